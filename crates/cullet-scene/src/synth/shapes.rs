//! Shapes to build scenes from: boxes, spheres, turned profiles, knots, height fields.
//!
//! All are in model space with y up, counter-clockwise seen from outside, with unit normals
//! and one texture coordinate set. Positions are computed in f64 with `libm` and rounded
//! once, so they are the same bits on every machine.
//!
//! Source of the knot: the (p, q) torus knot as any book on curves has it.

use std::f64::consts::TAU;

use glam::{DAffine3, DVec2, DVec3, Vec2, Vec3, Vec4};

use crate::Mesh;

/// A point of a surface and its outward unit normal.
pub(super) type Sample = (DVec3, DVec3);

/// A surface over the unit square, `n_u` by `n_v` cells of two triangles.
///
/// `du` cross `dv` must point outwards. Cells that collapse to a point or an edge, as at
/// the poles of a sphere, lose the triangles without area. `uv` are scaled by `repeat`.
pub(super) fn surface(
    (n_u, n_v): (u32, u32),
    repeat: Vec2,
    sample: impl Fn(f64, f64) -> Sample,
) -> Mesh {
    let mut mesh = empty();
    for j in 0..=n_v {
        for i in 0..=n_u {
            let (u, v) = (f64::from(i) / f64::from(n_u), f64::from(j) / f64::from(n_v));
            let (position, normal) = sample(u, v);
            let uv = repeat * DVec2::new(u, 1.0 - v).as_vec2();
            push_vertex(&mut mesh, position.as_vec3(), normal.as_vec3(), uv);
        }
    }
    for j in 0..n_v {
        for i in 0..n_u {
            let low = j * (n_u + 1) + i;
            let high = low + n_u + 1;
            push_triangle(&mut mesh, [low, low + 1, high + 1]);
            push_triangle(&mut mesh, [low, high + 1, high]);
        }
    }
    mesh
}

/// A box from `-half` to `half`. Each face shows the image once per `1 / per_unit` units,
/// or exactly once when `per_unit` is 0.
pub(super) fn cuboid(half: [f32; 3], per_unit: f32) -> Mesh {
    let half = Vec3::from(half);
    let mut mesh = empty();
    for (normal, right) in [
        (Vec3::X, Vec3::NEG_Z),
        (Vec3::NEG_X, Vec3::Z),
        (Vec3::Y, Vec3::X),
        (Vec3::NEG_Y, Vec3::X),
        (Vec3::Z, Vec3::X),
        (Vec3::NEG_Z, Vec3::NEG_X),
    ] {
        let up = normal.cross(right);
        let extent = Vec2::new((right * half).length(), (up * half).length());
        let repeat = if per_unit == 0.0 { Vec2::ONE } else { 2.0 * extent * per_unit };
        let first = mesh.positions.len() as u32;
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            let position = (normal + x * right + y * up) * half;
            let uv = repeat * Vec2::new(0.5 + 0.5 * x, 0.5 - 0.5 * y);
            push_vertex(&mut mesh, position, normal, uv);
        }
        push_triangle(&mut mesh, [first, first + 1, first + 2]);
        push_triangle(&mut mesh, [first, first + 2, first + 3]);
    }
    mesh
}

/// An upright square from (-1, -1) to (1, 1) in the plane z = 0, facing +z.
pub(super) fn quad() -> Mesh {
    surface((1, 1), Vec2::ONE, |u, v| (DVec3::new(2.0 * u - 1.0, 2.0 * v - 1.0, 0.0), DVec3::Z))
}

/// A level square of side 2 around the origin, facing up, with the image `repeat` times.
pub(super) fn floor(n_cells: u32, repeat: f32) -> Mesh {
    surface((n_cells, n_cells), Vec2::splat(repeat), |u, v| {
        (DVec3::new(2.0 * u - 1.0, 0.0, 1.0 - 2.0 * v), DVec3::Y)
    })
}

/// A unit sphere of `n_around` by `n_around / 2` cells.
pub(super) fn sphere(n_around: u32) -> Mesh {
    surface((n_around, (n_around / 2).max(2)), Vec2::new(2.0, 1.0), |u, v| {
        let (sin, cos) = sincos(v * TAU / 2.0);
        let at_pole = v == 0.0 || v == 1.0; // where the sine of pi is not quite 0
        let position = around(u, if at_pole { 0.0 } else { sin }) - cos * DVec3::Y;
        (position, position)
    })
}

