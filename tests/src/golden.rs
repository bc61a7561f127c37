//! Golden pictures: what the shipped scenes look like, kept as small PNG files.
//!
//! Compared as decoded pixels, never as files, since an encoder may change its bytes.

use std::path::{Path, PathBuf};

use cullet::{Antialias, Frame, Settings, frame_scene};

use crate::{own_cameras, prepare_file, render, root, shipped_scenes};

/// Golden pictures are this large: small enough to keep many, large enough to see.
pub const SIZE: [u32; 2] = [320, 180];

/// How far a channel may be off, in 8-bit codes. Zero: the same bytes on every machine is the
/// promise; a change of rounding anywhere is to be looked at and blessed.
pub const TOLERANCE: u8 = 0;

/// One golden picture.
#[derive(Clone, Debug)]
pub struct Golden {
    /// File name without extension.
    pub name: String,
    scene: PathBuf,
    own_camera: bool,
}

/// Every golden picture: each shipped scene from its own camera and framed automatically.
pub fn all() -> Vec<Golden> {
    let scenes = shipped_scenes().into_iter();
    let goldens = scenes.flat_map(|scene| {
        let name = scene.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        [("own", true), ("auto", false)].map(|(suffix, own_camera)| Golden {
            name: format!("{name}.{suffix}"),
            scene: scene.clone(),
            own_camera,
        })
    });
    goldens.collect()
}

impl Golden {
    /// Where the picture is kept.
    pub fn path(&self) -> PathBuf {
        root().join("tests/golden").join(format!("{}.png", self.name))
    }

    /// Where a picture that differs is left to be looked at.
    pub fn actual_path(&self) -> PathBuf {
        root().join("out").join(format!("{}.actual.png", self.name))
    }

    /// Draws it, with the default settings until presets exist.
    pub fn render(&self) -> Frame {
        let prepared = prepare_file(&self.scene);
        let aspect = f64::from(SIZE[0]) / f64::from(SIZE[1]);
        let own = own_cameras(&prepared).into_iter().next().filter(|_| self.own_camera);
        let camera = own.unwrap_or_else(|| frame_scene(&prepared, aspect));
        render(
            &prepared,
            &camera,
            SIZE,
            &Settings { antialias: Antialias::None, ..Settings::default() },
        )
    }
}

/// Writes the colours of a frame.
pub fn save(frame: &Frame, path: &Path) {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).expect("a folder that can be made");
    }
    let rgb: Vec<u8> = frame.rgba8.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
    image::save_buffer(path, &rgb, frame.width, frame.height, image::ColorType::Rgb8)
        .unwrap_or_else(|e| panic!("{}: {e}", path.display()));
}
