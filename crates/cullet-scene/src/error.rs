//! Why a scene cannot be loaded, in words that name the place and a way out.

use std::io;

/// Why a scene cannot be loaded.
///
/// `path` is the file as the user named it, or the URI inside it that led there.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// A file cannot be opened or read.
    #[error("{path}: cannot be read: {source}")]
    Read {
        /// The file.
        path: String,
        /// What the system says.
        source: io::Error,
    },
    /// A file was read but says something that cannot be.
    #[error("{path}: {}{problem}; {remedy}", at(place))]
    Invalid {
        /// The file.
        path: String,
        /// Node, mesh, accessor or line in it; empty for the file as a whole.
        place: String,
        /// What is wrong.
        problem: String,
        /// What the user can do.
        remedy: String,
    },
    /// The file cannot be drawn without an extension that Cullet lacks.
    #[error("{path}: requires {extension}, which is not supported; {remedy}")]
    Unsupported {
        /// The file.
        path: String,
        /// The registered name of the extension.
        extension: String,
        /// What the user can do.
        remedy: String,
    },
    /// The file asks for more than [`crate::LoadOptions`] allows.
    #[error("{path}: {what} exceeds the limit of {limit}; {option} raises it")]
    Limit {
        /// The file.
        path: String,
        /// What there is too much of, with the amount when it is known.
        what: String,
        /// The limit in force.
        limit: u64,
        /// The command line option that raises it.
        option: &'static str,
    },
}

/// The classes of [`LoadError`] that a caller may want to treat differently.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorKind {
    /// Unreadable or invalid.
    Input,
    /// Needs an extension that Cullet lacks.
    Unsupported,
    /// Over a limit of [`crate::LoadOptions`].
    Limit,
}

impl LoadError {
    /// The class of this error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            LoadError::Read { .. } | LoadError::Invalid { .. } => ErrorKind::Input,
            LoadError::Unsupported { .. } => ErrorKind::Unsupported,
            LoadError::Limit { .. } => ErrorKind::Limit,
        }
    }

    /// A [`LoadError::Invalid`]. An empty `place` means the file as a whole.
    pub fn invalid(
        path: impl Into<String>,
        place: impl Into<String>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> LoadError {
        LoadError::Invalid {
            path: path.into(),
            place: place.into(),
            problem: problem.into(),
            remedy: remedy.into(),
        }
    }
}

fn at(place: &str) -> String {
    if place.is_empty() { String::new() } else { format!("{place}: ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_file_place_and_remedy() {
        let error = LoadError::invalid("a.glb", "mesh `b`", "has no positions", "export it again");
        assert_eq!(error.to_string(), "a.glb: mesh `b`: has no positions; export it again");
        assert_eq!(error.kind(), ErrorKind::Input);
    }

    #[test]
    fn an_empty_place_leaves_no_trace() {
        let error = LoadError::invalid("a.glb", "", "is empty", "export it again");
        assert_eq!(error.to_string(), "a.glb: is empty; export it again");
    }
}
