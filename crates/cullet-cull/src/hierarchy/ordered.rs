//! One frustum through the tree, nearest first.
//!
//! As in `walk`, but every node and leaf goes through the stack, sorted along the view direction,
//! so that leaves come between nodes as distance has it; and someone may be asked before each.

use fearless_simd::{Simd, dispatch, f32x8, prelude::*};

use super::stats::{Counts, MAX_LEVELS, WalkStats};
use super::tree::{Child, Tree};
use super::walk::{Visit, ask_beside, planes_for};
use crate::wide::{Group, Level, Planes8, Row};
use crate::{Aabb, Frustum, PlaneMask};

/// Whom to ask.
pub(super) trait Manner {
    /// Every box of a node or leaf is shown to [`Manner::hidden`], none skipped for a run.
    const ASKS: bool;
    /// Whether nothing in this box can be seen.
    fn hidden(&mut self, bounds: &Aabb) -> bool;
}

/// Nobody.
pub(super) struct NearToFar;

impl Manner for NearToFar {
    const ASKS: bool = false;
    fn hidden(&mut self, _: &Aabb) -> bool {
        false
    }
}

/// A question before each box.
pub(super) struct Occluded<'a>(pub &'a mut dyn FnMut(&Aabb) -> bool);

impl Manner for Occluded<'_> {
    const ASKS: bool = true;
    fn hidden(&mut self, bounds: &Aabb) -> bool {
        (self.0)(bounds)
    }
}

pub(super) fn walk<M: Manner>(
    tree: &Tree,
    frustum: &Frustum,
    level: Level,
    mut manner: M,
    visit: &mut Visit<'_>,
) -> WalkStats {
    let stats = ask_beside(tree, frustum, visit);
    let Some(planes) = planes_for(tree, frustum) else {
        return WalkStats { nodes: Counts::of_one(None), ..stats };
    };
    let mut walker = Walker { tree, planes, forward: forward(frustum), stats, visit };
    walker.stats.nodes = Counts::of_one(Some(walker.planes.asked));
    dispatch!(level, simd => walker.run(simd, &mut manner));
    walker.stats
}

/// The view direction as far as order goes: away from the near plane.
fn forward(frustum: &Frustum) -> [f32; 3] {
    frustum.planes[cullet_transform::Plane::Near.index()].normal.to_array().map(|x| x as f32)
}

/// A child still to be looked at. Eight bytes without a gap, so that a stack of them is cleared
/// in one sweep: with a gap that took a third of a walk that sees nothing.
#[derive(Clone, Copy, Default)]
struct Pending {
    /// The node it is a child of.
    node: u32,
    lane: u16,
    /// The planes that cut it, one bit each.
    cutting: u16,
}

/// A node leaves the stack before its eight children enter it.
const STACK: usize = 7 * MAX_LEVELS + 8;

struct Walker<'a> {
    tree: &'a Tree,
    planes: Planes8,
    forward: [f32; 3],
    stats: WalkStats,
    visit: &'a mut Visit<'a>,
}

