//! The `cullet` command: glTF and OBJ to pictures, without a GPU.
//!
//! Results go to standard output or the named file, words for people to standard error.
//! Exit codes are in [`exit`]; every error of a run arrives here as one line.

mod camera_file;
mod cull;
mod diff;
mod exit;
mod info;
mod message;
mod numbers;
mod output;
mod picture_file;
mod render;
mod signals;
mod source;
mod stats;
mod synth;
mod view;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Draws glTF and OBJ scenes on the CPU.
#[derive(Parser, Debug)]
#[command(name = "cullet", version, about, after_help = EXIT_CODES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Debug)]
enum Command {
    Render(Box<render::RenderArgs>),
    Cull(Box<cull::CullArgs>),
    Info(info::InfoArgs),
    Diff(diff::DiffArgs),
    Synth(synth::SynthArgs),
    View(view::ViewArgs),
}

const EXIT_CODES: &str = "Exit codes: 0 done, 1 a comparison differs or a threshold failed, \
    2 wrong usage, 3 input unreadable or invalid, 4 the scene requires something unsupported, \
    5 a limit was reached, 6 output could not be written, 130 and 143 interrupted";

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            let _ = error.print();
            return ExitCode::from(error.exit_code() as u8);
        }
    };
    signals::listen();
    let done = match &cli.command {
        Command::Render(args) => render::run(args),
        Command::Cull(args) => cull::run(args),
        Command::Info(args) => info::run(args),
        Command::Diff(args) => diff::run(args),
        Command::Synth(args) => synth::run(args),
        Command::View(args) => view::run(args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            message::note(&failure.message);
            failure.exit.into()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
