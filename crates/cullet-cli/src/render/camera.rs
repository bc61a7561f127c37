//! Which camera does `--camera` mean, and how large is its picture?

use std::fs;
use std::path::Path;

use cullet::scene::{Scene, SceneCamera};
use cullet::{Camera, Prepared, Viewport, camera_of, frame_scene};

use crate::camera_file::CameraFile;
use crate::exit::Failure;

/// Size of a picture when nothing names one.
pub const DEFAULT_SIZE: (u32, u32) = (1280, 720);

/// The camera that `spec` means, and its picture: `size` wins over that of a camera file.
pub fn choose(
    spec: &str,
    size: Option<(u32, u32)>,
    prepared: &Prepared,
) -> Result<(Camera, Viewport), Failure> {
    let viewport = |size: Option<(u32, u32)>| {
        let (width, height) = size.unwrap_or(DEFAULT_SIZE);
        Viewport::new(width, height).map_err(Failure::from)
    };
    if spec == "auto" {
        let viewport = viewport(size)?;
        return Ok((frame_scene(prepared, viewport.aspect()), viewport));
    }
    if let Some(camera) = find(spec, prepared.scene()) {
        return Ok((from_scene(camera)?, viewport(size)?));
    }
    if let Some(path) = file(spec) {
        let wrong = |problem: String| Failure::input(format!("{spec}: {problem}"));
        let text = fs::read(path).map_err(|error| wrong(format!("cannot be read: {error}")))?;
        let text = String::from_utf8(text).map_err(|_| wrong("is not text".into()))?;
        let file = CameraFile::parse(&text).map_err(wrong)?;
        let camera = file.camera().map_err(wrong)?;
        return Ok((camera, viewport(size.or(file.size().map_err(wrong)?))?));
    }
    Err(Failure::usage(missing(spec, prepared.scene())))
}

/// The camera file that `spec` can only mean when no camera of the scene has that name.
pub fn file(spec: &str) -> Option<&Path> {
    let path = Path::new(spec);
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json")).then_some(path)
}

/// The camera of that index or else that name.
fn find<'a>(spec: &str, scene: &'a Scene) -> Option<&'a SceneCamera> {
    match spec.parse::<usize>() {
        Ok(index) if index < scene.cameras.len() => scene.cameras.get(index),
        _ => scene.cameras.iter().find(|camera| camera.name == spec),
    }
}

fn missing(spec: &str, scene: &Scene) -> String {
    let names = scene.cameras.iter().enumerate().take(20);
    let names: Vec<_> = names.map(|(i, camera)| format!("{i} `{}`", camera.name)).collect();
    let known = match names.len() {
        0 => "the scene has none; give `auto` or a camera file (.json)".into(),
        _ => format!("the scene has {}: {}", scene.cameras.len(), names.join(", ")),
    };
    format!("there is no camera `{spec}`: {known}")
}

fn from_scene(camera: &SceneCamera) -> Result<Camera, Failure> {
    camera_of(camera)
        .map_err(|error| Failure::input(format!("camera `{}` of the scene: {error}", camera.name)))
}
