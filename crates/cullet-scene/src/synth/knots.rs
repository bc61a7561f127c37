//! Torus knots in a row: vertex colours, mirrored and unevenly scaled nodes.

use glam::{DAffine3, DMat3, DVec3, Vec3};

use super::build::{Builder, at, scaled, tilted, turned};
use super::shapes::{colored, floor, sincos, torus_knot};
use super::textures;
use crate::{Mesh, Scene};

pub(super) fn build() -> Scene {
    let mut builder = Builder::new("knots");
    let white = builder.plain("white", [1.0; 3]);
    let kinds = [((2, 3), 0.2), ((3, 4), 0.14), ((2, 5), 0.16), ((3, 5), 0.11)];
    let meshes = kinds.map(|((p, q), tube)| {
        let knot = colored(torus_knot((p, q), tube, (240, 20)), rainbow);
        builder.mesh(&format!("knot {p} {q}"), Mesh { uvs: [None, None], ..knot })
    });
    for (column, mesh) in meshes.into_iter().enumerate() {
        let x = 3.2 * column as f64 - 4.8;
        for (name, y, shape) in [
            ("plain", 5.0, DAffine3::IDENTITY),
            ("mirrored", 1.8, scaled(-1.0, 1.0, 1.0)),
            ("flattened", -1.4, scaled(1.0, 0.35, 1.0)),
            ("sheared and mirrored", -4.2, sheared()),
        ] {
            let place = at(x, y, 0.0) * tilted(70.0) * turned(20.0 * column as f64) * shape;
            builder.place(&format!("knot {column} {name}"), None, place, (mesh, white));
        }
    }
    let squares = [Vec3::splat(0.55), Vec3::splat(0.35)];
    let ground = builder.textured("ground", textures::checker(64, 8, squares));
    builder.single("ground", at(0.0, -6.0, 0.0) * scaled(16.0, 1.0, 16.0), floor(8, 4.0), ground);
    builder.look([2.0, 2.0, 19.0], [0.0, 0.2, 0.0], 42.0);
    builder.finish()
}

/// Leans over and turns inside out.
fn sheared() -> DAffine3 {
    DAffine3::from_mat3(DMat3::from_cols(
        DVec3::new(-0.9, 0.0, 0.0),
        DVec3::new(0.5, 0.8, 0.0),
        DVec3::new(0.0, 0.3, 1.0),
    ))
}

/// A smooth colour for each direction.
fn rainbow(position: Vec3) -> Vec3 {
    let wave = |phase: f64| {
        let along = f64::from(position.x) * 1.3 + f64::from(position.z) * 1.7;
        (0.45 + 0.4 * sincos(along + phase).0) as f32
    };
    Vec3::new(wave(0.0), wave(2.1), wave(4.2))
}
