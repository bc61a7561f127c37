//! A half-line, for picking and for the ray caster that checks the rasterizer.

use glam::DVec3;

/// The points `origin + t * direction` for `t >= 0`.
///
/// The direction need not have unit length: every `t` counts in multiples of it. With a zero
/// direction the ray is a point to the box test and hits no triangle. A ray with a NaN or an
/// infinity hits nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: DVec3,
    /// Where it goes, any length.
    pub direction: DVec3,
}

impl Ray {
    /// The point at parameter `t`, rounded.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }

    /// Whether it has no NaN and no infinity.
    pub fn is_finite(&self) -> bool {
        self.origin.is_finite() && self.direction.is_finite()
    }
}
