//! Triangles of few columns with one sample a pixel: four rows of four pixels at a time.
//!
//! Rows of eight pixels would be empty for the most part. Edges, depth and ties are those of [`crate::fill`], operation
//! by operation.

use fearless_simd::{Simd, f64x8, i16x32, i32x4, i32x16, prelude::*, u32x4, u32x16};

use crate::depth::reversed_key;
use crate::fill::{TileTriangle, clamped_key, is_long, wins_of};
use crate::tile::TileBuffer;

/// Pixels along each side of a group.
pub(crate) const SIDE: usize = 4;

/// By lane, how many rows down and columns to the right, twice as many 16-bit numbers.
static WAYS: [i16; 32] = {
    let mut all = [0; 32];
    let mut lane = 0;
    while lane < 16 {
        (all[2 * lane], all[2 * lane + 1]) = ((lane / SIDE) as i16, (lane % SIDE) as i16);
        lane += 1;
    }
    all
};

/// By how many rows of a group there are, -1 in those that are not.
static BEYOND: [[i32; 16]; SIDE] = {
    let mut all = [[0; 16]; SIDE];
    let mut lane = 0;
    while lane < 16 {
        let mut n = 0;
        while n <= lane / SIDE {
            all[n][lane] = -1;
            n += 1;
        }
        lane += 1;
    }
    all
};

/// Draws a triangle of at most [`SIDE`] columns whose edges fit 16 bits. `pairs` are those of
/// [`Values::of_short`](crate::patch::Values::of_short). Returns how many samples were won.
#[inline(always)]
pub(crate) fn fill<S: Simd>(
    simd: S,
    tile: &mut TileBuffer,
    triangle: &TileTriangle,
    pairs: [i32; 3],
) -> u32 {
    let TileTriangle { rect, value, left, down, depth, .. } = triangle;
    // Within the tile: what is left of a box, at the border, is outside.
    let x = rect.x[0].min(tile.side() - SIDE);
    let back = (rect.x[0] - x) as i32;
    let ways = i16x32::simd_from(simd, WAYS);
    let mut values = [
        edge(simd, ways, pairs[0], value[0] + left[0] * back),
        edge(simd, ways, pairs[1], value[1] + left[1] * back),
        edge(simd, ways, pairs[2], value[2] + left[2] * back),
    ];
    let [origin_x, origin_y] = tile.origin();
    // Multiples of 1 / 256: exact.
    let way_x = f64::from(origin_x + x as i32) - depth.origin[0];
    let way_y = f64::from(origin_y + rect.y[0] as i32) - depth.origin[1];
    let columns = f64x8::simd_from(simd, [0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0]);
    let in_column = (columns + way_x) * depth.ddx;
    let mut upper = f64x8::simd_from(simd, [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]) + way_y;
    let id = u32x4::splat(simd, triangle.id);
    let stride = tile.stride_px();
    let start = rect.y[0] * stride + x;
    // As many of both, so that one comparison ends the loop and serves for all. Below the last row of a tile there is
    // room for a group.
    let n_groups = (rect.y[1] - rect.y[0]).div_ceil(SIDE);
    let n = n_groups * SIDE * stride;
    let mut keys = &mut tile.keys[tile.starts[0] + start..][..n];
    let mut ids = &mut tile.ids[tile.starts[1] + start..][..n];
    let mut n_rows = rect.y[1] - rect.y[0];
    let mut written = 0;
    while keys.len() >= SIDE * stride {
        let (group_keys, other_keys) = keys.split_at_mut(SIDE * stride);
        let (group_ids, other_ids) = ids.split_at_mut(SIDE * stride);
        (keys, ids) = (other_keys, other_ids);
        let mut outside = values[0] | values[1] | values[2];
        if n_rows < SIDE {
            outside |= i32x16::simd_from(simd, BEYOND[n_rows]);
        }
        if is_long::<S>() || outside.simd_ge(0).any_true() {
            let lower = upper + 2.0;
            let upper_depth = in_column + (upper * depth.ddy + depth.depth);
            let lower_depth = in_column + (lower * depth.ddy + depth.depth);
            let key = clamped_key(simd, depth, upper_depth.narrow(lower_depth));
            let [a, b, c, d] = rows(group_keys, stride);
            let old_key = four(simd, a, b, c, d);
            let [i, j, k, l] = rows(group_ids, stride);
            let (two_ids, old_id) = (id.combine(id), four_ids(simd, i, j, k, l));
            let four_ids = two_ids.combine(two_ids);
            let wins = wins_of(simd, outside, [key, old_key], [four_ids, old_id]);
            let (upper, lower) = wins.select(key, old_key).split();
            let ((p, q), (r, s)) = (upper.split(), lower.split());
            p.store_slice(a);
            q.store_slice(b);
            r.store_slice(c);
            s.store_slice(d);
            let (none, all) = (i32x16::splat(simd, 0), i32x16::splat(simd, -1));
            let (upper, lower) = wins.select(all, none).split();
            let ((p, q), (r, s)) = (upper.split(), lower.split());
            write(simd, p, id, i);
            write(simd, q, id, j);
            write(simd, r, id, k);
            write(simd, s, id, l);
            written += wins.to_bitmask().count_ones();
        }
        values = [values[0] + down[0] * 4, values[1] + down[1] * 4, values[2] + down[2] * 4];
        upper += 4.0;
        n_rows = n_rows.saturating_sub(SIDE);
    }
    if written > 0 {
        tile.touch(*rect, reversed_key(depth.high as f32));
    }
    written
}

/// The values of an edge in a group, from that in its first pixel.
#[inline(always)]
fn edge<S: Simd>(simd: S, ways: i16x32<S>, pair: i32, value: i32) -> i32x16<S> {
    let pair: i16x32<S> = i32x16::splat(simd, pair).bitcast();
    simd.pairwise_dot_product_i16x32(pair, ways) + value
}

/// The first pixels of four rows.
#[inline(always)]
fn rows<T>(group: &mut [T], stride: usize) -> [&mut [T; SIDE]; SIDE] {
    let (upper, lower) = group.split_at_mut(2 * stride);
    let (a, b) = upper.split_at_mut(stride);
    let (c, d) = lower.split_at_mut(stride);
    [first(a), first(b), first(c), first(d)]
}

#[inline(always)]
fn first<T>(row: &mut [T]) -> &mut [T; SIDE] {
    row.first_chunk_mut().expect("rows are longer")
}

#[inline(always)]
fn four<S: Simd>(
    simd: S,
    a: &[i32; SIDE],
    b: &[i32; SIDE],
    c: &[i32; SIDE],
    d: &[i32; SIDE],
) -> i32x16<S> {
    let upper = i32x4::simd_from(simd, *a).combine(i32x4::simd_from(simd, *b));
    upper.combine(i32x4::simd_from(simd, *c).combine(i32x4::simd_from(simd, *d)))
}

#[inline(always)]
fn four_ids<S: Simd>(
    simd: S,
    a: &[u32; SIDE],
    b: &[u32; SIDE],
    c: &[u32; SIDE],
    d: &[u32; SIDE],
) -> u32x16<S> {
    let upper = u32x4::simd_from(simd, *a).combine(u32x4::simd_from(simd, *b));
    upper.combine(u32x4::simd_from(simd, *c).combine(u32x4::simd_from(simd, *d)))
}

/// Writes `id` where `wins` is negative.
#[inline(always)]
fn write<S: Simd>(simd: S, wins: i32x4<S>, id: u32x4<S>, ids: &mut [u32; SIDE]) {
    wins.simd_lt(0).select(id, u32x4::simd_from(simd, *ids)).store_slice(ids);
}
