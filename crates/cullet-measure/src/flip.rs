//! FLIP: how much does a pixel change when the two pictures are flipped between, in place,
//! by someone at a known distance from the screen?
//!
//! Two differences per pixel. *Colour*: both pictures are blurred as the eye blurs them
//! (contrast sensitivity, in the opponent space YCxCz), then compared in CIELAB with
//! colours less vivid in the dark (Hunt) by a distance fit for large steps (HyAB), and
//! large errors are compressed. *Feature*: edges and points found in the unblurred
//! luminance, at the scale at which the eye finds them. Features amplify colour:
//! `colour^(1 - feature)`.
//!
//! Source: Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild, "FLIP: A
//! Difference Evaluator for Alternating Images", 2020: the metric for ordinary (LDR)
//! pictures, constants and names included.

use crate::color::{
    lab_from_relative_xyz, linear_from_relative_xyz, linear_from_srgb, opponent_from_relative_xyz,
    relative_xyz_from_linear, relative_xyz_from_opponent,
};
use crate::convolve::{Plane, gaussian, offsets};
use crate::error::{MeasureError, same_size};
use crate::{ErrorMap, Picture};
use std::f64::consts::PI;

/// Pixels per degree of visual angle at 0.7 m from a screen 0.7 m and 3840 pixels wide:
/// the paper's viewer, about 67.
pub const PIXELS_PER_DEGREE: f64 = 3840.0 * PI / 180.0;

/// FLIP error per pixel in [0, 1]; 0 where nothing visibly changed, all 0 for equal
/// pictures. [`ErrorMap::mean`] is the usual summary.
///
/// `pixels_per_degree` is in [1, ∞), usually [`PIXELS_PER_DEGREE`]; larger means farther
/// away and more forgiving. Beyond the picture's border the border pixel repeats. Takes
/// time in proportion to pixels times `pixels_per_degree`.
///
/// # Errors
/// When the sizes differ.
///
/// # Panics
/// When `pixels_per_degree` is below 1, infinite or NaN: the detectors would be narrower
/// than a pixel by orders of magnitude.
pub fn flip(
    reference: &Picture,
    candidate: &Picture,
    pixels_per_degree: f64,
) -> Result<ErrorMap, MeasureError> {
    same_size(reference, candidate)?;
    let [reference, candidate] =
        [reference, candidate].map(|picture| Perceived::of(picture, pixels_per_degree));
    reference.flip(&candidate)
}

/// A picture as FLIP perceives it: for comparing one with many, most of the work done once.
#[derive(Clone, Debug)]
pub struct Perceived {
    width: usize,
    height: usize,
    /// Blurred as the eye blurs, CIELAB with the Hunt effect.
    colors: Vec<[f64; 3]>,
    edges: Plane,
    points: Plane,
}

impl Perceived {
    /// As somebody sees it for whom a degree has so many pixels; see [`flip()`].
    ///
    /// # Panics
    /// When `pixels_per_degree` is below 1, infinite or NaN.
    pub fn of(picture: &Picture, pixels_per_degree: f64) -> Perceived {
        assert!((1.0..f64::INFINITY).contains(&pixels_per_degree), "no viewer sees that");
        let (width, height) = (picture.width(), picture.height());
        let opponent = Opponent::of(picture);
        let colors = seen(&opponent, pixels_per_degree);
        let [edges, points] = features(&opponent.y, pixels_per_degree);
        Perceived { width, height, colors, edges, points }
    }

    /// What [`flip()`] says of this picture and another, the same whichever comes first.
    ///
    /// # Errors
    /// When the sizes differ.
    pub fn flip(&self, other: &Perceived) -> Result<ErrorMap, MeasureError> {
        let (a, b) = ((self.width, self.height), (other.width, other.height));
        if a != b {
            return Err(MeasureError::SizesDiffer { reference: a, candidate: b });
        }
        let color = color_differences(self, other);
        let feature = feature_differences(self, other);
        let errors = color.zip(&feature, |color, feature| libm::pow(color, 1.0 - feature));
        let values = errors.values.into_iter().map(|v| v as f32).collect();
        Ok(ErrorMap { width: self.width, height: self.height, values })
    }
}

