//! Frames of a camera that turns 1 degree per frame, beside those of one that stands still.
//!
//! `turning SCENE CAMERA.json [--threads N] [--aa none|msaa4] [--budget SECONDS]` prints a line of JSON:
//! medians and least times in ms. Each renderer keeps its memory, so what one frame may teach the
//! next can pay. Both are timed in turn. The still camera looks in every direction of the turn as well
//! (each of its frames is drawn twice and the second one timed), so that both draw the same pictures.
//! An unknown `--aa` is exit code 2.

use std::path::Path;
use std::time::{Duration, Instant};

use cullet::scene::{LoadOptions, load};
use cullet::{Antialias, Frame, Prepared, Renderer, Settings, View};
use cullet_benches::camera::CameraFile;
use cullet_measure::Summary;

/// Frames of the turn.
const DEGREES: usize = 30;

fn main() {
    let mut settings = Settings { threads: 1, ..Settings::default() };
    let mut budget = Duration::from_secs(2);
    let mut files = Vec::new();
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().expect("a value");
        match argument.as_str() {
            "--threads" => settings.threads = value().parse().expect("a number of threads"),
            "--budget" => budget = Duration::from_secs_f64(value().parse().expect("seconds")),
            "--aa" => match value().as_str() {
                "none" => settings.antialias = Antialias::None,
                "msaa4" => settings.antialias = Antialias::Msaa4,
                other => {
                    eprintln!("no antialiasing `{other}`");
                    std::process::exit(2);
                }
            },
            _ => files.push(argument),
        }
    }
    let [scene, camera] = &files[..] else { panic!("turning SCENE CAMERA.json [OPTIONS]") };
    let scene = load(Path::new(scene), &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let prepared = Prepared::new(scene).unwrap_or_else(|e| panic!("{e}"));
    let camera = CameraFile::read(Path::new(camera));
    let views: Vec<_> =
        (0..DEGREES).map(|i| View::new(&camera.turned(i as f64), camera.viewport)).collect();

    let (mut moving, mut resting) = (Renderer::default(), Renderer::default());
    let mut frame = Frame::default();
    let mut draw = |renderer: &mut Renderer, view: &View| {
        let start = Instant::now();
        renderer.render(&prepared, view, &settings, &mut frame);
        1e3 * start.elapsed().as_secs_f64()
    };
    draw(&mut moving, &views[DEGREES - 1]);
    let (mut turning, mut still) = (Vec::new(), Vec::new());
    let start = Instant::now();
    // Whole turns there and back, so that every view counts as often as any other.
    while turning.is_empty() || start.elapsed() < budget {
        for view in views.iter().chain(views.iter().rev()) {
            turning.push(draw(&mut moving, view));
            draw(&mut resting, view);
            still.push(draw(&mut resting, view));
        }
    }
    let [turning, still] = [turning, still].map(|ms| Summary::of(&ms).expect("frames"));
    println!(
        "{{\"degrees\": {DEGREES}, \"frames\": {}, \"still_ms\": {}, \"turning_ms\": {}, \
         \"still_min_ms\": {}, \"turning_min_ms\": {}}}",
        turning.n, still.median, turning.median, still.min, turning.min
    );
}
