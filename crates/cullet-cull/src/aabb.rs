//! Axis-aligned bounding boxes, closed at both ends.
//!
//! Every value is one of three: a box that holds points, an **empty** box (some
//! `min > max`), or an **invalid** one (some NaN). Empty boxes are neutral in unions and
//! never visible; invalid ones are neutral in unions with real boxes, so they poison no
//! parent, and every visibility test keeps them. Infinite extents are ordinary.
//!
//! Space: whatever space the points came from; scene units.

use glam::{DAffine3, DVec3};

use crate::Sphere;
use crate::rounding::{ROUNDING, size, times};

/// The points `p` with `min <= p <= max` in every coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Least corner, scene units; `-inf` is legal.
    pub min: DVec3,
    /// Greatest corner, scene units; `+inf` is legal.
    pub max: DVec3,
}

impl Aabb {
    /// Holds nothing; the start of a union.
    pub const EMPTY: Aabb = Aabb { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };
    /// Holds everything.
    pub const INFINITE: Aabb = Aabb { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY };
    /// The invalid box with NaN everywhere.
    pub const NAN: Aabb = Aabb { min: DVec3::NAN, max: DVec3::NAN };

    /// The least box around `points`; [`Aabb::EMPTY`] around none. Exact.
    ///
    /// A point with a NaN is passed over: the triangles that use it are never drawn, and
    /// the rest of a mesh must keep its bounds. Infinite coordinates count.
    pub fn from_points(points: impl IntoIterator<Item = DVec3>) -> Aabb {
        points
            .into_iter()
            .filter(|point| !point.is_nan())
            .fold(Aabb::EMPTY, |all, p| Aabb { min: all.min.min(p), max: all.max.max(p) })
    }

    /// The least box around the corners of a triangle; NaN as in [`Aabb::from_points`].
    pub fn from_triangle(corners: &[DVec3; 3]) -> Aabb {
        Aabb::from_points(*corners)
    }

    /// A box around `sphere`, rounded outwards.
    ///
    /// Empty stays empty, NaN stays NaN, an infinite radius gives [`Aabb::INFINITE`] around
    /// any finite centre.
    pub fn from_sphere(sphere: &Sphere) -> Aabb {
        if sphere.is_empty() {
            return Aabb::EMPTY;
        }
        Aabb { min: sphere.center, max: sphere.center }.grown(sphere.radius)
    }

    /// The least box around both. Exact, commutative and associative.
    ///
    /// A box that holds points wins over an invalid one, and that over an empty one: NaN
    /// is forgotten as soon as there is anything to bound. Whoever keeps invalid items
    /// keeps them beside the tree.
    #[must_use]
    pub fn union(&self, other: &Aabb) -> Aabb {
        match (self.holds_points(), other.holds_points()) {
            (true, true) => Aabb { min: self.min.min(other.min), max: self.max.max(other.max) },
            (true, false) => *self,
            (false, true) => *other,
            (false, false) if self.is_nan() || other.is_nan() => Aabb::NAN,
            (false, false) => Aabb::EMPTY,
        }
    }

    /// The box with `distance` (scene units, not negative) added on every side, rounded outwards.
    ///
    /// Empty stays empty, NaN stays NaN.
    #[must_use]
    pub fn grown(&self, distance: f64) -> Aabb {
        if self.is_empty() || distance == 0.0 {
            return *self;
        }
        let by = DVec3::splat(distance);
        Aabb { min: map(self.min - by, f64::next_down), max: map(self.max + by, f64::next_up) }
    }

