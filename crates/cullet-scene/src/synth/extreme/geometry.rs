//! Triangles that are no numbers, go through the eye, never end, have no area or share a plane
//! (numerics 4, items 1 to 4 and 10).

use glam::{DAffine3, Vec3};

use super::super::build::{Builder, at, scaled};
use super::super::shapes::{self, quad, sincos};
use super::{double_sided, lens, look};
use crate::{Lens, Mesh, Scene};

const INF: f64 = f64::INFINITY;

fn triangle(corners: [[f32; 3]; 3]) -> Mesh {
    let positions = corners.map(Vec3::from).to_vec();
    Mesh { positions, triangles: vec![[0, 1, 2]], ..Mesh::default() }
}

/// A sphere with bad vertices: the triangles around them are missing, and nothing else.
pub fn not_a_number(ordinary: bool) -> Scene {
    let mut builder = Builder::new("extreme");
    let clay = builder.plain("clay", [0.7, 0.45, 0.3]);
    let mut sphere = shapes::sphere(64);
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY].into_iter().cycle();
    if !ordinary {
        for (i, (position, bad)) in sphere.positions.iter_mut().step_by(40).zip(bad).enumerate() {
            position[i % 3] = bad;
        }
    }
    builder.single("sphere", DAffine3::IDENTITY, sphere, clay);
    look(&mut builder, [0.0, 0.8, 3.2], [0.0; 3], lens(45.0, 0.05, INF));
    builder.finish()
}

/// Twelve strips around the view axis, from 40 behind the eye to 40 in front of it, and a
/// triangle with a corner in the eye.
pub fn through_the_eye(ordinary: bool) -> Scene {
    let mut builder = Builder::new("extreme");
    let begin = if ordinary { -0.5 } else { 40.0 };
    let colors = [[0.8, 0.2, 0.1], [0.2, 0.5, 0.8], [0.8, 0.7, 0.2]];
    let paints = colors.map(|color| double_sided(&mut builder, "paint", color));
    for k in 0..12 {
        let corner = |step: f64, z: f32| {
            let (sin, cos) = sincos((f64::from(k) + step) * std::f64::consts::TAU / 12.0);
            Vec3::new(cos as f32, sin as f32, z)
        };
        let strip = Mesh {
            positions: vec![
                corner(0.0, begin),
                corner(0.6, begin),
                corner(0.6, -40.0),
                corner(0.0, -40.0),
            ],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        };
        builder.single(&format!("strip {k}"), DAffine3::IDENTITY, strip, paints[k as usize % 3]);
    }
    let white = double_sided(&mut builder, "white", [0.9; 3]);
    let tip = if ordinary { [0.0, -0.01, -0.06] } else { [0.0; 3] };
    let wedge = triangle([tip, [-0.4, -0.8, -4.0], [0.4, -0.8, -4.0]]);
    builder.single("wedge", DAffine3::IDENTITY, wedge, white);
    look(&mut builder, [0.0; 3], [0.0, 0.0, -1.0], lens(70.0, 0.05, INF));
    builder.finish()
}

/// A ground of one triangle, each corner behind the eye or beyond the far plane.
pub fn ground(ordinary: bool) -> Scene {
    let mut builder = Builder::new("extreme");
    let green = double_sided(&mut builder, "green", [0.25, 0.45, 0.2]);
    let corners = match ordinary {
        true => [[-250.0, 0.0, -100.0], [0.0; 3], [250.0, 0.0, -100.0]],
        false => [[-2e9, 0.0, -1e9], [1e8, 0.0, 3e9], [2.5e9, 0.0, -1.2e9]],
    };
    let plane = triangle(corners);
    builder.single("ground", DAffine3::IDENTITY, plane, green);
    let grey = builder.plain("grey", [0.6; 3]);
    let post = builder.mesh("post", shapes::cuboid([0.2, 1.0, 0.2], 0.0));
    for k in 0..8 {
        let x = if k % 2 == 0 { -2.5 } else { 2.5 };
        let local = at(x, 1.0, -5.0 - 6.0 * f64::from(k / 2));
        builder.place(&format!("post {k}"), None, local, (post, grey));
    }
    let far = if ordinary { 1e4 } else { 100.0 };
    look(&mut builder, [0.0, 1.7, 0.0], [0.0, 1.4, -5.0], lens(60.0, 0.1, far));
    builder.finish()
}

