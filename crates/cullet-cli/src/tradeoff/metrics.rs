//! How wrong: one number per picture, 0 for perfect, smaller is better.

use std::sync::Arc;

use cullet::{Frame, Pass, Passes, Prepared, Renderer, Settings, View};
use cullet_measure::{
    ErrorMap, MeasureError, PIXELS_PER_DEGREE, Perceived, Picture, ids_differ_ppm, max_abs,
    split_psnr, ssim,
};

use super::reference::Reference;

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Metric {
    /// Mean FLIP.
    Flip,
    /// Root mean square error of the pixels along edges: 10^(-PSNR / 20).
    EdgeRmse,
    /// Root mean square error of all other pixels.
    FlatRmse,
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
            Metric::FlatRmse => "flat_rmse",
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

    /// Whether its reference is the picture made of many samples.
    pub const fn is_of_samples(self) -> bool {
        matches!(self, Metric::Flip | Metric::EdgeRmse | Metric::FlatRmse | Metric::SsimLoss)
    }

    /// For people.
    pub const fn about(self) -> &'static str {
        match self {
            Metric::Flip => "mean FLIP against the reference picture; 0.01 is hard to see",
            Metric::EdgeRmse => {
                "root mean square error along edges (0 to 1) against the reference picture"
            }
            Metric::FlatRmse => {
                "root mean square error beside edges (0 to 1) against the reference picture"
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
            Metric::MaxAbs => "largest absolute error of a sine or cosine",
        }
    }
}

/// The errors of one configuration.
#[derive(Default)]
pub struct Errors {
    /// Those that were asked for.
    pub values: Vec<(Metric, f64)>,
    /// The same against either half of the samples of the reference, where it is made of samples; of
    /// shimmer, in every other pixel and in those between.
    pub by_halves: Vec<(Metric, [f64; 2])>,
    /// What one pixel is where pixels are counted.
    pub ppm_of_a_pixel: f64,
    /// FLIP by pixel, where it was asked for.
    pub map: Option<Arc<ErrorMap>>,
}

impl Errors {
    /// The error by `metric`, if it was asked for.
    pub fn get(&self, metric: Metric) -> Option<f64> {
        self.values.iter().find(|(known, _)| *known == metric).map(|(_, error)| *error)
    }

    /// The errors by `metric` against the halves of the reference, if it has any.
    pub fn get_by_halves(&self, metric: Metric) -> Option<[f64; 2]> {
        self.by_halves.iter().find(|(known, _)| *known == metric).map(|(_, errors)| *errors)
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

/// Measures a picture by one metric after the other, and adds to `errors`.
pub struct Measuring<'a> {
    drawn: Drawn<'a>,
    reference: &'a Reference,
    /// Made when first asked for.
    perceived: Option<Perceived>,
    /// What has been measured.
    pub errors: Errors,
}

impl<'a> Measuring<'a> {
    /// Nothing is measured yet.
    pub fn new(drawn: Drawn<'a>, reference: &'a Reference) -> Measuring<'a> {
        Measuring { drawn, reference, perceived: None, errors: Errors::default() }
    }

    /// Measures by `metric`.
    pub fn measure(&mut self, renderer: &mut Renderer, metric: Metric) -> Result<(), MeasureError> {
        let Measuring { drawn, reference, .. } = self;
        let error = match metric {
            Metric::Flip => return self.flip(),
            Metric::EdgeRmse | Metric::FlatRmse | Metric::SsimLoss => {
                let error = |truth| against(truth, drawn.picture, metric);
                let [even, odd] = &reference.halves;
                self.errors.by_halves.push((metric, [error(even)?, error(odd)?]));
                error(&reference.picture)?
            }
            Metric::IdPpm => {
                let passes = Passes::NONE.with(Pass::Triangle);
                let mut frame = Frame::default();
                let settings = Settings { passes, ..*drawn.settings };
                renderer.render(drawn.prepared, drawn.view, &settings, &mut frame);
                self.errors.ppm_of_a_pixel = 1e6 / frame.len().max(1) as f64;
                ids_differ_ppm(&reference.triangles, &frame.triangle)?
            }
            Metric::Shimmer => {
                let (whole, halves) = shimmer(drawn, renderer);
                self.errors.by_halves.push((metric, halves));
                whole
            }
            Metric::FalseVisible => {
                // One that is lost is no less wrong than one that is kept.
                let n_false = drawn.n_kept.abs_diff(reference.n_visible);
                n_false as f64 / drawn.prepared.items().len().max(1) as f64 * 1e6
            }
            Metric::LightFlip => {
                let lit = &self.reference.perceived.lit;
                lit.flip(self.perceived())?.mean()
            }
            Metric::LightMax => max_abs(&reference.lit, drawn.picture)?,
            Metric::DefaultMax => max_abs(&reference.default, drawn.picture)?,
            Metric::MaxAbs => return Ok(()), // not of pictures
        };
        self.errors.values.push((metric, error));
        Ok(())
    }

