//! The pixels of a block as runs, and the triangles that they show, before they are coloured.

use cullet_raster::{BLOCK, NO_TRIANGLE};
use cullet_shade::wide::Run;
use fearless_simd::{Level, Simd, dispatch, prelude::*, u32x8};

use crate::tile_shader::Wanted;

/// Pixels coloured at once: those of a block.
pub(crate) const BATCH: usize = (BLOCK * BLOCK) as usize;

/// Slots of the table of triangles.
const SLOTS: usize = 2048;

/// Runs are put in order eight at a time, whatever there are.
const RUNS: usize = BATCH + 8;

/// Up to [`BATCH`] pixels, in runs of one triangle each.
#[derive(Debug)]
pub(crate) struct Batch {
    /// By some bits of an id: the id, the batch that it is of, and its record's number.
    table: Box<[u64; SLOTS]>,
    /// Which batch this is.
    epoch: u16,
    /// The triangles, by the numbers of their records; the last place is for what is not to be kept.
    ids: Box<[u32; BATCH + 1]>,
    runs: Box<[Run; RUNS]>,
    /// The runs by paint.
    sorted: Box<[Run; RUNS]>,
    /// The paints of the runs.
    paints: Box<[u32; BATCH]>,
    n: Counts,
}

/// How many there are in a batch.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    triangles: usize,
    /// Those of them that have records.
    set_up: usize,
    runs: usize,
    pixels: usize,
}

impl Default for Batch {
    fn default() -> Self {
        Batch {
            table: boxed(0),
            epoch: 0,
            ids: boxed(0),
            runs: boxed(Run::default()),
            sorted: boxed(Run::default()),
            paints: boxed(0),
            n: Counts::default(),
        }
    }
}

/// As many as the type says, without a way over the stack.
fn boxed<T: Clone, const N: usize>(value: T) -> Box<[T; N]> {
    let all = vec![value; N].into_boxed_slice();
    all.try_into().unwrap_or_else(|_| unreachable!("there are N of them"))
}

impl Batch {
    /// Memory held.
    pub(crate) fn bytes() -> usize {
        SLOTS * 8 + BATCH * (8 + 2 * size_of::<Run>())
    }

    /// Forgets the batch before.
    pub(crate) fn begin(&mut self) {
        self.epoch = self.epoch.wrapping_add(1);
        if self.epoch == 0 {
            self.table.fill(0);
            self.epoch = 1;
        }
        self.n = Counts::default();
    }

    /// Ids of the triangles, by the numbers of their records.
    pub(crate) fn ids(&self) -> &[u32] {
        &self.ids[..self.n.triangles]
    }

    /// How many of the triangles, the first ones, have their records.
    pub(crate) fn n_set_up(&self) -> usize {
        self.n.set_up
    }

    /// Notes that all triangles have their records.
    pub(crate) fn all_set_up(&mut self) {
        self.n.set_up = self.n.triangles;
    }

    /// Whether there is room for as many triangles more.
    pub(crate) fn has_room(&self, n: usize) -> bool {
        self.n.triangles + n <= BATCH
    }

    pub(crate) fn n_pixels(&self) -> usize {
        self.n.pixels
    }

    /// Pixels of a rectangle of the block.
    pub(crate) fn rectangle(&mut self, simd: Level, rectangle: &Rectangle<'_>) {
        dispatch!(simd, simd => self.rows(simd, rectangle));
    }

    #[inline(always)]
    fn rows<S: Simd>(&mut self, simd: S, rectangle: &Rectangle<'_>) {
        let Rectangle { ids, stride, size: [width, height], out, out_stride, place } = *rectangle;
        let mut writer = self.writer();
        for row in 0..height as usize {
            let ids = &ids[row * stride..][..width as usize];
            let out = (out + row * out_stride) as u32;
            writer.row(simd, ids, out, [place[0], place[1] + 16 * row as u32]);
        }
        self.n = writer.n;
    }

