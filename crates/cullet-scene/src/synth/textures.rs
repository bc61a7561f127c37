//! Pictures to cover shapes with, computed: brick, wood, marble, leaves, windows.
//!
//! Every picture tiles: its noise repeats at the edges. Colours are given as they are
//! stored, sRGB encoded. Few colour steps and smooth noise keep the PNG files small.

use std::f64::consts::TAU;

use glam::{DVec2, Vec3};

use super::shapes::sincos;
use crate::Image;

/// Squares of two colours, `n` by `n` of them.
pub(super) fn checker(size: u32, n: u32, colors: [Vec3; 2]) -> Image {
    paint("checker", [size, size], |at| {
        let cell = (at * f64::from(n)).floor();
        opaque(colors[((cell.x + cell.y) as usize) % 2])
    })
}

/// Bricks in running bond, 4 by 8 of them.
pub(super) fn brick(size: u32) -> Image {
    paint("brick", [size, size], |at| {
        let row = (at.y * 8.0).floor();
        let shifted = DVec2::new(at.x * 4.0 + 0.5 * (row % 2.0), at.y * 8.0);
        let (cell, inside) = (shifted.floor(), shifted.fract());
        let from_edge = (inside.x.min(1.0 - inside.x) * 2.0).min(inside.y.min(1.0 - inside.y));
        let grain = clouds(at, 16, 7);
        if from_edge < 0.07 + 0.03 * grain {
            return opaque(Vec3::new(0.70, 0.67, 0.62) - 0.1 * grain as f32);
        }
        let tone = hash(cell.x as u32 % 4, cell.y as u32, 3);
        let fired = Vec3::new(0.60, 0.28, 0.20).lerp(Vec3::new(0.74, 0.42, 0.30), tone as f32);
        opaque(fired * (0.82 + 0.3 * grain as f32))
    })
}

/// Four boards with grain along u.
pub(super) fn wood(size: u32) -> Image {
    paint("wood", [size, size], |at| {
        let board = (at.y * 4.0).floor();
        let inside = (at.y * 4.0).fract();
        let wave = clouds(DVec2::new(at.x, at.y + 0.31 * board), 4, 11 + board as u32);
        let ring = 0.5 + 0.5 * sincos(TAU * (inside * 3.0 + 2.5 * wave)).0;
        let tone = 0.85 + 0.2 * hash(board as u32, 0, 5);
        let light = Vec3::new(0.78, 0.58, 0.36);
        let dark = Vec3::new(0.52, 0.34, 0.18);
        let gap = if inside.min(1.0 - inside) < 0.03 { 0.45 } else { 1.0 };
        opaque(light.lerp(dark, (0.7 * ring * ring) as f32) * (tone * gap) as f32)
    })
}

/// White stone with dark veins.
pub(super) fn marble(size: u32) -> Image {
    paint("marble", [size, size], |at| {
        let bent = clouds(at, 4, 23) + 0.5 * clouds(at, 8, 29);
        let wave = sincos(TAU * (at.x + at.y + 1.4 * bent)).0;
        let vein = libm::pow(1.0 - wave.abs(), 5.0);
        let stone =
            Vec3::new(0.93, 0.92, 0.89).lerp(Vec3::new(0.80, 0.80, 0.81), bent as f32 * 0.5);
        opaque(stone.lerp(Vec3::new(0.30, 0.33, 0.38), 0.75 * vein as f32))
    })
}

/// Paving: 4 by 4 slabs of warm stone with joints.
pub(super) fn paving(size: u32) -> Image {
    paint("paving", [size, size], |at| {
        let (cell, inside) = ((at * 4.0).floor(), (at * 4.0).fract());
        let from_edge = inside.min(1.0 - inside).min_element();
        if from_edge < 0.025 {
            return opaque(Vec3::new(0.40, 0.37, 0.33));
        }
        let tone = hash(cell.x as u32, cell.y as u32, 17);
        let slab = Vec3::new(0.76, 0.68, 0.56).lerp(Vec3::new(0.85, 0.79, 0.69), tone as f32);
        opaque(slab * (0.88 + 0.18 * clouds(at, 16, 19)) as f32)
    })
}

