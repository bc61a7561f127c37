//! `cullet tradeoff`: what each way to draw costs, how wrong it is, and which are worth it.
//!
//! One row is one value of one knob on one scene, by one metric: time as the median of interleaved
//! rounds, error against a reference that is not the fast path, both from the same run.

mod calls;
mod domination;
mod doubt;
mod expectations;
mod findings;
mod html;
mod knobs;
mod lamp;
mod machine;
mod measure;
mod metrics;
mod plan;
mod plot;
mod reference;
mod study;
mod table;
mod text;
mod words;

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;
use cullet::scene::Images;
use cullet::{Camera, Prepared, Settings, View, Viewport};
use serde::Serialize;
use serde_json::json;

use crate::exit::Failure;
use crate::message::{Progress, note, warn};
use crate::output::{Outputs, Target, print, spare_inputs};
use crate::render::{camera, size};
use crate::source::{Limits, Source};
use crate::stats;
use calls::Calls;
use findings::{Control, Findings};
use lamp::Lamp;
use machine::Machine;
use measure::{Reporter, SceneMeasured};
use plan::{Budget, STUDIES_SHARE};
use study::{Studies, Study};
use table::Row;

/// Changes whenever a key changes its meaning or goes.
const SCHEMA: u32 = 1;

/// The most of the budget that is spent on what is measured by the call.
const CALLS: f64 = 0.02;

/// How much of the budget may be used up before that is told.
const OVER: f64 = 1.25;

/// Measure speed against accuracy: every setting's time and error, and which settings nothing beats.
///
/// Writes tradeoff.csv, tradeoff.json, tradeoff.svg and tradeoff.html, and prints the settings that
/// nothing beats, what they were measured with, and of everything one would expect whether it is confirmed,
/// refuted, or within what the figures cannot tell.
///
/// `time_ms` is the default's median times the median ratio to it, round by round; `spread` is half the
/// interquartile range of that ratio as a fraction of it.
#[derive(Args, Clone, Debug)]
pub struct TradeoffArgs {
    /// .glb, .gltf or .obj files, or `synth:NAME`; several are measured one after the other
    #[arg(value_name = "SCENE", required = true)]
    scenes: Vec<PathBuf>,
    /// The folder for the four files; it is made where it is not there
    #[arg(long, value_name = "DIR", default_value = ".")]
    out: PathBuf,
    /// Seconds for everything, held within a quarter; what does not fit is left out, the least important
    /// first, and named
    #[arg(long, value_name = "SECONDS", default_value_t = 240.0, value_parser = seconds)]
    #[arg(allow_negative_numbers = true)]
    budget: f64,
    /// Size of the pictures in pixels
    #[arg(long, value_name = "WxH", default_value = "480x270", value_parser = size)]
    size: (u32, u32),
    /// Camera of every scene: `auto`, an index, a name or a camera file [default: the first of the
    /// scene, or else auto]
    #[arg(long, value_name = "auto|INDEX|NAME|FILE.json")]
    camera: Option<String>,
    /// Worker threads of what is timed, 0 for one per core. One gives the steadiest figures: its
    /// processor time, which other programs do not add to. More are timed by the wall
    #[arg(long, value_name = "N", default_value_t = 1, allow_negative_numbers = true)]
    #[arg(value_parser = clap::value_parser!(u16).range(0..=1024))]
    threads: u16,
    #[command(flatten)]
    limits: Limits,
}

/// All that is reported.
struct Report<'a> {
    scenes: &'a [SceneReport],
    rows: &'a [Row],
    findings: &'a Findings,
    studies: &'a [Study],
    /// Studies of no scene that there was no time for.
    no_study: &'a [String],
    machine: &'a Machine,
    size: (u32, u32),
    threads: u16,
    clock: &'static str,
    budget: f64,
    /// Seconds.
    took: f64,
    command: String,
}

/// What was measured of a scene, and from where.
struct SceneReport {
    name: String,
    camera: String,
    measured: SceneMeasured,
}

/// A scene, and where it is seen from.
struct Loaded {
    prepared: Prepared,
    camera: String,
    eye: Camera,
}

