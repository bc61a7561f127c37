//! Boxes for meshes that move: never too small, whatever the pose.
//!
//! ```
//! use cullet_cull::bounds::MorphBounds;
//! use glam::DVec3;
//!
//! let face = [DVec3::ZERO, DVec3::X, DVec3::Y];
//! let smile = [DVec3::ZERO, DVec3::X, DVec3::ZERO];
//! let bounds = MorphBounds::new(&face, &[&smile]).posed(&[(0.0, 0.5)]);
//! assert!(bounds.contains_point(DVec3::new(1.5, 0.0, 0.0))); // half a smile
//! assert!(!bounds.contains_point(DVec3::new(1.6, 0.0, 0.0)));
//! ```

mod morph;
mod skin;

pub use morph::{MorphBounds, morphed_bounds};
pub use skin::{Influence, SkinBounds};

use glam::DVec3;

use crate::Aabb;
use crate::rounding::times;

/// All products of a number from `factor` (least and greatest) and a point of `bounds`, rounded
/// outwards; zero times infinity is zero.
pub(crate) fn scaled(bounds: &Aabb, factor: (f64, f64)) -> Aabb {
    let [least, most] = [factor.0, factor.1].map(DVec3::splat);
    let (a, b) = (times(bounds.min, least), times(bounds.max, least));
    let (c, d) = (times(bounds.min, most), times(bounds.max, most));
    outwards(&Aabb { min: a.min(b).min(c.min(d)), max: a.max(b).max(c.max(d)) })
}

/// The sum of any point of each, rounded outwards.
pub(crate) fn sum(a: &Aabb, b: &Aabb) -> Aabb {
    outwards(&Aabb { min: a.min + b.min, max: a.max + b.max })
}

fn outwards(bounds: &Aabb) -> Aabb {
    let map = |v: DVec3, step: fn(f64) -> f64| DVec3::new(step(v.x), step(v.y), step(v.z));
    Aabb { min: map(bounds.min, f64::next_down), max: map(bounds.max, f64::next_up) }
}