    /// A box around the image of this one under `target_from_source`.
    ///
    /// Instead of transforming eight corners, each output bound adds up, per input axis, the
    /// better of two products (Arvo, "Transforming Axis-Aligned Bounding Boxes", Graphics
    /// Gems, 1990). Every bound then moves outwards by [`ROUNDING`] times the sum of the sizes
    /// of its terms, which covers the rounding here and that of a vertex transformed by the
    /// same matrix in f64, so no corner can end up outside.
    ///
    /// `0 * inf` is 0. Empty stays empty; a NaN in box or matrix gives [`Aabb::NAN`];
    /// a bound that would be `inf - inf` becomes the infinity that keeps.
    #[must_use]
    pub fn transformed(&self, target_from_source: &DAffine3) -> Aabb {
        if self.is_nan() || target_from_source.is_nan() {
            return Aabb::NAN;
        }
        if self.is_empty() {
            return Aabb::EMPTY;
        }
        let offset = target_from_source.translation;
        let (mut min, mut min_terms) = (offset, offset.abs());
        let (mut max, mut max_terms) = (offset, offset.abs());
        for axis in 0..3 {
            let column = target_from_source.matrix3.col(axis);
            let (low, high) = (DVec3::splat(self.min[axis]), DVec3::splat(self.max[axis]));
            let (at_low, at_high) = (times(column, low), times(column, high));
            let (low_size, high_size) = (size(column, low), size(column, high));
            let rising = column.cmpge(DVec3::ZERO);
            min += DVec3::select(rising, at_low, at_high);
            max += DVec3::select(rising, at_high, at_low);
            min_terms += DVec3::select(rising, low_size, high_size);
            max_terms += DVec3::select(rising, high_size, low_size);
        }
        Aabb {
            min: map(min - ROUNDING * min_terms, lower_bound),
            max: -map(-max - ROUNDING * max_terms, lower_bound),
        }
    }

    /// Whether the two share a point; touching counts.
    ///
    /// Two intervals per axis, six comparisons (the lecture's snippet lists three, which only
    /// says that one box does not end before the other starts). An empty box overlaps nothing;
    /// an invalid one overlaps everything else.
    pub fn overlaps(&self, other: &Aabb) -> bool {
        if self.is_empty() || other.is_empty() {
            return false;
        }
        let meet = self.min.cmple(other.max).all() && other.min.cmple(self.max).all();
        meet || self.is_nan() || other.is_nan()
    }

    /// Whether `point` lies inside or on the border; false for NaN and for an empty box.
    pub fn contains_point(&self, point: DVec3) -> bool {
        self.min.cmple(point).all() && point.cmple(self.max).all()
    }

    /// Whether every point of `other` lies in this box: true for an empty `other`, false if
    /// either is invalid.
    pub fn contains(&self, other: &Aabb) -> bool {
        let within = self.min.cmple(other.min).all() && other.max.cmple(self.max).all();
        other.is_empty() && !self.is_nan() || within && self.holds_points()
    }

    /// Whether it holds no point: some `min > max`, and no NaN anywhere.
    pub fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any() && !self.is_nan()
    }

    /// Whether it is invalid: some coordinate is NaN.
    pub fn is_nan(&self) -> bool {
        self.min.is_nan() || self.max.is_nan()
    }

    /// The middle, rounded, without overflow; 0 along an axis that reaches to both
    /// infinities. Meaningless but not a panic for an empty box.
    pub fn center(&self) -> DVec3 {
        let middle = self.min * 0.5 + self.max * 0.5;
        DVec3::select(self.min.cmpeq(-self.max), DVec3::ZERO, middle)
    }

    /// Half the size along each axis, rounded, without overflow: `center ± half_extent` may
    /// miss the box by that rounding. Negative somewhere for an empty box.
    pub fn half_extent(&self) -> DVec3 {
        self.max * 0.5 - self.min * 0.5
    }

    /// The eight corners; bit 0 of the index chooses the greater x, bit 1 y, bit 2 z.
    pub fn corners(&self) -> [DVec3; 8] {
        core::array::from_fn(|i| {
            let greater = glam::BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0);
            DVec3::select(greater, self.max, self.min)
        })
    }

    /// The corner farthest along `normal` (the "p-vertex"); where a coordinate of
    /// the normal is 0 or -0 the greater one.
    pub fn farthest_along(&self, normal: DVec3) -> DVec3 {
        DVec3::select(normal.cmpge(DVec3::ZERO), self.max, self.min)
    }

    /// Area of the six faces, square scene units, rounded: the cost measure of a hierarchy
    /// (Goldsmith and Salmon 1987). 0 for an empty box, NaN for an invalid one, and `0 * inf`
    /// is 0.
    pub fn surface_area(&self) -> f64 {
        if self.is_empty() {
            return 0.0;
        }
        let extent = self.max - self.min;
        let faces = times(extent, DVec3::new(extent.y, extent.z, extent.x));
        2.0 * (faces.x + faces.y + faces.z)
    }

    /// The same box with `origin` as the new zero; each coordinate rounded once.
    #[must_use]
    pub fn relative_to(&self, origin: DVec3) -> Aabb {
        Aabb { min: self.min - origin, max: self.max - origin }
    }

    /// The verdict of every test on a box that is no box: NaN is kept, empty is not.
    pub(crate) fn undisputed(&self) -> Option<bool> {
        if self.is_nan() { Some(true) } else { self.is_empty().then_some(false) }
    }

    fn holds_points(&self) -> bool {
        self.min.cmple(self.max).all()
    }
}

