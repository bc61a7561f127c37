//! Eight neighbouring pixels of a row at once: [`Interpolator::fragment`], wide.
//!
//! Shares over w and their quotients are formed in f64 and rounded once, so a pixel's weights do
//! not depend on where a group of eight begins, nor on the instruction set: the arithmetic is
//! `+ - * /` and compare-and-select in a fixed order, none of it fused.

use fearless_simd::{Simd, f32x8, f64x4, prelude::*};

use crate::fragment::Fragment;
use crate::interpolate::Interpolator;

/// The places of eight pixels on their triangle; see [`Fragment`].
#[derive(Clone, Copy, Debug)]
pub struct Fragment8<S: Simd> {
    /// Weights of the three corners at the pixel centres.
    pub weights: [f32x8<S>; 3],
    /// Change of the weights of corners 1 and 2 per pixel to the right; that of corner 0 is
    /// minus their sum.
    pub ddx: [f32x8<S>; 2],
    /// The same per pixel down.
    pub ddy: [f32x8<S>; 2],
}

/// Some pixels of one triangle.
#[derive(Clone, Copy, Debug)]
pub enum Pixels<'a> {
    /// Neighbours in a row, from the pixel `(x, y)` of the picture to the right.
    Row {
        /// The triangle.
        interpolator: &'a Interpolator,
        /// Column of the first.
        x: u32,
        /// Row of all.
        y: u32,
    },
    /// Any, each with its place.
    Each(&'a [Fragment]),
}

impl Pixels<'_> {
    /// Pixel `i`.
    #[inline]
    pub fn at(&self, i: usize) -> Fragment {
        match *self {
            Pixels::Row { interpolator, x, y } => interpolator.fragment(x + i as u32, y),
            Pixels::Each(fragments) => fragments[i],
        }
    }

    /// Pixels `i..i + 8`; what lies beyond the last is some number.
    #[inline(always)]
    pub fn at8<S: Simd>(&self, simd: S, i: usize) -> Fragment8<S> {
        match *self {
            Pixels::Row { interpolator, x, y } => interpolator.fragment8(simd, x + i as u32, y),
            Pixels::Each(fragments) => collected(simd, &fragments[i..]),
        }
    }
}

fn collected<S: Simd>(simd: S, fragments: &[Fragment]) -> Fragment8<S> {
    let (mut weights, mut ddx, mut ddy) = ([[0.0; 8]; 3], [[0.0; 8]; 2], [[0.0; 8]; 2]);
    for (lane, fragment) in fragments.iter().take(8).enumerate() {
        let Fragment { weights: w, ddx: dx, ddy: dy } = fragment;
        let w = w.as_vec3();
        (weights[0][lane], weights[1][lane], weights[2][lane]) = (w.x, w.y, w.z);
        (ddx[0][lane], ddx[1][lane]) = (dx.y, dx.z);
        (ddy[0][lane], ddy[1][lane]) = (dy.y, dy.z);
    }
    Fragment8 {
        weights: weights.map(|w| f32x8::simd_from(simd, w)),
        ddx: ddx.map(|d| f32x8::simd_from(simd, d)),
        ddy: ddy.map(|d| f32x8::simd_from(simd, d)),
    }
}

/// Eight f64 numbers.
type F64x8<S> = [f64x4<S>; 2];

impl Interpolator {
    /// The eight pixels from `(x, y)` to the right; up to rounding, [`Interpolator::fragment`] of
    /// each.
    #[inline(always)]
    pub fn fragment8<S: Simd>(&self, simd: S, x: u32, y: u32) -> Fragment8<S> {
        let (centre, origin) = (f64::from(x) + 0.5, self.origin[0]); // the first sum is exact
        let dx = [
            f64x4::simd_from(simd, [0.0, 1.0, 2.0, 3.0]) + centre - origin,
            f64x4::simd_from(simd, [4.0, 5.0, 6.0, 7.0]) + centre - origin,
        ];
        let dy = f64::from(y) + 0.5 - self.origin[1];
        let (at, ddx, ddy) = (self.at_origin.to_array(), self.ddx.to_array(), self.ddy.to_array());
        let [a, b, c] = [
            share(simd, at[0], ddx[0], dx, ddy[0] * dy),
            share(simd, at[1], ddx[1], dx, ddy[1] * dy),
            share(simd, at[2], ddx[2], dx, ddy[2] * dy),
        ];
        let one = f64x4::splat(simd, 1.0);
        let over_sum = [one / (a[0] + b[0] + c[0]), one / (a[1] + b[1] + c[1])];
        let [a, b, c] = [times(a, over_sum), times(b, over_sum), times(c, over_sum)];
        let [sum_ddx, sum_ddy] = [ddx[0] + ddx[1] + ddx[2], ddy[0] + ddy[1] + ddy[2]];
        Fragment8 {
            weights: finite(simd, [narrow(a), narrow(b), narrow(c)]),
            ddx: [slope(ddx[1], b, sum_ddx, over_sum), slope(ddx[2], c, sum_ddx, over_sum)],
            ddy: [slope(ddy[1], b, sum_ddy, over_sum), slope(ddy[2], c, sum_ddy, over_sum)],
        }
    }
}

