//! `cullet-view`: the smallest useful window.
//!
//! Loads a scene, then hands the [`App`] to a window or to a script.

mod args;
mod replay;
mod window;

use std::fmt::Display;
use std::io::{Write, stderr, stdout};
use std::process::ExitCode;

use clap::Parser;
use cullet::scene::{ErrorKind, LoadError};
use cullet::{Prepared, Viewport};
use cullet_view::{App, picture_file};

/// Why the viewer ends early: an exit code (listed in `--help`) and the sentence that explains it.
#[derive(Debug)]
struct Failure {
    exit: u8,
    message: String,
}

const USAGE: u8 = 2;
const INPUT: u8 = 3;
const UNSUPPORTED: u8 = 4;
const LIMIT: u8 = 5;
const OUTPUT: u8 = 6;

impl Failure {
    fn new(exit: u8, message: impl Display) -> Failure {
        Failure { exit, message: message.to_string() }
    }
}

impl From<LoadError> for Failure {
    fn from(error: LoadError) -> Failure {
        let exit = match error.kind() {
            ErrorKind::Input => INPUT,
            ErrorKind::Unsupported => UNSUPPORTED,
            ErrorKind::Limit => LIMIT,
        };
        Failure::new(exit, error)
    }
}

fn main() -> ExitCode {
    let args = match args::Args::try_parse() {
        Ok(args) => args,
        Err(error) => {
            let _ = error.print();
            return ExitCode::from(error.exit_code() as u8);
        }
    };
    match run(&args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            note(&failure.message);
            ExitCode::from(failure.exit)
        }
    }
}

fn run(args: &args::Args) -> Result<(), Failure> {
    let (width, height) = args.size;
    let viewport = Viewport::new(width, height).map_err(|error| Failure::new(USAGE, error))?;
    let script = args.script.as_deref().map(replay::read).transpose()?;
    let scene = args.load()?;
    scene.warnings.iter().take(20).for_each(|warning| note(format_args!("warning: {warning}")));
    let prepared = Prepared::new(scene).map_err(|error| Failure::new(LIMIT, error))?;
    let camera = args.camera(prepared.scene())?;
    let app = App::new(prepared, camera.as_ref(), viewport);
    match script {
        Some(steps) => replay::run(app, &steps),
        None => window::run(app, &args.scene.display().to_string()),
    }
}

/// One line on standard error, whatever names from foreign files hold.
fn note(message: impl Display) {
    let line: String =
        message.to_string().chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    let _ = writeln!(stderr(), "cullet-view: {line}");
}

/// One line on standard output.
fn print(line: &str) {
    let _ = writeln!(stdout(), "{line}");
}

/// Draws the picture as it should be now and saves it in the current folder; says where.
fn screenshot(app: &mut App) -> Result<String, String> {
    app.draw(false);
    let (width, height) = app.size();
    let saved = picture_file::png(app.pixels(), width, height)
        .and_then(|file| picture_file::write_numbered(".".as_ref(), &file));
    match saved {
        Ok(path) => Ok(format!("saved {}", path.file_name().unwrap_or_default().display())),
        Err(error) => Err(format!("the screenshot cannot be saved: {error}")),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        super::args::Args::command().debug_assert();
    }
}