impl Loaded {
    fn new(path: &Path, args: &TradeoffArgs) -> Result<Loaded, Failure> {
        let (scene, _) =
            Source::new(path.to_owned(), args.limits).load_to_draw(0, Images::BaseColors)?;
        warn(&scene.warnings);
        let prepared = Prepared::new(scene)?;
        let camera = args.camera.clone().unwrap_or_else(|| first_camera(&prepared));
        let (eye, _) = camera::choose(&camera, Some(args.size), &prepared)?;
        Ok(Loaded { prepared, camera, eye })
    }
}

/// Measures and writes.
pub fn run(args: &TradeoffArgs) -> Result<(), Failure> {
    let budget = Budget::new(Duration::from_secs_f64(args.budget));
    let viewport = Viewport::new(args.size.0, args.size.1)?;
    let line = Progress::show("loading");
    // All before anything is measured or made: a name that is wrong says so at once.
    let loaded: Vec<Loaded> =
        args.scenes.iter().map(|path| Loaded::new(path, args)).collect::<Result<_, _>>()?;
    if args.out.as_os_str() == "-" {
        return Err(Failure::usage("--out -: several files are written; name a folder for them"));
    }
    let made = !args.out.exists();
    if made {
        let cannot = |error| Failure::output(format!("{}: {error}", args.out.display()));
        fs::create_dir_all(&args.out).map_err(cannot)?;
    }
    let targets = ["csv", "json", "svg", "html"]
        .map(|extension| Target::File(args.out.join(format!("tradeoff.{extension}"))));
    let inputs: Vec<&Path> = args.scenes.iter().map(PathBuf::as_path).collect();
    spare_inputs(&targets, &inputs)?;
    let mut outputs = Outputs::open(&targets)?;

    let machine = Machine::here();
    let mut scenes: Vec<SceneReport> = Vec::new();
    let mut calls = Calls::new();
    let time_for_calls =
        Duration::from_secs_f64(args.budget * CALLS / (args.scenes.len() + 1) as f64);
    calls.measure(time_for_calls);
    let Studies { done: mut studies, left_out: no_study, .. } =
        Studies::within(Duration::from_secs_f64(args.budget * STUDIES_SHARE)).general()?;
    for (i, (path, Loaded { prepared, camera, eye })) in args.scenes.iter().zip(loaded).enumerate()
    {
        let end = budget.end_of_scene(args.scenes.len() - i);
        let name = scene_name(path, &scenes);
        let n_scenes = args.scenes.len();
        let report = Reporter { scene: name.clone(), budget: &budget, n_scenes, line: &line };
        let view = View::new(&eye, viewport);
        let threads = usize::from(args.threads);
        let lamp = Lamp::find(&prepared, &view);
        let common = move |settings: &mut Settings| {
            settings.threads = threads;
            lamp.hang(settings);
        };
        let measured = measure::scene(&prepared, &view, &common, threads, end, &report)?;
        scenes.push(SceneReport { name, camera, measured });
        calls.measure(time_for_calls);
    }
    let mut rows: Vec<Row> =
        scenes.iter().flat_map(|scene| table::of_scene(&scene.name, &scene.measured)).collect();
    rows.extend(calls.all().iter().flat_map(|calls| table::of_calls(calls)));
    table::find_fronts(&mut rows);
    let controls: Vec<Control> =
        scenes.iter().map(|scene| Control::of(&scene.name, &scene.measured)).collect();
    for scene in &mut scenes {
        studies.append(&mut scene.measured.studies);
    }
    let findings = Findings::of(&rows, &controls, &studies);
    drop(line);

    let report = Report {
        scenes: &scenes,
        rows: &rows,
        findings: &findings,
        studies: &studies,
        no_study: &no_study,
        machine: &machine,
        size: args.size,
        threads: args.threads,
        clock: match args.threads {
            1 => "processor time of one thread",
            _ => "wall time",
        },
        budget: args.budget,
        took: budget.elapsed().as_secs_f64(),
        command: command(args),
    };
    outputs.write(0, table::csv(&rows).as_bytes())?;
    outputs.write(1, &report_json(&report))?;
    outputs.write(2, plot::svg(&rows).as_bytes())?;
    outputs.write(3, html::page(&report)?.as_bytes())?;
    outputs.commit()?;
    print(text::all(&report).as_bytes())?;
    if !no_study.is_empty() {
        note(format_args!(
            "left out, as --budget {} is short: {}",
            args.budget,
            no_study.join(", ")
        ));
    }
    for scene in scenes.iter().filter(|scene| !scene.measured.left_out.is_empty()) {
        let left_out = scene.measured.left_out.join(", ");
        note(format_args!(
            "{}: left out, as --budget {} is short: {left_out}",
            scene.name, args.budget
        ));
    }
    if budget.elapsed().as_secs_f64() > OVER * args.budget {
        note(format_args!(
            "--budget {} is less than the references and the presets take here",
            args.budget
        ));
    }
    note(format_args!(
        "{} rows in {:.0} s: {}",
        rows.len(),
        budget.elapsed().as_secs_f64(),
        args.out.join("tradeoff.{csv,json,svg,html}").display()
    ));
    Ok(())
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|seconds: &f64| *seconds > 0.0 && *seconds <= 1e6);
    seconds.ok_or_else(|| "give a number of seconds above 0, at most a million".into())
}

