//! How wrong: one number per picture, 0 for perfect, smaller is better.

use std::sync::Arc;

use cullet::{Frame, Pass, Passes, Prepared, Renderer, Settings, View};
use cullet_measure::{
    ErrorMap, MeasureError, PIXELS_PER_DEGREE, Picture, flip, ids_differ_ppm, max_abs, split_psnr,
    ssim,
};

use super::reference::Reference;

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Metric {
    /// Mean FLIP.
    Flip,
    /// Root mean square error of the pixels along edges: 10^(-PSNR / 20).
    EdgeRmse,
    /// 1 - SSIM.
    SsimLoss,
    /// Pixels that show another triangle, out of a million.
    IdPpm,
    /// How much a picture twitches while it pans.
    Shimmer,
    /// Objects kept more than those in the view, or fewer, out of a million of the scene.
    FalseVisible,
    /// Mean FLIP against the same picture with a light at a point that does not end.
    LightFlip,
    /// The largest difference from that picture.
    LightMax,
    /// The largest difference from the default's picture.
    DefaultMax,
    /// Largest error of a sine or cosine.
    MaxAbs,
}

impl Metric {
    /// In the table.
    pub const fn name(self) -> &'static str {
        match self {
            Metric::Flip => "flip",
            Metric::EdgeRmse => "edge_rmse",
            Metric::SsimLoss => "ssim_loss",
            Metric::IdPpm => "id_ppm",
            Metric::Shimmer => "shimmer",
            Metric::FalseVisible => "false_visible_ppm",
            Metric::LightFlip => "light_flip",
            Metric::LightMax => "light_max",
            Metric::DefaultMax => "default_max",
            Metric::MaxAbs => "max_abs",
        }
    }

    /// For people.
    pub const fn about(self) -> &'static str {
        match self {
            Metric::Flip => "mean FLIP against the reference picture; 0.01 is hard to see",
            Metric::EdgeRmse => {
                "root mean square error along edges (0 to 1) against the reference picture"
            }
            Metric::SsimLoss => "1 - SSIM against the reference picture",
            Metric::IdPpm => {
                "pixels of a million that show another triangle than the f64 ray caster finds"
            }
            Metric::Shimmer => {
                "mean second difference (0 to 1) of pans of 1 px across and down in steps of 1/16 px; no \
                 reference"
            }
            Metric::FalseVisible => {
                "objects kept more, or fewer, than the exact test keeps, of a million of the scene"
            }
            Metric::LightFlip => "mean FLIP against the same settings with a light that never ends",
            Metric::LightMax => {
                "largest difference of a channel (0 to 1) from the same settings with a light that \
                 never ends"
            }
            Metric::DefaultMax => {
                "largest difference of a channel (0 to 1) from the picture of the default"
            }
            Metric::MaxAbs => "largest absolute error of a sine or cosine, angles to 1e9",
        }
    }
}

/// The errors of one configuration.
#[derive(Default)]
pub struct Errors {
    /// Those that were asked for.
    pub values: Vec<(Metric, f64)>,
    /// FLIP by pixel, where it was asked for.
    pub map: Option<Arc<ErrorMap>>,
}

impl Errors {
    /// The error by `metric`, if it was asked for.
    pub fn get(&self, metric: Metric) -> Option<f64> {
        self.values.iter().find(|(known, _)| *known == metric).map(|(_, error)| *error)
    }
}

/// What is drawn, from where, and by which settings.
pub struct Drawn<'a> {
    pub prepared: &'a Prepared,
    pub view: &'a View,
    pub settings: &'a Settings,
    /// The picture that was measured.
    pub picture: &'a Picture,
    /// Objects that culling kept in it.
    pub n_kept: u64,
}

/// Measures a picture by `metrics`.
pub fn errors(
    drawn: &Drawn<'_>,
    renderer: &mut Renderer,
    reference: &Reference,
    metrics: &[Metric],
) -> Result<Errors, MeasureError> {
    let mut errors = Errors::default();
    let truth = &reference.picture;
    for &metric in metrics {
        let error = match metric {
            Metric::Flip => {
                let map = flip(truth, drawn.picture, PIXELS_PER_DEGREE)?;
                let mean = map.mean();
                errors.map = Some(Arc::new(map));
                mean
            }
            Metric::EdgeRmse => {
                // A picture without edges has no error along them.
                let psnr = split_psnr(truth, drawn.picture)?.edge;
                psnr.map_or(0.0, |psnr| libm::pow(10.0, -psnr / 20.0))
            }
            Metric::SsimLoss => (1.0 - ssim(truth, drawn.picture)?).max(0.0),
            Metric::IdPpm => {
                let passes = Passes::NONE.with(Pass::Triangle);
                let mut frame = Frame::default();
                let settings = Settings { passes, ..*drawn.settings };
                renderer.render(drawn.prepared, drawn.view, &settings, &mut frame);
                ids_differ_ppm(&reference.triangles, &frame.triangle)?
            }
            Metric::Shimmer => shimmer(drawn, renderer),
            Metric::FalseVisible => {
                // One that is lost is no less wrong than one that is kept.
                let n_false = drawn.n_kept.abs_diff(reference.n_visible);
                n_false as f64 / drawn.prepared.items().len().max(1) as f64 * 1e6
            }
            Metric::LightFlip => flip(&reference.lit, drawn.picture, PIXELS_PER_DEGREE)?.mean(),
            Metric::LightMax => max_abs(&reference.lit, drawn.picture)?,
            Metric::DefaultMax => max_abs(&reference.default, drawn.picture)?,
            Metric::MaxAbs => continue, // not of pictures
        };
        errors.values.push((metric, error));
    }
    Ok(errors)
}

/// Steps of a pixel that a pan takes.
const STEPS: u32 = 16;

/// The mean over pixels, channels and steps of `|a - 2 b + c|`, encoded, of three pictures in a row of
/// two pans, across and down. What glides changes evenly and counts little; what jumps counts twice its jump.
fn shimmer(drawn: &Drawn<'_>, renderer: &mut Renderer) -> f64 {
    let settings = Settings { passes: Passes::COLOR, ..*drawn.settings };
    let mut frames = [Frame::default(), Frame::default(), Frame::default()];
    let mut sum = 0_u64;
    for [right, down] in [[1.0, 0.0], [0.0, 1.0]] {
        for step in 0..=STEPS {
            frames.rotate_left(1);
            let way = f64::from(step) / f64::from(STEPS);
            let view = drawn.view.shifted(way * right, way * down);
            renderer.render(drawn.prepared, &view, &settings, &mut frames[2]);
            if step < 2 {
                continue;
            }
            let [a, b, c] = &frames;
            for ((a, b), c) in a.rgba8.iter().zip(&b.rgba8).zip(&c.rgba8) {
                for channel in 0..3 {
                    let bend =
                        i32::from(a[channel]) + i32::from(c[channel]) - 2 * i32::from(b[channel]);
                    sum += u64::from(bend.unsigned_abs());
                }
            }
        }
    }
    let n = 2 * u64::from(STEPS - 1) * 3 * frames[2].len() as u64;
    sum as f64 / n as f64 / 255.0
}

/// An opaque frame as a picture.
pub fn picture(frame: &Frame) -> Result<Picture, MeasureError> {
    let (width, height) = (frame.width as usize, frame.height as usize);
    Picture::from_rgba(width, height, frame.rgba8.as_flattened(), [0.0; 3])
}
