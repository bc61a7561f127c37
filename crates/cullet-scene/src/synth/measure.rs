//! Scenes to measure with: what is in them can be told from their parameter.

use glam::{DAffine3, DVec3, Vec3};

use super::build::{Builder, at, looking, scaled};
use super::shapes::{self, cuboid, flat, quad};
use crate::{Lens, Mesh, Scene};

/// `n` cubed unit boxes, 2 units apart, centred on the origin; they share one mesh.
pub(super) fn box_grid(n: u32) -> Scene {
    let mut builder = Builder::new("box-grid");
    let drawn = (builder.mesh("box", cuboid([0.5; 3], 0.0)), builder.plain("grey", [0.6; 3]));
    let place = |k: u32| 2.0 * f64::from(k) - f64::from(n - 1);
    for z in 0..n {
        for y in 0..n {
            for x in 0..n {
                let local = at(place(x), place(y), place(z));
                builder.place(&format!("box {x} {y} {z}"), None, local, drawn);
            }
        }
    }
    let size = f64::from(n);
    builder.look([1.6 * size, 1.3 * size, 2.6 * size], [0.0; 3], 45.0);
    builder.finish()
}

/// One unit sphere, smooth.
pub(super) fn sphere(n_around: u32) -> Scene {
    let mut builder = Builder::new("sphere");
    let material = builder.plain("clay", [0.7, 0.45, 0.3]);
    builder.single("sphere", DAffine3::IDENTITY, shapes::sphere(n_around), material);
    builder.look([0.0, 0.8, 3.2], [0.0; 3], 45.0);
    builder.finish()
}

/// A fan of `n` needles around the origin, radius 1, and beside it level strips of
/// thickness 1/2, 1/4, ... 1/512 of a pixel, as seen 512 pixels high.
pub(super) fn slivers(n: u32) -> Scene {
    let mut builder = Builder::new("slivers");
    let mut fan = shapes::lathe(&[[1.0, 0.0], [0.0, 0.0]], n.max(3), glam::Vec2::ONE);
    for position in &mut fan.positions {
        *position = Vec3::new(position.x, -position.z, 0.0);
    }
    let blue = builder.plain("blue", [0.1, 0.25, 0.7]);
    builder.single("fan", at(-0.25, 0.0, 0.0), plain(fan), blue);
    let red = builder.plain("red", [0.8, 0.1, 0.05]);
    let strip = builder.mesh("strip", plain(quad()));
    for k in 1..=9 {
        let pixel = 2.0 / 512.0;
        let thickness = pixel / f64::from(1 << k);
        let local = at(1.25, 0.8 - 0.1 * f64::from(k), 0.0) * scaled(0.4, 0.5 * thickness, 1.0);
        builder.place(&format!("strip 1/{}", 1 << k), None, local, (strip, red));
    }
    let lens = Lens::Orthographic { xmag: 16.0 / 9.0, ymag: 1.0, near: 0.0, far: 2.0 };
    builder.camera(None, at(0.0, 0.0, 1.0), lens);
    builder.finish()
}

/// A few boxes and the camera, all below one node that is moved by `(distance, 0, -distance)`.
///
/// Every number below that node is a multiple of 1/16, so that all sums are exact in f64
/// up to a distance of 2^48 and the picture must not depend on the distance.
pub(super) fn far_away(distance: f64) -> Scene {
    let mut builder = Builder::new("far-away");
    let root = builder.node("far away", None, at(distance, 0.0, -distance));
    let shape = builder.mesh("box", cuboid([0.5; 3], 0.0));
    let colors = [[0.8, 0.2, 0.1], [0.1, 0.5, 0.2], [0.1, 0.3, 0.8], [0.8, 0.7, 0.2]];
    for (k, color) in colors.into_iter().enumerate() {
        let material = builder.plain(&format!("paint {k}"), color);
        for j in 0..4 {
            let (x, z) = (1.5 * k as f64 - 2.25, -1.5 * f64::from(j));
            let local = at(x, 0.25 * f64::from(j), z);
            builder.place(&format!("box {k} {j}"), Some(root), local, (shape, material));
        }
    }
    let eye = DVec3::new(0.0, 0.75, 6.0);
    let local = looking(eye, DVec3::new(0.0, 0.75, 0.0));
    let lens = Lens::Perspective { yfov: 0.75, aspect: None, near: 0.0625, far: f64::INFINITY };
    builder.camera(Some(root), local, lens);
    builder.finish()
}

/// `n` by `n` cells that fill the view; cell (i, j), counted from the lower left, is
/// covered in its lower left corner: `(i+1)/n` of its width, `(j+1)/n` of its height.
///
/// A square picture whose side is a multiple of `n * n` sees these fractions of its pixels
/// exactly when `n` is a power of two; all in all `(n+1)^2 / (4 n^2)` of them are covered.
pub(super) fn tiles(n: u32) -> Scene {
    let mut builder = Builder::new("tiles");
    let unit = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    let drawn = (builder.mesh("tile", unit), builder.plain("white", [1.0; 3]));
    let cell = 2.0 / f64::from(n);
    for j in 0..n {
        for i in 0..n {
            let corner = at(cell * f64::from(i) - 1.0, cell * f64::from(j) - 1.0, 0.0);
            let part = |k: u32| cell * f64::from(k + 1) / f64::from(n);
            let local = corner * scaled(part(i), part(j), 1.0);
            builder.place(&format!("tile {i} {j}"), None, local, drawn);
        }
    }
    let lens = Lens::Orthographic { xmag: 1.0, ymag: 1.0, near: 0.0, far: 2.0 };
    builder.camera(None, at(0.0, 0.0, 1.0), lens);
    builder.finish()
}

/// Positions and triangles only.
fn plain(mesh: Mesh) -> Mesh {
    Mesh { uvs: [None, None], ..flat(mesh) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_the_fraction_they_promise() {
        for n in [1, 2, 8] {
            let scene = tiles(n);
            let area = |object: &crate::Object| object.world_from_model.matrix3.determinant();
            let covered: f64 = scene.objects.iter().map(area).sum::<f64>() / 4.0;
            let n = f64::from(n);
            assert_eq!(covered, (n + 1.0) * (n + 1.0) / (4.0 * n * n));
        }
    }

    #[test]
    fn a_far_scene_is_a_near_scene_moved() {
        let (near, far) = (far_away(0.0), far_away(134_217_728.0));
        let moved = DVec3::new(134_217_728.0, 0.0, -134_217_728.0);
        for (a, b) in near.objects.iter().zip(&far.objects) {
            assert_eq!(a.world_from_model.translation + moved, b.world_from_model.translation);
        }
        let eyes = [&near, &far].map(|scene| scene.cameras[0].world_from_camera.translation);
        assert_eq!(eyes[0] + moved, eyes[1]);
    }

    #[test]
    fn counts_follow_the_parameter() {
        assert_eq!(box_grid(3).objects.len(), 27);
        assert_eq!(slivers(720).meshes[0].triangles.len(), 720);
        assert_eq!(sphere(64).meshes[0].triangles.len(), 64 * 32 * 2 - 2 * 64);
    }
}
