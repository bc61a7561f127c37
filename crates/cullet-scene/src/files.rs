//! May this scene read that file? Every file that a scene names passes here.
//!
//! A scene is somebody else's text, so what it names is confined: files below the scene's
//! own folder only (also after following links), regular files only, and no more bytes
//! in total than [`LoadOptions::max_file_bytes`]. Data URIs are decoded here too.

use std::borrow::Cow;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use base64::Engine;
use base64::alphabet;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;

use crate::{LoadError, LoadOptions};

/// The folder of a scene, through which all its files are read.
#[derive(Debug)]
pub struct Root {
    /// `None` for a scene that came without a folder (standard input).
    folder: Option<PathBuf>,
    limit: u64,
    /// Files are read by one thread; atomic only so that others may hold the folder.
    used: AtomicU64,
}

impl Root {
    /// The folder that `scene` lies in.
    pub fn beside(scene: &Path, options: &LoadOptions) -> Root {
        let folder = scene.parent().map(Path::to_path_buf).unwrap_or_default();
        let folder = if folder.as_os_str().is_empty() { PathBuf::from(".") } else { folder };
        Root { folder: Some(folder), limit: options.max_file_bytes, used: AtomicU64::new(0) }
    }

    /// No folder: only data URIs can be read.
    pub fn nowhere(options: &LoadOptions) -> Root {
        Root { folder: None, limit: options.max_file_bytes, used: AtomicU64::new(0) }
    }

    /// Reads the scene file itself, wherever the user says it is.
    pub fn read_scene(&self, scene: &Path) -> Result<Vec<u8>, LoadError> {
        let shown = scene.display().to_string();
        self.read_regular(scene)
            .map_err(|error| error.into_load_error(&shown, "check the path of the scene"))
    }

    /// Reads what a URI of a glTF file refers to: a data URI, or a file below the folder.
    ///
    /// Names that exist as written but not percent-decoded are found too, as are names
    /// with backslashes for slashes: exporters write both.
    pub fn read(&self, uri: &str) -> Result<Vec<u8>, LoadError> {
        if let Some(data) = strip_prefix_ignore_case(uri, "data:") {
            return decode_data_uri(data);
        }
        if strip_prefix_ignore_case(uri, "file:").is_some() || uri.contains("://") {
            return Err(FileError::Outside.into_load_error(uri, OUTSIDE_REMEDY));
        }
        let decoded = percent_decode_str(uri).decode_utf8().unwrap_or(Cow::Borrowed(uri));
        let slashed = decoded.replace('\\', "/");
        self.read_first_of(&[&decoded, uri, &slashed])
    }

    /// Reads a file named by a plain path, as OBJ and MTL files do: backslashes count as
    /// slashes, nothing is percent-decoded.
    pub fn read_path(&self, path: &str) -> Result<Vec<u8>, LoadError> {
        self.read_first_of(&[&path.replace('\\', "/"), path])
    }

    /// Counts bytes that did not come from a file here against the limit of the scene.
    pub fn count_bytes(&self, shown: &str, n_bytes: u64) -> Result<(), LoadError> {
        let used = self.used().saturating_add(n_bytes);
        if used > self.limit {
            return Err(FileError::TooBig { limit: self.limit }.into_load_error(shown, ""));
        }
        self.set_used(used);
        Ok(())
    }

    /// Bytes read so far.
    pub fn used(&self) -> u64 {
        self.used.load(Ordering::Relaxed)
    }

    /// Lets `used` bytes count as read: those of files that turned out not to be needed do not.
    pub fn set_used(&self, used: u64) {
        self.used.store(used, Ordering::Relaxed);
    }

    fn read_first_of(&self, names: &[&str]) -> Result<Vec<u8>, LoadError> {
        let not_found = |result: &Result<_, FileError>| matches!(result, Err(FileError::Io(error)) if error.kind() == io::ErrorKind::NotFound);
        let mut result = self.read_below(names[0]);
        for name in &names[1..] {
            if not_found(&result) {
                result = self.read_below(name);
            }
        }
        result.map_err(|error| error.into_load_error(names[0], OUTSIDE_REMEDY))
    }

