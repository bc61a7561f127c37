//! Ray against triangle, watertight.
//!
//! Move the ray's origin to zero and shear space so that the ray becomes an axis. Then the
//! question is flat: is zero inside the projected triangle? Three edge functions answer,
//! and because each corner is projected by itself and each edge function never has the
//! wrong sign, two triangles that share an edge cannot both deny a ray that
//! passes between them. On the edge itself both accept.
//!
//! Chosen over Möller and Trumbore 1997, whose edge tests depend on the third corner and so
//! leak along shared edges. Source: Woop, Benthin and Wald, "Watertight Ray/Triangle
//! Intersection", JCGT 2(1), 2013; instead of a wider type, exact ties are settled by
//! Kahan's difference of products.

use glam::DVec3;

use crate::Ray;
use crate::rounding::cross_2;

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// Ray parameter, at least 0, in multiples of the direction.
    pub t: f64,
    /// Weights of the three corners in their order: each in [0, 1], their sum 1 up to rounding.
    pub barycentrics: DVec3,
}

/// The hit of `ray` on `corners`, seen from either side, borders included.
///
/// A triangle whose edges are parallel (or of no length), one seen exactly edge-on, and
/// a NaN or an infinity in ray or triangle give `None`, as does a zero direction. Products of
/// two coordinates must not overflow or underflow: sizes from 1e-140 to 1e140 are safe.
pub fn ray_triangle(ray: &Ray, corners: &[DVec3; 3]) -> Option<TriangleHit> {
    let finite = ray.is_finite() && corners.iter().all(|corner| corner.is_finite());
    if !finite || parallel(corners[1] - corners[0], corners[2] - corners[0]) {
        return None;
    }
    let [a, b, c] = corners.map(|corner| sheared(ray, corner));

    // Twice the signed areas that zero spans with the edge opposite each corner.
    let areas = DVec3::new(edge(c, b), edge(a, c), edge(b, a));
    let inside = areas.cmpge(DVec3::ZERO).all() || areas.cmple(DVec3::ZERO).all();
    let area = areas.x + areas.y + areas.z;
    if !inside || area == 0.0 || !area.is_finite() {
        return None;
    }
    let barycentrics = areas / area;
    let t = barycentrics.dot(DVec3::new(a.z, b.z, c.z));
    (t >= 0.0 && t.is_finite()).then_some(TriangleHit { t, barycentrics })
}

/// `point` in the frame where the ray starts at zero and runs along z at unit speed.
fn sheared(ray: &Ray, point: DVec3) -> DVec3 {
    let axis = ray.direction.abs().max_position();
    let turned = |v: DVec3| DVec3::new(v[(axis + 1) % 3], v[(axis + 2) % 3], v[axis]);
    let (direction, point) = (turned(ray.direction), turned(point - ray.origin));
    // For a zero direction all is NaN, and NaN is outside.
    DVec3::new(
        point.x - direction.x / direction.z * point.z,
        point.y - direction.y / direction.z * point.z,
        point.z / direction.z,
    )
}

/// Positive if zero lies to the left of the way from `from` to `to`, seen against z.
fn edge(to: DVec3, from: DVec3) -> f64 {
    cross_2(from.x, from.y, to.x, to.y)
}

