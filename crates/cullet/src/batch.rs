//! The pixels of a block as runs, and the triangles that they show, before they are coloured.

use cullet_raster::{BLOCK, NO_TRIANGLE};
use cullet_shade::wide::Run;

/// Pixels coloured at once: those of a block.
pub(crate) const BATCH: usize = (BLOCK * BLOCK) as usize;

/// Slots of the table of triangles.
const SLOTS: usize = 2048;

/// Up to [`BATCH`] pixels, in runs of one triangle each.
#[derive(Debug)]
pub(crate) struct Batch {
    /// By some bits of an id: the id, the batch that it is of, and its record's number. The last slot is
    /// never looked at.
    table: Vec<u64>,
    /// Which batch this is.
    epoch: u16,
    /// The triangles, by the numbers of their records; the last place is for what is not to be kept.
    ids: Vec<u32>,
    /// Likewise.
    runs: Vec<Run>,
    /// The runs by paint.
    sorted: Vec<Run>,
    n_triangles: usize,
    n_runs: usize,
    n_pixels: usize,
}

impl Default for Batch {
    fn default() -> Self {
        Batch {
            table: vec![0; SLOTS + 1],
            epoch: 0,
            ids: vec![0; BATCH + 1],
            runs: vec![Run::default(); BATCH + 1],
            sorted: vec![Run::default(); BATCH + 1],
            n_triangles: 0,
            n_runs: 0,
            n_pixels: 0,
        }
    }
}

impl Batch {
    /// Memory held.
    pub(crate) fn bytes() -> usize {
        SLOTS * 8 + BATCH * (4 + 2 * size_of::<Run>())
    }

    /// Forgets the batch before.
    pub(crate) fn begin(&mut self) {
        self.epoch = self.epoch.wrapping_add(1);
        if self.epoch == 0 {
            self.table.fill(0);
            self.epoch = 1;
        }
        (self.n_triangles, self.n_runs, self.n_pixels) = (0, 0, 0);
    }

    /// Ids of the triangles, by the numbers of their records.
    pub(crate) fn ids(&self) -> &[u32] {
        &self.ids[..self.n_triangles]
    }

    pub(crate) fn n_pixels(&self) -> usize {
        self.n_pixels
    }

    /// Pixels of a row of the block, from `x`, `y` on, the first of which goes to `out`.
    #[inline]
    pub(crate) fn row(&mut self, ids: &[u32], out: u32, [x, y]: [f32; 2]) {
        let Some(first) = ids.first() else { return };
        let mut starts = [0_u8; BLOCK as usize + 1];
        let mut n = 0;
        let mut before = !first;
        let (eights, rest) = ids.as_chunks::<8>();
        let mut at = 0;
        for eight in eights {
            let mut differences = 0;
            for id in eight {
                differences |= id ^ before;
            }
            if differences != 0 {
                // Without a branch, since the ends of small triangles are beyond prediction.
                for (i, &id) in eight.iter().enumerate() {
                    starts[n] = at + i as u8;
                    n += usize::from(id != before);
                    before = id;
                }
            }
            at += 8;
        }
        for (i, &id) in rest.iter().enumerate() {
            starts[n] = at + i as u8;
            n += usize::from(id != before);
            before = id;
        }
        starts[n] = ids.len() as u8;
        for i in 0..n {
            let [start, end] = [starts[i], starts[i + 1]];
            let id = ids[usize::from(start)];
            let place = [x + f32::from(start), y];
            self.push(id, u16::from(end - start), out + u32::from(start), place);
        }
    }

    /// A run of `len` neighbours that show one triangle, or nothing. Without a branch as well: what is
    /// not to be kept is written where the next will be, or where nobody looks.
    #[inline(always)]
    pub(crate) fn push(&mut self, id: u32, len: u16, out: u32, [x, y]: [f32; 2]) {
        let is_there = id != NO_TRIANGLE;
        let record = self.record_of(id, is_there);
        self.runs[self.n_runs] = Run { record, len, out, x, y };
        self.n_runs += usize::from(is_there);
        self.n_pixels += if is_there { usize::from(len) } else { 0 };
    }

    /// Forgets the pixels, but not the triangles.
    pub(crate) fn begin_more(&mut self) {
        (self.n_runs, self.n_pixels) = (0, 0);
    }

