//! Errors that look at each pixel alone, on sRGB-encoded values.
//!
//! All three channels count alike and the peak is 1. Differences are taken in f64. Equal
//! pictures give exactly 0 (and infinite PSNR), different ones never do. The only error is
//! two sizes that differ.

use crate::Picture;
use crate::error::{MeasureError, same_size};

/// The largest difference of any channel of any pixel, in [0, 1].
///
/// Times 255 and rounded: how many 8-bit codes.
pub fn max_abs(reference: &Picture, candidate: &Picture) -> Result<f64, MeasureError> {
    Ok(differences(reference, candidate)?.map(largest).fold(0.0, f64::max))
}

/// Mean absolute difference over all pixels and channels, in [0, 1].
pub fn mae(reference: &Picture, candidate: &Picture) -> Result<f64, MeasureError> {
    mean_over_channels(reference, candidate, f64::abs)
}

/// Mean squared difference over all pixels and channels, in [0, 1].
pub fn mse(reference: &Picture, candidate: &Picture) -> Result<f64, MeasureError> {
    mean_over_channels(reference, candidate, |d| d * d)
}

/// Peak signal-to-noise ratio, `-10 log10(mse)`, in decibels: 0 for black against white,
/// infinite for equal pictures.
pub fn psnr(reference: &Picture, candidate: &Picture) -> Result<f64, MeasureError> {
    mse(reference, candidate).map(psnr_from_mse)
}

/// How many pixels differ by more than `threshold` in some channel.
///
/// `threshold` is in [0, 1]; 0 counts every pixel that is not identical. Pictures hold
/// rounded f32s, so to allow one 8-bit code ask between codes, `1.5 / 255.0`.
pub fn changed_pixels(
    reference: &Picture,
    candidate: &Picture,
    threshold: f64,
) -> Result<usize, MeasureError> {
    Ok(differences(reference, candidate)?.filter(|d| largest(*d) > threshold).count())
}

/// Decibels of a mean squared error against peak 1; `+inf` for 0.
pub(crate) fn psnr_from_mse(mse: f64) -> f64 {
    if mse == 0.0 { f64::INFINITY } else { 0.0 - 10.0 * libm::log10(mse) } // 0, not -0, for 1
}

/// Reference minus candidate, channel by channel, in row order.
pub(crate) fn differences<'a>(
    reference: &'a Picture,
    candidate: &'a Picture,
) -> Result<impl Iterator<Item = [f64; 3]> + 'a, MeasureError> {
    same_size(reference, candidate)?;
    let pairs = reference.pixels().iter().zip(candidate.pixels());
    Ok(pairs.map(|(r, c)| std::array::from_fn(|i| f64::from(r[i]) - f64::from(c[i]))))
}

fn mean_over_channels(
    reference: &Picture,
    candidate: &Picture,
    error: impl Fn(f64) -> f64,
) -> Result<f64, MeasureError> {
    let sum: f64 = differences(reference, candidate)?.flatten().map(error).sum();
    Ok(sum / (3 * reference.pixels().len()) as f64)
}

fn largest(difference: [f64; 3]) -> f64 {
    difference.into_iter().fold(0.0, |most, d| d.abs().max(most))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::samples::picture;

    #[test]
    fn equal_pictures_have_no_error() {
        for (width, height) in [(1, 1), (2, 3), (64, 48)] {
            let noise = picture("noise", width, height);
            assert_eq!(max_abs(&noise, &noise), Ok(0.0));
            assert_eq!(mae(&noise, &noise), Ok(0.0));
            assert_eq!(mse(&noise, &noise), Ok(0.0));
            assert_eq!(psnr(&noise, &noise), Ok(f64::INFINITY));
            assert_eq!(changed_pixels(&noise, &noise, 0.0), Ok(0));
        }
    }

    #[test]
    fn black_is_as_far_from_white_as_can_be() {
        let (black, white) = (picture("black", 2, 3), picture("white", 2, 3));
        assert_eq!(max_abs(&black, &white), Ok(1.0));
        assert_eq!(mae(&black, &white), Ok(1.0));
        assert_eq!(psnr(&black, &white), Ok(0.0));
        assert_eq!(changed_pixels(&black, &white, 0.99), Ok(6));
    }

    #[test]
    fn one_code_is_one_code() {
        let reference = Picture::from_rgb(2, 1, &[200u8, 7, 7, 7, 7, 7]).unwrap();
        let candidate = Picture::from_rgb(2, 1, &[201u8, 7, 7, 7, 7, 7]).unwrap();
        let codes = max_abs(&reference, &candidate).unwrap() * 255.0;
        assert!((codes - 1.0).abs() < 1e-4);
        assert_eq!(changed_pixels(&reference, &candidate, 0.5 / 255.0), Ok(1));
        assert_eq!(changed_pixels(&reference, &candidate, 1.5 / 255.0), Ok(0));
        assert!((mae(&reference, &candidate).unwrap() * 6.0 * 255.0 - 1.0).abs() < 1e-4);
    }

    /// Expected: `peak_signal_noise_ratio(a, b, data_range=1)` of scikit-image 0.26.0.
    #[test]
    fn psnr_agrees_with_scikit_image() {
        for (reference, candidate, width, height, expected) in [
            ("ramp", "shifted", 64, 48, 17.807302635),
            ("rings", "moved", 64, 48, 26.630678843),
            ("checks", "tinted", 65, 33, 27.783182546),
            ("noise", "checks", 33, 65, 5.736317304),
            ("green", "blue", 64, 48, 1.760912591),
            ("noise", "ramp", 2, 3, 15.962256488),
        ] {
            let [r, c] = [reference, candidate].map(|name| picture(name, width, height));
            let found = psnr(&r, &c).unwrap();
            assert!((found - expected).abs() < 1e-5, "{reference}, {candidate}: {found}");
        }
    }

    #[test]
    fn sizes_must_agree() {
        let (wide, tall) = (picture("black", 3, 2), picture("black", 2, 3));
        let differ = MeasureError::SizesDiffer { reference: (3, 2), candidate: (2, 3) };
        assert_eq!(psnr(&wide, &tall), Err(differ));
        assert_eq!(max_abs(&wide, &tall), Err(differ));
        assert_eq!(changed_pixels(&wide, &tall, 0.0), Err(differ));
    }
}
