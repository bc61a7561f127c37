//! Boxes of eight triangles in a tile, in pixels and in blocks.

use fearless_simd::{Simd, i32x8, prelude::*};

use crate::assembly::pixels8;
use crate::tile::{BLOCK_BITS, BlockRect, TileBuffer};

/// Pixels of eight triangles in a tile whose samples may lie between their borders: the first ones
/// and those after the last.
#[derive(Clone, Copy)]
pub(crate) struct Boxes<S: Simd> {
    pub x: [i32x8<S>; 2],
    pub y: [i32x8<S>; 2],
}

impl<S: Simd> Boxes<S> {
    /// Between borders, units, cut to the tile.
    #[inline(always)]
    pub fn new(
        tile: &TileBuffer,
        left: i32x8<S>,
        right: i32x8<S>,
        upper: i32x8<S>,
        lower: i32x8<S>,
    ) -> Self {
        let (samples, side, [x, y]) = (tile.samples(), tile.side() as i32, tile.origin());
        let [start_x, end_x] = pixels8(left, right, samples);
        let [start_y, end_y] = pixels8(upper, lower, samples);
        Boxes {
            x: [(start_x - x).max(0), (end_x - x).min(side)],
            y: [(start_y - y).max(0), (end_y - y).min(side)],
        }
    }

    /// Which hold a pixel, a bit each.
    #[inline(always)]
    pub fn hold(&self) -> u64 {
        let [[start_x, end_x], [start_y, end_y]] = [self.x, self.y];
        (start_x.simd_lt(end_x) & start_y.simd_lt(end_y)).to_bitmask()
    }

    /// The blocks that they lie in.
    #[inline(always)]
    pub fn blocks(&self) -> Blocks8 {
        let [[start_x, end_x], [start_y, end_y]] = [self.x, self.y];
        Blocks8 {
            x: [(start_x >> BLOCK_BITS).into(), ((end_x - 1) >> BLOCK_BITS).into()],
            y: [(start_y >> BLOCK_BITS).into(), ((end_y - 1) >> BLOCK_BITS).into()],
        }
    }
}

/// The first and the last column and row of the blocks of eight boxes.
pub(crate) struct Blocks8 {
    x: [[i32; 8]; 2],
    y: [[i32; 8]; 2],
}

impl Blocks8 {
    #[inline(always)]
    pub fn of(&self, lane: usize) -> BlockRect {
        BlockRect {
            x: [self.x[0][lane] as usize, self.x[1][lane] as usize],
            y: [self.y[0][lane] as usize, self.y[1][lane] as usize],
        }
    }
}
