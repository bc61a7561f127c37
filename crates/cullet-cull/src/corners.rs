//! Box against frustum, all eight corners against each plane: the textbook's test.
//!
//! A plane excludes the box when all corners lie behind it. One of them, the one farthest along
//! the plane's normal, would have told (`p_vertex`), for an eighth of the work: this
//! test is here to show that. Exclusion is proof, rounding included; survival is not.
//!
//! Source: Assarsson and Möller, "Optimized View Frustum Culling Algorithms for Bounding
//! Boxes", Journal of Graphics Tools 5(1), 2000, who start from it; INFOGR lecture 6.

use crate::halfspace::excludes_point;
use crate::{Aabb, Frustum};

/// Whether no plane has all corners of `bounds` behind it. NaN: true; empty: false.
pub fn corners_visible(bounds: &Aabb, frustum: &Frustum) -> bool {
    if let Some(verdict) = bounds.undisputed() {
        return verdict;
    }
    let corners = bounds.relative_to(frustum.origin).corners();
    let behind = |plane: usize| {
        let (plane, error) = (&frustum.planes[plane], &frustum.errors[plane]);
        corners.iter().all(|&corner| excludes_point(plane, error, corner))
    };
    !(0..6).any(behind)
}
