//! Boxes, and the frusta they are tested against.

use std::fs;
use std::io::{Read, stdin};
use std::path::Path;

use cullet::cull::{Aabb, DepthRange, Frustum};
use cullet::scene::Images;
use cullet::{Camera, Prepared, Viewport};
use glam::{DMat4, DVec3, DVec4};
use serde::Deserialize;
use serde_json::Value;

use super::CullArgs;
use super::path::{self, CameraPath, dolly, orbit};
use crate::camera_file::CameraFile;
use crate::exit::Failure;
use crate::message::warn;
use crate::numbers::Number;
use crate::render::camera;

/// Aspect ratio of a camera file that names neither a size nor a ratio: that of 1280x720.
const DEFAULT_ASPECT: f64 = 1280.0 / 720.0;

/// What is measured.
pub struct Input {
    /// In input order, world space.
    pub boxes: Vec<Aabb>,
    /// At least one.
    pub shots: Vec<Shot>,
    /// The scene that the boxes are of, if they are of one.
    pub prepared: Option<Prepared>,
}

/// One frustum.
pub struct Shot {
    /// World space.
    pub frustum: Frustum,
    /// What it was made from, unless that was a matrix.
    pub camera: Option<Camera>,
    /// The picture it would make, where there is something to draw.
    pub viewport: Option<Viewport>,
}

/// Everything that `args` name.
pub fn read(args: &CullArgs) -> Result<Input, Failure> {
    match (args.source(), &args.boxes) {
        (Some(source), _) => {
            let (scene, _) = source.load_to_draw(0, Images::BaseColors)?;
            warn(&scene.warnings);
            let prepared = Prepared::new(scene)?;
            let boxes: Vec<Aabb> = prepared.items().iter().map(|item| item.bounds).collect();
            let shots = shots(args, &boxes, Some(&prepared))?;
            Ok(Input { boxes, shots, prepared: Some(prepared) })
        }
        (None, Some(path)) => {
            let boxes = self::boxes(path, args.f64)?;
            let shots = shots(args, &boxes, None)?;
            Ok(Input { boxes, shots, prepared: None })
        }
        (None, None) => Err(Failure::usage("name a scene, or boxes with --boxes")),
    }
}

fn text(path: &Path) -> Result<String, Failure> {
    let unreadable = |error| wrong(path, format!("cannot be read: {error}"));
    utf8(path, fs::read(path).map_err(unreadable)?)
}

fn utf8(path: &Path, bytes: Vec<u8>) -> Result<String, Failure> {
    let text = String::from_utf8(bytes).map_err(|_| wrong(path, "is not text"))?;
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}

fn wrong(path: &Path, problem: impl std::fmt::Display) -> Failure {
    Failure::input(format!("{}: {problem}", path.display()))
}

#[derive(Deserialize)]
struct BoxLine {
    min: [Number; 3],
    max: [Number; 3],
}

/// Of a file, or of standard input for `-`.
fn boxes(path: &Path, keep_f64: bool) -> Result<Vec<Aabb>, Failure> {
    let (path, text) = if path == Path::new("-") {
        let path = Path::new("standard input");
        let mut bytes = Vec::new();
        let read = stdin().lock().read_to_end(&mut bytes);
        read.map_err(|error| wrong(path, format!("cannot be read: {error}")))?;
        (path, utf8(path, bytes)?)
    } else {
        (path, text(path)?)
    };
    let lines = text.lines().enumerate();
    let lines = lines.filter(|(_, line)| !line.trim().is_empty());
    let read = |(i, line): (usize, &str)| {
        let BoxLine { min, max } = serde_json::from_str(line).map_err(|error| {
            // Each line is a text of its own for the parser, which counts from its start.
            let error = error.to_string().replace(" at line 1 column ", ", column ");
            let hint = "a box is {\"min\":[x,y,z],\"max\":[x,y,z]}; what JSON has no number for is a \
                        string: \"inf\", \"-inf\", \"nan\"";
            wrong(path, format!("line {}: {error}; {hint}", i + 1))
        })?;
        let corner = |numbers: [Number; 3]| {
            let value = |Number(n)| if keep_f64 { n } else { f64::from(n as f32) };
            DVec3::from_array(numbers.map(value))
        };
        Ok(Aabb { min: corner(min), max: corner(max) })
    };
    lines.map(read).collect()
}

