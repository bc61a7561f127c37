//! Box against frustum, one corner per plane (the "p-vertex" test).
//!
//! A plane excludes the whole box when even the corner farthest along the plane's
//! inward normal lies behind it. Exclusion is proof, rounding included; survival is not: a
//! box just off a frustum edge can be cut by two planes and still miss the frustum.
//! Likewise "inside" is proof: a plane left out of the answer cuts no vertex of the box,
//! not even one whose clip coordinates round differently.
//!
//! Space: box and frustum share one (world, in the renderer). Unit normals, inward.
//! Source: Greene, "Detecting Intersection of a Rectangular Solid and a Convex
//! Polyhedron", Graphics Gems IV, 1994; INFOGR lecture 6, frustum culling of boxes.

use cullet_transform::PlaneMask;

use crate::{Aabb, Frustum};

/// The planes among `asked` that cut `bounds`, or `None` when one of them excludes it.
///
/// Hand a parent's answer to its children: a plane the parent lies wholly inside of
/// needs no second look. An empty box is excluded whatever is asked. NaN bounds cut every
/// plane asked, so bad data is drawn and seen rather than lost.
pub fn planes_cutting(bounds: &Aabb, frustum: &Frustum, asked: PlaneMask) -> Option<PlaneMask> {
    match bounds.undisputed() {
        Some(keep) => keep.then_some(asked),
        None => cutting(bounds, frustum, asked.iter()).ok(),
    }
}

/// [`planes_cutting`], asking first the plane that rejected last.
///
/// What one plane rejected it often rejects again, the next frame or the next box: keep one
/// `last_rejecting` (any number to begin with) per box or per walk. The answer is the same.
/// Source: Assarsson and Möller, "Optimized View Frustum Culling Algorithms for Bounding
/// Boxes", 2000: plane coherency.
pub fn planes_cutting_coherent(
    bounds: &Aabb,
    frustum: &Frustum,
    asked: PlaneMask,
    last_rejecting: &mut usize,
) -> Option<PlaneMask> {
    if let Some(keep) = bounds.undisputed() {
        return keep.then_some(asked);
    }
    let first = *last_rejecting;
    let order = asked.contains(first).then_some(first).into_iter();
    let order = order.chain(asked.iter().filter(|&plane| plane != first));
    cutting(bounds, frustum, order).map_err(|plane| *last_rejecting = plane).ok()
}

/// Whether no plane excludes `bounds`: [`planes_cutting`] without its mask, for less.
pub fn p_vertex_visible(bounds: &Aabb, frustum: &Frustum) -> bool {
    if let Some(verdict) = bounds.undisputed() {
        return verdict;
    }
    let bounds = bounds.relative_to(frustum.origin);
    !(0..6).any(|plane| frustum.excludes(plane, &bounds))
}

/// The planes that cut, or the one that excludes.
fn cutting(
    bounds: &Aabb,
    frustum: &Frustum,
    planes: impl Iterator<Item = usize>,
) -> Result<PlaneMask, usize> {
    let bounds = bounds.relative_to(frustum.origin);
    let mut cutting = PlaneMask::NONE;
    for i in planes {
        if frustum.excludes(i, &bounds) {
            return Err(i);
        }
        if !frustum.holds(i, &bounds) {
            cutting.insert(i);
        }
    }
    Ok(cutting)
}

#[cfg(test)]
mod tests {
    use cullet_transform::{Kind, Window};
    use glam::{DMat3, DVec3};
    use proptest::prelude::*;

    use super::*;

    const INF: f64 = f64::INFINITY;
    const LEFT: u8 = 1;
    const RIGHT: u8 = 2;
    const NEAR: u8 = 16;
    const FAR: u8 = 32;

    /// Looks down -z from the origin, 90 degrees both ways.
    fn pyramid(near: f64, far: f64) -> Frustum {
        let window = Window {
            kind: Kind::Perspective,
            left: -1.0,
            right: 1.0,
            bottom: -1.0,
            top: 1.0,
            near,
            far,
        };
        Frustum::from_window(DVec3::ZERO, &DMat3::IDENTITY, &window)
    }