/// A profile of (radius, height) points, from the bottom up, turned about the y axis.
///
/// Every stretch of the profile is a smooth band of its own; the edges between are sharp.
pub(super) fn lathe(profile: &[[f64; 2]], n_around: u32, repeat: Vec2) -> Mesh {
    let mut mesh = empty();
    for pair in profile.windows(2) {
        let (low, high) = (DVec2::from(pair[0]), DVec2::from(pair[1]));
        let along = (high - low).normalize_or_zero();
        let band = surface((n_around, 1), repeat, |u, v| {
            let here = low.lerp(high, v);
            (around(u, here.x) + here.y * DVec3::Y, around(u, along.y) - along.x * DVec3::Y)
        });
        append(&mut mesh, &band, DAffine3::IDENTITY);
    }
    mesh
}

/// An upright closed cylinder around the origin.
pub(super) fn cylinder(radius: f64, height: f64, n_around: u32, repeat: Vec2) -> Mesh {
    let (low, high) = (-0.5 * height, 0.5 * height);
    lathe(&[[0.0, low], [radius, low], [radius, high], [0.0, high]], n_around, repeat)
}

/// A tube of radius `tube` along the (p, q) torus knot of radii 1 and 0.4.
pub(super) fn torus_knot((p, q): (u32, u32), tube: f64, (n_along, n_tube): (u32, u32)) -> Mesh {
    let curve = |t: f64| {
        let (sin_q, cos_q) = sincos(f64::from(q) * t);
        around(f64::from(p) * t / TAU, 1.0 + 0.4 * cos_q) + 0.4 * sin_q * DVec3::Y
    };
    surface((n_along, n_tube), Vec2::new(f64::from(4 * p) as f32, 1.0), |u, v| {
        // One exact turn, so that the ends of the tube meet in the same bits.
        let t = if u == 1.0 { 0.0 } else { u * TAU };
        let ahead = (curve(t + 1e-4) - curve(t - 1e-4)).normalize();
        let bend = (curve(t + 1e-4) + curve(t - 1e-4)).normalize();
        let side = ahead.cross(bend).normalize();
        let out = side.cross(ahead);
        let (sin, cos) = sincos(if v == 1.0 { 0.0 } else { v * TAU });
        let normal = cos * out - sin * side;
        (curve(t) + tube * normal, normal)
    })
}

/// A terrain over the square of side 2, `height(x, z)` above it.
pub(super) fn height_field(n_cells: u32, height: impl Fn(f64, f64) -> f64) -> Mesh {
    let step = 1.0 / f64::from(n_cells);
    surface((n_cells, n_cells), Vec2::ONE, |u, v| {
        let (x, z) = (2.0 * u - 1.0, 1.0 - 2.0 * v);
        let slope_x = (height(x + step, z) - height(x - step, z)) / (2.0 * step);
        let slope_z = (height(x, z + step) - height(x, z - step)) / (2.0 * step);
        (DVec3::new(x, height(x, z), z), DVec3::new(-slope_x, 1.0, -slope_z).normalize())
    })
}

/// Adds a moved copy of `part` to `mesh`. Both must have the same attributes. The move must
/// keep handedness, and angles where there are normals.
pub(super) fn append(mesh: &mut Mesh, part: &Mesh, whole_from_part: DAffine3) {
    let first = mesh.positions.len() as u32;
    let moved = |point: &Vec3| whole_from_part.transform_point3(point.as_dvec3()).as_vec3();
    let turned = |normal: &Vec3| {
        whole_from_part.transform_vector3(normal.as_dvec3()).normalize_or_zero().as_vec3()
    };
    mesh.positions.extend(part.positions.iter().map(moved));
    if let (Some(normals), Some(more)) = (&mut mesh.normals, &part.normals) {
        normals.extend(more.iter().map(turned));
    }
    if let (Some(uvs), Some(more)) = (&mut mesh.uvs[0], &part.uvs[0]) {
        uvs.extend(more);
    }
    mesh.triangles.extend(part.triangles.iter().map(|triangle| triangle.map(|i| i + first)));
}

/// Several moved parts as one mesh, under the rules of [`append`].
pub(super) fn joined<'a>(parts: impl IntoIterator<Item = (&'a Mesh, DAffine3)>) -> Mesh {
    let mut mesh = empty();
    for (part, whole_from_part) in parts {
        append(&mut mesh, part, whole_from_part);
    }
    mesh
}

