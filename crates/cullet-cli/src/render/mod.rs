//! `cullet render`: a scene and a camera in, pictures out.

mod args;
pub mod camera;
mod passes;
mod pixels;

pub use args::{RenderArgs, SimdName};

use std::time::{Duration, Instant};

use clap::ValueEnum;
use cpu_time::ProcessTime;
use cullet::{
    Camera, Frame, FrameStats, Pass, Passes, Prepared, Region, Renderer, Settings, View, Viewport,
    legend,
};
use serde_json::{Value, json};

use crate::camera_file::CameraFile;
use crate::exit::Failure;
use crate::message::{Progress, note, warn};
use crate::output::{Outputs, Target};
use crate::picture_file::encode;
use crate::stats::{self, Around, Frames, Report};
use passes::{Bits, PassName, Picture};
use pixels::{Spans, finite_range, pixels};

/// Draws, measures and writes what `args` ask for.
pub fn run(args: &RenderArgs) -> Result<(), Failure> {
    let pictures = passes::plan(args)?;
    let mut settings = args.settings()?;
    settings.passes = pictures.iter().map(Picture::source).collect();
    if args.legend.is_some() {
        settings.passes = settings.passes.with(Pass::Id);
    }
    let mut targets: Vec<Target> = pictures.iter().map(|picture| picture.target.clone()).collect();
    targets.extend(args.legend.iter().chain(&args.stats).map(|path| Target::from(path.as_path())));
    let mut outputs = Outputs::open(&targets)?;

    let start = Instant::now();
    let scene = args.source.load()?;
    let load = start.elapsed();
    let (mut warnings, left_out) = (scene.warnings.clone(), scene.left_out.clone());
    let start = Instant::now();
    let prepared = Prepared::new(scene)?;
    let prepare = start.elapsed();

    let (camera, viewport) = camera::choose(&args.camera, args.size, &prepared)?;
    check_sizes(args, &pictures, &prepared, viewport)?;
    let view = View::new(&camera, viewport);
    let mut frame = Frame::default();
    let frames = draw(args, &prepared, &view, &settings, &mut frame)?;
    if prepared.bounds().is_empty() {
        warnings.push("there is nothing to draw; the picture shows the background".into());
    } else if frames.median.pixels_shaded == 0 {
        warnings.push("nothing is in view; the picture shows the background".into());
    }

    let spans = spans(&pictures, &prepared, &view, &settings, &frame);
    let start = Instant::now();
    for (i, picture) in pictures.iter().enumerate() {
        let file = encode(picture.format, &pixels(picture, &frame, &spans), args.png_compression);
        let file = file.map_err(|e| Failure::output(format!("{}: {e}", picture.target)))?;
        outputs.write(i, &file)?;
    }
    let encode = start.elapsed();
    if args.legend.is_some() {
        outputs.write(pictures.len(), &legend_json(&prepared, &frame))?;
    }
    if args.stats.is_some() {
        let settings = settings_json(args, &camera, viewport);
        let around = Around { load, prepare, encode };
        let report = Report::new(&frames, &around, &warnings, &left_out, settings);
        outputs.write(targets.len() - 1, &stats::json(&report))?;
    }
    outputs.commit()?;
    warn(&warnings);
    if !left_out.is_empty() {
        note(format_args!("left out: {}", left_out.join(", ")));
    }
    explain_depth(&pictures, &spans);
    Ok(())
}

/// Limits that depend on the size of the picture, and a region that must lie in it.
fn check_sizes(
    args: &RenderArgs,
    pictures: &[Picture],
    prepared: &Prepared,
    viewport: Viewport,
) -> Result<(), Failure> {
    let (width, height) = (viewport.width(), viewport.height());
    let region = args.region.unwrap_or(Region { x: 0, y: 0, width, height });
    let ends_within =
        |start: u32, len: u32, side| start.checked_add(len).is_some_and(|end| end <= side);
    if !(ends_within(region.x, region.width, width) && ends_within(region.y, region.height, height))
    {
        return Err(Failure::usage(format!(
            "--region leaves the picture of {width}x{height} pixels"
        )));
    }
    let n_pixels = u64::from(region.width) * u64::from(region.height);
    if n_pixels > args.max_pixels {
        let limit = args.max_pixels;
        return Err(Failure::limit(format!(
            "{n_pixels} pixels exceed the limit of {limit}; --max-pixels raises it, --region draws a part"
        )));
    }
    for Picture { pass, format, bits, target, .. } in pictures {
        let longest = region.width.max(region.height);
        if longest > format.max_side() {
            return Err(Failure::limit(format!(
                "{target}: the format ends at {} pixels per side; write a .png",
                format.max_side()
            )));
        }
        if *pass == PassName::Id && *bits != Bits::F32 && prepared.items().len() >= 1 << 24 {
            return Err(Failure::limit(format!("{target}: more objects than 24 bits can number")));
        }
    }
    Ok(())
}

