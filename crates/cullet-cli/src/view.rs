//! `cullet view`: starts the viewer, a program of its own, so that this one needs no window.

use std::env::{self, consts::EXE_SUFFIX};
use std::ffi::OsString;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::process::Command;

use clap::Args;

use crate::exit::{Exit, Failure};

/// Show a scene in a window (starts `cullet-view`; `cullet view --help` is its help).
#[derive(Args, Clone, Debug)]
#[command(disable_help_flag = true)]
pub struct ViewArgs {
    /// A scene, and options of the viewer
    #[arg(value_name = "SCENE", trailing_var_arg = true, allow_hyphen_values = true)]
    args: Vec<OsString>,
}

/// Becomes the viewer, or waits for it where that is impossible.
pub fn run(args: &ViewArgs) -> Result<(), Failure> {
    let own = env::current_exe().ok();
    let program = beside(own.as_deref()).unwrap_or_else(|| name().into());
    let error = become_or_wait(Command::new(&program).args(&args.args));
    let message = match error.kind() {
        ErrorKind::NotFound => "the viewer is a program of its own, found neither beside this one \
            nor on PATH; `cargo install --path crates/cullet-view` installs it"
            .into(),
        _ => format!("{} cannot be started: {error}", program.display()),
    };
    Err(Failure { exit: Exit::Unsupported, message })
}

fn name() -> String {
    format!("cullet-view{EXE_SUFFIX}")
}

/// The viewer in the folder of the program `own`, if it is there.
fn beside(own: Option<&Path>) -> Option<PathBuf> {
    let viewer = own?.with_file_name(name());
    viewer.is_file().then_some(viewer)
}

/// Returns only if the program cannot be started.
#[cfg(unix)]
fn become_or_wait(command: &mut Command) -> io::Error {
    std::os::unix::process::CommandExt::exec(command)
}

/// Returns only if the program cannot be started.
#[cfg(not(unix))]
fn become_or_wait(command: &mut Command) -> io::Error {
    match command.status() {
        Ok(status) => std::process::exit(status.code().unwrap_or(1)),
        Err(error) => error,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_viewer_beside_the_program_comes_first() {
        let folder = tempfile::tempdir().unwrap();
        let own = folder.path().join("cullet");
        assert_eq!(beside(Some(&own)), None);
        assert_eq!(beside(None), None);
        let viewer = folder.path().join(name());
        std::fs::write(&viewer, "").unwrap();
        assert_eq!(beside(Some(&own)), Some(viewer));
    }
}
