//! The samples of a square of the picture, on their way to being shaded.
//!
//! Per sample the source triangle and its depth as a *key*, an integer that is larger where the
//! sample is nearer (see [`DepthFormat::key`](crate::DepthFormat::key)); and per block of 8 x 8 pixels the farthest
//! key, so that what lies behind a whole block is found out at once (Greene, Kass & Miller 1993,
//! "Hierarchical Z-Buffer Visibility"). Farthest keys are made when asked for, from the samples, unless
//! a triangle that fills the block has told enough.

use fearless_simd::{Level, Simd, dispatch, i32x8, prelude::*};

use crate::cover::NO_TRIANGLE;
use crate::samples::Samples;

/// Pixels along a side of a block of the depth hierarchy.
pub(crate) const BLOCK: usize = 8;
pub(crate) const BLOCK_BITS: u32 = BLOCK.trailing_zeros();

/// Columns beyond the right border, so that a group of sixteen may be read from the last column on, and a cache
/// line's worth, so that all rows begin alike. Nothing is drawn there.
const MARGIN: usize = LINE;
const _: () = assert!(MARGIN >= 16);

/// How many things must be found hidden block by block before the whole tile is looked at again.
const HIDDEN_TILL_ALL: u32 = 2;

/// Values in a cache line.
const LINE: usize = 16;

/// A square of samples. All of it is drawn to, also where it reaches beyond the picture.
#[derive(Clone, Debug, Default)]
pub struct TileBuffer {
    /// Left border in the picture, px.
    x: i32,
    /// Upper border in the picture, px.
    y: i32,
    side: usize,
    samples: Samples,
    /// Where keys and ids begin, for rows to start with a cache line.
    pub(crate) starts: [usize; 2],
    /// Rows of `stride_px` pixels, the samples of each side by side, a value each.
    pub(crate) keys: Vec<i32>,
    /// The same.
    pub(crate) ids: Vec<u32>,
    blocks: Vec<Block>,
    /// The farthest key of all, when it was found.
    farthest_of_all: i32,
    /// Things found hidden since.
    n_hidden: u32,
}

/// What is known of the samples of a block.
#[derive(Clone, Copy, Debug, Default)]
struct Block {
    /// No key is farther than this. Keys only come nearer, so it stays true.
    farthest: i32,
    /// No key is nearer than this.
    nearest: i32,
    /// How often it was written to since `farthest` was found.
    n_stale: u32,
    /// Written to since the tile began.
    is_touched: bool,
}

/// Pixels of a tile, counted from its corner: columns `x[0]..x[1]`, rows `y[0]..y[1]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileRect {
    /// First column and the one after the last.
    pub x: [usize; 2],
    /// First row and the one after the last.
    pub y: [usize; 2],
}

impl TileBuffer {
    /// Starts a square with its upper left corner at the pixel `(x, y)` of the picture, nothing in
    /// it. `side` is a multiple of 8.
    pub fn begin(&mut self, [x, y]: [u32; 2], side: usize, samples: Samples) {
        debug_assert!(side > 0 && side.is_multiple_of(BLOCK), "side {side}");
        (self.x, self.y) = (x as i32, y as i32);
        let is_alike = (self.side, self.samples) == (side, samples);
        (self.side, self.samples) = (side, samples);
        let n_blocks = (side / BLOCK) * (side / BLOCK);
        let n_touched = self.blocks.iter().filter(|block| block.is_touched).count();
        if is_alike && n_touched <= n_blocks / 2 {
            self.clear_touched();
        } else {
            // Beyond the last row, others, for rows are drawn up to four at a time, and what that reaches into from
            // the last column on.
            let n = samples.count() * self.stride_px() * (side + 4) + LINE;
            self.keys.resize(n, 0);
            self.ids.resize(n, 0);
            // `fill` sets many at a time, which `resize` does not.
            self.keys.fill(0);
            self.ids.fill(NO_TRIANGLE);
            let start = |offset: usize| offset.min(LINE); // no promise is given that it is known
            self.starts = [
                start(self.keys.as_ptr().align_offset(4 * LINE)),
                start(self.ids.as_ptr().align_offset(4 * LINE)),
            ];
        }
        self.blocks.clear();
        self.blocks.resize(n_blocks, Block::default());
        (self.farthest_of_all, self.n_hidden) = (0, 0);
    }