/// A picture in YCxCz: luminance, red against green, blue against yellow.
struct Opponent {
    y: Plane,
    cx: Plane,
    cz: Plane,
}

impl Opponent {
    fn of(picture: &Picture) -> Opponent {
        let xyz = |rgb: [f64; 3]| relative_xyz_from_linear(rgb.map(linear_from_srgb));
        let colors: Vec<[f64; 3]> = picture
            .pixels()
            .iter()
            .map(|rgb| opponent_from_relative_xyz(xyz(rgb.map(f64::from))))
            .collect();
        let channel = |c: usize| Plane {
            width: picture.width(),
            height: picture.height(),
            values: colors.iter().map(|color| color[c]).collect(),
        };
        Opponent { y: channel(0), cx: channel(1), cz: channel(2) }
    }
}

/// Colour difference per pixel, in [0, 1].
fn color_differences(reference: &Perceived, candidate: &Perceived) -> Plane {
    let most = libm::pow(
        hyab(hunt_lab_from_linear([0.0, 1.0, 0.0]), hunt_lab_from_linear([0.0, 0.0, 1.0])),
        HYAB_EXPONENT,
    );
    let pairs = reference.colors.iter().zip(&candidate.colors);
    let values =
        pairs.map(|(r, c)| redistributed(libm::pow(hyab(*r, *c), HYAB_EXPONENT), most)).collect();
    Plane { values, ..reference.edges }
}

/// The paper's q_c.
const HYAB_EXPONENT: f64 = 0.7;

/// Maps a colour error from [0, most] to [0, 1]: the lower 0.4 (p_c) of the range, where
/// nearly all errors lie, onto the lower 0.95 (p_t), the rest onto what is left. `most` is
/// the error of green against blue, the two colours of the gamut farthest apart.
fn redistributed(error: f64, most: f64) -> f64 {
    const P_C: f64 = 0.4;
    const P_T: f64 = 0.95;
    let knee = P_C * most;
    if error < knee {
        error * P_T / knee
    } else {
        P_T + (error - knee) / (most - knee) * (1.0 - P_T)
    }
}

/// What the eye makes of a picture: blurred by its contrast sensitivity, clamped to the
/// screen's gamut, in CIELAB with the Hunt effect.
fn seen(picture: &Opponent, ppd: f64) -> Vec<[f64; 3]> {
    let [y, cx, cz] = [
        blurred(&picture.y, &[LUMINANCE], ppd),
        blurred(&picture.cx, &[RED_GREEN], ppd),
        blurred(&picture.cz, &BLUE_YELLOW, ppd),
    ];
    let lab = |i: usize| {
        let opponent = [y.values[i], cx.values[i], cz.values[i]];
        let linear = linear_from_relative_xyz(relative_xyz_from_opponent(opponent));
        hunt_lab_from_linear(linear.map(|v| v.clamp(0.0, 1.0)))
    };
    (0..y.values.len()).map(lab).collect()
}

/// One Gaussian of a contrast sensitivity function in space, `a sqrt(pi / b) exp(-pi² x² / b)`
/// with x in degrees.
struct Csf {
    a: f64,
    b: f64,
}

const LUMINANCE: Csf = Csf { a: 1.0, b: 0.0047 };
const RED_GREEN: Csf = Csf { a: 1.0, b: 0.0053 };
const BLUE_YELLOW: [Csf; 2] = [Csf { a: 34.1, b: 0.04 }, Csf { a: 13.5, b: 0.025 }];

impl Csf {
    /// Standard deviation in pixels.
    fn sigma(&self, ppd: f64) -> f64 {
        (self.b / (2.0 * PI * PI)).sqrt() * ppd
    }
}

