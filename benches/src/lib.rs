//! Benches of Cullet: kernels, stages, frames. Timed work lives here and never in a test.
//!
//! Each bench is a binary (`cargo run --release -p cullet-benches --bin NAME`) that prints a
//! table of interleaved medians with their spread, and ratios, since absolute times belong to a
//! machine. Records worth keeping go to `benches/record/` with date, machine and command.

pub mod boxes;
pub mod camera;
pub mod depth;
pub mod growing;
pub mod memory;
pub mod peers;
pub mod plot;

use std::path::{Path, PathBuf};

use cullet::scene::{LoadOptions, load};
use cullet::{Prepared, View, Viewport, camera_of, frame_scene};

/// The scenes this project ships, sorted by name.
pub fn shipped_scenes() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    let entries = std::fs::read_dir(folder).expect("the folder scenes/");
    let mut scenes: Vec<_> = entries
        .map(|entry| entry.expect("a readable entry").path())
        .filter(|path| path.extension().is_some_and(|e| e == "glb"))
        .collect();
    scenes.sort();
    scenes
}

/// A scene and the view of its own first camera, or the automatic one.
pub fn prepare(path: &Path, viewport: Viewport) -> (Prepared, View) {
    let scene = load(path, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let prepared = Prepared::new(scene).unwrap_or_else(|e| panic!("{e}"));
    let own = prepared.scene().cameras.first();
    let own = own.map(|camera| camera_of(camera).expect("a possible camera"));
    let camera = own.unwrap_or_else(|| frame_scene(&prepared, viewport.aspect()));
    let view = View::new(&camera, viewport);
    (prepared, view)
}
