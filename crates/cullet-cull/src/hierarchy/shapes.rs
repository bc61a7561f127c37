//! Spheres, cones, boxes and whatever else can be asked about a box.
//!
//! These queries are asked in f64, one box at a time, of the boxes as stored: a little larger
//! than they were given, by 2^-20 of their distance from the middle of the world. What
//! comes back may thus touch the shape by less than that; nothing that touches it is missing.

use glam::DVec3;

use super::stats::MAX_LEVELS;
use super::tree::Tree;
use crate::{Aabb, Sphere};

/// How a box lies to a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overlap {
    /// They have no point in common.
    Outside,
    /// They may have.
    Partly,
    /// The shape contains the box.
    Inside,
}

/// All points within `range` of `apex` whose direction from there is within `half_angle` of
/// `direction`: what a spot light reaches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Where it begins.
    pub apex: DVec3,
    /// Where it opens to; unit length.
    pub direction: DVec3,
    /// Radians, in [0, π]; above π/2 it is what another cone leaves out.
    pub half_angle: f64,
    /// Scene units; may be infinite.
    pub range: f64,
}

/// Room for the rounding of a dozen operations.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// How `bounds` lies to the ball. In doubt [`Overlap::Partly`], as for anything with a NaN.
pub fn overlap_sphere(sphere: &Sphere, bounds: &Aabb) -> Overlap {
    if bounds.is_nan() || sphere.is_nan() {
        return Overlap::Partly;
    }
    if bounds.is_empty() || sphere.is_empty() {
        return Overlap::Outside;
    }
    let (below, above) = (bounds.min - sphere.center, sphere.center - bounds.max);
    let nearest = length(below.max(above).max(DVec3::ZERO));
    let farthest = length(below.abs().max(above.abs()));
    if nearest * (1.0 - ROUNDING) > sphere.radius {
        Overlap::Outside
    } else if farthest * (1.0 + ROUNDING) <= sphere.radius {
        Overlap::Inside
    } else {
        Overlap::Partly
    }
}

/// How `bounds` lies to the cone, by the ball around the box: near the border it may say
/// [`Overlap::Partly`] of a box that is outside. In doubt the same, as for anything with a NaN.
pub fn overlap_cone(cone: &Cone, bounds: &Aabb) -> Overlap {
    let reach = overlap_sphere(&Sphere { center: cone.apex, radius: cone.range }, bounds);
    if reach == Overlap::Outside {
        return Overlap::Outside;
    }
    let (sin, cos) = (libm::sin(cone.half_angle), libm::cos(cone.half_angle));
    // Distance to the mantle, positive outside, and the sizes of its terms.
    let off = |point: DVec3| {
        let from_apex = point - cone.apex;
        let along = from_apex.dot(cone.direction);
        let across = length(from_apex - along * cone.direction);
        // The subtraction rounds relative to the difference, not to the coordinates.
        (across * cos - along * sin, ROUNDING * length(from_apex))
    };
    // Measured from the centre as it was rounded: far from zero that is not the middle.
    let ball = Sphere::around(bounds);
    let (distance, doubt) = off(ball.center);
    if distance - doubt > ball.radius * (1.0 + ROUNDING) {
        return Overlap::Outside;
    }
    let is_convex = cone.half_angle <= core::f64::consts::FRAC_PI_2;
    let holds = |corner: DVec3| {
        let (distance, doubt) = off(corner);
        distance <= -doubt
    };
    if reach == Overlap::Inside && is_convex && bounds.corners().into_iter().all(holds) {
        Overlap::Inside
    } else {
        Overlap::Partly
    }
}

/// How `bounds` lies to the box, exactly; NaN as in [`Aabb::overlaps`].
pub fn overlap_box(range: &Aabb, bounds: &Aabb) -> Overlap {
    if !range.overlaps(bounds) {
        Overlap::Outside
    } else if range.contains(bounds) {
        Overlap::Inside
    } else {
        Overlap::Partly
    }
}

/// The length, without overflow or underflow.
fn length(v: DVec3) -> f64 {
    let largest = v.abs().max_element();
    if largest > 0.0 && largest.is_finite() { (v / largest).length() * largest } else { largest }
}

/// Calls `visit` with runs of items whose boxes `overlap` does not put outside.
pub(super) fn query(
    tree: &Tree,
    overlap: &mut dyn FnMut(&Aabb) -> Overlap,
    visit: &mut dyn FnMut(&[u32]),
) {
    for (id, bounds) in &tree.beside {
        if overlap(bounds) != Overlap::Outside {
            visit(&[*id]);
        }
    }
    // Nodes, and whether they are inside.
    let mut stack = [(0_u32, false); 7 * MAX_LEVELS + 8];
    let mut n_pending = usize::from(tree.has_root());
    while n_pending > 0 {
        n_pending -= 1;
        let (node, is_inside) = stack[n_pending];
        let node = &tree.nodes[node as usize];
        for (lane, child) in node.children.iter().enumerate() {
            if child.is_absent() {
                continue;
            }
            let bounds = node.bounds.get(lane);
            let verdict =
                if is_inside { Overlap::Inside } else { overlap(&tree.space.restore(&bounds)) };
            match (verdict, child.node(), child.group()) {
                (Overlap::Outside, ..) => {}
                (Overlap::Inside, ..) if child.len > 0 => visit(&tree.ids[child.slots()]),
                (_, Some(node), _) => {
                    stack[n_pending] = (node as u32, verdict == Overlap::Inside);
                    n_pending += 1;
                }
                (_, _, Some(group)) => {
                    for slot in child.slots() {
                        let bounds = tree.groups[group].get(slot % 8);
                        if overlap(&tree.space.restore(&bounds)) != Overlap::Outside {
                            visit(&tree.ids[slot..=slot]);
                        }
                    }
                }
                _ => {}
            }
        }
    }
}
