//! `cullet synth`: computed scenes as .glb files.

use std::io::{IsTerminal, stdout};
use std::path::PathBuf;

use clap::Args;
use cullet::scene::synth::{EXTREMES, NAMES, synth};
use cullet::scene::write_glb;

use crate::exit::Failure;
use crate::output::{Outputs, Target, is_device, print};

/// Write a computed scene as a .glb file.
#[derive(Args, Clone, Debug)]
pub struct SynthArgs {
    /// Which scene: NAME or NAME:PARAMETER; of an extreme, extreme:NAME:ordinary is the twin by ordinary
    /// numbers
    #[arg(value_name = "NAME", required_unless_present = "list")]
    name: Option<String>,
    /// The .glb file; `-` is standard output
    #[arg(short, long, value_name = "OUT.glb", default_value = "-")]
    output: PathBuf,
    /// Name every scene with its parameter and stop
    #[arg(long, conflicts_with = "name")]
    list: bool,
}

/// Writes the scene, or the list.
pub fn run(args: &SynthArgs) -> Result<(), Failure> {
    let Some(name) = &args.name else {
        let names = NAMES.iter().map(|(name, about)| line(name, about));
        let extremes = EXTREMES.map(|(name, about)| format!("extreme:{name:<16} {about}\n"));
        let twins = [TWINS.to_owned()];
        return print(names.chain(extremes).chain(twins).collect::<String>().as_bytes());
    };
    let scene = synth(name.strip_prefix("synth:").unwrap_or(name)).map_err(Failure::usage)?;
    let target = Target::from(args.output.as_path());
    if target == Target::Stdout && stdout().is_terminal() {
        return Err(Failure::usage("a .glb file is nothing for a terminal; name a file with -o"));
    }
    if let Target::File(path) = &target
        && path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("glb"))
        && !is_device(path)
    {
        return Err(Failure::usage(format!("{target}: only .glb files are written")));
    }
    let mut outputs = Outputs::open(&[target])?;
    let file = write_glb(&scene).map_err(Failure::output)?;
    outputs.write(0, &file)?;
    outputs.commit()
}

/// How to ask for what an extreme is compared with.
const TWINS: &str = "extreme:NAME:ordinary    the twin of each extreme, by ordinary numbers\n";

fn line(name: &str, about: &str) -> String {
    // Some descriptions begin with the name and its parameter.
    match about.split_once(": ").filter(|(usage, _)| usage.starts_with(name)) {
        Some((usage, about)) => format!("{usage:<14}{about}\n"),
        None => format!("{name:<14}{about}\n"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_name_what_to_type() {
        assert_eq!(line("box-grid", "box-grid:N: boxes"), "box-grid:N    boxes\n");
        assert_eq!(line("knots", "smooth knots: nice"), "knots         smooth knots: nice\n");
    }
}