/// A plane blurred by a sum of Gaussians, normalised to total weight 1.
///
/// All channels share the radius of the widest Gaussian, three deviations. The sum is not
/// separable, but each Gaussian is: blur by each, then mix by their shares of the total.
fn blurred(plane: &Plane, sum: &[Csf], ppd: f64) -> Plane {
    let radius = (3.0 * BLUE_YELLOW[0].sigma(ppd)).ceil() as usize;
    let weight = |csf: &Csf| {
        let sigma = csf.sigma(ppd);
        let taps: f64 = offsets(radius).map(|x| libm::exp(-x * x / (2.0 * sigma * sigma))).sum();
        csf.a * (PI / csf.b).sqrt() * taps * taps
    };
    let total: f64 = sum.iter().map(weight).sum();
    let layer = |csf: &Csf| {
        let kernel = gaussian(csf.sigma(ppd), radius);
        let share = weight(csf) / total;
        plane.filtered(&kernel, &kernel.iter().map(|tap| tap * share).collect::<Vec<f64>>())
    };
    let [first, rest @ ..] = sum else { unreachable!("a sum has a term") };
    rest.iter().fold(layer(first), |mixed, csf| mixed.zip(&layer(csf), |a, b| a + b))
}

/// CIELAB with chroma scaled by lightness: vivid colours look less vivid in the dark.
fn hunt_lab_from_linear(rgb: [f64; 3]) -> [f64; 3] {
    let [l, a, b] = lab_from_relative_xyz(relative_xyz_from_linear(rgb));
    [l, 0.01 * l * a, 0.01 * l * b]
}

/// HyAB distance: city block between lightness and chroma, Euclidean within chroma.
fn hyab(p: [f64; 3], q: [f64; 3]) -> f64 {
    let [dl, da, db]: [f64; 3] = std::array::from_fn(|i| p[i] - q[i]);
    dl.abs() + (da * da + db * db).sqrt()
}

/// Feature difference per pixel, in [0, 1]: what appeared or vanished of edges or points,
/// whichever is more.
fn feature_differences(reference: &Perceived, candidate: &Perceived) -> Plane {
    let change = |a: &Plane, b: &Plane| a.zip(b, |r, c| (r - c).abs());
    let edges = change(&reference.edges, &candidate.edges);
    let points = change(&reference.points, &candidate.points);
    edges.zip(&points, |edge, point| (edge.max(point) / 2f64.sqrt()).sqrt())
}

/// How much of an edge, and of a point, there is at each pixel of a luminance.
fn features(y: &Plane, ppd: f64) -> [Plane; 2] {
    let sigma = 0.5 * FEATURE_WIDTH * ppd;
    let radius = (3.0 * sigma).ceil() as usize;
    let smooth = gaussian(sigma, radius);
    let edge = balanced(smooth.iter().zip(offsets(radius)).map(|(g, x)| g * x));
    let point = balanced(
        smooth.iter().zip(offsets(radius)).map(|(g, x)| g * (x * x / (sigma * sigma) - 1.0)),
    );
    let y = Plane { values: y.values.iter().map(|v| (v + 16.0) / 116.0).collect(), ..*y };
    [edge, point].map(|kernel| {
        let (across, down) = (y.filtered(&kernel, &smooth), y.filtered(&smooth, &kernel));
        across.zip(&down, |x, y| (x * x + y * y).sqrt())
    })
}

/// The paper's w, degrees: how wide an edge looks to the detectors. (Its q_f, 0.5, is the
/// square root above.)
const FEATURE_WIDTH: f64 = 0.082;

