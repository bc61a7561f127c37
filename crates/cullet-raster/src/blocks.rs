//! Large triangles within a tile, block by block of 8 x 8 pixels: past those outside an edge, and those where
//! everything is nearer.
//!
//! Sources: Abrash 2009, "Rasterization on Larrabee"; Greene, Kass & Miller 1993 for the depths of blocks.

use fearless_simd::Simd;

use crate::fill::{KeepSample, TileDepth, TileTriangle, shift};
use crate::samples::Offset;
use crate::strip::{STRIP, Strip};
use crate::tile::{BLOCK, TileBuffer};

/// Eight columns of pixels, in some grid of samples.
pub(crate) trait Columns<S: Simd> {
    /// What all columns of a triangle share.
    type Setup;

    /// From column `x` on.
    fn at(
        simd: S,
        tile: &TileBuffer,
        triangle: &TileTriangle,
        setup: &Self::Setup,
        x: usize,
    ) -> Self;

    /// Draws some rows; returns how many samples were won. Without `PARTLY` all samples are covered, and
    /// their depths need no clamp.
    fn rows<const PARTLY: bool>(
        &self,
        simd: S,
        tile: &mut TileBuffer,
        triangle: &TileTriangle,
        rows: [usize; 2],
        keep: Option<&mut KeepSample<'_>>,
    ) -> u32;

    /// [`Columns::rows`] where all samples are covered and nearer than what is there.
    fn rows_in_front(
        &self,
        simd: S,
        tile: &mut TileBuffer,
        triangle: &TileTriangle,
        rows: [usize; 2],
    ) -> u32;
}

/// Draws a triangle that may fill whole blocks, in any grid; `offsets` are the tile's. Returns how many samples were
/// won.
#[inline(always)]
pub(crate) fn fill_blocks<S: Simd, C: Columns<S>, const N: usize>(
    simd: S,
    tile: &mut TileBuffer,
    triangle: &TileTriangle,
    offsets: &[Offset; N],
    setup: &C::Setup,
    mut keep: Option<&mut KeepSample<'_>>,
) -> u32 {
    let TileTriangle { rect, .. } = *triangle;
    let per_row = tile.blocks_per_row();
    let range = Range::new(tile, triangle.depth);
    let [_, nearest] = range.of(range.columns(rect.x), rect.y);
    if tile.hides_wide(simd, rect, triangle.depth.clamped(nearest)) {
        return 0;
    }
    let edges = BlockEdges::new(triangle, offsets);
    let are_whole = keep.is_none() && rect.y[0] % BLOCK == 0 && rect.y[1] % BLOCK == 0;
    let mut written = 0;
    let mut x = rect.x[0] / BLOCK * BLOCK;
    while x < rect.x[1] {
        let column = C::at(simd, tile, triangle, setup, x);
        let across = edges.across(triangle, x);
        let ways = range.columns([x, x + 8]);
        let mut top = rect.y[0] / BLOCK * BLOCK;
        while top < rect.y[1] {
            let strip = Strip::new(simd, triangle, &across, &range, ways, top);
            let first = top / BLOCK * per_row + x / BLOCK;
            if are_whole && strip.is_in_front(tile, first) {
                let rows = [top, rect.y[1].min(top + STRIP)];
                written += column.rows_in_front(simd, tile, triangle, rows);
                for block in 0..strip.there.count_ones() as usize {
                    tile.cover_block(first + block * per_row, strip.keys(block % 8));
                }
                top += STRIP;
                continue;
            }
            let mut reached = strip.reached;
            while reached != 0 {
                let at = reached.trailing_zeros() as usize % 8;
                reached &= reached - 1;
                let (rows, keys, block) = (strip.rows(at), strip.keys(at), first + at * per_row);
                let [farthest, nearest] = keys;
                if tile.block_hides(simd, block, nearest) {
                    continue;
                }
                if strip.whole >> at & 1 != 0 && keep.is_none() {
                    written += match tile.block_is_behind(block, farthest) {
                        true => column.rows_in_front(simd, tile, triangle, rows),
                        false => column.rows::<false>(simd, tile, triangle, rows, None),
                    };
                    if rows[1] - rows[0] == BLOCK {
                        tile.cover_block(block, keys);
                        continue;
                    }
                } else {
                    let keep = keep.as_deref_mut();
                    written += column.rows::<true>(simd, tile, triangle, rows, keep);
                }
                tile.touch_block(block, nearest);
            }
            top += STRIP;
        }
        x += 8;
    }
    written
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
    pub least: [i32; 3],
    pub most: [i32; 3],
}

/// The least and the greatest depth, before clamping, that a triangle's plane can have in parts of a tile:
/// rounding keeps the order of depths along x and along y, so they are found at corners.
pub(crate) struct Range {
    pub depth: TileDepth,
    /// Upper left corner of the tile in the picture, px.
    pub origin: [i32; 2],
    /// How far samples are from the centres of their pixels, px.
    pub reach: f64,
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
    fn of(&self, [way_far, way_near]: [f64; 2], [start, end]: [usize; 2]) -> [f64; 2] {
        let TileDepth { depth, ddy, origin, .. } = self.depth;
        let first = f64::from(self.origin[1] + start as i32) - self.reach;
        let last = f64::from(self.origin[1] + end as i32 - 1) + self.reach;
        let (far, near) = if ddy > 0.0 { (first, last) } else { (last, first) };
        let row_far = depth + ddy * (far - origin[1]);
        let row_near = depth + ddy * (near - origin[1]);
        [row_far + way_far, row_near + way_near]
    }
}
