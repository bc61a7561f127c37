//! Eight blocks below each other, side by side: which of them a large triangle reaches and fills, and how near it comes
//! there.

use fearless_simd::{Simd, f64x4, i32x8, prelude::*};

use crate::blocks::{Across, Range};
use crate::depth::reversed_key;
use crate::fill::TileTriangle;
use crate::small::widened;
use crate::tile::{BLOCK, TileBuffer};

/// Rows of a strip.
pub(crate) const STRIP: usize = 8 * BLOCK;

/// A triangle in a strip. Sets of blocks are words, a bit each, the uppermost lowest.
pub(crate) struct Strip {
    /// Rows of the triangle's box in each block, in the tile: the first, and the one after the last.
    start: [i32; 8],
    end: [i32; 8],
    /// Blocks that the box reaches.
    pub there: u64,
    /// Those that may have samples inside all edges.
    pub reached: u64,
    /// Those all of whose samples are inside, with depths that need no clamp.
    pub whole: u64,
    /// No key of the triangle is farther, none is nearer.
    farthest: [i32; 8],
    nearest: [i32; 8],
}

impl Strip {
    /// Of the columns of `across`, from row `top` of the tile on; `ways` is what they add to the depth.
    #[inline(always)]
    #[expect(clippy::needless_range_loop, reason = "iterators beside vectors may become calls")]
    pub fn new<S: Simd>(
        simd: S,
        triangle: &TileTriangle,
        across: &Across,
        range: &Range,
        ways: [f64; 2],
        top: usize,
    ) -> Self {
        let TileTriangle { rect, down, depth, .. } = triangle;
        let [first, end] = [rect.y[0] as i32, rect.y[1] as i32];
        let rows = i32x8::simd_from(simd, [0, 8, 16, 24, 32, 40, 48, 56]) + top as i32;
        let (start, end) = (rows.max(first), (rows + BLOCK as i32).min(end));
        let there = start.simd_lt(end).to_bitmask();
        let (upper, lower) = (start - first, end - 1 - first);
        let mut most = i32x8::splat(simd, 0);
        let mut least = i32x8::splat(simd, 0);
        for edge in 0..3 {
            let (upper, lower) = (upper * down[edge], lower * down[edge]);
            most |= upper.max(lower) + across.most[edge];
            least |= upper.min(lower) + across.least[edge];
        }
        let [far, near] = range.rows(simd, [start, end - 1]);
        let farthest = [far[0] + ways[0], far[1] + ways[0]];
        let nearest = [near[0] + ways[1], near[1] + ways[1]];
        let is_free = [
            farthest[0].simd_ge(depth.low) & nearest[0].simd_le(depth.high),
            farthest[1].simd_ge(depth.low) & nearest[1].simd_le(depth.high),
        ];
        let free = is_free[0].to_bitmask() | is_free[1].to_bitmask() << 4;
        let limits = [reversed_key(depth.low as f32), reversed_key(depth.high as f32)];
        Strip {
            start: start.into(),
            end: end.into(),
            there,
            reached: most.simd_ge(0).to_bitmask() & there,
            whole: least.simd_ge(0).to_bitmask() & free & there,
            farthest: between(limits, farthest).into(),
            nearest: between(limits, nearest).into(),
        }
    }

    /// Rows of a block.
    #[inline(always)]
    pub fn rows(&self, block: usize) -> [usize; 2] {
        [self.start[block] as usize, self.end[block] as usize]
    }

    /// The farthest and the nearest key of a block.
    #[inline(always)]
    pub fn keys(&self, block: usize) -> [i32; 2] {
        [self.farthest[block], self.nearest[block]]
    }

    /// Whether all of the box is covered, and nearer than what is in its blocks, whose uppermost is `first`.
    #[inline(always)]
    pub fn is_in_front(&self, tile: &TileBuffer, first: usize) -> bool {
        if self.whole != self.there {
            return false;
        }
        let per_row = tile.blocks_per_row();
        for block in 0..self.there.count_ones() as usize {
            if !tile.block_is_behind(first + block * per_row, self.farthest[block % 8]) {
                return false;
            }
        }
        true
    }
}

/// The keys of eight depths, as [`clamped_key`](crate::fill::clamped_key).
#[inline(always)]
fn between<S: Simd>([low, high]: [i32; 2], [first, second]: [f64x4<S>; 2]) -> i32x8<S> {
    let key: i32x8<S> = first.narrow(second).bitcast();
    key.max(low).min(high)
}

impl Range {
    /// What rows add to the depth, at the far end and at the near one: between the first and the last of each block.
    /// Operation by operation as in the rows.
    #[inline(always)]
    fn rows<S: Simd>(&self, simd: S, [first, last]: [i32x8<S>; 2]) -> [[f64x4<S>; 2]; 2] {
        let first = widened(simd, first + self.origin[1]);
        let last = widened(simd, last + self.origin[1]);
        let upper = [self.row(first[0] - self.reach), self.row(first[1] - self.reach)];
        let lower = [self.row(last[0] + self.reach), self.row(last[1] + self.reach)];
        // Rounding keeps the order of depths.
        [
            [upper[0].min(lower[0]), upper[1].min(lower[1])],
            [upper[0].max(lower[0]), upper[1].max(lower[1])],
        ]
    }

