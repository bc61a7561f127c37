//! Triangles of a few pixels, eight side by side: the same pixel of each one's box at a time.
//!
//! A triangle's rows of eight pixels would be empty for the most part; eight triangles fill the lanes.
//! Only samples that are covered are then tried one by one. Edges, depth and ties are those of
//! [`crate::fill`], operation by operation.

use fearless_simd::{Simd, SimdCvtFloat, f32x8, f64x4, i32x8, mask32x8, prelude::*};

use crate::fill::clamp;
use crate::samples::Offset;
use crate::tile::{TileBuffer, TileRect};

/// Boxes of at most this many pixels along each axis are drawn here.
pub(crate) const SMALL: i32 = 6;

/// Eight triangles in a tile; those that are not to be drawn may hold anything.
pub(crate) struct Small<'s, S: Simd> {
    /// First pixel of the box, in the tile, and how many there are.
    pub x: i32x8<S>,
    pub y: i32x8<S>,
    pub width: i32x8<S>,
    pub height: i32x8<S>,
    /// As in [`TileTriangle`](crate::fill::TileTriangle).
    pub value: [i32x8<S>; 3],
    pub rest: [i32x8<S>; 3],
    pub left: [i32x8<S>; 3],
    pub down: [i32x8<S>; 3],
    /// Twice the area, square units.
    pub area: i32x8<S>,
    /// The first corner, units.
    pub corner: [i32x8<S>; 2],
    /// Reversed depth of the corners, clockwise.
    pub depth: &'s [[f64; 8]; 3],
    pub id: &'s [u32; 8],
}

/// Planes of depth of four triangles, as [`TileDepth`](crate::fill::TileDepth).
#[derive(Clone, Copy)]
struct Depth4<S: Simd> {
    depth: f64x4<S>,
    origin: [f64x4<S>; 2],
    ddx: f64x4<S>,
    ddy: f64x4<S>,
}

impl<S: Simd> Depth4<S> {
    /// Reversed depth, before clamping, at points of the picture, pixels; centres have whole numbers here.
    #[inline(always)]
    fn at(&self, x: f64x4<S>, y: f64x4<S>) -> f64x4<S> {
        let row = self.depth + self.ddy * (y - self.origin[1]);
        row + self.ddx * (x - self.origin[0])
    }
}

