//! `cullet diff`: how far apart are two pictures?
//!
//! Figures are in the units people expect: `max` and `mae` in 8-bit steps (0 to 255, with
//! fractions for deeper pictures), `changed` in pixels, `psnr` in decibels, `ssim` up to 1,
//! `flip` from 0 to 1. A picture with transparency is compared over black and over white, and
//! the worse figure counts.
//!
//! Two pictures of floats hold data: `max`, `mae` and `changed` compare the numbers as they
//! are, alpha included, in their own units, where NaN equals NaN and is infinitely far from
//! everything else. Figures of appearance, and a picture of floats against one of integers,
//! take floats as linear light and clamp them as a screen does; NaN is black.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use cullet_measure::{
    Align, ErrorMap, MeasureError, PIXELS_PER_DEGREE, Picture, Table, changed_pixels, flip,
    heatmap, mae, max_abs, psnr, ssim,
};
use image::{DynamicImage, ImageError, ImageReader, Limits};
use serde_json::{Map, Value, json};

use crate::exit::Failure;
use crate::numbers::{self, Number};
use crate::output::{Outputs, Target, print, spare_inputs};
use crate::picture_file::{Format, Pixels, PngCompression, Samples, encode};
use crate::stats;

/// Compare two pictures; without thresholds, any difference is exit code 1
///
/// Two .exr files are compared as data: `max`, `mae` and `changed` take the floats as they are,
/// alpha included, in the units of the data; NaN equals NaN, and inf equals inf. `psnr`, `ssim`
/// and `flip` compare what a screen shows: linear light, clamped to 0..1. A picture with
/// transparency is compared over black and over white, and the worse figure counts.
#[derive(Args, Clone, Debug)]
pub struct DiffArgs {
    /// The reference
    #[arg(value_name = "A")]
    a: PathBuf,
    /// The picture to judge
    #[arg(value_name = "B")]
    b: PathBuf,
    /// What to measure
    #[arg(long = "metric", value_enum, value_delimiter = ',')]
    #[arg(default_value = "max,mae,changed,psnr,ssim,flip")]
    metrics: Vec<Metric>,
    /// Paint where and how visibly (FLIP) the pictures differ
    #[arg(long, value_name = "OUT")]
    heatmap: Option<PathBuf>,
    /// Exit code 1 when the metric is above the value; may be given several times
    #[arg(long, value_name = "METRIC=VALUE", value_parser = threshold)]
    fail_above: Vec<(Metric, f64)>,
    /// Exit code 1 when the metric is below the value; may be given several times
    #[arg(long, value_name = "METRIC=VALUE", value_parser = threshold)]
    fail_below: Vec<(Metric, f64)>,
    /// Write the figures as JSON
    #[arg(long)]
    json: bool,
}

/// A figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Metric {
    /// Largest difference of any channel, in 8-bit steps; for two .exr in the data's own units
    Max,
    /// Mean absolute difference, in the same units as `max`
    Mae,
    /// Pixels that differ at all
    Changed,
    /// Peak signal-to-noise ratio, dB; inf for equal pictures
    Psnr,
    /// Structural similarity of luma, 1 for equal pictures
    Ssim,
    /// Mean visible difference, 0 to 1
    Flip,
}