    /// A run of `len` neighbours that show one triangle, or nothing, the first at `place`, sixteenths of
    /// a pixel from the corner of the block.
    #[inline(always)]
    pub(crate) fn push(&mut self, id: u32, len: u32, out: u32, place: [u32; 2]) {
        let mut writer = self.writer();
        writer.push(id, len, out, place);
        self.n = writer.n;
    }

    /// Single pixels of a block, whose places are counted from `corner`, both sixteenths of a pixel. The
    /// first goes to `out`, each other to the place after that of the one before.
    pub(crate) fn singles(&mut self, wanted: &[Wanted], corner: [i32; 2], out: usize) {
        let mut writer = self.writer();
        for (out, wanted) in (out as u32..).zip(wanted) {
            // No `map`: it is a call for each where the compiler has inlined enough.
            let place = [(wanted.x - corner[0]) as u32, (wanted.y - corner[1]) as u32];
            writer.push(wanted.id, 1, out, place);
        }
        self.n = writer.n;
    }

    /// Forgets the pixels, but not the triangles.
    pub(crate) fn begin_more(&mut self) {
        (self.n.runs, self.n.pixels) = (0, 0);
    }

    /// Pixels of a triangle whose record is known.
    #[inline(always)]
    pub(crate) fn put(&mut self, run: Run) {
        self.runs[self.n.runs] = run;
        self.n.runs += 1;
        self.n.pixels += run.len as usize;
    }

    /// The number of a triangle's record, a new one if it is not known.
    pub(crate) fn record_of(&mut self, id: u32) -> u32 {
        let mut writer = self.writer();
        let record = writer.record_of(id, true);
        self.n = writer.n;
        record
    }

    #[inline(always)]
    fn writer(&mut self) -> Writer<'_> {
        let Batch { table, epoch, ids, runs, n, .. } = self;
        Writer { table, epoch: *epoch, ids, runs, n: *n }
    }

    /// All runs.
    pub(crate) fn runs(&self) -> &[Run] {
        &self.runs[..self.n.runs]
    }

    /// Puts the runs in the order of their paints, which `paint_of` says by record, and says in
    /// `counts`, by paint, how many there are; on entry, where there are any. Returns the runs.
    pub(crate) fn by_paint(&mut self, simd: Level, paint_of: &[u32], counts: &mut [u32]) -> &[Run] {
        let n = dispatch!(simd, simd => self.sort(simd, paint_of, counts));
        &self.sorted[..n]
    }

    /// Once through all runs for each paint, eight at a time: there are few paints, and branches would be
    /// many. Runs beyond the last have no paint.
    #[inline(always)]
    fn sort<S: Simd>(&mut self, simd: S, paint_of: &[u32], counts: &mut [u32]) -> usize {
        let n_eights = self.n.runs.div_ceil(8);
        let (runs, paints) = (self.runs.as_chunks::<8>().0, self.paints.as_chunks_mut::<8>().0);
        let (runs, paints) = (&runs[..n_eights], &mut paints[..n_eights]);
        for (eight, paints) in paints.iter_mut().enumerate() {
            let n = (self.n.runs - 8 * eight).min(8);
            paints.fill(NO_PAINT);
            for lane in 0..n {
                paints[lane] = paint_of[runs[eight][lane].record()];
            }
        }
        let mut end = 0;
        for (paint, count) in counts.iter_mut().enumerate().filter(|(_, count)| **count > 0) {
            let first = end;
            let own = u32x8::splat(simd, paint as u32);
            for eight in 0..n_eights {
                let is_own = u32x8::simd_from(simd, paints[eight]).simd_eq(own).to_bitmask() as u8;
                if is_own == 0 {
                    continue;
                }
                let places = PLACES_OF_ONES[usize::from(is_own)].to_le_bytes();
                let sorted: &mut [Run; 8] =
                    self.sorted[end..].first_chunk_mut().expect("a margin of eight");
                for lane in 0..8 {
                    sorted[lane] = runs[eight][usize::from(places[lane]) % 8];
                }
                end += is_own.count_ones() as usize;
            }
            *count = (end - first) as u32;
        }
        end
    }
}

