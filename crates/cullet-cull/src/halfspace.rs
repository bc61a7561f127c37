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

/// Sums are made of an eighth of each coefficient, so that four terms cannot overflow on the way
/// to a sum that does not.
const EIGHTH: f64 = 0.125;

/// What four products of an eighth can lose to underflow, times eight, and more.
const UNDERFLOW: f64 = 64.0 * f64::from_bits(1);

impl Halfspace {
    /// [`excludes`].
    pub fn excludes(&self, bounds: &Aabb) -> bool {
        excludes(&self.plane, &self.error, bounds)
    }

    /// No point of `bounds` lies farther inside than this: below zero excludes the box.
    #[inline(never)]
    pub fn farthest(&self, bounds: &Aabb) -> f64 {
        let end =
            |x: DVec3| times(EIGHTH * (self.plane.normal + self.error.normal * x.signum()), x);
        let along = end(bounds.min).max(end(bounds.max));
        let offset = self.plane.offset + (self.error.offset + UNDERFLOW);
        (along.x + along.y + along.z + EIGHTH * offset) / EIGHTH
    }

    /// Some point of `bounds` lies at least this far inside: zero or more, and this plane
    /// certainly does not exclude the box.
    pub fn reached(&self, bounds: &Aabb) -> f64 {
        let end =
            |x: DVec3| times(EIGHTH * (self.plane.normal - self.error.normal * x.signum()), x);
        let along = end(bounds.min).max(end(bounds.max));
        let offset = self.plane.offset - (self.error.offset + UNDERFLOW);
        (along.x + along.y + along.z + EIGHTH * offset) / EIGHTH
    }

    /// No point of `bounds` lies farther outside than this, as a signed distance: zero or
    /// more, and the box lies wholly inside.
    #[inline(never)]
    pub fn nearest(&self, bounds: &Aabb) -> f64 {
        -Halfspace { plane: -self.plane, error: self.error }.farthest(bounds)
    }
}

/// Whether no point of `bounds` lies inside, proven by a plain sum where that is clear, and by
/// [`Halfspace::farthest`] below zero where it is not: a quarter of the time.
///
/// By reference, plane and error apart: a copy of both would be read back before it is written.
#[inline(always)]
pub(crate) fn excludes(plane: &Plane, error: &Plane, bounds: &Aabb) -> bool {
    let farthest = DVec3::select(plane.normal.cmpge(DVec3::ZERO), bounds.max, bounds.min);
    let (distance, doubt) = (distance(plane, farthest), doubt(error, reach(bounds)));
    if clear(distance, doubt) {
        return distance < 0.0;
    }
    Halfspace { plane: *plane, error: *error }.farthest(bounds) < 0.0
}

/// Whether all of `bounds` lies inside, likewise by [`Halfspace::nearest`]. False for NaN.
#[inline(always)]
pub(crate) fn holds(plane: &Plane, error: &Plane, bounds: &Aabb) -> bool {
    let nearest = DVec3::select(plane.normal.cmpge(DVec3::ZERO), bounds.min, bounds.max);
    let (distance, doubt) = (distance(plane, nearest), doubt(error, reach(bounds)));
    if clear(distance, doubt) {
        return distance > 0.0;
    }
    Halfspace { plane: *plane, error: *error }.nearest(bounds) >= 0.0
}

/// Whether a single point lies outside, in the same way.
#[inline(always)]
pub(crate) fn excludes_point(plane: &Plane, error: &Plane, point: DVec3) -> bool {
    let (distance, doubt) = (distance(plane, point), doubt(error, point.abs()));
    if clear(distance, doubt) {
        return distance < 0.0;
    }
    let point = Aabb { min: point, max: point };
    Halfspace { plane: *plane, error: *error }.farthest(&point) < 0.0
}

/// How far inside `point` is at most: [`Halfspace::farthest`], or a little more.
#[inline(always)]
pub(crate) fn at_most(plane: &Plane, error: &Plane, point: DVec3) -> f64 {
    let distance = distance(plane, point) + doubt(error, point.abs());
    if distance.abs() < f64::INFINITY {
        return distance;
    }
    let point = Aabb { min: point, max: point };
    Halfspace { plane: *plane, error: *error }.farthest(&point)
}

/// The largest size of each coordinate.
#[inline(always)]
fn reach(bounds: &Aabb) -> DVec3 {
    bounds.min.abs().max(bounds.max.abs())
}

/// Of `point`, as if the coefficients were right.
#[inline(always)]
fn distance(plane: &Plane, point: DVec3) -> f64 {
    plane.normal.dot(point) + plane.offset
}

/// How far [`distance`] may be off for points with coordinates up to `reach`. It has fewer
/// roundings than are counted in the error, which pays for those of this sum.
#[inline(always)]
fn doubt(error: &Plane, reach: DVec3) -> f64 {
    error.normal.dot(reach) + (error.offset + UNDERFLOW)
}

/// Whether the sign of a distance is beyond doubt: not for NaN, nor where a sum overflowed.
#[inline(always)]
fn clear(distance: f64, doubt: f64) -> bool {
    let size = distance.abs();
    size > doubt && size < f64::INFINITY
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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Ordinary numbers, and the odd zero, infinity, tiny and huge one.
    fn coordinate() -> impl Strategy<Value = f64> {
        const ODD: [f64; 10] = [
            0.0,
            -0.0,
            1.0,
            -1.0,
            f64::INFINITY,
            f64::NEG_INFINITY,
            5e-324,
            1e300,
            f64::MAX,
            f64::MIN,
        ];
        prop_oneof![4 => -4.0..4.0, 1 => proptest::sample::select(&ODD[..])]
    }

    fn vector() -> impl Strategy<Value = DVec3> {
        [coordinate(), coordinate(), coordinate()].prop_map(DVec3::from_array)
    }

    #[test]
    fn nothing_overflows_on_the_way() {
        // Half of the largest number inside, by way of minus one and a half.
        let plane = Plane { normal: DVec3::new(-1.0, -1.0, 1.0), offset: f64::MAX };
        let corner = DVec3::new(0.75, 0.75, 1.0) * f64::MAX;
        let bounds = Aabb { min: corner, max: corner };
        let halfspace = Halfspace::from(plane);
        assert!(halfspace.farthest(&bounds) > 0.0 && !halfspace.excludes(&bounds));
        assert!(holds(&halfspace.plane, &halfspace.error, &bounds));
    }

    proptest! {
        #[test]
        fn the_quick_way_says_what_the_careful_one_says(
            normal in [-1.0..1.0, -1.0..1.0, -1.0..1.0], a in vector(), b in vector(),
            touching: bool, zeros in 0_u8..8,
        ) {
            let normal = DVec3::from_array(core::array::from_fn(|i| {
                if zeros >> i & 1 == 0 { normal[i] } else { 0.0 }
            }));
            let bounds = Aabb { min: a.min(b), max: a.max(b) };
            // Through a corner, where every rounding counts, or anywhere.
            let through = if touching && a.is_finite() { a } else { DVec3::splat(0.5) };
            let plane = Plane { normal, offset: -normal.dot(through) };
            let halfspace = Halfspace::from(plane);
            prop_assert_eq!(halfspace.excludes(&bounds), halfspace.farthest(&bounds) < 0.0);
            prop_assert_eq!(holds(&halfspace.plane, &halfspace.error, &bounds), halfspace.nearest(&bounds) >= 0.0);
        }
    }
}
