//! Ray against box, one slab at a time.
//!
//! A box is where three slabs meet: each axis gives an interval of `t` in which the ray is
//! between its two planes, and the ray hits the box when the three intervals and
//! `[0, inf)` have a point in common.
//!
//! ```text
//!        |      |  /              enter = the last entry, exit = the first exit,
//!   -----+------+-/----           hit if enter <= exit
//!        |      |/
//!        |      o exit
//!        |     /|
//!   -----+----o-+------
//!        |   / enter
//! ```
//!
//! The interval starts as `[0, inf)` and every axis takes part. (The lecture's code starts
//! with the two ends exchanged, which no axis can narrow, and leaves out z.) Each
//! computed bound is widened by more than its rounding, so a box the ray touches
//! is never missed.
//!
//! Source: Kay and Kajiya 1986, "Ray Tracing Complex Scenes"; Ize 2013, "Robust BVH Ray
//! Traversal", for the widening; INFOGR lecture on bounding volumes.

use crate::{Aabb, Ray};

/// Where `ray` enters and leaves `bounds`, as parameters `t` with `0 <= enter <= exit`, or
/// `None` when it misses.
///
/// The interval holds the exact one and is wider by at most 2^-50 of each end. A ray that
/// starts inside enters at 0. A direction component of 0 (or -0) keeps the ray in or out of
/// its slab for good, the border included. Infinite boxes are exact. An empty box is missed, an
/// invalid one (NaN) is hit everywhere; a ray with a NaN or an infinity misses everything.
pub fn ray_aabb(ray: &Ray, bounds: &Aabb) -> Option<(f64, f64)> {
    if !ray.is_finite() || bounds.is_empty() {
        return None;
    }
    let (mut enter, mut exit) = (0.0_f64, f64::INFINITY);
    if bounds.is_nan() {
        return Some((enter, exit));
    }
    for axis in 0..3 {
        let (origin, direction) = (ray.origin[axis], ray.direction[axis]);
        let (min, max) = (bounds.min[axis], bounds.max[axis]);
        if direction == 0.0 {
            if origin < min || origin > max {
                return None;
            }
            continue;
        }
        let (first, last) = if direction > 0.0 { (min, max) } else { (max, min) };
        enter = enter.max(-upper_quotient(origin - first, direction));
        exit = exit.min(upper_quotient(last - origin, direction));
    }
    (enter <= exit).then_some((enter, exit))
}

