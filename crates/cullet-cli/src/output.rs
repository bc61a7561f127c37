//! Outputs that appear whole or not at all.
//!
//! Each regular file is written to `.NAME.cullet-tmp` in its own folder; when every output
//! of the run is complete, all are renamed. Temporary files are made before the work
//! starts, so a folder that cannot be written to is noticed first. Devices and pipes are
//! written directly, symbolic links are followed. Signals remove what is unfinished.

use std::fmt;
use std::fs::{self, File, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::exit::Failure;

/// Where an output goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Target {
    /// `-`: standard output.
    Stdout,
    /// A path.
    File(PathBuf),
}

impl From<&Path> for Target {
    fn from(path: &Path) -> Target {
        let stdout = ["-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"];
        if stdout.iter().any(|name| path == Path::new(name)) {
            Target::Stdout
        } else {
            Target::File(path.to_owned())
        }
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Target::Stdout => f.write_str("standard output"),
            Target::File(path) => path.display().fmt(f),
        }
    }
}

/// Whether `path` exists and is neither a regular file nor a folder.
pub fn is_device(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir())
}

/// Refuses outputs that would replace one of the `inputs`, however the path is spelled.
pub fn spare_inputs(targets: &[Target], inputs: &[&Path]) -> Result<(), Failure> {
    let inputs: Vec<PathBuf> = inputs.iter().filter_map(|path| path.canonicalize().ok()).collect();
    let is_input = |target: &&Target| {
        let Target::File(path) = target else { return false };
        path.canonicalize().is_ok_and(|path| inputs.contains(&path))
    };
    match targets.iter().find(is_input) {
        Some(target) => {
            Err(Failure::usage(format!("{target} is an input; give the output another name")))
        }
        None => Ok(()),
    }
}

/// The outputs of one run, in the order given. Dropped without [`Outputs::commit`], it
/// leaves no trace of regular files.
#[derive(Debug)]
pub struct Outputs(Vec<Output>);

#[derive(Debug)]
struct Output {
    target: Target,
    sink: Sink,
}

#[derive(Debug)]
enum Sink {
    Stdout,
    /// Exists and is not a regular file; opened at the first write.
    Device(PathBuf, Option<File>),
    Regular {
        path: PathBuf,
        temporary: PathBuf,
        file: File,
    },
}

impl Outputs {
    /// Checks and claims every target.
    pub fn open(targets: &[Target]) -> Result<Outputs, Failure> {
        if targets.iter().filter(|target| **target == Target::Stdout).count() > 1 {
            return Err(Failure::usage("two outputs go to standard output; name files for them"));
        }
        let mut outputs = Outputs(Vec::new());
        for target in targets {
            let sink = Sink::open(target, &outputs.0)?;
            outputs.0.push(Output { target: target.clone(), sink });
        }
        Ok(outputs)
    }

    /// Writes to output `index`, after what was written to it before.
    pub fn write(&mut self, index: usize, bytes: &[u8]) -> Result<(), Failure> {
        let Output { target, sink } = &mut self.0[index];
        let written = match sink {
            Sink::Stdout => return print(bytes),
            Sink::Device(path, file) => match file {
                Some(file) => file.write_all(bytes),
                None => File::options()
                    .write(true)
                    .open(path)
                    .and_then(|opened| file.insert(opened).write_all(bytes)),
            },
            Sink::Regular { file, .. } => file.write_all(bytes),
        };
        written.map_err(|error| cannot_write(target, &error))
    }

    /// Renames everything to its final name.
    pub fn commit(self) -> Result<(), Failure> {
        // A signal waits until all names are right.
        let mut live = live();
        for Output { target, sink } in &self.0 {
            if let Sink::Regular { path, temporary, .. } = sink {
                fs::rename(temporary, path).map_err(|error| cannot_write(target, &error))?;
                live.retain(|name| name != temporary);
            }
        }
        Ok(())
    }
}

impl Drop for Outputs {
    fn drop(&mut self) {
        let mut live = live();
        for Output { sink, .. } in &self.0 {
            if let Sink::Regular { temporary, .. } = sink
                && let Some(i) = live.iter().position(|name| name == temporary)
            {
                let _ = fs::remove_file(live.swap_remove(i));
            }
        }
    }
}

impl Sink {
    fn open(target: &Target, others: &[Output]) -> Result<Sink, Failure> {
        let Target::File(path) = target else { return Ok(Sink::Stdout) };
        let path = follow(path).map_err(|error| cannot_write(target, &error))?;
        let mode = match fs::metadata(&path) {
            Ok(found) if found.is_dir() => {
                return Err(Failure::output(format!("{target}: is a folder; name a file")));
            }
            Ok(found) if !found.is_file() => return Ok(Sink::Device(path, None)),
            Ok(found) if found.permissions().readonly() => {
                return Err(Failure::output(format!("{target}: is read-only")));
            }
            Ok(found) => Some(found.permissions()),
            Err(_) => None, // it is not there yet, or making the temporary file will tell
        };
        let taken =
            |other: &Output| matches!(&other.sink, Sink::Regular { path: p, .. } if *p == path);
        if let Some(other) = others.iter().find(|other| taken(other)) {
            let other = &other.target;
            return Err(Failure::usage(format!("{target} and {other} are the same file")));
        }
        let temporary = temporary_name(&path)
            .ok_or_else(|| Failure::output(format!("{target}: does not name a file")))?;
        let file = claim(&temporary).map_err(|error| cannot_write(target, &error))?;
        if let Some(mode) = mode {
            let _ = file.set_permissions(mode); // like the file it replaces, where that is allowed
        }
        Ok(Sink::Regular { path, temporary, file })
    }
}

