//! The frustum of a matrix, whatever made it.
//!
//! Clip space is bounded by `-w <= x <= w` and so on; each bound is a row of the matrix added
//! to or taken from its last row, and is a plane in the space of the boxes. Mirrored,
//! off-centre, oblique and infinite frusta are nothing special. The matrix is taken at its
//! word: the sum of two rows is kept as an unevaluated sum of two numbers, exact, so
//! that a far plane survives the cancellation in it, and the exact test can be exact.
//!
//! Powers of two are divided out first, so scales from 1e-30 to 1e30 change no bit.
//!
//! Source: Gribb and Hartmann, "Fast Extraction of Viewing Frustum Planes from the
//! World-View-Projection Matrix", 2001.

use core::array::from_fn;

use glam::{DMat4, DVec3, DVec4};

use crate::apex;
use crate::frustum::{AT_INFINITY, bounds_of};
use crate::implied::{self, Row};
use crate::number::{Expansion, Interval, Number};
use crate::rounding::{ROUNDING, two_sum};
use crate::{Frustum, Plane};

/// The index of the near plane; the far plane comes after it, the sides before.
const NEAR: usize = cullet_transform::Plane::Near.index();

/// What a corner of a matrix may be off by at least, relative to its coordinates.
const MATRIX_CORNER: f64 = 8.0 * ROUNDING;

/// What clip-space z means.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DepthRange {
    /// `0 <= z <= w`, near is 0 (Direct3D, Vulkan, Metal).
    ZeroToOne,
    /// `-w <= z <= w`, near is -1 (OpenGL).
    MinusOneToOne,
    /// `0 <= z <= w`, near is 1 (Cullet).
    Reversed,
}

/// Why a matrix has no frustum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrustumError {
    /// An entry is NaN or infinite, or a plane lies farther away than numbers reach.
    NotFinite,
    /// The sides do not meet in one point or direction: rows x, y and w depend on each other, as
    /// far as arithmetic can tell. (Row z may depend on them.)
    Singular,
    /// No point of space is inside, as with a matrix of the opposite sign.
    Empty,
    /// Entries differ so much in size that doubles cannot hold them together, or not tell the corners.
    TooFarApart,
}

impl core::fmt::Display for FrustumError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            FrustumError::NotFinite => {
                "frustum: an entry of the matrix is not finite, or a plane too far away for numbers"
            }
            FrustumError::Singular => {
                "frustum: the matrix has no sides: its rows x, y and w depend on each other"
            }
            FrustumError::Empty => {
                "frustum: the matrix puts no point of space inside: look at its depth range, its sign, \
                 and whether its rows are columns"
            }
            FrustumError::TooFarApart => {
                "frustum: entries of the matrix are too far apart in size: scale it, or count from the eye"
            }
        })
    }
}

impl core::error::Error for FrustumError {}

/// The matrix, times a power of two, and the meaning of its z.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ExactRows {
    clip_from_world: DMat4,
    depth: DepthRange,
}

/// Numbers whose size is zero or within 2^±216: products of four of them, and all that
/// rounding drops from these, stay clear of overflow and underflow.
pub(crate) fn exact_range(x: f64) -> bool {
    const TWO_TO_216: f64 = f64::from_bits((1023 + 216) << 52); // `powi` needs std
    x == 0.0 || (1.0 / TWO_TO_216..=TWO_TO_216).contains(&x.abs())
}

impl ExactRows {
    /// The planes, each coefficient the sum of two entries.
    pub fn planes(&self) -> [Row<Expansion>; 6] {
        self.sums().map(|row| row.map(Expansion::from_sum))
    }

    fn sums(&self) -> [[[f64; 2]; 4]; 6] {
        let [x, y, z, w] = from_fn(|i| self.clip_from_world.row(i));
        let sum = |a: DVec4, b: DVec4| from_fn(|i| [a[i], b[i]]);
        let (from_zero, to_one) = (sum(DVec4::ZERO, z), sum(w, -z));
        let (near, far) = match self.depth {
            DepthRange::ZeroToOne => (from_zero, to_one),
            DepthRange::MinusOneToOne => (sum(w, z), to_one),
            DepthRange::Reversed => (to_one, from_zero),
        };
        [sum(w, x), sum(w, -x), sum(w, y), sum(w, -y), near, far]
    }
}

