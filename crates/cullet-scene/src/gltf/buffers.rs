//! Where are the bytes of each buffer?

use std::borrow::Cow;

use super::document::Document;
use super::extensions;
use crate::LoadError;
use crate::files::Root;

/// Reads every buffer that a buffer view refers to. A buffer may have fewer bytes than it
/// claims; accessors are checked against what is there.
pub(super) fn read<'a>(
    document: &Document<'a>,
    name: &str,
    files: &Root,
) -> Result<Vec<Cow<'a, [u8]>>, LoadError> {
    let mut wanted = vec![false; document.root.buffers.len()];
    for view in &document.root.buffer_views {
        wanted[view.buffer.value()] = true;
    }
    let mut buffers = Vec::with_capacity(wanted.len());
    for (i, buffer) in document.root.buffers.iter().enumerate() {
        buffers.push(match (&buffer.uri, document.blob) {
            _ if !wanted[i] => Cow::Borrowed(&[][..]),
            (Some(uri), _) => Cow::Owned(files.read(uri).map_err(|error| within(name, i, error))?),
            (None, Some(blob)) if i == 0 => Cow::Borrowed(blob),
            (None, _) => match fallback_of(buffer) {
                Some(extension) => return Err(extensions::unsupported(name, extension)),
                None => Cow::Borrowed(&[][..]),
            },
        });
    }
    Ok(buffers)
}

/// The compression that a buffer without bytes stands in for.
fn fallback_of(buffer: &::gltf::json::Buffer) -> Option<&'static str> {
    let extensions = buffer.extensions.as_ref()?;
    ["EXT_meshopt_compression", "KHR_meshopt_compression"]
        .into_iter()
        .find(|extension| extensions.others.contains_key(*extension))
}

/// A missing buffer is the fault of the scene, so both files are named.
fn within(name: &str, buffer: usize, error: LoadError) -> LoadError {
    let place = format!("buffer {buffer}");
    match error {
        LoadError::Read { path, source } => {
            let problem = format!("{path} cannot be read: {source}");
            LoadError::invalid(name, place, problem, "put the file beside the scene")
        }
        LoadError::Invalid { path, problem, remedy, .. } => {
            LoadError::invalid(name, place, format!("{path} {problem}"), remedy)
        }
        other => other,
    }
}