    /// Pixels of a triangle whose record is known.
    #[inline(always)]
    pub(crate) fn put(&mut self, run: Run) {
        self.runs[self.n_runs] = run;
        self.n_runs += 1;
        self.n_pixels += usize::from(run.len);
    }

    /// The number of a triangle's record, a new one if it is not known.
    #[inline(always)]
    pub(crate) fn record_of(&mut self, id: u32, is_there: bool) -> u16 {
        let slot = (id ^ id >> 11) as usize % SLOTS;
        let key = u64::from(id) << 32 | u64::from(self.epoch) << 16;
        let known = self.table[slot];
        let is_known = (known ^ key) >> 16 == 0;
        let record = if is_known { known & 0xffff } else { self.n_triangles as u64 };
        self.table[if is_known { SLOTS } else { slot }] = key | record;
        self.ids[self.n_triangles] = id;
        self.n_triangles += usize::from(!is_known & is_there);
        record as u16
    }

    /// All runs.
    pub(crate) fn runs(&self) -> &[Run] {
        &self.runs[..self.n_runs]
    }

    /// Puts the runs in the order of their paints, which `paint_of` says by record, and says in
    /// `counts`, by paint, how many there are; on entry, where there are any. Returns the runs.
    pub(crate) fn by_paint(&mut self, paint_of: &[u32], counts: &mut [u32]) -> &[Run] {
        let mut end = 0;
        // Once through all runs for each paint: there are few, and branches would be many.
        for (paint, count) in (0..).zip(counts).filter(|(_, count)| **count > 0) {
            let first = end;
            for run in &self.runs[..self.n_runs] {
                self.sorted[end] = *run;
                end += usize::from(paint_of[usize::from(run.record)] == paint);
            }
            *count = (end - first) as u32;
        }
        &self.sorted[..end]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The pixels of all runs: id, out, x, y.
    fn pixels(batch: &Batch) -> Vec<(u32, u32, f32, f32)> {
        let mut pixels = Vec::new();
        for run in batch.runs() {
            let id = batch.ids()[usize::from(run.record)];
            for i in 0..run.len {
                pixels.push((id, run.out + u32::from(i), run.x + f32::from(i), run.y));
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
        for len in [0, 1, 7, 8, 9, 63, 64] {
            for pattern in patterns {
                batch.begin();
                let mut expected = Vec::new();
                for y in [0, 1] {
                    let ids: Vec<u32> = (0..len).map(|x| pattern(x + y)).collect();
                    let first = 1000 * y;
                    batch.row(&ids, first, [0.5, y as f32]);
                    let seen = (0..).zip(&ids).filter(|(_, id)| **id != NO_TRIANGLE);
                    expected.extend(seen.map(|(x, id)| (*id, first + x, x as f32 + 0.5, y as f32)));
                }
                assert_eq!(pixels(&batch), expected);
                assert_eq!(batch.n_pixels(), expected.len());
                let together = batch.runs().windows(2).find(|two| {
                    two[0].record == two[1].record
                        && two[0].out + u32::from(two[0].len) == two[1].out
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
            batch.push(i % 3 + 1, 1, 0, [0.0; 2]);
            batch.push(i % 3 + 1, 1, 1, [0.0; 2]);
            assert_eq!(batch.ids(), [i % 3 + 1]);
        }
    }

    #[test]
    fn runs_are_sorted_by_paint() {
        let mut batch = Batch::default();
        batch.begin();
        for i in 0..200 {
            batch.push(i % 10, 1, i, [0.0; 2]);
        }
        let paint_of: Vec<u32> = batch.ids().iter().map(|id| [4, 1, 2][*id as usize % 3]).collect();
        let mut counts = [0, 1, 1, 0, 1];
        let sorted: Vec<u32> =
            batch.by_paint(&paint_of, &mut counts).iter().map(|r| r.out).collect();
        assert_eq!(counts, [0, 60, 60, 0, 80]);
        let mut expected: Vec<u32> = (0..200).collect();
        expected.sort_by_key(|i| [4, 1, 2][*i as usize % 10 % 3]);
        assert_eq!(sorted, expected);
    }
}
