//! `cullet render`: a scene and a camera in, pictures out.

mod args;
pub mod camera;
mod passes;
mod pixels;

pub use args::{RenderArgs, SimdName, level_name, size, tile_size};

use std::time::{Duration, Instant};

use clap::ValueEnum;
use cpu_time::ProcessTime;
use cullet::scene::Images;
use cullet::transform::MAX_SIDE;
use cullet::{
    Camera, Frame, FrameStats, Pass, Passes, Prepared, Region, Renderer, Resolution, Settings,
    View, Viewport, legend,
};
use serde_json::{Value, json};

use crate::camera_file::CameraFile;
use crate::exit::Failure;
use crate::message::{Progress, note, warn};
use crate::numbers::from_f32;
use crate::output::{Outputs, Target, spare_inputs};
use crate::picture_file::encode;
use crate::stats::{self, Around, Frames, Report};
use args::{Antialiasing, ResolutionName};
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
    let camera_file = camera::file(&args.camera);
    let inputs: Vec<_> = camera_file.into_iter().chain([args.source.path.as_path()]).collect();
    spare_inputs(&targets, &inputs)?;
    let mut outputs = Outputs::open(&targets)?;

    let start = Instant::now();
    let (scene, load_times) = args.source.load_to_draw(settings.threads, images(&settings))?;
    let load = start.elapsed();
    let (mut warnings, left_out) = (scene.warnings.clone(), scene.left_out.clone());
    let start = Instant::now();
    let prepared = Prepared::with_threads(scene, settings.threads)?;
    let prepare = start.elapsed();

    let (camera, viewport) = camera::choose(&args.camera, args.size, &prepared)?;
    let region = region(args, viewport)?;
    warnings.extend(check_numbers(&pictures, &prepared)?);
    check_sizes(args, &settings, &pictures, region, viewport)?;
    check_supersampling(&settings, viewport)?;
    let view = View::new(&camera, viewport);
    let mut frame = Frame::default();
    let frames = draw(args, &prepared, &view, &settings, &mut frame)?;
    if prepared.bounds().is_empty() {
        warnings.push("there is nothing to draw; the picture shows the background".into());
    } else if frames.median.pixels_shaded == 0 {
        warnings.push(nothing_shown(&frames.median));
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
        outputs.write(pictures.len(), &legend_json(&prepared, &frame, region))?;
    }
    if args.stats.is_some() {
        let settings = settings_json(args, &settings, &camera, viewport, region);
        let prepare_times = prepared.times();
        let around = Around { load, load_times, prepare, prepare_times, encode };
        let report = Report::new(&frames, &around, &warnings, &left_out, settings);
        outputs.write(targets.len() - 1, &stats::json(&report))?;
    }
    outputs.commit()?;
    warn(&warnings);
    if !left_out.is_empty() {
        note(format_args!("left out: {}", left_out.join(", ")));
    }
    explain_depth(&pictures, &spans);
    // The process is about to end, and the system takes memory back by the page. Freeing a scene of
    // many objects piece by piece would only take longer.
    std::mem::forget(prepared);
    Ok(())
}

/// The images that the passes show: colours, or else only those that cut shapes out.
fn images(settings: &Settings) -> Images {
    let colored = [Pass::Color, Pass::Linear, Pass::Albedo];
    match colored.into_iter().any(|pass| settings.passes.contains(pass)) {
        true => Images::BaseColors,
        false => Images::Masks,
    }
}

/// The part of the picture to draw: all of it, unless an option names one that lies in it.
fn region(args: &RenderArgs, viewport: Viewport) -> Result<Region, Failure> {
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
    Ok(region)
}

/// Pictures of numbers need numbers that fit: 24 bits as integers. Warns of rounded floats.
fn check_numbers(pictures: &[Picture], prepared: &Prepared) -> Result<Option<String>, Failure> {
    let n_triangles: u64 = prepared.items().iter().map(|item| u64::from(item.n_triangles)).sum();
    for Picture { pass, bits, target, .. } in pictures.iter().filter(|p| p.pass.is_number()) {
        let (n, things) = match pass {
            PassName::Triangle => (n_triangles, "triangles"),
            _ => (prepared.items().len() as u64, "objects"),
        };
        if n < 1 << 24 {
            continue;
        }
        if *bits == Bits::F32 {
            return Ok(Some(format!(
                "{target}: the numbers of {n} {things} are rounded above 2^24"
            )));
        }
        let floats = if cfg!(feature = "exr") { ".exr or .f32" } else { ".f32" };
        return Err(Failure::limit(format!(
            "{target}: {n} {things} are more than 24 bits can number; write {floats}"
        )));
    }
    Ok(None)
}

