//! One camera and one viewport: every matrix of a frame, composed once, in f64.

use glam::{DAffine3, DMat3, DMat4, DVec3};

use crate::{Camera, ClipPoint, ScreenPoint, Viewport, Window};

/// All that is the same for a whole frame.
///
/// World positions enter relative to the eye: a node's translation loses the eye's position
/// before it meets any rotation, so a scene that is moved together with its camera gives the
/// same bits as long as those two sums are exact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    camera: Camera,
    viewport: Viewport,
    view_from_relative: DMat3,
    clip_from_view: DMat4,
}

impl View {
    /// Composes the matrices of a frame.
    pub fn new(camera: &Camera, viewport: Viewport) -> Self {
        let world_from_view = DMat3::from_cols(camera.right(), camera.up(), camera.back());
        View {
            camera: *camera,
            viewport,
            view_from_relative: world_from_view.transpose(),
            clip_from_view: camera.window(viewport.aspect()).clip_from_view(),
        }
    }

    /// This view with the picture moved under its pixels: the centre of each samples what lies
    /// `right` and `down` pixels from there in this one. The eye stays; only the lens shifts, so
    /// pictures a part of a pixel apart differ in where they sample and in nothing else.
    ///
    /// Both finite. A shift of 0 changes no bit of any symmetric lens.
    #[must_use]
    pub fn shifted(&self, right: f64, down: f64) -> View {
        let Window { left, right: end, bottom, top, .. } = self.window();
        let x = (end - left) * (right / f64::from(self.viewport.width()));
        let y = (top - bottom) * (down / f64::from(self.viewport.height()));
        let window = Window {
            left: left + x,
            right: end + x,
            bottom: bottom - y,
            top: top - y,
            ..self.window()
        };
        View::new(&self.camera.through(window), self.viewport)
    }

    /// This view at half its size: pixel (x, y) spans the four pixels from (2 x, 2 y) on. Odd sides
    /// round up, and what the last row or column then spans beyond this picture is in it.
    #[must_use]
    pub fn halved(&self) -> View {
        let (width, height) = (self.viewport.width(), self.viewport.height());
        let viewport = self.viewport.halved();
        let window = self.window();
        let Window { left, right, bottom, top, .. } = window;
        // Exactly 1 for even sides.
        let wider = f64::from(2 * viewport.width()) / f64::from(width);
        let higher = f64::from(2 * viewport.height()) / f64::from(height);
        let window = Window {
            right: if wider == 1.0 { right } else { left + (right - left) * wider },
            bottom: if higher == 1.0 { bottom } else { top - (top - bottom) * higher },
            ..window
        };
        View::new(&self.camera.through(window), viewport)
    }

    /// This view at `factor` times its size, or `None` where that is larger than pictures can be.
    pub fn enlarged(&self, factor: u32) -> Option<View> {
        let sides = (self.viewport.width().checked_mul(factor)?, self.viewport.height());
        let viewport = Viewport::new(sides.0, sides.1.checked_mul(factor)?).ok()?;
        Some(View::new(&self.camera.through(self.window()), viewport))
    }

    /// The camera.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// The picture's sides.
    pub fn viewport(&self) -> Viewport {
        self.viewport
    }

    /// The part of the world in the picture.
    pub fn window(&self) -> Window {
        self.camera.window(self.viewport.aspect())
    }

    /// View space to clip space.
    pub fn clip_from_view(&self) -> &DMat4 {
        &self.clip_from_view
    }

    /// World axes to view axes; a rotation, to be used on directions and on positions relative
    /// to the eye.
    pub fn view_from_relative(&self) -> &DMat3 {
        &self.view_from_relative
    }

    /// `world_from_model` with the eye subtracted: world axes, origin at the eye.
    pub fn relative_from_model(&self, world_from_model: &DAffine3) -> DAffine3 {
        DAffine3 {
            matrix3: world_from_model.matrix3,
            translation: world_from_model.translation - self.camera.eye(),
        }
    }

    /// Model space to view space.
    pub fn view_from_model(&self, world_from_model: &DAffine3) -> DAffine3 {
        DAffine3::from_mat3(self.view_from_relative) * self.relative_from_model(world_from_model)
    }

    /// Model space to clip space.
    pub fn clip_from_model(&self, world_from_model: &DAffine3) -> DMat4 {
        self.clip_from_view * DMat4::from(self.view_from_model(world_from_model))
    }

    /// A world-space point in pixels; see [`ClipPoint::ndc`] for points behind the eye.
    pub fn project(&self, point_world: DVec3) -> ScreenPoint {
        let point_view = self.view_from_relative * (point_world - self.camera.eye());
        let clip = ClipPoint::from_model(&self.clip_from_view, point_view);
        self.viewport.screen_from_ndc(clip.ndc())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Projection, reference};

