//! Many frusta in one walk: the cascades of a shadow map, the faces of a cube, the tiles of a
//! picture.
//!
//! Each child carries the set of frusta that cut it and the set of those it is wholly inside of;
//! only the first are asked about what lies below. A run is returned when nothing cuts any more.

use fearless_simd::{Simd, dispatch};

use super::stats::{Counts, MAX_LEVELS, WalkStats};
use super::tree::Tree;
use crate::wide::{Group, Level, Planes8};
use crate::{Frustum, PlaneMask, planes_cutting};

/// The most frusta of one walk.
pub const MAX_FRUSTA: usize = 64;

/// Receives runs of items with the frusta that may see them, one bit each.
pub(super) type Visit<'a> = dyn FnMut(&[u32], u64) + 'a;

pub(super) fn walk(
    tree: &Tree,
    frusta: &[Frustum],
    level: Level,
    visit: &mut Visit<'_>,
) -> WalkStats {
    assert!(frusta.len() <= MAX_FRUSTA, "at most {MAX_FRUSTA} frusta at a time");
    let mut stats = WalkStats::default();
    for (id, bounds) in &tree.beside {
        let mut seen_by = 0;
        for (index, frustum) in frusta.iter().enumerate() {
            let cutting = planes_cutting(bounds, frustum, PlaneMask::ALL);
            seen_by |= u64::from(cutting.is_some()) << index;
        }
        let (outside, straddling) = (u64::from(seen_by == 0), u64::from(seen_by != 0));
        stats.items += Counts { tested: 1, outside, inside: 0, straddling };
        if seen_by != 0 {
            stats.n_visible += 1;
            visit(&[*id], seen_by);
        }
    }
    if let (true, Some(first)) = (tree.has_root(), frusta.first()) {
        let planes = |frustum| Planes8::new(frustum, &tree.space, &tree.bounds);
        let mut all = [planes(first); MAX_FRUSTA];
        for (slot, frustum) in all.iter_mut().zip(frusta).skip(1) {
            *slot = planes(frustum);
        }
        let mut walker = Walker { tree, planes: &all, stats: &mut stats, visit };
        let everyone = u64::MAX >> (MAX_FRUSTA - frusta.len());
        dispatch!(level, simd => walker.run(simd, everyone));
    }
    stats
}

/// A node still to be entered.
#[derive(Clone, Copy, Default)]
struct Pending {
    node: u32,
    cut_by: u64,
    inside: u64,
}

struct Walker<'a> {
    tree: &'a Tree,
    planes: &'a [Planes8; MAX_FRUSTA],
    stats: &'a mut WalkStats,
    visit: &'a mut Visit<'a>,
}

/// By lane, the frusta that cut it and those it is inside of.
struct Verdicts {
    cut_by: [u64; 8],
    inside: [u64; 8],
}

impl Walker<'_> {
    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S, everyone: u64) {
        let mut stack = [Pending::default(); 7 * MAX_LEVELS + 8];
        stack[0] = Pending { node: 0, cut_by: everyone, inside: 0 };
        let mut n_pending = 1;
        while n_pending > 0 {
            n_pending -= 1;
            let Pending { node, cut_by, inside } = stack[n_pending];
            let node = &self.tree.nodes[node as usize];
            let verdicts = self.ask(simd, &node.bounds, cut_by, inside);
            self.stats.nodes += counts(node.present, &verdicts);
            for lane in 0..8 {
                let child = node.children[lane];
                let (cut_by, inside) = (verdicts.cut_by[lane], verdicts.inside[lane]);
                if child.is_absent() || cut_by | inside == 0 {
                    continue;
                }
                if cut_by == 0 && child.len > 0 {
                    self.stats.n_untested += u64::from(child.len);
                    self.stats.n_visible += u64::from(child.len);
                    (self.visit)(&self.tree.ids[child.slots()], inside);
                } else if let Some(group) = child.group() {
                    self.sift(simd, group, child.len as usize, cut_by, inside);
                } else if let Some(node) = child.node() {
                    stack[n_pending] = Pending { node: node as u32, cut_by, inside };
                    n_pending += 1;
                }
            }
        }
    }

    /// Tests the items of a leaf.
    #[inline(always)]
    fn sift<S: Simd>(&mut self, simd: S, group: usize, len: usize, cut_by: u64, inside: u64) {
        let verdicts = self.ask(simd, &self.tree.groups[group], cut_by, inside);
        self.stats.items += counts(0xff >> (8 - len.clamp(1, 8)), &verdicts);
        for (lane, id) in self.tree.ids[8 * group..8 * group + len].iter().enumerate() {
            let seen_by = verdicts.cut_by[lane & 7] | verdicts.inside[lane & 7];
            if seen_by != 0 {
                self.stats.n_visible += 1;
                (self.visit)(core::slice::from_ref(id), seen_by);
            }
        }
    }

    /// Asks the frusta in `cut_by` about eight boxes that all lie inside those of `inside`.
    #[inline(always)]
    fn ask<S: Simd>(&mut self, simd: S, group: &Group, cut_by: u64, inside: u64) -> Verdicts {
        let mut verdicts = Verdicts { cut_by: [0; 8], inside: [inside; 8] };
        let mut left = cut_by;
        while left != 0 {
            let index = left.trailing_zeros() as usize;
            left &= left - 1;
            let planes = &self.planes[index];
            self.stats.n_groups += 1;
            let verdict = planes.test(simd, group, planes.asked);
            let within = verdict.inside();
            let (mut cut, mut within) = (verdict.visible & !within, within);
            while cut != 0 {
                verdicts.cut_by[cut.trailing_zeros() as usize] |= 1 << index;
                cut &= cut - 1;
            }
            while within != 0 {
                verdicts.inside[within.trailing_zeros() as usize] |= 1 << index;
                within &= within - 1;
            }
        }
        verdicts
    }
}

/// A box counts as outside when it is so for all frusta, as inside when none cuts it.
#[inline(always)]
fn counts(present: u8, verdicts: &Verdicts) -> Counts {
    let (mut straddling, mut inside) = (0_u8, 0_u8);
    for lane in 0..8 {
        let (cut_by, within) = (verdicts.cut_by[lane], verdicts.inside[lane]);
        straddling |= u8::from(cut_by != 0) << lane;
        inside |= u8::from(cut_by == 0 && within != 0) << lane;
    }
    let count = |bits: u8| u64::from((bits & present).count_ones());
    let (tested, straddling, inside) = (count(0xff), count(straddling), count(inside));
    Counts { tested, outside: tested - straddling - inside, inside, straddling }
}
