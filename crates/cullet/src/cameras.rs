//! The cameras of a scene as cameras that can make a picture.

use cullet_scene::{Lens, SceneCamera};
use cullet_transform::{Camera, CameraError, Projection};

/// The camera of a scene, at its node. Pixels are square: the width of the view follows from the
/// picture, whatever aspect ratio or `xmag` the file names.
pub fn camera_of(camera: &SceneCamera) -> Result<Camera, CameraError> {
    let projection = match camera.lens {
        Lens::Perspective { yfov, near, far, .. } => Projection::Perspective { yfov, near, far },
        Lens::Orthographic { ymag, near, far, .. } => {
            Projection::Orthographic { height: 2.0 * ymag, near, far }
        }
    };
    Camera::from_node(&camera.world_from_camera, projection)
}
