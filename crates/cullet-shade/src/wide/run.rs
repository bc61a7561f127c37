//! Pixels on their way to their colours: runs of neighbours, taken apart into eights.

use cullet_raster::BLOCK;
use fearless_simd::{Simd, SimdCvtFloat, f32x8, i32x8, prelude::*, u32x8};

use super::sampler::EIGHTS;

/// Neighbours in a row that show one triangle, or a single place anywhere in the block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(16))]
pub struct Run {
    /// From the lowest bit up: across and down to the first pixel, [`PLACE_BITS`] each, and the record.
    first: u32,
    /// How many pixels, at least 1.
    pub len: u32,
    /// Where the colour of the first goes; the others follow.
    pub out: u32,
}

/// Sixteenths of a pixel along a block, bits.
const PLACE_BITS: u32 = (16 * BLOCK).trailing_zeros();

impl Run {
    /// Pixels of the triangle with this `record`, which is below `BLOCK * BLOCK`. The first is at
    /// `place`, sixteenths of a pixel from the corner of the block and within it; each other is 1 px to
    /// the right of the one before.
    #[inline(always)]
    pub fn new(record: u32, place: [u32; 2], len: u32, out: u32) -> Run {
        Run { first: record << (2 * PLACE_BITS) | place[1] << PLACE_BITS | place[0], len, out }
    }

    /// The record of the triangle.
    #[inline(always)]
    pub fn record(&self) -> usize {
        (self.first >> (2 * PLACE_BITS)) as usize
    }

    /// Place of the first pixel, sixteenths of a pixel from the corner of the block, across and down.
    pub fn place(&self) -> [u32; 2] {
        [self.first, self.first >> PLACE_BITS].map(|at| at & ((1 << PLACE_BITS) - 1))
    }
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
    /// As [`Run::first`] has it.
    packed: [u32; LANES],
    out: [u32; LANES],
    record: [u32; ROOM],
    x: [f32; ROOM],
    y: [f32; ROOM],
}

impl Default for Places {
    fn default() -> Self {
        Places {
            packed: [0; LANES],
            out: [0; LANES],
            record: [0; ROOM],
            x: [0.0; ROOM],
            y: [0.0; ROOM],
        }
    }
}

impl Places {
    /// Takes as many pixels as there is room for, and returns how many. The eight that the last is in
    /// is filled up with places beside it.
    #[inline(always)]
    pub fn take<S: Simd>(&mut self, simd: S, rest: &mut Rest<'_>) -> usize {
        let Rest { mut runs, mut taken } = *rest;
        let Some(mut last) = runs.first() else { return 0 };
        let mut n = 0;
        while let Some((run, others)) = runs.split_first() {
            let len = run.len as usize;
            if len <= 8 && n <= ROOM - 8 && taken == 0 {
                self.put(simd, n, run, 0);
                n += len;
            } else if n < ROOM {
                let fitting = (len - taken).min(ROOM - n);
                let mut i = 0;
                while i < fitting {
                    self.put(simd, n + i, run, taken + i);
                    i += 8;
                }
                n += fitting;
                taken += fitting;
                if taken < len {
                    break;
                }
                taken = 0;
            } else {
                break;
            }
            (last, runs) = (run, others);
        }
        *rest = Rest { runs, taken };
        // These neighbours may lie in the next row, or be of the next triangle: they only have to be there.
        self.put(simd, n, last, 0);
        for eight in 0..n.div_ceil(8) {
            self.unpack(simd, eight);
        }
        n
    }

    /// Eight neighbours at once, from pixel `i` of a run on.
    #[inline(always)]
    fn put<S: Simd>(&mut self, simd: S, at: usize, run: &Run, i: usize) {
        let lanes = u32x8::simd_from(simd, [0, 1, 2, 3, 4, 5, 6, 7]);
        let steps = u32x8::simd_from(simd, [0, 16, 32, 48, 64, 80, 96, 112]);
        let packed = steps + (run.first + 16 * i as u32);
        packed.store_slice(&mut self.packed[at..at + 8]);
        (lanes + (run.out + i as u32)).store_slice(&mut self.out[at..at + 8]);
    }

    #[inline(always)]
    fn unpack<S: Simd>(&mut self, simd: S, eight: usize) {
        let packed = u32x8::simd_from(simd, self.packed.as_chunks().0[eight]);
        self.x.as_chunks_mut().0[eight] = place(packed).into();
        self.y.as_chunks_mut().0[eight] = place(packed >> PLACE_BITS).into();
        self.record.as_chunks_mut().0[eight] = (packed >> (2 * PLACE_BITS)).into();
    }

    /// Eight places of one triangle, whose record is the first.
    pub fn set_eight(&mut self, [x, y]: [[f32; 8]; 2]) {
        self.record.as_chunks_mut().0[0] = [0; 8];
        self.x.as_chunks_mut().0[0] = x;
        self.y.as_chunks_mut().0[0] = y;
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
        Run { first: self.packed[i], len: 1, out: self.out[i] }
    }
}

/// The lowest bits, px.
#[inline(always)]
fn place<S: Simd>(packed: u32x8<S>) -> f32x8<S> {
    // Signed, which is one instruction, and exact.
    f32x8::float_from((packed & ((1 << PLACE_BITS) - 1)).bitcast::<i32x8<S>>()) * 0.0625
}
