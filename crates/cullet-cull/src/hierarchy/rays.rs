//! What a ray meets.
//!
//! Boxes are tested by [`ray_aabb`], which never misses one it touches, as they are stored; see
//! `shapes`. For the nearest hit children are entered in the order the ray reaches them and left
//! out once something nearer was hit.

use super::stats::MAX_LEVELS;
use super::tree::Tree;
use crate::{Ray, ray_aabb};

/// Calls `visit` with every item whose box the ray meets, and where it enters and leaves.
pub(super) fn hits(tree: &Tree, ray: &Ray, visit: &mut dyn FnMut(u32, (f64, f64))) {
    for (id, bounds) in &tree.beside {
        if let Some(interval) = ray_aabb(ray, bounds) {
            visit(*id, interval);
        }
    }
    let mut stack = [0_u32; 7 * MAX_LEVELS + 8];
    let mut n_pending = usize::from(tree.has_root());
    while n_pending > 0 {
        n_pending -= 1;
        let node = &tree.nodes[stack[n_pending] as usize];
        for (lane, child) in node.children.iter().enumerate() {
            if child.is_absent() {
                continue;
            }
            if ray_aabb(ray, &tree.space.restore(&node.bounds.get(lane))).is_none() {
                continue;
            }
            if let Some(node) = child.node() {
                stack[n_pending] = node as u32;
                n_pending += 1;
            } else if let Some(group) = child.group() {
                for slot in child.slots() {
                    let bounds = tree.space.restore(&tree.groups[group].get(slot % 8));
                    if let Some(interval) = ray_aabb(ray, &bounds) {
                        visit(tree.ids[slot], interval);
                    }
                }
            }
        }
    }
}

/// The item that `hit` puts nearest, and where; of equals the one with the lowest number. NaN is no
/// hit.
pub(super) fn nearest(
    tree: &Tree,
    ray: &Ray,
    hit: &mut dyn FnMut(u32) -> Option<f64>,
) -> Option<(u32, f64)> {
    let mut best: Option<(u32, f64)> = None;
    let mut try_item = |id: u32, best: &mut Option<(u32, f64)>| {
        if let Some(t) = hit(id).filter(|t| !t.is_nan()) {
            let is_nearer =
                best.is_none_or(|(other, nearest)| t < nearest || t == nearest && id < other);
            if is_nearer {
                *best = Some((id, t));
            }
        }
    };
    let is_beyond = |enter: f64, best: Option<(u32, f64)>| best.is_some_and(|(_, t)| enter > t);
    for (id, bounds) in &tree.beside {
        if ray_aabb(ray, bounds).is_some_and(|(enter, _)| !is_beyond(enter, best)) {
            try_item(*id, &mut best);
        }
    }
    // Links, eight times the node plus the lane, and where the ray enters, farthest first.
    let mut stack = [(0_u32, 0.0_f64); 7 * MAX_LEVELS + 8];
    let mut n_pending = 0;
    let mut entered = tree.has_root().then_some(0);
    loop {
        if let Some(index) = entered.take() {
            let node: &super::tree::Node = &tree.nodes[index];
            let base = n_pending;
            for lane in (0..8).filter(|lane| !node.children[*lane].is_absent()) {
                let bounds = tree.space.restore(&node.bounds.get(lane));
                let Some((enter, _)) = ray_aabb(ray, &bounds) else { continue };
                let mut at = n_pending;
                while at > base && stack[at - 1].1 < enter {
                    stack[at] = stack[at - 1];
                    at -= 1;
                }
                stack[at] = ((8 * index + lane) as u32, enter);
                n_pending += 1;
            }
        }
        if n_pending == 0 {
            return best;
        }
        n_pending -= 1;
        let (link, enter) = stack[n_pending];
        if is_beyond(enter, best) {
            continue;
        }
        let child = tree.nodes[link as usize / 8].children[link as usize % 8];
        entered = child.node();
        if let Some(group) = child.group() {
            for slot in child.slots() {
                let bounds = tree.space.restore(&tree.groups[group].get(slot % 8));
                if ray_aabb(ray, &bounds).is_some_and(|(enter, _)| !is_beyond(enter, best)) {
                    try_item(tree.ids[slot], &mut best);
                }
            }
        }
    }
}
