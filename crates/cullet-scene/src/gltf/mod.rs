//! glTF 2.0: from bytes to a [`Scene`].

use crate::files::Root;
use crate::{LoadError, LoadOptions, Scene};

/// Loads a glTF scene, binary or text.
pub(crate) fn load(
    _bytes: &[u8],
    name: &str,
    _root: &Root,
    _options: &LoadOptions,
) -> Result<Scene, LoadError> {
    Err(LoadError::invalid(name, "", "glTF is not read yet", "wait"))
}
