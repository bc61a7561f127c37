//! What every test says of every box.

use cullet::cull::{Aabb, Frustum, Sat, Test, Visibility, planes_cutting_coherent, visible};
use cullet::transform::{Plane, PlaneMask};

/// The tests reported, in the order of the ladder.
pub const TESTS: [Test; 6] =
    [Test::Sphere, Test::Corners, Test::PVertex, Test::Reverse, Test::Both, Test::Sat];

/// The verdicts on one box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Verdict {
    /// Bit `t` is set if `TESTS[t]` keeps the box.
    kept: u8,
    /// What becomes of it in the end.
    pub fate: Fate,
}

/// Why a box is seen or not: the first of these that holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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

    /// Lower-case name, for reports.
    pub fn name(self) -> &'static str {
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

impl Verdict {
    /// Asks every test about `bounds`; `sat` is made from `frustum`.
    pub fn on(bounds: &Aabb, frustum: &Frustum, sat: &Sat) -> Verdict {
        let mut kept = 0;
        for (bit, test) in TESTS.iter().enumerate() {
            kept |= u8::from(keeps(*test, bounds, frustum, sat)) << bit;
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
                _ if kept & bit(Test::Reverse) == 0 => Fate::Reverse,
                _ => Fate::Edges,
            },
        };
        Verdict { kept, fate }
    }

    /// Whether `test`, one of [`TESTS`], keeps the box.
    pub fn keeps(self, test: Test) -> bool {
        self.kept & bit(test) != 0
    }

    /// Whether the exact test keeps it.
    pub fn visible(self) -> bool {
        self.keeps(Test::Sat)
    }

    /// The line of `--verdicts`; `camera` is given when there are several.
    pub fn line(self, i: usize, camera: Option<usize>) -> String {
        let class = match self.fate {
            Fate::Invalid => "invalid",
            Fate::Inside => "inside",
            Fate::Crossing => "crossing",
            _ => "outside",
        };
        let camera = camera.map_or(String::new(), |camera| format!(",\"camera\":{camera}"));
        format!(
            "{{\"i\":{i},\"corners\":{},\"p_vertex\":{},\"reverse\":{},\"both\":{},\"sat\":{},\
             \"class\":\"{class}\"{camera}}}\n",
            self.keeps(Test::Corners),
            self.keeps(Test::PVertex),
            self.keeps(Test::Reverse),
            self.keeps(Test::Both),
            self.visible(),
        )
    }
}

/// Whether `test` keeps `bounds`; `sat` is made from `frustum`.
pub fn keeps(test: Test, bounds: &Aabb, frustum: &Frustum, sat: &Sat) -> bool {
    match test {
        Test::Sat => sat.visible(bounds),
        test => visible(test, frustum, bounds),
    }
}

fn bit(test: Test) -> u8 {
    TESTS.iter().position(|known| *known == test).map_or(0, |bit| 1 << bit)
}
