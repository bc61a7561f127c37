//! How a run ends: the exit codes of the command, and an error that carries one.

use std::fmt;
use std::process::ExitCode;

use cullet::scene::{ErrorKind, LoadError};
use cullet::{LightError, PrepareError, ViewportError};

/// Why a run ends early. The numbers are a promise to scripts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// A comparison differs, or a threshold failed.
    Differs = 1,
    /// The command line asks for something that cannot be.
    Usage = 2,
    /// An input is unreadable or invalid.
    Input = 3,
    /// The scene requires something unsupported.
    Unsupported = 4,
    /// A limit was reached.
    Limit = 5,
    /// An output could not be written.
    Output = 6,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> ExitCode {
        ExitCode::from(exit as u8)
    }
}

/// An exit code with the sentence that explains it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// The code.
    pub exit: Exit,
    /// What went wrong, where, and what to do about it.
    pub message: String,
}

impl Failure {
    /// A comparison differs, or a threshold failed.
    pub fn differs(message: impl fmt::Display) -> Failure {
        Failure { exit: Exit::Differs, message: message.to_string() }
    }

    /// Wrong usage.
    pub fn usage(message: impl fmt::Display) -> Failure {
        Failure { exit: Exit::Usage, message: message.to_string() }
    }

    /// An unreadable or invalid input.
    pub fn input(message: impl fmt::Display) -> Failure {
        Failure { exit: Exit::Input, message: message.to_string() }
    }

    /// A limit was reached.
    pub fn limit(message: impl fmt::Display) -> Failure {
        Failure { exit: Exit::Limit, message: message.to_string() }
    }

    /// An output cannot be written.
    pub fn output(message: impl fmt::Display) -> Failure {
        Failure { exit: Exit::Output, message: message.to_string() }
    }
}

impl From<LoadError> for Failure {
    fn from(error: LoadError) -> Failure {
        let exit = match error.kind() {
            ErrorKind::Input => Exit::Input,
            ErrorKind::Unsupported => Exit::Unsupported,
            ErrorKind::Limit => Exit::Limit,
        };
        Failure { exit, message: error.to_string() }
    }
}

impl From<PrepareError> for Failure {
    fn from(error: PrepareError) -> Failure {
        match error {
            PrepareError::TooManyTriangles { .. } => Failure::limit(error),
            PrepareError::NoPixels { .. } => Failure::input(error),
        }
    }
}

impl From<ViewportError> for Failure {
    fn from(error: ViewportError) -> Failure {
        match error {
            ViewportError::Empty(..) => Failure::usage(error),
            ViewportError::TooLarge(..) => {
                Failure::limit(format!("{error}; no option raises this limit"))
            }
        }
    }
}

impl From<LightError> for Failure {
    fn from(error: LightError) -> Failure {
        Failure::usage(error)
    }
}
