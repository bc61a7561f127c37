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
//! What a batch finds is two lists, leaves to be looked into and runs to be returned, since a list
//! is gone through with fewer branches guessed wrongly than the bits of node after node. What is
//! returned of eight leaves is settled for all of them together, one bit per item, and all their
//! items with the same mask are one run.

use fearless_simd::{Simd, dispatch};

use super::stats::{Counts, MAX_LEVELS, WalkStats};
use super::tree::{Node, Tree};
use crate::wide::{Grid, Level, Planes8, Row, Verdict, errors};
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
    let errors = errors(&planes);
    let (ids, run) = ([0; 64], [0; 64]);
    let mut walker = Walker { tree, planes, errors, ids, run, stats, levels, visit };
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

/// So many nodes are worked on at once. 8 take a tenth longer where memory is slow (bench `walk`), 32 no
/// less.
const BATCH: usize = 16;

/// With more nodes than this on the stack only one at a time is taken from it.
const CROWDED: usize = 256;

/// A batch leaves the stack before its children enter it, and below a crowded stack each level
/// adds seven nodes at most: one leaves before its eight children enter. A batch is copied whole, with
/// what lies above the top, so there is room for one above any top.
const STACK: usize = CROWDED + 8 * BATCH + 7 * MAX_LEVELS;

/// A leaf that planes cut.
#[derive(Clone, Copy, Default)]
struct CutLeaf {
    /// The node above it.
    node: u32,
    group: u32,
    /// Where it is in the node.
    lane: u8,
    /// The planes that cut it, one bit each.
    planes: u8,
    /// One bit per item there is.
    present: u8,
}

/// Of every child of a batch at most one entry in a list.
const MOST: usize = 8 * BATCH;

/// What a batch of nodes has among its children, apart from nodes to be entered.
struct Found {
    leaves: [CutLeaf; MOST],
    n_leaves: usize,
    /// The first slot of what is wholly inside, and the one after the last.
    runs: [(u32, u32); MOST],
    n_runs: usize,
}

impl Found {
    fn leaves(&self) -> &[CutLeaf] {
        &self.leaves[..self.n_leaves.min(MOST)]
    }

    fn runs(&self) -> &[(u32, u32)] {
        &self.runs[..self.n_runs.min(MOST)]
    }
}

