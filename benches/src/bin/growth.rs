//! How a frame's time grows: with pixels seen, with triangles seen, with triangles hidden behind a
//! wall, with triangles outside the view.
//!
//! `growth PREFIX [LARGEST]`: writes `PREFIX-pixels.svg`, `-seen.svg`, `-hidden.svg`, `-outside.svg`
//! and the same as tables in `PREFIX.md`. LARGEST: millions of hidden and outside triangles in the
//! last step, 100 by default. 1280x720 but for the first, one sample per pixel; least time of many frames, on one
//! core and on two.

use std::fmt::Write;
use std::path::Path;
use std::time::Duration;

use cullet::scene::{Scene, synth};
use cullet::{Antialias, Frame, Prepared, Renderer, Settings, View, Viewport, camera_of};
use cullet_benches::growing::{hidden, outside, sphere};
use cullet_benches::plot::{Line, log_log, short};
use cullet_measure::{Align, Stopwatch, Table};

/// The same frame on so many threads.
const THREADS: [usize; 2] = [1, 2];
const COLORS: [&str; 2] = ["#1f6fb4", "#d1652b"];

fn main() {
    let mut arguments = std::env::args().skip(1);
    let prefix = arguments.next().expect("growth PREFIX [LARGEST]");
    if let Some(folder) = Path::new(&prefix).parent() {
        std::fs::create_dir_all(folder).expect("a folder");
    }
    let largest: usize = arguments.next().map_or(100, |n| n.parse().expect("millions"));
    let millions: Vec<usize> =
        [1, 2, 5, 10, 20, 50, 100].into_iter().filter(|&n| n <= largest).collect();
    let hd = [1280, 720];

    let sizes = [[854, 480], [1280, 720], [1920, 1080], [2560, 1440], [3840, 2160], [7680, 4320]];
    let showpiece = prepare(synth::synth("showpiece").expect("a scene"));
    let pixels = sizes.map(|size| step(f64::from(size[0] * size[1]), &showpiece, size));
    let seen = [10_000, 30_000, 100_000, 300_000, 1_000_000, 4_000_000].map(|n| {
        let scene = prepare(sphere(n));
        step(scene.scene().meshes[0].triangles.len() as f64, &scene, hd)
    });
    let grow = |build: fn(usize) -> Scene| -> Vec<Step> {
        let steps = millions.iter().map(|&n| {
            let scene = prepare(build(n * 1_000_000));
            step(n as f64 * 1e6, &scene, hd)
        });
        steps.collect()
    };

    let mut report = String::new();
    for (name, title, x_label, steps) in [
        ("pixels", "The showpiece, 480p to 8K", "pixels", pixels.to_vec()),
        ("seen", "One sphere, more and more finely divided", "triangles in view", seen.to_vec()),
        ("hidden", "Instances behind a wall", "triangles hidden", grow(hidden)),
        ("outside", "Instances behind the camera", "triangles outside the view", grow(outside)),
    ] {
        let lines: Vec<_> = (0..THREADS.len())
            .map(|i| Line {
                label: format!("threads: {}", THREADS[i]),
                color: COLORS[i],
                points: steps.iter().map(|step| [step.x, step.ms[i]]).collect(),
            })
            .collect();
        let file = format!("{prefix}-{name}.svg");
        std::fs::write(&file, log_log(title, x_label, "ms", &lines)).expect("a file");
        let _ = writeln!(report, "## {title}\n\n![]({})\n", file_name(&file));
        let _ = writeln!(report, "```text\n{}```\n", table(x_label, &steps));
    }
    std::fs::write(format!("{prefix}.md"), &report).expect("a file");
    print!("{report}");
}

/// One point of each line.
#[derive(Clone, Copy)]
struct Step {
    x: f64,
    /// Per number of threads.
    ms: [f64; 2],
    drawn: u64,
    pixels: u64,
}

fn prepare(scene: Scene) -> Prepared {
    Prepared::new(scene).unwrap_or_else(|e| panic!("{e}"))
}

fn step(x: f64, prepared: &Prepared, [width, height]: [u32; 2]) -> Step {
    let viewport = Viewport::new(width, height).expect("a possible size");
    let camera = camera_of(&prepared.scene().cameras[0]).expect("a possible camera");
    let view = View::new(&camera, viewport);
    let mut frame = Frame::default();
    let mut result = Step { x, ms: [0.0; 2], drawn: 0, pixels: 0 };
    for (i, threads) in THREADS.into_iter().enumerate() {
        let settings = Settings { threads, antialias: Antialias::None, ..Settings::default() };
        let mut renderer = Renderer::default();
        let watch =
            Stopwatch { at_least: 5, budget: Duration::from_millis(1500), ..Stopwatch::default() };
        let mut draw = || renderer.render(prepared, &view, &settings, &mut frame);
        let stats = draw();
        result.ms[i] = 1e3 * watch.measure(draw).min;
        (result.drawn, result.pixels) = (stats.triangles.n_drawn, stats.pixels_shaded);
    }
    eprintln!("{}: {:.2?} ms", short(x), result.ms);
    result
}

fn table(x_label: &str, steps: &[Step]) -> Table {
    let right = Align::Right;
    let mut table = Table::new(&[
        (x_label, right),
        ("ms, 1 thread", right),
        ("ms, 2 threads", right),
        ("to the first", right),
        ("x to the first", right),
        ("triangles drawn", right),
        ("pixels shaded", right),
    ]);
    for step in steps {
        table.push([
            short(step.x),
            format!("{:.2}", step.ms[0]),
            format!("{:.2}", step.ms[1]),
            format!("{:.2}", step.ms[0] / steps[0].ms[0]),
            format!("{:.2}", step.x / steps[0].x),
            step.drawn.to_string(),
            step.pixels.to_string(),
        ]);
    }
    table
}

fn file_name(path: &str) -> &str {
    path.rsplit('/').next().unwrap_or(path)
}
