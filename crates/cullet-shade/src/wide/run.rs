//! Pixels on their way to their colours: runs of neighbours, taken apart into groups.

use cullet_raster::BLOCK;
use fearless_simd::{Simd, prelude::*, u32x8};

use super::column::{Column, Lanes, ROOM, WIDEST};

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

/// Runs are written eight pixels at a time, whatever their length, and what is too much is written
/// over by the next; the last group is filled up.
const PADDED: usize = ROOM + WIDEST;

/// What is left of a list of runs.
#[derive(Debug)]
pub(super) struct Rest<'a> {
    pub runs: &'a [Run],
    /// Pixels of the first that are taken already.
    pub taken: usize,
}

/// A chunk of pixels.
#[derive(Debug)]
pub(super) struct Places {
    /// As [`Run::first`] has it.
    packed: [u32; PADDED],
    out: [u32; PADDED],
    record: Column<u32>,
    x: Column<f32>,
    y: Column<f32>,
}

impl Default for Places {
    fn default() -> Self {
        Places {
            packed: [0; PADDED],
            out: [0; PADDED],
            record: Column::default(),
            x: Column::default(),
            y: Column::default(),
        }
    }
}

impl Places {
    /// Takes as many pixels as there is room for, and returns how many. The group that the last is in
    /// is filled up.
    #[inline(always)]
    pub fn take<S: Simd, V: Lanes<S>>(&mut self, simd: S, rest: &mut Rest<'_>) -> usize {
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
        // The group is filled up with one place of the last triangle, which nobody looks at.
        let first = u32x8::splat(simd, last.first);
        for i in (n..n + V::LEN).step_by(8) {
            first.store_slice(&mut self.packed[i..i + 8]);
        }
        for group in 0..n.div_ceil(V::LEN) {
            self.unpack::<S, V>(simd, group);
        }
        n
    }

    /// Eight neighbours at once, from pixel `i` of a run on.
    #[inline(always)]
    fn put<S: Simd>(&mut self, simd: S, at: usize, run: &Run, i: usize) {
        let lanes = u32x8::simd_from(simd, [0, 1, 2, 3, 4, 5, 6, 7]);
        let packed = (lanes << 4) + (run.first + 16 * i as u32);
        packed.store_slice(&mut self.packed[at..at + 8]);
        (lanes + (run.out + i as u32)).store_slice(&mut self.out[at..at + 8]);
    }

    #[inline(always)]
    fn unpack<S: Simd, V: Lanes<S>>(&mut self, simd: S, group: usize) {
        let first = group * V::LEN;
        let packed = V::Uints::from_slice(simd, &self.packed[first..first + V::LEN]);
        self.x.set::<S, V>(group, place(simd, packed));
        self.y.set::<S, V>(group, place(simd, packed >> PLACE_BITS));
        self.record.set::<S, V::Uints>(group, packed >> (2 * PLACE_BITS));
    }

    /// Eight places of one triangle, whose record is the first.
    pub fn set_eight(&mut self, [x, y]: [[f32; 8]; 2]) {
        self.record.0[..8].fill(0);
        self.x.0[..8].copy_from_slice(&x);
        self.y.0[..8].copy_from_slice(&y);
    }

    /// The records of a group of so many pixels.
    #[inline(always)]
    pub fn records(&self, group: usize, lanes: usize) -> &[u32] {
        self.record.of(group, lanes)
    }

    /// Where the colours go.
    #[inline(always)]
    pub fn out(&self) -> &[u32] {
        &self.out
    }

    /// Px right of the corner of the block.
    #[inline(always)]
    pub fn x(&self) -> &Column<f32> {
        &self.x
    }

    /// Px down from the corner of the block.
    #[inline(always)]
    pub fn y(&self) -> &Column<f32> {
        &self.y
    }

    /// Whether a group shows one triangle.
    #[inline(always)]
    pub fn is_one_triangle<S: Simd, V: Lanes<S>>(&self, simd: S, group: usize) -> bool {
        let records: V::Uints = self.record.get(simd, group);
        records.simd_eq(V::Uints::splat(simd, self.record.0[group * V::LEN])).all_true()
    }

    /// A pixel, by itself.
    pub fn pixel(&self, i: usize) -> Run {
        Run { first: self.packed[i], len: 1, out: self.out[i] }
    }
}

/// The lowest bits, px.
#[inline(always)]
fn place<S: Simd, V: Lanes<S>>(simd: S, packed: V::Uints) -> V {
    let low = packed & V::Uints::splat(simd, (1 << PLACE_BITS) - 1);
    // Signed, which is one instruction, and exact.
    V::float_from(low.bitcast::<V::Ints>()) * 0.0625
}
