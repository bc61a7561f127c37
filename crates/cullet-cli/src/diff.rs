//! `cullet diff`: how far apart are two pictures?
//!
//! Figures are in the units people expect: `max` and `mae` in 8-bit steps (0 to 255, with
//! fractions for deeper pictures), `changed` in pixels, `psnr` in decibels, `ssim` up to 1,
//! `flip` from 0 to 1. A picture with transparency is compared over black and over white, and
//! the worse figure counts. Floats are taken as linear light and clamped as a screen does.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use cullet_measure::{
    Align, ErrorMap, MeasureError, PIXELS_PER_DEGREE, Picture, Table, changed_pixels, flip,
    heatmap, mae, max_abs, psnr, ssim,
};
use image::{DynamicImage, ImageError, ImageReader, Limits};
use serde_json::{Map, Value, json};

use crate::exit::{Exit, Failure};
use crate::numbers::{self, Number};
use crate::output::{Outputs, Target, print};
use crate::picture_file::{Format, Pixels, PngCompression, Samples, encode};
use crate::stats;

/// Compare two pictures; without thresholds, any difference is exit code 1.
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
    /// Largest difference of any channel, in 8-bit steps
    Max,
    /// Mean absolute difference, in 8-bit steps
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
    let [a, b] = [read(&args.a)?, read(&args.b)?];
    let sizes = [&a, &b].map(|image| [image.width(), image.height()]);
    if sizes[0] != sizes[1] {
        let [[aw, ah], [bw, bh]] = sizes;
        if args.json {
            print(&stats::json(&report(args, sizes, false, Map::new(), &[])))?;
        }
        let (a, b) = (args.a.display(), args.b.display());
        return Err(differs(format!("sizes differ: {a} is {aw}x{ah}, {b} is {bw}x{bh}")));
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
            table.push([metric.name(), format!("{:.6}", value)]);
        }
        print(table.to_string().as_bytes())?;
    }
    match (failures.is_empty(), args.has_thresholds() || equal) {
        (true, true) => Ok(()),
        (true, false) => Err(differs("the pictures differ".into())),
        (false, _) => Err(differs(failures.join("; "))),
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

fn differs(message: String) -> Failure {
    Failure { exit: Exit::Differs, message }
}

fn threshold(text: &str) -> Result<(Metric, f64), String> {
    let (name, value) = text.split_once('=').ok_or("give METRIC=VALUE, like psnr=40")?;
    let metric = Metric::from_str(name.trim(), true)?;
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
        Ok(Pairs { pairs, whole_steps: eight(a) && eight(b) && !transparent })
    }

    /// The worse figure of all backgrounds.
    fn measure(&self, metric: Metric) -> Result<f64, Failure> {
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
            let linear = |p: &image::Rgba<f32>| [0, 1, 2].map(|i| blend(p[i], p[3]));
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
