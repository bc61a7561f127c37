//! Is the tree what it claims to be, and how good is it?

use alloc::vec::Vec;
use core::fmt;

use super::stats::MAX_LEVELS;
use super::tree::{NO_PARENT, Place, Tree};

/// A promise that a tree breaks: always a bug of this crate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fault {
    /// What is wrong.
    pub what: &'static str,
    /// Which node, slot or item.
    pub at: usize,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "hierarchy: {} (at {})", self.what, self.at)
    }
}

impl core::error::Error for Fault {}

/// Figures about a tree.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Quality {
    /// Items in leaves: neither empty nor kept beside the tree.
    pub n_items: usize,
    /// Nodes in use.
    pub n_nodes: usize,
    /// Leaf groups in use.
    pub n_leaves: usize,
    /// Levels of nodes; 1 if the root has only leaves.
    pub depth: usize,
    /// Children per place for one, in (0, 1].
    pub node_fill: f64,
    /// Items per place for one, in (0, 1].
    pub leaf_fill: f64,
    /// The surface area heuristic: eight-wide tests that a long random line through the root's box is
    /// expected to need.
    pub cost: f64,
    /// Where children of a node overlap, the areas of the overlaps, over the sum of the areas of
    /// all children: 0 is best.
    pub overlap: f64,
    /// Memory of nodes and leaves, bytes.
    pub n_bytes: usize,
}

impl Tree {
    pub fn validate(&self) -> Result<(), Fault> {
        let fault = |what, at| Err(Fault { what, at });
        let mut found = alloc::vec![false; self.places.len()];
        let (mut n_nodes, mut n_groups) = (0, 0);
        let mut below: Vec<(usize, usize)> = Vec::new();
        if !self.nodes.is_empty() {
            below.push((0, 0));
            if self.nodes[0].parent != NO_PARENT {
                return fault("the root has a parent", 0);
            }
        }
        while let Some((index, level)) = below.pop() {
            n_nodes += 1;
            let node = &self.nodes[index];
            if level >= MAX_LEVELS {
                return fault("too deep", index);
            }
            if node.present == 0 && index != 0 {
                return fault("a node without children", index);
            }
            for (lane, child) in node.children.iter().enumerate() {
                let here = (8 * index + lane) as u32;
                if child.is_absent() != (node.present >> lane & 1 == 0) {
                    return fault("present children are not marked as such", index);
                }
                if child.group().is_some() != (node.leaves >> lane & 1 != 0) {
                    return fault("leaves are not marked as such", index);
                }
                if child.is_absent() {
                    if !node.bounds.get(lane).min[0].is_nan() {
                        return fault("an absent child has a box", index);
                    }
                    continue;
                }
                if node.bounds.get(lane) != self.bounds_below(*child) {
                    return fault("a child's box does not fit", index);
                }
                if child
                    .slots()
                    .any(|slot| self.ids.get(slot).is_none_or(|id| *id == Tree::NO_ITEM))
                {
                    return fault("a run with a hole", index);
                }
                if let Some(below_here) = child.node() {
                    if self.nodes[below_here].parent != here {
                        return fault("a node that does not know its parent", below_here);
                    }
                    if child.len > 0 && self.slots_below(below_here) != Some(child.slots()) {
                        return fault("a run that is not what lies below", below_here);
                    }
                    below.push((below_here, level + 1));
                } else if let Some(group) = child.group() {
                    n_groups += 1;
                    if self.parents[group] != here || child.len == 0 || child.first % 8 != 0 {
                        return fault("a leaf in disorder", group);
                    }
                    if self.packed[group] != self.pack(group) {
                        return fault("a leaf that is packed otherwise", group);
                    }
                    for lane in 0..8 {
                        let slot = 8 * group + lane;
                        let id = self.ids[slot];
                        let bounds = self.groups[group].get(lane);
                        if lane >= child.len as usize {
                            if id != Tree::NO_ITEM || !bounds.min[0].is_nan() {
                                return fault("an empty slot is not empty", slot);
                            }
                            continue;
                        }
                        let place = self.places.get(id as usize);
                        if place != Some(&Place::Slot(slot as u32)) {
                            return fault("an item that is elsewhere", id as usize);
                        }
                        found[id as usize] = true;
                        if self.bounds.union(&bounds) != self.bounds {
                            return fault("a box beyond the box around all", slot);
                        }
                    }
                }
            }
        }
        if n_nodes + self.free_nodes.len() != self.nodes.len() {
            return fault("nodes are lost", n_nodes);
        }
        if n_groups + self.free_groups.len() != self.groups.len() {
            return fault("leaves are lost", n_groups);
        }
        let mut n_items = 0;
        for (id, place) in self.places.iter().enumerate() {
            n_items += usize::from(*place != Place::Nowhere);
            let is_lost = match place {
                Place::Nowhere | Place::Empty => found[id],
                Place::Slot(_) => !found[id],
                Place::Beside(index) => {
                    let entry = self.beside.get(*index as usize);
                    entry.is_none_or(|(other, _)| *other as usize != id)
                }
            };
            if is_lost {
                return fault("an item is lost", id);
            }
        }
        if n_items != self.n_items {
            return fault("the number of items is wrong", n_items);
        }
        Ok(())
    }

    /// The slots of all leaves below a node, if they are side by side.
    fn slots_below(&self, top: usize) -> Option<core::ops::Range<usize>> {
        let nodes = self.nodes_below(top);
        let children = nodes.into_iter().flat_map(|index| self.nodes[index].children);
        let mut leaves: Vec<_> = children.filter(|c| c.group().is_some()).collect();
        leaves.sort_unstable_by_key(|leaf| leaf.first);
        let mut all = leaves.first()?.slots();
        for leaf in &leaves[1..] {
            if leaf.first as usize != all.end {
                return None;
            }
            all.end += leaf.len as usize;
        }
        Some(all)
    }

    pub fn quality(&self) -> Quality {
        let mut quality = Quality::default();
        if !self.has_root() {
            return quality;
        }
        let root = self.nodes[0].bounds.union().half_area();
        let (mut areas, mut shared, mut n_children) = (0.0, 0.0, 0);
        let mut below = alloc::vec![(0, 1)];
        while let Some((index, level)) = below.pop() {
            let node = &self.nodes[index];
            quality.n_nodes += 1;
            quality.depth = quality.depth.max(level);
            for (lane, child) in node.children.iter().enumerate() {
                if child.is_absent() {
                    continue;
                }
                n_children += 1;
                let bounds = node.bounds.get(lane);
                areas += bounds.half_area();
                for other in lane + 1..8 {
                    let common = bounds.intersection(&node.bounds.get(other));
                    shared += common.map_or(0.0, |common| common.half_area());
                }
                if let Some(node) = child.node() {
                    below.push((node, level + 1));
                } else {
                    quality.n_leaves += 1;
                    quality.n_items += child.len as usize;
                }
            }
        }
        quality.node_fill = f64::from(n_children) / (8 * quality.n_nodes) as f64;
        quality.leaf_fill = quality.n_items as f64 / (8 * quality.n_leaves) as f64;
        quality.cost = if root > 0.0 { 1.0 + areas / root } else { 1.0 };
        quality.overlap = if areas > 0.0 { shared / areas } else { 0.0 };
        quality.n_bytes = size_of_val(&*self.nodes)
            + size_of_val(&*self.groups)
            + size_of_val(&*self.packed)
            + 4 * (self.ids.len() + self.parents.len())
            + size_of_val(&*self.places);
        quality
    }
}