fn parallel(u: DVec3, v: DVec3) -> bool {
    let areas =
        [cross_2(u.y, u.z, v.y, v.z), cross_2(u.z, u.x, v.z, v.x), cross_2(u.x, u.y, v.x, v.y)];
    areas == [0.0; 3]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const TRIANGLE: [DVec3; 3] =
        [DVec3::ZERO, DVec3::new(4.0, 0.0, 0.0), DVec3::new(0.0, 4.0, 0.0)];

    fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
        Ray { origin: origin.into(), direction: direction.into() }
    }

    /// Down z at half speed from height 2.
    #[track_caller]
    fn check_from_above(x: f64, y: f64, expected: Option<[f64; 3]>) {
        let hit = ray_triangle(&ray([x, y, 2.0], [0.0, 0.0, -0.5]), &TRIANGLE);
        assert_eq!(hit.map(|hit| hit.barycentrics.to_array()), expected);
        assert!(hit.is_none_or(|hit| hit.t == 4.0));
    }

    #[test]
    fn barycentrics_follow_the_corners() {
        check_from_above(1.0, 2.0, Some([0.25, 0.25, 0.5]));
        check_from_above(0.0, 0.0, Some([1.0, 0.0, 0.0]));
        check_from_above(4.0, 0.0, Some([0.0, 1.0, 0.0]));
        check_from_above(0.0, 4.0, Some([0.0, 0.0, 1.0]));
        check_from_above(2.0, 2.0, Some([0.0, 0.5, 0.5]));
        check_from_above(2.0, 2.1, None);
        check_from_above(-1e-300, 1.0, None);
    }

    #[test]
    fn both_sides_and_every_axis_are_hit() {
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                let turn =
                    |v: DVec3| DVec3::from_array(core::array::from_fn(|i| v[(i + axis) % 3]));
                let ray = Ray {
                    origin: turn(DVec3::new(1.0, 1.0, 3.0 * sign)),
                    direction: turn(DVec3::new(0.0, 0.0, -sign)),
                };
                let hit = ray_triangle(&ray, &TRIANGLE.map(turn)).expect("a hit");
                assert_eq!((hit.t, hit.barycentrics), (3.0, DVec3::new(0.5, 0.25, 0.25)));
            }
        }
    }

    #[test]
    fn what_lies_behind_is_missed() {
        assert_eq!(ray_triangle(&ray([1.0, 1.0, 1.0], [0.0, 0.0, 1.0]), &TRIANGLE), None);
        let on_it = ray_triangle(&ray([1.0, 1.0, 0.0], [0.0, 0.0, 1.0]), &TRIANGLE);
        assert_eq!(on_it.map(|hit| hit.t), Some(0.0));
    }

    #[test]
    fn degenerate_and_broken_input_gives_nothing() {
        #[track_caller]
        fn check(ray: Ray, corners: [DVec3; 3]) {
            assert_eq!(ray_triangle(&ray, &corners), None);
        }
        let down = ray([1.0, 1.0, 3.0], [0.0, 0.0, -1.0]);
        check(down, [DVec3::ONE; 3]);
        check(down, [DVec3::ZERO, DVec3::ONE, DVec3::ONE]);
        let collinear = [DVec3::ZERO, DVec3::ONE, DVec3::splat(3.0)];
        check(down, collinear);
        check(ray([0.0, 0.0, 3.0], [0.7, 0.7, -2.3]), collinear);
        check(ray([1.0, 1.0, 0.0], [1.0, 0.0, 0.0]), TRIANGLE); // edge-on
        check(ray([1.0, 1.0, 0.0], [0.0; 3]), TRIANGLE);
        check(down, [DVec3::NAN, TRIANGLE[1], TRIANGLE[2]]);
        check(down, [DVec3::INFINITY, TRIANGLE[1], TRIANGLE[2]]);
        check(down, [DVec3::MAX, TRIANGLE[1], -DVec3::MAX]);
        check(ray([f64::NAN, 1.0, 3.0], [0.0, 0.0, -1.0]), TRIANGLE);
        check(ray([1.0, 1.0, 3.0], [0.0, 0.0, f64::NEG_INFINITY]), TRIANGLE);
    }

    fn point() -> impl Strategy<Value = DVec3> {
        (prop::array::uniform3(-1.0_f64..1.0), -10..10_i32)
            .prop_map(|(p, exponent)| DVec3::from_array(p) * 2.0_f64.powi(exponent))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4096))]

        /// A ray aimed at a shared edge, as well as arithmetic can, meets a neighbour.
        #[test]
        fn shared_edges_do_not_leak(
            (a, b, origin) in (point(), point(), point()),
            along in 0.001_f64..0.999,
            (left, right) in (0.1_f64..2.0, 0.1_f64..2.0),
        ) {
            let middle = a + (b - a) * along;
            let direction = middle - origin;
            let across = (b - a).cross(direction).normalize_or_zero() * (b - a).length();
            // Both wings stand off the edge, as seen by the ray, by more than rounding.
            let reach = middle.length() + origin.length();
            prop_assume!((b - a).length() > 1e-6 * reach && direction.length() > 1e-6 * reach);
            prop_assume!((b - a).cross(direction).length()
                > 1e-6 * (b - a).length() * direction.length());
            let ray = Ray { origin, direction };
            let hits = [across * left, across * -right]
                .map(|wing| ray_triangle(&ray, &[a, b, middle + wing]));
            prop_assert!(hits.iter().any(Option::is_some));
            for hit in hits.into_iter().flatten() {
                prop_assert!(hit.barycentrics.cmpge(DVec3::ZERO).all());
                prop_assert!((hit.barycentrics.element_sum() - 1.0).abs() < 1e-14);
            }
        }

        /// Around a corner, a closed fan of triangles leaves no hole either.
        #[test]
        fn a_fan_does_not_leak(
            (hub, origin) in (point(), point()),
            n in 3..12_usize,
            turn in 0.0_f64..6.3,
        ) {
            let direction = hub - origin;
            let reach = hub.length() + origin.length();
            prop_assume!(direction.length() > 1e-6 * reach);
            let (u, v) = direction.normalize().any_orthonormal_pair();
            let rim: Vec<DVec3> = (0..n)
                .map(|i| {
                    let angle = turn + std::f64::consts::TAU * i as f64 / n as f64;
                    hub + (u * angle.cos() + v * angle.sin()) * reach
                })
                .collect();
            let ray = Ray { origin, direction };
            let hit = (0..n).any(|i| ray_triangle(&ray, &[hub, rim[i], rim[(i + 1) % n]]).is_some());
            prop_assert!(hit);
        }

        /// Whole numbers: the verdict is the sign of exact determinants.
        #[test]
        fn the_verdict_along_an_axis_is_exact(
            corners in prop::array::uniform3(prop::array::uniform3(-9_i64..=9)),
            (x, y) in (-9_i64..=9, -9_i64..=9),
        ) {
            let [a, b, c] = corners;
            let cross = |p: [i64; 3], q: [i64; 3]| {
                (p[0] - x) * (q[1] - y) - (p[1] - y) * (q[0] - x)
            };
            let signs = [cross(a, b), cross(b, c), cross(c, a)].map(i64::signum);
            let inside = (!signs.contains(&1) || !signs.contains(&-1)) && signs != [0; 3];
            let ray = ray([x as f64, y as f64, 10.0], [0.0, 0.0, -1.0]);
            let corners = corners.map(|p| DVec3::from_array(p.map(|n| n as f64)));
            let hit = ray_triangle(&ray, &corners);
            prop_assert_eq!(hit.is_some(), inside);
            if let Some(TriangleHit { t, barycentrics }) = hit {
                let there = corners[0] * barycentrics.x
                    + corners[1] * barycentrics.y
                    + corners[2] * barycentrics.z;
                prop_assert!(there.distance(ray.at(t)) < 1e-13);
            }
        }
    }
}
