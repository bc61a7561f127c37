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
//! Nodes are taken from the stack in batches: all of a batch are tested, then what they need of
//! memory is loaded at once, then items are returned. (A tree beyond the caches is a random
//! walk through memory, and one line at a time is a wait each.)
//!
//! What is returned of the leaves of a node is settled for all of them together, one bit per
//! item: that asks memory for eight leaves at a time, guesses few branches wrongly, and returns
//! all items with the same mask in one run.

use fearless_simd::{Simd, dispatch};

use super::stats::{Counts, MAX_LEVELS, WalkStats};
use super::tree::{Node, Tree};
use crate::wide::{Level, Planes8, Row, Verdict};
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

/// So many nodes are worked on at once. 4 and 16 are slower, where memory is (bench `walk`).
const BATCH: usize = 8;

/// With more nodes than this on the stack only one at a time is taken from it.
const CROWDED: usize = 64;

/// A batch leaves the stack before its children enter it, and below a crowded stack each level
/// adds seven nodes at most: one leaves before its eight children enter.
const STACK: usize = CROWDED + 7 * BATCH + 7 * MAX_LEVELS;

/// What is visible of the children of a node, apart from nodes to be entered.
#[derive(Clone, Copy)]
struct Found {
    node: u32,
    /// Children that are wholly inside.
    inside: u8,
    /// Leaves that planes cut.
    cut: u8,
    verdict: Verdict,
}

impl Found {
    const NOTHING: Found = Found { node: 0, inside: 0, cut: 0, verdict: Verdict::NOTHING };
}

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
        let mut batch = [Pending::default(); BATCH];
        let mut found = [Found::NOTHING; BATCH];
        while n_pending > 0 {
            let n = if n_pending > CROWDED { 1 } else { n_pending.min(BATCH) };
            n_pending -= n;
            batch[..n].copy_from_slice(&stack[n_pending..n_pending + n]);
            for (pending, found) in batch[..n].iter().zip(&mut found) {
                let enter;
                (*found, enter) = self.look(simd, pending);
                let node = &self.tree.nodes[pending.node as usize];
                let masks = found.verdict.masks();
                let mut left = enter;
                while left != 0 {
                    let lane = 7 - left.leading_zeros() as usize;
                    left ^= 1 << lane;
                    stack[n_pending] = Pending {
                        node: node.children[lane].node().unwrap_or(0) as u32,
                        level: pending.level + 1,
                        cutting: u16::from(masks[lane]),
                    };
                    n_pending += 1;
                }
            }
            self.fetch(&found[..n], &stack[n_pending.saturating_sub(BATCH)..n_pending]);
            for found in &found[..n] {
                let node = &self.tree.nodes[found.node as usize];
                self.take(node, found.inside);
                if found.cut != 0 {
                    self.sift(simd, node, found.cut, found.verdict);
                }
            }
        }
    }

    /// What is to be returned of a node's children, and which of them are to be entered.
    #[inline(always)]
    fn look<S: Simd>(&mut self, simd: S, pending: &Pending) -> (Found, u8) {
        let node = &self.tree.nodes[pending.node as usize];
        let asked = PlaneMask::from_bits(pending.cutting as u8);
        let verdict = self.ask(simd, node, pending.level, asked);
        let mut inside = verdict.inside();
        let crossed = verdict.visible & !inside;
        let mut enter = crossed & !node.leaves;
        if inside & !node.leaves != 0 {
            let scattered = inside & node.scattered();
            enter |= scattered;
            inside &= !scattered;
        }
        (Found { node: pending.node, inside, cut: crossed & node.leaves, verdict }, enter)
    }

    /// Loads a word of every line of memory that is wanted soon: leaves and items of what was
    /// `found`, and the nodes to come.
    ///
    /// A processor waits for many lines at a time as long as it need not guess which; in the walk
    /// proper every answer is a branch. Takes a third off where memory is cold, and adds a twentieth
    /// where it is warm. The idea is the group prefetching of Chen, Ailamaki, Gibbons and Mowry,
    /// "Improving Hash Join Performance through Prefetching", 2004.
    #[inline(always)]
    fn fetch(&self, found: &[Found], to_come: &[Pending]) {
        const EVERY_LINE: [Row; 3] = [Row::MinX, Row::MinZ, Row::MaxY];
        let mut sum = 0;
        for pending in to_come {
            let node = &self.tree.nodes[pending.node as usize];
            EVERY_LINE.iter().for_each(|row| sum ^= node.bounds.row(*row)[0].to_bits());
            sum ^= node.children[0].first ^ node.children[6].first;
        }
        for found in found {
            let node = &self.tree.nodes[found.node as usize];
            let mut left = found.cut;
            while left != 0 {
                let lane = left.trailing_zeros() as usize & 7;
                left &= left - 1;
                let first = node.children[lane].first as usize;
                let group = &self.tree.groups[first / 8];
                EVERY_LINE.iter().for_each(|row| sum ^= group.row(*row)[0].to_bits());
                sum ^= self.tree.ids[first];
            }
            let mut left = found.inside;
            while left != 0 {
                let lane = left.trailing_zeros() as usize & 7;
                left &= left - 1;
                // Of a long run the rest is fetched by itself.
                let slots = node.children[lane].slots();
                sum ^= self.tree.ids[slots.start] ^ self.tree.ids[slots.start.midpoint(slots.end)];
            }
        }
        core::hint::black_box(sum);
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

    /// Returns everything below the children in `lanes`, neighbours together.
    #[inline(always)]
    fn take(&mut self, node: &Node, mut lanes: u8) {
        let mut run = 0..0;
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            let slots = node.children[lane & 7].slots();
            if slots.start != run.end {
                self.deliver(run);
                run = slots.start..slots.start;
            }
            run.end = slots.end;
        }
        self.deliver(run);
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
