//! Which samples of a tile a triangle wins, eight pixels at a time.
//!
//! Edge values are divided by the subpixel unit and rounded down: a step of one pixel changes them
//! by a multiple of it, so their signs, which are all that counts, survive, and 32 bits suffice
//! within a tile. Depth is the same plane in f64 that [`crate::cover`] evaluates, in the same
//! order. Large triangles go block by block of 8 x 8 pixels: past those outside an edge, and those where
//! everything is nearer.
//! Sources: Pineda 1988, "A Parallel Algorithm for Polygon Rasterization"; Abrash 2009,
//! "Rasterization on Larrabee"; Greene, Kass & Miller 1993 for the depths of blocks.

use fearless_simd::{Simd, f32x8, f64x4, i32x8, prelude::*, u32x8};

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

/// Draws; `offsets` are the tile's. Returns how many samples were won.
#[inline(always)]
pub(crate) fn fill<S: Simd, const N: usize>(
    simd: S,
    tile: &mut TileBuffer,
    triangle: &TileTriangle,
    offsets: &[Offset; N],
    mut keep: Option<&mut KeepSample<'_>>,
) -> u32 {
    let TileTriangle { rect, .. } = *triangle;
    let mut written = 0;
    let mut x = rect.x[0];
    while x < rect.x[1] {
        let column = Column::new(simd, tile, triangle, offsets, x);
        written += match keep.as_deref_mut() {
            None => column.rows::<true, false>(simd, tile, triangle, rect.y, None),
            keep => column.rows::<true, true>(simd, tile, triangle, rect.y, keep),
        };
        x += 8;
    }
    if written > 0 {
        tile.touch(rect, reversed_key(triangle.depth.high as f32));
    }
    written
}