impl Frustum {
    /// The view volume of a matrix from the space of the boxes to clip space; its origin is
    /// zero. A far plane (or any other) with a zero normal excludes nothing: infinite far; unless its
    /// offset is negative, which excludes everything.
    ///
    /// The matrix need not have an inverse: where rounding has taken the near distance from it, or
    /// z is w or 0 on purpose, near and far exclude what their rows say, and the volume is open
    /// towards the corners that are gone. With parallel sides that is all eight, and then the
    /// reverse test keeps everything.
    ///
    /// Matrices of scenes far from their zero have lost what they have lost; where the eye is
    /// known, [`Frustum::from_camera`] has not.
    pub fn from_matrix(
        clip_from_world: &DMat4,
        depth: DepthRange,
    ) -> Result<Frustum, FrustumError> {
        let entries = clip_from_world.to_cols_array();
        let largest = entries.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        if !clip_from_world.is_finite() {
            return Err(FrustumError::NotFinite);
        }
        if largest == 0.0 {
            return Err(FrustumError::Singular);
        }
        let scaled = scaled(entries, -libm::ilogb(largest))?;
        let exact = ExactRows { clip_from_world: DMat4::from_cols_array(&scaled), depth };

        let mut planes = [AT_INFINITY; 6];
        let mut rows: [Row<Interval>; 6] = from_fn(|_| from_fn(|_| Interval::zero()));
        for (i, sums) in exact.sums().into_iter().enumerate() {
            let sums = Normalized::new(sums, i >= NEAR)?;
            rows[i] = sums.row();
            if let Some(plane) = sums.plane()? {
                planes[i] = plane;
            }
        }

        let exact = scaled.into_iter().all(exact_range).then_some(exact);
        let corners: [Option<Row<Interval>>; 8] = from_fn(|i| implied::corner(&rows, i));
        let corners = match (corners, exact) {
            ([Some(a), Some(b), Some(c), Some(d), Some(e), Some(f), Some(g), Some(h)], _)
                if !apex::is_in_doubt(&[a, b, c, d, e, f, g, h]) =>
            {
                apex::with_a_point([a, b, c, d, e, f, g, h])?
            }
            (_, Some(exact)) => apex::corners(&exact.planes())?,
            (_, None) => return Err(FrustumError::TooFarApart),
        };
        let corners = corners.map(|corner| {
            let (corner, error) = implied::rounded(corner);
            // Room for the rounding of a box that is moved to the origin, too.
            (corner, error.max(MATRIX_CORNER * corner.truncate().abs()))
        });
        let (corners, corner_errors) =
            (corners.map(|(corner, _)| corner), corners.map(|(_, error)| error));
        let terms = planes.map(|(_, terms)| terms);
        let error = |terms: Plane| Plane {
            normal: ROUNDING * terms.normal,
            offset: ROUNDING * terms.offset,
        };
        Ok(Frustum {
            origin: DVec3::ZERO,
            planes: planes.map(|(plane, _)| plane),
            corners,
            terms,
            sway: None,
            bounds: bounds_of(&corners, &corner_errors),
            slack: ROUNDING,
            errors: terms.map(error),
            exact,
        })
    }
}

/// Times a power of two, which must not cost a bit (but may lead to infinity).
fn scaled<const N: usize>(values: [f64; N], exponent: i32) -> Result<[f64; N], FrustumError> {
    let scaled = values.map(|x| libm::scalbn(x, exponent));
    let is_exact = |(x, y): (&f64, &f64)| !y.is_finite() || libm::scalbn(*y, -exponent) == *x;
    let is_exact = values.iter().zip(&scaled).all(is_exact);
    if is_exact { Ok(scaled) } else { Err(FrustumError::TooFarApart) }
}

/// The sums of a plane with the normal's greatest component between 1 and 2.
struct Normalized {
    sums: [[f64; 2]; 4],
    normal_is_zero: bool,
}

impl Normalized {
    /// A plane `of_depth` may be nothing but zeros: then it holds everywhere.
    fn new(mut sums: [[f64; 2]; 4], of_depth: bool) -> Result<Self, FrustumError> {
        let normal = sums.iter().take(3).fold(0.0, |most: f64, [a, b]| most.max((a + b).abs()));
        let [a, b] = sums[3];
        let mut largest = if normal == 0.0 { a + b } else { normal };
        if normal == 0.0 && largest < 0.0 {
            return Err(FrustumError::Empty);
        }
        if largest == 0.0 {
            if !of_depth {
                return Err(FrustumError::Singular);
            }
            (sums[3], largest) = ([1.0, 0.0], 1.0);
        }
        let scale = -libm::ilogb(largest);
        let [x, y, z, w] = sums;
        let sums = [scaled(x, scale)?, scaled(y, scale)?, scaled(z, scale)?, scaled(w, scale)?];
        Ok(Normalized { sums, normal_is_zero: normal == 0.0 })
    }

