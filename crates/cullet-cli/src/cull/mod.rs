//! `cullet cull`: what each culling test rejects, leaves over, costs and saves.

mod compare;
mod downstream;
mod expr;
mod html;
mod input;
mod measure;
mod path;
mod report;
mod sweep;
mod tables;
mod verdicts;
mod waste;

use std::path::PathBuf;

use clap::{ArgGroup, Args};
use cullet::Level;
use cullet::cull::Verdict;
use cullet::cull::distributions::Distribution;
use serde_json::Value;

use crate::exit::Failure;
use crate::message::{Progress, note};
use crate::output::{Outputs, Target, print, spare_inputs};
use crate::render::{SimdName, camera, level_name, size};
use crate::source::{Limits, Source};
use downstream::{Drawn, Mode, draw};
use expr::Reports;
use input::{Input, Shot};
use measure::{Boxes, Figures, Rounds};
use path::CameraPath;
use waste::Waste;

/// Measure what each culling test rejects, leaves over, costs and saves
#[derive(Args, Clone, Debug)]
#[command(group(ArgGroup::new("asked").args(["scene", "boxes", "distributions"]).multiple(true).required(true)))]
pub struct CullArgs {
    /// A .glb, .gltf or .obj file; `-` reads a .glb from standard input; `synth:NAME[:PARAMETER]`
    /// computes a scene (`cullet synth --list` names them)
    #[arg(value_name = "SCENE")]
    scene: Option<PathBuf>,
    // Not `Option<Source>`: an optional group with a group inside counts as never given.
    #[command(flatten)]
    limits: Limits,
    /// Test these boxes instead of a scene: one {"min":[x,y,z],"max":[x,y,z]} per line; `-` reads
    /// them from standard input
    #[arg(long, value_name = "FILE.jsonl|-", conflicts_with = "scene")]
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
    #[arg(long, value_name = "FILE.json", conflicts_with_all = ["camera", "camera_path"])]
    clip_from_world: Option<PathBuf>,
    /// Many cameras: `orbit:N[:DISTANCE]` turns --camera around the vertical line through the median
    /// of the boxes' centres (DISTANCE times as far from it, default 1); `dolly[:N]` moves it
    /// straight on through everything (N: 32); a file holds a list of cameras. An `auto` camera
    /// gets a near plane that does not cut things away when it comes close
    #[arg(id = "camera_path", long = "path", value_name = "orbit:N|dolly|FILE.json")]
    path: Option<CameraPath>,
    /// Size of the picture, which decides how wide the view is; default: the camera file's, or
    /// 1280x720
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<(u32, u32)>,
    /// Timed rounds per camera, in which the tests take turns; one more comes first to warm up
    #[arg(long, value_name = "N", default_value_t = 5)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=100_000))]
    repeat: u32,
    /// Rounds with cold caches, at the first camera
    #[arg(long, value_name = "N", default_value_t = 3)]
    #[arg(value_parser = clap::value_parser!(u32).range(0..=100_000))]
    cold: u32,
    /// Frames the renderer draws per way of culling, to tell what culling saves (scenes only);
    /// 0 draws none. Default: 5 for the one camera, or the worst of a path; 1 for each of a path
    #[arg(long, value_name = "N")]
    #[arg(value_parser = clap::value_parser!(u32).range(0..=1000))]
    frames: Option<u32>,
    /// Instruction set of the wide tests; one that the machine lacks is an error
    #[arg(long, value_enum, default_value = "auto")]
    simd: SimdName,
    /// Instead of a scene ask the tests about N frusta of each of nine generated kinds of boxes
    /// (seeded, the same everywhere): props to skies, screen tiles, light clusters, a city
    #[arg(long, value_name = "N", num_args = 0..=1, default_missing_value = "400")]
    #[arg(conflicts_with_all = ["scene", "boxes", "camera", "camera_path", "clip_from_world"])]
    #[arg(conflicts_with = "verdicts")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    distributions: Option<u32>,
    /// One line per box, in input order: what each test says of it. On a path camera after camera;
    /// written as it becomes known
    #[arg(long, value_name = "OUT.jsonl")]
    verdicts: Option<PathBuf>,
    /// The figures as JSON; `-` for standard output
    #[arg(long, value_name = "FILE|-")]
    json: Option<PathBuf>,
    /// The figures of the tests, the walk and the renderer, per camera, as CSV; `-` for standard output
    #[arg(long, value_name = "FILE|-")]
    csv: Option<PathBuf>,
    /// All of it with charts and pictures, as one page that needs nothing else
    #[arg(long, value_name = "FILE|-")]
    html: Option<PathBuf>,
    /// Show what changed since an earlier --json report
    #[arg(long, value_name = "OLD.json")]
    compare: Option<PathBuf>,
    /// Exit with 1 if this holds, e.g. `tests.both.false_visible > 0` or, with --compare,
    /// `hierarchy.walk_ms > 1.2 * old.hierarchy.walk_ms`: figures are named as in the JSON; numbers,
    /// + - * / ( ) < <= > >= == != && ||; to divide by 0 is wrong usage. May be given more than once
    #[arg(long, value_name = "EXPR", allow_hyphen_values = true)]
    fail_if: Vec<String>,
}

