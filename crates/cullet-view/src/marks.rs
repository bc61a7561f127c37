//! What a test makes of every object, and in which colour its box says so.

use cullet::cull::{Aabb, Fate, Frustum, Sat, Test, Verdict};
use cullet::transform::Plane;
use cullet::{Prepared, View};

/// How a box is shown: what becomes of it, or that a test keeps it in vain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Mark {
    /// What the test found agrees with this. Of [`Fate::Reverse`] and [`Fate::Edges`] only the
    /// latter is used, for all that no plane alone rejects.
    Fate(Fate),
    /// Kept, though the exact test rejects it.
    FalseVisible,
}

impl Mark {
    /// Every mark on a box that holds something.
    pub const ALL: [Mark; 10] = [
        Mark::Fate(Fate::Inside),
        Mark::Fate(Fate::Crossing),
        Mark::FalseVisible,
        Mark::Fate(Fate::Plane(Plane::Left)),
        Mark::Fate(Fate::Plane(Plane::Right)),
        Mark::Fate(Fate::Plane(Plane::Bottom)),
        Mark::Fate(Fate::Plane(Plane::Top)),
        Mark::Fate(Fate::Plane(Plane::Near)),
        Mark::Fate(Fate::Plane(Plane::Far)),
        Mark::Fate(Fate::Edges),
    ];

    /// What `test` makes of `bounds`, in the space of the frustum of `sat`.
    pub fn of(test: Test, sat: &Sat, bounds: &Aabb) -> Mark {
        let verdict = Verdict::on(bounds, sat);
        match verdict.fate {
            Fate::Invalid => Mark::Fate(Fate::Crossing),
            kept @ (Fate::Inside | Fate::Crossing | Fate::Empty) => Mark::Fate(kept),
            Fate::Plane(_) | Fate::Reverse | Fate::Edges if verdict.keeps(test) => {
                Mark::FalseVisible
            }
            Fate::Reverse => Mark::Fate(Fate::Edges),
            outside => Mark::Fate(outside),
        }
    }

    /// Whether the test rejects it.
    pub const fn is_outside(self) -> bool {
        matches!(self, Mark::Fate(Fate::Plane(_) | Fate::Reverse | Fate::Edges))
    }

    /// Whether the test keeps it.
    pub const fn is_kept(self) -> bool {
        !self.is_outside() && !matches!(self, Mark::Fate(Fate::Empty))
    }

    /// 0RGB. What is kept is green or yellow, or magenta where that is a mistake; what is
    /// rejected has one hue per plane, from red to brown.
    pub const fn color(self) -> u32 {
        match self {
            Mark::Fate(Fate::Empty) => 0x80_8080,
            Mark::Fate(Fate::Inside) => 0x40_e060,
            Mark::Fate(Fate::Crossing | Fate::Invalid) => 0xff_e640,
            Mark::FalseVisible => 0xff_40ff,
            Mark::Fate(Fate::Plane(plane)) => plane_color(plane),
            Mark::Fate(Fate::Reverse | Fate::Edges) => 0x90_80ff,
        }
    }

    /// In words, for a legend.
    pub const fn name(self) -> &'static str {
        match self {
            Mark::FalseVisible => "false-visible",
            Mark::Fate(Fate::Reverse | Fate::Edges) => "no plane alone",
            Mark::Fate(fate) => fate.name(),
        }
    }
}

/// The hue of what a plane rejects, 0RGB.
pub const fn plane_color(plane: Plane) -> u32 {
    match plane {
        Plane::Left => 0xff_3030,
        Plane::Right => 0xff_8030,
        Plane::Bottom => 0xb8_6040,
        Plane::Top => 0xff_90a0,
        Plane::Near => 0xd0_2068,
        Plane::Far => 0xa0_3030,
    }
}

/// The mark of each object of a scene, in scene order, as `view` sees them.
pub fn marks(prepared: &Prepared, view: &View, test: Test) -> Vec<Mark> {
    let frustum = Frustum::from_camera(view.camera(), view.viewport().aspect()).relative_to_eye();
    let sat = Sat::new(&frustum);
    let items = prepared.items().iter();
    items.map(|item| Mark::of(test, &sat, &item.bounds_from_eye(view))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet::{Camera, Projection};
    use glam::DVec3;
    use std::collections::HashSet;

    /// Looks down -z from the origin, 90 degrees wide and high, from 1 to 10.
    fn frustum() -> Frustum {
        let lens =
            Projection::Perspective { yfov: 0.5 * core::f64::consts::PI, near: 1.0, far: 10.0 };
        let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, lens).unwrap();
        Frustum::from_camera(&camera, 1.0)
    }

    #[track_caller]
    fn check(test: Test, center: [f64; 3], half: f64, expected: Mark) {
        let (center, half) = (DVec3::from_array(center), DVec3::splat(half));
        let bounds = Aabb { min: center - half, max: center + half };
        assert_eq!(Mark::of(test, &Sat::new(&frustum()), &bounds), expected);
    }

    #[test]
    fn boxes_are_named_for_where_they_lie() {
        for test in [Test::Corners, Test::PVertex, Test::Both, Test::Sat] {
            check(test, [0.0, 0.0, -5.0], 1.0, Mark::Fate(Fate::Inside));
            check(test, [5.0, 0.0, -5.0], 1.0, Mark::Fate(Fate::Crossing));
            check(test, [0.0, 0.0, -5.0], 100.0, Mark::Fate(Fate::Crossing));
            check(test, [-9.0, 0.0, -5.0], 1.0, Mark::Fate(Fate::Plane(Plane::Left)));
            check(test, [9.0, 0.0, -5.0], 1.0, Mark::Fate(Fate::Plane(Plane::Right)));
            check(test, [0.0, -9.0, -5.0], 1.0, Mark::Fate(Fate::Plane(Plane::Bottom)));
            check(test, [0.0, 9.0, -5.0], 1.0, Mark::Fate(Fate::Plane(Plane::Top)));
            check(test, [0.0, 0.0, -0.5], 0.25, Mark::Fate(Fate::Plane(Plane::Near)));
            check(test, [0.0, 0.0, -12.0], 1.0, Mark::Fate(Fate::Plane(Plane::Far)));
        }
    }

    #[test]
    fn what_is_drawn_in_vain_is_named() {
        check(Test::None, [0.0, 9.0, -5.0], 1.0, Mark::FalseVisible);
    }

    #[test]
    fn odd_boxes_have_marks() {
        assert_eq!(
            Mark::of(Test::PVertex, &Sat::new(&frustum()), &Aabb::EMPTY),
            Mark::Fate(Fate::Empty)
        );
        assert_eq!(
            Mark::of(Test::PVertex, &Sat::new(&frustum()), &Aabb::NAN),
            Mark::Fate(Fate::Crossing)
        );
    }

    #[test]
    fn no_two_marks_look_alike() {
        let colors: HashSet<u32> = Mark::ALL.iter().map(|mark| mark.color()).collect();
        assert_eq!(colors.len(), Mark::ALL.len());
    }
}
