//! Which samples of a tile a triangle wins: with one a pixel, two rows of eight pixels at a time; of large triangles,
//! block by block.
//!
//! Edge values are divided by the subpixel unit and rounded down: a step of one pixel changes them
//! by a multiple of it, so their signs, which are all that counts, survive, and 32 bits suffice
//! within a tile. Depth is the same plane in f64 that [`crate::cover`] evaluates, in the same
//! order. Large triangles go block by block of 8 x 8 pixels: past those outside an edge, and those where
//! everything is nearer.
//! Sources: Pineda 1988, "A Parallel Algorithm for Polygon Rasterization"; Abrash 2009,
//! "Rasterization on Larrabee"; Greene, Kass & Miller 1993 for the depths of blocks.

use fearless_simd::{Simd, f32x16, f64x8, i32x8, i32x16, mask32x16, prelude::*, u32x8, u32x16};

use crate::cover::{DepthPlane, Edges};
use crate::depth::{DepthFormat, reversed_key};
use crate::samples::Offset;
use crate::setup::ScreenTriangle;
use crate::tile::{BLOCK, TileBuffer, TileRect};

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
    fn clamped(&self, depth: f64) -> i32 {
        let depth = if depth < self.low { self.low } else { depth };
        let depth = if depth > self.high { self.high } else { depth };
        reversed_key(depth as f32)
    }

    /// Whether all depths between these are those of the triangle already.
    #[inline(always)]
    fn needs_no_clamp(&self, farthest: f64, nearest: f64) -> bool {
        farthest >= self.low && nearest <= self.high
    }
}

/// Asked, where a triangle's material has holes, whether it has matter at samples of up to eight
/// neighbouring pixels: the triangle, the place of the first in the picture in sixteenths of a pixel (the
/// next are 16 to the right each), and which are asked about, a bit each. Answers with the bits of
/// those that have.
pub type KeepSample<'k> = dyn FnMut(u32, [i32; 2], u64) -> u64 + 'k;

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

/// [`fill`] for triangles that fill whole blocks, in any grid; `offsets` are the tile's.
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
    let per_row = tile.side() / BLOCK;
    let range = Range::new(tile, triangle.depth);
    let [_, nearest] = range.of(range.columns(rect.x), rect.y);
    if tile.hides_wide(simd, rect, triangle.depth.clamped(nearest)) {
        return 0;
    }
    let edges = BlockEdges::new(triangle, offsets);
    let mut written = 0;
    let mut x = rect.x[0] / BLOCK * BLOCK;
    while x < rect.x[1] {
        let column = C::at(simd, tile, triangle, setup, x);
        let across = edges.across(triangle, x);
        let ways = range.columns([x, x + 8]);
        let mut y = rect.y[0];
        while y < rect.y[1] {
            let end = (y / BLOCK * BLOCK + BLOCK).min(rect.y[1]);
            let rows = [y, end];
            y = end;
            if across.misses(triangle, rows) {
                continue;
            }
            let block = rows[0] / BLOCK * per_row + x / BLOCK;
            let [farthest, nearest] = range.of(ways, rows);
            let nearest_key = triangle.depth.clamped(nearest);
            if tile.block_hides(simd, block, nearest_key) {
                continue;
            }
            let is_whole =
                across.fills(triangle, rows) && triangle.depth.needs_no_clamp(farthest, nearest);
            if is_whole && keep.is_none() {
                let farthest_key = triangle.depth.clamped(farthest);
                written += match tile.block_is_behind(block, farthest_key) {
                    true => column.rows_in_front(simd, tile, triangle, rows),
                    false => column.rows::<false>(simd, tile, triangle, rows, None),
                };
                if rows[1] - rows[0] == BLOCK {
                    tile.cover_block(block, [farthest_key, nearest_key]);
                    continue;
                }
            } else {
                let keep = keep.as_deref_mut();
                written += column.rows::<true>(simd, tile, triangle, rows, keep);
            }
            tile.touch(TileRect { x: [x, x + 1], y: rows }, nearest_key);
        }
        x += 8;
    }
    written
}

