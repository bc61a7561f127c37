//! Spheres from 8 to 64 segments: what flat and smooth shading make of the same shape.

use glam::Vec3;

use super::build::{Builder, at, scaled};
use super::shapes::{flat, floor, sphere};
use super::textures;
use crate::Scene;

pub(super) fn build() -> Scene {
    let mut builder = Builder::new("spheres");
    let clay = builder.plain("clay", [0.72, 0.42, 0.26]);
    let squares = [Vec3::new(0.88, 0.86, 0.80), Vec3::new(0.20, 0.34, 0.52)];
    let checker = builder.textured("checker", textures::checker(64, 8, squares));
    for (k, n_around) in [8, 12, 16, 24, 32, 48, 64].into_iter().enumerate() {
        let x = 2.3 * (k as f64 - 3.0);
        let smooth = builder.mesh(&format!("sphere {n_around}"), sphere(n_around));
        let faceted = builder.mesh(&format!("flat sphere {n_around}"), flat(sphere(n_around)));
        for (name, y, drawn) in [
            ("flat", 4.7, (faceted, clay)),
            ("smooth", 2.4, (smooth, clay)),
            ("textured", 0.1, (smooth, checker)),
        ] {
            builder.place(&format!("{name} {n_around}"), None, at(x, y, 0.0), drawn);
        }
    }
    let squares = [Vec3::splat(0.62), Vec3::splat(0.55)];
    let ground = builder.textured("ground", textures::checker(32, 4, squares));
    builder.single("ground", at(0.0, -0.95, 0.0) * scaled(14.0, 1.0, 14.0), floor(8, 7.0), ground);
    builder.look([0.0, 4.2, 16.0], [0.0, 2.2, 0.0], 34.0);
    builder.finish()
}