impl<S: Simd> Small<'_, S> {
    /// Draws the triangles of `lanes`, a bit each. Returns how many samples were won.
    #[inline(always)]
    pub fn fill<const N: usize>(
        &self,
        simd: S,
        tile: &mut TileBuffer,
        offsets: &[Offset; N],
        lanes: u64,
    ) -> u32 {
        let zero = i32x8::splat(simd, 0);
        let wanted: mask32x8<S> = SimdMask::from_bitmask(simd, lanes);
        let (width, height) = (wanted.select(self.width, zero), wanted.select(self.height, zero));
        let (columns, rows) = (width.reduce_max(), height.reduce_max());
        let (stride, plane, [left, top]) = (tile.stride(), tile.plane(), tile.origin());
        let first: [i32; 8] = (self.y * stride as i32 + self.x).into();
        let (first_x, first_y) = (widened(simd, self.x + left), widened(simd, self.y + top));
        let mut shifts = [[zero; 3]; N];
        for sample in 0..N {
            shifts[sample] = [
                self.shift(0, offsets[sample]),
                self.shift(1, offsets[sample]),
                self.shift(2, offsets[sample]),
            ];
        }
        let planes = self.planes(simd);
        let [lowest, highest] = self.limits(simd);
        let [keys_start, ids_start] = tile.starts;
        // As many of both, so that one comparison serves for both.
        let n = N * plane;
        let keys = &mut tile.keys[keys_start..][..n];
        let ids = &mut tile.ids[ids_start..][..n];
        let mut in_row = self.value;
        let (mut written, mut touched) = (0, 0_u64);
        for row in 0..rows {
            let in_rows = height.simd_gt(row);
            let mut value = in_row;
            for column in 0..columns {
                let in_box = in_rows & width.simd_gt(column);
                for sample in 0..N {
                    let [a, b, c] = &shifts[sample];
                    let signs = match N {
                        1 => value[0] | value[1] | value[2],
                        _ => (value[0] + *a) | (value[1] + *b) | (value[2] + *c),
                    };
                    let mut covered = (signs.simd_ge(0) & in_box).to_bitmask();
                    if covered == 0 {
                        continue;
                    }
                    let [sx, sy] = offsets[sample];
                    let x = f64::from(column) + f64::from(sx) * (1.0 / 16.0);
                    let y = f64::from(row) + f64::from(sy) * (1.0 / 16.0);
                    let low = planes[0].at(first_x[0] + x, first_y[0] + y);
                    let high = planes[1].at(first_x[1] + x, first_y[1] + y);
                    let depth = clamp(low.narrow(high), lowest, highest);
                    let key: i32x8<S> = (depth + 0.0).bitcast();
                    let key: [i32; 8] = key.into();
                    let start = sample * plane + row as usize * stride + column as usize;
                    let mut won = 0_u64;
                    while covered != 0 {
                        let lane = covered.trailing_zeros() as usize % 8;
                        covered &= covered - 1;
                        let at = start + first[lane] as usize;
                        let old_key = keys[at];
                        if key[lane] < old_key {
                            continue;
                        }
                        if key[lane] > old_key || self.id[lane] < ids[at] {
                            (keys[at], ids[at]) = (key[lane], self.id[lane]);
                            won |= 1 << lane;
                        }
                    }
                    touched |= won;
                    written += won.count_ones();
                }
                value = [value[0] - self.left[0], value[1] - self.left[1], value[2] - self.left[2]];
            }
            let down = &self.down;
            in_row = [in_row[0] + down[0], in_row[1] + down[1], in_row[2] + down[2]];
        }
        self.touch(tile, touched);
        written
    }

    /// What a sample away from the centre adds to the values of an edge.
    #[inline(always)]
    fn shift(&self, edge: usize, [x, y]: Offset) -> i32x8<S> {
        // Per pixel `left` units of 256; per sixteenth sixteen of them.
        let way = (self.down[edge] * y - self.left[edge] * x) * 16;
        (self.rest[edge] + way) >> 8
    }

    /// Notes where the triangles of `lanes` have drawn.
    #[inline(always)]
    fn touch(&self, tile: &mut TileBuffer, mut lanes: u64) {
        let (x, y): ([i32; 8], [i32; 8]) = (self.x.into(), self.y.into());
        let (end_x, end_y): ([i32; 8], [i32; 8]) =
            ((self.x + self.width).into(), (self.y + self.height).into());
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize % 8;
            lanes &= lanes - 1;
            let rect = TileRect {
                x: [x[lane] as usize, end_x[lane] as usize],
                y: [y[lane] as usize, end_y[lane] as usize],
            };
            tile.touch(rect, i32::MAX);
        }
    }

    /// The least and the greatest depth of the corners. Rounding keeps the order, so that clamping may
    /// follow it.
    #[inline(always)]
    fn limits(&self, simd: S) -> [f32x8<S>; 2] {
        let a = single(simd, &self.depth[0]);
        let b = single(simd, &self.depth[1]);
        let c = single(simd, &self.depth[2]);
        [a.min(b).min(c), a.max(b).max(c)]
    }

    /// [`crate::cover`]'s planes of depth.
    #[inline(always)]
    fn planes(&self, simd: S) -> [Depth4<S>; 2] {
        let unit = f32x8::splat(simd, 256.0);
        // Within 2^23: exact in f32.
        let dx1 = (f32x8::float_from(-self.left[1]) * unit).widen();
        let dx2 = (f32x8::float_from(-self.left[2]) * unit).widen();
        let dy1 = (f32x8::float_from(self.down[1]) * unit).widen();
        let dy2 = (f32x8::float_from(self.down[2]) * unit).widen();
        let x = f32x8::float_from(self.corner[0]).widen();
        let y = f32x8::float_from(self.corner[1]).widen();
        // Any i32, in two parts of fewer bits: boxes are small, but what they are cut from need not be.
        let high = f32x8::float_from(self.area >> 12).widen();
        let low = f32x8::float_from(self.area & 0xfff).widen();
        let area = (high.0 * 4096.0 + low.0, high.1 * 4096.0 + low.1);
        [
            self.plane(simd, 0, area.0, [dx1.0, dx2.0], [dy1.0, dy2.0], [x.0, y.0]),
            self.plane(simd, 4, area.1, [dx1.1, dx2.1], [dy1.1, dy2.1], [x.1, y.1]),
        ]
    }

    /// Of the four triangles from `first` on.
    #[inline(always)]
    fn plane(
        &self,
        simd: S,
        first: usize,
        area: f64x4<S>,
        [dx1, dx2]: [f64x4<S>; 2],
        [dy1, dy2]: [f64x4<S>; 2],
        [x, y]: [f64x4<S>; 2],
    ) -> Depth4<S> {
        let inverse_area = f64x4::splat(simd, 1.0) / area;
        let a = f64x4::from_slice(simd, &self.depth[0][first..first + 4]);
        let b = f64x4::from_slice(simd, &self.depth[1][first..first + 4]);
        let c = f64x4::from_slice(simd, &self.depth[2][first..first + 4]);
        let (ab, ac) = (b - a, c - a);
        Depth4 {
            depth: a,
            origin: [x * (1.0 / 256.0) - 0.5, y * (1.0 / 256.0) - 0.5],
            ddx: (ab * dx1 + ac * dx2) * inverse_area,
            ddy: (ab * dy1 + ac * dy2) * inverse_area,
        }
    }
}

/// Eight values, rounded.
#[inline(always)]
fn single<S: Simd>(simd: S, values: &[f64; 8]) -> f32x8<S> {
    let low = f64x4::from_slice(simd, &values[0..4]);
    low.narrow(f64x4::from_slice(simd, &values[4..8]))
}

/// Whole numbers below 2^24.
#[inline(always)]
fn widened<S: Simd>(_: S, x: i32x8<S>) -> [f64x4<S>; 2] {
    let (low, high) = f32x8::float_from(x).widen();
    [low, high]
}
