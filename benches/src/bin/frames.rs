//! Whole frames of the shipped scenes at 1280x720, one thread: where the time goes, and what the
//! box test of each object gains. Arguments: scenes to time instead.

use std::hint::black_box;

use cullet::{CullTest, Frame, Renderer, Settings, Viewport};
use cullet_benches::{prepare, shipped_scenes};
use cullet_measure::{Align, Rounds, Table};

fn main() {
    let arguments: Vec<_> = std::env::args_os().skip(1).map(Into::into).collect();
    let scenes = if arguments.is_empty() { shipped_scenes() } else { arguments };
    let viewport = Viewport::new(1280, 720).expect("a possible size");
    let mut table = Table::new(&[
        ("scene", Align::Left),
        ("ms", Align::Right),
        ("spread", Align::Right),
        ("geometry", Align::Right),
        ("raster", Align::Right),
        ("shade", Align::Right),
        ("resolve", Align::Right),
        ("no cull / cull", Align::Right),
    ]);
    for path in scenes {
        let (prepared, view) = prepare(&path, viewport);
        let culled =
            Settings { threads: 1, antialias: cullet::Antialias::None, ..Settings::default() };
        let whole = Settings { cull: CullTest::None, ..culled };
        let (mut renderer, mut frame) = (Renderer::default(), Frame::default());
        let mut stats = renderer.render(&prepared, &view, &culled, &mut frame);
        let (mut other, mut other_frame) = (Renderer::default(), Frame::default());
        let comparison = Rounds::default().compare(
            &mut || {
                black_box(other.render(&prepared, &view, &whole, &mut other_frame));
            },
            &mut || {
                stats = black_box(renderer.render(&prepared, &view, &culled, &mut frame));
            },
        );
        let ms = |seconds: f64| format!("{:.1}", 1e3 * seconds);
        let stages = stats.stages;
        table.push([
            path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            ms(comparison.b.median),
            format!("{:.0}%", 100.0 * comparison.b.spread()),
            ms(stages.geometry.as_secs_f64()),
            ms(stages.raster.as_secs_f64()),
            ms(stages.shade.as_secs_f64()),
            ms(stages.resolve.as_secs_f64()),
            format!("{:.2}", comparison.ratios.median),
        ]);
    }
    println!("{table}");
}