/// Measures, prints and judges.
pub fn run(args: &DiffArgs) -> Result<(), Failure> {
    let heatmap = args.heatmap.as_deref().map(heatmap_format).transpose()?;
    if let Some(path) = &args.heatmap {
        spare_inputs(&[Target::from(path.as_path())], &[&args.a, &args.b])?;
    }
    let [a, b] = [read(&args.a)?, read(&args.b)?];
    let sizes = [&a, &b].map(|image| [image.width(), image.height()]);
    if sizes[0] != sizes[1] {
        let [[aw, ah], [bw, bh]] = sizes;
        if args.json {
            print(&stats::json(&report(args, sizes, false, Map::new(), &[])))?;
        }
        let (a, b) = (args.a.display(), args.b.display());
        return Err(Failure::differs(format!("sizes differ: {a} is {aw}x{ah}, {b} is {bw}x{bh}")));
    }
    let pairs = Pairs::new(args, &a, &b)?;
    let mut asked = args.metrics.clone();
    asked.extend(args.fail_above.iter().chain(&args.fail_below).map(|(metric, _)| *metric));
    let mut figures: Vec<(Metric, f64)> = Vec::new();
    for metric in asked {
        if !figures.iter().any(|(known, _)| *known == metric) {
            figures.push((metric, pairs.measure(metric)?));
        }
    }
    let figure =
        |metric| figures.iter().find(|(known, _)| *known == metric).map_or(f64::NAN, |f| f.1);
    let failures = failures(args, figure);

    let equal = pairs.measure(Metric::Changed)? == 0.0;
    if let (Some(format), Some(path)) = (heatmap, &args.heatmap) {
        write_heatmap(&pairs.error_map()?, format, Target::from(path.as_path()))?;
    }
    if args.json {
        let metrics =
            figures.iter().map(|(metric, v)| (metric.name(), json!(Number(*v)))).collect();
        print(&stats::json(&report(args, sizes, equal, metrics, &failures)))?;
    } else {
        let mut table = Table::new(&[("metric", Align::Left), ("value", Align::Right)]);
        for (metric, value) in &figures {
            table.push([metric.name(), figure_text(*value)]);
        }
        print(table.to_string().as_bytes())?;
    }
    match (failures.is_empty(), args.has_thresholds() || equal) {
        (true, true) => Ok(()),
        (true, false) => Err(Failure::differs("the pictures differ")),
        (false, _) => Err(Failure::differs(failures.join("; "))),
    }
}

impl DiffArgs {
    fn has_thresholds(&self) -> bool {
        !(self.fail_above.is_empty() && self.fail_below.is_empty())
    }
}

impl Metric {
    fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }
}

/// Six decimals where they show something.
fn figure_text(value: f64) -> String {
    let plain = value == 0.0 || !value.is_finite() || (1e-3..1e9).contains(&value.abs());
    if plain { format!("{value:.6}") } else { format!("{value:.6e}") }
}

fn threshold(text: &str) -> Result<(Metric, f64), String> {
    let (name, value) = text.split_once('=').ok_or("give METRIC=VALUE, like psnr=40")?;
    let metric = Metric::from_str(name.trim(), true).map_err(|_| {
        let names: Vec<_> = Metric::value_variants().iter().map(|metric| metric.name()).collect();
        format!("there is no metric `{}`; choose from {}", name.trim(), names.join(", "))
    })?;
    let value = numbers::parse(value).filter(|value| !value.is_nan());
    Ok((metric, value.ok_or("the value is not a number")?))
}

/// One sentence per threshold that does not hold; NaN holds none.
fn failures(args: &DiffArgs, figure: impl Fn(Metric) -> f64) -> Vec<String> {
    let above = args.fail_above.iter().map(|(metric, limit)| {
        let value = figure(*metric);
        (value <= *limit).then_some(()).ok_or(format!("{} {value} is above {limit}", metric.name()))
    });
    let below = args.fail_below.iter().map(|(metric, limit)| {
        let value = figure(*metric);
        (value >= *limit).then_some(()).ok_or(format!("{} {value} is below {limit}", metric.name()))
    });
    above.chain(below).filter_map(Result::err).collect()
}

fn report(
    args: &DiffArgs,
    [a, b]: [[u32; 2]; 2],
    equal: bool,
    metrics: Map<String, Value>,
    failures: &[String],
) -> Value {
    let picture = |path: &Path, [width, height]: [u32; 2]| json!({ "path": path.to_string_lossy(), "width": width, "height": height });
    let passed = a == b && failures.is_empty() && (equal || args.has_thresholds());
    json!({
        "schema": 1,
        "version": env!("CARGO_PKG_VERSION"),
        "a": picture(&args.a, a),
        "b": picture(&args.b, b),
        "equal": equal,
        "metrics": metrics,
        "failures": failures,
        "passed": passed,
    })
}

