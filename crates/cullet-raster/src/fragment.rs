//! Where a pixel lies on its triangle: all that a shading kernel is told about geometry.

use glam::Vec3;

/// One pixel's place on its source triangle.
///
/// Barycentrics are perspective-correct, in the order of the triangle's corners, each in
/// [0, 1], sum 1 up to rounding. `ddx` and `ddy` are their analytic derivatives along the
/// screen axes, per pixel, x right and y down; each sums to 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fragment {
    /// Weights of the three corners at the pixel centre.
    pub weights: Vec3,
    /// Change of the weights per pixel to the right.
    pub ddx: Vec3,
    /// Change of the weights per pixel down.
    pub ddy: Vec3,
}
