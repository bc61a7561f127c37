//! Boxes and the frustum they are tested against.

use std::fs;
use std::path::Path;

use cullet::Prepared;
use cullet::cull::{Aabb, DepthRange, Frustum};
use glam::{DMat4, DVec3, DVec4};
use serde::Deserialize;

use super::CullArgs;
use crate::camera_file::CameraFile;
use crate::exit::Failure;
use crate::message::warn;
use crate::numbers::Number;
use crate::render::camera;

/// Aspect ratio of a camera file that names neither a size nor a ratio: that of 1280x720.
const DEFAULT_ASPECT: f64 = 1280.0 / 720.0;

/// The boxes in input order, world space, and the frustum.
pub fn read(args: &CullArgs) -> Result<(Vec<Aabb>, Frustum), Failure> {
    match (&args.source, &args.boxes) {
        (Some(source), _) => {
            let scene = source.load()?;
            warn(&scene.warnings);
            let prepared = Prepared::new(scene).map_err(Failure::limit)?;
            let boxes = prepared.items().iter().map(|item| item.bounds).collect();
            Ok((boxes, frustum(args, Some(&prepared))?))
        }
        (None, Some(path)) => Ok((boxes(path, args.f64)?, frustum(args, None)?)),
        (None, None) => Err(Failure::usage("name a scene, or boxes with --boxes")),
    }
}

fn text(path: &Path) -> Result<String, Failure> {
    let wrong = |problem: &str| Failure::input(format!("{}: {problem}", path.display()));
    let bytes = fs::read(path).map_err(|error| wrong(&format!("cannot be read: {error}")))?;
    String::from_utf8(bytes).map_err(|_| wrong("is not text"))
}

#[derive(Deserialize)]
struct BoxLine {
    min: [Number; 3],
    max: [Number; 3],
}

fn boxes(path: &Path, keep_f64: bool) -> Result<Vec<Aabb>, Failure> {
    let text = text(path)?;
    let lines = text.trim_start_matches('\u{feff}').lines().enumerate();
    let lines = lines.filter(|(_, line)| !line.trim().is_empty());
    let read = |(i, line): (usize, &str)| {
        let BoxLine { min, max } = serde_json::from_str(line).map_err(|error| {
            Failure::input(format!("{}: line {}: {error}", path.display(), i + 1))
        })?;
        let corner = |numbers: [Number; 3]| {
            let value = |Number(n)| if keep_f64 { n } else { f64::from(n as f32) };
            DVec3::from_array(numbers.map(value))
        };
        Ok(Aabb { min: corner(min), max: corner(max) })
    };
    lines.map(read).collect()
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

fn frustum(args: &CullArgs, prepared: Option<&Prepared>) -> Result<Frustum, Failure> {
    if let Some(path) = &args.clip_from_world {
        let wrong = |problem: String| Failure::input(format!("{}: {problem}", path.display()));
        let text = text(path)?;
        let file: MatrixFile =
            serde_json::from_str(&text).map_err(|error| wrong(error.to_string()))?;
        let [x, y, z, w] = file.rows.map(|row| DVec4::from_array(row.map(|Number(n)| n)));
        let depth = match file.depth {
            Depth::ZeroToOne => DepthRange::ZeroToOne,
            Depth::MinusOneToOne => DepthRange::MinusOneToOne,
            Depth::Reversed => DepthRange::Reversed,
        };
        let clip_from_world = DMat4::from_cols(x, y, z, w).transpose();
        return Frustum::from_matrix(&clip_from_world, depth)
            .map_err(|error| wrong(error.to_string()));
    }
    if let Some(prepared) = prepared {
        let (camera, viewport) = camera::choose(&args.camera, None, prepared)?;
        return Ok(Frustum::from_camera(&camera, viewport.aspect()));
    }
    let path = Path::new(&args.camera);
    if args.camera == "auto" {
        return Err(Failure::usage("boxes come without a camera: give --camera FILE.json"));
    }
    let wrong = |problem: String| Failure::input(format!("{}: {problem}", path.display()));
    let file = CameraFile::parse(&text(path)?).map_err(wrong)?;
    let aspect = file.aspect().map_err(wrong)?.unwrap_or(DEFAULT_ASPECT);
    Ok(Frustum::from_camera(&file.camera().map_err(wrong)?, aspect))
}
