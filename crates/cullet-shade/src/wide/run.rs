//! Pixels on their way to their colours: runs of neighbours, taken apart into eights.

use fearless_simd::{Simd, f32x8, prelude::*, u32x8};

use super::sampler::EIGHTS;

/// Neighbours in a row that show one triangle, or a single place anywhere in the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(16))]
pub struct Run {
    /// The record of the triangle.
    pub record: u16,
    /// How many pixels, at least 1.
    pub len: u16,
    /// Where the colour of the first goes; the others follow.
    pub out: u32,
    /// Place of the first, px from the corner of the block; each other is 1 px to the right of the
    /// one before.
    pub x: f32,
    /// Down.
    pub y: f32,
}

/// Pixels that go through a stage before the next begins.
const ROOM: usize = 8 * EIGHTS;

/// Runs are written eight pixels at a time, whatever their length, and what is too much is written
/// over by the next.
const LANES: usize = ROOM + 16;

/// What is left of a list of runs.
#[derive(Debug)]
pub(super) struct Rest<'a> {
    pub runs: &'a [Run],
    /// Pixels of the first that are taken already.
    pub taken: usize,
}

/// A chunk of pixels, of up to [`EIGHTS`] eights.
#[derive(Debug)]
pub(super) struct Places {
    record: [u32; LANES],
    out: [u32; LANES],
    x: [f32; LANES],
    y: [f32; LANES],
}

impl Default for Places {
    fn default() -> Self {
        Places { record: [0; LANES], out: [0; LANES], x: [0.0; LANES], y: [0.0; LANES] }
    }
}

impl Places {
    /// Takes as many pixels as there is room for, and returns how many. The eight that the last is in
    /// is filled up with places beside it.
    #[inline(always)]
    pub fn take<S: Simd>(&mut self, simd: S, rest: &mut Rest<'_>) -> usize {
        let mut n = 0;
        while n < ROOM
            && let Some((run, others)) = rest.runs.split_first()
        {
            let (taken, left) = (rest.taken, run.len as usize - rest.taken);
            let fitting = left.min(ROOM - n);
            let mut i = 0;
            while i < fitting {
                self.put(simd, n + i, run, taken + i);
                i += 8;
            }
            n += fitting;
            if fitting == left {
                *rest = Rest { runs: others, taken: 0 };
            } else {
                rest.taken += fitting;
            }
            if n == ROOM || rest.runs.is_empty() {
                self.put(simd, n, run, taken);
            }
        }
        n
    }

    /// Eight neighbours at once, from pixel `i` of a run on.
    #[inline(always)]
    fn put<S: Simd>(&mut self, simd: S, at: usize, run: &Run, i: usize) {
        let lanes = u32x8::simd_from(simd, [0, 1, 2, 3, 4, 5, 6, 7]);
        let steps = f32x8::simd_from(simd, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        let lanes_used = at..at + 8;
        u32x8::splat(simd, u32::from(run.record)).store_slice(&mut self.record[lanes_used.clone()]);
        (lanes + (run.out + i as u32)).store_slice(&mut self.out[lanes_used.clone()]);
        (steps + (run.x + i as f32)).store_slice(&mut self.x[lanes_used.clone()]);
        f32x8::splat(simd, run.y).store_slice(&mut self.y[lanes_used]);
    }

    /// Eight places of one triangle, whose record is the first.
    pub fn set_eight(&mut self, [x, y]: [[f32; 8]; 2]) {
        self.record[..8].fill(0);
        self.x[..8].copy_from_slice(&x);
        self.y[..8].copy_from_slice(&y);
    }

    /// The records of an eight.
    #[inline(always)]
    pub fn records(&self, eight: usize) -> &[u32; 8] {
        &self.record.as_chunks().0[eight]
    }

    /// Where the colours of an eight go.
    #[inline(always)]
    pub fn out(&self, eight: usize) -> &[u32; 8] {
        &self.out.as_chunks().0[eight]
    }

    /// Px right of the corner of the block.
    #[inline(always)]
    pub fn x(&self, eight: usize) -> &[f32; 8] {
        &self.x.as_chunks().0[eight]
    }

    /// Px down from the corner of the block.
    #[inline(always)]
    pub fn y(&self, eight: usize) -> &[f32; 8] {
        &self.y.as_chunks().0[eight]
    }

    /// Whether an eight shows one triangle.
    #[inline(always)]
    pub fn is_one_triangle<S: Simd>(&self, simd: S, eight: usize) -> bool {
        let records = u32x8::simd_from(simd, *self.records(eight));
        records.simd_eq(u32x8::splat(simd, self.records(eight)[0])).all_true()
    }

    /// A pixel, by itself.
    pub fn pixel(&self, i: usize) -> Run {
        let (record, out) = (self.record[i] as u16, self.out[i]);
        Run { record, len: 1, out, x: self.x[i], y: self.y[i] }
    }
}
