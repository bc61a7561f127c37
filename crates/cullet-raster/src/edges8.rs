//! Eight triangles set up side by side: their edges, and one of them by itself.

use fearless_simd::{Simd, i32x8, mask32x8, prelude::*};

use crate::depth8::Planes8;
use crate::fill::TileTriangle;
use crate::tile::TileRect;

/// An edge of eight triangles.
pub(crate) struct Edge8<S: Simd> {
    pub value: i32x8<S>,
    pub rest: i32x8<S>,
    pub run: i32x8<S>,
    pub drop: i32x8<S>,
}

impl<S: Simd> Edge8<S> {
    /// What [`Values::of_short`] takes.
    #[inline(always)]
    pub fn pair(&self) -> i32x8<S> {
        self.run & 0xffff | -self.drop << 16
    }
}

/// Values at `(px, py)`; the rule is that of [`crate::cover`].
#[inline(always)]
pub(crate) fn edge<S: Simd>(
    simd: S,
    from_x: i32x8<S>,
    from_y: i32x8<S>,
    to_x: i32x8<S>,
    to_y: i32x8<S>,
    px: i32x8<S>,
    py: i32x8<S>,
) -> Edge8<S> {
    let (run, drop) = (to_x - from_x, to_y - from_y);
    let top_left: mask32x8<S> = drop.simd_lt(0) | (drop.simd_eq(0) & run.simd_gt(0));
    let least = top_left.select(i32x8::splat(simd, 0), i32x8::splat(simd, 1));
    let value = run * (py - from_y) - drop * (px - from_x) - least;
    Edge8 { value: value >> 8, rest: value & 255, run, drop }
}

/// Eight triangles set up, number by number.
pub(crate) struct Eight {
    pub x: [[i32; 8]; 2],
    pub y: [[i32; 8]; 2],
    pub value: [[i32; 8]; 3],
    pub rest: [[i32; 8]; 3],
    pub left: [[i32; 8]; 3],
    pub down: [[i32; 8]; 3],
    pub pairs: [[i32; 8]; 3],
    pub planes: Planes8,
}

impl Eight {
    /// Pixels that the samples of the triangle in `lane` may lie in.
    #[inline(always)]
    pub fn rect(&self, lane: usize) -> TileRect {
        TileRect {
            x: [self.x[0][lane] as usize, self.x[1][lane] as usize],
            y: [self.y[0][lane] as usize, self.y[1][lane] as usize],
        }
    }

    /// The triangle in `lane`, with the depth of its corners.
    #[inline(always)]
    pub fn triangle(&self, lane: usize, id: u32, depth: [f64; 3]) -> TileTriangle {
        TileTriangle {
            id,
            rect: self.rect(lane),
            value: lane_of(&self.value, lane),
            rest: lane_of(&self.rest, lane),
            left: lane_of(&self.left, lane),
            down: lane_of(&self.down, lane),
            depth: self.planes.of(lane, depth),
        }
    }
}

#[inline(always)]
pub(crate) fn lane_of(list: &[[i32; 8]; 3], lane: usize) -> [i32; 3] {
    [list[0][lane], list[1][lane], list[2][lane]]
}