    fn flip(&mut self) -> Result<(), MeasureError> {
        let truth = &self.reference.perceived;
        let [even, odd] = &truth.halves;
        let perceived = self.perceived();
        let map = truth.whole.flip(perceived)?;
        let halves = [even.flip(perceived)?.mean(), odd.flip(perceived)?.mean()];
        self.errors.values.push((Metric::Flip, map.mean()));
        self.errors.by_halves.push((Metric::Flip, halves));
        self.errors.map = Some(Arc::new(map));
        Ok(())
    }

    fn perceived(&mut self) -> &Perceived {
        let picture = self.drawn.picture;
        self.perceived.get_or_insert_with(|| Perceived::of(picture, PIXELS_PER_DEGREE))
    }
}

/// The error of `picture` by a metric of two pictures other than FLIP.
pub fn against(truth: &Picture, picture: &Picture, metric: Metric) -> Result<f64, MeasureError> {
    // A picture without edges has no error along them, one of edges alone none beside them.
    let rmse = |psnr: Option<f64>| psnr.map_or(0.0, |psnr| libm::pow(10.0, -psnr / 20.0));
    Ok(match metric {
        Metric::EdgeRmse => rmse(split_psnr(truth, picture)?.edge),
        Metric::FlatRmse => rmse(split_psnr(truth, picture)?.flat),
        _ => (1.0 - ssim(truth, picture)?).max(0.0),
    })
}

/// Steps of a pixel that a pan takes.
const STEPS: u32 = 16;

/// Frames that shimmer is measured from.
pub const SHIMMER_FRAMES: u32 = 2 * (STEPS + 1);

/// The mean over pixels, channels and steps of `|a - 2 b + c|`, encoded, of three pictures in a row of a
/// pan across and of one down: of all, and of every other pixel and those between. What glides changes evenly
/// and counts little; what jumps counts twice its jump.
fn shimmer(drawn: &Drawn<'_>, renderer: &mut Renderer) -> (f64, [f64; 2]) {
    let settings = Settings { passes: Passes::COLOR, ..*drawn.settings };
    let mut frames = [Frame::default(), Frame::default(), Frame::default()];
    let (mut sums, mut n) = ([0_u64; 2], [0_u64; 2]);
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
            let width = a.width as usize;
            for (i, ((a, b), c)) in a.rgba8.iter().zip(&b.rgba8).zip(&c.rgba8).enumerate() {
                let half = (i / width + i % width) % 2; // as on a chessboard
                for channel in 0..3 {
                    let bend =
                        i32::from(a[channel]) + i32::from(c[channel]) - 2 * i32::from(b[channel]);
                    sums[half] += u64::from(bend.unsigned_abs());
                }
                n[half] += 3;
            }
        }
    }
    let mean = |sum: u64, n: u64| sum as f64 / n.max(1) as f64 / 255.0;
    (mean(sums[0] + sums[1], n[0] + n[1]), [mean(sums[0], n[0]), mean(sums[1], n[1])])
}

/// An opaque frame as a picture.
pub fn picture(frame: &Frame) -> Result<Picture, MeasureError> {
    let (width, height) = (frame.width as usize, frame.height as usize);
    Picture::from_rgba(width, height, frame.rgba8.as_flattened(), [0.0; 3])
}