/// [`fill`] for triangles that fill whole blocks.
#[inline(always)]
pub(crate) fn fill_blocks<S: Simd, const N: usize>(
    simd: S,
    tile: &mut TileBuffer,
    triangle: &TileTriangle,
    offsets: &[Offset; N],
    mut keep: Option<&mut KeepSample<'_>>,
) -> u32 {
    let TileTriangle { rect, .. } = *triangle;
    let per_row = tile.side() / BLOCK;
    let range = Range::new(tile, triangle.depth);
    let [_, nearest] = range.of(range.columns(rect.x), rect.y);
    if tile.hides_wide(simd, rect, triangle.depth.clamped(nearest)) {
        return 0;
    }
    let mut written = 0;
    let mut x = rect.x[0] / BLOCK * BLOCK;
    while x < rect.x[1] {
        let column = Column::new(simd, tile, triangle, offsets, x);
        let ways = range.columns([x, x + 8]);
        let mut y = rect.y[0];
        while y < rect.y[1] {
            let end = (y / BLOCK * BLOCK + BLOCK).min(rect.y[1]);
            let rows = [y, end];
            y = end;
            if column.misses(triangle, rows) {
                continue;
            }
            let block = rows[0] / BLOCK * per_row + x / BLOCK;
            let [farthest, nearest] = range.of(ways, rows);
            let nearest_key = triangle.depth.clamped(nearest);
            if tile.block_hides(simd, block, nearest_key) {
                continue;
            }
            let is_whole =
                column.fills(triangle, rows) && triangle.depth.needs_no_clamp(farthest, nearest);
            if is_whole && keep.is_none() {
                let farthest_key = triangle.depth.clamped(farthest);
                written += match tile.block_is_behind(block, farthest_key) {
                    true => column.rows_in_front(simd, tile, triangle, rows),
                    false => column.rows::<false, false>(simd, tile, triangle, rows, None),
                };
                if rows[1] - rows[0] == BLOCK {
                    tile.cover_block(block, [farthest_key, nearest_key]);
                    continue;
                }
            } else {
                written += match keep.as_deref_mut() {
                    None => column.rows::<true, false>(simd, tile, triangle, rows, None),
                    keep => column.rows::<true, true>(simd, tile, triangle, rows, keep),
                };
            }
            tile.touch(TileRect { x: [x, x + 1], y: rows }, nearest_key);
        }
        x += 8;
    }
    written
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

/// Eight columns of pixels.
struct Column<S: Simd, const N: usize> {
    /// First column in the tile.
    x: usize,
    /// Edge values in the first row of the triangle.
    values: [i32x8<S>; 3],
    /// What each sample adds to them.
    shifts: [[i32; 3]; N],
    /// Depth that the way from the plane's origin along x adds, by sample.
    depths: [[f64x4<S>; 2]; N],
    offsets: [Offset; N],
    /// Row of the values.
    first_row: usize,
}

impl<S: Simd, const N: usize> Column<S, N> {
    #[inline(always)]
    fn new(
        simd: S,
        tile: &TileBuffer,
        triangle: &TileTriangle,
        offsets: &[Offset; N],
        x: usize,
    ) -> Self {
        let TileTriangle { rect, value, rest, left, down, depth, .. } = triangle;
        let lanes =
            i32x8::simd_from(simd, [0, 1, 2, 3, 4, 5, 6, 7]) + (x as i32 - rect.x[0] as i32);
        let values = [
            i32x8::splat(simd, value[0]) - lanes * left[0],
            i32x8::splat(simd, value[1]) - lanes * left[1],
            i32x8::splat(simd, value[2]) - lanes * left[2],
        ];
        let at = f64::from(tile.origin()[0] + x as i32);
        let low = f64x4::simd_from(simd, [at, at + 1.0, at + 2.0, at + 3.0]);
        let high = low + 4.0;
        let mut shifts = [[0; 3]; N];
        let mut depths = [[low; 2]; N];
        for sample in 0..N {
            let [sx, sy] = offsets[sample];
            for edge in 0..3 {
                // Per pixel `left` units of 256; per sixteenth sixteen of them.
                let shift = (down[edge] as i64 * sy as i64 - left[edge] as i64 * sx as i64) * 16;
                shifts[sample][edge] = ((rest[edge] as i64 + shift) >> 8) as i32;
            }
            let sx = f64::from(sx) * (1.0 / 16.0);
            depths[sample] = [
                (low + sx - depth.origin[0]) * depth.ddx,
                (high + sx - depth.origin[0]) * depth.ddx,
            ];
        }
        Column { x, values, shifts, depths, offsets: *offsets, first_row: rect.y[0] }
    }

    /// Whether no sample of some rows is inside all edges.
    #[inline(always)]
    fn misses(&self, triangle: &TileTriangle, rows: [usize; 2]) -> bool {
        for edge in 0..3 {
            let (left, down) = (triangle.left[edge], triangle.down[edge]);
            let row = if down > 0 { rows[1] - 1 } else { rows[0] };
            let lane = if left < 0 { 7 } else { 0 };
            let mut shift = self.shifts[0][edge];
            for sample in 1..N {
                shift = shift.max(self.shifts[sample][edge]);
            }
            let way = down * (row - self.first_row) as i32;
            if self.values[edge][lane] + way + shift < 0 {
                return true;
            }
        }
        false
    }

    /// Whether all samples of some rows are inside all edges.
    #[inline(always)]
    fn fills(&self, triangle: &TileTriangle, rows: [usize; 2]) -> bool {
        for edge in 0..3 {
            let (left, down) = (triangle.left[edge], triangle.down[edge]);
            let row = if down < 0 { rows[1] - 1 } else { rows[0] };
            let lane = if left > 0 { 7 } else { 0 };
            let mut shift = self.shifts[0][edge];
            for sample in 1..N {
                shift = shift.min(self.shifts[sample][edge]);
            }
            let way = down * (row - self.first_row) as i32;
            if self.values[edge][lane] + way + shift < 0 {
                return false;
            }
        }
        true
    }

    /// Draws some rows; returns how many samples were won. Without `PARTLY` all samples are covered, and
    /// their depths need no clamp; with `KEEPS` there is a `keep` to be asked.
    #[inline(always)]
    fn rows<const PARTLY: bool, const KEEPS: bool>(
        &self,
        simd: S,
        tile: &mut TileBuffer,
        triangle: &TileTriangle,
        rows: [usize; 2],
        mut keep: Option<&mut KeepSample<'_>>,
    ) -> u32 {
        let rows = if PARTLY && N > 1 { self.rows_met(simd, triangle, rows) } else { rows };
        let mut values = self.values;
        if PARTLY {
            values = self.values_at(triangle, rows[0]);
        }
        let (stride, plane, [left, top]) = (tile.stride(), tile.plane(), tile.origin());
        assert!(stride >= 8);
        let mut written = i32x8::splat(simd, 0);
        for sample in 0..N {
            let start = sample * plane + rows[0] * stride + self.x;
            // As many of both, row after row, so that one comparison ends the loop and serves for all.
            let n = (rows[1] - rows[0]) * stride;
            let mut keys = &mut tile.keys[tile.starts[0] + start..][..n];
            let mut ids = &mut tile.ids[tile.starts[1] + start..][..n];
            let [a, b, c] = self.shifts[sample];
            let [_, offset_y] = self.offsets[sample];
            let y = f64::from(top + rows[0] as i32) + f64::from(offset_y) * (1.0 / 16.0);
            let mut pixels = Pixels {
                values: match N {
                    1 => values,
                    _ => [values[0] + a, values[1] + b, values[2] + c],
                },
                way_y: y - triangle.depth.origin[1],
                written,
            };
            let mut place = [left + self.x as i32, top + rows[0] as i32];
            while keys.len() >= stride {
                let (row_keys, other_keys) = keys.split_at_mut(stride);
                let (row_ids, other_ids) = ids.split_at_mut(stride);
                self.sample::<PARTLY, KEEPS>(
                    simd,
                    triangle,
                    &mut pixels,
                    sample,
                    eight(row_keys),
                    eight(row_ids),
                    place,
                    keep.as_deref_mut(),
                );
                pixels.step::<PARTLY>(triangle);
                place[1] += 1;
                (keys, ids) = (other_keys, other_ids);
            }
            written = pixels.written;
        }
        written.reduce_sum() as u32
    }

    /// Edge values at the centres of a row of pixels.
    #[inline(always)]
    fn values_at(&self, TileTriangle { down, .. }: &TileTriangle, row: usize) -> [i32x8<S>; 3] {
        let way = row as i32 - self.first_row as i32;
        [
            self.values[0] + down[0] * way,
            self.values[1] + down[1] * way,
            self.values[2] + down[2] * way,
        ]
    }

    /// Some rows without those at both ends in which no sample can be covered: each edge is where it lies
    /// for the sample that is farthest inside, so that one look serves for all samples.
    #[inline(always)]
    fn rows_met(
        &self,
        simd: S,
        triangle: &TileTriangle,
        [mut first, mut end]: [usize; 2],
    ) -> [usize; 2] {
        let mut reach = self.shifts[0];
        for sample in 1..N {
            let [a, b, c] = self.shifts[sample];
            reach = [reach[0].max(a), reach[1].max(b), reach[2].max(c)];
        }
        let down = triangle.down;
        let [a, b, c] = self.values_at(triangle, first);
        let mut values = [a + reach[0], b + reach[1], c + reach[2]];
        while first < end && !any_inside(simd, values) {
            values = [values[0] + down[0], values[1] + down[1], values[2] + down[2]];
            first += 1;
        }
        let [a, b, c] = self.values_at(triangle, end - 1);
        let mut values = [a + reach[0], b + reach[1], c + reach[2]];
        while first < end && !any_inside(simd, values) {
            values = [values[0] - down[0], values[1] - down[1], values[2] - down[2]];
            end -= 1;
        }
        [first, end]
    }

    /// One sample of eight pixels: those that the triangle wins become its own. `keys` and `ids` are the
    /// pixels', the first of which is at `place` in the picture.
    ///
    /// What is decided stays a sign as long as it can: masks that live on behind a branch are packed and
    /// unpacked.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "one loop's body")]
    fn sample<const PARTLY: bool, const KEEPS: bool>(
        &self,
        simd: S,
        triangle: &TileTriangle,
        pixels: &mut Pixels<S>,
        sample: usize,
        keys: &mut [i32; 8],
        ids: &mut [u32; 8],
        place: [i32; 2],
        keep: Option<&mut KeepSample<'_>>,
    ) {
        let depth = &triangle.depth;
        let mut outside = i32x8::splat(simd, 0);
        if PARTLY {
            let [a, b, c] = pixels.values;
            outside = a | b | c;
            if !outside.simd_ge(0).any_true() {
                return;
            }
        }
        let in_row = depth.depth + depth.ddy * pixels.way_y;
        let [near, far] = self.depths[sample];
        let mut reversed = (near + in_row).narrow(far + in_row);
        if PARTLY {
            // Rounding keeps the order: it is the same before and after it.
            let (low, high) = (depth.low as f32, depth.high as f32);
            reversed = clamp(reversed, f32x8::splat(simd, low), f32x8::splat(simd, high));
        }
        // The sum has no negative zero; bits of floats from 0 on are in their order.
        let key: i32x8<S> = (reversed + 0.0).bitcast();
        let old_key = i32x8::simd_from(simd, *keys);
        // Neither is negative.
        let ahead = key - old_key;
        if !(outside | ahead).simd_ge(0).any_true() {
            return;
        }
        let (id, old_id) = (u32x8::splat(simd, triangle.id), u32x8::simd_from(simd, *ids));
        // A mask's own bits are -1 and 0.
        let (none, minus_one) = (i32x8::splat(simd, 0), i32x8::splat(simd, -1));
        // Where keys are equal, the higher id is behind by one.
        let behind = id.simd_ge(old_id).select(minus_one, none);
        let mut wins = (outside | (ahead + behind)).simd_ge(0);
        if KEEPS && let Some(keep) = keep {
            let [x, y] = self.offsets[sample];
            let place = [16 * place[0] + 8 + x, 16 * place[1] + 8 + y];
            let bits = wins.to_bitmask();
            let bits = if bits == 0 { 0 } else { keep(triangle.id, place, bits) & bits };
            wins = SimdMask::from_bitmask(simd, bits);
        }
        wins.select(key, old_key).store_slice(keys);
        wins.select(id, old_id).store_slice(ids);
        pixels.written -= wins.select(minus_one, none);
    }

    /// [`Column::rows`] where all samples are covered and nearer than what is there.
    #[inline(always)]
    fn rows_in_front(
        &self,
        simd: S,
        tile: &mut TileBuffer,
        triangle: &TileTriangle,
        rows: [usize; 2],
    ) -> u32 {
        let TileTriangle { depth, .. } = triangle;
        let (stride, plane, [_, top]) = (tile.stride(), tile.plane(), tile.origin());
        let start = rows[0] * stride + self.x;
        let keys = &mut tile.keys[tile.starts[0] + start..];
        let ids = &mut tile.ids[tile.starts[1] + start..];
        let id = u32x8::splat(simd, triangle.id);
        let mut row_y = f64::from(top + rows[0] as i32);
        for row in 0..rows[1] - rows[0] {
            for sample in 0..N {
                let y = row_y + f64::from(self.offsets[sample][1]) * (1.0 / 16.0);
                let in_row = depth.depth + depth.ddy * (y - depth.origin[1]);
                let [near, far] = self.depths[sample];
                let key: i32x8<S> = ((near + in_row).narrow(far + in_row) + 0.0).bitcast();
                let at = sample * plane + row * stride;
                key.store_slice(eight(&mut keys[at..]));
                id.store_slice(eight(&mut ids[at..]));
            }
            row_y += 1.0;
        }
        (8 * N * (rows[1] - rows[0])) as u32
    }
}

/// A sample of eight neighbouring pixels, row after row.
struct Pixels<S: Simd> {
    /// Edge values at the samples.
    values: [i32x8<S>; 3],
    /// From the origin of the plane of depth down to the samples, px: multiples of 1 / 256, so that sums
    /// are exact.
    way_y: f64,
    /// How many samples were won, by lane.
    written: i32x8<S>,
}

impl<S: Simd> Pixels<S> {
    /// To the row below.
    #[inline(always)]
    fn step<const PARTLY: bool>(&mut self, TileTriangle { down, .. }: &TileTriangle) {
        if PARTLY {
            let [a, b, c] = self.values;
            self.values = [a + down[0], b + down[1], c + down[2]];
        }
        self.way_y += 1.0;
    }
}

/// None of the three is NaN, and negative zeros are lost later: all instruction sets agree on maxima.
#[inline(always)]
pub(crate) fn clamp<S: Simd>(depth: f32x8<S>, low: f32x8<S>, high: f32x8<S>) -> f32x8<S> {
    depth.max(low).min(high)
}

/// Whether one of eight places is inside all three edges.
#[inline(always)]
fn any_inside<S: Simd>(_: S, [a, b, c]: [i32x8<S>; 3]) -> bool {
    (a | b | c).simd_ge(0).any_true()
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
    let (stride, plane) = (tile.stride(), tile.plane());
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
                let at = sample * plane + row * stride + (x - left) as usize;
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