/// Limits that depend on the size of the picture.
fn check_sizes(
    args: &RenderArgs,
    settings: &Settings,
    pictures: &[Picture],
    region: Region,
    viewport: Viewport,
) -> Result<(), Failure> {
    let (n_pixels, remedy) = if pictures.iter().any(spans_depth) {
        let n_pixels = u64::from(viewport.width()) * u64::from(viewport.height());
        (n_pixels, "depth as floats (.exr, .f32) draws no more than its --region")
    } else {
        (u64::from(region.width) * u64::from(region.height), "--region draws a part")
    };
    if n_pixels > args.max_pixels {
        let limit = args.max_pixels;
        return Err(Failure::limit(format!(
            "{n_pixels} pixels exceed the limit of {limit}; --max-pixels raises it, {remedy}"
        )));
    }
    let n_bytes = n_pixels * bytes_per_pixel(settings, pictures, args.legend.is_some());
    if !is_to_be_had(n_bytes) {
        let mebibytes = n_bytes >> 20;
        return Err(Failure::limit(format!(
            "{n_pixels} pixels take {mebibytes} MiB of memory, which the system does not give; \
             make --size smaller, or {remedy}"
        )));
    }
    for Picture { format, target, .. } in pictures {
        let longest = region.width.max(region.height);
        if longest > format.max_side() {
            return Err(Failure::limit(format!(
                "{target}: the format ends at {} pixels per side; write a .png",
                format.max_side()
            )));
        }
    }
    Ok(())
}

/// Supersampling draws a larger picture, which must not be too large itself.
fn check_supersampling(settings: &Settings, viewport: Viewport) -> Result<(), Failure> {
    let (n, longest) = (settings.antialias.per_side(), viewport.width().max(viewport.height()));
    if settings.passes.needs_color() && longest > MAX_SIDE / n {
        return Err(Failure::limit(format!(
            "--aa ssaa{} draws {n} times {longest} pixels along a side, more than {MAX_SIDE}; \
             make --size smaller or choose another --aa",
            n * n
        )));
    }
    Ok(())
}

/// Memory that drawing and writing `pictures` takes, with room to spare.
fn bytes_per_pixel(settings: &Settings, pictures: &[Picture], legend: bool) -> u64 {
    let visibility = 8;
    let legend_ids = if legend { 4 } else { 0 };
    // A frame of floats and a sum in f64, a frame of a quarter of the pixels.
    let sum = if settings.accumulate > 1 { 16 + 32 } else { 0 };
    let half = if settings.resolution == Resolution::Full { 0 } else { 5 };
    let passes = pictures.iter().map(|picture| match picture.source() {
        Pass::Color | Pass::Depth | Pass::Id | Pass::Triangle => 4,
        Pass::Uv => 8,
        Pass::Normal | Pass::Position => 12,
        Pass::Linear | Pass::Albedo => 16,
    });
    // One picture at a time: four samples, what the encoder makes of them, and the file.
    let encoding = pictures.iter().map(|picture| match picture.bits {
        Bits::U8 => 3 * 4,
        Bits::U16 => 3 * 8,
        Bits::F32 => 3 * 16,
    });
    visibility + legend_ids + sum + half + passes.sum::<u64>() + encoding.max().unwrap_or(0)
}

/// Whether the system would give that much memory at once. Asking first beats being aborted.
fn is_to_be_had(n_bytes: u64) -> bool {
    let mut memory = Vec::<u8>::new();
    let given = usize::try_from(n_bytes).is_ok_and(|n| memory.try_reserve_exact(n).is_ok());
    std::hint::black_box(&memory); // or the compiler does not ask
    given
}

