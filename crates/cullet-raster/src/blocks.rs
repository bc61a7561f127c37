//! Large triangles within a tile, block by block of 8 x 8 pixels: past those outside an edge, and those where
//! everything is nearer.
//!
//! Sources: Abrash 2009, "Rasterization on Larrabee"; Greene, Kass & Miller 1993 for the depths of blocks.

use fearless_simd::Simd;

use crate::fill::{KeepSample, TileTriangle};
use crate::samples::Offset;
use crate::strip::{BlockEdges, Range, STRIP, Strip};
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