    #[inline(always)]
    fn row<S: Simd>(&self, y: f64x4<S>) -> f64x4<S> {
        (y - self.depth.origin[1]) * self.depth.ddy + self.depth.depth
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blocks::BlockEdges;
    use crate::fill::TileDepth;
    use crate::level::dispatch_wide;
    use crate::samples::Samples;
    use crate::testing::{Random, levels};
    use crate::tile::TileRect;

    /// A half plane of each kind, and a plane of depth that some of the strip needs clamped.
    fn triangle(random: &mut Random, side: usize) -> TileTriangle {
        let mut between = |low: f64, high: f64| low + (high - low) * random.next();
        let rows = [0, 1].map(|_| between(0.0, side as f64) as usize);
        let y = [rows[0].min(rows[1]), rows[0].max(rows[1]) + 1];
        let edge = |between: &mut dyn FnMut(f64, f64) -> f64| between(-300.0, 300.0) as i32;
        let [left, down] = [0, 1].map(|_| [0, 1, 2].map(|_| edge(&mut between)));
        let value = [0, 1, 2].map(|_| between(-4000.0, 20_000.0) as i32);
        let depth = TileDepth {
            depth: between(0.2, 0.8),
            origin: [0, 1].map(|_| between(100.0, 164.0)),
            ddx: between(-0.01, 0.01),
            ddy: between(-0.01, 0.01),
            low: between(0.0, 0.4),
            high: between(0.6, 1.0),
        };
        let rect = TileRect { x: [0, side], y };
        TileTriangle { id: 7, rect, value, rest: [0; 3], left, down, depth }
    }

    #[test]
    fn blocks_of_a_strip_are_what_their_pixels_are() {
        let random = &mut Random(5);
        let [mut n_reached, mut n_whole, mut n_front] = [0; 3];
        for round in 0..600 {
            let side = [32, 64, 128][round % 3];
            let mut tile = TileBuffer::default();
            tile.begin([100, 100], side, Samples::One);
            let triangle = triangle(random, side);
            let TileTriangle { rect, value, left, down, depth, .. } = triangle;
            let (edges, range) = (BlockEdges::new(&triangle, &[[0, 0]]), Range::new(&tile, depth));
            let x = (random.next() * (side / BLOCK) as f64) as usize * BLOCK;
            let top = rect.y[0] / BLOCK * BLOCK;
            let (across, ways) = (edges.across(&triangle, x), range.columns([x, x + BLOCK]));
            for level in levels().into_iter().filter(|level| !level.is_fallback()) {
                let strip = dispatch_wide!(level, simd => {
                    Strip::new(simd, &triangle, &across, &range, ways, top)
                });
                let mut all_whole = true;
                for block in 0..8 {
                    let rows = (top + block * BLOCK).max(rect.y[0])
                        ..(top + block * BLOCK + BLOCK).min(rect.y[1]);
                    let has = |set: u64| set >> block & 1 != 0;
                    assert_eq!(has(strip.there), !rows.is_empty());
                    if rows.is_empty() {
                        assert!(!has(strip.reached) && !has(strip.whole));
                        continue;
                    }
                    assert_eq!(strip.rows(block), [rows.start, rows.end]);
                    let (mut any, mut all) = (false, true);
                    let (mut keys, mut is_free) = ([i32::MAX, i32::MIN], true);
                    for (row, column) in rows.flat_map(|row| (x..x + 8).map(move |x| (row, x))) {
                        let [along, below] = [column as i32, (row - rect.y[0]) as i32];
                        let inside = [0, 1, 2]
                            .map(|edge| value[edge] - left[edge] * along + down[edge] * below >= 0);
                        any |= inside == [true; 3];
                        all &= inside == [true; 3];
                        let [px, py] = [100.0 + column as f64, 100.0 + row as f64];
                        let at = depth.depth
                            + depth.ddy * (py - depth.origin[1])
                            + depth.ddx * (px - depth.origin[0]);
                        is_free &= (depth.low..=depth.high).contains(&at);
                        let key = depth.clamped(at);
                        keys = [keys[0].min(key), keys[1].max(key)];
                    }
                    assert!(has(strip.reached) || !any, "{level:?}");
                    assert_eq!(has(strip.whole), all && is_free, "{level:?}");
                    assert_eq!(strip.keys(block), keys, "{level:?}");
                    all_whole &= all && is_free;
                    n_reached += u32::from(has(strip.reached));
                    n_whole += u32::from(all && is_free);
                }
                let first = top / BLOCK * tile.blocks_per_row() + x / BLOCK;
                assert_eq!(strip.is_in_front(&tile, first), all_whole && strip.keys(0)[0] > 0);
                if all_whole {
                    n_front += 1;
                    let last = strip.there.count_ones() as usize - 1;
                    let [farthest, _] = strip.keys(last);
                    for (nearest, is_in_front) in [(farthest - 1, true), (farthest, false)] {
                        let mut tile = tile.clone();
                        tile.touch_block(first + last * tile.blocks_per_row(), nearest);
                        assert_eq!(strip.is_in_front(&tile, first), is_in_front);
                    }
                }
            }
        }
        assert!(
            n_reached > 1000 && n_whole > 300 && n_front > 50,
            "{n_reached} {n_whole} {n_front}"
        );
    }
}
