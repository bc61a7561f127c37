//! The one light of `lambert`: a distant sun over an even ambient.

use glam::Vec3;
use thiserror::Error;

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
    fn no_direction_and_no_share_are_refused() {
        for direction in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY, Vec3::new(1.0, f32::NAN, 0.0)] {
            assert!(matches!(Light::new(direction, 0.5), Err(LightError::Direction(_))));
        }
        for ambient in [-0.01, 1.01, f32::NAN, f32::INFINITY] {
            assert!(matches!(Light::new(Vec3::X, ambient), Err(LightError::Ambient(_))));
        }
    }
}