/// Needles from 2 px down to 1/180 px wide at the tip (as seen 512 pixels high) and, red, what has
/// no area at all: one corner twice. (What merely lies on a line may have area after the snap.)
pub fn no_area(ordinary: bool) -> Scene {
    let mut builder = Builder::new("extreme");
    let blue = double_sided(&mut builder, "blue", [0.1, 0.25, 0.7]);
    let red = double_sided(&mut builder, "red", [1.0, 0.0, 0.0]);
    let (mut needles, mut flat) = (Mesh::default(), Mesh::default());
    for k in 0..360_u32 {
        let (sin, cos) = sincos(f64::from(k) * std::f64::consts::TAU / 360.0);
        let (sin, cos) = (sin as f32, cos as f32);
        let width = if ordinary { 0.008 } else { 2.0 / 512.0 * (k + 1) as f32 / 360.0 };
        let (tip, side) = (Vec3::new(cos, sin, 0.0) * 0.9, Vec3::new(-sin, cos, 0.0) * width);
        let first = 3 * k;
        needles.positions.extend([Vec3::ZERO, tip - side, tip + side]);
        needles.triangles.push([first, first + 1, first + 2]);
        let off = if ordinary { side } else { Vec3::ZERO };
        flat.positions.extend([tip * 0.3, tip * 1.05, tip * 0.3 + off]);
        flat.triangles.push([first, first + 1, first + 2]);
    }
    builder.single("needles", at(0.0, 0.0, -1.0), needles, blue);
    builder.single("no area", at(0.0, 0.0, -0.5), flat, red);
    let lens = Lens::Orthographic { xmag: 16.0 / 9.0, ymag: 1.0, near: 0.0, far: 2.0 };
    builder.camera(None, DAffine3::IDENTITY, lens);
    builder.finish()
}

/// Three triangles whose corners are up to 1e9 px and 3e38 units away; each ends on a line through
/// the picture.
pub fn huge(ordinary: bool) -> Scene {
    let mut builder = Builder::new("extreme");
    let reach = |extreme: f32| if ordinary { 3.0 } else { extreme };
    let corners =
        |r: f32, z: f32| triangle([[-r, -0.5 * r, z], [r, -0.5 * r, z], [0.0, 0.5 * r, z]]);
    let colors = [[0.8, 0.2, 0.1], [0.2, 0.6, 0.2], [0.1, 0.3, 0.8]];
    for (k, (color, reach)) in colors.into_iter().zip([1e5, 2e9, 3e38].map(reach)).enumerate() {
        let paint = double_sided(&mut builder, &format!("paint {k}"), color);
        let degrees = 120.0 * k as f64;
        // Its upper corner is brought down to the middle of the picture, then it is turned.
        let mesh = corners(reach, 0.0);
        let lowered = Mesh {
            positions: mesh
                .positions
                .iter()
                .map(|p| Vec3::new(p.x, p.y - 0.5 * reach, 0.0))
                .collect(),
            ..mesh
        };
        let turn = DAffine3::from_rotation_z(degrees.to_radians());
        builder.single(&format!("triangle {k}"), at(0.0, 0.0, -1.0) * turn, lowered, paint);
    }
    look(&mut builder, [0.0; 3], [0.0, 0.0, -1.0], lens(60.0, 0.1, INF));
    builder.finish()
}

/// Squares that lie in one plane and overlap, before a wall: red is first in the scene, blue last.
pub fn ties(ordinary: bool) -> Scene {
    let mut builder = Builder::new("extreme");
    let names = ["red", "green", "blue"];
    let colors = [[0.8, 0.1, 0.05], [0.1, 0.6, 0.15], [0.1, 0.2, 0.8]];
    let paints: Vec<usize> =
        names.into_iter().zip(colors).map(|(name, color)| builder.plain(name, color)).collect();
    let square = builder.mesh("square", quad());
    for (k, (name, paint)) in names.into_iter().zip(paints).enumerate() {
        let step = k as f64;
        let apart = if ordinary { -0.1 * step } else { 0.0 };
        let local = at(0.5 * step - 0.5, 0.35 - 0.35 * step, apart) * scaled(0.6, 0.6, 1.0);
        builder.place(name, None, local, (square, paint));
    }
    let grey = builder.plain("grey", [0.5; 3]);
    builder.place("wall", None, at(0.0, 0.0, -3.0) * scaled(6.0, 4.0, 1.0), (square, grey));
    look(&mut builder, [0.0, 0.0, 2.6], [0.0; 3], lens(45.0, 0.05, INF));
    builder.finish()
}