/// What a computed lower bound is worth: nothing if it is NaN, and no more than the greatest
/// number, since `+inf` may be an overflow.
fn lower_bound(bound: f64) -> f64 {
    if bound.is_nan() { f64::NEG_INFINITY } else { bound.min(f64::MAX) }
}

fn map(v: DVec3, f: impl Fn(f64) -> f64) -> DVec3 {
    DVec3::new(f(v.x), f(v.y), f(v.z))
}

#[cfg(test)]
mod tests {
    use glam::DMat3;
    use proptest::prelude::*;

    use super::*;

    const INF: f64 = f64::INFINITY;

    fn aabb(min: [f64; 3], max: [f64; 3]) -> Aabb {
        Aabb { min: min.into(), max: max.into() }
    }

    /// The box from -1 to 1, moved by `x` along the first axis.
    fn cube(x: f64) -> Aabb {
        aabb([x - 1.0, -1.0, -1.0], [x + 1.0, 1.0, 1.0])
    }

    fn half_nan() -> Aabb {
        aabb([f64::NAN, 5.0, 0.0], [1.0, 4.0, 0.0])
    }

    /// Empty along y only.
    fn half_empty() -> Aabb {
        aabb([-9.0, 1.0, -9.0], [9.0, 0.0, 9.0])
    }

    #[test]
    fn a_value_is_a_box_or_empty_or_invalid() {
        #[track_caller]
        fn check(bounds: Aabb, (holds, empty, nan): (bool, bool, bool)) {
            assert_eq!(
                (bounds.holds_points(), bounds.is_empty(), bounds.is_nan()),
                (holds, empty, nan)
            );
        }
        check(cube(0.0), (true, false, false));
        check(aabb([0.0; 3], [-0.0; 3]), (true, false, false));
        check(Aabb::INFINITE, (true, false, false));
        check(Aabb::EMPTY, (false, true, false));
        check(half_empty(), (false, true, false));
        check(Aabb::NAN, (false, false, true));
        check(half_nan(), (false, false, true));
    }

    #[test]
    fn points_with_nan_are_passed_over() {
        let points = [DVec3::ZERO, DVec3::new(100.0, f64::NAN, 0.0), DVec3::ONE];
        assert_eq!(Aabb::from_points(points), aabb([0.0; 3], [1.0; 3]));
        assert_eq!(Aabb::from_triangle(&points), aabb([0.0; 3], [1.0; 3]));
        assert_eq!(Aabb::from_points([DVec3::NAN]), Aabb::EMPTY);
        assert_eq!(Aabb::from_points([]), Aabb::EMPTY);
        let reaching = Aabb::from_points([DVec3::ZERO, DVec3::new(INF, 0.0, 0.0)]);
        assert_eq!(reaching.max, DVec3::new(INF, 0.0, 0.0));
    }

    #[test]
    fn unions_forget_empty_and_invalid_boxes() {
        #[track_caller]
        fn check(a: Aabb, b: Aabb, expected: Aabb) {
            for union in [a.union(&b), b.union(&a)] {
                assert!(union == expected || union.is_nan() && expected.is_nan(), "{union:?}");
            }
        }
        check(cube(0.0), cube(5.0), aabb([-1.0; 3], [6.0, 1.0, 1.0]));
        check(cube(0.0), Aabb::EMPTY, cube(0.0));
        check(cube(0.0), half_empty(), cube(0.0));
        check(cube(0.0), half_nan(), cube(0.0));
        check(cube(0.0), Aabb::INFINITE, Aabb::INFINITE);
        check(half_empty(), Aabb::EMPTY, Aabb::EMPTY);
        check(half_nan(), half_empty(), Aabb::NAN);
        check(half_nan(), half_nan(), Aabb::NAN);
    }

