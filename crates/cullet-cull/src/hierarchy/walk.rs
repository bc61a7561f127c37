//! One frustum through the tree, in any order, as fast as possible.
//!
//! A node is tested with the planes its own box was found to be cut by, all children at once,
//! and each surviving child inherits what cuts it (Bishop, Eberly, Whitted, Finch and Shantz,
//! "Designing a PC Game Engine", 1998; Assarsson and Möller, "Optimized View Frustum Culling
//! Algorithms for Bounding Boxes", 2000). A child that nothing cuts needs no further test: its
//! items lie side by side and are returned as one run.
//!
//! The box around everything is tested first, plane by plane as each is made ready, so a frustum
//! that sees nothing costs little more than the plane that says so.
//!
//! What is returned of the leaves of a node is settled for all of them together, one bit per
//! item: that asks memory for eight leaves at a time, guesses few branches wrongly, and returns
//! all items with the same mask in one run.

use fearless_simd::{Simd, dispatch};

use super::stats::{Counts, MAX_LEVELS, WalkStats};
use super::tree::{Node, Tree};
use crate::wide::{Level, Planes8, Verdict};
use crate::{Frustum, PlaneMask, planes_cutting};

/// Receives runs of items that share a mask.
pub(super) type Visit<'a> = dyn FnMut(&[u32], PlaneMask) + 'a;

pub(super) fn walk(
    tree: &Tree,
    frustum: &Frustum,
    level: Level,
    levels: Option<&mut [Counts; MAX_LEVELS]>,
    visit: &mut Visit<'_>,
) -> WalkStats {
    let stats = ask_beside(tree, frustum, visit);
    let Some(planes) = planes_for(tree, frustum) else {
        return WalkStats { nodes: Counts::of_one(None), ..stats };
    };
    let (ids, run) = ([0; 64], [0; 64]);
    let mut walker = Walker { tree, planes, ids, run, stats, levels, visit };
    walker.stats.nodes = Counts::of_one(Some(walker.planes.asked));
    dispatch!(level, simd => walker.run(simd));
    walker.stats
}

/// Returns what is visible of the items that are kept beside the tree.
#[inline(always)]
pub(super) fn ask_beside(tree: &Tree, frustum: &Frustum, visit: &mut Visit<'_>) -> WalkStats {
    let mut stats = WalkStats::default();
    for (id, bounds) in &tree.beside {
        let cutting = planes_cutting(bounds, frustum, PlaneMask::ALL);
        stats.items += Counts::of_one(cutting);
        if let Some(cutting) = cutting {
            stats.n_visible += 1;
            visit(&[*id], cutting);
        }
    }
    stats
}

/// The planes for all that is in the tree, unless nothing is visible, or nothing there.
#[inline(always)]
pub(super) fn planes_for(tree: &Tree, frustum: &Frustum) -> Option<Planes8> {
    if tree.nodes.is_empty() {
        return None;
    }
    Planes8::cutting(frustum, &tree.space, &tree.bounds)
}

/// A node still to be entered. Eight bytes without a gap, so that a stack of them is cleared in
/// one sweep.
#[derive(Clone, Copy, Default)]
struct Pending {
    node: u32,
    /// 0 for the root.
    level: u16,
    /// The planes that cut it, one bit each.
    cutting: u16,
}

/// A node leaves the stack before its eight children enter it.
const STACK: usize = 7 * MAX_LEVELS + 8;

struct Walker<'a> {
    tree: &'a Tree,
    planes: Planes8,
    /// The items of the leaves of a node, eight each.
    ids: [u32; 64],
    /// Those of them that share a mask.
    run: [u32; 64],
    stats: WalkStats,
    /// Boxes of nodes by level, for those who want to know.
    levels: Option<&'a mut [Counts; MAX_LEVELS]>,
    visit: &'a mut Visit<'a>,
}