/// Compare and select, NaN stays.
#[inline(always)]
fn share<S: Simd>(simd: S, at: f64, ddx: f64, dx: F64x8<S>, shift_y: f64) -> F64x8<S> {
    let zero = f64x4::splat(simd, 0.0);
    let low = dx[0] * ddx + at + shift_y;
    let high = dx[1] * ddx + at + shift_y;
    [low.simd_lt(zero).select(zero, low), high.simd_lt(zero).select(zero, high)]
}

#[inline(always)]
fn times<S: Simd>(a: F64x8<S>, b: F64x8<S>) -> F64x8<S> {
    [a[0] * b[0], a[1] * b[1]]
}

#[inline(always)]
fn narrow<S: Simd>(a: F64x8<S>) -> f32x8<S> {
    a[0].narrow(a[1])
}

/// Quotient rule: `(s / S)' = (s' - (s / S) S') / S`.
#[inline(always)]
fn slope<S: Simd>(d: f64, weight: F64x8<S>, sum: f64, over_sum: F64x8<S>) -> f32x8<S> {
    let low = (weight[0] * -sum + d) * over_sum[0];
    let high = (weight[1] * -sum + d) * over_sum[1];
    narrow([low, high])
}

/// The weights; a third each if the triangle has no extent at all here.
#[inline(always)]
fn finite<S: Simd>(simd: S, [a, b, c]: [f32x8<S>; 3]) -> [f32x8<S>; 3] {
    let third = f32x8::splat(simd, 1.0 / 3.0);
    let good = (a + b + c).simd_lt(f32x8::splat(simd, 2.0)); // false for NaN
    [good.select(a, third), good.select(b, third), good.select(c, third)]
}

#[cfg(test)]
mod tests {
    use cullet_transform::{ClipPoint, PlaneMask, Viewport};
    use fearless_simd::{Level, dispatch};

    use super::*;

    const CORNERS: [ClipPoint; 3] = [
        ClipPoint { x: -0.8, y: -0.7, z: 0.1, w: 1.0 },
        ClipPoint { x: 2.5, y: -2.0, z: 0.1, w: 3.0 },
        ClipPoint { x: 0.3, y: 1.6, z: 0.1, w: 2.0 },
    ];

    fn lanes(interpolator: &Interpolator, x: u32, y: u32) -> [[f32; 8]; 7] {
        #[inline(always)]
        fn flat<S: Simd>(simd: S, interpolator: &Interpolator, x: u32, y: u32) -> [[f32; 8]; 7] {
            let Fragment8 { weights: [a, b, c], ddx, ddy } = interpolator.fragment8(simd, x, y);
            [a, b, c, ddx[0], ddx[1], ddy[0], ddy[1]].map(Into::into)
        }
        dispatch!(Level::new(), simd => flat(simd, interpolator, x, y))
    }

    #[test]
    fn eight_are_one_by_one() {
        let viewport = Viewport::new(64, 48).unwrap();
        let interpolator = Interpolator::new::<8>(viewport, &CORNERS, PlaneMask::NONE);
        for (x, y) in [(0, 0), (20, 20), (33, 12), (61, 47)] {
            let eight = lanes(&interpolator, x, y);
            for lane in 0..8 {
                let one = interpolator.fragment(x + lane as u32, y);
                let w = one.weights.as_vec3();
                let one = [w.x, w.y, w.z, one.ddx.y, one.ddx.z, one.ddy.y, one.ddy.z];
                for (eight, one) in eight.iter().zip(one) {
                    let error = (eight[lane] - one).abs();
                    assert!(error <= 1e-6 * one.abs().max(0.1), "{error:e} at {x}, {y}, {lane}");
                }
                let shifted = lanes(&interpolator, x + lane as u32, y);
                for (eight, shifted) in eight.iter().zip(shifted) {
                    assert_eq!(eight[lane].to_bits(), shifted[0].to_bits());
                }
            }
        }
    }

    #[test]
    fn no_extent_is_a_third_each() {
        let viewport = Viewport::new(64, 48).unwrap();
        let corners = [ClipPoint { x: f64::NAN, y: 0.0, z: 0.1, w: 1.0 }; 3];
        let interpolator = Interpolator::new::<8>(viewport, &corners, PlaneMask::NONE);
        assert_eq!(lanes(&interpolator, 3, 3)[..3], [[1.0 / 3.0; 8]; 3]);
    }
}
