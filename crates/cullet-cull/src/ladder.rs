//! The tests as a ladder, from the cheapest to the exact one.
//!
//! Every rung keeps all that is visible; a higher rung keeps less of what is not. Rungs
//! differ in what they cost and in what they leave over, and which pays depends on how large
//! boxes are beside the frustum.

use cullet_transform::PlaneMask;

use crate::{Aabb, Frustum, planes_cutting};

/// One way to ask whether a box can be seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Test {
    /// Keeps everything but empty boxes.
    None,
    /// The ball around the box against each plane.
    Sphere,
    /// Rejects a box with all eight corners outside one plane.
    Corners,
    /// Like [`Test::Corners`], by one corner per plane ([`planes_cutting`]).
    PVertex,
    /// Rejects a box with a face that all of the frustum lies beyond.
    Reverse,
    /// [`Test::PVertex`], then [`Test::Reverse`].
    Both,
    /// Exact: separating axes.
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
}

/// What the exact test says of a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Visibility {
    /// Shares no point with the frustum.
    Outside,
    /// Shares a point with it and may reach out of it.
    Crossing,
    /// Lies in it, with all clip coordinates of its points, rounding included.
    Inside,
}

/// Whether `bounds` may be visible in `frustum`, as this test alone says. Both are in one
/// space. NaN: true; empty: false; touching: true.
pub fn visible(test: Test, frustum: &Frustum, bounds: &Aabb) -> bool {
    match test {
        Test::None => !bounds.is_empty(),
        _ => planes_cutting(bounds, frustum, PlaneMask::ALL).is_some(),
    }
}

/// Where `bounds` lies, as exactly as [`Test::Sat`] can say. NaN bounds cross.
pub fn classify(frustum: &Frustum, bounds: &Aabb) -> Visibility {
    if !visible(Test::Sat, frustum, bounds) {
        return Visibility::Outside;
    }
    match planes_cutting(bounds, frustum, PlaneMask::ALL) {
        Some(PlaneMask::NONE) => Visibility::Inside,
        _ => Visibility::Crossing,
    }
}