impl CullArgs {
    fn source(&self) -> Option<Source> {
        Some(Source::new(self.scene.clone()?, self.limits))
    }
}

/// One camera's results.
pub struct Shown {
    /// What the tests did.
    pub figures: Figures,
    /// The frame without culling and the one with `render`'s defaults; none without a scene.
    pub drawn: Vec<Drawn>,
}

/// Everything measured.
pub struct Measured {
    /// What was asked about.
    pub input: Input,
    /// Per camera.
    pub shown: Vec<Shown>,
    /// All cameras added up.
    pub sum: Figures,
    /// Which camera the rest is about: the only one, or the one with the most triangles to draw, or,
    /// without a scene, with the most boxes to test.
    pub focus: usize,
    /// Its verdicts on every box.
    pub verdicts: Vec<Verdict>,
    /// Its frame, with every way to cull.
    pub downstream: Vec<Drawn>,
    /// Time to build the tree, ms.
    pub build_ms: f64,
    /// Instruction set of the wide tests.
    pub simd: &'static str,
}

impl Measured {
    /// The frames of a camera; of the one in focus with every way to cull, where there are any.
    fn drawn(&self, camera: usize) -> &[Drawn] {
        let all = camera == self.focus && !self.downstream.is_empty();
        if all { &self.downstream } else { &self.shown[camera].drawn }
    }
}

/// Reads, measures, writes.
pub fn run(args: &CullArgs) -> Result<(), Failure> {
    let level = args.simd.level()?;
    for condition in &args.fail_if {
        let comparing = args.compare.is_some();
        expr::check(condition, comparing)
            .map_err(|fault| Failure::usage(format!("--fail-if `{condition}`: {fault}")))?;
    }
    if args.camera != "auto" && matches!(args.path, Some(CameraPath::File(_))) {
        return Err(Failure::usage("--path FILE.json has cameras of its own: leave --camera out"));
    }
    let wanted = [&args.verdicts, &args.json, &args.csv, &args.html].map(|path| path.as_deref());
    let targets: Vec<Target> = wanted.into_iter().flatten().map(Target::from).collect();
    spare_inputs(&targets, &inputs(args))?;
    let mut outputs = Outputs::open(&targets)?;
    let old = args.compare.as_deref().map(compare::read).transpose()?;
    let write = |outputs: &mut Outputs, path: &Option<PathBuf>, bytes: &[u8]| {
        let target = path.as_deref().map(Target::from);
        match targets.iter().position(|known| Some(known) == target.as_ref()) {
            Some(index) => outputs.write(index, bytes),
            None => Ok(()),
        }
    };

    // The page always shows where the tests differ; 60 frusta of a kind are enough for a chart.
    let n_samples = args.distributions.or(args.html.is_some().then_some(60));
    let wastes: Vec<Waste> = n_samples.map(distributions).unwrap_or_default();
    let measured = match (args.source(), &args.boxes) {
        (None, None) => None,
        _ => Some(measure(args, level, input::read(args)?, &mut |lines| {
            write(&mut outputs, &args.verdicts, lines)
        })?),
    };
    let asked = if args.distributions.is_some() { &wastes[..] } else { &[] };
    let new = report::json(args, measured.as_ref(), asked);
    let compared = old.as_ref().map(|old| compare::table(&new, old)).unwrap_or_default();
    if let Some(differ) = old.as_ref().and_then(|old| compare::other_inputs(&new, old)) {
        note(differ);
    }
    // Faulty conditions are wrong usage: nothing is written then (but verdicts that go elsewhere than to a file).
    let failed = failed(args, &new, old.as_ref())?;

    let measured = measured.as_ref();
    if args.json.is_some() {
        write(&mut outputs, &args.json, &crate::stats::json(&new))?;
    }
    if args.csv.is_some() {
        write(&mut outputs, &args.csv, tables::csv(measured, asked).as_bytes())?;
    }
    if args.html.is_some() {
        write(&mut outputs, &args.html, html::page(args, measured, &wastes).as_bytes())?;
    }
    outputs.commit()?;
    if targets.contains(&Target::Stdout) {
        compared.lines().filter(|line| !line.is_empty()).for_each(note);
    } else {
        let mut tables = measured.map(tables::all).unwrap_or_default();
        if args.distributions.is_some() {
            tables += &tables::distributions(asked);
        }
        print((tables + &compared).as_bytes())?;
    }
    match failed {
        0 => Ok(()),
        n => Err(Failure::differs(format!("{n} of {} conditions hold", args.fail_if.len()))),
    }
}