/// A sky from the horizon (bottom row) to the zenith (top row), with a hint of clouds.
pub(super) fn sky(size: u32) -> Image {
    paint("sky", [size, size / 2], |at| {
        let height = 1.0 - at.y;
        let clear = Vec3::new(0.85, 0.90, 0.94).lerp(Vec3::new(0.24, 0.47, 0.78), height as f32);
        let cloud =
            (2.2 * clouds(DVec2::new(at.x, at.y * 2.0 % 1.0), 4, 37) - 1.15).clamp(0.0, 1.0);
        let fade = (height * 6.0).min(1.0) * (1.0 - height);
        opaque(clear.lerp(Vec3::splat(0.97), (cloud * fade) as f32))
    })
}

/// Four floors of eight windows, some of them lit.
pub(super) fn windows(size: u32, wall: Vec3, seed: u32) -> Image {
    paint("windows", [size, size], |at| {
        let (x, y) = (at.x * 8.0, at.y * 4.0);
        let (across, down) = (x - x.floor(), y - y.floor());
        let glass = (0.2..0.8).contains(&across) && (0.22..0.8).contains(&down);
        let frame = (across - 0.5).abs() < 0.03 || (down - 0.5).abs() < 0.02;
        if !glass || frame {
            let ledge = if down > 0.93 { 0.8 } else { 1.0 };
            return opaque(wall * ledge);
        }
        let lit = hash(x as u32, y as u32, seed);
        let day = Vec3::new(0.26, 0.34, 0.42).lerp(Vec3::new(0.50, 0.62, 0.72), 1.0 - down as f32);
        opaque(if lit > 0.86 {
            Vec3::new(0.96, 0.86, 0.58)
        } else {
            day * (0.7 + 0.4 * lit) as f32
        })
    })
}

/// A sprig of leaves on nothing: transparent around.
pub(super) fn leaves(size: u32) -> Image {
    paint("leaves", [size, size], |at| {
        let stem = (at.x - 0.5 - 0.03 * sincos(at.y * 9.0).0).abs() < 0.012 && at.y > 0.12;
        let mut best: Option<f64> = None;
        for k in 0..11 {
            let side = if k % 2 == 0 { 1.0 } else { -1.0 };
            let base = DVec2::new(0.5, 0.95 - 0.075 * f64::from(k));
            let (sin, cos) = sincos(0.5 + 0.06 * f64::from(k));
            let away = DVec2::new(side * cos, -sin);
            let from_base = at - base;
            let (along, across) = (from_base.dot(away), from_base.perp_dot(away).abs());
            let length = 0.40 - 0.018 * f64::from(k);
            let t = along / length;
            if (0.0..1.0).contains(&t) && across < 0.24 * length * sincos(TAU / 2.0 * t).0 {
                best = Some(if across < 0.006 { 1.25 } else { 0.75 + 0.04 * f64::from(k % 5) });
            }
        }
        match best {
            _ if stem => [96, 84, 40, 255],
            Some(tone) => opaque(Vec3::new(0.34, 0.52, 0.20) * tone as f32),
            None => [74, 110, 44, 0],
        }
    })
}

/// A lattice fence: holes are transparent.
pub(super) fn fence(size: u32) -> Image {
    paint("fence", [size, size], |at| {
        let bar = |t: f64| {
            let inside = (t * 4.0).rem_euclid(1.0);
            inside.min(1.0 - inside) < 0.13
        };
        let shade = 0.85 + 0.2 * clouds(at, 8, 41) as f32;
        match (bar(at.x + at.y), bar(at.x - at.y)) {
            (true, _) => opaque(Vec3::new(0.66, 0.48, 0.30) * shade),
            (_, true) => opaque(Vec3::new(0.55, 0.39, 0.24) * shade),
            _ => [140, 100, 60, 0],
        }
    })
}

/// An arrow-like mark without symmetry, to tell turned and mirrored pictures apart.
pub(super) fn mark(size: u32) -> Image {
    paint("mark", [size, size], |at| {
        let inside = at.min(1.0 - at).min_element();
        let shaft = (0.2..0.8).contains(&at.y) && (0.2..0.36).contains(&at.x);
        let foot = (0.66..0.8).contains(&at.y) && (0.2..0.75).contains(&at.x);
        let dot = at.distance(DVec2::new(0.68, 0.32)) < 0.12;
        opaque(match () {
            _ if inside < 0.04 => Vec3::new(0.42, 0.50, 0.44),
            _ if dot => Vec3::new(0.82, 0.24, 0.18),
            _ if shaft || foot => Vec3::new(0.16, 0.36, 0.62),
            _ => Vec3::new(0.93, 0.90, 0.82),
        })
    })
}

