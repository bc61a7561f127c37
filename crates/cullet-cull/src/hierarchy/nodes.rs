//! The boxes of a tree, for those who count and draw.

use alloc::vec::Vec;

use crate::{Aabb, Hierarchy};

/// The box around a subtree or a leaf.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeBox {
    /// Which of `WalkStats::levels` counts it; 0 for a child of the root.
    pub level: usize,
    /// The box around it: its place in this row. `None` for a child of the root.
    pub parent: Option<usize>,
    /// In the space of the items, a little larger than the items need.
    pub bounds: Aabb,
    /// A leaf, with items below it and no further boxes of nodes.
    pub leaf: bool,
}

impl Hierarchy {
    /// Every box that a walk may test before it comes to the items, each after the box around it.
    pub fn node_boxes(&self) -> Vec<NodeBox> {
        let tree = &self.tree;
        let mut boxes = Vec::new();
        let mut nodes = Vec::new();
        if tree.has_root() {
            nodes.push((0, 0, None));
        }
        while let Some((index, level, parent)) = nodes.pop() {
            let node = &tree.nodes[index];
            for (lane, child) in node.children.iter().enumerate() {
                if child.is_absent() {
                    continue;
                }
                if let Some(below) = child.node() {
                    nodes.push((below, level + 1, Some(boxes.len())));
                }
                let bounds = tree.space.restore(&node.bounds.get(lane));
                boxes.push(NodeBox { level, parent, bounds, leaf: child.group().is_some() });
            }
        }
        boxes
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat4, DVec3, DVec4};

    use super::*;
    use crate::Frustum;
    use crate::wide::Level;

    #[test]
    fn a_walk_that_sees_everything_in_part_tests_them_all() {
        let cell = |i: i32| {
            let min = DVec3::new(f64::from(i % 10), f64::from(i / 10 % 10), f64::from(-i / 100));
            Aabb { min, max: min + 0.5 }
        };
        let cells: Vec<Aabb> = (0..1000).map(cell).collect();
        let tree = Hierarchy::build(&cells);
        let boxes = tree.node_boxes();
        assert_eq!(boxes.iter().filter(|node| node.leaf).count(), tree.quality().n_leaves);
        let n_inner = boxes.iter().filter(|node| !node.leaf).count();
        assert_eq!(n_inner + 1, tree.quality().n_nodes); // the root has no box
        for (i, node) in boxes.iter().enumerate() {
            match node.parent.map(|parent| (parent, boxes[parent])) {
                None => assert_eq!(node.level, 0),
                Some((parent, above)) => {
                    assert!(parent < i && !above.leaf && above.level + 1 == node.level);
                    assert_eq!(above.bounds.union(&node.bounds), above.bounds);
                }
            }
        }
        for bounds in &cells {
            let holds = |node: &&NodeBox| node.leaf && node.bounds.union(bounds) == node.bounds;
            assert!(boxes.iter().any(|node| holds(&node)));
        }
        // A view of nothing but the first plane of cells: each level is asked no more than it has.
        // x and y from -1 to 5, z from 0 down to -20.
        let matrix = DMat4::from_cols(
            DVec4::new(1.0 / 3.0, 0.0, 0.0, 0.0),
            DVec4::new(0.0, 1.0 / 3.0, 0.0, 0.0),
            DVec4::new(0.0, 0.0, -0.05, 0.0),
            DVec4::new(-2.0 / 3.0, -2.0 / 3.0, 0.0, 1.0),
        );
        let frustum = Frustum::from_matrix(&matrix, crate::DepthRange::ZeroToOne).unwrap();
        let mut levels = [crate::Counts::default(); crate::MAX_LEVELS];
        tree.walk_by_level(&frustum, Level::new(), &mut levels, |_, _| {});
        for (level, counts) in levels.iter().enumerate() {
            let n = boxes.iter().filter(|node| node.level == level).count() as u64;
            assert!(counts.tested <= n, "level {level}");
            assert!(level > 0 || counts.tested == n);
        }
        assert!(Hierarchy::build(&[]).node_boxes().is_empty());
    }
}
