//! The coverage rule as one reads it, sample by sample, in 128-bit integers: the twin that
//! [`crate::cover`] is held to.

use crate::fixed::Fixed;
use crate::setup::ScreenTriangle;

/// Whether the centre of pixel `(x, y)` belongs to the triangle with these snapped corners, in
/// either order of corners. A triangle without area has no samples.
pub fn covers<const BITS: u32>(corners: [Fixed; 3], x: i64, y: i64) -> bool {
    let unit = 1i128 << BITS;
    let sample = (i128::from(x) * unit + unit / 2, i128::from(y) * unit + unit / 2);
    let [a, b, c] = corners.map(|p| (i128::from(p.x), i128::from(p.y)));
    match cross(a, b, c).signum() {
        0 => false,
        1 => inside(a, b, sample) && inside(b, c, sample) && inside(c, a, sample),
        _ => inside(a, c, sample) && inside(c, b, sample) && inside(b, a, sample),
    }
}

/// Twice the signed area of a triangle; positive is clockwise as seen, y down.
fn cross(a: (i128, i128), b: (i128, i128), c: (i128, i128)) -> i128 {
    (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0)
}

/// Whether `sample` is to the right of the edge (clockwise triangle), or on it and the edge is a
/// top or a left one.
fn inside(from: (i128, i128), to: (i128, i128), sample: (i128, i128)) -> bool {
    let side = cross(from, to, sample);
    let is_top = from.1 == to.1 && to.0 > from.0;
    let is_left = to.1 < from.1;
    side > 0 || (side == 0 && (is_top || is_left))
}

/// Reversed depth at the centre of pixel `(x, y)`, before clamping and rounding.
pub fn depth<const BITS: u32>(triangle: &ScreenTriangle, x: i64, y: i64) -> f64 {
    let unit = 1i128 << BITS;
    let sample = (i128::from(x) * unit + unit / 2, i128::from(y) * unit + unit / 2);
    let [a, b, c] = triangle.corners.map(|p| (i128::from(p.x), i128::from(p.y)));
    let shares = [cross(b, c, sample), cross(c, a, sample), cross(a, b, sample)];
    let sum: f64 = (0..3).map(|i| shares[i] as f64 * triangle.depth[i]).sum();
    sum / cross(a, b, c) as f64
}
