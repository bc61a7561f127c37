//! A ball around a point.

use glam::DVec3;

/// All points within `radius` of `center`, the surface included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre, in the space of its owner.
    pub center: DVec3,
    /// Scene units. 0 is a point, infinite is everywhere, negative is empty.
    pub radius: f64,
}

impl Sphere {
    /// Whether a coordinate of the centre or the radius is NaN.
    pub fn is_nan(&self) -> bool {
        self.center.is_nan() || self.radius.is_nan()
    }

    /// Whether it holds no point: a negative radius, and no NaN.
    pub fn is_empty(&self) -> bool {
        !self.is_nan() && self.radius < 0.0
    }
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
