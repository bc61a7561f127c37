//! Lenses, distances, places and scales at their ends (numerics 4, items 6 to 8).

use glam::DVec3;

use super::super::build::{Builder, at, scaled};
use super::super::measure::far_away;
use super::super::shapes::{self, cuboid, quad};
use super::{lens, look};
use crate::Scene;

const INF: f64 = f64::INFINITY;

/// A ball on a box, seen through a keyhole from 100 thousand units away.
pub fn narrow(ordinary: bool) -> Scene {
    let mut builder = Builder::new("extreme");
    let (degrees, distance) = if ordinary { (45.0, 2.2) } else { (1e-3, 1e5) };
    let clay = builder.plain("clay", [0.7, 0.45, 0.3]);
    let grey = builder.plain("grey", [0.6; 3]);
    builder.single("ball", at(0.0, 0.25, 0.0) * scaled(0.35, 0.35, 0.35), shapes::sphere(32), clay);
    builder.single("box", at(0.0, -0.35, 0.0), cuboid([0.5, 0.25, 0.5], 0.0), grey);
    let eye = DVec3::new(0.3, 0.4, 1.0).normalize() * distance;
    look(&mut builder, eye.to_array(), [0.0; 3], lens(degrees, 0.1, INF));
    builder.finish()
}

/// Boxes side by side in a plane at distance 1; the picture is 23 thousand units high there.
pub fn wide(ordinary: bool) -> Scene {
    let mut builder = Builder::new("extreme");
    let half_height = |degrees: f64| libm::tan(0.5 * degrees.to_radians());
    let degrees = if ordinary { 60.0 } else { 179.99 };
    let unit = 1000.0 * half_height(degrees) / half_height(179.99);
    let colors = [[0.8, 0.2, 0.1], [0.1, 0.5, 0.2], [0.1, 0.3, 0.8], [0.8, 0.7, 0.2]];
    let paints = colors.map(|color| builder.plain("paint", color));
    let shape = builder.mesh("box", cuboid([0.5; 3], 0.0));
    for row in -5..=5_i32 {
        for column in -9..=9_i32 {
            let place = at(2.0 * f64::from(column) * unit, 2.0 * f64::from(row) * unit, -1.25);
            let local = place * scaled(1.2 * unit, 1.2 * unit, 0.5);
            let paint = paints[(row + 2 * column).rem_euclid(4) as usize];
            builder.place(&format!("box {row} {column}"), None, local, (shape, paint));
        }
    }
    look(&mut builder, [0.0; 3], [0.0, 0.0, -1.0], lens(degrees, 0.1, INF));
    builder.finish()
}

/// A row of spheres that look alike, each a thousand to a million times farther than the one
/// before.
pub fn far(ordinary: bool) -> Scene {
    let mut builder = Builder::new("extreme");
    let shape = builder.mesh("sphere", shapes::sphere(32));
    for (k, exponent) in [-3, 0, 3, 6, 12, 18, 24, 30].into_iter().enumerate() {
        let distance =
            if ordinary { 2.0 + 0.1 * k as f64 } else { libm::exp10(f64::from(exponent)) };
        let (x, y) = (0.4 * (k % 4) as f64 - 0.6, 0.22 - 0.44 * (k / 4) as f64);
        let tone = k as f32 / 8.0;
        let paint = builder.plain(&format!("paint {k}"), [0.2 + 0.7 * tone, 0.5, 0.8 - 0.7 * tone]);
        let local = at(x * distance, y * distance, -distance)
            * scaled(0.16 * distance, 0.16 * distance, 0.16 * distance);
        builder.place(&format!("sphere at 1e{exponent}"), None, local, (shape, paint));
    }
    let near = if ordinary { 0.1 } else { 1e-6 };
    look(&mut builder, [0.0; 3], [0.0, 0.0, -1.0], lens(50.0, near, INF));
    builder.finish()
}

/// Pairs of squares, green before red: no red may be seen but at the border.
pub fn depth(ordinary: bool) -> Scene {
    let mut builder = Builder::new("extreme");
    let green = builder.plain("green", [0.1, 0.6, 0.15]);
    let red = builder.plain("red", [1.0, 0.0, 0.0]);
    let square = builder.mesh("square", quad());
    for (k, exponent) in [0, 2, 4, 6, 8, 9, 10, 11].into_iter().enumerate() {
        let (distance, apart) = match ordinary {
            true => (2.0 + 0.1 * k as f64, 0.01),
            false => (libm::exp10(f64::from(exponent)), 3e-7),
        };
        let (x, y) = (0.4 * (k % 4) as f64 - 0.6, 0.22 - 0.44 * (k / 4) as f64);
        for (name, distance, size, paint) in
            [("red", distance * (1.0 + apart), 0.17, red), ("green", distance, 0.16, green)]
        {
            let local = at(x * distance, y * distance, -distance)
                * scaled(size * distance, size * distance, 1.0);
            builder.place(&format!("{name} at 1e{exponent}"), None, local, (square, paint));
        }
    }
    let (near, far) = if ordinary { (0.1, INF) } else { (1e-6, 1e12) };
    look(&mut builder, [0.0; 3], [0.0, 0.0, -1.0], lens(50.0, near, far));
    builder.finish()
}

/// Moved so far that f32 has no fractions left; the twin is not moved.
pub fn offset(ordinary: bool) -> Scene {
    far_away(if ordinary { 0.0 } else { 134_217_728.0 })
}

/// Boxes in a node that scales up in one that scales down.
pub fn nested_scales(ordinary: bool) -> Scene {
    let mut builder = Builder::new("extreme");
    let scale = if ordinary { 1.0 } else { 1_048_576.0 };
    let down = 1.0 / scale;
    let outer = builder.node("down", None, scaled(down, down, down));
    let inner = builder.node("up", Some(outer), scaled(scale, scale, scale));
    let shape = builder.mesh("box", cuboid([0.5; 3], 0.0));
    let colors = [[0.8, 0.2, 0.1], [0.1, 0.5, 0.2], [0.1, 0.3, 0.8]];
    for (k, color) in colors.into_iter().enumerate() {
        let paint = builder.plain(&format!("paint {k}"), color);
        for j in 0..3 {
            let local = at(1.5 * k as f64 - 1.5, 0.25 * f64::from(j), -1.5 * f64::from(j));
            builder.place(&format!("box {k} {j}"), Some(inner), local, (shape, paint));
        }
    }
    look(&mut builder, [2.0, 2.5, 4.5], [0.0, 0.0, -1.0], lens(45.0, 0.05, INF));
    builder.finish()
}
