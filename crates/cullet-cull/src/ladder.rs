//! The tests as a ladder, from the cheapest to the exact one.
//!
//! Every rung keeps all that is visible. Of what is not, planes keep less from rung to rung (none,
//! sphere, corners, p-vertex; up to rounding); the reverse test is no higher rung but another ladder: it
//! rejects large boxes that planes keep, and keeps most of what they reject. Both together keep less
//! than either, and the exact test nothing. Which pays depends on how large boxes are beside the
//! frustum: [`Ladder`] asks any choice of them in turn, and counts if asked
//! to.

use alloc::vec::Vec;

use cullet_transform::PlaneMask;

use crate::{
    Aabb, Frustum, Sat, Sphere, corners_visible, p_vertex_visible, planes_cutting_coherent,
    reverse_visible, sphere_visible,
};

/// One way to ask whether a box can be seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Test {
    /// Keeps everything but empty boxes.
    None,
    /// The ball around the box against each plane ([`sphere_visible`]).
    Sphere,
    /// Rejects a box with all eight corners outside one plane ([`corners_visible`]).
    Corners,
    /// Like [`Test::Corners`], by one corner per plane ([`p_vertex_visible`]).
    PVertex,
    /// Rejects a box with a face that all of the frustum lies beyond ([`reverse_visible`]).
    Reverse,
    /// [`Test::PVertex`], then [`Test::Reverse`].
    Both,
    /// Exact: separating axes ([`Sat`]).
    Sat,
}

impl Test {
    /// All of them, in the order of the ladder.
    pub const ALL: [Test; 7] = [
        Test::None,
        Test::Sphere,
        Test::Corners,
        Test::PVertex,
        Test::Reverse,
        Test::Both,
        Test::Sat,
    ];

    /// Lower-case name with underscores, for tables.
    pub const fn name(self) -> &'static str {
        ["none", "sphere", "corners", "p_vertex", "reverse", "both", "sat"][self as usize]
    }
}

/// What the exact test says of a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Visibility {
    /// Shares no point with the frustum.
    Outside,
    /// Shares a point with it and may reach out of it.
    Crossing,
    /// Lies in it with all its points, by [`ROUNDING`](crate::ROUNDING) (or the outset of the
    /// frustum) of the sizes of the terms of each distance: enough for the clip coordinates of
    /// these points to round as they like.
    Inside,
}

/// Whether `bounds` may be visible in `frustum`, as this test alone says. Both are in one
/// space. NaN: true; empty: false; touching: true.
///
/// For many boxes and [`Test::Sat`] prepare a [`Sat`] or a [`Ladder`].
pub fn visible(test: Test, frustum: &Frustum, bounds: &Aabb) -> bool {
    match test {
        Test::None => !bounds.is_empty(),
        Test::Sphere => sphere_visible(&Sphere::around(bounds), frustum),
        Test::Corners => corners_visible(bounds, frustum),
        Test::PVertex => p_vertex_visible(bounds, frustum),
        Test::Reverse => reverse_visible(bounds, frustum),
        Test::Both => {
            visible(Test::PVertex, frustum, bounds) && visible(Test::Reverse, frustum, bounds)
        }
        Test::Sat => visible(Test::Both, frustum, bounds) && Sat::new(frustum).visible(bounds),
    }
}

/// Where `bounds` lies, by [`Sat`]. NaN bounds cross.
pub fn classify(frustum: &Frustum, bounds: &Aabb) -> Visibility {
    Sat::new(frustum).classify(bounds)
}

/// A frustum and the tests to ask of it, in order, until one rejects.
///
/// ```
/// use cullet_cull::{Aabb, CullStats, Frustum, Ladder, Test};
/// # use cullet_transform::{Camera, Projection};
/// # use glam::DVec3;
/// # let lens = Projection::Perspective { yfov: 1.0, near: 0.1, far: 100.0 };
/// # let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, lens)?;
/// let frustum = Frustum::from_camera(&camera, 1.0);
/// let ladder = Ladder::new(&frustum, &[Test::PVertex, Test::Reverse]);
/// let behind = Aabb { min: DVec3::splat(1.0), max: DVec3::splat(2.0) };
/// let mut stats = CullStats::default();
/// assert!(ladder.visible(&Aabb::INFINITE, &mut stats));
/// assert!(!ladder.visible(&behind, &mut stats));
/// let planes = stats.tests[Test::PVertex as usize];
/// assert_eq!((planes.n_in, planes.n_out), (1, 1));
/// # Ok::<(), cullet_transform::CameraError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Ladder {
    frustum: Frustum,
    tests: Vec<Test>,
    sat: Option<Sat>,
}

impl Ladder {
    /// Prepares what `tests` need.
    pub fn new(frustum: &Frustum, tests: &[Test]) -> Ladder {
        let sat = tests.contains(&Test::Sat).then(|| Sat::new(frustum));
        Ladder { frustum: *frustum, tests: tests.to_vec(), sat }
    }

    /// Whether all tests keep `bounds`. `()` counts nothing and costs nothing.
    pub fn visible(&self, bounds: &Aabb, count: &mut impl Count) -> bool {
        self.tests.iter().all(|&test| {
            let keep = self.ask(test, bounds, count);
            count.asked(test, keep);
            keep
        })
    }

