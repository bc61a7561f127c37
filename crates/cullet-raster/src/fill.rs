//! Which samples of a tile a triangle wins, two rows of eight pixels with one sample each at a time.
//!
//! Edge values are divided by the subpixel unit and rounded down: a step of one pixel changes them
//! by a multiple of it, so their signs, which are all that counts, survive, and 32 bits suffice
//! within a tile. Depth is the same plane in f64 that [`crate::cover`] evaluates, in the same
//! order.
//! Source: Pineda 1988, "A Parallel Algorithm for Polygon Rasterization".

use fearless_simd::{Simd, f32x16, f64x8, i32x8, i32x16, mask32x16, prelude::*, u32x8, u32x16};

use crate::blocks::Columns;
use crate::depth::reversed_key;
use crate::samples::Offset;
use crate::tile::{TileBuffer, TileRect};

/// A triangle within one tile.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TileTriangle {
    pub id: u32,
    /// Pixels that its samples may lie in.
    pub rect: TileRect,
    /// Edge values, less what is not inside, at the centre of the first pixel of `rect`: whole
    /// subpixel units, rounded down.
    pub value: [i32; 3],
    /// What rounding took off, `0..256`.
    pub rest: [i32; 3],
    /// Change of `value` per pixel to the left.
    pub left: [i32; 3],
    /// Change of `value` per pixel down.
    pub down: [i32; 3],
    pub depth: TileDepth,
}

/// [`crate::cover`]'s plane of depth.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TileDepth {
    pub depth: f64,
    pub origin: [f64; 2],
    pub ddx: f64,
    pub ddy: f64,
    pub low: f64,
    pub high: f64,
}

impl TileDepth {
    /// The key of a depth.
    #[inline(always)]
    pub(crate) fn clamped(&self, depth: f64) -> i32 {
        let depth = if depth < self.low { self.low } else { depth };
        let depth = if depth > self.high { self.high } else { depth };
        reversed_key(depth as f32)
    }
}

/// Asked, where a triangle's material has holes, whether it has matter at samples of up to eight
/// neighbouring pixels: the triangle, the place of the first in the picture in sixteenths of a pixel (the
/// next are 16 to the right each), and which are asked about, a bit each. Answers with the bits of
/// those that have.
pub type KeepSample<'k> = dyn FnMut(u32, [i32; 2], u64) -> u64 + 'k;

/// Draws a triangle that does not fill blocks, one sample a pixel. Returns how many were won.
#[inline(always)]
pub(crate) fn fill<S: Simd>(
    simd: S,
    tile: &mut TileBuffer,
    triangle: &TileTriangle,
    mut keep: Option<&mut KeepSample<'_>>,
) -> u32 {
    let TileTriangle { rect, .. } = *triangle;
    let mut written = 0;
    let mut x = rect.x[0];
    while x < rect.x[1] {
        // Within the tile. What the column before has won already is not won again.
        let column = Column::at(simd, tile, triangle, &(), x.min(tile.side() - 8));
        written += column.rows::<true>(simd, tile, triangle, rect.y, keep.as_deref_mut());
        x += 8;
    }
    if written > 0 {
        tile.touch(rect, reversed_key(triangle.depth.high as f32));
    }
    written
}

/// What a sample away from the centre of its pixel adds to the value of an edge.
#[inline(always)]
pub(crate) fn shift(rest: i32, left: i32, down: i32, [x, y]: Offset) -> i32 {
    // Per pixel `left` units of 256; per sixteenth sixteen of them.
    let way = (down as i64 * y as i64 - left as i64 * x as i64) * 16;
    ((rest as i64 + way) >> 8) as i32
}

/// Eight columns of pixels with one sample each, drawn two rows at a time.
pub(crate) struct Column<S: Simd> {
    /// First column in the tile.
    x: usize,
    /// Edge values in the first two rows of the triangle, the upper one first.
    values: [i32x16<S>; 3],
    /// Depth that the way from the plane's origin along x adds.
    way: f64x8<S>,
}

impl<S: Simd> Columns<S> for Column<S> {
    type Setup = ();