impl Walker<'_> {
    #[inline(always)]
    fn run<S: Simd, M: Manner>(&mut self, simd: S, manner: &mut M) {
        let mut stack = Stack { pending: [Pending::default(); STACK], n: 0 };
        self.enter(simd, 0, self.planes.asked, &mut stack);
        while let Some(Pending { node, lane, cutting }) = stack.pop() {
            let parent = &self.tree.nodes[node as usize];
            let lane = usize::from(lane & 7);
            if M::ASKS && manner.hidden(&self.tree.space.restore(&parent.bounds.get(lane))) {
                self.stats.n_occluded += 1;
                continue;
            }
            let child = parent.children[lane];
            let cutting = PlaneMask::from_bits(cutting as u8);
            if let Some(group) = child.group() {
                self.sift(simd, group, child, cutting);
            } else if cutting.is_empty() && child.len > 0 && !M::ASKS {
                self.take(child);
            } else if let Some(node) = child.node() {
                self.enter(simd, node, cutting, &mut stack);
            }
        }
    }

    /// Tests the children of a node and puts those that remain on the stack.
    #[inline(always)]
    fn enter<S: Simd>(&mut self, simd: S, index: usize, asked: PlaneMask, stack: &mut Stack) {
        let node = &self.tree.nodes[index];
        let (mut visible, mut masks) = (node.present, [0; 8]);
        if !asked.is_empty() {
            let verdict = self.planes.test(simd, &node.bounds, asked);
            self.stats.n_groups += 1;
            self.stats.nodes += Counts::of(node.present, verdict);
            (visible, masks) = (verdict.visible, verdict.masks());
        }
        let keys = along(simd, &node.bounds, self.forward);
        let base = stack.n;
        while visible != 0 {
            let lane = visible.trailing_zeros() as usize;
            visible &= visible - 1;
            let cutting = u16::from(masks[lane]);
            stack.push(Pending { node: index as u32, lane: lane as u16, cutting });
            stack.sink(base, &keys);
        }
    }

    /// Tests the items of a leaf.
    #[inline(always)]
    fn sift<S: Simd>(&mut self, simd: S, group: usize, leaf: Child, asked: PlaneMask) {
        if asked.is_empty() {
            return self.take(leaf);
        }
        let verdict = self.planes.test(simd, &self.tree.groups[group], asked);
        let present = 0xff >> (8 - leaf.len.clamp(1, 8));
        self.stats.n_groups += 1;
        self.stats.items += Counts::of(present, verdict);
        self.stats.n_visible += u64::from(verdict.visible.count_ones());
        let ids = &self.tree.ids[leaf.slots()];
        if verdict.inside() == present {
            return (self.visit)(ids, PlaneMask::NONE);
        }
        // One call per mask: neighbours are mostly cut by the same plane.
        let masks = verdict.masks();
        let mut left = verdict.visible;
        while left != 0 {
            let mask = masks[left.trailing_zeros() as usize];
            let (mut run, mut n) = ([0; 8], 0);
            for (lane, id) in ids.iter().enumerate() {
                let belongs = left >> lane & u8::from(masks[lane & 7] == mask);
                run[n & 7] = *id;
                n += usize::from(belongs & 1);
                left &= !((belongs & 1) << lane);
            }
            (self.visit)(&run[..n.min(8)], PlaneMask::from_bits(mask));
        }
    }

    /// Returns everything below a child, whose slots lie side by side.
    #[inline(always)]
    fn take(&mut self, child: Child) {
        self.stats.n_untested += u64::from(child.len);
        self.stats.n_visible += u64::from(child.len);
        (self.visit)(&self.tree.ids[child.slots()], PlaneMask::NONE);
    }
}

/// How far the middle of each box lies along `direction`, times two.
#[inline(always)]
fn along<S: Simd>(simd: S, group: &Group, direction: [f32; 3]) -> [f32; 8] {
    let mut sum = f32x8::splat(simd, 0.0);
    for (axis, component) in direction.into_iter().enumerate() {
        let min = f32x8::simd_from(simd, *group.row(Row::MIN[axis]));
        let max = f32x8::simd_from(simd, *group.row(Row::MAX[axis]));
        sum += (min + max) * component;
    }
    sum.into()
}

struct Stack {
    pending: [Pending; STACK],
    n: usize,
}

impl Stack {
    #[inline(always)]
    fn push(&mut self, pending: Pending) {
        self.pending[self.n] = pending;
        self.n += 1;
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<Pending> {
        self.n = self.n.checked_sub(1)?;
        Some(self.pending[self.n])
    }

    /// Lets the topmost sink, no further than `base`, until none above it is farther.
    #[inline(always)]
    fn sink(&mut self, base: usize, keys: &[f32; 8]) {
        let key = |pending: Pending| keys[usize::from(pending.lane & 7)];
        let mut i = self.n - 1;
        while i > base && key(self.pending[i - 1]) <= key(self.pending[i]) {
            self.pending.swap(i - 1, i);
            i -= 1;
        }
    }
}