    fn ask(&self, test: Test, bounds: &Aabb, count: &mut impl Count) -> bool {
        match (test, &self.sat) {
            (Test::Sat, Some(sat)) => sat.visible(bounds),
            (Test::PVertex | Test::Both, _) => {
                let mut plane = usize::MAX;
                let frustum = &self.frustum;
                let cut = planes_cutting_coherent(bounds, frustum, PlaneMask::ALL, &mut plane);
                if cut.is_none() {
                    count.rejected_by(plane);
                }
                cut.is_some() && (test == Test::PVertex || reverse_visible(bounds, frustum))
            }
            _ => visible(test, &self.frustum, bounds),
        }
    }
}

/// Something that watches a [`Ladder`].
pub trait Count {
    /// `test` was asked and kept the box or rejected it.
    fn asked(&mut self, test: Test, kept: bool);
    /// Plane `index` rejected a box; an empty box is rejected by none (an index above 5).
    fn rejected_by(&mut self, index: usize);
}

/// Counts nothing.
impl Count for () {
    fn asked(&mut self, _: Test, _: bool) {}
    fn rejected_by(&mut self, _: usize) {}
}

/// How many boxes a test was asked about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct InOut {
    /// Kept: may be visible.
    pub n_in: u64,
    /// Rejected.
    pub n_out: u64,
}

/// Boxes per test and rejections per plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CullStats {
    /// In the order of [`Test::ALL`].
    pub tests: [InOut; 7],
    /// Boxes the p-vertex test rejected by each plane, in the order of `PlaneMask`.
    pub planes: [u64; 6],
}

impl Count for CullStats {
    fn asked(&mut self, test: Test, kept: bool) {
        let InOut { n_in, n_out } = &mut self.tests[test as usize];
        *if kept { n_in } else { n_out } += 1;
    }

    fn rejected_by(&mut self, index: usize) {
        if let Some(n) = self.planes.get_mut(index) {
            *n += 1;
        }
    }
}

impl core::ops::AddAssign for CullStats {
    fn add_assign(&mut self, other: CullStats) {
        for (mine, theirs) in self.tests.iter_mut().zip(other.tests) {
            mine.n_in += theirs.n_in;
            mine.n_out += theirs.n_out;
        }
        for (mine, theirs) in self.planes.iter_mut().zip(other.planes) {
            *mine += theirs;
        }
    }
}

#[cfg(test)]
mod tests {
    use cullet_transform::{Kind, Window};
    use glam::{DMat3, DVec3};

    use super::*;

    fn pyramid() -> Frustum {
        let window = Window {
            kind: Kind::Perspective,
            left: -1.0,
            right: 1.0,
            bottom: -1.0,
            top: 1.0,
            near: 1.0,
            far: 100.0,
        };
        Frustum::from_window(DVec3::ZERO, &DMat3::IDENTITY, &window)
    }

    fn aabb(min: [f64; 3], max: [f64; 3]) -> Aabb {
        Aabb { min: min.into(), max: max.into() }
    }

    /// The verdicts of the ladder, `+` for kept.
    #[track_caller]
    fn check(bounds: Aabb, expected: &str) {
        let keeps = |&test: &Test| visible(test, &pyramid(), &bounds);
        let verdicts: alloc::string::String =
            Test::ALL.iter().map(|test| if keeps(test) { '+' } else { '.' }).collect();
        assert_eq!(verdicts, expected);
    }

    #[test]
    fn each_test_rejects_what_it_can() {
        check(aabb([-1.0, -1.0, -9.0], [1.0, 1.0, -8.0]), "+++++++");
        check(aabb([50.0, -1.0, -9.0], [51.0, 1.0, -8.0]), "+...+..");
        // A corner in the ball, none in the box.
        check(aabb([12.0, -9.0, -10.0], [30.0, 9.0, -9.0]), "++..+..");
        // Behind the far plane's middle, cut by no plane alone.
        check(aabb([101.0, -1.0, -300.0], [500.0, 1.0, 300.0]), "++++...");
    }

    #[test]
    fn bad_boxes_have_one_verdict() {
        check(Aabb::NAN, "+++++++");
        check(Aabb::EMPTY, ".......");
        check(Aabb::INFINITE, "+++++++");
        assert_eq!(classify(&pyramid(), &Aabb::NAN), Visibility::Crossing);
        assert_eq!(classify(&pyramid(), &Aabb::EMPTY), Visibility::Outside);
    }

    #[test]
    fn counters_know_test_and_plane() {
        let ladder = Ladder::new(&pyramid(), &[Test::PVertex, Test::Sat]);
        let mut stats = CullStats::default();
        assert!(!ladder.visible(&aabb([50.0, -1.0, -9.0], [51.0, 1.0, -8.0]), &mut stats));
        assert!(!ladder.visible(&aabb([101.0, -1.0, -300.0], [500.0, 1.0, 300.0]), &mut stats));
        assert!(!ladder.visible(&Aabb::EMPTY, &mut stats));
        assert!(ladder.visible(&Aabb::INFINITE, &mut stats));
        assert!(ladder.visible(&Aabb::INFINITE, &mut ()));
        assert_eq!(stats.planes, [0, 1, 0, 0, 0, 0]);
        assert_eq!(stats.tests[Test::PVertex as usize], InOut { n_in: 2, n_out: 2 });
        assert_eq!(stats.tests[Test::Sat as usize], InOut { n_in: 1, n_out: 1 });
        let mut twice = stats;
        twice += stats;
        assert_eq!(twice.planes[1], 2);
    }
}