/// Draws into `frame` as often as asked.
fn draw(
    args: &RenderArgs,
    prepared: &Prepared,
    view: &View,
    settings: &Settings,
    frame: &mut Frame,
) -> Result<Frames, Failure> {
    let _progress = Progress::show("drawing");
    let mut renderer = Renderer::default();
    let mut draw_once = || -> (FrameStats, Option<Duration>) {
        let cpu = ProcessTime::try_now();
        let stats = renderer.render(prepared, view, settings, frame);
        (stats, cpu.and_then(|cpu| cpu.try_elapsed()).ok())
    };
    if args.frames.is_some() {
        draw_once(); // to warm up
    }
    let n = args.frames.map_or(1, |n| n.get());
    let frames = (0..n).map(|_| draw_once()).collect();
    Ok(Frames::of(frames).expect("at least one frame is drawn"))
}

/// What integer pictures span. A region takes the depth of the whole picture for that, or it
/// would be no crop of it.
fn spans(
    pictures: &[Picture],
    prepared: &Prepared,
    view: &View,
    settings: &Settings,
    frame: &Frame,
) -> Spans {
    let asks = |picture: &Picture| picture.pass == PassName::Depth && picture.bits != Bits::F32;
    let depth = if !pictures.iter().any(asks) {
        None
    } else if settings.region.is_none() {
        finite_range(&frame.depth)
    } else {
        let passes = Passes::NONE.with(Pass::Depth);
        let whole = Settings { region: None, passes, ..*settings };
        let mut frame = Frame::default();
        Renderer::default().render(prepared, view, &whole, &mut frame);
        finite_range(&frame.depth)
    };
    Spans { depth, bounds: prepared.bounds() }
}

/// Says what the greys of depth pictures mean.
fn explain_depth(pictures: &[Picture], spans: &Spans) {
    for picture in pictures.iter().filter(|p| p.pass == PassName::Depth && p.bits != Bits::F32) {
        match spans.depth {
            Some((near, far)) => note(format_args!(
                "{}: black is {near}, white is {far} scene units or nothing",
                picture.target
            )),
            None => note(format_args!("{}: white is nothing", picture.target)),
        }
    }
}

fn legend_json(prepared: &Prepared, frame: &Frame) -> Vec<u8> {
    let objects: Vec<Value> = legend(prepared, frame)
        .into_iter()
        .map(|entry| {
            json!({
                "id": entry.object + 1,
                "object": entry.object,
                "name": entry.name,
                "path": entry.path,
                "mesh": entry.mesh,
                "material": entry.material,
                "pixels": entry.n_pixels,
                "bounds": entry.bounds_px,
            })
        })
        .collect();
    let (width, height) = (frame.width, frame.height);
    stats::json(&json!({ "schema": 1, "width": width, "height": height, "objects": objects }))
}

/// Every option in effect.
fn settings_json(args: &RenderArgs, camera: &Camera, viewport: Viewport) -> Value {
    fn name(value: &impl ValueEnum) -> Option<String> {
        value.to_possible_value().map(|value| value.get_name().to_owned())
    }
    let (width, height) = (viewport.width(), viewport.height());
    let Region { x, y, width: w, height: h } =
        args.region.unwrap_or(Region { x: 0, y: 0, width, height });
    json!({
        "scene": args.source.path.to_string_lossy(),
        "output": args.output.to_string_lossy(),
        "camera": args.camera,
        "camera_file": CameraFile::of(camera, width, height),
        "size": [width, height],
        "region": [x, y, w, h],
        "shading": name(&args.shading),
        "background": args.background.to_array(),
        "sun": args.sun.to_array(),
        "ambient": args.ambient,
        "texture": name(&args.texture),
        "aa": name(&args.aa),
        "passes": args.passes.iter().map(name).collect::<Vec<_>>(),
        "bits": args.bits.parse::<u32>().ok(),
        "png_compression": name(&args.png_compression),
        "cull": name(&args.cull),
        "threads": args.threads,
        "renderer": name(&args.renderer),
        "raycast_geometry": name(&args.raycast_geometry),
        "frames": args.frames,
    })
}