    /// Empties the blocks that were written to.
    fn clear_touched(&mut self) {
        let per_row = self.blocks_per_row();
        let n_samples = self.samples.count();
        let (stride, width) = (self.stride_px() * n_samples, BLOCK * n_samples);
        for (block, _) in (0..).zip(&self.blocks).filter(|(_, block)| block.is_touched) {
            let corner: usize = block / per_row * BLOCK * stride + block % per_row * width;
            for row in 0..BLOCK {
                let start = corner + row * stride;
                self.keys[self.starts[0] + start..][..width].fill(0);
                self.ids[self.starts[1] + start..][..width].fill(NO_TRIANGLE);
            }
        }
    }

    /// Whether nothing has been drawn into it.
    pub fn is_empty(&self) -> bool {
        !self.blocks.iter().any(|block| block.is_touched)
    }

    /// Upper left corner in the picture, px.
    pub fn origin(&self) -> [i32; 2] {
        [self.x, self.y]
    }

    /// Pixels along a side.
    pub fn side(&self) -> usize {
        self.side
    }

    /// Blocks along a side.
    pub(crate) fn blocks_per_row(&self) -> usize {
        self.side / BLOCK
    }

    /// Where pixels are sampled.
    pub fn samples(&self) -> Samples {
        self.samples
    }

    /// Pixels from a row to the next.
    pub(crate) fn stride_px(&self) -> usize {
        self.side + MARGIN
    }

    /// The source triangles of a sample along a row, left to right, or [`NO_TRIANGLE`].
    pub fn ids(&self, sample: usize, row: usize) -> impl Iterator<Item = u32> {
        self.along(&self.ids[self.starts[1]..], sample, row)
    }

    /// The source triangles of all samples from a pixel of the tile on, those of a pixel side by side, and how
    /// many there are from a row to the next. After a row come at least sixteen pixels that mean nothing.
    pub fn ids_from(&self, [column, row]: [u32; 2]) -> (&[u32], usize) {
        let n_samples = self.samples.count();
        let at = row as usize * self.stride_px() + column as usize;
        (&self.ids[self.starts[1] + at * n_samples..], self.stride_px() * n_samples)
    }

    /// Their depth keys, which lie alike.
    pub fn keys_from(&self, [column, row]: [u32; 2]) -> &[i32] {
        let at = row as usize * self.stride_px() + column as usize;
        &self.keys[self.starts[0] + at * self.samples.count()..]
    }

    /// The depth keys of a sample along a row.
    pub fn keys(&self, sample: usize, row: usize) -> impl Iterator<Item = i32> {
        self.along(&self.keys[self.starts[0]..], sample, row)
    }

