//! What the whole-pipeline tests share: where scenes are, how cameras stand around them.

use std::path::{Path, PathBuf};

use cullet::scene::{LoadOptions, Scene, load, synth};
use cullet::{
    Camera, Frame, Pass, Passes, Prepared, Projection, Renderer, Settings, View, Viewport,
    camera_of,
};
use glam::DVec3;

pub mod golden;

/// The root of the repository.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The folder of real models beside the repository, or `None` (and a line that says so) where
/// there is none.
pub fn real_models() -> Option<PathBuf> {
    let folder = root().join("../shared/assets");
    if folder.join("MANIFEST.json").is_file() {
        return Some(folder);
    }
    eprintln!("skipped: no folder of real models beside the repository");
    None
}

/// The scenes this project ships, sorted by name.
pub fn shipped_scenes() -> Vec<PathBuf> {
    let folder = root().join("scenes");
    let entries = std::fs::read_dir(&folder).expect("the folder scenes/ is there");
    let mut scenes: Vec<_> = entries
        .map(|entry| entry.expect("a readable entry").path())
        .filter(|path| path.extension().is_some_and(|e| e == "glb"))
        .collect();
    scenes.sort();
    assert!(scenes.len() >= 5, "{} holds {} scenes", folder.display(), scenes.len());
    scenes
}

/// Loads and prepares a file.
#[track_caller]
pub fn prepare_file(path: &Path) -> Prepared {
    let scene = load(path, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    prepare(scene)
}

/// Prepares a scene.
#[track_caller]
pub fn prepare(scene: Scene) -> Prepared {
    Prepared::new(scene).unwrap_or_else(|e| panic!("{e}"))
}

/// Prepares a synthetic scene.
#[track_caller]
pub fn prepare_synth(spec: &str) -> Prepared {
    prepare(synth::synth(spec).unwrap_or_else(|e| panic!("{e}")))
}

/// The cameras that the scene brings.
pub fn own_cameras(prepared: &Prepared) -> Vec<Camera> {
    let cameras = prepared.scene().cameras.iter().map(camera_of);
    cameras.collect::<Result<_, _>>().expect("possible cameras")
}

/// Cameras for a scene: its own, four around it, two from the middle of it, one of those
/// rolled with a finite far plane, and one orthographic. Eight or more.
pub fn cameras(prepared: &Prepared) -> Vec<Camera> {
    let mut cameras: Vec<_> = own_cameras(prepared);
    let bounds = prepared.bounds();
    let (middle, radius) = (bounds.center(), bounds.half_extent().length().max(1e-3));
    let lens = Projection::Perspective { yfov: 0.8, near: 0.002 * radius, far: f64::INFINITY };
    let mut look = |eye: DVec3, target: DVec3, up: DVec3, lens| {
        cameras.push(Camera::look_at(eye, target, up, lens).expect("a possible camera"));
    };
    for direction in [[0.9, 0.3, 1.1], [-1.3, 0.7, 0.2], [0.1, 1.5, -0.3], [0.5, -0.4, -1.2]] {
        look(middle + DVec3::from_array(direction) * radius, middle, DVec3::Y, lens);
    }
    look(middle, middle + DVec3::new(1.0, 0.1, 0.3), DVec3::Y, lens);
    let short = Projection::Perspective { yfov: 1.7, near: 0.01 * radius, far: 0.6 * radius };
    let aside = middle + DVec3::new(0.1, 0.05, -0.2) * radius;
    look(aside, middle - DVec3::Z * radius, DVec3::new(0.4, 1.0, 0.1), short);
    let flat = Projection::Orthographic { height: radius, near: 0.0, far: 4.0 * radius };
    look(middle + DVec3::new(1.0, 1.0, 1.0) * radius, middle, DVec3::Y, flat);
    look(middle + DVec3::new(0.2, 0.1, 0.9) * radius, middle, DVec3::Y, short);
    cameras
}

/// Every pass at once.
pub fn all_passes() -> Passes {
    Pass::ALL.into_iter().collect()
}

/// One frame.
pub fn render(prepared: &Prepared, camera: &Camera, size: [u32; 2], settings: &Settings) -> Frame {
    let viewport = Viewport::new(size[0], size[1]).expect("a possible size");
    let mut frame = Frame::default();
    let view = View::new(camera, viewport);
    Renderer::default().render(prepared, &view, settings, &mut frame);
    frame
}

/// All bytes of a frame, to compare two frames exactly (NaN equals NaN).
pub fn bytes(frame: &Frame) -> Vec<u8> {
    let mut bytes = Vec::new();
    bytes.extend(frame.width.to_le_bytes());
    bytes.extend(frame.height.to_le_bytes());
    bytes.extend(frame.rgba8.as_flattened());
    let mut floats = |values: &mut dyn Iterator<Item = f32>| {
        bytes.extend(values.flat_map(f32::to_le_bytes));
    };
    floats(&mut frame.linear.iter().flat_map(|v| v.to_array()));
    floats(&mut frame.depth.iter().copied());
    floats(&mut frame.normal.iter().flat_map(|v| v.to_array()));
    floats(&mut frame.albedo.iter().flat_map(|v| v.to_array()));
    floats(&mut frame.uv.iter().flat_map(|v| v.to_array()));
    floats(&mut frame.position.iter().flat_map(|v| v.to_array()));
    bytes.extend(frame.id.iter().chain(&frame.triangle).flat_map(|v| v.to_le_bytes()));
    bytes
}

/// A small generator of random numbers (xorshift64*, Vigna 2016), the same everywhere.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// Starts from `seed`.
    pub fn new(seed: u64) -> Self {
        Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    /// In `0.0..1.0`.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// In `low..high`.
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// In `low..=high`.
    pub fn integer(&mut self, low: i64, high: i64) -> i64 {
        low + (self.bits() % (high - low + 1) as u64) as i64
    }
}

/// Whether the long mode was asked for: `CULLET_LONG=1 cargo test --release`.
pub fn long_mode() -> bool {
    std::env::var_os("CULLET_LONG").is_some_and(|v| v != "0")
}
