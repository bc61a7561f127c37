//! The lights of `lambert`: a distant sun over an even ambient, and, if wanted, one light at a point.

use glam::{DVec3, Vec3};
use thiserror::Error;

use crate::select::max;

/// A distant light and the share of light that comes from everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    direction: Vec3,
    ambient: f32,
}

/// Why a [`Light`] cannot be.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum LightError {
    /// The direction is zero, NaN or infinite.
    #[error("the light direction {0} has no direction: give three finite numbers, not all zero")]
    Direction(Vec3),
    /// The ambient share is outside `[0, 1]` or NaN.
    #[error("the ambient light {0} is outside 0..1")]
    Ambient(f32),
    /// The position is NaN or infinite.
    #[error("a light at {0} has no place: give three finite numbers")]
    Position(DVec3),
    /// A colour is below 0, NaN or infinite.
    #[error("a light cannot have the colour {0}: give three finite numbers, none below 0")]
    Color(Vec3),
    /// The radius is below 0 or NaN.
    #[error("a light cannot reach {0} units far: give 0 or more, or inf")]
    Radius(f32),
}

/// A coloured light at a point, that ends at a radius.
///
/// A surface at distance `d` gets `color * cos * (1 - (d / r)^4)^2 / (d^2 + 1)`, exactly 0 from `r`
/// on, so that nothing beyond need be looked at. With an infinite radius, `color * cos / (d^2 + 1)`.
/// On the light itself (`d = 0`) no direction leads to it, and it adds nothing. Source: Karis 2013,
/// "Real Shading in Unreal Engine 4".
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLight {
    position: DVec3,
    color: Vec3,
    radius: f32,
    /// 0 of an infinite radius.
    inverse_radius2: f32,
}

impl PointLight {
    /// A light at a finite world-space position, of a linear colour from 0 on, with a radius in
    /// scene units: 0 is dark, infinity never ends.
    pub fn new(position: DVec3, color: Vec3, radius: f32) -> Result<PointLight, LightError> {
        if !position.is_finite() {
            return Err(LightError::Position(position));
        }
        if !(color.is_finite() && color.cmpge(Vec3::ZERO).all()) {
            return Err(LightError::Color(color));
        }
        let is_length = radius >= 0.0; // false for NaN
        if !is_length {
            return Err(LightError::Radius(radius));
        }
        Ok(PointLight { position, color, radius, inverse_radius2: 1.0 / (radius * radius) })
    }

    /// Where it is, world space.
    pub fn position(&self) -> DVec3 {
        self.position
    }

    /// Linear light at no distance.
    pub fn color(&self) -> Vec3 {
        self.color
    }

    /// Where it ends, scene units; may be infinite.
    pub fn radius(&self) -> f32 {
        self.radius
    }

    /// The square of the radius, infinite for one beyond 1.8e19, and its inverse.
    pub(crate) fn radius2(&self) -> [f32; 2] {
        [self.radius * self.radius, self.inverse_radius2]
    }

    /// The vector to it from a place in the world.
    pub(crate) fn seen_from(&self, position: DVec3) -> Vec3 {
        (self.position - position).as_vec3()
    }

    /// What it adds on a surface with a unit normal. [`crate::wide`] computes the same.
    pub(crate) fn on(&self, normal: Vec3, to_light: Vec3) -> Vec3 {
        let [radius2, inverse_radius2] = self.radius2();
        let distance2 = to_light.dot(to_light);
        let reached = distance2 > 0.0 && distance2 < radius2; // false for NaN
        if !reached {
            return Vec3::ZERO;
        }
        let cosine = max(normal.dot(to_light), 0.0) / distance2.sqrt();
        let share = distance2 * inverse_radius2;
        let window = max(1.0 - share * share, 0.0);
        self.color * (cosine * (window * window / (distance2 + 1.0)))
    }
}