fn read(path: &Path) -> Result<DynamicImage, Failure> {
    let shown = path.display();
    if path == Path::new("-") {
        return Err(Failure::usage("pictures are not read from standard input; name two files"));
    }
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    match extension.to_str() {
        Some("f32") => {
            return Err(Failure::input(format!(
                "{shown}: raw floats do not say their size; render to .exr, which holds the same \
                 floats, or compare .png, .jpg, .webp or .ppm"
            )));
        }
        Some("glb" | "gltf" | "obj") => {
            return Err(Failure::input(format!(
                "{shown}: is a scene; draw it first: cullet render {shown} -o FILE.png"
            )));
        }
        _ => {}
    }
    let unreadable =
        |error: std::io::Error| Failure::input(format!("{shown}: cannot be read: {error}"));
    let mut reader =
        ImageReader::open(path).and_then(ImageReader::with_guessed_format).map_err(unreadable)?;
    let mut limits = Limits::default();
    limits.max_alloc = Some(1 << 34); // the largest picture a render makes, with room
    reader.limits(limits);
    reader.decode().map_err(|error| match error {
        ImageError::Limits(error) => {
            Failure::limit(format!("{shown}: {error}; no option raises this"))
        }
        error => Failure::input(format!("{shown}: {error}")),
    })
}

/// The two pictures over each background that matters.
struct Pairs {
    pairs: Vec<[Picture; 2]>,
    /// Both have 8 bits and no blending took place, so steps are whole.
    whole_steps: bool,
    /// How far the numbers differ, when both hold floats.
    data: Option<DataError>,
}

impl Pairs {
    fn new(args: &DiffArgs, a: &DynamicImage, b: &DynamicImage) -> Result<Pairs, Failure> {
        let transparent = has_transparency(a) || has_transparency(b);
        let backgrounds: &[f32] = if transparent { &[0.0, 1.0] } else { &[0.0] };
        let over = |path: &Path, image, background| {
            over(image, background).map_err(|e| Failure::input(format!("{}: {e}", path.display())))
        };
        let mut pairs = Vec::new();
        for background in backgrounds {
            pairs.push([over(&args.a, a, *background)?, over(&args.b, b, *background)?]);
        }
        let eight = |image: &DynamicImage| {
            let color = image.color();
            color.bytes_per_pixel() == color.channel_count()
        };
        let data = (is_float(a) && is_float(b)).then(|| DataError::between(a, b));
        Ok(Pairs { pairs, whole_steps: eight(a) && eight(b) && !transparent, data })
    }

    /// The worse figure of all backgrounds.
    fn measure(&self, metric: Metric) -> Result<f64, Failure> {
        match (metric, &self.data) {
            (Metric::Max, Some(data)) => return Ok(data.max),
            (Metric::Mae, Some(data)) => return Ok(data.mae),
            (Metric::Changed, Some(data)) => return Ok(data.n_changed as f64),
            _ => {}
        }
        let figures = self.pairs.iter().map(|[a, b]| match metric {
            Metric::Max if self.whole_steps => max_abs(a, b).map(|v| (v * 255.0).round()),
            Metric::Max => max_abs(a, b).map(|v| v * 255.0),
            Metric::Mae => mae(a, b).map(|v| v * 255.0),
            Metric::Changed => changed_pixels(a, b, 0.0).map(|n| n as f64),
            Metric::Psnr => psnr(a, b),
            Metric::Ssim => ssim(a, b),
            Metric::Flip => flip(a, b, PIXELS_PER_DEGREE).map(|map| map.mean()),
        });
        let figures: Result<Vec<f64>, MeasureError> = figures.collect();
        let worse = match metric {
            Metric::Psnr | Metric::Ssim => f64::min,
            _ => f64::max,
        };
        let figures = figures.map_err(Failure::input)?;
        Ok(figures.into_iter().reduce(worse).unwrap_or(f64::NAN))
    }

    /// Visible errors, over the background that shows more of them.
    fn error_map(&self) -> Result<ErrorMap, Failure> {
        let maps = self.pairs.iter().map(|[a, b]| flip(a, b, PIXELS_PER_DEGREE));
        let maps: Vec<ErrorMap> = maps.collect::<Result<_, _>>().map_err(Failure::input)?;
        let worst = maps.into_iter().max_by(|a, b| a.mean().total_cmp(&b.mean()));
        worst.ok_or_else(|| Failure::input("there are no pixels"))
    }
}

/// How far the floats of two pictures differ, in their own units.
struct DataError {
    max: f64,
    mae: f64,
    /// Pixels with any difference.
    n_changed: usize,
}

