//! A frame like one drawn before takes no memory: everything it needs is in the renderer and the
//! frame already.
//!
//! Counted on the thread that draws, by an allocator that counts for this test program alone. One
//! thread: starting threads is the system's business.

use allocation_counter::measure;
use cullet::{Frame, Renderer, Settings, View, Viewport};
use cullet_tests::{all_passes, cameras, prepare_file, shipped_scenes};

/// Allocations of the frames after each view has been drawn once.
fn allocations(settings: &Settings) -> Vec<(String, u64, u64)> {
    let viewport = Viewport::new(200, 120).unwrap();
    let count = |path: &std::path::PathBuf| {
        let prepared = prepare_file(path);
        let cameras = cameras(&prepared);
        let views: Vec<_> = cameras.iter().map(|camera| View::new(camera, viewport)).collect();
        let (mut renderer, mut frame) = (Renderer::default(), Frame::default());
        let mut draw_all = || {
            for view in &views {
                renderer.render(&prepared, view, settings, &mut frame);
            }
        };
        draw_all();
        let info = measure(draw_all);
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        (name, info.count_total, info.bytes_total)
    };
    shipped_scenes().iter().map(count).collect()
}

#[track_caller]
fn check(settings: &Settings) {
    let counted = allocations(settings);
    let some: Vec<_> = counted.iter().filter(|(_, count, _)| *count > 0).collect();
    assert!(some.is_empty(), "(scene, allocations, bytes): {some:?}");
}

#[test]
fn a_warmed_up_frame_allocates_nothing() {
    check(&Settings { threads: 1, ..Settings::default() });
}

#[test]
fn nor_does_one_with_every_pass() {
    check(&Settings { threads: 1, passes: all_passes(), ..Settings::default() });
}

#[test]
fn a_first_frame_is_counted() {
    let prepared = prepare_file(&shipped_scenes()[0]);
    let camera = cameras(&prepared).swap_remove(0);
    let view = View::new(&camera, Viewport::new(200, 120).unwrap());
    let settings = Settings { threads: 1, ..Settings::default() };
    let info = measure(|| {
        Renderer::default().render(&prepared, &view, &settings, &mut Frame::default());
    });
    assert!(info.bytes_total >= 200 * 120 * 4, "{info:?}");
}