    /// What a sample has along a row.
    fn along<'v, T: Copy>(
        &self,
        values: &'v [T],
        sample: usize,
        row: usize,
    ) -> impl Iterator<Item = T> + use<'v, T> {
        let n_samples = self.samples.count();
        let start = row * self.stride_px() * n_samples + sample;
        values[start..].iter().step_by(n_samples).take(self.side).copied()
    }

    /// Notes that pixels of `rect` may have been written, with keys no nearer than `nearest`.
    #[inline(always)]
    pub(crate) fn touch(&mut self, rect: TileRect, nearest: i32) {
        let per_row = self.blocks_per_row();
        for row in rect.y[0] / BLOCK..rect.y[1].div_ceil(BLOCK) {
            for column in rect.x[0] / BLOCK..rect.x[1].div_ceil(BLOCK).min(per_row) {
                self.touch_block(row * per_row + column, nearest);
            }
        }
    }

    /// [`TileBuffer::touch`] for one block.
    #[inline(always)]
    pub(crate) fn touch_block(&mut self, block: usize, nearest: i32) {
        let block = &mut self.blocks[block];
        block.nearest = block.nearest.max(nearest);
        block.n_stale += 1;
        block.is_touched = true;
    }

    /// Notes that a triangle with keys between these covers all samples of a block: each sample has the
    /// nearer key now of its own and the triangle's.
    #[inline(always)]
    pub(crate) fn cover_block(&mut self, block: usize, [farthest, nearest]: [i32; 2]) {
        let block = &mut self.blocks[block];
        block.farthest = block.farthest.max(farthest);
        block.nearest = block.nearest.max(nearest);
        block.is_touched = true;
    }

    /// Whether everything in a block is farther than `key`.
    #[inline(always)]
    pub(crate) fn block_is_behind(&self, block: usize, key: i32) -> bool {
        self.blocks[block].nearest < key
    }

    /// Whether everything in `rect` is nearer than `key`: whether a thing that reaches no farther to
    /// the front than `key` would be hidden there altogether. Whole blocks are looked at, so the answer may be no too often.
    pub fn hides(&mut self, level: Level, rect: TileRect, key: i32) -> bool {
        dispatch!(level, simd => self.hides_wide(simd, rect, key))
    }

    /// Whether all of the tile is known to be nearer than `key`.
    #[inline(always)]
    pub(crate) fn all_hides(&self, key: i32) -> bool {
        self.farthest_of_all > key
    }

    #[inline(always)]
    pub(crate) fn hides_wide<S: Simd>(&mut self, simd: S, rect: TileRect, key: i32) -> bool {
        if self.all_hides(key) {
            return true;
        }
        if !self.blocks_hide::<_, 1>(simd, rect, key) {
            return false;
        }
        // The more is hidden, the more it pays to find that out at once.
        self.n_hidden += 1;
        if self.n_hidden == HIDDEN_TILL_ALL {
            self.n_hidden = 0;
            let mut least = i32::MAX;
            for block in 0..self.blocks.len() {
                least = least.min(self.farthest_of(simd, block));
            }
            self.farthest_of_all = least;
        }
        true
    }

    /// Whether everything in the blocks that `rect` reaches is nearer than `key`. Blocks that were
    /// written to less than `STALE` times since are asked for what was their farthest then.
    #[inline(always)]
    pub(crate) fn blocks_hide<S: Simd, const STALE: u32>(
        &mut self,
        simd: S,
        rect: TileRect,
        key: i32,
    ) -> bool {
        let per_row = self.blocks_per_row();
        for row in rect.y[0] / BLOCK..rect.y[1].div_ceil(BLOCK) {
            for column in rect.x[0] / BLOCK..rect.x[1].div_ceil(BLOCK) {
                let block = row * per_row + column;
                let known = &self.blocks[block];
                if known.farthest <= key
                    && (known.n_stale < STALE || self.farthest_of(simd, block) <= key)
                {
                    return false;
                }
            }
        }
        true
    }

    /// A key that nothing in a block is farther than, as far as is known.
    #[inline(always)]
    pub(crate) fn farthest_known(&self, block: usize) -> i32 {
        self.blocks[block].farthest
    }

    /// Finds the farthest keys anew of blocks that were written to at least `TOUCHES` times since.
    #[inline(always)]
    pub(crate) fn look_again<S: Simd, const TOUCHES: u32>(&mut self, simd: S) {
        for block in 0..self.blocks.len() {
            if self.blocks[block].n_stale >= TOUCHES {
                self.farthest_of(simd, block);
            }
        }
    }

    /// Whether everything in a block is nearer than `key`.
    #[inline(always)]
    pub(crate) fn block_hides<S: Simd>(&mut self, simd: S, block: usize, key: i32) -> bool {
        self.blocks[block].farthest > key || self.farthest_of(simd, block) > key
    }

    /// A key that none of a block is farther than.
    #[inline(always)]
    fn farthest_of<S: Simd>(&mut self, simd: S, block: usize) -> i32 {
        if self.blocks[block].n_stale > 0 {
            let per_row = self.blocks_per_row();
            let n_samples = self.samples.count();
            let corner = block / per_row * BLOCK * self.stride_px() + block % per_row * BLOCK;
            let mut least = i32x8::splat(simd, i32::MAX);
            for row in 0..BLOCK {
                let start = self.starts[0] + (corner + row * self.stride_px()) * n_samples;
                let keys = &self.keys[start..start + BLOCK * n_samples];
                let mut i = 0;
                while i + 8 <= keys.len() {
                    least = least.min(i32x8::from_slice(simd, &keys[i..i + 8]));
                    i += 8;
                }
            }
            let block = &mut self.blocks[block];
            (block.farthest, block.n_stale) = (least.reduce_min(), 0);
        }
        self.blocks[block].farthest
    }

    /// Panics where what is known of a block does not hold, or something was drawn outside.
    #[cfg(test)]
    pub(crate) fn validate(&self) {
        let n_samples = self.samples.count();
        let per_row = self.blocks_per_row();
        for (i, block) in self.blocks.iter().enumerate() {
            for row in 0..BLOCK {
                let at = (i / per_row * BLOCK + row) * self.stride_px() + i % per_row * BLOCK;
                for sample in 0..BLOCK * n_samples {
                    let key = self.keys[self.starts[0] + at * n_samples + sample];
                    let id = self.ids[self.starts[1] + at * n_samples + sample];
                    assert!((block.farthest..=block.nearest).contains(&key), "{block:?} {key}");
                    assert!(block.is_touched || id == NO_TRIANGLE, "{block:?} {id}");
                    assert!(self.farthest_of_all <= key, "{} {key}", self.farthest_of_all);
                }
            }
        }
        let stride = self.stride_px() * n_samples;
        for row in 0..self.side + 4 {
            let inside = if row < self.side { self.side * n_samples } else { 0 };
            let keys = &self.keys[self.starts[0] + row * stride..][inside..stride];
            let ids = &self.ids[self.starts[1] + row * stride..][inside..stride];
            assert!(keys.iter().all(|key| *key == 0), "row {row}: {keys:?}");
            assert!(ids.iter().all(|id| *id == NO_TRIANGLE), "row {row}: {ids:?}");
        }
    }

    /// Memory held.
    pub fn bytes(&self) -> usize {
        (self.keys.capacity() + self.ids.capacity()) * 4
            + self.blocks.capacity() * size_of::<Block>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_hides_what_is_behind_its_farthest_sample() {
        let mut tile = TileBuffer::default();
        tile.begin([64, 0], 32, Samples::Two);
        let whole = TileRect { x: [8, 16], y: [0, 8] };
        assert!(!tile.hides(Level::new(), whole, 0));
        let stride = tile.stride_px();
        for (row, column) in (0..8).flat_map(|row| (8..16).map(move |column| (row, column))) {
            let at = tile.starts[0] + 2 * (row * stride + column);
            tile.keys[at] = 50;
            tile.keys[at + 1] = 40;
        }
        assert!(!tile.hides(Level::new(), whole, 0)); // nobody said that it was written
        tile.touch(whole, 50);
        assert!(tile.hides(Level::new(), whole, 39));
        assert!(!tile.hides(Level::new(), whole, 40));
        assert!(!tile.hides(Level::new(), TileRect { x: [8, 17], y: [0, 8] }, 39));
    }

    #[test]
    fn blocks_are_looked_at_again_when_written_to_often() {
        let mut tile = TileBuffer::default();
        tile.begin([0, 0], 16, Samples::Two);
        tile.keys.fill(50);
        for _ in 0..3 {
            tile.touch_block(0, 50);
        }
        dispatch!(Level::new(), simd => tile.look_again::<_, 4>(simd));
        assert!(tile.farthest_known(0) < 50);
        tile.touch_block(0, 50);
        dispatch!(Level::new(), simd => tile.look_again::<_, 4>(simd));
        assert_eq!(tile.farthest_known(0), 50);
    }
}