struct Walker<'a> {
    tree: &'a Tree,
    planes: Planes8,
    /// What each plane leaves in doubt of packed leaves, wherever they are.
    errors: [f32; 6],
    /// The items of eight leaves, eight each.
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
        let (leaves, runs) = ([CutLeaf::default(); MOST], [(0, 0); MOST]);
        let mut found = Found { leaves, n_leaves: 0, runs, n_runs: 0 };
        while n_pending > 0 {
            let n = if n_pending > CROWDED { 1 } else { n_pending.min(BATCH) };
            n_pending -= n;
            // All of it, whatever is above the top of the stack: a copy of fixed length is no call.
            batch.copy_from_slice(&stack[n_pending..n_pending + BATCH]);
            (found.n_leaves, found.n_runs) = (0, 0);
            for pending in &batch[..n] {
                self.look(simd, pending, &mut found, &mut stack, &mut n_pending);
            }
            self.fetch(&found, &stack[n_pending.saturating_sub(BATCH)..n_pending]);
            self.take(found.runs());
            for leaves in found.leaves().chunks(8) {
                self.sift(simd, leaves);
            }
        }
    }

    /// Tests the children of a node, and puts each that may be visible where it belongs.
    #[inline(always)]
    fn look<S: Simd>(
        &mut self,
        simd: S,
        pending: &Pending,
        found: &mut Found,
        stack: &mut [Pending; STACK],
        n_pending: &mut usize,
    ) {
        let node = &self.tree.nodes[pending.node as usize];
        let asked = PlaneMask::from_bits(pending.cutting as u8);
        let verdict = self.ask(simd, node, pending.level, asked);
        let masks = verdict.masks();
        let mut inside = verdict.inside();
        let crossed = verdict.visible & !inside;
        let mut enter = crossed & !node.leaves;
        if inside & !node.leaves != 0 {
            let scattered = inside & node.scattered();
            enter |= scattered;
            inside &= !scattered;
        }
        while enter != 0 {
            let lane = 7 - enter.leading_zeros() as usize;
            enter ^= 1 << lane;
            stack[*n_pending] = Pending {
                node: node.children[lane].node().unwrap_or(0) as u32,
                level: pending.level + 1,
                cutting: u16::from(masks[lane]),
            };
            *n_pending += 1;
        }
        let (mut n_leaves, mut n_runs) = (found.n_leaves, found.n_runs);
        let mut cut = crossed & node.leaves;
        while cut != 0 {
            let lane = cut.trailing_zeros() as usize & 7;
            cut &= cut - 1;
            let leaf = node.children[lane];
            debug_assert!(n_leaves < MOST);
            found.leaves[n_leaves % MOST] = CutLeaf {
                node: pending.node,
                group: leaf.first / 8,
                lane: lane as u8,
                planes: masks[lane],
                present: !(u32::MAX << (leaf.len & 31)) as u8,
            };
            n_leaves += 1;
        }
        while inside != 0 {
            let lane = inside.trailing_zeros() as usize & 7;
            inside &= inside - 1;
            let child = node.children[lane];
            debug_assert!(n_runs < MOST);
            found.runs[n_runs % MOST] = (child.first, child.first + child.len);
            n_runs += 1;
        }
        (found.n_leaves, found.n_runs) = (n_leaves, n_runs);
    }

    /// Loads a word of every line of memory that is wanted soon: leaves and items of what was
    /// `found`, and the nodes to come.
    ///
    /// A processor waits for many lines at a time as long as it need not guess which; in the walk
    /// proper every answer is a branch. Takes a third off where memory is cold, and adds a twentieth
    /// where it is warm. The idea is the group prefetching of Chen, Ailamaki, Gibbons and Mowry,
    /// "Improving Hash Join Performance through Prefetching", 2004.
    #[inline(always)]
    fn fetch(&self, found: &Found, to_come: &[Pending]) {
        const EVERY_LINE: [Row; 3] = [Row::MinX, Row::MinZ, Row::MaxY];
        let mut sum = 0;
        for pending in to_come {
            let node = &self.tree.nodes[pending.node as usize];
            EVERY_LINE.iter().for_each(|row| sum ^= node.bounds.row(*row)[0].to_bits());
            sum ^= node.children[0].first ^ node.children[6].first;
        }
        for leaf in found.leaves() {
            sum ^= self.tree.packed[leaf.group as usize].touch();
        }
        for (start, end) in found.runs() {
            // Of a long run the rest is fetched by itself.
            sum ^= self.tree.ids[*start as usize] ^ self.tree.ids[start.midpoint(*end) as usize];
        }
        core::hint::black_box(sum);
    }

    /// What the planes say of the children of a node.
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

    /// Returns what is wholly inside, neighbours together.
    #[inline(always)]
    fn take(&mut self, runs: &[(u32, u32)]) {
        let (mut start, mut end) = (0, 0);
        for (next, end_of_next) in runs {
            if *next != end {
                self.deliver(start, end);
                start = *next;
            }
            end = *end_of_next;
        }
        self.deliver(start, end);
    }

    #[inline(always)]
    fn deliver(&mut self, start: u32, end: u32) {
        let slots = start as usize..end as usize;
        if !slots.is_empty() {
            self.stats.n_untested += slots.len() as u64;
            self.stats.n_visible += slots.len() as u64;
            (self.visit)(&self.tree.ids[slots], PlaneMask::NONE);
        }
    }

    /// Tests the items in `leaves`, eight at most.
    #[inline(always)]
    fn sift<S: Simd>(&mut self, simd: S, leaves: &[CutLeaf]) {
        // Bit 8 l + i: item i of leaf l.
        let (mut present, mut visible, mut cut_by) = (0_u64, 0_u64, [0_u64; 6]);
        for (l, leaf) in leaves.iter().enumerate() {
            let first = (8 * l) & 63;
            let packed = &self.tree.packed[leaf.group as usize];
            let node = &self.tree.nodes[leaf.node as usize];
            let grid = Grid::in_lane(&node.bounds, usize::from(leaf.lane & 7));
            let ends = packed.ends(simd);
            self.ids[first..first + 8].copy_from_slice(&packed.ids);
            let mut seen = leaf.present;
            let mut left = leaf.planes;
            while left != 0 {
                let index = (left.trailing_zeros() as usize).min(5);
                left &= left - 1;
                let (plane, error) = (&self.planes.planes[index], self.errors[index]);
                let said = grid.ask(simd, plane, error, &ends, seen);
                let (mut reached, mut inside) = (said.reached, said.inside);
                if said.in_doubt {
                    let group = &self.tree.groups[leaf.group as usize];
                    (reached, inside) = self.planes.ask(simd, index, group);
                }
                seen &= reached;
                cut_by[index] |= u64::from(!inside) << first;
            }
            present |= u64::from(leaf.present) << first;
            visible |= u64::from(seen) << first;
        }
        let all_cut = cut_by.iter().fold(0, |all, cut_by| all | cut_by);
        let count = |bits: u64| u64::from(bits.count_ones());
        self.stats.n_groups += leaves.len() as u64;
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
