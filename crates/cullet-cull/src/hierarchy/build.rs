//! Building a tree: split where boxes cost least, eight ways at a time.
//!
//! The surface area heuristic: what a split costs is the number of boxes on each side times
//! the area around them (Goldsmith and Salmon 1987). It is looked for among 16 bins per axis
//! (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007). A node takes
//! its eight children by splitting the one with the largest area again and again (Wald,
//! Benthin and Boulos, "Getting Rid of Packets", 2008).
//!
//! Splits are rounded to whole groups: to multiples of 64 items while there are more, then of 8.
//! So all leaves but the last hold exactly eight boxes, the nodes above them are mostly full, and
//! the leaves in order are a plain list of boxes with no holes.
//!
//! Whatever the boxes, the tree is at most [`MAX_LEVELS`] deep and built in O(n log n): where
//! centres coincide, and where the levels left over get scarce, items are split into equal
//! halves by rank.

use alloc::vec::Vec;

use super::stats::MAX_LEVELS;
use super::tree::{Child, NO_PARENT, Node, Tree};
use crate::wide::{Box32, Group};

/// Runs two pieces of work, maybe at the same time, and returns when both are done.
///
/// With rayon: `&|a, b| { rayon::join(a, b); }`.
pub type Join<'a> = dyn Fn(&mut (dyn FnMut() + Send), &mut (dyn FnMut() + Send)) + Sync + 'a;

/// One after the other.
pub(super) fn in_turn(a: &mut (dyn FnMut() + Send), b: &mut (dyn FnMut() + Send)) {
    a();
    b();
}

/// Fewer items than this are not worth a thread.
const WORTH_JOINING: usize = 1 << 14;

/// Levels kept in reserve for balanced splits.
const RESERVE: usize = 6;

const N_BINS: usize = 16;

/// An item under construction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    pub bounds: Box32,
    pub id: u32,
}

/// How to split.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Split {
    /// Where it is cheapest.
    Cheapest,
    /// Into halves: the least depth for any boxes.
    Halves,
}

/// Arranges `items` in leaf order and returns the nodes above them, the root first and every
/// child after its parent. Slots count from 0; the root is at `level`.
pub(super) fn build_nodes(
    items: &mut [Item],
    level: usize,
    split: Split,
    join: &Join<'_>,
) -> Vec<Node> {
    let mut nodes = Vec::new();
    if !items.is_empty() {
        let builder = Builder { split, join };
        builder.node(items, 0, level, &mut nodes);
    }
    nodes
}

/// Leaf groups and the ids in their slots, for items in leaf order.
pub(super) fn leaves(items: &[Item]) -> (Vec<Group>, Vec<u32>) {
    let fill = |chunk: &[Item]| {
        let mut group = Group::ABSENT;
        chunk.iter().enumerate().for_each(|(lane, item)| group.set(lane, &item.bounds));
        group
    };
    let groups: Vec<Group> = items.chunks(8).map(fill).collect();
    let mut ids: Vec<u32> = items.iter().map(|item| item.id).collect();
    ids.resize(8 * groups.len(), Tree::NO_ITEM);
    (groups, ids)
}

/// Items that will become one child.
struct Segment<'a> {
    items: &'a mut [Item],
    bounds: Box32,
}

impl<'a> Segment<'a> {
    fn new(items: &'a mut [Item]) -> Self {
        let bounds = items.iter().fold(Box32::EMPTY, |all, item| all.union(&item.bounds));
        Segment { items, bounds }
    }
}

struct Builder<'a> {
    split: Split,
    join: &'a Join<'a>,
}

impl Builder<'_> {
    /// Appends the node over `items`, not none, whose first slot is `first`, and all below it.
    fn node(&self, items: &mut [Item], first: usize, level: usize, nodes: &mut Vec<Node>) {
        let n_items = items.len();
        let here = nodes.len();
        nodes.push(Node::EMPTY);
        let mut slot = first;
        let mut tasks = Vec::new();
        for (lane, segment) in self.segments(items, level).into_iter().enumerate() {
            let len = segment.items.len();
            let is_leaf = len <= 8;
            let child = if is_leaf { Child::leaf } else { Child::inner };
            nodes[here].set(lane, child(slot as u32, len as u32), &segment.bounds);
            if !is_leaf {
                tasks.push(Task { lane, items: segment.items, first: slot, nodes: Vec::new() });
            }
            slot += len;
        }
        if n_items < WORTH_JOINING {
            for task in tasks {
                let offset = nodes.len() as u32;
                nodes[here].children[task.lane].shift(offset);
                self.node(task.items, task.first, level + 1, nodes);
            }
            return;
        }
        self.run(&mut tasks, level + 1);
        for mut task in tasks {
            let offset = nodes.len() as u32;
            nodes[here].children[task.lane].shift(offset);
            task.nodes.iter_mut().for_each(|node| node.shift(offset));
            nodes.append(&mut task.nodes);
        }
    }

    /// Builds the nodes of each task, half of the tasks beside the other half.
    fn run(&self, tasks: &mut [Task<'_>], level: usize) {
        match tasks {
            [] => {}
            [task] => self.node(task.items, task.first, level, &mut task.nodes),
            _ => {
                let (a, b) = tasks.split_at_mut(tasks.len() / 2);
                (self.join)(&mut || self.run(a, level), &mut || self.run(b, level));
            }
        }
    }

    /// Splits `items` into at most eight, each a whole number of groups but the last.
    fn segments<'a>(&self, items: &'a mut [Item], level: usize) -> Vec<Segment<'a>> {
        let levels_left = MAX_LEVELS.saturating_sub(level + RESERVE);
        let shallow = 8_usize.checked_pow(levels_left as u32).is_none_or(|n| items.len() <= n);
        let split = if shallow { self.split } else { Split::Halves };
        let unit = if items.len() > 64 { 64 } else { 8 };
        let mut segments = Vec::with_capacity(8);
        segments.push(Segment::new(items));
        while segments.len() < 8 {
            let cost = |segment: &Segment<'_>| match split {
                Split::Cheapest => segment.bounds.half_area(),
                Split::Halves => segment.items.len() as f64,
            };
            let largest = (0..segments.len())
                .filter(|&i| segments[i].items.len() > unit)
                .max_by(|&a, &b| cost(&segments[a]).total_cmp(&cost(&segments[b])));
            let Some(largest) = largest else { break };
            let segment = segments.remove(largest);
            let at = arrange(segment.items, unit, split);
            let (a, b) = segment.items.split_at_mut(at);
            segments.insert(largest, Segment::new(b));
            segments.insert(largest, Segment::new(a));
        }
        segments
    }
}