    #[test]
    fn touching_boxes_overlap() {
        #[track_caller]
        fn check(a: Aabb, b: Aabb, expected: bool) {
            assert_eq!((a.overlaps(&b), b.overlaps(&a)), (expected, expected));
        }
        check(cube(0.0), cube(2.0), true);
        check(cube(0.0), cube(2.0_f64.next_up()), false);
        check(cube(0.0), cube(-2.5), false);
        for axis in 0..3 {
            let mut beyond = cube(0.0);
            (beyond.min[axis], beyond.max[axis]) = (1.5, 2.0);
            check(cube(0.0), beyond, false);
            (beyond.min[axis], beyond.max[axis]) = (0.5, 2.0);
            check(cube(0.0), beyond, true);
        }
        check(cube(0.0), Aabb::INFINITE, true);
        check(cube(0.0), half_empty(), false);
        check(Aabb::INFINITE, Aabb::EMPTY, false);
        check(cube(0.0), half_nan(), true);
        check(half_nan(), Aabb::EMPTY, false);
    }

    #[test]
    fn containing_is_closed() {
        assert!(cube(0.0).contains_point(DVec3::ONE));
        assert!(!cube(0.0).contains_point(DVec3::new(0.0, 0.0, 1.0_f64.next_up())));
        assert!(!cube(0.0).contains_point(DVec3::NAN));
        assert!(!half_empty().contains_point(DVec3::ZERO));
        assert!(cube(0.0).contains(&cube(0.0)));
        assert!(!cube(0.0).contains(&cube(0.1)));
        assert!(cube(0.0).contains(&half_empty()) && Aabb::EMPTY.contains(&half_empty()));
        assert!(!half_empty().contains(&cube(0.0)));
        assert!(!Aabb::INFINITE.contains(&half_nan()) && !half_nan().contains(&cube(0.0)));
    }

    #[test]
    fn a_sphere_fits_its_box() {
        let sphere = |radius| Sphere { center: DVec3::new(1.0, 2.0, 3.0), radius };
        let point = aabb([1.0, 2.0, 3.0], [1.0, 2.0, 3.0]);
        assert_eq!(Aabb::from_sphere(&sphere(0.0)), point);
        assert_eq!(Aabb::from_sphere(&sphere(0.5)).max.z, 3.5_f64.next_up());
        assert_eq!(Aabb::from_sphere(&sphere(INF)), Aabb::INFINITE);
        assert_eq!(Aabb::from_sphere(&sphere(-1.0)), Aabb::EMPTY);
        assert!(Aabb::from_sphere(&sphere(f64::NAN)).is_nan());
        let small = Aabb::from_sphere(&sphere(1e-30));
        assert_eq!((small.min.x, small.max.x), (1.0_f64.next_down(), 1.0_f64.next_up()));
    }

    #[test]
    fn measures() {
        let bounds = aabb([1.0, 2.0, 3.0], [2.0, 4.0, 6.0]);
        assert_eq!(bounds.center(), DVec3::new(1.5, 3.0, 4.5));
        assert_eq!(bounds.half_extent(), DVec3::new(0.5, 1.0, 1.5));
        assert_eq!(bounds.surface_area(), 22.0);
        assert_eq!(bounds.corners()[5], DVec3::new(2.0, 2.0, 6.0));
        assert_eq!(bounds.farthest_along(DVec3::new(-1.0, 1.0, -0.0)), DVec3::new(1.0, 4.0, 6.0));
        assert_eq!(Aabb::INFINITE.center(), DVec3::ZERO);
        assert_eq!(aabb([f64::MAX; 3], [f64::MAX; 3]).center(), DVec3::MAX);
        assert_eq!(Aabb::EMPTY.surface_area(), 0.0);
        assert_eq!(aabb([0.0; 3], [INF, 1.0, 0.0]).surface_area(), INF);
        assert_eq!(aabb([0.0; 3], [INF, 0.0, 0.0]).surface_area(), 0.0);
        assert!(half_nan().surface_area().is_nan());
    }

    #[test]
    fn growing_rounds_outwards() {
        let grown = cube(0.0).grown(1e-30);
        assert_eq!((grown.min.x, grown.max.x), ((-1.0_f64).next_down(), 1.0_f64.next_up()));
        assert_eq!(cube(0.0).grown(0.0), cube(0.0));
        assert!(half_empty().grown(10.0).is_empty() && half_nan().grown(1.0).is_nan());
        assert_eq!(Aabb::INFINITE.grown(1.0), Aabb::INFINITE);
    }