/// Writes to standard output. Nobody listening is no error: the reader has had enough.
pub fn print(bytes: &[u8]) -> Result<(), Failure> {
    printed(io::stdout().lock().write_all(bytes))
}

/// Ends a write to standard output: `print` for what others wrote.
pub fn printed(written: io::Result<()>) -> Result<(), Failure> {
    match written.and_then(|()| io::stdout().flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(cannot_write(&Target::Stdout, &error))
        }
        _ => Ok(()),
    }
}

/// Removes every unfinished file. The list stays locked: nothing is written after this.
pub fn abandon() -> impl Sized {
    let live = live();
    for temporary in live.iter() {
        let _ = fs::remove_file(temporary);
    }
    live
}

/// The temporary files of this process.
static LIVE: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn live() -> MutexGuard<'static, Vec<PathBuf>> {
    LIVE.lock().unwrap_or_else(PoisonError::into_inner)
}

fn cannot_write(target: &Target, error: &io::Error) -> Failure {
    if let Target::File(path) = target
        && let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty())
        && error.kind() == io::ErrorKind::NotFound
        && fs::symlink_metadata(folder).is_err()
    {
        let folder = folder.display();
        return Failure::output(format!(
            "{target}: cannot be written: there is no folder `{folder}`; make it first"
        ));
    }
    Failure::output(format!("{target}: cannot be written: {error}"))
}

/// The path behind symbolic links, also behind one that leads nowhere yet, with a resolved
/// folder, so that two spellings of one file are equal.
fn follow(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_owned();
    for _ in 0..40 {
        let Ok(link) = fs::read_link(&path) else {
            let folder = match path.parent() {
                Some(folder) if !folder.as_os_str().is_empty() => folder,
                _ => Path::new("."),
            };
            let folder = folder.canonicalize()?;
            return Ok(path.file_name().map_or(path.clone(), |name| folder.join(name)));
        };
        path = path.parent().unwrap_or(Path::new("")).join(link);
    }
    Err(io::Error::other("too many symbolic links"))
}

fn temporary_name(path: &Path) -> Option<PathBuf> {
    let mut name = std::ffi::OsString::from(".");
    name.push(path.file_name()?);
    name.push(".cullet-tmp");
    Some(path.with_file_name(name))
}

/// Makes the temporary file, in place of one that a killed run left behind.
fn claim(temporary: &Path) -> io::Result<File> {
    let mut live = live();
    if fs::symlink_metadata(temporary).is_ok_and(|found| found.is_file()) {
        let lock = File::open(temporary).map(|stale| stale.try_lock());
        if let Ok(Err(TryLockError::WouldBlock)) = lock {
            return Err(io::Error::other("another run is writing it"));
        }
    }
    match fs::remove_file(temporary) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    let file = File::options().write(true).create_new(true).open(temporary)?;
    live.push(temporary.to_owned());
    let _ = file.try_lock(); // where the file system has no locks, live without
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exit::Exit;

    fn target(path: &Path) -> Target {
        Target::from(path)
    }

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let name = |entry: io::Result<fs::DirEntry>| entry.unwrap().file_name();
        let mut names: Vec<_> =
            entries.map(|entry| name(entry).to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    #[test]
    fn files_appear_together_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let targets = ["a", "b"].map(|name| target(&folder.path().join(name)));
        let mut outputs = Outputs::open(&targets).unwrap();
        assert_eq!(names(folder.path()), [".a.cullet-tmp", ".b.cullet-tmp"]);
        outputs.write(0, b"one").unwrap();
        drop(outputs);
        assert!(names(folder.path()).is_empty());
        let mut outputs = Outputs::open(&targets).unwrap();
        outputs.write(0, b"one").unwrap();
        outputs.write(1, b"two").unwrap();
        outputs.commit().unwrap();
        assert_eq!(names(folder.path()), ["a", "b"]);
        assert_eq!(fs::read(folder.path().join("b")).unwrap(), b"two");
    }

    #[test]
    fn stale_files_are_replaced_and_live_ones_respected() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        fs::write(folder.path().join(".a.cullet-tmp"), "left behind").unwrap();
        let first = Outputs::open(&[target(&path)]).unwrap();
        let second = Outputs::open(&[target(&path)]).unwrap_err();
        assert_eq!(second.exit, Exit::Output);
        first.commit().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"");
    }

    #[test]
    fn one_place_takes_one_output() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let same = folder.path().join(".").join("a");
        let twice = Outputs::open(&[target(&path), target(&same)]).unwrap_err();
        assert_eq!(twice.exit, Exit::Usage);
        let stdout = Outputs::open(&[target(Path::new("-")), Target::Stdout]).unwrap_err();
        assert_eq!(stdout.exit, Exit::Usage);
        assert!(names(folder.path()).is_empty());
    }

    #[test]
    fn folders_and_missing_folders_are_output_errors() {
        let folder = tempfile::tempdir().unwrap();
        for path in [folder.path().to_owned(), folder.path().join("none/a"), "/".into()] {
            assert_eq!(Outputs::open(&[target(&path)]).unwrap_err().exit, Exit::Output);
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed() {
        let folder = tempfile::tempdir().unwrap();
        let (link, file) = (folder.path().join("link"), folder.path().join("file"));
        std::os::unix::fs::symlink("file", &link).unwrap();
        for text in ["new", "old"] {
            let mut outputs = Outputs::open(&[target(&link)]).unwrap();
            outputs.write(0, text.as_bytes()).unwrap();
            outputs.commit().unwrap();
            assert_eq!(fs::read_to_string(&file).unwrap(), text);
            assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        }
        std::os::unix::fs::symlink("loop", folder.path().join("loop")).unwrap();
        assert!(Outputs::open(&[target(&folder.path().join("loop"))]).is_err());
    }
}
