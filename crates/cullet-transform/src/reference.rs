//! The chain of spaces one step at a time, to read and to compare with.
//!
//! The five steps of a vertex, as the lecture lists them: model to world, world to camera
//! (view), view to clip, the divide, the viewport.

use glam::{DAffine3, DVec3};

use crate::{ClipPoint, NdcPoint, ScreenPoint, View};

/// A vertex in every space.
#[derive(Clone, Copy, Debug)]
pub struct Chain {
    /// World space.
    pub world: DVec3,
    /// View space.
    pub view: DVec3,
    /// Clip space.
    pub clip: ClipPoint,
    /// After the divide.
    pub ndc: NdcPoint,
    /// Pixels.
    pub screen: ScreenPoint,
}

/// Takes a model-space point through all spaces, one after the other, with no matrix composed
/// beforehand. Slower and, far from the origin, less exact than [`View::clip_from_model`].
pub fn chain(view: &View, world_from_model: &DAffine3, point_model: DVec3) -> Chain {
    let camera = view.camera();
    let world = world_from_model.transform_point3(point_model);
    let from_eye = world - camera.eye();
    let in_view = DVec3::new(
        from_eye.dot(camera.right()),
        from_eye.dot(camera.up()),
        from_eye.dot(camera.back()),
    );
    let clip = ClipPoint::from_model(view.clip_from_view(), in_view);
    let ndc = clip.ndc();
    Chain { world, view: in_view, clip, ndc, screen: view.viewport().screen_from_ndc(ndc) }
}