/// A batch while it grows: what it counts is at hand, and all lengths are known beforehand.
struct Writer<'a> {
    table: &'a mut [u64; SLOTS],
    epoch: u16,
    ids: &'a mut [u32; BATCH + 1],
    runs: &'a mut [Run; RUNS],
    n: Counts,
}

impl Writer<'_> {
    /// Pixels of a row of the block, from `x`, `y` on, sixteenths, the first of which goes to `out`.
    #[inline(always)]
    fn row<S: Simd>(&mut self, simd: S, ids: &[u32], out: u32, [x, y]: [u32; 2]) {
        let mut starts = [0; STARTS];
        let n = run_starts(simd, ids, &mut starts);
        starts[n] = ids.len() as u8;
        for i in 0..n {
            let (start, end) = (u32::from(starts[i]), u32::from(starts[i + 1]));
            let id = ids[start as usize];
            self.push(id, end - start, out + start, [x + 16 * start, y]);
        }
    }

    /// [`Batch::push`]. Without a branch: what is not to be kept is written where the next will be, or
    /// where nobody looks.
    #[inline(always)]
    fn push(&mut self, id: u32, len: u32, out: u32, place: [u32; 2]) {
        let is_there = id != NO_TRIANGLE;
        let record = self.record_of(id, is_there);
        self.runs[self.n.runs] = Run::new(record, place, len, out);
        self.n.runs += usize::from(is_there);
        self.n.pixels += if is_there { len as usize } else { 0 };
    }

    /// [`Batch::record_of`]. The table may know of nothing, but nobody asks for its record.
    #[inline(always)]
    fn record_of(&mut self, id: u32, is_there: bool) -> u32 {
        let slot = (id ^ id >> 11) as usize % SLOTS;
        let key = u64::from(id) << 32 | u64::from(self.epoch) << 16;
        let known = self.table[slot];
        let is_known = (known ^ key) >> 16 == 0;
        let entry = if is_known { known } else { key | self.n.triangles as u64 };
        self.table[slot] = entry;
        self.ids[self.n.triangles] = id;
        self.n.triangles += usize::from(!is_known & is_there);
        entry as u32 & 0xffff
    }
}

/// Of what is not a run.
const NO_PAINT: u32 = u32::MAX;

/// Ids of triangles over a rectangle of one block, rows from top to bottom.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rectangle<'a> {
    pub ids: &'a [u32],
    /// From an id to the one below it.
    pub stride: usize,
    /// Width and height, px.
    pub size: [u32; 2],
    /// Where the first pixel goes, and how much further the one below it.
    pub out: usize,
    pub out_stride: usize,
    /// The centre of the first pixel, sixteenths of a pixel from the corner of the block.
    pub place: [u32; 2],
}

/// Room for the starts of all runs of a row: eight are written at a time, whatever there are.
const STARTS: usize = BLOCK as usize + 8;

/// Where the ids of a row change, the start among them; returns how often.
///
/// Without a branch that depends on ids, since the ends of small triangles are beyond prediction: eight
/// comparisons are a byte, and a table knows the places of its ones.
#[inline(always)]
fn run_starts<S: Simd>(simd: S, ids: &[u32], starts: &mut [u8; STARTS]) -> usize {
    let len = ids.len();
    if len < 9 {
        let mut n = usize::from(len > 0);
        for i in 1..len {
            starts[n] = i as u8;
            n += usize::from(ids[i] != ids[i - 1]);
        }
        return n;
    }
    let mut n = 1;
    let mut at = 1;
    while at < len {
        // The last eight may have some of the eight before.
        let first = at.min(len - 8);
        let own = u32x8::from_slice(simd, &ids[first..first + 8]);
        let before = u32x8::from_slice(simd, &ids[first - 1..first + 7]);
        let differs = !own.simd_eq(before).to_bitmask() as u8 & 0xff << (at - first);
        let places = PLACES_OF_ONES[usize::from(differs)].wrapping_add(first as u64 * LOW_BITS);
        *starts[n..].first_chunk_mut().expect("a margin of eight") = places.to_le_bytes();
        n += differs.count_ones() as usize;
        at = first + 8;
    }
    n
}