/// Smooth noise in 0..1 over the unit square, of three octaves; repeats at the edges.
pub(super) fn clouds(at: DVec2, n_cells: u32, seed: u32) -> f64 {
    let octave =
        |k: u32| lattice_noise(at, n_cells << k, seed + k) * [0.57, 0.29, 0.14][k as usize];
    octave(0) + octave(1) + octave(2)
}

/// A pseudo-random number in 0..1 for a lattice point.
pub(super) fn hash(x: u32, y: u32, seed: u32) -> f64 {
    let mut bits =
        x.wrapping_mul(0x9E37_79B1) ^ y.wrapping_mul(0x85EB_CA77) ^ seed.wrapping_mul(0xC2B2_AE3D);
    for shift in [15, 13, 16] {
        bits = (bits ^ (bits >> shift)).wrapping_mul(0x2C1B_3C6D);
    }
    f64::from(bits >> 8) / f64::from(1 << 24)
}

fn lattice_noise(at: DVec2, n_cells: u32, seed: u32) -> f64 {
    let scaled = at * f64::from(n_cells);
    let (cell, t) = (scaled.floor(), scaled - scaled.floor());
    let smooth = t * t * (3.0 - 2.0 * t);
    let wrapped = |value: f64| value.rem_euclid(f64::from(n_cells)) as u32;
    let value = |dx: f64, dy: f64| hash(wrapped(cell.x + dx), wrapped(cell.y + dy), seed);
    let low = value(0.0, 0.0) + smooth.x * (value(1.0, 0.0) - value(0.0, 0.0));
    let high = value(0.0, 1.0) + smooth.x * (value(1.0, 1.0) - value(0.0, 1.0));
    low + smooth.y * (high - low)
}

/// Evaluates `color` at every pixel centre, in 0..1 with y down.
fn paint(name: &str, [width, height]: [u32; 2], color: impl Fn(DVec2) -> [u8; 4]) -> Image {
    let mut rgba = Vec::with_capacity(width as usize * height as usize * 4);
    for y in 0..height {
        for x in 0..width {
            let centre = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            rgba.extend(color(centre / DVec2::new(f64::from(width), f64::from(height))));
        }
    }
    Image { name: name.into(), width, height, rgba, ..Image::default() }
}

/// Rounds to 64 steps per channel: PNG packs that a third smaller.
fn opaque(color: Vec3) -> [u8; 4] {
    let [r, g, b] = (color * 63.0).round().clamp(Vec3::ZERO, Vec3::splat(63.0)).to_array();
    [r, g, b, 63.0].map(|step| (step as u8) << 2 | (step as u8) >> 4)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_stays_in_range_and_repeats_at_the_edges() {
        for k in 0..50 {
            let t = f64::from(k) / 50.0;
            let value = clouds(DVec2::new(t, 0.3), 4, 1);
            assert!((0.0..=1.0).contains(&value));
            assert!(
                (clouds(DVec2::new(0.0, t), 4, 1) - clouds(DVec2::new(1.0, t), 4, 1)).abs() < 1e-12
            );
        }
    }

    #[test]
    fn pictures_have_the_size_they_say() {
        let white = Vec3::ONE;
        for image in [
            checker(8, 2, [white, Vec3::ZERO]),
            brick(8),
            wood(8),
            marble(8),
            paving(8),
            sky(8),
            windows(8, white, 1),
            leaves(8),
            fence(8),
            mark(8),
        ] {
            let n_bytes = image.width as usize * image.height as usize * 4;
            assert_eq!(image.rgba.len(), n_bytes, "{}", image.name);
        }
    }

    #[test]
    fn cut_out_pictures_have_holes_and_others_have_none() {
        let n_holes = |image: Image| image.rgba.chunks(4).filter(|pixel| pixel[3] == 0).count();
        assert!(n_holes(leaves(64)) > 1000);
        assert!(n_holes(fence(64)) > 1000);
        assert_eq!(n_holes(brick(64)), 0);
    }

    #[test]
    fn white_and_black_stay_exact() {
        assert_eq!(opaque(Vec3::ONE), [255; 4]);
        assert_eq!(opaque(Vec3::ZERO), [0, 0, 0, 255]);
    }
}
