//! Structural similarity: do means, contrasts and patterns agree, window by window?
//!
//! Each 11 x 11 window, weighted by a Gaussian of sigma 1.5, compares the luma of the two
//! pictures through weighted means, variances and covariance (population, not sample).
//! The answer is the mean over the windows that lie wholly within the picture.
//!
//! Source: Wang, Bovik, Sheikh, Simoncelli, "Image Quality Assessment: From Error
//! Visibility to Structural Similarity", 2004, equations 13 to 17, with their constants.

use crate::Picture;
use crate::convolve::{Plane, gaussian};
use crate::error::{MeasureError, same_size};

const SIGMA: f64 = 1.5;
const RADIUS: usize = 5;

/// `(K1 L)²` and `(K2 L)²` with K1 = 0.01, K2 = 0.03 and L = 1: what keeps flat windows
/// from dividing 0 by 0.
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// Mean structural similarity of luma (Rec. 709 weights on encoded values), in [-1, 1];
/// 1 for equal pictures.
///
/// Where a side is below 11 pixels no whole window fits; the window then shrinks along
/// that side to the largest odd length that does.
///
/// # Errors
/// When the sizes differ.
pub fn ssim(reference: &Picture, candidate: &Picture) -> Result<f64, MeasureError> {
    same_size(reference, candidate)?;
    let (width, height) = (reference.width(), reference.height());
    let radius_x = RADIUS.min((width - 1) / 2);
    let radius_y = RADIUS.min((height - 1) / 2);
    let (kernel_x, kernel_y) = (gaussian(SIGMA, radius_x), gaussian(SIGMA, radius_y));
    let mean_of_product =
        |a: &Plane, b: &Plane| a.zip(b, |a, b| a * b).filtered(&kernel_x, &kernel_y).values;

    let (r, c) = (reference.luma(), candidate.luma());
    let mean_r = r.filtered(&kernel_x, &kernel_y).values;
    let mean_c = c.filtered(&kernel_x, &kernel_y).values;
    let mean_rr = mean_of_product(&r, &r);
    let mean_cc = mean_of_product(&c, &c);
    let mean_rc = mean_of_product(&r, &c);

    let similarity = |i: usize| {
        let (mr, mc) = (mean_r[i], mean_c[i]);
        let variances = (mean_rr[i] - mr * mr) + (mean_cc[i] - mc * mc);
        let covariance = mean_rc[i] - mr * mc;
        let luminance = (2.0 * mr * mc + C1) / (mr * mr + mc * mc + C1);
        let structure = (2.0 * covariance + C2) / (variances + C2);
        luminance * structure
    };
    let columns = radius_x..width - radius_x;
    let rows = radius_y..height - radius_y;
    let n_windows = columns.len() * rows.len();
    let sum: f64 =
        rows.flat_map(|y| columns.clone().map(move |x| y * width + x)).map(similarity).sum();
    Ok(sum / n_windows as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::samples::picture;

    /// Expected: scikit-image 0.26.0, `structural_similarity` of the luma with
    /// `gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1`.
    #[test]
    fn agrees_with_scikit_image() {
        for (reference, candidate, width, height, expected) in [
            ("ramp", "shifted", 64, 48, 0.774288515),
            ("rings", "moved", 64, 48, 0.985945781),
            ("rings", "coarse", 64, 48, 0.544164770),
            ("rings", "noise", 64, 48, 0.010286912),
            ("checks", "tinted", 65, 33, 0.999957138),
            ("noise", "checks", 33, 65, 0.014499816),
            ("black", "white", 64, 48, 0.000099990),
            ("green", "blue", 64, 48, 0.200019550),
            ("black", "dot", 31, 31, 0.857181274),
            ("rings", "moved", 12, 11, 0.994257873),
        ] {
            let [r, c] = [reference, candidate].map(|name| picture(name, width, height));
            let found = ssim(&r, &c).unwrap();
            assert!((found - expected).abs() < 1e-6, "{reference}, {candidate}: {found}");
        }
    }

    #[test]
    fn equal_pictures_of_any_size_are_similar_exactly() {
        for (width, height) in [(1, 1), (2, 3), (10, 11), (3, 40), (64, 48)] {
            let noise = picture("noise", width, height);
            assert_eq!(ssim(&noise, &noise), Ok(1.0), "{width}x{height}");
        }
    }

    #[test]
    fn a_single_pixel_compares_luminance_alone() {
        let found = ssim(&picture("black", 1, 1), &picture("white", 1, 1)).unwrap();
        assert!((found - C1 / (1.0 + C1)).abs() < 1e-12);
    }

    #[test]
    fn sizes_must_agree() {
        assert!(ssim(&picture("black", 3, 2), &picture("black", 2, 3)).is_err());
    }
}
