//! Frustum against the planes of the box: the p-vertex test with the roles exchanged.
//!
//! A box is six planes too. One of them excludes the frustum when all of the frustum's corners
//! lie beyond it, that is, when the least box around the frustum does not reach this one.
//! That box is the same for all questions, so each costs six comparisons. It rejects
//! what planes are bad at, boxes larger than the frustum, and keeps what surrounds
//! the frustum's slanted sides.
//!
//! Source: Greene, "Detecting Intersection of a Rectangular Solid and a Convex Polyhedron",
//! Graphics Gems IV, 1994; Quílez, "Fixing frustum culling", 2013.

use crate::{Aabb, Frustum};

/// Whether no face of `bounds` has all of the frustum beyond it. NaN: true; empty: false.
pub fn reverse_visible(bounds: &Aabb, frustum: &Frustum) -> bool {
    bounds.relative_to(frustum.origin).overlaps(&frustum.bounds())
}
