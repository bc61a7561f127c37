//! Boxes of eight triangles in a tile, in pixels and in blocks.

use fearless_simd::{Simd, i32x8, prelude::*};

use crate::assembly::pixels8;
use crate::tile::{BLOCK_BITS, TileBuffer};

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

    /// The blocks at their corners.
    #[inline(always)]
    pub fn corners(&self, tile: &TileBuffer) -> BlockCorners {
        let per_row = tile.blocks_per_row() as i32;
        let [left, right] = [self.x[0] >> BLOCK_BITS, (self.x[1] - 1) >> BLOCK_BITS];
        let [top, bottom] = [self.y[0] >> BLOCK_BITS, (self.y[1] - 1) >> BLOCK_BITS];
        let [upper, lower] = [top * per_row, bottom * per_row];
        BlockCorners {
            blocks: [
                (upper + left).into(),
                (upper + right).into(),
                (lower + left).into(),
                (lower + right).into(),
            ],
            few: ((right - left).simd_lt(2) & (bottom - top).simd_lt(2)).to_bitmask(),
        }
    }
}

/// The blocks at the corners of eight boxes.
pub(crate) struct BlockCorners {
    blocks: [[i32; 8]; 4],
    /// Boxes that are no more than two blocks along an axis, a bit each: they lie in those at their corners.
    few: u64,
}

impl BlockCorners {
    /// Whether all blocks of a box are known to be nearer than `key`. If they are not few, the answer is no.
    #[inline(always)]
    pub fn hide(&self, tile: &TileBuffer, lane: usize, key: i32) -> bool {
        let [a, b, c, d] = [
            tile.farthest_known(self.blocks[0][lane] as usize),
            tile.farthest_known(self.blocks[1][lane] as usize),
            tile.farthest_known(self.blocks[2][lane] as usize),
            tile.farthest_known(self.blocks[3][lane] as usize),
        ];
        (self.few >> lane & 1 != 0) & (a.min(b).min(c.min(d)) > key)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::level::dispatch_wide;
    use crate::samples::Samples;
    use crate::testing::levels;

    #[test]
    fn few_blocks_hide_what_is_behind_all_of_them() {
        let mut tile = TileBuffer::default();
        tile.begin([64, 32], 32, Samples::Four);
        let farthest = |block: usize| 10 + (block * 7 % 16) as i32;
        for block in 0..16 {
            tile.cover_block(block, [farthest(block), 100]);
        }
        for (level, place) in
            levels().into_iter().flat_map(|level| (0..256).map(move |p| (level, p)))
        {
            let ([x0, x1], [y0, y1]) =
                ([place & 3, place >> 2 & 3], [place >> 4 & 3, place >> 6 & 3]);
            if x0 > x1 || y0 > y1 || level.is_fallback() {
                continue;
            }
            let blocks = (y0..=y1).flat_map(|y| (x0..=x1).map(move |x| 4 * y + x));
            let least = blocks.map(farthest).min().unwrap();
            let is_few = x1 - x0 < 2 && y1 - y0 < 2;
            // From some pixel of the first block to some pixel of the last.
            let pixels = |first: usize, last: usize| [8 * first + place % 8, 8 * last + 8];
            let ([left, right], [top, bottom]) = (pixels(x0, x1), pixels(y0, y1));
            let corners = dispatch_wide!(level, simd => {
                let all = |pixel: usize| i32x8::splat(simd, pixel as i32);
                let boxes =
                    Boxes { x: [all(left), all(right)], y: [all(top), all(bottom)] };
                boxes.corners(&tile)
            });
            for lane in [0, 7] {
                assert_eq!(corners.hide(&tile, lane, least - 1), is_few, "{level:?} {place}");
                assert!(!corners.hide(&tile, lane, least), "{level:?} {place}");
            }
        }
    }
}
