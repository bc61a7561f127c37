//! A half-space whose plane is known up to an error.

use glam::DVec3;

use crate::rounding::times;
use crate::{Aabb, Plane};

/// `plane`, inward, give or take `error` in each coefficient: a family of half-spaces that the
/// true one is among.
///
/// The box is an interval, so are the coefficients, and interval arithmetic (Moore 1966) gives
/// ends that the truth cannot lie beyond. The roundings of this evaluation itself, at most
/// eight, are counted in the error by whoever makes one; see [`EVALUATION`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Halfspace {
    pub plane: Plane,
    pub error: Plane,
}

/// What a coefficient's error holds beyond that of the coefficient, relative to it: a box
/// moved to the frustum's origin (1 rounding), a widened coefficient (2), a product (1), a sum
/// of four (3), in units of 2^-53.
pub(crate) const EVALUATION: f64 = 4.0 * f64::EPSILON;

/// What four products can lose to underflow, and more.
const UNDERFLOW: f64 = 4.0 * f64::from_bits(1);

impl Halfspace {
    /// No point of `bounds` lies farther inside than this: below zero excludes the box.
    pub fn farthest(&self, bounds: &Aabb) -> f64 {
        let end = |x: DVec3| times(self.plane.normal + self.error.normal * x.signum(), x);
        let along = end(bounds.min).max(end(bounds.max));
        along.x + along.y + along.z + (self.plane.offset + (self.error.offset + UNDERFLOW))
    }

    /// Some point of `bounds` lies at least this far inside: zero or more, and this plane
    /// certainly does not exclude the box.
    pub fn reached(&self, bounds: &Aabb) -> f64 {
        let end = |x: DVec3| times(self.plane.normal - self.error.normal * x.signum(), x);
        let along = end(bounds.min).max(end(bounds.max));
        along.x + along.y + along.z + (self.plane.offset - (self.error.offset + UNDERFLOW))
    }

    /// No point of `bounds` lies farther outside than this, as a signed distance: zero or
    /// more, and the box lies wholly inside.
    pub fn nearest(&self, bounds: &Aabb) -> f64 {
        -Halfspace { plane: -self.plane, error: self.error }.farthest(bounds)
    }
}

/// The errors of a rounded half-space, none where a coefficient is exactly zero.
impl From<Plane> for Halfspace {
    fn from(plane: Plane) -> Self {
        let relative = 2.0 * EVALUATION;
        let error =
            Plane { normal: plane.normal.abs() * relative, offset: plane.offset.abs() * relative };
        Halfspace { plane, error }
    }
}
