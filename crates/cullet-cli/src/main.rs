//! The `cullet` command: glTF and OBJ to pictures, without a GPU.
//!
//! Results go to standard output or the named file, words for people to standard error.
//! Exit codes are in [`exit`]; every error of a run arrives here as one line.

#![recursion_limit = "256"] // of `json!`, one step per entry

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
mod tradeoff;
mod verify;
mod view;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Draw glTF and OBJ scenes without a GPU, measure what it takes, and compare the pictures
#[derive(Parser, Debug)]
#[command(name = "cullet", version, after_help = EXIT_CODES)]
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
    Tradeoff(Box<tradeoff::TradeoffArgs>),
    Verify(verify::VerifyArgs),
    View(view::ViewArgs),
}

const EXIT_CODES: &str = "Exit codes: 0 done, 1 a comparison differs or a threshold failed, \
    2 wrong usage, 3 input unreadable or invalid, 4 the scene requires something unsupported, \
    5 a limit was reached, 6 output could not be written, 129, 130 and 143 interrupted";

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) if error.use_stderr() => {
            let _ = error.print();
            return ExitCode::from(error.exit_code() as u8);
        }
        Err(help) => return end(output::printed(help.print())),
    };
    signals::listen();
    end(match &cli.command {
        Command::Render(args) => render::run(args),
        Command::Cull(args) => cull::run(args),
        Command::Info(args) => info::run(args),
        Command::Diff(args) => diff::run(args),
        Command::Synth(args) => synth::run(args),
        Command::Tradeoff(args) => tradeoff::run(args),
        Command::Verify(args) => verify::run(args),
        Command::View(args) => view::run(args),
    })
}

/// Says what went wrong, if anything did.
fn end(done: Result<(), exit::Failure>) -> ExitCode {
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
