//! Which loader reads this file?

use std::path::Path;

use crate::files::Root;
use crate::tasks::{Run, in_turn};
use crate::{LoadError, LoadOptions, Scene, gltf, obj};

/// Loads a scene from a `.glb`, `.gltf` or `.obj` file. Other names go by their content.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Scene, LoadError> {
    load_with(path, options, &in_turn)
}

/// Like [`load`], with work that can be done side by side given to `run`. The scene, its
/// warnings and errors are the same.
pub fn load_with(path: &Path, options: &LoadOptions, run: Run<'_>) -> Result<Scene, LoadError> {
    let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or("");
    if extension.eq_ignore_ascii_case("obj") {
        return obj::load(path, options, run);
    }
    let root = Root::beside(path, options);
    let bytes = root.read_scene(path)?;
    let shown = path.display().to_string();
    let named_gltf = ["glb", "gltf"].iter().any(|known| extension.eq_ignore_ascii_case(known));
    if named_gltf || looks_like_gltf(&bytes) {
        return gltf::load(&bytes, &shown, &root, options, run);
    }
    Err(LoadError::invalid(shown, "", "is no scene", "give a .glb, .gltf or .obj file"))
}

/// Loads a glTF scene from memory, say from standard input; `name` is for messages.
/// There is no folder to read further files from.
pub fn load_glb_bytes(
    bytes: Vec<u8>,
    name: &str,
    options: &LoadOptions,
) -> Result<Scene, LoadError> {
    load_glb_bytes_with(bytes, name, options, &in_turn)
}

/// Like [`load_glb_bytes`], with work that can be done side by side given to `run`.
pub fn load_glb_bytes_with(
    bytes: Vec<u8>,
    name: &str,
    options: &LoadOptions,
    run: Run<'_>,
) -> Result<Scene, LoadError> {
    let root = Root::nowhere(options);
    root.count_bytes(name, bytes.len() as u64)?;
    gltf::load(&bytes, name, &root, options, run)
}

fn looks_like_gltf(bytes: &[u8]) -> bool {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    bytes.starts_with(b"glTF") || text.trim_ascii_start().starts_with(b"{")
}
