//! Triangles of a few pixels with one sample each, eight side by side: the same pixel of each one's box at a time.
//!
//! A triangle's rows of eight pixels would be empty for the most part; eight triangles fill the lanes.
//! Only samples that are covered are then tried one by one. Edges, depth and ties are those of
//! [`crate::fill`], operation by operation.

use fearless_simd::{Simd, f64x4, i32x8, mask32x8, prelude::*};

use crate::depth8::{Depth4, widened};
use crate::samples::Samples;
use crate::tile::{BLOCK, BLOCK_BITS, TileBuffer};

/// Boxes of at most this many pixels along each axis are drawn here.
pub(crate) const SMALL: i32 = 6;

/// Pixels of a box that are looked at before samples are tried: as many as a word has bits for, and at least a row.
const STEPS: usize = 8;
const _: () = assert!(SMALL as usize <= BLOCK && SMALL as usize <= STEPS && 8 * STEPS <= 64);

/// Eight triangles in a tile; those that are not to be drawn may hold anything.
pub(crate) struct Small<'s, S: Simd> {
    /// First pixel of the box, in the tile, and how many there are.
    pub x: i32x8<S>,
    pub y: i32x8<S>,
    pub width: i32x8<S>,
    pub height: i32x8<S>,
    /// As in [`TileTriangle`](crate::fill::TileTriangle).
    pub value: [i32x8<S>; 3],
    pub left: [i32x8<S>; 3],
    pub down: [i32x8<S>; 3],
    pub planes: [Depth4<S>; 2],
    /// Reversed depth of the corners, clockwise.
    pub depth: &'s [[f64; 8]; 3],
    pub id: &'s [u32; 8],
}

impl<S: Simd> Small<'_, S> {
    /// Draws the triangles of `lanes`, a bit each. Returns how many samples were won.
    #[inline(always)]
    pub fn fill(&self, simd: S, tile: &mut TileBuffer, lanes: u64) -> u32 {
        debug_assert_eq!(tile.samples(), Samples::One);
        let zero = i32x8::splat(simd, 0);
        let wanted: mask32x8<S> = SimdMask::from_bitmask(simd, lanes);
        let (width, height) = (wanted.select(self.width, zero), wanted.select(self.height, zero));
        let (columns, rows) = (width.reduce_max(), height.reduce_max());
        let (stride, [left, top]) = (tile.stride_px(), tile.origin());
        let (first_x, first_y) = (widened(simd, self.x + left), widened(simd, self.y + top));
        let planes = &self.planes;
        let [lowest, highest] = self.limits(simd);
        let [keys_start, ids_start] = tile.starts;
        // As many of both, so that one comparison serves for both.
        let n = tile.side() * stride;
        let keys = &mut tile.keys[keys_start..][..n];
        let ids = &mut tile.ids[ids_start..][..n];
        let mut in_row = self.value;
        let (mut written, mut touched) = (0, 0_u64);
        // Of several steps, each of a pixel of all boxes: what is covered, a bit each, with which keys, and where.
        let mut step_keys = [0; 8 * STEPS];
        let mut step_places = [0; 8 * STEPS];
        let first: i32x8<S> = self.y * stride as i32 + self.x;
        let mut row = 0;
        while row < rows {
            let (mut covered, mut step) = (0_u64, 0);
            loop {
                let in_rows = height.simd_gt(row);
                let y = f64::from(row);
                let low_row = planes[0].row(first_y[0] + y);
                let high_row = planes[1].row(first_y[1] + y);
                let mut value = in_row;
                let mut column = 0;
                while column < columns {
                    let in_box = in_rows & width.simd_gt(column);
                    let signs = value[0] | value[1] | value[2];
                    covered |= (signs.simd_ge(0) & in_box).to_bitmask() << (8 * step);
                    let x = f64::from(column);
                    let low = planes[0].in_row(low_row, first_x[0] + x);
                    let high = planes[1].in_row(high_row, first_x[1] + x);
                    let depth: i32x8<S> = low.narrow(high).bitcast();
                    let key = depth.max(lowest).min(highest);
                    let place = first + (row * stride as i32 + column);
                    let at = 8 * (step % STEPS);
                    key.store_slice(&mut step_keys[at..at + 8]);
                    place.store_slice(&mut step_places[at..at + 8]);
                    value =
                        [value[0] - self.left[0], value[1] - self.left[1], value[2] - self.left[2]];
                    column += 1;
                    step += 1;
                }
                let down = &self.down;
                in_row = [in_row[0] + down[0], in_row[1] + down[1], in_row[2] + down[2]];
                row += 1;
                if row == rows || step + columns as usize > STEPS {
                    break;
                }
            }
            while covered != 0 {
                let sample = covered.trailing_zeros() as usize % (8 * STEPS);
                covered &= covered - 1;
                let (key, at) = (step_keys[sample], step_places[sample] as usize);
                let id = self.id[sample % 8];
                let (old_key, old_id) = (keys[at], ids[at]);
                // A branch for equal keys, which hardly ever any are; none for the nearer: nobody could foresee it.
                let mut wins = key > old_key;
                if key == old_key {
                    wins = id < old_id;
                }
                keys[at] = key.max(old_key);
                ids[at] = if wins { id } else { old_id };
                touched |= u64::from(wins) << (sample % 8);
                written += u32::from(wins);
            }
        }
        self.touch(tile, touched, &highest.into());
        written
    }

    /// Notes where the triangles of `lanes` have drawn, with the nearest key of each.
    #[inline(always)]
    pub fn touch(&self, tile: &mut TileBuffer, lanes: u64, nearest: &[i32; 8]) {
        let per_row = tile.blocks_per_row();
        let (column, row) = (self.x >> BLOCK_BITS, self.y >> BLOCK_BITS);
        let (end_column, end_row) =
            ((self.x + self.width - 1) >> BLOCK_BITS, (self.y + self.height - 1) >> BLOCK_BITS);
        let first: [i32; 8] = (row * per_row as i32 + column).into();
        // A box is no larger than a block: it lies in one, or in two along an axis.
        let wide = end_column.simd_gt(column).to_bitmask() & lanes;
        let tall = end_row.simd_gt(row).to_bitmask() & lanes;
        let further = [0, 1, per_row, per_row + 1];
        let mut touched = lanes | wide << 8 | tall << 16 | (wide & tall) << 24;
        while touched != 0 {
            let bit = touched.trailing_zeros() as usize;
            touched &= touched - 1;
            let block = first[bit % 8] as usize + further[bit / 8 % 4];
            tile.touch_block(block, nearest[bit % 8]);
        }
    }

    /// The least and the greatest key of the corners, for keys to be brought between as in
    /// [`clamped_key`](crate::fill::clamped_key).
    #[inline(always)]
    pub fn limits(&self, simd: S) -> [i32x8<S>; 2] {
        let a = key(simd, &self.depth[0]);
        let b = key(simd, &self.depth[1]);
        let c = key(simd, &self.depth[2]);
        [a.min(b).min(c), a.max(b).max(c)]
    }
}

/// The keys of eight reversed depths.
#[inline(always)]
fn key<S: Simd>(simd: S, values: &[f64; 8]) -> i32x8<S> {
    let low = f64x4::from_slice(simd, &values[0..4]);
    // The sum has no negative zero.
    (low.narrow(f64x4::from_slice(simd, &values[4..8])) + 0.0).bitcast()
}