/// Taps with the positive ones scaled to sum 1 and the negative ones to sum -1.
fn balanced(taps: impl Iterator<Item = f64>) -> Vec<f64> {
    let taps: Vec<f64> = taps.collect();
    let above: f64 = taps.iter().map(|tap| tap.max(0.0)).sum();
    let below: f64 = taps.iter().map(|tap| (-tap).max(0.0)).sum();
    taps.into_iter().map(|tap| if tap > 0.0 { tap / above } else { tap / below }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::samples::picture;

    /// Expected mean and maximum: flip-evaluator 1.7, the authors' Python package,
    /// `evaluate(reference, test, "LDR", applyMagma=False)` on the same pictures as f32,
    /// with `{"ppd": ...}` where it is not the default; the mean of the map taken in f64.
    ///
    /// Agreement is about 1e-7 where there are features and 1.5e-5 on flat pictures: there
    /// the package's f32 kernels do not sum to exactly 0 and the square root of the feature
    /// difference magnifies what is left.
    #[test]
    fn agrees_with_the_authors_implementation() {
        const DEFAULT: f64 = PIXELS_PER_DEGREE;
        for (reference, candidate, width, height, ppd, mean, max) in [
            ("ramp", "shifted", 64, 48, DEFAULT, 0.2279183, 0.7907736),
            ("rings", "moved", 64, 48, DEFAULT, 0.1036249, 0.6286849),
            ("rings", "coarse", 64, 48, DEFAULT, 0.2361969, 0.4097775),
            ("rings", "noise", 64, 48, DEFAULT, 0.8470163, 0.9748111),
            ("checks", "tinted", 65, 33, DEFAULT, 0.1270277, 0.1755696),
            ("noise", "checks", 33, 65, DEFAULT, 0.8939995, 0.9841470),
            ("black", "white", 64, 48, DEFAULT, 0.9673883, 0.9673883),
            ("green", "blue", 64, 48, DEFAULT, 1.0, 1.0),
            ("black", "dot", 31, 31, DEFAULT, 0.0148900, 0.8649065),
            ("rings", "moved", 64, 48, 20.0, 0.1003345, 0.9665732),
            ("rings", "coarse", 64, 48, 120.0, 0.2431991, 0.3371273),
            ("rings", "moved", 12, 11, DEFAULT, 0.0851757, 0.1062777),
            ("noise", "ramp", 2, 3, DEFAULT, 0.4434389, 0.4987308),
            ("noise", "ramp", 1, 1, DEFAULT, 0.4775612, 0.4775612),
            ("black", "white", 1, 1, DEFAULT, 0.9673883, 0.9673883),
            ("rings", "noise", 640, 360, DEFAULT, 0.4718860, 0.9873390),
        ] {
            let [r, c] = [reference, candidate].map(|name| picture(name, width, height));
            let map = flip(&r, &c, ppd).unwrap();
            assert!((map.mean() - mean).abs() < 2e-5, "{reference}, {candidate}: {}", map.mean());
            assert!((map.max() - max).abs() < 2e-5, "{reference}, {candidate}: {}", map.max());
        }
    }

    #[test]
    fn one_picture_compared_with_many_is_seen_once() {
        let [rings, moved, noise] = ["rings", "moved", "noise"].map(|name| picture(name, 33, 21));
        let of = |picture| Perceived::of(picture, PIXELS_PER_DEGREE);
        let reference = of(&rings);
        for other in [&moved, &noise] {
            let map = reference.flip(&of(other)).unwrap();
            assert_eq!(map, flip(&rings, other, PIXELS_PER_DEGREE).unwrap());
            assert_eq!(map, of(other).flip(&reference).unwrap());
        }
        assert!(reference.flip(&of(&picture("rings", 32, 21))).is_err());
    }

    #[test]
    fn equal_pictures_of_any_size_have_no_error() {
        for (width, height) in [(1, 1), (2, 3), (64, 48)] {
            let noise = picture("noise", width, height);
            let map = flip(&noise, &noise, PIXELS_PER_DEGREE).unwrap();
            assert_eq!((map.width, map.height, map.values.len()), (width, height, width * height));
            assert_eq!(map.max(), 0.0);
        }
    }

    #[test]
    fn every_viewer_gets_errors_from_0_to_1() {
        let (noise, checks) = (picture("noise", 16, 9), picture("checks", 16, 9));
        for ppd in [1.0, 2.0, 10.0, 1000.0] {
            let map = flip(&noise, &checks, ppd).unwrap();
            assert!(map.values.iter().all(|error| (0.0..=1.0).contains(error)), "{ppd}");
        }
    }

    #[test]
    fn the_default_viewer_sees_67_pixels_per_degree() {
        assert!((PIXELS_PER_DEGREE - 67.020_643).abs() < 1e-6);
    }

    #[test]
    fn sizes_must_agree() {
        let (wide, tall) = (picture("black", 3, 2), picture("black", 2, 3));
        assert!(flip(&wide, &tall, PIXELS_PER_DEGREE).is_err());
    }
}