    /// Correctly rounded, with no more error than that.
    fn row(&self) -> Row<Interval> {
        self.sums.map(|[a, b]| {
            let (value, dropped) = two_sum(a, b);
            Interval { value, error: dropped.abs() }
        })
    }

    /// With unit normal, and its terms; none at infinity.
    fn plane(&self) -> Result<Option<(Plane, Plane)>, FrustumError> {
        if self.normal_is_zero {
            return Ok(None);
        }
        let sum = DVec4::from_array(self.sums.map(|[a, b]| a + b));
        let sizes = DVec4::from_array(self.sums.map(|[a, b]| a.abs() + b.abs()));
        let length = libm::sqrt(sum.truncate().length_squared());
        let scaled = |v: DVec4| Plane { normal: v.truncate() / length, offset: v.w / length };
        let (plane, terms) = (scaled(sum), scaled(sizes));
        let finite = terms.normal.is_finite() && terms.offset.is_finite();
        if finite { Ok(Some((plane, terms))) } else { Err(FrustumError::NotFinite) }
    }
}

#[cfg(test)]
mod tests {
    use cullet_transform::{Kind, Window};
    use glam::DMat3;

    use super::*;
    use crate::{Aabb, PlaneMask, Test, planes_cutting, visible};

    fn window(far: f64) -> Window {
        let (left, right, bottom, top) = (-1.0, 2.0, -0.5, 1.5);
        Window { kind: Kind::Perspective, left, right, bottom, top, near: 0.5, far }
    }

    /// The other depth ranges of a matrix with reversed depth.
    fn with_depth(reversed: &DMat4, depth: DepthRange) -> DMat4 {
        let mut rows = reversed.transpose();
        rows.z_axis = match depth {
            DepthRange::Reversed => rows.z_axis,
            DepthRange::ZeroToOne => rows.w_axis - rows.z_axis,
            DepthRange::MinusOneToOne => rows.w_axis - 2.0 * rows.z_axis,
        };
        rows.transpose()
    }

    #[test]
    fn the_matrix_of_a_window_has_its_planes_and_corners() {
        let depths = [DepthRange::Reversed, DepthRange::ZeroToOne, DepthRange::MinusOneToOne];
        for (far, depth) in [8.0, f64::INFINITY].into_iter().flat_map(|f| depths.map(|d| (f, d))) {
            let expected = Frustum::from_window(DVec3::ZERO, &DMat3::IDENTITY, &window(far));
            let matrix = with_depth(&window(far).clip_from_view(), depth);
            for scale in [1e-30, 1.0, 1e30] {
                let frustum = Frustum::from_matrix(&(matrix * scale), depth).expect("a frustum");
                assert_eq!(frustum.has_far(), far.is_finite());
                for (a, b) in frustum.planes.iter().zip(&expected.planes) {
                    assert!(a.normal.abs_diff_eq(b.normal, 1e-15));
                    assert!(a.offset == b.offset || (a.offset - b.offset).abs() < 1e-13);
                }
                for (a, b) in frustum.corners.iter().zip(expected.corners) {
                    let scale = if a.w == 0.0 {
                        b.truncate().length() / a.truncate().length()
                    } else {
                        1.0
                    };
                    assert!((a.truncate() * scale).abs_diff_eq(b.truncate(), 1e-12) && a.w == b.w);
                }
                assert!(frustum.bounds().grown(1e-9).contains(&expected.bounds()));
            }
        }
    }

    #[test]
    fn worlds_of_any_size_are_alike() {
        let matrix = window(100.0).clip_from_view();
        let verdicts = |size: f64| {
            let world = matrix * DMat4::from_scale(DVec3::splat(1.0 / size));
            let frustum = Frustum::from_matrix(&world, DepthRange::Reversed).expect("a frustum");
            (0..400)
                .map(|i| {
                    let at = DVec3::new(f64::from(i % 20) - 10.0, f64::from(i / 20) - 10.0, -9.0);
                    let bounds = Aabb { min: at * size, max: (at + 0.5) * size };
                    Test::ALL.map(|test| visible(test, &frustum, &bounds))
                })
                .collect::<alloc::vec::Vec<_>>()
        };
        let ordinary = verdicts(1.0);
        assert!(ordinary.iter().any(|v| v[6]) && ordinary.iter().any(|v| !v[6]));
        for size in [1e-30, 1e-20, 1e20, 1e30] {
            assert_eq!(verdicts(size), ordinary, "{size}");
        }
    }