impl DataError {
    /// Compares colour, and alpha where one has it; the sizes are the same.
    fn between(a: &DynamicImage, b: &DynamicImage) -> DataError {
        let channels = if a.color().has_alpha() || b.color().has_alpha() { 4 } else { 3 };
        let (a, b) = (a.to_rgba32f(), b.to_rgba32f());
        let (mut max, mut sum, mut n_changed) = (0.0f64, 0.0, 0);
        for (a, b) in a.pixels().zip(b.pixels()) {
            let distances: [f64; 4] = std::array::from_fn(|i| distance(a[i], b[i]));
            max = distances.into_iter().fold(max, f64::max);
            sum += distances.iter().sum::<f64>();
            n_changed += usize::from(distances != [0.0; 4]);
        }
        let n = a.pixels().len() * channels;
        DataError { max, mae: sum / n as f64, n_changed }
    }
}

/// Between two numbers; infinite when just one is NaN.
fn distance(a: f32, b: f32) -> f64 {
    if a == b || (a.is_nan() && b.is_nan()) {
        return 0.0; // also inf and inf, whose difference is NaN
    }
    let distance = (f64::from(a) - f64::from(b)).abs();
    if distance.is_nan() { f64::INFINITY } else { distance }
}

fn is_float(image: &DynamicImage) -> bool {
    matches!(image, DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_))
}

fn has_transparency(image: &DynamicImage) -> bool {
    image.color().has_alpha()
        && match image {
            DynamicImage::ImageRgba32F(image) => image.pixels().any(|pixel| pixel[3] != 1.0),
            _ => image.to_rgba16().pixels().any(|pixel| pixel[3] != u16::MAX),
        }
}

/// The picture over an even grey, 0 or 1.
fn over(image: &DynamicImage, background: f32) -> Result<Picture, MeasureError> {
    let (width, height) = (image.width() as usize, image.height() as usize);
    match image {
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
            let image = image.to_rgba32f();
            let blend = |c: f32, alpha: f32| {
                if alpha == 1.0 { c } else { c * alpha + background * (1.0 - alpha) }
            };
            let shown = |c: f32| if c.is_nan() { 0.0 } else { c };
            let linear = |p: &image::Rgba<f32>| [0, 1, 2].map(|i| shown(blend(p[i], p[3])));
            let pixels: Vec<[f32; 3]> = image.pixels().map(linear).collect();
            Picture::from_linear(width, height, &pixels)
        }
        DynamicImage::ImageLuma8(_)
        | DynamicImage::ImageLumaA8(_)
        | DynamicImage::ImageRgb8(_)
        | DynamicImage::ImageRgba8(_) => {
            Picture::from_rgba(width, height, &image.to_rgba8(), [background; 3])
        }
        _ => Picture::from_rgba(width, height, &image.to_rgba16(), [background; 3]),
    }
}

fn heatmap_format(path: &Path) -> Result<Format, Failure> {
    if Target::from(path) == Target::Stdout {
        return Err(Failure::usage("the figures go to standard output; name a file for --heatmap"));
    }
    let format = Format::of(path).filter(|format| !format.is_float());
    format.ok_or_else(|| {
        Failure::usage(format!("{}: use .png, .jpg, .webp or .ppm for --heatmap", path.display()))
    })
}

