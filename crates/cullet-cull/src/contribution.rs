//! How large can it look? Contribution culling.
//!
//! What covers less than a pixel adds little to a picture, and a far-off scene is full of it.
//! Leaving it out changes pixels all the same, so this is never on by itself: compare
//! [`projected_size_px`] with a threshold of your own. The size is an upper bound, so nothing
//! larger than the threshold is lost.
//!
//! Source: Akenine-Möller et al., "Real-Time Rendering", 2018, section 19.9.

use cullet_transform::{Kind, View};
use glam::{DAffine3, DVec3};

use crate::{Aabb, Sphere};

/// The longer side, in pixels, of a rectangle that the visible part of `bounds` (world space)
/// fits into on the screen of `view`.
///
/// 0 for an empty box and for one that does not reach from the near to the far plane's depths;
/// infinite for NaN and for a box that is infinite in front of the near plane. What is seen of it
/// may be smaller, or nothing: sides of the frustum are not asked.
pub fn projected_size_px(view: &View, bounds: &Aabb) -> f64 {
    let view_from_world = view.view_from_model(&DAffine3::IDENTITY);
    size_in_view(view, &bounds.transformed(&view_from_world))
}

/// Likewise for a ball: tighter than the box around it if the camera is turned.
pub fn projected_sphere_size_px(view: &View, sphere: &Sphere) -> f64 {
    let view_from_world = view.view_from_model(&DAffine3::IDENTITY);
    let point = Aabb { min: sphere.center, max: sphere.center }.transformed(&view_from_world);
    if sphere.is_empty() {
        return 0.0;
    }
    size_in_view(view, &if sphere.is_nan() { Aabb::NAN } else { point.grown(sphere.radius) })
}

fn size_in_view(view: &View, bounds: &Aabb) -> f64 {
    if let Some(keep) = bounds.undisputed() {
        return if keep { f64::INFINITY } else { 0.0 };
    }
    let window = view.window();
    let (nearest, farthest) = ((-bounds.max.z).max(window.near), (-bounds.min.z).min(window.far));
    if nearest > farthest {
        return 0.0;
    }
    let scale = DVec3::new(
        f64::from(view.viewport().width()) / (window.right - window.left),
        f64::from(view.viewport().height()) / (window.top - window.bottom),
        0.0,
    );
    let extent = match window.kind {
        Kind::Orthographic => bounds.max - bounds.min,
        // x / depth is greatest at the nearest depth if positive, at the farthest if not.
        Kind::Perspective => {
            (bounds.max / nearest).max(bounds.max / farthest)
                - (bounds.min / nearest).min(bounds.min / farthest)
        }
    };
    let size = extent.x * scale.x;
    let size = size.max(extent.y * scale.y) * (1.0 + 16.0 * f64::EPSILON);
    if size.is_nan() { f64::INFINITY } else { size }
}

#[cfg(test)]
mod tests {
    use cullet_transform::{Camera, Projection, Viewport};
    use proptest::prelude::*;

    use super::*;

    fn view(eye: DVec3, projection: Projection) -> View {
        let camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Y, projection).expect("a camera");
        View::new(&camera, Viewport::new(400, 200).expect("a picture"))
    }

    const LENS: Projection = Projection::Perspective {
        yfov: core::f64::consts::FRAC_PI_2,
        near: 1.0,
        far: f64::INFINITY,
    };

    #[track_caller]
    fn check(min: [f64; 3], max: [f64; 3], expected: f64) {
        let bounds = Aabb { min: min.into(), max: max.into() };
        let size = projected_size_px(&view(DVec3::Z * 10.0, LENS), &bounds);
        assert!(size >= expected * (1.0 - 1e-15) && size <= expected * (1.0 + 1e-12), "{size}");
    }

    #[test]
    fn sizes_follow_the_nearest_face() {
        // 100 pixels per unit at depth 1, 10 at depth 10.
        check([-1.0, -0.5, 0.0], [1.0, 0.5, 0.0], 20.0);
        check([-1.0, -0.5, 0.0], [1.0, 0.5, 5.0], 40.0);
        check([-1.0, -0.5, 0.0], [1.0, 0.5, 50.0], 200.0); // cut off at near
        check([-1.0, -0.5, 9.5], [1.0, 0.5, 50.0], 0.0);
        check([1.0, 1.0, 1.0], [0.0, 1.0, 1.0], 0.0);
        check([f64::NAN; 3], [1.0; 3], f64::INFINITY);
        check([f64::NEG_INFINITY; 3], [f64::INFINITY; 3], f64::INFINITY);
    }

    #[test]
    fn parallel_lines_keep_sizes() {
        let lens = Projection::Orthographic { height: 20.0, near: 0.0, far: 100.0 };
        let view = view(DVec3::Z * 10.0, lens);
        let bounds = Aabb { min: DVec3::new(0.0, 0.0, -50.0), max: DVec3::ONE };
        assert!((projected_size_px(&view, &bounds) - 10.0).abs() < 1e-9);
        let ball = Sphere { center: DVec3::ZERO, radius: 0.5 };
        assert!((projected_sphere_size_px(&view, &ball) - 10.0).abs() < 1e-9);
        assert_eq!(projected_sphere_size_px(&view, &Sphere { radius: -1.0, ..ball }), 0.0);
        assert_eq!(
            projected_sphere_size_px(&view, &Sphere { radius: f64::NAN, ..ball }),
            f64::INFINITY
        );
    }

    proptest! {
        /// Points of a box that are in front of the near plane are never farther apart.
        #[test]
        fn no_two_points_are_farther_apart(
            eye in prop::array::uniform3(-20.0_f64..20.0),
            min in prop::array::uniform3(-9.0_f64..9.0),
            size in prop::array::uniform3(0.0_f64..5.0),
            places in prop::collection::vec(prop::array::uniform3(0.0_f64..1.0), 8),
        ) {
            let eye = DVec3::from_array(eye) + DVec3::X * 0.1;
            let (min, size) = (DVec3::from_array(min), DVec3::from_array(size));
            let view = view(eye, LENS);
            let most = projected_size_px(&view, &Aabb { min, max: min + size });
            let points: alloc::vec::Vec<_> = places.into_iter()
                .map(|place| min + size * DVec3::from_array(place))
                .filter(|&p| (eye - p).dot(view.camera().back()) >= 1.0)
                .map(|p| view.project(p))
                .collect();
            for a in &points {
                for b in &points {
                    let apart = (a.x - b.x).abs().max((a.y - b.y).abs());
                    prop_assert!(apart <= most + 1e-9, "{apart} {most}");
                }
            }
        }
    }
}