/// The file's name without its ending, with a number where another scene has it already.
fn scene_name(path: &Path, others: &[SceneReport]) -> String {
    let whole = path.to_string_lossy();
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let name =
        if whole.starts_with("synth:") { whole.into_owned() } else { stem.unwrap_or_default() };
    let is_taken =
        |name: &str| calls::is_scene(name) || others.iter().any(|other| other.name == name);
    let numbered = (2..).map(|n| format!("{name} {n}"));
    let names = std::iter::once(name.clone()).chain(numbered);
    names.into_iter().find(|name| !is_taken(name)).unwrap_or(name)
}

fn first_camera(prepared: &Prepared) -> String {
    if prepared.scene().cameras.is_empty() { "auto".into() } else { "0".into() }
}

/// The command that measures this again.
fn command(args: &TradeoffArgs) -> String {
    let scenes: Vec<_> = args.scenes.iter().map(|path| path.to_string_lossy()).collect();
    let camera = args.camera.as_ref().map_or(String::new(), |camera| format!(" --camera {camera}"));
    format!(
        "cullet tradeoff {} --budget {} --size {}x{} --threads {}{camera}",
        scenes.join(" "),
        args.budget,
        args.size.0,
        args.size.1,
        args.threads,
    )
}

fn report_json(report: &Report<'_>) -> Vec<u8> {
    #[derive(Serialize)]
    struct SceneJson<'a> {
        scene: &'a str,
        camera: &'a str,
        reference: &'a str,
        samples: u32,
        rounds: usize,
        left_out: &'a [String],
    }
    let scenes: Vec<_> = report
        .scenes
        .iter()
        .map(|scene| SceneJson {
            scene: &scene.name,
            camera: &scene.camera,
            reference: &scene.measured.reference.how,
            samples: scene.measured.reference.n_samples,
            rounds: scene.measured.n_rounds,
            left_out: &scene.measured.left_out,
        })
        .collect();
    stats::json(&json!({
        "schema": SCHEMA,
        "version": env!("CARGO_PKG_VERSION"),
        "machine": report.machine,
        "settings": {
            "command": report.command,
            "size": [report.size.0, report.size.1],
            "threads": report.threads,
            "clock": report.clock,
            "budget_s": report.budget,
            "took_s": table::rounded(report.took),
            "default": "quality balanced",
        },
        "scenes": scenes,
        "rows": report.rows,
        "studies": report.studies,
        "left_out": report.no_study,
        "findings": report.findings.all().collect::<Vec<_>>(),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn budgets() {
        assert_eq!(seconds("240"), Ok(240.0));
        for text in ["", "0", "-1", "nan", "inf", "a"] {
            assert!(seconds(text).is_err(), "{text}");
        }
    }

    #[test]
    fn scenes_have_names_of_their_own() {
        assert_eq!(scene_name(Path::new("a/city.glb"), &[]), "city");
        assert_eq!(scene_name(Path::new("synth:box-grid:3"), &[]), "synth:box-grid:3");
        assert_eq!(scene_name(Path::new("calls.obj"), &[]), "calls 2");
    }
}
