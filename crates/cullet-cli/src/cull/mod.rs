//! `cullet cull`: what each culling test rejects, leaves over and costs.

mod input;
mod measure;
mod report;

use std::path::{Path, PathBuf};

use clap::Args;
use cullet::cull::{Aabb, Frustum, Sat, Test, Visibility, visible};

use crate::exit::Failure;
use crate::output::{Outputs, Target, print};
use crate::render::SimdName;
use crate::source::Source;
use measure::Measured;

/// Measure what each culling test rejects, leaves over and costs
#[derive(Args, Clone, Debug)]
pub struct CullArgs {
    #[command(flatten)]
    source: Option<Source>,
    /// Test these boxes instead of a scene: one {"min":[x,y,z],"max":[x,y,z]} per line
    #[arg(
        long,
        value_name = "FILE.jsonl",
        conflicts_with = "path",
        required_unless_present = "path"
    )]
    boxes: Option<PathBuf>,
    /// Keep the boxes of the file in f64; without it they are read as f32
    #[arg(long, requires = "boxes")]
    f64: bool,
    /// `auto` frames the whole scene; or the index or name of a camera of the scene; or a camera
    /// file (the only choice with --boxes)
    #[arg(long, value_name = "auto|INDEX|NAME|FILE.json", default_value = "auto")]
    camera: String,
    /// Test against this matrix instead of a camera: {"rows":[[4],[4],[4],[4]],
    /// "depth":"zero-to-one"|"minus-one-to-one"|"reversed"}
    #[arg(long, value_name = "FILE.json", conflicts_with = "camera")]
    clip_from_world: Option<PathBuf>,
    /// Timed rounds, in which the tests take turns; one more comes first to warm up
    #[arg(long, value_name = "N", default_value_t = 5)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=100_000))]
    repeat: u32,
    /// Instruction set of the walk over the tree; one that the machine lacks is an error
    #[arg(long, value_enum, default_value = "auto")]
    simd: SimdName,
    /// One line per box, in input order: what each test says of it
    #[arg(long, value_name = "OUT.jsonl")]
    verdicts: Option<PathBuf>,
    /// The figures as JSON; `-` for standard output
    #[arg(long, value_name = "FILE|-")]
    json: Option<PathBuf>,
    /// The figures of the tests as CSV; `-` for standard output
    #[arg(long, value_name = "FILE|-")]
    csv: Option<PathBuf>,
}

/// Reads, measures, writes.
pub fn run(args: &CullArgs) -> Result<(), Failure> {
    let level = args.simd.level()?;
    let wanted = [&args.verdicts, &args.json, &args.csv].map(|path| path.as_deref());
    let targets: Vec<Target> = wanted.into_iter().flatten().map(Target::from).collect();
    let mut outputs = Outputs::open(&targets)?;

    let (boxes, frustum) = input::read(args)?;
    let measured = Measured::take(&boxes, &frustum, level, args.repeat);
    let mut index = 0;
    let mut write = |wanted: Option<&Path>, bytes: &dyn Fn() -> Vec<u8>| match wanted {
        Some(_) => {
            index += 1;
            outputs.write(index - 1, &bytes())
        }
        None => Ok(()),
    };
    write(wanted[0], &|| verdicts(&boxes, &frustum))?;
    write(wanted[1], &|| report::json(args, &measured))?;
    write(wanted[2], &|| report::csv(&measured).into_bytes())?;
    outputs.commit()?;
    if wanted[1].is_none() && wanted[2].is_none() {
        print(report::table(&measured).as_bytes())?;
    }
    Ok(())
}

/// What every test says of every box, a line of JSON each.
fn verdicts(boxes: &[Aabb], frustum: &Frustum) -> Vec<u8> {
    let sat = Sat::new(frustum);
    let mut text = String::new();
    for (i, bounds) in boxes.iter().enumerate() {
        let says = |test| visible(test, frustum, bounds);
        let class = match sat.classify(bounds) {
            _ if bounds.is_nan() => "invalid",
            Visibility::Outside => "outside",
            Visibility::Crossing => "crossing",
            Visibility::Inside => "inside",
        };
        let line = serde_json::json!({
            "i": i,
            "corners": says(Test::Corners),
            "p_vertex": says(Test::PVertex),
            "reverse": says(Test::Reverse),
            "both": says(Test::Both),
            "sat": sat.visible(bounds),
            "class": class,
        });
        text += &line.to_string();
        text.push('\n');
    }
    text.into_bytes()
}