fn write_heatmap(map: &ErrorMap, format: Format, target: Target) -> Result<(), Failure> {
    let samples = Samples::U8(heatmap(map, 1.0));
    let (width, height) = (map.width as u32, map.height as u32);
    let pixels = Pixels { width, height, channels: 3, samples };
    let mut outputs = Outputs::open(std::slice::from_ref(&target))?;
    let file = encode(format, &pixels, PngCompression::Default);
    outputs.write(0, &file.map_err(|error| Failure::output(format!("{target}: {error}")))?)?;
    outputs.commit()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn args(above: &[(Metric, f64)], below: &[(Metric, f64)]) -> DiffArgs {
        DiffArgs {
            a: "a".into(),
            b: "b".into(),
            metrics: Vec::new(),
            heatmap: None,
            fail_above: above.to_vec(),
            fail_below: below.to_vec(),
            json: false,
        }
    }

    #[test]
    fn thresholds_hold_at_their_value_and_never_for_nan() {
        let check = |args: &DiffArgs, value| failures(args, |_| value).is_empty();
        let above = args(&[(Metric::Max, 2.0)], &[]);
        assert!(check(&above, 2.0) && !check(&above, 2.1) && !check(&above, f64::NAN));
        let below = args(&[], &[(Metric::Psnr, 40.0)]);
        assert!(check(&below, 40.0) && check(&below, f64::INFINITY));
        assert!(!check(&below, 39.9) && !check(&below, f64::NAN));
    }

    #[test]
    fn thresholds_are_parsed() {
        assert_eq!(threshold("PSNR=4e1"), Ok((Metric::Psnr, 40.0)));
        assert_eq!(threshold("max=inf"), Ok((Metric::Max, f64::INFINITY)));
        for text in ["max", "max=", "max=nan", "size=1", "=1"] {
            assert!(threshold(text).is_err(), "{text}");
        }
    }

    #[test]
    fn unknown_metrics_name_the_known_ones() {
        let message = threshold("foo=1").unwrap_err();
        assert!(message.contains("max, mae, changed, psnr, ssim, flip"), "{message}");
    }

    #[test]
    fn floats_are_compared_as_they_are() {
        let image = |rgb: [f32; 3]| {
            DynamicImage::ImageRgb32F(image::Rgb32FImage::from_raw(1, 1, rgb.to_vec()).unwrap())
        };
        #[track_caller]
        fn check(a: DynamicImage, b: DynamicImage, [max, mae, changed]: [f64; 3]) {
            let pairs = Pairs::new(&args(&[], &[]), &a, &b).unwrap();
            let found = [Metric::Max, Metric::Mae, Metric::Changed];
            let found = found.map(|metric| pairs.measure(metric).unwrap());
            assert_eq!(found, [max, mae, changed]);
            assert!(!pairs.measure(Metric::Psnr).unwrap().is_nan());
        }
        let (inf, nan) = (f32::INFINITY, f32::NAN);
        check(image([inf, nan, -inf]), image([inf, nan, -inf]), [0.0, 0.0, 0.0]);
        check(image([2.0, 0.0, 0.0]), image([5.0, 0.0, 0.0]), [3.0, 1.0, 1.0]);
        check(image([-1.0, 0.0, 0.0]), image([-1.0, 0.0, -3.0]), [3.0, 1.0, 1.0]);
        for (a, b) in [(inf, 1.0), (nan, 1.0), (inf, -inf), (nan, inf)] {
            let (a, b) = (image([a, 0.0, 0.0]), image([b, 0.0, 0.0]));
            check(a, b, [f64::INFINITY, f64::INFINITY, 1.0]);
        }
        let rgba = image::Rgba32FImage::from_raw(1, 1, vec![2.0, 0.0, 0.0, 0.0]).unwrap();
        let rgba = DynamicImage::ImageRgba32F(rgba);
        check(image([2.0, 0.0, 0.0]), rgba, [1.0, 0.25, 1.0]);
    }

    #[test]
    fn small_figures_do_not_look_like_none() {
        let texts = [0.0, 1e-7, 0.5, 2e12, f64::INFINITY].map(figure_text);
        assert_eq!(texts, ["0.000000", "1.000000e-7", "0.500000", "2.000000e12", "inf"]);
    }

    #[test]
    fn transparent_pictures_are_compared_over_black_and_white() {
        let image = |rgba: [u8; 4]| {
            DynamicImage::ImageRgba8(image::RgbaImage::from_raw(1, 1, rgba.to_vec()).unwrap())
        };
        let args = args(&[], &[]);
        let max =
            |a, b| Pairs::new(&args, &image(a), &image(b)).unwrap().measure(Metric::Max).unwrap();
        assert_eq!(max([0, 0, 0, 0], [0, 0, 0, 255]), 255.0); // equal over black
        assert_eq!(max([255, 255, 255, 0], [255, 255, 255, 255]), 255.0); // equal over white
        assert_eq!(max([9, 9, 9, 0], [7, 7, 7, 0]), 0.0); // nobody sees it
        assert_eq!(max([9, 9, 9, 255], [7, 7, 7, 255]), 2.0);
    }
}