    fn view(eye: DVec3, target: DVec3) -> View {
        let lens = Projection::Perspective { yfov: 0.9, near: 0.1, far: f64::INFINITY };
        let camera = Camera::look_at(eye, target, DVec3::Y, lens).unwrap();
        View::new(&camera, Viewport::new(1280, 720).unwrap())
    }

    #[test]
    fn the_short_chain_equals_the_long_one() {
        let view = view(DVec3::new(3.0, 2.0, 5.0), DVec3::new(0.1, 0.2, -0.3));
        let model = DAffine3::from_scale_rotation_translation(
            DVec3::new(1.0, 2.0, 0.5),
            glam::DQuat::from_rotation_y(0.7),
            DVec3::new(-0.5, 0.3, 0.2),
        );
        let clip_from_model = view.clip_from_model(&model);
        for i in 0..100 {
            let t = f64::from(i);
            let p = DVec3::new(t * 0.01, 0.5 - t * 0.02, t * 0.015);
            let short = ClipPoint::from_model(&clip_from_model, p);
            let short = view.viewport().screen_from_ndc(short.ndc());
            let long = reference::chain(&view, &model, p).screen;
            assert!((short.x - long.x).abs() < 1e-10 && (short.y - long.y).abs() < 1e-10);
            assert!((short.depth - long.depth).abs() < 1e-14);
        }
    }

    #[test]
    fn moving_scene_and_camera_together_changes_no_bit() {
        let offset = DVec3::new(134217728.0, 0.0, -134217728.0);
        let (eye, target) = (DVec3::new(3.0, 2.0, 5.0), DVec3::new(0.5, 0.25, -0.5));
        let model = DAffine3::from_translation(DVec3::new(0.75, -1.5, 0.125));
        let moved = DAffine3::from_translation(model.translation + offset);
        let (here, there) = (view(eye, target), view(eye + offset, target + offset));
        assert_eq!(here.clip_from_model(&model), there.clip_from_model(&moved));
    }

    #[test]
    fn a_shift_moves_the_picture_and_nothing_else() {
        let straight = view(DVec3::new(3.0, 2.0, 5.0), DVec3::new(0.5, 0.25, -0.5));
        let still = straight.shifted(0.0, 0.0);
        assert_eq!(still.clip_from_view(), straight.clip_from_view());
        let shifted = straight.shifted(0.25, -0.5);
        for i in 0..50 {
            let t = f64::from(i);
            let p = DVec3::new(0.3 - 0.02 * t, 0.01 * t, -0.015 * t);
            let (before, after) = (straight.project(p), shifted.project(p));
            assert!((before.x - after.x - 0.25).abs() < 1e-10);
            assert!((before.y - after.y + 0.5).abs() < 1e-10);
            assert_eq!(before.depth, after.depth);
        }
    }

    #[test]
    fn pixels_of_half_a_view_span_four() {
        let camera = *view(DVec3::new(3.0, 2.0, 5.0), DVec3::ZERO).camera();
        for (width, height) in [(64, 48), (63, 48), (1, 7), (5, 1)] {
            let whole = View::new(&camera, Viewport::new(width, height).unwrap());
            let half = whole.halved();
            let sides = (half.viewport().width(), half.viewport().height());
            assert_eq!(sides, (width.div_ceil(2), height.div_ceil(2)));
            let (whole, half) = (whole.project(DVec3::X), half.project(DVec3::X));
            assert!((whole.x - 2.0 * half.x).abs() < 1e-10 * whole.x.abs().max(1.0));
            assert!((whole.y - 2.0 * half.y).abs() < 1e-10 * whole.y.abs().max(1.0));
        }
    }

    #[test]
    fn a_larger_view_shows_the_same() {
        let view = view(DVec3::new(3.0, 2.0, 5.0), DVec3::ZERO);
        let larger = view.enlarged(4).unwrap();
        assert!((4.0 * view.project(DVec3::X).x - larger.project(DVec3::X).x).abs() < 1e-9);
        assert_eq!(view.enlarged(30), None);
        assert_eq!(view.enlarged(0), None);
    }

    #[test]
    fn the_target_is_in_the_middle() {
        let view = view(DVec3::new(3.0, 2.0, 5.0), DVec3::new(0.5, 0.25, -0.5));
        let p = view.project(DVec3::new(0.5, 0.25, -0.5));
        assert!((p.x - 640.0).abs() < 1e-9 && (p.y - 360.0).abs() < 1e-9);
    }
}