/// The mesh without normals: shaded flat.
pub(super) fn flat(mesh: Mesh) -> Mesh {
    Mesh { normals: None, ..mesh }
}

/// The mesh with a colour (linear) for each position. Colours are rounded to 8 bits, which
/// keeps written files small.
pub(super) fn colored(mesh: Mesh, color: impl Fn(Vec3) -> Vec3) -> Mesh {
    let rounded = |position: &Vec3| -> Vec4 {
        let color = (color(*position).clamp(Vec3::ZERO, Vec3::ONE) * 255.0).round() / 255.0;
        color.extend(1.0)
    };
    let colors = Some(mesh.positions.iter().map(rounded).collect());
    Mesh { colors, ..mesh }
}

/// A mesh without vertices that has normals and texture coordinates.
pub(super) fn empty() -> Mesh {
    Mesh { normals: Some(Vec::new()), uvs: [Some(Vec::new()), None], ..Mesh::default() }
}

/// Sine and cosine, the same bits on every machine.
pub(super) fn sincos(radians: f64) -> (f64, f64) {
    libm::sincos(radians)
}

/// The point `radius` from the y axis after `turns` turns from +x towards -z.
///
/// Whole turns return to the same bits, so that seams close.
fn around(turns: f64, radius: f64) -> DVec3 {
    let (sin, cos) = sincos((turns - libm::floor(turns)) * TAU);
    DVec3::new(radius * cos, 0.0, -radius * sin)
}

fn push_vertex(mesh: &mut Mesh, position: Vec3, normal: Vec3, uv: Vec2) {
    mesh.positions.push(position);
    mesh.normals.get_or_insert_default().push(normal);
    mesh.uvs[0].get_or_insert_default().push(uv);
}

fn push_triangle(mesh: &mut Mesh, corners: [u32; 3]) {
    let [a, b, c] = corners.map(|i| mesh.positions[i as usize]);
    if a != b && b != c && c != a {
        mesh.triangles.push(corners);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Six times the enclosed volume; positive when faces look outwards.
    fn volume6(mesh: &Mesh) -> f64 {
        let corner = |i: u32| mesh.positions[i as usize].as_dvec3();
        let sum = |[a, b, c]: &[u32; 3]| corner(*a).dot(corner(*b).cross(corner(*c)));
        mesh.triangles.iter().map(sum).sum()
    }

    #[track_caller]
    fn check(mesh: &Mesh, volume: f64) {
        let difference = (volume6(mesh) / 6.0 - volume).abs();
        assert!(difference < 0.02 * volume, "volume {}", volume6(mesh) / 6.0);
        let normals = mesh.normals.as_ref().unwrap();
        assert_eq!(normals.len(), mesh.positions.len());
        assert_eq!(mesh.uvs[0].as_ref().unwrap().len(), mesh.positions.len());
        assert!(normals.iter().all(|normal| (normal.length() - 1.0).abs() < 1e-5));
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
            let face = (b - a).cross(c - a);
            assert!(triangle.iter().all(|i| normals[*i as usize].dot(face) > 0.0), "{triangle:?}");
        }
    }

    #[test]
    fn shapes_face_outwards_with_normals_to_match() {
        let pi = std::f64::consts::PI;
        check(&cuboid([1.0, 2.0, 3.0], 0.0), 48.0);
        check(&sphere(64), 4.0 / 3.0 * pi);
        check(&cylinder(1.0, 2.0, 64, Vec2::ONE), 2.0 * pi);
        check(&lathe(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], 64, Vec2::ONE), pi / 3.0);
    }

    #[test]
    fn a_knot_is_closed_and_faces_outwards() {
        let knot = torus_knot((2, 3), 0.15, (256, 16));
        assert!(volume6(&knot) > 0.0);
        let mut ends = knot.positions.chunks(257).map(|row| (row[0], row[256]));
        assert!(ends.all(|(first, last)| first == last));
    }

    #[test]
    fn open_shapes_face_the_viewer() {
        let faces = |mesh: &Mesh, direction: Vec3| {
            mesh.triangles.iter().all(|triangle| {
                let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
                (b - a).cross(c - a).dot(direction) > 0.0
            })
        };
        assert!(faces(&quad(), Vec3::Z));
        assert!(faces(&floor(3, 1.0), Vec3::Y));
        assert!(faces(&height_field(4, |x, z| x * z), Vec3::Y));
    }
}