/// The frusta: of a matrix, of the one camera, or of those of the path.
fn shots(
    args: &CullArgs,
    boxes: &[Aabb],
    prepared: Option<&Prepared>,
) -> Result<Vec<Shot>, Failure> {
    if let Some(path) = &args.clip_from_world {
        return Ok(vec![Shot { frustum: matrix(path)?, camera: None, viewport: None }]);
    }
    if let Some(CameraPath::File(path)) = &args.path {
        return cameras(path)?
            .iter()
            .enumerate()
            .map(|(i, file)| {
                let wrong = |problem| wrong(path, format!("camera {i}: {problem}"));
                let camera = file.camera().map_err(wrong)?;
                let size = args.size.or(file.size().map_err(wrong)?);
                let aspect = match args.size {
                    Some(_) => None,
                    None => file.aspect().map_err(wrong)?,
                };
                shot(camera, size, aspect, prepared.is_some())
            })
            .collect();
    }
    let (camera, size, aspect) = base(args, prepared)?;
    let bounds = || {
        let finite = boxes.iter().filter(|b| b.min.is_finite() && b.max.is_finite());
        finite.fold(Aabb::EMPTY, |all, bounds| all.union(bounds))
    };
    let camera = match args.camera.as_str() {
        "auto" if args.path.is_some() => path::close_up(&camera, &bounds()),
        _ => camera,
    };
    let cameras = match args.path {
        Some(CameraPath::Orbit { n, distance }) => orbit(&camera, path::middle(boxes), n, distance),
        Some(CameraPath::Dolly { n }) => dolly(&camera, &bounds(), n),
        _ => vec![camera],
    };
    let wanted = args.path.as_ref().map_or(1, CameraPath::len);
    if cameras.len() < wanted {
        return Err(Failure::usage(format!(
            "only {} of {wanted} cameras of this path are possible: stay nearer to the origin",
            cameras.len()
        )));
    }
    cameras.into_iter().map(|camera| shot(camera, size, aspect, prepared.is_some())).collect()
}

/// A camera with the size or else the aspect ratio of its picture; `draws` when there will be one.
fn shot(
    camera: Camera,
    size: Option<(u32, u32)>,
    aspect: Option<f64>,
    draws: bool,
) -> Result<Shot, Failure> {
    let (width, height) = size.unwrap_or(camera::DEFAULT_SIZE);
    let viewport = Viewport::new(width, height)?;
    // What is drawn and what is culled must be one view.
    let aspect = match aspect {
        Some(aspect) if size.is_none() && !draws => aspect,
        None if size.is_none() && !draws => DEFAULT_ASPECT,
        _ => viewport.aspect(),
    };
    let frustum = Frustum::from_camera(&camera, aspect);
    Ok(Shot { frustum, camera: Some(camera), viewport: draws.then_some(viewport) })
}

type Base = (Camera, Option<(u32, u32)>, Option<f64>);

/// The camera that `--camera` means, and the size or ratio of its picture.
fn base(args: &CullArgs, prepared: Option<&Prepared>) -> Result<Base, Failure> {
    if let Some(prepared) = prepared {
        let (camera, viewport) = camera::choose(&args.camera, args.size, prepared)?;
        return Ok((camera, Some((viewport.width(), viewport.height())), None));
    }
    if args.camera == "auto" {
        return Err(Failure::usage("boxes come without a camera: give --camera FILE.json"));
    }
    let path = camera::file(&args.camera).ok_or_else(|| {
        let camera = &args.camera;
        Failure::usage(format!("boxes have no camera `{camera}`: give a camera file (.json)"))
    })?;
    let wrong = |problem| wrong(path, problem);
    let file = CameraFile::parse(&text(path)?).map_err(wrong)?;
    let aspect = file.aspect().map_err(wrong)?;
    Ok((file.camera().map_err(wrong)?, args.size, aspect))
}

/// A list of cameras, or an object that has one under `cameras`.
fn cameras(path: &Path) -> Result<Vec<CameraFile>, Failure> {
    let mut value: Value =
        serde_json::from_str(&text(path)?).map_err(|error| wrong(path, error))?;
    if value.get("cameras").is_some() {
        value = value["cameras"].take();
    }
    let Value::Array(cameras) = value else {
        return Err(wrong(path, "holds no list of cameras"));
    };
    if cameras.is_empty() {
        return Err(wrong(path, "the list of cameras is empty"));
    }
    let parse = |(i, camera): (usize, &Value)| {
        CameraFile::parse(&camera.to_string())
            .map_err(|problem| wrong(path, format!("camera {i}: {problem}")))
    };
    cameras.iter().enumerate().map(parse).collect()
}

#[derive(Deserialize)]
struct MatrixFile {
    rows: [[Number; 4]; 4],
    depth: Depth,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Depth {
    ZeroToOne,
    MinusOneToOne,
    Reversed,
}

fn matrix(path: &Path) -> Result<Frustum, Failure> {
    let text = text(path)?;
    let file: MatrixFile = serde_json::from_str(&text).map_err(|error| {
        let asked = r#"{"rows": four lists of four numbers, "depth": "zero-to-one", "minus-one-to-one" or "reversed"}"#;
        wrong(path, format!("{error}; a matrix is {asked}"))
    })?;
    let [x, y, z, w] = file.rows.map(|row| DVec4::from_array(row.map(|Number(n)| n)));
    let depth = match file.depth {
        Depth::ZeroToOne => DepthRange::ZeroToOne,
        Depth::MinusOneToOne => DepthRange::MinusOneToOne,
        Depth::Reversed => DepthRange::Reversed,
    };
    let clip_from_world = DMat4::from_cols(x, y, z, w).transpose();
    Frustum::from_matrix(&clip_from_world, depth).map_err(|error| wrong(path, error))
}
