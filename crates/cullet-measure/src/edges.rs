//! PSNR split into the edges and the flats of the reference.
//!
//! Anti-aliasing lives in the few pixels along edges; a PSNR over the whole picture drowns
//! them in flats that cannot go wrong. So the reference's own gradient says which pixels
//! are edge, and each kind gets its figure. The 3 x 3 Sobel window marks the pixels on
//! both sides of a step, which is where a resolve may differ.
//!
//! Source of the gradient: Sobel and Feldman's 3 x 3 operator (1968), divided by 8 so that
//! a ramp of slope s answers s.

use crate::Picture;
use crate::error::MeasureError;
use crate::pixelwise::{differences, psnr_from_mse};

/// Gradient of luma from which a pixel counts as edge, encoded luma per pixel: about ten
/// 8-bit codes, above smooth shading, below a step between two surfaces that can be told
/// apart.
pub const EDGE_GRADIENT: f64 = 0.04;

/// PSNR of edge pixels and of the others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplitPsnr {
    /// Decibels over the edge pixels, infinite where they are equal; `None` without any.
    pub edge: Option<f64>,
    /// Decibels over the flat pixels, likewise.
    pub flat: Option<f64>,
    /// How many pixels are edge.
    pub n_edge: usize,
    /// How many are flat; together with `n_edge` the whole picture.
    pub n_flat: usize,
}

/// PSNR over the pixels of [`edge_mask`] and over the rest.
///
/// # Errors
/// When the sizes differ.
pub fn split_psnr(reference: &Picture, candidate: &Picture) -> Result<SplitPsnr, MeasureError> {
    let mut sums = [0.0; 2];
    let mut counts = [0; 2];
    for (difference, is_edge) in differences(reference, candidate)?.zip(edge_mask(reference)) {
        sums[usize::from(is_edge)] += difference.map(|d| d * d).iter().sum::<f64>();
        counts[usize::from(is_edge)] += 1;
    }
    let [flat, edge] = [0, 1].map(|kind| {
        (counts[kind] > 0).then(|| psnr_from_mse(sums[kind] / (3 * counts[kind]) as f64))
    });
    Ok(SplitPsnr { edge, flat, n_edge: counts[1], n_flat: counts[0] })
}

/// Which pixels are edge: luma gradient (Sobel, borders replicated) of at least
/// [`EDGE_GRADIENT`]. Row-major, `width * height`.
pub fn edge_mask(reference: &Picture) -> Vec<bool> {
    let luma = reference.luma();
    let (rise, smooth) = ([-0.5, 0.0, 0.5], [0.25, 0.5, 0.25]);
    let gradient_x = luma.filtered(&rise, &smooth);
    let gradient_y = luma.filtered(&smooth, &rise);
    let gradient = gradient_x.zip(&gradient_y, |x, y| (x * x + y * y).sqrt());
    gradient.values.into_iter().map(|g| g >= EDGE_GRADIENT).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::samples::picture;
    use crate::psnr;

    /// One row per line, `#` = 1 and `.` = 0, as a grey picture of that brightness.
    fn drawn(rows: &[&str], bright: u8) -> Picture {
        let samples: Vec<u8> =
            rows.concat().bytes().flat_map(|b| [if b == b'#' { bright } else { 0 }; 3]).collect();
        Picture::from_rgb(rows[0].len(), rows.len(), &samples).unwrap()
    }

    #[track_caller]
    fn check_mask(rows: &[&str], bright: u8, expected: &[&str]) {
        let mask = edge_mask(&drawn(rows, bright));
        let found: Vec<String> = mask
            .chunks(rows[0].len())
            .map(|row| row.iter().map(|&edge| if edge { '#' } else { '.' }).collect())
            .collect();
        assert_eq!(found, expected);
    }

    #[test]
    fn both_sides_of_a_step_are_edge() {
        check_mask(&["...###", "...###"], 255, &["..##..", "..##.."]);
    }

    #[test]
    fn all_around_a_corner_is_edge() {
        let expected = ["......", "..####", "..####", "..##.."];
        check_mask(&["......", "......", "...###", "...###"], 255, &expected);
    }

    #[test]
    fn a_faint_step_is_flat() {
        check_mask(&["...###"], 16, &["......"]);
    }

    #[test]
    fn a_single_pixel_is_flat() {
        check_mask(&["#"], 255, &["."]);
    }

    #[test]
    fn an_error_on_an_edge_spares_the_flats() {
        let reference = drawn(&["...###", "...###"], 255);
        let candidate = drawn(&["..####", "...###"], 255);
        let split = split_psnr(&reference, &candidate).unwrap();
        assert_eq!((split.n_edge, split.n_flat), (4, 8));
        assert_eq!(split.flat, Some(f64::INFINITY));
        assert!((split.edge.unwrap() - 10.0 * 4f64.log10()).abs() < 1e-12);
    }

    #[test]
    fn a_flat_picture_has_no_edge_figure() {
        let (black, white) = (picture("black", 2, 3), picture("white", 2, 3));
        let split = split_psnr(&black, &white).unwrap();
        assert_eq!(split, SplitPsnr { edge: None, flat: Some(0.0), n_edge: 0, n_flat: 6 });
    }

    #[test]
    fn the_parts_make_up_the_whole() {
        let (rings, moved) = (picture("rings", 64, 48), picture("moved", 64, 48));
        let split = split_psnr(&rings, &moved).unwrap();
        let mse = |db: Option<f64>| 10f64.powf(-db.unwrap() / 10.0);
        let sum = mse(split.edge) * split.n_edge as f64 + mse(split.flat) * split.n_flat as f64;
        let whole = 10f64.powf(-psnr(&rings, &moved).unwrap() / 10.0);
        assert!((sum / (64.0 * 48.0) - whole).abs() < 1e-12);
    }
}