    #[test]
    fn transforms_keep_what_is_special() {
        let turn = DAffine3::from_rotation_z(1.0);
        assert_eq!(Aabb::EMPTY.transformed(&turn), Aabb::EMPTY);
        assert_eq!(half_empty().transformed(&turn), Aabb::EMPTY);
        assert!(half_nan().transformed(&turn).is_nan());
        assert!(cube(0.0).transformed(&DAffine3::NAN).is_nan());
        assert_eq!(Aabb::INFINITE.transformed(&turn).max, DVec3::new(INF, INF, INF));

        // Infinite along z only; a turn about z leaves x and y finite.
        let column = aabb([-1.0, -1.0, -INF], [1.0, 1.0, INF]).transformed(&turn);
        assert!(column.min.x.is_finite() && column.max.y.is_finite());
        assert_eq!((column.min.z, column.max.z), (-INF, INF));

        // A flat box stays flat, and a matrix without volume flattens.
        let floor = aabb([-1.0, 0.0, -1.0], [1.0, 0.0, 1.0]).transformed(&DAffine3::IDENTITY);
        assert_eq!((floor.min.y, floor.max.y), (0.0, 0.0));
        let flat = DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0));
        assert_eq!(Aabb::INFINITE.transformed(&flat).max, DVec3::new(INF, 0.0, INF));

        // Overflow and opposing infinities widen.
        let huge = aabb([f64::MAX; 3], [f64::MAX; 3]);
        let doubled = huge.transformed(&DAffine3::from_scale(DVec3::splat(2.0)));
        assert!(doubled.min.x <= f64::MAX && doubled.max.x == INF);
        let skew = DAffine3::from_mat3(DMat3::from_cols(DVec3::X, -DVec3::X, DVec3::Z));
        let corner = aabb([INF, INF, 0.0], [INF, INF, 0.0]).transformed(&skew);
        assert_eq!((corner.min.x, corner.max.x), (-INF, INF));
    }

    /// Whole numbers up to 2^53 in size, of all magnitudes.
    fn whole() -> impl Strategy<Value = i64> {
        (-(1_i64 << 53)..=1 << 53, 0..53_u32).prop_map(|(n, shift)| n >> shift)
    }

    proptest! {
        #[test]
        fn a_transformed_box_holds_its_corners_exactly(
            m in prop::array::uniform12(whole()),
            a in prop::array::uniform3(whole()),
            b in prop::array::uniform3(whole()),
        ) {
            let column = |c: usize| DVec3::from_array([m[c], m[c + 1], m[c + 2]].map(|n| n as f64));
            let affine = DAffine3::from_cols(column(0), column(3), column(6), column(9));
            let source = Aabb::from_points([a, b].map(|p| DVec3::from_array(p.map(|n| n as f64))));
            let target = source.transformed(&affine);
            for corner in source.corners().map(|p| p.to_array().map(|x| x as i128)) {
                for i in 0..3 {
                    let exact = (0..3).map(|j| i128::from(m[3 * j + i]) * corner[j]).sum::<i128>()
                        + i128::from(m[9 + i]);
                    prop_assert!(target.min[i].ceil() as i128 <= exact);
                    prop_assert!(exact <= target.max[i].floor() as i128);
                }
            }
        }

        #[test]
        fn unions_and_growth_contain_their_parts(
            a in prop::array::uniform3(whole()),
            b in prop::array::uniform3(whole()),
            by in 0.0..1e6,
        ) {
            let [a, b] = [a, b].map(|p| Aabb::from_points([DVec3::from_array(p.map(|n| n as f64))]));
            let both = a.union(&b);
            prop_assert!(both.contains(&a) && both.contains(&b) && both.overlaps(&a));
            prop_assert!(both.grown(by).contains(&both));
        }

        #[test]
        fn a_box_holds_its_sphere_exactly(center in whole(), radius in whole()) {
            let radius = radius.abs();
            let sphere = Sphere { center: DVec3::splat(center as f64), radius: radius as f64 };
            let bounds = Aabb::from_sphere(&sphere);
            let (center, radius) = (i128::from(center), i128::from(radius));
            prop_assert!(bounds.min.x.ceil() as i128 <= center - radius);
            prop_assert!(center + radius <= bounds.max.x.floor() as i128);
        }
    }
}
