//! A camera on a leash: turned around a point, moved with it, pulled to it and away.
//!
//! The first picture is that of the camera it was made from, roll and all. Turning left and right
//! goes around the world's y axis, up and down around the picture's horizontal; over the poles it
//! does not go. A turn, a shift or a step that would make an impossible camera is not made, so
//! [`Orbit::camera`] cannot fail.
//!
//! Lengths in scene units, world space; distances on the picture as a fraction of its height.

use std::f64::consts::PI;

use cullet::Camera;
use cullet::Projection::{self, OffCentre, Orthographic, Perspective};
use cullet::cull::Aabb;
use cullet::transform::Kind;
use glam::{DAffine3, DMat3, DVec3};

/// What one step of the wheel does to the distance.
const ZOOM_STEP: f64 = 0.9;

/// The nearest that the view axis comes to the poles, radians.
const POLE_GAP: f64 = 0.01;

/// A camera and the point it turns around.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    target: DVec3,
    distance: f64,
    /// Size of the scene, for limits.
    size: f64,
    /// The lens at the distance that it was given for.
    lens: Projection,
    lens_distance: f64,
    camera: Camera,
}

impl Orbit {
    /// Takes over `camera`, to be turned around the point on its axis beside the middle of
    /// `bounds`.
    pub fn new(camera: &Camera, bounds: &Aabb) -> Orbit {
        let half = bounds.half_extent();
        let size = if half.is_finite() && half.max_element() > 0.0 { half.length() } else { 1.0 };
        let along = (camera.eye() - bounds.center()).dot(camera.back());
        let distance = if along.is_finite() && along > 1e-3 * size { along } else { size };
        Orbit {
            target: camera.eye() - camera.back() * distance,
            distance,
            size,
            lens: camera.projection(),
            lens_distance: distance,
            camera: *camera,
        }
    }

    /// The same with a near plane close to the eye, for looking at things from close by.
    #[must_use]
    pub fn with_near_eye(mut self) -> Orbit {
        if let Perspective { near, .. } = &mut self.lens {
            *near = near.min(0.01 * self.distance);
        }
        self.place(self, self.camera.up(), self.camera.back());
        self
    }

    /// The camera.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Follows a pointer that grabbed the scene and went `right` and `down`: a picture height is
    /// half a turn.
    pub fn turn(&mut self, right: f64, down: f64) {
        let around_y = |v| rotated(v, DVec3::Y, -right * PI);
        let [right, up, back] =
            [self.camera.right(), self.camera.up(), self.camera.back()].map(around_y);
        let elevation = libm::asin(back.y.clamp(-1.0, 1.0));
        let limit = elevation.abs().max(0.5 * PI - POLE_GAP);
        let tilt = (elevation + down * PI).clamp(-limit, limit) - elevation;
        self.place(*self, rotated(up, right, -tilt), rotated(back, right, -tilt));
    }

    /// Follows a pointer that grabbed the target and went `right` and `down`.
    pub fn pan(&mut self, right: f64, down: f64) {
        let window = self.camera.window(1.0);
        let scale = match window.kind {
            Kind::Perspective => self.distance,
            Kind::Orthographic => 1.0,
        };
        let height = (window.top - window.bottom) * scale;
        let shift = self.camera.up() * down - self.camera.right() * right;
        let next = Orbit { target: self.target + shift * height, ..*self };
        self.place(next, self.camera.up(), self.camera.back());
    }

    /// Goes towards the target by `steps` of the wheel, or away from it.
    pub fn zoom(&mut self, steps: f64) {
        let factor = libm::pow(ZOOM_STEP, steps);
        let mut next = *self;
        match &mut next.lens {
            Orthographic { height, .. } => *height *= factor,
            OffCentre(window) if window.kind == Kind::Orthographic => {
                for edge in
                    [&mut window.left, &mut window.right, &mut window.bottom, &mut window.top]
                {
                    *edge *= factor;
                }
            }
            Perspective { .. } | OffCentre(_) => {
                let nearest = 1e-5 * self.size.min(self.lens_distance);
                let farthest = 1e3 * self.size.max(self.lens_distance);
                next.distance = (self.distance * factor).clamp(nearest, farthest);
            }
        }
        self.place(next, self.camera.up(), self.camera.back());
    }

    /// Becomes `next` with these axes, if that makes a camera.
    fn place(&mut self, mut next: Orbit, up: DVec3, back: DVec3) {
        let axes = DMat3::from_cols(up.cross(back), up, back);
        let eye = next.target + back * next.distance;
        if let Ok(camera) =
            Camera::from_node(&DAffine3 { matrix3: axes, translation: eye }, next.lens())
        {
            next.camera = camera;
            *self = next;
        }
    }

    /// The lens here: going closer takes the near plane along.
    fn lens(&self) -> Projection {
        let mut lens = self.lens;
        let closer = (self.distance / self.lens_distance).min(1.0);
        match &mut lens {
            Perspective { near, .. } => *near *= closer,
            OffCentre(window) if window.kind == Kind::Perspective => window.near *= closer,
            Orthographic { .. } | OffCentre(_) => {}
        }
        lens
    }
}

