//! Camera files, as far as benches need them (`cullet render --camera` reads all of them).

use std::path::Path;

use cullet::{Camera, Projection, Viewport};
use glam::{DQuat, DVec3};

/// A perspective camera of a file; panics where the file is none.
#[derive(Clone, Copy, Debug)]
pub struct CameraFile {
    /// In world space.
    pub eye: DVec3,
    /// A point that it looks at.
    pub target: DVec3,
    /// Up, any length.
    pub up: DVec3,
    lens: Projection,
    /// What it is a picture of.
    pub viewport: Viewport,
}

impl CameraFile {
    /// Reads `path`.
    pub fn read(path: &Path) -> CameraFile {
        let text = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let json: serde_json::Value = serde_json::from_slice(&text).expect("JSON");
        let number = |name: &str| json[name].as_f64();
        let vector = |name: &str| {
            DVec3::from_array([0, 1, 2].map(|i| json[name][i].as_f64().expect("a number")))
        };
        let side = |name: &str, default| number(name).map_or(default, |n| n as u32);
        CameraFile {
            eye: vector("eye"),
            target: vector("target"),
            up: vector("up"),
            lens: Projection::Perspective {
                yfov: number("yfov_deg").expect("a field of view").to_radians(),
                near: number("znear").expect("a near distance"),
                far: number("zfar").unwrap_or(f64::INFINITY),
            },
            viewport: Viewport::new(side("width", 1280), side("height", 720))
                .expect("a possible size"),
        }
    }

    /// The camera, turned to the left by `degrees` about its up vector.
    pub fn turned(&self, degrees: f64) -> Camera {
        let turn = DQuat::from_axis_angle(self.up.normalize(), degrees.to_radians());
        let target = self.eye + turn * (self.target - self.eye);
        Camera::look_at(self.eye, target, self.up, self.lens).expect("a possible camera")
    }
}