/// A child to be built.
struct Task<'a> {
    lane: usize,
    items: &'a mut [Item],
    first: usize,
    nodes: Vec<Node>,
}

/// Orders `items`, more than `unit`, so that all before the returned index lie before all after
/// it along some axis; the index is a multiple of `unit`.
fn arrange(items: &mut [Item], unit: usize, split: Split) -> usize {
    let centers = items.iter().fold(Box32::EMPTY, |all, item| {
        let center = core::array::from_fn(|axis| item.bounds.center2(axis));
        all.union(&Box32 { min: center, max: center })
    });
    let n_units = items.len().div_ceil(unit);
    let cheapest = match split {
        Split::Cheapest => cheapest_split(items, &centers),
        Split::Halves => None,
    };
    let (axis, at) = cheapest.unwrap_or_else(|| {
        let extent = |axis: usize| centers.max[axis] - centers.min[axis];
        let widest = (0..3).max_by(|&a, &b| extent(a).total_cmp(&extent(b))).unwrap_or(0);
        (widest, items.len() / 2)
    });
    let at = unit * ((at + unit / 2) / unit).clamp(1, n_units - 1);
    items.select_nth_unstable_by(at, |a, b| {
        let (x, y) = (a.bounds.center2(axis), b.bounds.center2(axis));
        x.total_cmp(&y).then(a.id.cmp(&b.id))
    });
    at
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Box32,
    n: usize,
}

/// The axis and number of items before the cheapest split between bins; `None` if all centres
/// coincide.
fn cheapest_split(items: &[Item], centers: &Box32) -> Option<(usize, usize)> {
    let mut bins = [[Bin { bounds: Box32::EMPTY, n: 0 }; N_BINS]; 3];
    let scale: [f32; 3] = core::array::from_fn(|axis| {
        let extent = centers.max[axis] - centers.min[axis];
        let scale = N_BINS as f32 * (1.0 - 1e-6) / extent;
        if scale.is_finite() { scale } else { 0.0 }
    });
    for item in items {
        for axis in 0..3 {
            let along = (item.bounds.center2(axis) - centers.min[axis]) * scale[axis];
            let bin = &mut bins[axis][(along as usize).min(N_BINS - 1)];
            bin.bounds = bin.bounds.union(&item.bounds);
            bin.n += 1;
        }
    }
    let mut best: Option<(f64, usize, usize)> = None;
    for (axis, bins) in bins.iter().enumerate() {
        let mut after = [0.0; N_BINS];
        let mut all = Bin { bounds: Box32::EMPTY, n: 0 };
        for i in (1..N_BINS).rev() {
            all = Bin { bounds: all.bounds.union(&bins[i].bounds), n: all.n + bins[i].n };
            after[i] = all.bounds.half_area() * all.n as f64;
        }
        let mut all = Bin { bounds: Box32::EMPTY, n: 0 };
        for i in 1..N_BINS {
            all = Bin { bounds: all.bounds.union(&bins[i - 1].bounds), n: all.n + bins[i - 1].n };
            if all.n == 0 || all.n == items.len() {
                continue;
            }
            let cost = all.bounds.half_area() * all.n as f64 + after[i];
            if best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, all.n));
            }
        }
    }
    best.map(|(_, axis, n)| (axis, n))
}

/// Makes every node know its parent, and returns those of the leaf groups.
pub(super) fn link(nodes: &mut [Node], n_groups: usize) -> Vec<u32> {
    let mut parents = alloc::vec![NO_PARENT; n_groups];
    for index in 0..nodes.len() {
        for lane in 0..8 {
            let child = nodes[index].children[lane];
            let parent = (8 * index + lane) as u32;
            if let Some(node) = child.node() {
                nodes[node].parent = parent;
            } else if let Some(group) = child.group() {
                parents[group] = parent;
            }
        }
    }
    parents
}