impl Light {
    /// A light from `direction`, world space, pointing *towards* the light, of any finite
    /// length but zero. `ambient` in `[0, 1]` is the light of a surface turned away.
    pub fn new(direction: Vec3, ambient: f32) -> Result<Light, LightError> {
        let exact = direction.as_dvec3();
        let length = exact.dot(exact).sqrt(); // f64: f32 squares would over- and underflow
        if !(length > 0.0 && length.is_finite()) {
            return Err(LightError::Direction(direction));
        }
        if !(0.0..=1.0).contains(&ambient) {
            return Err(LightError::Ambient(ambient));
        }
        Ok(Light { direction: (exact / length).as_vec3(), ambient })
    }

    /// Unit vector towards the light, world space.
    pub fn direction(&self) -> Vec3 {
        self.direction
    }

    /// Light on a surface turned away, in `[0, 1]`.
    pub fn ambient(&self) -> f32 {
        self.ambient
    }
}

impl Default for Light {
    /// The sun of the command line: from (0.4, 1, 0.6), a quarter ambient.
    fn default() -> Self {
        Light::new(Vec3::new(0.4, 1.0, 0.6), 0.25).expect("a direction and a share")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_finite_length_is_normalised() {
        for scale in [1e-44_f32, 1e-20, 1.0, 1e20, 3e38] {
            let light = Light::new(Vec3::new(0.0, -scale, 0.0), 0.0).unwrap();
            assert_eq!(light.direction(), Vec3::NEG_Y);
        }
    }

    #[test]
    fn a_point_light_ends_exactly_at_its_radius() {
        for radius in [0.0, 1e-30, 0.1, 1.0, 3.7, 1e10, 3e38] {
            let light = PointLight::new(DVec3::ZERO, Vec3::ONE, radius).unwrap();
            let at = |d: f32| light.on(Vec3::Z, Vec3::Z * d);
            for d in [radius, radius.next_up(), 2.0 * radius, f32::INFINITY, f32::NAN] {
                assert_eq!(at(d), Vec3::ZERO, "{d} of {radius}");
            }
            if (0.1..1e9).contains(&radius) {
                assert!(at(0.9 * radius).x > 0.0);
                let middle = (15.0_f32 / 16.0).powi(2) / (0.25 * radius * radius + 1.0);
                assert!((at(0.5 * radius).x - middle).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn light_without_end_and_on_the_light_is_finite() {
        let light = PointLight::new(DVec3::ZERO, Vec3::ONE, f32::INFINITY).unwrap();
        for d in [0.0, 1e-45, 1e-20, 1.0, 1e10, 1e19, 3e38] {
            let there = light.on(Vec3::Z, Vec3::Z * d);
            assert!(there.is_finite() && there.cmpge(Vec3::ZERO).all(), "{d}: {there}");
        }
        assert_eq!(light.on(Vec3::Z, Vec3::Z).x, 0.5);
        assert_eq!(light.on(Vec3::NEG_Z, Vec3::Z), Vec3::ZERO);
    }

    #[test]
    fn what_is_no_light_is_refused() {
        let new = PointLight::new;
        assert!(matches!(new(DVec3::NAN, Vec3::ONE, 1.0), Err(LightError::Position(_))));
        for color in [Vec3::NAN, Vec3::INFINITY, Vec3::new(1.0, -0.1, 0.0)] {
            assert!(matches!(new(DVec3::ZERO, color, 1.0), Err(LightError::Color(_))));
        }
        for radius in [-1.0, f32::NAN, f32::NEG_INFINITY] {
            assert!(matches!(new(DVec3::ZERO, Vec3::ONE, radius), Err(LightError::Radius(_))));
        }
    }

    #[test]
    fn no_direction_and_no_share_are_refused() {
        for direction in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY, Vec3::new(1.0, f32::NAN, 0.0)] {
            assert!(matches!(Light::new(direction, 0.5), Err(LightError::Direction(_))));
        }
        for ambient in [-0.01, 1.01, f32::NAN, f32::INFINITY] {
            assert!(matches!(Light::new(Vec3::X, ambient), Err(LightError::Ambient(_))));
        }
    }
}