/// Why a picture of a scene with something to draw shows none of it.
fn nothing_shown(stats: &FrameStats) -> String {
    let (objects, triangles) = (&stats.objects, &stats.triangles);
    let n_in_view = triangles.n_drawn + triangles.n_facing_away + triangles.n_zero_area;
    let why = if objects.n_drawn == 0 || (n_in_view == 0 && triangles.n_outside > 0) {
        "all objects are outside the view".into()
    } else if triangles.n_drawn == 0 && triangles.n_facing_away > 0 {
        let n = triangles.n_facing_away;
        format!(
            "all {n} triangles in view face away and are single-sided (look from the other side)"
        )
    } else {
        "nothing that can be seen covers a pixel centre".into()
    };
    format!("{why}; the picture shows the background")
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
    let n = args.frames.unwrap_or(1);
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
    let depth = if !pictures.iter().any(spans_depth) {
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

/// Whether the greys of a picture span the distances of the whole picture.
fn spans_depth(picture: &Picture) -> bool {
    picture.pass == PassName::Depth && picture.bits != Bits::F32
}

/// Says what the greys of depth pictures mean.
fn explain_depth(pictures: &[Picture], spans: &Spans) {
    for picture in pictures.iter().filter(|picture| spans_depth(picture)) {
        match spans.depth {
            Some((near, far)) => note(format_args!(
                "{}: black is {near}, white is {far} scene units or nothing",
                picture.target
            )),
            None => note(format_args!("{}: white is nothing", picture.target)),
        }
    }
}

fn legend_json(prepared: &Prepared, frame: &Frame, region: Region) -> Vec<u8> {
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
    stats::json(&json!({
        "schema": 1,
        "width": frame.width,
        "height": frame.height,
        "region": borders(region),
        "objects": objects,
    }))
}

/// As options and JSON spell a region.
fn borders(Region { x, y, width, height }: Region) -> [u32; 4] {
    [x, y, width, height]
}

/// Every option in effect.
fn settings_json(
    args: &RenderArgs,
    settings: &Settings,
    camera: &Camera,
    viewport: Viewport,
    region: Region,
) -> Value {
    fn name(value: &impl ValueEnum) -> Option<String> {
        value.to_possible_value().map(|value| value.get_name().to_owned())
    }
    /// The one of an option's values that means a setting.
    fn name_of<V: ValueEnum, S: PartialEq>(setting: S, of: impl Fn(V) -> S) -> Option<String> {
        name(V::value_variants().iter().find(|value| of((*value).clone()) == setting)?)
    }
    let (width, height) = (viewport.width(), viewport.height());
    let limits = args.source.limits();
    json!({
        "scene": args.source.path.to_string_lossy(),
        "output": args.output.to_string_lossy(),
        "camera": args.camera,
        "camera_file": CameraFile::of(camera, width, height),
        "size": [width, height],
        "region": borders(region),
        "shading": name(&args.shading),
        "background": args.background.to_array().map(from_f32),
        "sun": args.sun.to_array().map(from_f32),
        "ambient": from_f32(args.ambient),
        "point_light": args.point_light.map(|light| json!({
            "position": light.position().to_array(),
            "color": light.color().to_array().map(from_f32),
            "radius": match light.radius().is_finite() {
                true => json!(from_f32(light.radius())),
                false => json!("inf"),
            },
        })),
        "quality": name(&args.quality),
        "texture": name(&args.texture),
        "texture_arithmetic": name(&args.texture_arithmetic),
        "division": name(&args.division),
        "srgb": name(&args.srgb),
        "aa": name_of(settings.antialias, Antialiasing::setting),
        "edge_shading": name(&args.edge_shading),
        "accumulate": settings.accumulate,
        "resolution": name_of(settings.resolution, ResolutionName::setting),
        "shading_rate": name(&args.shading_rate).and_then(|rate| rate.parse::<u32>().ok()),
        "transform": name(&args.transform),
        "subpixel_bits": name(&args.subpixel_bits).and_then(|bits| bits.parse::<u32>().ok()),
        "depth_format": name(&args.depth_format),
        "passes": args.passes.iter().map(name).collect::<Vec<_>>(),
        "bits": args.bits.parse::<u32>().ok(),
        "png_compression": name(&args.png_compression),
        "cull": name(&args.cull),
        "hierarchy": name(&args.hierarchy),
        "min_size": args.min_size,
        "occlusion": name(&args.occlusion),
        "tile_size": args.tile_size,
        "simd": level_name(settings.simd),
        "threads": args.threads,
        "renderer": name(&args.renderer),
        "raycast_geometry": name(&args.raycast_geometry),
        "frames": args.frames,
        "legend": args.legend.as_ref().map(|path| path.to_string_lossy()),
        "stats": args.stats.as_ref().map(|path| path.to_string_lossy()),
        "max_pixels": args.max_pixels,
        "max_file_bytes": limits.max_file_bytes,
        "max_image_pixels": limits.max_image_pixels,
        "max_nodes": limits.max_nodes,
        "max_triangles": limits.max_triangles,
        "max_decoded_bytes": limits.max_decoded_bytes,
    })
}