    fn read_below(&self, name: &str) -> Result<Vec<u8>, FileError> {
        let relative = Path::new(name);
        let plain = |part| matches!(part, Component::Normal(_) | Component::CurDir);
        if name.is_empty() || !relative.components().all(plain) {
            return Err(FileError::Outside);
        }
        let folder = self.folder.as_ref().ok_or(FileError::NoFolder)?.canonicalize()?;
        let file = folder.join(relative).canonicalize()?;
        if !file.starts_with(&folder) {
            return Err(FileError::Outside);
        }
        self.read_regular(&file)
    }

    fn read_regular(&self, file: &Path) -> Result<Vec<u8>, FileError> {
        // Asked before opening, because opening a pipe waits for its other end.
        let metadata = fs::metadata(file)?;
        if !metadata.is_file() {
            return Err(FileError::NotRegular);
        }
        let left = self.limit - self.used();
        let too_big = FileError::TooBig { limit: self.limit };
        if metadata.len() > left {
            return Err(too_big);
        }
        let mut bytes = Vec::with_capacity(metadata.len() as usize);
        File::open(file)?.take(left.saturating_add(1)).read_to_end(&mut bytes)?;
        if bytes.len() as u64 > left {
            return Err(too_big);
        }
        self.set_used(self.used() + bytes.len() as u64);
        if bytes.starts_with(LFS_POINTER) {
            return Err(FileError::LfsPointer);
        }
        Ok(bytes)
    }
}

/// How the text begins that Git LFS leaves in place of a large file.
///
/// Source: git-lfs, docs/spec.md, "The Pointer".
const LFS_POINTER: &[u8] = b"version https://git-lfs.github.com/spec/";

const OUTSIDE_REMEDY: &str = "put the file into the folder of the scene and name it relatively";

#[derive(Debug, thiserror::Error)]
enum FileError {
    #[error(transparent)]
    Io(#[from] io::Error),
    #[error("leads out of the folder of the scene")]
    Outside,
    #[error("is named by a scene that has no folder")]
    NoFolder,
    #[error("is not a regular file")]
    NotRegular,
    #[error("is only a Git LFS pointer to the file")]
    LfsPointer,
    #[error("too big")]
    TooBig { limit: u64 },
}

impl FileError {
    fn into_load_error(self, shown: &str, remedy: &str) -> LoadError {
        let problem = self.to_string();
        match self {
            FileError::Io(source) => LoadError::Read { path: shown.into(), source },
            FileError::TooBig { limit } => LoadError::Limit {
                path: shown.into(),
                what: "the size of the scene's files in bytes".into(),
                limit,
                option: "--max-file-bytes",
            },
            FileError::NoFolder => {
                LoadError::invalid(shown, "", problem, "give the scene as a file, or pack a .glb")
            }
            FileError::LfsPointer => {
                LoadError::invalid(shown, "", problem, "fetch it with `git lfs pull`")
            }
            FileError::NotRegular => LoadError::invalid(shown, "", problem, "name a regular file"),
            FileError::Outside => LoadError::invalid(shown, "", problem, remedy),
        }
    }
}

/// Decodes what follows `data:`. Newlines and blanks inside base64 are skipped, padding
/// is optional, and the URL-safe alphabet is understood as well.
fn decode_data_uri(data: &str) -> Result<Vec<u8>, LoadError> {
    let invalid =
        |problem: String| LoadError::invalid("data URI", "", problem, "export the file again");
    let Some((kind, payload)) = data.split_once(',') else {
        return Err(invalid("has no comma".into()));
    };
    let bytes: Vec<u8> = percent_decode_str(payload).collect();
    if !kind.trim_end().to_ascii_lowercase().ends_with(";base64") {
        return Ok(bytes);
    }
    let symbols: Vec<u8> = bytes
        .into_iter()
        .filter(|byte| !byte.is_ascii_whitespace())
        .map(|byte| match byte {
            b'-' => b'+',
            b'_' => b'/',
            other => other,
        })
        .collect();
    let lenient = GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true);
    GeneralPurpose::new(&alphabet::STANDARD, lenient)
        .decode(symbols)
        .map_err(|error| invalid(format!("is not base64: {error}")))
}