/// At least `distance / direction`, where `distance` was rounded once before; 0 stays 0.
///
/// Two roundings move the quotient by 2 * 2^-53 of itself, and the widening is
/// rounded as well: 4 * 2^-53 covers all, and the step to the next number covers underflow.
fn upper_quotient(distance: f64, direction: f64) -> f64 {
    const WIDENING: f64 = 4.0 / (1_u64 << 53) as f64;
    let t = distance / direction;
    if distance == 0.0 {
        return t;
    }
    if t == f64::NEG_INFINITY && distance.is_finite() {
        return f64::MIN; // an overflow, not a slab at infinity
    }
    (t + t.abs() * WIDENING).next_up()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use proptest::prelude::*;

    use super::*;

    const INF: f64 = f64::INFINITY;

    fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
        Ray { origin: origin.into(), direction: direction.into() }
    }

    /// Against the box from -1 to 1.
    #[track_caller]
    fn check(origin: [f64; 3], direction: [f64; 3], expected: Option<(f64, f64)>) {
        check_box([-1.0; 3], [1.0; 3], origin, direction, expected);
    }

    #[track_caller]
    fn check_box(
        min: [f64; 3],
        max: [f64; 3],
        origin: [f64; 3],
        direction: [f64; 3],
        expected: Option<(f64, f64)>,
    ) {
        let bounds = Aabb { min: min.into(), max: max.into() };
        let hit = ray_aabb(&ray(origin, direction), &bounds);
        match (hit, expected) {
            (None, None) => {}
            (Some((enter, exit)), Some((expected_enter, expected_exit))) => {
                let within = enter <= expected_enter && exit >= expected_exit;
                let close = |a: f64, b: f64| a == b || (a - b).abs() <= 1e-15 * b.abs();
                assert!(
                    within && close(enter, expected_enter) && close(exit, expected_exit),
                    "{hit:?} against {expected:?}"
                );
            }
            _ => panic!("{hit:?} against {expected:?}"),
        }
    }

    #[test]
    fn head_on() {
        check([-3.0, 0.0, 0.0], [1.0, 0.0, 0.0], Some((2.0, 4.0)));
        check([0.0, 3.0, 0.0], [0.0, -1.0, 0.0], Some((2.0, 4.0)));
        check([0.0, 0.0, 3.0], [0.0, -0.0, -2.0], Some((1.0, 2.0)));
    }

    #[test]
    fn every_axis_can_miss() {
        check([-3.0, 2.0, 0.0], [1.0, 0.0, 0.0], None);
        check([-3.0, 0.0, 2.0], [1.0, 0.0, 0.0], None);
        check([2.0, 0.0, -3.0], [-0.0, 0.0, 1.0], None);
        check([-3.0, 0.0, 0.0], [1.0, 0.0, 0.75], None);
        check([-3.0, 0.0, 0.0], [1.0, 0.75, 0.0], None);
    }

    #[test]
    fn box_behind_the_origin_is_missed() {
        check([3.0, 0.0, 0.0], [1.0, 0.0, 0.0], None);
    }

    #[test]
    fn from_inside_the_ray_enters_at_zero() {
        check([0.0; 3], [1.0, 2.0, 3.0], Some((0.0, 1.0 / 3.0)));
        check([0.5; 3], [0.0; 3], Some((0.0, INF)));
    }

    #[test]
    fn a_face_an_edge_and_a_corner_are_touched() {
        check([-3.0, 1.0, 0.0], [1.0, 0.0, 0.0], Some((2.0, 4.0)));
        check([-3.0, 1.0, -1.0], [1.0, 0.0, 0.0], Some((2.0, 4.0)));
        check([-3.0, 3.0, 0.0], [1.0, -1.0, 0.0], Some((2.0, 4.0)));
        check([-1.0, 3.0, 0.0], [-1.0, -2.0, 0.0], None);
        check([0.0, 2.0, 1.0], [1.0, -1.0, 0.0], Some((1.0, 1.0)));
    }

    #[test]
    fn origin_on_a_face() {
        check([1.0, 0.0, 0.0], [1.0, 0.0, 0.0], Some((0.0, 0.0)));
        check([1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], Some((0.0, 2.0)));
        check([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], Some((0.0, 1.0)));
    }

    #[test]
    fn flat_and_infinite_boxes() {
        check_box([0.0; 3], [0.0; 3], [-2.0, -4.0, -6.0], [1.0, 2.0, 3.0], Some((2.0, 2.0)));
        let floor = ([-INF, 0.0, -INF], [INF, 0.0, INF]);
        check_box(floor.0, floor.1, [5.0, 8.0, 5.0], [1.0, -2.0, 0.0], Some((4.0, 4.0)));
        check_box([-INF; 3], [INF; 3], [0.0; 3], [1.0, -1.0, 0.0], Some((0.0, INF)));
        check_box([INF; 3], [-INF; 3], [0.0; 3], [1.0, 0.0, 0.0], None);
    }

    #[test]
    fn tiny_directions_do_not_lose_the_box() {
        let hit = ray_aabb(&ray([-3.0, 0.0, 0.0], [5e-324, 0.0, 0.0]), &CUBE);
        assert_eq!(hit, Some((f64::MAX, INF)));
        check([-3e-300, 0.0, 0.0], [1e300, 0.0, 0.0], Some((0.0, 1e-300)));
    }

    #[test]
    fn nan_rays_miss_and_nan_boxes_are_hit() {
        check([f64::NAN, 0.0, 0.0], [1.0, 0.0, 0.0], None);
        check([0.0; 3], [INF, 0.0, 0.0], None);
        let bounds = Aabb { min: DVec3::new(f64::NAN, 5.0, 5.0), max: DVec3::splat(6.0) };
        let hit = ray_aabb(&ray([0.0; 3], [1.0, 0.0, 0.0]), &bounds);
        assert_eq!(hit, Some((0.0, INF)));
    }

    const CUBE: Aabb = Aabb { min: DVec3::NEG_ONE, max: DVec3::ONE };

    fn whole_point(range: i64) -> impl Strategy<Value = [i64; 3]> {
        prop::array::uniform3(-range..=range)
    }

    fn to_f64(v: [i64; 3]) -> DVec3 {
        DVec3::from_array(v.map(|n| n as f64))
    }

    /// Truth in whole numbers: the slab bounds are fractions over the direction.
    fn hits_exactly(origin: [i64; 3], direction: [i64; 3], min: [i64; 3], max: [i64; 3]) -> bool {
        // Fractions (numerator, positive denominator).
        let mut enter = (0_i128, 1_i128);
        let mut exit: Option<(i128, i128)> = None;
        let less = |a: (i128, i128), b: (i128, i128)| a.0 * b.1 < b.0 * a.1;
        for i in 0..3 {
            if direction[i] == 0 {
                if origin[i] < min[i] || origin[i] > max[i] {
                    return false;
                }
                continue;
            }
            let (first, last) = if direction[i] > 0 { (min[i], max[i]) } else { (max[i], min[i]) };
            let t = |plane: i64| {
                let sign = i128::from(direction[i].signum());
                (sign * i128::from(plane - origin[i]), i128::from(direction[i].abs()))
            };
            if less(enter, t(first)) {
                enter = t(first);
            }
            if exit.is_none_or(|exit| less(t(last), exit)) {
                exit = Some(t(last));
            }
        }
        exit.is_none_or(|exit| !less(exit, enter))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4096))]

        /// A ray that passes exactly through a corner, at t = p / q, with coordinates so long
        /// that differences and quotients round: often the corner is all it touches.
        #[test]
        fn a_ray_through_a_corner_never_misses(
            step in whole_point(3 << 30),
            (p, q) in (1_i64..1 << 22, 1_i64..1 << 20),
            shift in whole_point(1 << 20),
            size in whole_point(1 << 40),
        ) {
            let corner: [i64; 3] = core::array::from_fn(|i| p * step[i] / 2 + shift[i]);
            let origin = core::array::from_fn(|i| corner[i] - p * step[i]);
            let other = core::array::from_fn(|i| corner[i] + size[i]);
            let bounds = Aabb::from_points([to_f64(corner), to_f64(other)]);
            let direction = to_f64(step.map(|n| q * n));
            let t = p as f64 / q as f64;
            let hit = ray_aabb(&Ray { origin: to_f64(origin), direction }, &bounds);
            prop_assert!(hit.is_some_and(|(enter, exit)| (enter..=exit).contains(&t)));
        }

        /// Small whole numbers: widening may add nothing that is not a touch.
        #[test]
        fn the_verdict_is_exact_on_small_whole_numbers(
            origin in whole_point(20),
            direction in whole_point(7),
            (a, b) in (whole_point(9), whole_point(9)),
        ) {
            let min: [i64; 3] = core::array::from_fn(|i| a[i].min(b[i]));
            let max: [i64; 3] = core::array::from_fn(|i| a[i].max(b[i]));
            let bounds = Aabb { min: to_f64(min), max: to_f64(max) };
            let ray = Ray { origin: to_f64(origin), direction: to_f64(direction) };
            let exact = hits_exactly(origin, direction, min, max);
            prop_assert_eq!(ray_aabb(&ray, &bounds).is_some(), exact);
        }

        /// Points sampled along the ray that lie in the box lie in the interval.
        #[test]
        fn the_interval_holds_every_sample_inside(
            origin in prop::array::uniform3(-3.0..3.0),
            direction in prop::array::uniform3(-1.0..1.0),
        ) {
            let ray = ray(origin, direction);
            let hit = ray_aabb(&ray, &CUBE);
            for t in (0..256).map(|i| f64::from(i) / 16.0) {
                // A sample clearly inside; its own rounding is far below 1e-12.
                if ray.at(t).abs().max_element() < 1.0 - 1e-12 {
                    prop_assert!(hit.is_some_and(|(enter, exit)| enter <= t && t <= exit));
                }
                if let Some((enter, exit)) = hit && enter < t && t < exit {
                    prop_assert!(ray.at(t).abs().max_element() < 1.0 + 1e-12);
                }
            }
        }
    }
}
