//! An oriented plane: inside is where the distance is not negative.

use core::ops::Neg;

use glam::DVec3;

use crate::rounding::times;

/// The points `p` with `normal · p + offset = 0`, in whatever space its owner says.
///
/// A zero `normal` with `offset = +inf` is the plane at infinity: everything is inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit length, pointing inward.
    pub normal: DVec3,
    /// Distance of the space's origin to the plane, scene units, positive inside.
    pub offset: f64,
}

impl Plane {
    /// Signed distance of `point`, scene units, positive inside (INFOGR lecture 6, the
    /// plane equation).
    ///
    /// Rounded, with `0 * inf` as 0; NaN if the point has one or if infinities oppose.
    pub fn distance(&self, point: DVec3) -> f64 {
        let along = times(self.normal, point);
        along.x + along.y + along.z + self.offset
    }
}

/// The same plane with inside and outside exchanged.
impl Neg for Plane {
    type Output = Plane;

    fn neg(self) -> Plane {
        Plane { normal: -self.normal, offset: -self.offset }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_is_positive_inside() {
        let plane = Plane { normal: DVec3::new(0.6, 0.0, 0.8), offset: -5.0 };
        assert_eq!(plane.distance(DVec3::new(3.0, 100.0, 4.0)), 0.0);
        assert_eq!(plane.distance(DVec3::ZERO), -5.0);
        assert_eq!((-plane).distance(DVec3::ZERO), 5.0);
    }

    #[test]
    fn infinity_along_the_plane_does_not_count() {
        let plane = Plane { normal: DVec3::Z, offset: 1.0 };
        assert_eq!(plane.distance(DVec3::new(f64::INFINITY, f64::NEG_INFINITY, 2.0)), 3.0);
        assert_eq!(plane.distance(DVec3::INFINITY), f64::INFINITY);
        assert!(plane.distance(DVec3::NAN).is_nan());
    }

    #[test]
    fn everything_is_inside_the_plane_at_infinity() {
        let plane = Plane { normal: DVec3::ZERO, offset: f64::INFINITY };
        assert_eq!(plane.distance(DVec3::NEG_INFINITY), f64::INFINITY);
    }
}
