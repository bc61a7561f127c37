//! What a test says of every object, and in which colour its box says so.

use cullet::cull::{Aabb, Frustum, Test, Visibility, classify, visible};
use cullet::transform::Plane;
use cullet::{Prepared, View};

/// What becomes of a box, and whether rightly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// Holds nothing.
    Empty,
    /// Kept, and wholly in the frustum.
    Inside,
    /// Kept, and partly in the frustum.
    Crossing,
    /// Rejected, and outside of this plane alone already.
    OutsidePlane(Plane),
    /// Rejected, though no plane alone would do.
    Outside,
    /// Kept, though the exact test rejects it.
    FalseVisible,
}

impl Verdict {
    /// Every verdict on a box that holds something.
    pub const ALL: [Verdict; 10] = [
        Verdict::Inside,
        Verdict::Crossing,
        Verdict::FalseVisible,
        Verdict::OutsidePlane(Plane::Left),
        Verdict::OutsidePlane(Plane::Right),
        Verdict::OutsidePlane(Plane::Bottom),
        Verdict::OutsidePlane(Plane::Top),
        Verdict::OutsidePlane(Plane::Near),
        Verdict::OutsidePlane(Plane::Far),
        Verdict::Outside,
    ];

    /// What `test` makes of `bounds`, judged by the exact test.
    pub fn of(test: Test, frustum: &Frustum, bounds: &Aabb) -> Verdict {
        if bounds.is_empty() {
            return Verdict::Empty;
        }
        match (visible(test, frustum, bounds), classify(frustum, bounds)) {
            (_, Visibility::Inside) => Verdict::Inside,
            (_, Visibility::Crossing) => Verdict::Crossing,
            (true, Visibility::Outside) => Verdict::FalseVisible,
            (false, Visibility::Outside) => {
                let rejects = |plane: &Plane| frustum.farthest(plane.index(), bounds) < 0.0;
                let plane = Plane::ALL.into_iter().find(rejects);
                plane.map_or(Verdict::Outside, Verdict::OutsidePlane)
            }
        }
    }

    /// 0RGB. What is kept is green or yellow, or magenta where that is a mistake; what is
    /// rejected has one hue per plane, from red to brown.
    pub const fn color(self) -> u32 {
        match self {
            Verdict::Empty => 0x80_8080,
            Verdict::Inside => 0x40_e060,
            Verdict::Crossing => 0xff_e640,
            Verdict::FalseVisible => 0xff_40ff,
            Verdict::OutsidePlane(plane) => plane_color(plane),
            Verdict::Outside => 0x90_80ff,
        }
    }

    /// In words, for a legend.
    pub const fn name(self) -> &'static str {
        match self {
            Verdict::Empty => "empty",
            Verdict::Inside => "inside",
            Verdict::Crossing => "crossing",
            Verdict::FalseVisible => "false-visible",
            Verdict::OutsidePlane(plane) => plane.name(),
            Verdict::Outside => "no plane alone",
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

/// The verdict on each object of a scene, in scene order, as `view` sees them.
pub fn verdicts(prepared: &Prepared, view: &View, test: Test) -> Vec<Verdict> {
    let frustum = Frustum::from_camera(view.camera(), view.viewport().aspect()).relative_to_eye();
    let items = prepared.items().iter();
    items.map(|item| Verdict::of(test, &frustum, &item.bounds_from_eye(view))).collect()
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
    fn check(test: Test, center: [f64; 3], half: f64, expected: Verdict) {
        let (center, half) = (DVec3::from_array(center), DVec3::splat(half));
        let bounds = Aabb { min: center - half, max: center + half };
        assert_eq!(Verdict::of(test, &frustum(), &bounds), expected);
    }

    #[test]
    fn boxes_are_named_for_where_they_lie() {
        for test in [Test::Corners, Test::PVertex, Test::Both, Test::Sat] {
            check(test, [0.0, 0.0, -5.0], 1.0, Verdict::Inside);
            check(test, [5.0, 0.0, -5.0], 1.0, Verdict::Crossing);
            check(test, [0.0, 0.0, -5.0], 100.0, Verdict::Crossing);
            check(test, [-9.0, 0.0, -5.0], 1.0, Verdict::OutsidePlane(Plane::Left));
            check(test, [9.0, 0.0, -5.0], 1.0, Verdict::OutsidePlane(Plane::Right));
            check(test, [0.0, -9.0, -5.0], 1.0, Verdict::OutsidePlane(Plane::Bottom));
            check(test, [0.0, 9.0, -5.0], 1.0, Verdict::OutsidePlane(Plane::Top));
            check(test, [0.0, 0.0, -0.5], 0.25, Verdict::OutsidePlane(Plane::Near));
            check(test, [0.0, 0.0, -12.0], 1.0, Verdict::OutsidePlane(Plane::Far));
        }
    }

    #[test]
    fn what_is_drawn_in_vain_is_named() {
        check(Test::None, [0.0, 9.0, -5.0], 1.0, Verdict::FalseVisible);
    }

    #[test]
    fn odd_boxes_have_verdicts() {
        assert_eq!(Verdict::of(Test::PVertex, &frustum(), &Aabb::EMPTY), Verdict::Empty);
        assert_eq!(Verdict::of(Test::PVertex, &frustum(), &Aabb::NAN), Verdict::Crossing);
    }

    #[test]
    fn no_two_verdicts_look_alike() {
        let colors: HashSet<u32> = Verdict::ALL.iter().map(|verdict| verdict.color()).collect();
        assert_eq!(colors.len(), Verdict::ALL.len());
    }
}