impl Walker<'_> {
    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S) {
        let mut stack = [Pending::default(); STACK];
        stack[0].cutting = u16::from(self.planes.asked.bits());
        let mut n_pending = 1;
        while n_pending > 0 {
            n_pending -= 1;
            let Pending { node, level, cutting } = stack[n_pending];
            let node = &self.tree.nodes[node as usize];
            let asked = PlaneMask::from_bits(cutting as u8);
            let verdict = self.ask(simd, node, level, asked);
            let within = verdict.inside();
            let scattered = self.take(node, within);
            let cut = verdict.visible & !within;
            if cut & node.leaves != 0 {
                self.sift(simd, node, cut & node.leaves, verdict);
            }
            let masks = verdict.masks();
            let mut enter = cut & !node.leaves | scattered;
            while enter != 0 {
                let lane = 7 - enter.leading_zeros() as usize;
                enter ^= 1 << lane;
                let child = node.children[lane].node().unwrap_or(0) as u32;
                stack[n_pending] =
                    Pending { node: child, level: level + 1, cutting: u16::from(masks[lane]) };
                n_pending += 1;
            }
        }
    }

    /// Tests the children of a node.
    #[inline(always)]
    fn ask<S: Simd>(&mut self, simd: S, node: &Node, level: u16, asked: PlaneMask) -> Verdict {
        if asked.is_empty() {
            return Verdict::inside_all(node.present);
        }
        let verdict = self.planes.test(simd, &node.bounds, asked);
        self.stats.n_groups += 1;
        let counts = Counts::of(node.present, verdict);
        self.stats.nodes += counts;
        if let Some(levels) = &mut self.levels {
            levels[usize::from(level) % MAX_LEVELS] += counts;
        }
        verdict
    }

    /// Returns everything below the children in `lanes`, neighbours together; but for those below
    /// whom items are scattered, which are the answer.
    #[inline(always)]
    fn take(&mut self, node: &Node, mut lanes: u8) -> u8 {
        let (mut scattered, mut run) = (0, 0..0);
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            let slots = node.children[lane & 7].slots();
            scattered |= u8::from(slots.is_empty()) << lane;
            if slots.start != run.end {
                self.deliver(run);
                run = slots.start..slots.start;
            }
            run.end = slots.end;
        }
        self.deliver(run);
        scattered
    }

    #[inline(always)]
    fn deliver(&mut self, slots: core::ops::Range<usize>) {
        if !slots.is_empty() {
            self.stats.n_untested += slots.len() as u64;
            self.stats.n_visible += slots.len() as u64;
            (self.visit)(&self.tree.ids[slots], PlaneMask::NONE);
        }
    }

    /// Tests the items in those of a node's `leaves` that planes cut, not none, as `verdict` says.
    #[inline(always)]
    fn sift<S: Simd>(&mut self, simd: S, node: &Node, leaves: u8, verdict: Verdict) {
        // Bit 8 l + i: item i of the leaf in lane l.
        let (mut present, mut visible, mut cut_by) = (0_u64, 0_u64, [0_u64; 6]);
        let mut left = leaves;
        while left != 0 {
            let lane = left.trailing_zeros() as usize & 7;
            left &= left - 1;
            let leaf = node.children[lane];
            present |= (0xff >> (8 - leaf.len.clamp(1, 8))) << (8 * lane);
            visible |= 0xff << (8 * lane);
            let first = leaf.first as usize;
            self.ids[8 * lane..8 * lane + 8].copy_from_slice(&self.tree.ids[first..first + 8]);
        }
        for (plane, cut_by) in cut_by.iter_mut().enumerate() {
            let mut left = verdict.cut_by(plane) & leaves;
            while left != 0 {
                let lane = left.trailing_zeros() as usize & 7;
                left &= left - 1;
                let group = &self.tree.groups[node.children[lane].first as usize / 8];
                let (reached, inside) = self.planes.ask(simd, plane, group);
                visible &= !(u64::from(!reached) << (8 * lane));
                *cut_by |= u64::from(!inside) << (8 * lane);
            }
        }
        let all_cut = cut_by.iter().fold(0, |all, cut_by| all | cut_by);
        let count = |bits: u64| u64::from(bits.count_ones());
        self.stats.n_groups += u64::from(leaves.count_ones());
        self.stats.n_visible += count(visible);
        self.stats.items += Counts {
            tested: count(present),
            outside: count(present & !visible),
            inside: count(visible & !all_cut),
            straddling: count(visible & all_cut),
        };
        let mut left = visible;
        while left != 0 {
            let first = left.trailing_zeros();
            let (mut alike, mut mask) = (left, 0);
            for (plane, cut_by) in cut_by.iter().enumerate() {
                let is_cut = cut_by >> first & 1;
                mask |= (is_cut as u8) << plane;
                alike &= cut_by ^ is_cut.wrapping_sub(1);
            }
            left &= !alike;
            let mut n = 0;
            while alike != 0 {
                self.run[n & 63] = self.ids[alike.trailing_zeros() as usize & 63];
                alike &= alike - 1;
                n += 1;
            }
            (self.visit)(&self.run[..n.min(64)], PlaneMask::from_bits(mask));
        }
    }
}