    #[inline(always)]
    fn at(simd: S, tile: &TileBuffer, triangle: &TileTriangle, _: &(), x: usize) -> Self {
        let TileTriangle { rect, depth, .. } = triangle;
        let lanes =
            i32x8::simd_from(simd, [0, 1, 2, 3, 4, 5, 6, 7]) + (x as i32 - rect.x[0] as i32);
        let values = [
            two_rows(simd, triangle, 0, lanes),
            two_rows(simd, triangle, 1, lanes),
            two_rows(simd, triangle, 2, lanes),
        ];
        let columns = f64x8::simd_from(simd, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        // Multiples of 1 / 256: exact.
        let way = columns + (f64::from(tile.origin()[0] + x as i32) - depth.origin[0]);
        Column { x, values, way: way * depth.ddx }
    }

    #[inline(always)]
    fn rows<const PARTLY: bool>(
        &self,
        simd: S,
        tile: &mut TileBuffer,
        triangle: &TileTriangle,
        rows: [usize; 2],
        keep: Option<&mut KeepSample<'_>>,
    ) -> u32 {
        match keep {
            None => self.draw::<PARTLY, false>(simd, tile, triangle, rows, None),
            keep => self.draw::<PARTLY, true>(simd, tile, triangle, rows, keep),
        }
    }

    #[inline(always)]
    fn rows_in_front(
        &self,
        simd: S,
        tile: &mut TileBuffer,
        triangle: &TileTriangle,
        rows: [usize; 2],
    ) -> u32 {
        let TileTriangle { depth, .. } = triangle;
        let (stride, [_, top]) = (tile.stride_px(), tile.origin());
        let start = rows[0] * stride + self.x;
        // As many of both, so that one comparison serves for all.
        let n_rows = rows[1] - rows[0];
        let mut keys = &mut tile.keys[tile.starts[0] + start..][..n_rows * stride];
        let mut ids = &mut tile.ids[tile.starts[1] + start..][..n_rows * stride];
        let id = u32x8::splat(simd, triangle.id);
        let mut way_y = f64::from(top + rows[0] as i32) - depth.origin[1];
        while keys.len() >= stride {
            let (key_row, other_keys) = keys.split_at_mut(stride);
            let (id_row, other_ids) = ids.split_at_mut(stride);
            (keys, ids) = (other_keys, other_ids);
            let in_row = self.way + (depth.depth + depth.ddy * way_y);
            let (near, far) = in_row.split();
            let key: i32x8<S> = (near.narrow(far) + 0.0).bitcast();
            key.store_slice(eight(key_row));
            id.store_slice(eight(id_row));
            way_y += 1.0;
        }
        (8 * n_rows) as u32
    }
}

/// Values of an edge in the first two rows of a triangle, so many columns to the right.
#[inline(always)]
fn two_rows<S: Simd>(
    simd: S,
    TileTriangle { value, left, down, .. }: &TileTriangle,
    edge: usize,
    columns: i32x8<S>,
) -> i32x16<S> {
    let upper = i32x8::splat(simd, value[edge]) - columns * left[edge];
    upper.combine(upper + down[edge])
}

impl<S: Simd> Column<S> {
    /// [`Columns::rows`]; with `KEEPS` there is a `keep` to be asked.
    #[inline(always)]
    fn draw<const PARTLY: bool, const KEEPS: bool>(
        &self,
        simd: S,
        tile: &mut TileBuffer,
        triangle: &TileTriangle,
        rows: [usize; 2],
        mut keep: Option<&mut KeepSample<'_>>,
    ) -> u32 {
        let TileTriangle { rect, depth, down, .. } = triangle;
        let mut values = self.values;
        if PARTLY {
            let (way, [a, b, c]) = (rows[0] as i32 - rect.y[0] as i32, values);
            values = [a + down[0] * way, b + down[1] * way, c + down[2] * way];
        }
        let (stride, [left, top]) = (tile.stride_px(), tile.origin());
        assert!(stride >= 8);
        let start = rows[0] * stride + self.x;
        // As many of both, row after row, so that one comparison ends the loop and serves for all. Below the last
        // row of a tile there is room for another.
        let n_pairs = (rows[1] - rows[0]).div_ceil(2);
        let mut keys = &mut tile.keys[tile.starts[0] + start..][..2 * n_pairs * stride];
        let mut ids = &mut tile.ids[tile.starts[1] + start..][..2 * n_pairs * stride];
        let mut way_y = f64::from(top + rows[0] as i32) - depth.origin[1];
        let mut row = rows[0];
        let mut written = 0;
        while keys.len() >= 2 * stride {
            let (key_rows, other_keys) = keys.split_at_mut(2 * stride);
            let (id_rows, other_ids) = ids.split_at_mut(2 * stride);
            (keys, ids) = (other_keys, other_ids);
            let mut outside = i32x16::splat(simd, 0);
            if PARTLY {
                let [a, b, c] = values;
                outside = a | b | c;
            }
            if row + 1 == rows[1] {
                outside |= i32x8::splat(simd, 0).combine(i32x8::splat(simd, -1));
            }
            if !PARTLY || is_long::<S>() || outside.simd_ge(0).any_true() {
                let (upper_keys, lower_keys) = key_rows.split_at_mut(stride);
                let (upper_ids, lower_ids) = id_rows.split_at_mut(stride);
                let (upper_keys, lower_keys) = (eight(upper_keys), eight(lower_keys));
                let (upper_ids, lower_ids) = (eight(upper_ids), eight(lower_ids));
                let upper = self.way + (depth.depth + depth.ddy * way_y);
                let lower = self.way + (depth.depth + depth.ddy * (way_y + 1.0));
                let key = match PARTLY {
                    true => clamped_key(simd, depth, upper.narrow(lower)),
                    // The sum has no negative zero.
                    false => (upper.narrow(lower) + 0.0).bitcast(),
                };
                let old_key = i32x8::simd_from(simd, *upper_keys)
                    .combine(i32x8::simd_from(simd, *lower_keys));
                let old_id =
                    u32x8::simd_from(simd, *upper_ids).combine(u32x8::simd_from(simd, *lower_ids));
                let id = u32x16::splat(simd, triangle.id);
                let mut wins = wins_of(simd, outside, [key, old_key], [id, old_id]);
                if KEEPS && let Some(keep) = keep.as_deref_mut() {
                    let place = [16 * (left + self.x as i32) + 8, 16 * (top + row as i32) + 8];
                    let bits = kept(wins.to_bitmask(), place, triangle.id, keep);
                    wins = SimdMask::from_bitmask(simd, bits);
                }
                let (upper, lower) = wins.select(key, old_key).split();
                upper.store_slice(upper_keys);
                lower.store_slice(lower_keys);
                let (upper, lower) = wins.select(id, old_id).split();
                upper.store_slice(upper_ids);
                lower.store_slice(lower_ids);
                written += wins.to_bitmask().count_ones();
            }
            if PARTLY {
                let [a, b, c] = values;
                values = [a + down[0] * 2, b + down[1] * 2, c + down[2] * 2];
            }
            way_y += 2.0;
            row += 2;
        }
        written
    }
}

/// Whether a register holds sixteen samples: then all are drawn before anybody could foresee whether any is inside.
#[inline(always)]
pub(crate) fn is_long<S: Simd>() -> bool {
    S::f32s::LEN == 16
}

/// The keys of reversed depths, brought between those of the triangle.
///
/// Rounding keeps the order: it is the same before and after it. Bits of floats from 0 on are in their order, too, and
/// those of others, negative zero among them, are below.
#[inline(always)]
pub(crate) fn clamped_key<S: Simd>(simd: S, depth: &TileDepth, reversed: f32x16<S>) -> i32x16<S> {
    let (low, high) = (reversed_key(depth.low as f32), reversed_key(depth.high as f32));
    between(simd, [low, high], reversed)
}

/// [`clamped_key`] between two keys.
#[inline(always)]
pub(crate) fn between<S: Simd>(
    simd: S,
    [farthest, nearest]: [i32; 2],
    reversed: f32x16<S>,
) -> i32x16<S> {
    let key: i32x16<S> = reversed.bitcast();
    key.max(i32x16::splat(simd, farthest)).min(i32x16::splat(simd, nearest))
}

/// Which of sixteen samples a triangle wins: those not `outside`, and nearer than what is there, or as near with a lower
/// id. Ids are asked only where keys are equal, which hardly ever any are.
#[inline(always)]
pub(crate) fn wins_of<S: Simd>(
    _: S,
    outside: i32x16<S>,
    [key, old_key]: [i32x16<S>; 2],
    [id, old_id]: [u32x16<S>; 2],
) -> mask32x16<S> {
    let inside = outside.simd_ge(0);
    let ties = inside & key.simd_eq(old_key);
    let mut wins = inside & key.simd_gt(old_key);
    if ties.any_true() {
        wins |= ties & id.simd_lt(old_id);
    }
    wins
}

/// Which of two rows of eight pixels have matter; the first is at `place`.
#[inline(always)]
fn kept(bits: u64, [x, y]: [i32; 2], id: u32, keep: &mut KeepSample<'_>) -> u64 {
    let mut all = 0;
    for row in 0..2 {
        let asked = bits >> (8 * row) & 0xff;
        if asked != 0 {
            all |= (keep(id, [x, y + 16 * row], asked) & asked) << (8 * row);
        }
    }
    all
}

/// The first eight values.
#[inline(always)]
fn eight<T>(list: &mut [T]) -> &mut [T; 8] {
    list.first_chunk_mut().expect("rows have a margin of eight")
}