    #[track_caller]
    fn check(min: [f64; 3], max: [f64; 3], expected: Option<u8>) {
        let bounds = Aabb { min: min.into(), max: max.into() };
        let cutting = planes_cutting(&bounds, &pyramid(1.0, 100.0), PlaneMask::ALL);
        assert_eq!(cutting.map(PlaneMask::bits), expected);
    }

    #[test]
    fn box_in_the_middle_is_cut_by_nothing() {
        check([-1.0, -1.0, -11.0], [1.0, 1.0, -9.0], Some(0));
    }

    #[test]
    fn box_across_the_right_plane_is_cut_by_it() {
        check([9.0, -1.0, -11.0], [12.0, 1.0, -9.0], Some(RIGHT));
    }

    #[test]
    fn box_beyond_the_right_plane_is_excluded() {
        check([12.0, -1.0, -11.0], [13.0, 1.0, -9.0], None);
    }

    #[test]
    fn box_touching_the_right_plane_from_outside_survives() {
        check([11.0, -1.0, -11.0], [13.0, 1.0, -9.0], Some(RIGHT));
    }

    #[test]
    fn box_a_hair_beyond_the_right_plane_is_excluded() {
        check([11.0 + 1e-12, -1.0, -11.0], [13.0, 1.0, -9.0], None);
    }

    #[test]
    fn box_behind_the_eye_is_excluded() {
        check([-1.0, -1.0, 1.0], [1.0, 1.0, 2.0], None);
    }

    #[test]
    fn point_on_the_near_plane_is_visible() {
        check([0.0, -0.0, -1.0], [0.0, 0.0, -1.0], Some(NEAR));
    }

    #[test]
    fn point_on_the_far_plane_is_visible() {
        check([5.0, 5.0, -100.0], [5.0, 5.0, -100.0], Some(FAR));
    }

    #[test]
    fn wall_without_end_is_cut_by_the_side_planes() {
        check([-INF, -1.0, -11.0], [INF, 1.0, -9.0], Some(LEFT | RIGHT));
    }

    #[test]
    fn wall_without_end_behind_the_far_plane_is_excluded() {
        check([-INF, -INF, -INF], [INF, INF, -100.1], None);
    }

    #[test]
    fn everything_is_cut_by_every_plane() {
        check([-INF; 3], [INF; 3], Some(0b11_1111));
    }

    #[test]
    fn empty_box_is_never_visible() {
        check([INF; 3], [-INF; 3], None);
        check([1.0, 0.0, -10.0], [-1.0, 0.0, -10.0], None);
        assert_eq!(planes_cutting(&Aabb::EMPTY, &pyramid(1.0, 2.0), PlaneMask::NONE), None);
    }

    #[test]
    fn nan_bounds_cut_every_plane_asked() {
        check([f64::NAN; 3], [f64::NAN; 3], Some(0b11_1111));
        // Also where the other coordinates alone would exclude it, or make it empty.
        check([f64::NAN, 50.0, -10.0], [1.0, 49.0, -10.0], Some(0b11_1111));
        let asked = PlaneMask::from_bits(LEFT | NEAR);
        assert_eq!(planes_cutting(&Aabb::NAN, &pyramid(1.0, 2.0), asked), Some(asked));
    }

    #[test]
    fn the_rejecting_plane_is_remembered() {
        let right = Aabb { min: DVec3::new(12.0, 0.0, -9.0), max: DVec3::new(13.0, 0.0, -9.0) };
        let (frustum, mut last) = (pyramid(1.0, 100.0), usize::MAX);
        assert_eq!(planes_cutting_coherent(&right, &frustum, PlaneMask::ALL, &mut last), None);
        assert_eq!(last, 1);
        let all = planes_cutting_coherent(&Aabb::INFINITE, &frustum, PlaneMask::ALL, &mut last);
        assert_eq!((all, last), (Some(PlaneMask::ALL), 1));
    }