fn inputs(args: &CullArgs) -> Vec<&std::path::Path> {
    let file = match &args.path {
        Some(CameraPath::File(path)) => Some(path),
        _ => None,
    };
    let named = [&args.boxes, &args.clip_from_world, &args.compare];
    let named = named.into_iter().flatten().chain(file).map(PathBuf::as_path);
    let scene = args.scene.as_deref();
    named.chain(camera::file(&args.camera)).chain(scene).collect()
}

fn distributions(n_samples: u32) -> Vec<Waste> {
    let _progress = Progress::show("asking about generated boxes");
    let seed = 1;
    Distribution::ALL.map(|kind| Waste::measure(kind, n_samples as usize, seed)).to_vec()
}

/// `write_verdicts` gets the lines of `--verdicts`, as they become known.
fn measure(
    args: &CullArgs,
    level: Level,
    input: Input,
    write_verdicts: &mut dyn FnMut(&[u8]) -> Result<(), Failure>,
) -> Result<Measured, Failure> {
    let Input { boxes, shots, prepared } = &input;
    let all = Boxes::new(boxes, level);
    let picture =
        |shot: &Shot, modes: &[Mode], frames: u32| match (prepared, &shot.camera, shot.viewport) {
            (Some(prepared), Some(camera), Some(viewport)) if frames > 0 => {
                draw(prepared, camera, viewport, modes, frames)
            }
            _ => Vec::new(),
        };
    /// Lines written at a time.
    const LINES: usize = 1 << 14;
    let mut text = String::new();
    let mut shown = Vec::new();
    let mut last = Vec::new();
    let mut sum = Figures::default();
    for (i, shot) in shots.iter().enumerate() {
        let _progress = Progress::show(&format!("camera {} of {}", i + 1, shots.len()));
        let cold = if i == 0 { args.cold } else { 0 };
        let verdicts = all.verdicts(&shot.frustum);
        if args.verdicts.is_some() {
            let camera = args.path.is_some().then_some(i);
            for (n, some) in verdicts.chunks(LINES).enumerate() {
                text.clear();
                verdicts::lines(some, n * LINES, camera, &mut text);
                write_verdicts(text.as_bytes())?;
            }
        }
        let figures = all.measure(&shot.frustum, &verdicts, Rounds { warm: args.repeat, cold });
        sum += &figures;
        let drawn = match shots.len() {
            1 => Vec::new(),
            _ => picture(shot, &[Mode::NONE, Mode::DEFAULT], args.frames.unwrap_or(1)),
        };
        shown.push(Shown { figures, drawn });
        last = verdicts;
    }
    // The one with the most to do, by counts: those are the same in every run.
    let metrics = sweep::metrics(&shown);
    let busiest = metrics.iter().rev().find(|m| matches!(m.name, "triangles" | "boxes_tested"));
    let focus = busiest.map_or(0, sweep::Metric::worst);
    let _progress = Progress::show("drawing with every test");
    Ok(Measured {
        verdicts: if focus + 1 == shots.len() { last } else { all.verdicts(&shots[focus].frustum) },
        downstream: picture(&shots[focus], &Mode::ALL, args.frames.unwrap_or(5)),
        shown,
        sum,
        focus,
        build_ms: all.build_ms,
        simd: level_name(level),
        input,
    })
}

/// How many conditions of `--fail-if` hold; says which, and what figures decided.
fn failed(args: &CullArgs, new: &Value, old: Option<&Value>) -> Result<usize, Failure> {
    let mut n = 0;
    for condition in &args.fail_if {
        let wrong = |fault| Failure::usage(format!("--fail-if `{condition}`: {fault}"));
        let asked = expr::holds(condition, Reports { new, old }).map_err(wrong)?;
        if asked.holds {
            n += 1;
            note(format_args!("--fail-if `{condition}` holds: {}", asked.figures.join(", ")));
        }
    }
    Ok(n)
}
