//! What every test says of one box, and why it is seen or not.
//!
//! For reports, pictures and debugging; a renderer asks one test.

use cullet_transform::{Plane, PlaneMask};

use crate::{Aabb, Frustum, Sat, Test, Visibility, planes_cutting_coherent, visible};

/// Why a box is seen or not: the first of these that holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fate {
    /// Has a NaN: kept by every test.
    Invalid,
    /// Has a min above its max: holds no point.
    Empty,
    /// Visible, wholly inside.
    Inside,
    /// Visible.
    Crossing,
    /// Outside this plane, the first in order.
    Plane(Plane),
    /// Cut by planes it lies between, but the frustum lies beyond one of its faces.
    Reverse,
    /// Told apart by a pair of edges only.
    Edges,
}

impl Fate {
    /// All of them, in the order of reports.
    pub const ALL: [Fate; 12] = [
        Fate::Inside,
        Fate::Crossing,
        Fate::Plane(Plane::Left),
        Fate::Plane(Plane::Right),
        Fate::Plane(Plane::Bottom),
        Fate::Plane(Plane::Top),
        Fate::Plane(Plane::Near),
        Fate::Plane(Plane::Far),
        Fate::Reverse,
        Fate::Edges,
        Fate::Empty,
        Fate::Invalid,
    ];

    /// Its place in [`Fate::ALL`].
    pub fn index(self) -> usize {
        Fate::ALL.iter().position(|known| *known == self).unwrap_or(0)
    }

    /// Lower-case name, for reports.
    pub const fn name(self) -> &'static str {
        match self {
            Fate::Invalid => "invalid",
            Fate::Empty => "empty",
            Fate::Inside => "inside",
            Fate::Crossing => "crossing",
            Fate::Plane(plane) => plane.name(),
            Fate::Reverse => "reverse",
            Fate::Edges => "sat",
        }
    }
}

/// The verdicts of all tests on one box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Verdict {
    /// One bit per test that keeps the box, in the order of [`Test::ALL`].
    kept: u8,
    /// What becomes of it in the end.
    pub fate: Fate,
}

impl Verdict {
    /// Asks every test about `bounds`, in the space of the frustum that `sat` was made from.
    pub fn on(bounds: &Aabb, sat: &Sat) -> Verdict {
        let frustum = sat.frustum();
        let mut kept = 0;
        for test in Test::ALL {
            kept |= u8::from(keeps(test, bounds, frustum, sat)) << test as u8;
        }
        let mut plane = usize::MAX;
        let cut = planes_cutting_coherent(bounds, frustum, PlaneMask::ALL, &mut plane);
        let fate = match sat.classify(bounds) {
            _ if bounds.is_nan() => Fate::Invalid,
            _ if bounds.is_empty() => Fate::Empty,
            Visibility::Inside => Fate::Inside,
            Visibility::Crossing => Fate::Crossing,
            Visibility::Outside => match Plane::ALL.get(plane) {
                Some(plane) if cut.is_none() => Fate::Plane(*plane),
                _ if kept & 1 << Test::Reverse as u8 == 0 => Fate::Reverse,
                _ => Fate::Edges,
            },
        };
        Verdict { kept, fate }
    }

    /// Whether `test` keeps the box.
    pub fn keeps(self, test: Test) -> bool {
        self.kept & 1 << test as u8 != 0
    }

    /// Whether the exact test keeps it.
    pub fn visible(self) -> bool {
        self.keeps(Test::Sat)
    }
}

fn keeps(test: Test, bounds: &Aabb, frustum: &Frustum, sat: &Sat) -> bool {
    match test {
        Test::Sat => sat.visible(bounds),
        test => visible(test, frustum, bounds),
    }
}

#[cfg(test)]
mod tests {
    use cullet_transform::{Camera, Projection};
    use glam::DVec3;

    use super::*;

    /// Looks down -z from the origin, 90 degrees wide and high, from 1 to 10.
    fn sat() -> Sat {
        let yfov = 0.5 * core::f64::consts::PI;
        let lens = Projection::Perspective { yfov, near: 1.0, far: 10.0 };
        let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, lens).unwrap();
        Sat::new(&Frustum::from_camera(&camera, 1.0))
    }

    #[track_caller]
    fn check(min: [f64; 3], max: [f64; 3], fate: Fate, rejected_by: &[Test]) {
        let bounds = Aabb { min: min.into(), max: max.into() };
        let verdict = Verdict::on(&bounds, &sat());
        assert_eq!(verdict.fate, fate);
        for test in Test::ALL {
            assert_eq!(verdict.keeps(test), !rejected_by.contains(&test), "{test:?}");
        }
        assert_eq!(verdict.visible(), !rejected_by.contains(&Test::Sat));
    }

    #[test]
    fn boxes_are_named_for_where_they_lie() {
        use Test::*;
        check([-1.0, -1.0, -6.0], [1.0, 1.0, -4.0], Fate::Inside, &[]);
        check([4.0, -1.0, -6.0], [6.0, 1.0, -4.0], Fate::Crossing, &[]);
        let planes = [Sphere, Corners, PVertex, Both, Sat];
        check([-9.0, -1.0, -5.0], [-8.0, 0.0, -4.0], Fate::Plane(Plane::Left), &planes);
        // Wide, above where the frustum ends.
        check(
            [-30.0, 11.0, -9.0],
            [30.0, 12.0, -2.0],
            Fate::Plane(Plane::Top),
            &[Corners, PVertex, Reverse, Both, Sat],
        );
        let nan = [f64::NAN; 3];
        check(nan, nan, Fate::Invalid, &[]);
        check([1.0; 3], [-1.0; 3], Fate::Empty, &Test::ALL);
    }

    #[test]
    fn the_last_two_tests_find_what_planes_cannot() {
        // A long thin box past an edge of the frustum: two planes cut it, and it misses both.
        let beside = |x: f64| Aabb {
            min: DVec3::new(x, -100.0, -100.0),
            max: DVec3::new(x + 0.1, 100.0, 100.0),
        };
        let verdict = Verdict::on(&beside(10.5), &sat());
        assert!(verdict.keeps(Test::PVertex) && !verdict.keeps(Test::Both));
        assert_eq!(verdict.fate, Fate::Reverse);
    }

    #[test]
    fn every_fate_has_a_place_and_a_name() {
        for (i, fate) in Fate::ALL.into_iter().enumerate() {
            assert_eq!(fate.index(), i);
            let same = Fate::ALL.iter().filter(|other| other.name() == fate.name());
            assert_eq!(same.count(), 1);
        }
    }
}
