//! Eight blocks below each other, side by side: which of them a large triangle reaches and fills, and how near it comes
//! there.

use fearless_simd::{Simd, f64x4, i32x8, prelude::*};

use crate::depth::reversed_key;
use crate::depth8::widened;
use crate::fill::{TileDepth, TileTriangle, shift};
use crate::samples::Offset;
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
            farthest: clamped_keys(limits, farthest).into(),
            nearest: clamped_keys(limits, nearest).into(),
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
fn clamped_keys<S: Simd>([low, high]: [i32; 2], [first, second]: [f64x4<S>; 2]) -> i32x8<S> {
    let key: i32x8<S> = first.narrow(second).bitcast();
    key.max(low).min(high)
}

/// How far samples reach beyond the centres of their pixels, in edge values.
pub(crate) struct BlockEdges {
    /// The least and the most that any sample adds to the value of each edge.
    least: [i32; 3],
    most: [i32; 3],
}

impl BlockEdges {
    #[inline(always)]
    pub fn new<const N: usize>(triangle: &TileTriangle, offsets: &[Offset; N]) -> Self {
        // One by one: of lists of three the compiler makes masked moves.
        let [a, b, c] = [
            reach_of(triangle, 0, offsets),
            reach_of(triangle, 1, offsets),
            reach_of(triangle, 2, offsets),
        ];
        BlockEdges { least: [a[0], b[0], c[0]], most: [a[1], b[1], c[1]] }
    }

    /// In eight columns from `x` on.
    #[inline(always)]
    pub fn across(
        &self,
        TileTriangle { rect, value, left, .. }: &TileTriangle,
        x: usize,
    ) -> Across {
        let way = x as i32 - rect.x[0] as i32;
        let mut across = Across { least: self.least, most: self.most };
        for edge in 0..3 {
            let first = value[edge] - left[edge] * way;
            let last = first - left[edge] * 7;
            across.least[edge] += first.min(last);
            across.most[edge] += first.max(last);
        }
        across
    }
}

/// The least and the most that any sample adds to the value of an edge.
#[inline(always)]
fn reach_of<const N: usize>(
    TileTriangle { rest, left, down, .. }: &TileTriangle,
    edge: usize,
    offsets: &[Offset; N],
) -> [i32; 2] {
    let (mut least, mut most) = (i32::MAX, i32::MIN);
    for offset in offsets {
        let shift = shift(rest[edge], left[edge], down[edge], *offset);
        (least, most) = (least.min(shift), most.max(shift));
    }
    [least, most]
}

/// The least and the greatest edge values in eight columns, in the first row of a triangle.
pub(crate) struct Across {
    least: [i32; 3],
    most: [i32; 3],
}

/// The least and the greatest depth, before clamping, that a triangle's plane can have in parts of a tile:
/// rounding keeps the order of depths along x and along y, so they are found at corners.
pub(crate) struct Range {
    depth: TileDepth,
    /// Upper left corner of the tile in the picture, px.
    origin: [i32; 2],
    /// How far samples are from the centres of their pixels, px.
    reach: f64,
}

impl Range {
    #[inline(always)]
    pub fn new(tile: &TileBuffer, depth: TileDepth) -> Self {
        Range { depth, origin: tile.origin(), reach: f64::from(tile.samples().reach()) / 16.0 }
    }

    /// What the way to some columns adds to the depth, at the far end and at the near one.
    #[inline(always)]
    pub fn columns(&self, [start, end]: [usize; 2]) -> [f64; 2] {
        let TileDepth { ddx, origin, .. } = self.depth;
        let first = f64::from(self.origin[0] + start as i32) - self.reach;
        let last = f64::from(self.origin[0] + end as i32 - 1) + self.reach;
        let (far, near) = if ddx > 0.0 { (first, last) } else { (last, first) };
        [ddx * (far - origin[0]), ddx * (near - origin[0])]
    }