/// How far samples reach beyond the centres of their pixels, in edge values.
struct BlockEdges {
    /// The least and the most that any sample adds to the value of each edge.
    least: [i32; 3],
    most: [i32; 3],
}

impl BlockEdges {
    #[inline(always)]
    fn new<const N: usize>(triangle: &TileTriangle, offsets: &[Offset; N]) -> Self {
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
    fn across(&self, TileTriangle { rect, value, left, .. }: &TileTriangle, x: usize) -> Across {
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
struct Across {
    least: [i32; 3],
    most: [i32; 3],
}

impl Across {
    /// Whether no sample of some rows is inside all edges.
    #[inline(always)]
    #[expect(clippy::needless_range_loop, reason = "iterators beside vectors may become calls")]
    fn misses(&self, TileTriangle { rect, down, .. }: &TileTriangle, rows: [usize; 2]) -> bool {
        for edge in 0..3 {
            let row = if down[edge] > 0 { rows[1] - 1 } else { rows[0] };
            let way = down[edge] * (row - rect.y[0]) as i32;
            if self.most[edge] + way < 0 {
                return true;
            }
        }
        false
    }

    /// Whether all samples of some rows are inside all edges.
    #[inline(always)]
    #[expect(clippy::needless_range_loop, reason = "iterators beside vectors may become calls")]
    fn fills(&self, TileTriangle { rect, down, .. }: &TileTriangle, rows: [usize; 2]) -> bool {
        for edge in 0..3 {
            let row = if down[edge] < 0 { rows[1] - 1 } else { rows[0] };
            let way = down[edge] * (row - rect.y[0]) as i32;
            if self.least[edge] + way < 0 {
                return false;
            }
        }
        true
    }
}

/// What a sample away from the centre of its pixel adds to the value of an edge.
#[inline(always)]
pub(crate) fn shift(rest: i32, left: i32, down: i32, [x, y]: Offset) -> i32 {
    // Per pixel `left` units of 256; per sixteenth sixteen of them.
    let way = (down as i64 * y as i64 - left as i64 * x as i64) * 16;
    ((rest as i64 + way) >> 8) as i32
}

/// The least and the greatest depth, before clamping, that a triangle's plane can have in parts of a tile:
/// rounding keeps the order of depths along x and along y, so they are found at corners.
struct Range {
    depth: TileDepth,
    /// Upper left corner of the tile in the picture, px.
    origin: [i32; 2],
    /// How far samples are from the centres of their pixels, px.
    reach: f64,
}

impl Range {
    #[inline(always)]
    fn new(tile: &TileBuffer, depth: TileDepth) -> Self {
        Range { depth, origin: tile.origin(), reach: f64::from(tile.samples().reach()) / 16.0 }
    }

    /// What the way to some columns adds to the depth, at the far end and at the near one.
    #[inline(always)]
    fn columns(&self, [start, end]: [usize; 2]) -> [f64; 2] {
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
        let keys = &mut tile.keys[tile.starts[0] + start..];
        let ids = &mut tile.ids[tile.starts[1] + start..];
        let id = u32x8::splat(simd, triangle.id);
        let mut y = f64::from(top + rows[0] as i32);
        for row in 0..rows[1] - rows[0] {
            let in_row = self.way + (depth.depth + depth.ddy * (y - depth.origin[1]));
            let (near, far) = in_row.split();
            let key: i32x8<S> = (near.narrow(far) + 0.0).bitcast();
            key.store_slice(eight(&mut keys[row * stride..]));
            id.store_slice(eight(&mut ids[row * stride..]));
            y += 1.0;
        }
        (8 * (rows[1] - rows[0])) as u32
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
            if !PARTLY || outside.simd_ge(0).any_true() {
                let (upper_keys, lower_keys) = key_rows.split_at_mut(stride);
                let (upper_ids, lower_ids) = id_rows.split_at_mut(stride);
                let (upper_keys, lower_keys) = (eight(upper_keys), eight(lower_keys));
                let (upper_ids, lower_ids) = (eight(upper_ids), eight(lower_ids));
                let upper = self.way + (depth.depth + depth.ddy * way_y);
                let lower = self.way + (depth.depth + depth.ddy * (way_y + 1.0));
                let mut reversed = upper.narrow(lower);
                if PARTLY {
                    // Rounding keeps the order: it is the same before and after it.
                    let (low, high) = (depth.low as f32, depth.high as f32);
                    let (low, high) = (f32x16::splat(simd, low), f32x16::splat(simd, high));
                    reversed = reversed.max(low).min(high);
                }
                // The sum has no negative zero; bits of floats from 0 on are in their order.
                let key: i32x16<S> = (reversed + 0.0).bitcast();
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

/// Which of sixteen samples a triangle wins: those not `outside`, and nearer than what is there: the key and the old
/// one, of which neither is negative. Where they are equal, the higher id is behind by one.
#[inline(always)]
pub(crate) fn wins_of<S: Simd>(
    simd: S,
    outside: i32x16<S>,
    [key, old_key]: [i32x16<S>; 2],
    [id, old_id]: [u32x16<S>; 2],
) -> mask32x16<S> {
    let (none, minus_one) = (i32x16::splat(simd, 0), i32x16::splat(simd, -1));
    let behind = id.simd_ge(old_id).select(minus_one, none);
    (outside | (key - old_key + behind)).simd_ge(0)
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

/// Draws a screen triangle sample by sample, in 64-bit integers: for triangles that do not fit the
/// wide code, and for every other grid of positions and format of depth.
pub(crate) fn fill_plain<D: DepthFormat, const BITS: u32>(
    tile: &mut TileBuffer,
    triangle: &ScreenTriangle,
    rect: TileRect,
    mut keep: Option<&mut KeepSample<'_>>,
) -> u32 {
    tile.touch(rect, i32::MAX);
    let (stride, n_samples) = (tile.stride_px(), tile.samples().count());
    let [left, top] = tile.origin().map(i64::from);
    let mut written = 0;
    let centre = Edges::new::<BITS>(triangle, [0, 0]);
    let depth = DepthPlane::new::<BITS>(triangle, &centre);
    for (sample, offset) in tile.samples().offsets().iter().enumerate() {
        // Sixteenths are whole units from four subpixel bits on.
        let units = offset.map(|sixteenths| (i64::from(sixteenths) << BITS) / 16);
        let edges = Edges::new::<BITS>(triangle, units);
        let [x_shift, y_shift] = offset.map(|sixteenths| f64::from(sixteenths) / 16.0);
        for row in rect.y[0]..rect.y[1] {
            let y = top + row as i64;
            let columns = rect.x.map(|column| left + column as i64);
            let (first, last) = edges.row::<BITS>(y).covered(columns[0], columns[1]);
            let in_row = depth.row(y as f64 + y_shift);
            for x in first..last {
                let at = (row * stride + (x - left) as usize) * n_samples + sample;
                let (key_at, id_at) = (tile.starts[0] + at, tile.starts[1] + at);
                let key = D::key(D::encode(depth.at(in_row, x as f64 + x_shift)));
                let old = (tile.keys[key_at], tile.ids[id_at]);
                let wins = key > old.0 || (key == old.0 && triangle.id < old.1);
                let place = [16 * x as i32 + 8 + offset[0], 16 * y as i32 + 8 + offset[1]];
                if wins
                    && keep.as_deref_mut().is_none_or(|keep| keep(triangle.id, place, 1) & 1 == 1)
                {
                    (tile.keys[key_at], tile.ids[id_at]) = (key, triangle.id);
                    written += 1;
                }
            }
        }
    }
    written
}
