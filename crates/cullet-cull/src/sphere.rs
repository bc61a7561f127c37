//! A ball around a point, and the cheapest test of all: ball against planes.
//!
//! One distance per plane, compared with the radius; but the ball around a box is up to
//! 2.7 times as large as the box, and for a long one without limit.
//!
//! Source: Gribb and Hartmann 2001; INFOGR lecture 6, frustum culling of spheres.

use glam::DVec3;

use crate::halfspace::{EVALUATION, at_most};
use crate::{Aabb, Frustum};

/// All points within `radius` of `center`, the surface included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre, in the space of its owner.
    pub center: DVec3,
    /// Scene units. 0 is a point, infinite is everywhere, negative is empty.
    pub radius: f64,
}

impl Sphere {
    /// Everything.
    pub const INFINITE: Sphere = Sphere { center: DVec3::ZERO, radius: f64::INFINITY };

    /// A ball around `bounds`, rounded outwards. Empty stays empty, NaN stays NaN; around a box
    /// without end, everything.
    pub fn around(bounds: &Aabb) -> Sphere {
        match bounds.undisputed() {
            Some(true) => return Sphere { center: DVec3::NAN, radius: f64::NAN },
            Some(false) => return Sphere { center: DVec3::ZERO, radius: -1.0 },
            None => {}
        }
        let center = bounds.center();
        let reach = (bounds.max - center).max(center - bounds.min);
        let squared = reach.length_squared();
        let in_range = (1e-200..1e200).contains(&squared);
        let radius = if in_range {
            libm::sqrt(squared)
        } else {
            libm::hypot(libm::hypot(reach.x, reach.y), reach.z)
        };
        if !radius.is_finite() {
            return Sphere::INFINITE;
        }
        Sphere { center, radius: (radius * (1.0 + EVALUATION)).next_up() }
    }

    /// Whether a coordinate of the centre or the radius is NaN.
    pub fn is_nan(&self) -> bool {
        self.center.is_nan() || self.radius.is_nan()
    }

    /// Whether it holds no point: a negative radius, and no NaN.
    pub fn is_empty(&self) -> bool {
        !self.is_nan() && self.radius < 0.0
    }
}

/// Whether no plane has all of `sphere` behind it. NaN: true; empty: false; touching: true.
pub fn sphere_visible(sphere: &Sphere, frustum: &Frustum) -> bool {
    if sphere.is_nan() || sphere.is_empty() {
        return sphere.is_nan();
    }
    let center = sphere.center - frustum.origin;
    frustum.planes.iter().zip(&frustum.errors).all(|(plane, error)| {
        let doubt = EVALUATION + error.normal.element_sum();
        let behind = at_most(plane, error, center) + sphere.radius * (1.0 + doubt) < 0.0;
        !behind
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_negative_radius_is_empty() {
        let sphere = |radius| Sphere { center: DVec3::ONE, radius };
        assert!(sphere(-1.0).is_empty() && !sphere(0.0).is_empty() && !sphere(-0.0).is_empty());
        assert!(sphere(f64::NAN).is_nan() && !sphere(f64::NAN).is_empty());
    }
}