    #[test]
    fn only_the_planes_asked_are_looked_at() {
        let behind = Aabb { min: DVec3::new(-9.0, 0.0, 1.0), max: DVec3::new(9.0, 0.0, 2.0) };
        let asked = PlaneMask::from_bits(FAR);
        let frustum = pyramid(1.0, 100.0);
        assert_eq!(planes_cutting(&behind, &frustum, asked), Some(PlaneMask::NONE));
    }

    #[test]
    fn infinite_far_excludes_nothing() {
        let frustum = pyramid(1e-6, INF);
        for depth in [1.0, 1e30, 1e300, INF] {
            let bounds = Aabb { min: DVec3::new(0.0, 0.0, -depth), max: DVec3::ZERO };
            let cutting = planes_cutting(&bounds, &frustum, PlaneMask::ALL).expect("visible");
            assert!(!cutting.contains(5), "{depth}");
        }
    }

    /// Truth in integers: a rotation from a whole quaternion has whole entries over a common
    /// denominator, and a window edge is a whole number over 2^20.
    struct Exact {
        eye: [i64; 3],
        /// Columns right, up, back, times `scale`.
        basis: [[i64; 3]; 3],
        scale: i64,
        left: i64,
    }

    const UNIT: i64 = 1 << 20;

    impl Exact {
        fn new(eye: [i64; 3], [a, b, c, d]: [i64; 4], left: i64) -> Self {
            let columns = [
                [a * a + b * b - c * c - d * d, 2 * (b * c + a * d), 2 * (b * d - a * c)],
                [2 * (b * c - a * d), a * a - b * b + c * c - d * d, 2 * (c * d + a * b)],
                [2 * (b * d + a * c), 2 * (c * d - a * b), a * a - b * b - c * c + d * d],
            ];
            Exact { eye, basis: columns, scale: a * a + b * b + c * c + d * d, left }
        }

        fn frustum(&self) -> Frustum {
            let column = |c: [i64; 3]| DVec3::from_array(c.map(|n| n as f64 / self.scale as f64));
            let [right, up, back] = self.basis.map(column);
            let left = self.left as f64 / UNIT as f64;
            let window = Window {
                kind: Kind::Perspective,
                left,
                right: left + 3.0,
                bottom: -1.0,
                top: 1.0,
                near: 1.0,
                far: INF,
            };
            let eye = DVec3::from_array(self.eye.map(|n| n as f64));
            Frustum::from_window(eye, &DMat3::from_cols(right, up, back), &window)
        }

        /// Distance to the left plane, and the sum of the sizes of its terms, both times a
        /// positive constant.
        fn left_distance(&self, point: [i64; 3]) -> (i128, i128) {
            let [right, _, back] = self.basis;
            let mut sums = (0, 0);
            for i in 0..3 {
                let along = i128::from(point[i]) - i128::from(self.eye[i]);
                let (across, depth) = (
                    i128::from(right[i]) * i128::from(UNIT) * along,
                    i128::from(back[i]) * i128::from(self.left) * along,
                );
                sums = (sums.0 + across + depth, sums.1 + across.abs() + depth.abs());
            }
            sums
        }

