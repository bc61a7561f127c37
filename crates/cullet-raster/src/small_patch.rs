//! Triangles of a few pixels with several samples each: what they are drawn with is made for eight side by side, then
//! each is drawn as patches of sixteen samples.
//!
//! Edges, depth and ties are those of [`crate::patch`], operation by operation.

use fearless_simd::{Simd, f64x8, i32x8, i32x16, prelude::*, u32x16};

use crate::depth8::{both, widened};
use crate::edges8::lane_of;
use crate::fill::{between, is_long};
use crate::patch::{Lattice, PATCH, short_values, win};
use crate::small::Small;
use crate::tile::{BLOCK, TileBuffer};

/// Boxes of at most this many pixels along each axis are drawn here: they lie in one block, or in two along an axis.
pub(crate) const SMALL: i32 = BLOCK as i32;

/// Of eight triangles what patches need, number by number.
struct Lanes {
    /// The first sample of the first patch, and how many pixels of the box there are from there to the right.
    start: [i32; 8],
    width: [i32; 8],
    height: [i32; 8],
    /// As in [`TileTriangle`](crate::fill::TileTriangle), at that pixel.
    value: [[i32; 8]; 3],
    rest: [[i32; 8]; 3],
    left: [[i32; 8]; 3],
    down: [[i32; 8]; 3],
    pairs: [[i32; 8]; 3],
    /// From the origin of the plane of depth to that pixel, px.
    way: [[f64; 8]; 2],
    ddx: [f64; 8],
    ddy: [f64; 8],
    /// The keys of the farthest and the nearest corner.
    limits: [[i32; 8]; 2],
}

impl<S: Simd> Small<'_, S> {
    /// Draws the triangles of `lanes`, a bit each, with `N` samples a pixel. `rest` and `pairs` are those of their
    /// edges. Returns how many samples were won.
    #[inline(always)]
    pub fn fill_patches<const N: usize>(
        &self,
        simd: S,
        tile: &mut TileBuffer,
        mut lanes: u64,
        rest: [i32x8<S>; 3],
        pairs: [i32x8<S>; 3],
    ) -> u32 {
        let all = self.lanes::<N>(tile, simd, rest, pairs);
        let lattice = Lattice::of::<N>();
        let stride = tile.stride_px() * N;
        let [keys_start, ids_start] = tile.starts;
        let n = tile.side() * stride + PATCH;
        let keys = &mut tile.keys[keys_start..][..n];
        let ids = &mut tile.ids[ids_start..][..n];
        let (mut written, mut touched) = (0, 0_u64);
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize % 8;
            lanes &= lanes - 1;
            let (left, down) = (lane_of(&all.left, lane), lane_of(&all.down, lane));
            let mut values = short_values::<S, N>(
                simd,
                lane_of(&all.value, lane),
                lane_of(&all.rest, lane),
                lane_of(&all.pairs, lane),
            );
            let id = u32x16::splat(simd, self.id[lane]);
            let limits = [all.limits[0][lane], all.limits[1][lane]];
            let (depth, ddx, ddy) = (self.depth[0][lane], all.ddx[lane], all.ddy[lane]);
            let mut way_x = [
                f64x8::from_slice(simd, &lattice.x[..8]) + all.way[0][lane],
                f64x8::from_slice(simd, &lattice.x[8..]) + all.way[0][lane],
            ];
            let upper_way = f64x8::simd_from(simd, lattice.y) + all.way[1][lane];
            let (mut start, mut width) = (all.start[lane] as usize, all.width[lane]);
            let mut won = 0;
            loop {
                let [near, far] = [way_x[0] * ddx, way_x[1] * ddx];
                let (mut row, mut way_y, mut at) = (values, upper_way, start);
                for _ in 0..all.height[lane] {
                    let outside: i32x16<S> = row[0] | row[1] | row[2];
                    if is_long::<S>() || outside.simd_ge(0).any_true() {
                        let in_row = way_y * ddy + depth;
                        let reversed = (near + in_row).narrow(far + in_row);
                        let key = between(simd, limits, reversed);
                        won += win(simd, outside, key, id, &mut keys[at..], &mut ids[at..]);
                    }
                    row = [row[0] + down[0], row[1] + down[1], row[2] + down[2]];
                    way_y += 1.0;
                    at += stride;
                }
                width -= (PATCH / N) as i32;
                if width <= 0 {
                    break;
                }
                let n = (PATCH / N) as i32;
                values =
                    [values[0] - left[0] * n, values[1] - left[1] * n, values[2] - left[2] * n];
                way_x = [way_x[0] + f64::from(n), way_x[1] + f64::from(n)];
                start += PATCH;
            }
            touched |= u64::from(won > 0) << lane;
            written += won;
        }
        self.touch(tile, touched, &all.limits[1]);
        written
    }

    #[inline(always)]
    fn lanes<const N: usize>(
        &self,
        tile: &TileBuffer,
        simd: S,
        rest: [i32x8<S>; 3],
        pairs: [i32x8<S>; 3],
    ) -> Lanes {
        let (stride, [left, top]) = (tile.stride_px() as i32, tile.origin());
        // All patches lie in the tile; what of them is left of the box, then, is outside.
        let width = (PATCH / N) as i32;
        let reach = (self.width + (width - 1)) & -width;
        let x = self.x.min(-reach + tile.side() as i32);
        let back = self.x - x;
        let value = [
            self.value[0] + self.left[0] * back,
            self.value[1] + self.left[1] * back,
            self.value[2] + self.left[2] * back,
        ];
        let (first_x, first_y) = (widened(simd, x + left), widened(simd, self.y + top));
        let [low, high] = &self.planes;
        let [farthest, nearest] = self.limits(simd);
        Lanes {
            start: ((self.y * stride + x) * N as i32).into(),
            width: (self.width + back).into(),
            height: self.height.into(),
            value: [value[0].into(), value[1].into(), value[2].into()],
            rest: [rest[0].into(), rest[1].into(), rest[2].into()],
            left: [self.left[0].into(), self.left[1].into(), self.left[2].into()],
            down: [self.down[0].into(), self.down[1].into(), self.down[2].into()],
            pairs: [pairs[0].into(), pairs[1].into(), pairs[2].into()],
            way: [
                both(first_x[0] - low.origin[0], first_x[1] - high.origin[0]),
                both(first_y[0] - low.origin[1], first_y[1] - high.origin[1]),
            ],
            ddx: both(low.ddx, high.ddx),
            ddy: both(low.ddy, high.ddy),
            limits: [farthest.into(), nearest.into()],
        }
    }
}
