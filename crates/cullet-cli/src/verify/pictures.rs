//! What is hashed: the pictures of a scene, from every camera of its own and framed automatically.

use std::path::Path;

use cullet::scene::{LoadOptions, Scene, load, load_glb_bytes, synth::synth, write_glb};
use cullet::{Frame, Prepared, Renderer, Settings, View, Viewport, camera_of, frame_scene};
use sha2::{Digest, Sha256};

use crate::exit::Failure;

/// Size of the pictures: small enough to draw on every instruction set in a moment.
const SIZE: (u32, u32) = (480, 270);

/// The scenes of the folder `scenes/` of the sources. Each is what `synth` makes of its name, byte
/// for byte (a test holds that), so that an installed program brings them along.
pub const SHIPPED: [&str; 6] = ["city", "interior", "knots", "masks", "showpiece", "spheres"];

/// Pictures of a scene, ready to be drawn any number of times.
pub struct Pictures {
    prepared: Prepared,
    views: Vec<View>,
}

impl Pictures {
    /// Of a shipped scene, a computed one (`synth:NAME`) or a file.
    pub fn of(scene: &str) -> Result<Pictures, Failure> {
        let prepared = Prepared::new(find(scene)?)?;
        let viewport = Viewport::new(SIZE.0, SIZE.1)?;
        let own = prepared.scene().cameras.iter().map(camera_of);
        let mut cameras = own
            .collect::<Result<Vec<_>, _>>()
            .map_err(|error| Failure::input(format!("{scene}: {error}")))?;
        cameras.push(frame_scene(&prepared, viewport.aspect()));
        let views = cameras.iter().map(|camera| View::new(camera, viewport)).collect();
        Ok(Pictures { prepared, views })
    }

    /// SHA-256, in hexadecimal, over width and height (32-bit, little-endian) and the RGBA bytes
    /// of one picture after another.
    pub fn hash(&self, settings: &Settings) -> String {
        let (mut renderer, mut frame) = (Renderer::default(), Frame::default());
        let mut hash = Sha256::new();
        for view in &self.views {
            renderer.render(&self.prepared, view, settings, &mut frame);
            hash.update(frame.width.to_le_bytes());
            hash.update(frame.height.to_le_bytes());
            hash.update(frame.rgba8.as_flattened());
        }
        hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

fn find(scene: &str) -> Result<Scene, Failure> {
    let options = LoadOptions::default();
    if SHIPPED.contains(&scene) {
        // By way of a file, as a reader of the folder gets it.
        let file = write_glb(&synth(scene).map_err(Failure::usage)?).map_err(Failure::input)?;
        return Ok(load_glb_bytes(file, scene, &options)?);
    }
    match scene.strip_prefix("synth:") {
        Some(spec) => synth(spec).map_err(Failure::usage),
        None => Ok(load(Path::new(scene), &options)?),
    }
}