fn strip_prefix_ignore_case<'a>(text: &'a str, prefix: &str) -> Option<&'a str> {
    let (head, tail) = text.split_at_checked(prefix.len())?;
    head.eq_ignore_ascii_case(prefix).then_some(tail)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ErrorKind;

    fn folder() -> (tempfile::TempDir, Root) {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("scene")).unwrap();
        fs::write(folder.path().join("secret"), "secret").unwrap();
        for name in ["a b.bin", "100%.bin", "a:b.bin"] {
            fs::write(folder.path().join("scene").join(name), name).unwrap();
        }
        fs::create_dir(folder.path().join("scene/tex")).unwrap();
        fs::write(folder.path().join("scene/tex/c.png"), "c").unwrap();
        let root = Root::beside(&folder.path().join("scene/x.gltf"), &LoadOptions::default());
        (folder, root)
    }

    #[test]
    fn git_lfs_pointers_are_told_from_files() {
        let (folder, root) = folder();
        let pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n";
        let path = folder.path().join("scene/x.gltf");
        fs::write(&path, pointer).unwrap();
        for result in [root.read_scene(&path), root.read("x.gltf")] {
            let error = result.unwrap_err().to_string();
            assert!(error.ends_with("Git LFS pointer to the file; fetch it with `git lfs pull`"));
        }
    }

    #[test]
    fn names_are_found_encoded_plain_and_with_backslashes() {
        let (_folder, root) = folder();
        let cases = [("a%20b.bin", "a b.bin"), ("a b.bin", "a b.bin"), ("100%.bin", "100%.bin")];
        for (uri, expected) in cases {
            assert_eq!(root.read(uri).unwrap(), expected.as_bytes(), "{uri}");
        }
        assert_eq!(root.read("./tex/c.png").unwrap(), b"c");
        assert_eq!(root.read("tex\\c.png").unwrap(), b"c");
        assert_eq!(root.read_path("tex\\c.png").unwrap(), b"c");
    }

    #[test]
    fn nothing_outside_the_folder_is_read() {
        let (folder, root) = folder();
        let absolute = folder.path().join("secret").display().to_string();
        for uri in ["../secret", "%2e%2e/secret", "tex/../../secret", "..\\secret", &absolute] {
            assert!(root.read(uri).is_err(), "{uri}");
            assert!(root.read_path(uri).is_err(), "{uri}");
        }
        assert!(root.read(&format!("file://{absolute}")).is_err());
        assert!(root.read("https://example.org/a.bin").is_err());
        assert!(root.read("").is_err());
        assert!(root.read("tex").is_err());
        assert!(root.read("%ff.bin").is_err());
    }

    #[cfg(unix)]
    #[test]
    fn links_that_lead_outside_are_refused() {
        let (folder, root) = folder();
        let link = folder.path().join("scene/link");
        std::os::unix::fs::symlink(folder.path().join("secret"), link).unwrap();
        assert!(root.read("link").is_err());
    }

    #[test]
    fn bytes_are_counted_over_all_files() {
        let (folder, _) = folder();
        let options = LoadOptions { max_file_bytes: 10, ..LoadOptions::default() };
        let root = Root::beside(&folder.path().join("scene/x.gltf"), &options);
        assert_eq!(root.read("a b.bin").unwrap().len(), 7);
        let error = root.read("a b.bin").unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Limit);
        assert!(error.to_string().contains("--max-file-bytes"), "{error}");
    }

    #[test]
    fn data_uris_of_every_form_are_decoded() {
        let root = Root::nowhere(&LoadOptions::default());
        let cases = [
            "data:application/octet-stream;base64,AAH/",
            "DATA:;BASE64,AAH_",
            "data:;base64,AA\nH/",
            "data:application/gltf-buffer;charset=utf-8;base64,AAH%2F",
            "data:,%00%01%ff",
        ];
        for uri in cases {
            assert_eq!(root.read(uri).unwrap(), [0, 1, 255], "{uri}");
        }
        assert_eq!(root.read("data:;base64,AA").unwrap(), [0]);
        assert!(root.read("data:;base64").is_err());
        assert!(root.read("data:;base64,AA!=").is_err());
        assert!(root.read("a.bin").unwrap_err().to_string().contains("no folder"));
    }
}