        /// Around depth `z` and height `y` on the left plane, the whole point that comes closest
        /// to the plane, on either side, or the one of the given `rank` after it.
        fn nearly_on_left_plane(&self, y: f64, z: f64, rank: usize) -> [i64; 3] {
            let x = z * self.left as f64 / UNIT as f64;
            let center: [i64; 3] = core::array::from_fn(|i| {
                let [right, up, back] = self.basis.map(|c| c[i] as f64 / self.scale as f64);
                self.eye[i] + (x * right + y * up - z * back).round() as i64
            });
            let mut around: Vec<[i64; 3]> = (0..343)
                .map(|n| [n / 49 - 3, n / 7 % 7 - 3, n % 7 - 3])
                .map(|step| core::array::from_fn(|i| center[i] + step[i]))
                .collect();
            around.sort_by_key(|&point| self.left_distance(point).0.abs());
            around[rank]
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4096))]

        /// Boxes whose deciding corner is a fraction of a unit off the plane, at distances up to 2^49
        /// where f64 rounds to about a unit, and eyes up to 2^48 away from zero.
        #[test]
        fn exclusion_by_a_plane_agrees_with_exact_arithmetic(
            eye in prop::array::uniform3((-(1_i64 << 48)..1 << 48, 0..48_u32)),
            quaternion in prop::array::uniform4(-40_i64..=40),
            left in -4 * UNIT..4 * UNIT,
            (y, z) in (-1.0_f64..1.0, (0.0..49.0).prop_map(f64::exp2)),
            rank in 0..8_usize,
            size in prop::array::uniform3((0_i64..1 << 40, 0..40_u32)),
        ) {
            prop_assume!(quaternion != [0; 4]);
            let exact = Exact::new(eye.map(|(n, shift)| n >> shift), quaternion, left);
            let frustum = exact.frustum();
            let deciding = exact.nearly_on_left_plane(y * z, z, rank);

            // The box reaches outwards from its deciding corner.
            let [right, _, back] = exact.basis;
            let reach: [i64; 3] = core::array::from_fn(|i| {
                let normal = right[i] * UNIT + back[i] * left;
                let (n, shift) = size[i];
                deciding[i] - normal.signum() * (n >> shift)
            });
            let bounds = Aabb::from_points(
                [deciding, reach].map(|p| DVec3::from_array(p.map(|n| n as f64))),
            );

            let asked = PlaneMask::from_bits(LEFT);
            let cutting = planes_cutting(&bounds, &frustum, asked);
            let (distance, terms) = exact.left_distance(deciding);
            if distance >= 0 {
                prop_assert!(cutting.is_some(), "false cull: {distance} of {terms}");
            }
            if distance < -(terms >> 18) {
                prop_assert!(cutting.is_none(), "false keep: {distance} of {terms}");
            }
            let (least, _) = exact.left_distance(reach);
            if cutting == Some(PlaneMask::NONE) {
                prop_assert!(least >= 0, "false inside: {least}");
            }
        }

        /// Whatever holds a point of the frustum is kept, by all six planes together.
        #[test]
        fn a_box_around_a_visible_point_is_kept(
            eye in prop::array::uniform3(-(1_i64 << 48)..1 << 48),
            quaternion in prop::array::uniform4(-40_i64..=40),
            (x, y, z) in (-2.0_f64..1.0, -1.0_f64..1.0, 4.0_f64..1e12),
            size in prop::array::uniform3(1_i64..1 << 40),
        ) {
            prop_assume!(quaternion != [0; 4]);
            let exact = Exact::new(eye, quaternion, -2 * UNIT);
            let frustum = exact.frustum();
            let rotation = exact.basis.map(|c| c.map(|n| n as f64 / exact.scale as f64));
            let point: [i64; 3] = core::array::from_fn(|i| {
                let [right, up, back] = rotation.map(|column| column[i]);
                eye[i] + (x * z * right + y * z * up - z * back).round() as i64
            });
            let at = |s: i64| {
                DVec3::from_array(core::array::from_fn(|i| (point[i] + s * size[i]) as f64))
            };
            let bounds = Aabb { min: at(-1), max: at(1) };
            let cutting = planes_cutting(&bounds, &frustum, PlaneMask::ALL);
            prop_assert!(cutting.is_some());
            for mut last in 0..8 {
                let again = planes_cutting_coherent(&bounds, &frustum, PlaneMask::ALL, &mut last);
                prop_assert_eq!(again, cutting);
            }
            let local = bounds.relative_to(frustum.origin);
            let relative = planes_cutting(&local, &frustum.relative_to_eye(), PlaneMask::ALL);
            prop_assert_eq!(relative, cutting);
        }
    }
}
