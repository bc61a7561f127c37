//! A tree of boxes, eight children to a node: what a frustum sees of a million of them
//! without asking each.
//!
//! Leaves are groups of eight boxes, nodes are groups of eight children, and both are tested in
//! one go by the arithmetic of [`wide`](crate::wide). Since that arithmetic is monotone, a walk
//! returns exactly the items, with exactly the masks, that testing every box would return:
//! [`Boxes8`](crate::wide::Boxes8) is its flat twin.
//!
//! The tree is one list of nodes and one of leaf groups, parents before children, so a walk is a
//! loop over a small stack and allocates nothing. Items in a subtree lie side by side: what is
//! wholly inside the frustum costs one call, however much it is.
//!
//! Boxes with a NaN or an infinity are kept beside the tree and tested one by one; empty boxes
//! are remembered and never visible.

mod build;
mod stats;
mod tree;
mod walk;

use alloc::vec::Vec;

use build::{Item, Split, build_nodes, in_turn, leaves, link};
use tree::{Place, Tree};
use walk::{AnyOrder, NearToFar, Occluded};

pub use build::Join;
pub use stats::{Counts, MAX_LEVELS, WalkStats};

use crate::wide::{Level, Space, Stored};
use crate::{Aabb, Frustum, PlaneMask};

/// Boxes in a tree, known by number.
#[derive(Clone, Debug)]
pub struct Hierarchy {
    tree: Tree,
}

impl Hierarchy {
    /// A tree over `boxes`; item `i` is `boxes[i]`.
    ///
    /// # Panics
    /// With more than 2^32 - 16 boxes.
    pub fn build(boxes: &[Aabb]) -> Hierarchy {
        Hierarchy::build_with(boxes, &in_turn)
    }

    /// The same tree, built by as many threads as `join` cares to use.
    pub fn build_with(boxes: &[Aabb], join: &Join<'_>) -> Hierarchy {
        assert!(boxes.len() <= u32::MAX as usize - 15, "items are numbered in 32 bits");
        let space = Space::around(boxes);
        let mut items = Vec::with_capacity(boxes.len());
        let mut beside = Vec::new();
        let mut places = alloc::vec![Place::EMPTY; boxes.len()];
        for (id, bounds) in boxes.iter().enumerate() {
            match space.store(bounds) {
                Stored::Bounded(bounds) => items.push(Item { bounds, id: id as u32 }),
                Stored::Beside => {
                    beside.push((id as u32, *bounds));
                    places[id] = Place::BESIDE;
                }
                Stored::Empty => {}
            }
        }
        let mut nodes = build_nodes(&mut items, 0, Split::Cheapest, join);
        let (groups, ids) = leaves(&items);
        for (slot, item) in items.iter().enumerate() {
            places[item.id as usize] = Place::slot(slot);
        }
        let parents = link(&mut nodes, groups.len());
        let reach = crate::wide::reach(&groups);
        let n_items = boxes.len();
        let (free_nodes, free_groups) = (Vec::new(), Vec::new());
        Hierarchy {
            tree: Tree {
                space,
                reach,
                nodes,
                groups,
                ids,
                parents,
                places,
                beside,
                free_nodes,
                free_groups,
                n_items,
            },
        }
    }

    /// How many items, empty boxes included.
    pub fn len(&self) -> usize {
        self.tree.n_items
    }

    /// Whether there is no item at all.
    pub fn is_empty(&self) -> bool {
        self.tree.n_items == 0
    }

    /// Calls `visit` with every item whose box `frustum` may see, once, in runs that share a
    /// mask: the planes that may cut them. Runs come in no particular order. Allocates nothing.
    ///
    /// The answer is that of [`Boxes8::cutting_into`](crate::wide::Boxes8::cutting_into): all that
    /// [`planes_cutting`](crate::planes_cutting) keeps, and what lies within the rounding of f32
    /// beside it.
    pub fn walk(
        &self,
        frustum: &Frustum,
        level: Level,
        mut visit: impl FnMut(&[u32], PlaneMask),
    ) -> WalkStats {
        walk::walk(&self.tree, frustum, level, AnyOrder, &mut visit)
    }

    /// Like [`Hierarchy::walk`], with nearer nodes and leaves before farther ones, by the middles of
    /// their boxes along the view direction. Within a run there is no order.
    pub fn walk_near_to_far(
        &self,
        frustum: &Frustum,
        level: Level,
        mut visit: impl FnMut(&[u32], PlaneMask),
    ) -> WalkStats {
        walk::walk(&self.tree, frustum, level, NearToFar, &mut visit)
    }

    /// Like [`Hierarchy::walk_near_to_far`], and before it looks into a node or a leaf that the
    /// frustum may see, asks whether `occluded` hides the whole box: if so, nothing in it is
    /// returned.
    ///
    /// `occluded` may use what `visit` drew so far. It gets boxes in the space of the items and
    /// must say `false` when in doubt; a leaf holds at most eight items.
    pub fn walk_unoccluded(
        &self,
        frustum: &Frustum,
        level: Level,
        mut occluded: impl FnMut(&Aabb) -> bool,
        mut visit: impl FnMut(&[u32], PlaneMask),
    ) -> WalkStats {
        walk::walk(&self.tree, frustum, level, Occluded(&mut occluded), &mut visit)
    }

    /// All visible items with their masks, in no particular order.
    pub fn visible(&self, frustum: &Frustum, level: Level) -> Vec<(u32, PlaneMask)> {
        let mut visible = Vec::new();
        self.walk(frustum, level, |ids, cutting| {
            visible.extend(ids.iter().map(|id| (*id, cutting)));
        });
        visible
    }
}