    #[test]
    fn impossible_matrices_are_errors() {
        #[track_caller]
        fn check(matrix: DMat4, expected: FrustumError) {
            let error = Frustum::from_matrix(&matrix, DepthRange::Reversed).unwrap_err();
            assert_eq!(error, expected);
        }
        let good = window(9.0).clip_from_view();
        check(good * f64::NAN, FrustumError::NotFinite);
        check(good * f64::INFINITY, FrustumError::NotFinite);
        check(DMat4::ZERO, FrustumError::Singular);
        check(DMat4::from_diagonal(DVec4::new(1.0, 0.0, 1.0, 1.0)), FrustumError::Singular);
        check(good * DMat4::from_scale(DVec3::new(0.0, 1.0, 1.0)), FrustumError::Singular);
        // x = -w: the left plane is nothing but zeros.
        let mut rows = good.transpose();
        rows.x_axis = -rows.w_axis;
        check(rows.transpose(), FrustumError::Singular);
        // A flat picture of what is not there.
        check(DMat4::from_diagonal(DVec4::new(1.0, 1.0, 0.0, -1.0)), FrustumError::Empty);
        check(good * DMat4::from_scale(DVec3::new(1.0, 1.0, 0.0)), FrustumError::Empty);
        check(-good, FrustumError::Empty);
    }

    fn point(x: f64, y: f64, z: f64) -> Aabb {
        Aabb { min: DVec3::new(x, y, z), max: DVec3::new(x, y, z) }
    }

    #[test]
    fn a_near_distance_that_rounding_took_leaves_a_pyramid() {
        let eye = DVec3::new(300.0, -20.0, 7000.0);
        for depth in [DepthRange::Reversed, DepthRange::ZeroToOne, DepthRange::MinusOneToOne] {
            // What an engine that computes in f32 has left of a near distance of 1e-5, and the
            // sky that it draws with z = w.
            let window = Window { near: 1e-5, ..window(f64::INFINITY) };
            let clip_from_view = with_depth(&window.clip_from_view(), depth).as_mat4();
            let mut matrix =
                (clip_from_view * glam::Mat4::from_translation(-eye.as_vec3())).as_dmat4();
            if depth == DepthRange::Reversed {
                let mut rows = matrix.transpose();
                rows.z_axis = DVec4::ZERO;
                matrix = rows.transpose();
            } else {
                assert_eq!(matrix.row(2), matrix.row(3));
            }
            let frustum = Frustum::from_matrix(&matrix, depth).expect("a frustum");
            assert!(!frustum.has_far());
            for corner in &frustum.corners[..4] {
                // The eye, as far as f32 knows it.
                assert!((corner.truncate() - eye).abs().max_element() < 1e-2 && corner.w == 1.0);
            }
            for (i, corner) in frustum.corners.iter().enumerate().skip(4) {
                let [x, y] = [corner.x / -corner.z, corner.y / -corner.z];
                let edge = |bit: usize, low: f64, high: f64| if i & bit == 0 { low } else { high };
                assert!((x - edge(1, -1.0, 2.0)).abs() < 1e-5 && corner.z < 0.0, "{corner}");
                assert!((y - edge(2, -0.5, 1.5)).abs() < 1e-5 && corner.w == 0.0, "{corner}");
            }
            for (bounds, expected) in [
                (point(eye.x, eye.y, eye.z).grown(1e-2), true),
                (point(eye.x + 15.0, eye.y, eye.z - 10.0), true),
                (point(eye.x + 25.0, eye.y, eye.z - 10.0), false),
                (point(eye.x, eye.y, eye.z + 1e-3), false),
                (point(eye.x, eye.y, eye.z - 1e30), true),
            ] {
                for test in [Test::PVertex, Test::Both, Test::Sat] {
                    assert_eq!(visible(test, &frustum, &bounds), expected, "{bounds:?} {depth:?}");
                }
            }
        }
    }

    #[test]
    fn a_near_distance_below_rounding_is_still_there() {
        // The rows hold it, the corners of the near plane cannot.
        let window = Window { near: 1e-30, ..window(f64::INFINITY) };
        let eye = DVec3::new(300.0, -20.0, 7000.0);
        let matrix = window.clip_from_view() * DMat4::from_translation(-eye);
        let frustum = Frustum::from_matrix(&matrix, DepthRange::Reversed).expect("a frustum");
        assert!(!frustum.has_far());
        assert!(!visible(Test::Sat, &frustum, &point(eye.x, eye.y, eye.z)));
        assert!(visible(Test::Sat, &frustum, &point(eye.x, eye.y, eye.z.next_down())));
    }