    /// In some columns and rows; operation by operation as in the rows.
    #[inline(always)]
    pub fn of(&self, [way_far, way_near]: [f64; 2], [start, end]: [usize; 2]) -> [f64; 2] {
        let TileDepth { depth, ddy, origin, .. } = self.depth;
        let first = f64::from(self.origin[1] + start as i32) - self.reach;
        let last = f64::from(self.origin[1] + end as i32 - 1) + self.reach;
        let (far, near) = if ddy > 0.0 { (first, last) } else { (last, first) };
        let row_far = depth + ddy * (far - origin[1]);
        let row_near = depth + ddy * (near - origin[1]);
        [row_far + way_far, row_near + way_near]
    }

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
        let rest = [0, 1, 2].map(|_| between(0.0, 256.0) as i32);
        TileTriangle { id: 7, rect, value, rest, left, down, depth }
    }

    fn check<const N: usize>(random: &mut Random, samples: Samples) {
        let offsets: &[Offset; N] = samples.offsets().first_chunk().unwrap();
        let [mut n_reached, mut n_whole, mut n_front] = [0; 3];
        for round in 0..300 {
            let side = [32, 64, 256][round % 3];
            let mut tile = TileBuffer::default();
            tile.begin([100, 100], side, samples);
            let triangle = triangle(random, side);
            let (edges, range) =
                (BlockEdges::new(&triangle, offsets), Range::new(&tile, triangle.depth));
            let x = (random.next() * (side / BLOCK) as f64) as usize * BLOCK;
            let rows = triangle.rect.y;
            // Any strip of the triangle.
            let n_strips = (rows[1] - rows[0]).div_ceil(STRIP);
            let strip = (random.next() * n_strips as f64) as usize;
            let top = rows[0] / BLOCK * BLOCK + STRIP * strip;
            let (across, ways) = (edges.across(&triangle, x), range.columns([x, x + BLOCK]));
            for level in levels().into_iter().filter(|level| !level.is_fallback()) {
                let strip = dispatch_wide!(level, simd => {
                    Strip::new(simd, &triangle, &across, &range, ways, top)
                });
                let mut is_all_whole = true;
                for block in 0..8 {
                    let first = top + block * BLOCK;
                    let rows = first.max(rows[0])..(first + BLOCK).min(rows[1]);
                    let has = |set: u64| set >> block & 1 != 0;
                    assert_eq!(has(strip.there), !rows.is_empty());
                    if rows.is_empty() {
                        assert!(!has(strip.reached) && !has(strip.whole));
                        continue;
                    }
                    assert_eq!(strip.rows(block), [rows.start, rows.end]);
                    let found = Found::new(&triangle, x, rows, offsets);
                    assert!(has(strip.reached) || !found.any, "{level:?}");
                    let is_whole = found.all && found.is_free;
                    let [farthest, nearest] = strip.keys(block);
                    if N == 1 {
                        assert_eq!(has(strip.whole), is_whole, "{level:?}");
                        assert_eq!([farthest, nearest], found.keys, "{level:?}");
                    } else {
                        assert!(is_whole || !has(strip.whole), "{level:?}");
                        assert!(farthest <= found.keys[0] && found.keys[1] <= nearest);
                    }
                    is_all_whole &= has(strip.whole);
                    n_reached += u32::from(has(strip.reached));
                    n_whole += u32::from(has(strip.whole));
                }
                let first = top / BLOCK * tile.blocks_per_row() + x / BLOCK;
                let is_in_front = is_all_whole && strip.keys(0)[0] > 0;
                assert_eq!(strip.is_in_front(&tile, first), is_in_front);
                if is_in_front {
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
        let n = [n_reached, n_whole, n_front];
        assert!(n[0] > 500 && n[1] > 100 && n[2] > 20, "{samples:?} {n:?}");
    }

    /// What the samples of a block are.
    struct Found {
        any: bool,
        all: bool,
        is_free: bool,
        keys: [i32; 2],
    }

    impl Found {
        fn new(
            TileTriangle { rect, value, rest, left, down, depth, .. }: &TileTriangle,
            x: usize,
            rows: std::ops::Range<usize>,
            offsets: &[Offset],
        ) -> Self {
            let mut found =
                Found { any: false, all: true, is_free: true, keys: [i32::MAX, i32::MIN] };
            let pixels = rows.flat_map(|row| (x..x + 8).map(move |x| (row, x)));
            for ((row, column), [sx, sy]) in
                pixels.flat_map(|pixel| offsets.iter().map(move |offset| (pixel, *offset)))
            {
                // Sixteenths from the centre of the first pixel.
                let along = 16 * column as i32 + sx;
                let below = 16 * (row - rect.y[0]) as i32 + sy;
                let is_inside = (0..3).all(|edge| {
                    let way = (down[edge] * below - left[edge] * along) * 16;
                    value[edge] * 256 + rest[edge] + way >= 0
                });
                found.any |= is_inside;
                found.all &= is_inside;
                let [px, py] = [(column, sx), (row, sy)]
                    .map(|(pixel, offset)| 100.0 + pixel as f64 + f64::from(offset) / 16.0);
                let at = depth.depth
                    + depth.ddy * (py - depth.origin[1])
                    + depth.ddx * (px - depth.origin[0]);
                found.is_free &= (depth.low..=depth.high).contains(&at);
                let key = depth.clamped(at);
                found.keys = [found.keys[0].min(key), found.keys[1].max(key)];
            }
            found
        }
    }

    #[test]
    fn blocks_of_a_strip_are_what_their_samples_are() {
        let random = &mut Random(5);
        check::<1>(random, Samples::One);
        check::<2>(random, Samples::Two);
        check::<4>(random, Samples::Four);
        check::<8>(random, Samples::Eight);
    }
}
