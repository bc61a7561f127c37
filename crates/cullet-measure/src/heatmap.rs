//! Errors as colours: black, violet, red, orange, pale yellow.
//!
//! The map is a curve through Oklab, made for this crate: lightness climbs in a straight
//! line, so equal steps of error look equal and a grey print still reads; hue turns once
//! from violet through red to yellow; chroma rises and falls between the two ends.
//!
//! Source of the space: Ottosson, "A perceptual color space for image processing", 2020.

use crate::ErrorMap;
use crate::color::srgb_from_linear;
use std::f64::consts::PI;

/// The map as 8-bit sRGB, row-major, three bytes per pixel: 0 is black, `full` and above
/// the palest yellow.
///
/// `full` is in (0, ∞); 1 for FLIP. NaN errors are drawn green, which the map never is.
pub fn heatmap(map: &ErrorMap, full: f32) -> Vec<u8> {
    let palette: Vec<[u8; 3]> = (0..=255).map(|i| heat_color(f64::from(i) / 255.0)).collect();
    let color = |error: f32| {
        if error.is_nan() {
            return NAN_COLOR;
        }
        palette[(error / full * 255.0).round().clamp(0.0, 255.0) as usize]
    };
    map.values.iter().flat_map(|&error| color(error)).collect()
}

const NAN_COLOR: [u8; 3] = [0, 255, 0];

/// The colour of `heat`, clamped to [0, 1], as 8-bit sRGB; green for NaN.
pub fn heat_color(heat: f64) -> [u8; 3] {
    if heat.is_nan() {
        return NAN_COLOR;
    }
    let heat = heat.clamp(0.0, 1.0);
    let hue = (290.0 + 175.0 * heat * heat.sqrt()) * PI / 180.0; // lingers in violet
    let lightness = 0.97 * heat;
    let chroma = 0.16 * libm::sin(PI * heat) + 0.06 * heat; // all but inside the sRGB gamut
    let linear = linear_from_oklab(lightness, chroma * libm::cos(hue), chroma * libm::sin(hue));
    linear.map(|v| (255.0 * srgb_from_linear(v.clamp(0.0, 1.0))).round() as u8)
}

fn linear_from_oklab(lightness: f64, a: f64, b: f64) -> [f64; 3] {
    let cube = |v: f64| v * v * v;
    let l = cube(lightness + 0.3963377774 * a + 0.2158037573 * b);
    let m = cube(lightness - 0.1055613458 * a - 0.0638541728 * b);
    let s = cube(lightness - 0.0894841775 * a - 1.2914855480 * b);
    [
        4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
        -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
        -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::{linear_from_srgb, luma};

    #[test]
    fn hotter_is_brighter() {
        let luminance = |i: u8| {
            let encoded = heat_color(f64::from(i) / 255.0).map(|v| f64::from(v) / 255.0);
            luma(encoded.map(linear_from_srgb))
        };
        for i in 8..=255 {
            assert!(luminance(i) > luminance(i - 8), "{i}");
        }
        assert_eq!(luminance(0), 0.0);
        assert!(luminance(255) > 0.85);
    }

    #[test]
    fn hue_runs_from_violet_through_red_to_yellow() {
        let [[vr, vg, vb], [rr, rg, rb], [yr, yg, yb]] = [0.25, 0.65, 0.95].map(heat_color);
        assert!(vb > vr && vr > vg, "violet");
        assert!(rr > 2 * rg && rr > 2 * rb, "red");
        assert!(yr > 200 && yg > 200 && yb < yg, "yellow");
    }

    #[test]
    fn errors_beyond_the_scale_are_clamped_and_nan_is_green() {
        let values = vec![-1.0, 0.0, 0.5, 2.0, f32::INFINITY, f32::NAN];
        let map = ErrorMap { width: 3, height: 2, values };
        let bytes = heatmap(&map, 0.5);
        let (colors, _) = bytes.as_chunks::<3>();
        assert_eq!(colors[0], heat_color(0.0));
        assert_eq!(colors[1], [0, 0, 0]);
        assert_eq!(colors[2..5], [heat_color(1.0); 3]);
        assert_eq!(colors[5], [0, 255, 0]);
    }
}