    #[test]
    fn a_flat_picture_is_a_prism_without_ends() {
        let flat = DMat4::from_diagonal(DVec4::new(0.5, 0.25, 0.0, 1.0));
        for depth in [DepthRange::ZeroToOne, DepthRange::MinusOneToOne, DepthRange::Reversed] {
            let frustum = Frustum::from_matrix(&flat, depth).expect("a frustum");
            assert!(!frustum.has_far() && frustum.corners.iter().all(|corner| corner.w == -1.0));
            assert_eq!(frustum.bounds(), Aabb::INFINITE);
            for z in [0.0, -1e9, 1e300] {
                assert!(visible(Test::Sat, &frustum, &point(2.0, -4.0, z)));
                assert!(!visible(Test::PVertex, &frustum, &point(2.0_f64.next_up() * 2.0, 0.0, z)));
                assert!(!visible(Test::Sat, &frustum, &point(2.0_f64.next_up(), 0.0, z)));
            }
        }
    }

    #[test]
    fn what_doubles_cannot_hold_together_is_refused() {
        #[track_caller]
        fn check(rows: [[f64; 4]; 4]) {
            let matrix = DMat4::from_cols_array_2d(&rows).transpose();
            let error = Frustum::from_matrix(&matrix, DepthRange::MinusOneToOne).unwrap_err();
            assert_eq!(error, FrustumError::TooFarApart);
        }
        let w = [0.0, 0.0, 0.0, 1.0];
        // The point (-9e289, 1.00000000001, 0) is inside, by what scaling would round away.
        check([[1e-300, 1.0, 0.0, 0.0], [1e-290, 0.0, 0.0, 0.0], [0.0, 0.0, 1e30, 0.0], w]);
        check([[1e-299, 1.0, 0.0, 0.0], [1e-291, 0.0, 0.0, 0.0], [0.0, 0.0, 1e25, 0.0], w]);
    }

    #[test]
    fn corners_in_doubt_are_found_before_a_volume_is_called_empty() {
        for ulps in [1.0, 2.0, 4.0, 8.0, 32.0] {
            let z = [1.0, 0.0, 1.0 - ulps * 0.5 * f64::EPSILON, -1.0];
            let rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], z, [0.0, 0.0, -1.0, 0.0]];
            let matrix = DMat4::from_cols_array_2d(&rows).transpose();
            let frustum = Frustum::from_matrix(&matrix, DepthRange::ZeroToOne).expect("a frustum");
            let inside = |x: f64, y: f64, z: f64| {
                let clip = matrix * DVec3::new(x, y, z).extend(1.0);
                let w = clip.w;
                clip.x.abs() <= w && clip.y.abs() <= w && clip.z >= 0.0 && clip.z <= w
            };
            // From where the near plane has left the right one behind: x = -z up to x = 1 - (1 - d) z.
            let mut n_inside = 0;
            for power in 50..90 {
                let far = libm::scalbn(1.0, power);
                for share in [-1.0, -0.5, 0.0, 0.75] {
                    let (x, y, z) = (far, share * far, -far);
                    if inside(x, y, z) {
                        n_inside += 1;
                        for test in Test::ALL {
                            assert!(
                                visible(test, &frustum, &point(x, y, z)),
                                "{test:?} {ulps} {power}"
                            );
                        }
                    }
                }
            }
            assert!(n_inside > 50, "{ulps}: {n_inside}");
        }
    }

    #[test]
    fn mirrors_and_parallel_lines_are_ordinary() {
        let mirror = DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        let matrix = window(9.0).clip_from_view() * mirror;
        let frustum = Frustum::from_matrix(&matrix, DepthRange::Reversed).expect("a frustum");
        let point = |x: f64| Aabb { min: DVec3::new(x, 0.0, -2.0), max: DVec3::new(x, 0.0, -2.0) };
        assert!(visible(Test::Sat, &frustum, &point(-3.5)));
        assert!(!visible(Test::PVertex, &frustum, &point(3.5)));
        let cube = Frustum::from_matrix(&DMat4::IDENTITY, DepthRange::MinusOneToOne).expect("one");
        assert!(cube.bounds().contains(&Aabb { min: -DVec3::ONE, max: DVec3::ONE }));
        let touching = Aabb { min: DVec3::ONE, max: DVec3::splat(2.0) };
        assert!(visible(Test::Sat, &cube, &touching));
        let apart = Aabb { min: DVec3::ONE.with_x(1.0_f64.next_up()), ..touching };
        assert!(!visible(Test::Sat, &cube, &apart));
        assert!(planes_cutting(&apart, &cube, PlaneMask::ALL).is_some());
    }
}