/// `v` turned around the unit vector `axis` by `angle`, counter-clockwise seen against the axis
/// (Rodrigues 1840).
fn rotated(v: DVec3, axis: DVec3, angle: f64) -> DVec3 {
    let (sin, cos) = libm::sincos(angle);
    v * cos + axis.cross(v) * sin + axis * (axis.dot(v) * (1.0 - cos))
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: Aabb = Aabb { min: DVec3::splat(-1.0), max: DVec3::ONE };

    fn orbit_from(eye: [f64; 3]) -> Orbit {
        let lens = Perspective { yfov: 0.8, near: 0.5, far: f64::INFINITY };
        let camera = Camera::look_at(eye.into(), DVec3::ZERO, DVec3::Y, lens).unwrap();
        Orbit::new(&camera, &BOUNDS)
    }

    #[track_caller]
    fn check(found: DVec3, expected: [f64; 3]) {
        assert!(
            (found - DVec3::from_array(expected)).length() < 1e-9,
            "{found} is not {expected:?}"
        );
    }

    #[test]
    fn the_first_camera_is_the_given_one() {
        let lens = Perspective { yfov: 0.8, near: 0.5, far: 90.0 };
        let roll = DVec3::new(0.4, 1.0, 0.1);
        let camera = Camera::look_at(DVec3::new(3.0, 1.0, 2.0), DVec3::Y, roll, lens).unwrap();
        assert_eq!(*Orbit::new(&camera, &BOUNDS).camera(), camera);
    }

    #[test]
    fn half_a_height_to_the_right_is_a_quarter_turn() {
        let mut orbit = orbit_from([0.0, 0.0, 4.0]);
        orbit.turn(0.5, 0.0);
        check(orbit.camera().eye(), [-4.0, 0.0, 0.0]);
        check(orbit.camera().right(), [0.0, 0.0, 1.0]);
        orbit.turn(-0.5, 0.25);
        check(orbit.camera().eye(), [0.0, 8.0_f64.sqrt(), 8.0_f64.sqrt()]);
    }

    #[test]
    fn poles_stop_a_turn() {
        let mut orbit = orbit_from([0.0, 0.0, 4.0]);
        for down in [5.0, 0.01, -20.0, -0.01] {
            orbit.turn(0.3, down);
            let camera = orbit.camera();
            assert!(camera.up().y > 0.0 && camera.back().y.abs() < 1.0);
            assert!((camera.eye().length() - 4.0).abs() < 1e-9);
        }
        let mut above = orbit_from([1e-9, 4.0, 0.0]);
        above.turn(0.1, 0.1);
        above.turn(0.0, -0.2);
        assert!((above.camera().eye().length() - 4.0).abs() < 1e-9);
        assert!(above.camera().eye().y < 3.9);
    }

    #[test]
    fn turns_that_come_back_end_where_they_began() {
        let mut orbit = orbit_from([1.0, 2.0, 3.0]);
        for _ in 0..1000 {
            orbit.turn(0.017, 0.0);
            orbit.turn(-0.017, 0.0);
        }
        check(orbit.camera().eye(), [1.0, 2.0, 3.0]);
    }

    #[test]
    fn the_target_stays_under_the_pointer_of_a_pan() {
        let mut orbit = orbit_from([0.0, 0.0, 4.0]);
        orbit.pan(0.25, -0.5);
        let view = cullet::View::new(orbit.camera(), cullet::Viewport::new(400, 200).unwrap());
        let target = view.project(DVec3::ZERO);
        assert!((target.x - 250.0).abs() < 1e-9 && (target.y - 0.0).abs() < 1e-9);
    }

    #[test]
    fn zoom_goes_to_the_target_but_never_through_it() {
        let mut orbit = orbit_from([0.0, 0.0, 4.0]);
        orbit.zoom(1.0);
        check(orbit.camera().eye(), [0.0, 0.0, 3.6]);
        orbit.zoom(1e6);
        assert!(orbit.camera().eye().z > 0.0);
        orbit.zoom(-1e6);
        assert!(orbit.camera().eye().is_finite());
        orbit.zoom(f64::NAN);
        assert!(orbit.camera().eye().is_finite());
    }

    #[test]
    fn near_follows_inwards_only() {
        let near = |orbit: &Orbit| orbit.camera().window(1.0).near;
        let mut orbit = orbit_from([0.0, 0.0, 4.0]);
        orbit.zoom(-3.0);
        assert_eq!(near(&orbit), 0.5);
        orbit.zoom(4.0);
        assert!((near(&orbit) - 0.45).abs() < 1e-9);
        assert!((near(&orbit_from([0.0, 0.0, 4.0]).with_near_eye()) - 0.04).abs() < 1e-9);
    }

    #[test]
    fn an_orthographic_lens_zooms_by_its_height() {
        let lens = Orthographic { height: 2.0, near: 0.0, far: 9.0 };
        let camera = Camera::look_at(DVec3::Z * 4.0, DVec3::ZERO, DVec3::Y, lens).unwrap();
        let mut orbit = Orbit::new(&camera, &BOUNDS);
        orbit.zoom(1.0);
        check(orbit.camera().eye(), [0.0, 0.0, 4.0]);
        assert!(
            matches!(orbit.camera().projection(), Orthographic { height, .. } if height == 1.8)
        );
        orbit.pan(0.0, 0.5);
        check(orbit.camera().eye(), [0.0, 0.9, 4.0]);
    }

    #[test]
    fn scenes_without_size_have_an_orbit_too() {
        let lens = Perspective { yfov: 0.8, near: 0.5, far: f64::INFINITY };
        let camera = Camera::look_at(DVec3::Z, DVec3::ZERO, DVec3::Y, lens).unwrap();
        for bounds in [Aabb::EMPTY, Aabb::NAN, Aabb::INFINITE] {
            let mut orbit = Orbit::new(&camera, &bounds);
            orbit.turn(0.1, 0.1);
            orbit.zoom(3.0);
            orbit.pan(1.0, 1.0);
            assert!(orbit.camera().eye().is_finite());
        }
    }
}
