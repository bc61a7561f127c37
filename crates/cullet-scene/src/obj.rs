//! Wavefront OBJ (not yet).

use std::path::Path;

use crate::{LoadError, LoadOptions, Scene};

/// Loads an OBJ file.
pub fn load(path: &Path, _options: &LoadOptions) -> Result<Scene, LoadError> {
    Err(LoadError::invalid(path.display().to_string(), "", "OBJ is not read yet", "use glTF"))
}