/// The lowest bit of each byte.
const LOW_BITS: u64 = 0x0101_0101_0101_0101;

/// By byte, the places of its ones in ascending order, a byte each.
static PLACES_OF_ONES: [u64; 256] = {
    let mut all = [0; 256];
    let mut byte = 0;
    while byte < 256 {
        let (mut bit, mut n) = (0, 0);
        while bit < 8 {
            if byte >> bit & 1 != 0 {
                all[byte] |= bit << (8 * n);
                n += 1;
            }
            bit += 1;
        }
        byte += 1;
    }
    all
};

#[cfg(test)]
mod tests {
    use super::*;

    /// The pixels of all runs: id, out, x, y.
    fn pixels(batch: &Batch) -> Vec<(u32, u32, u32, u32)> {
        let mut pixels = Vec::new();
        for run in batch.runs() {
            let (id, [x, y]) = (batch.ids()[run.record()], run.place());
            for i in 0..run.len {
                pixels.push((id, run.out + i, x + 16 * i, y));
            }
        }
        pixels
    }

    #[test]
    fn rows_become_runs_of_one_triangle_each() {
        let patterns: [fn(u32) -> u32; 5] = [
            |_| 7,
            |i| i,
            |i| if i % 3 == 0 { NO_TRIANGLE } else { i / 5 },
            |i| if i < 40 { NO_TRIANGLE } else { 2049 * (i / 16) },
            |i| i % 2,
        ];
        let mut batch = Batch::default();
        for len in [0, 1, 7, 8, 9, 10, 16, 17, 18, 63, 64] {
            for pattern in patterns {
                batch.begin();
                let mut expected = Vec::new();
                let ids = [0, 1].map(|y| (0..len).map(|x| pattern(x + y)).collect::<Vec<_>>());
                batch.rectangle(
                    Level::new(),
                    &Rectangle {
                        ids: &ids.concat(),
                        stride: len as usize,
                        size: [len, 2],
                        out: 0,
                        out_stride: 1000,
                        place: [8, 0],
                    },
                );
                for (y, ids) in (0..).zip(&ids) {
                    let first = 1000 * y;
                    let seen = (0..).zip(ids).filter(|(_, id)| **id != NO_TRIANGLE);
                    expected.extend(seen.map(|(x, id)| (*id, first + x, 16 * x + 8, 16 * y)));
                }
                assert_eq!(pixels(&batch), expected);
                assert_eq!(batch.n_pixels(), expected.len());
                let together = batch.runs().windows(2).find(|two| {
                    two[0].record() == two[1].record() && two[0].out + two[0].len == two[1].out
                });
                assert_eq!(together, None, "one run, in two");
            }
        }
    }

    #[test]
    fn a_batch_knows_nothing_of_the_one_before() {
        let mut batch = Batch::default();
        for i in 0..70_000 {
            batch.begin();
            batch.push(i % 3 + 1, 1, 0, [0; 2]);
            batch.push(i % 3 + 1, 1, 1, [0; 2]);
            assert_eq!(batch.ids(), [i % 3 + 1]);
        }
    }

    #[test]
    fn runs_are_sorted_by_paint() {
        let mut batch = Batch::default();
        batch.begin();
        for i in 0..200 {
            batch.push(i % 10, 1, i, [0; 2]);
        }
        let paint_of: Vec<u32> = batch.ids().iter().map(|id| [4, 1, 2][*id as usize % 3]).collect();
        let mut counts = [0, 1, 1, 0, 1];
        let sorted: Vec<u32> =
            batch.by_paint(Level::new(), &paint_of, &mut counts).iter().map(|r| r.out).collect();
        assert_eq!(counts, [0, 60, 60, 0, 80]);
        let mut expected: Vec<u32> = (0..200).collect();
        expected.sort_by_key(|i| [4, 1, 2][*i as usize % 10 % 3]);
        assert_eq!(sorted, expected);
    }
}
