//! The picture that every metric compares: opaque, sRGB-encoded, 0 to 1.
//!
//! Metrics of appearance are defined on what a screen is sent, so that is what is stored.
//! Alpha is never compared silently: a picture with alpha is laid over a background the
//! caller names ([`Picture::from_rgba`]), and alpha may be compared by itself as a grey
//! picture ([`Picture::alpha_of_rgba`]). The constructors refuse NaN, so that every metric
//! is a number.

use crate::color::{linear_from_srgb, luma, srgb_from_linear};
use crate::convolve::Plane;
use crate::error::MeasureError;

/// A width times height grid of sRGB-encoded colours, each component in [0, 1].
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    width: usize,
    height: usize,
    pixels: Vec<[f32; 3]>,
}

/// An unsigned integer sample whose largest value means 1: `u8` or `u16`.
pub trait Sample: Copy {
    /// The sample as a fraction of its largest value, in [0, 1].
    fn fraction(self) -> f32;
}

impl Sample for u8 {
    fn fraction(self) -> f32 {
        f32::from(self) / f32::from(u8::MAX)
    }
}

impl Sample for u16 {
    fn fraction(self) -> f32 {
        f32::from(self) / f32::from(u16::MAX)
    }
}

impl Picture {
    /// From sRGB-encoded pixels, row-major, top row first, every component in [0, 1].
    ///
    /// # Errors
    /// No pixels, a length other than width times height, a component that is NaN or out
    /// of range. The other constructors fail for the first two reasons only, except
    /// where they say more.
    pub fn new(
        width: usize,
        height: usize,
        pixels: Vec<[f32; 3]>,
    ) -> Result<Picture, MeasureError> {
        check_length(width, height, 1, pixels.len())?;
        for (i, pixel) in pixels.iter().enumerate() {
            if let Some(&value) = pixel.iter().find(|v| !(0.0..=1.0).contains(*v)) {
                return Err(MeasureError::OutOfRange { x: i % width, y: i / width, value });
            }
        }
        Ok(Picture { width, height, pixels })
    }

    /// From sRGB-encoded RGB samples of 8 or 16 bits, row-major, top row first.
    pub fn from_rgb<S: Sample>(
        width: usize,
        height: usize,
        samples: &[S],
    ) -> Result<Picture, MeasureError> {
        check_length(width, height, 3, samples.len())?;
        let (colors, _) = samples.as_chunks::<3>();
        Picture::new(width, height, colors.iter().map(|rgb| rgb.map(S::fraction)).collect())
    }

    /// From sRGB-encoded RGBA samples with straight alpha, laid over an sRGB-encoded
    /// `background` with components in [0, 1].
    ///
    /// The blend is done in linear light, as a renderer drawing over that background does
    /// it. Opaque pixels keep their colour exactly.
    ///
    /// # Errors
    /// Also when the background is out of range and shows.
    pub fn from_rgba<S: Sample>(
        width: usize,
        height: usize,
        samples: &[S],
        background: [f32; 3],
    ) -> Result<Picture, MeasureError> {
        check_length(width, height, 4, samples.len())?;
        let (colors, _) = samples.as_chunks::<4>();
        let over_background = |rgba: &[S; 4]| {
            let [r, g, b, alpha] = rgba.map(S::fraction);
            let front = [r, g, b];
            std::array::from_fn(|c| blend(front[c], background[c], alpha))
        };
        Picture::new(width, height, colors.iter().map(over_background).collect())
    }

    /// The alpha of RGBA samples as a grey picture, colour ignored.
    pub fn alpha_of_rgba<S: Sample>(
        width: usize,
        height: usize,
        samples: &[S],
    ) -> Result<Picture, MeasureError> {
        check_length(width, height, 4, samples.len())?;
        let (colors, _) = samples.as_chunks::<4>();
        Picture::new(width, height, colors.iter().map(|rgba| [rgba[3].fraction(); 3]).collect())
    }

    /// From linear RGB; values outside [0, 1] are clamped, as a screen clamps them.
    ///
    /// # Errors
    /// Also for NaN, which no screen can show.
    pub fn from_linear(
        width: usize,
        height: usize,
        pixels: &[[f32; 3]],
    ) -> Result<Picture, MeasureError> {
        let encode = |v: f32| srgb_from_linear(f64::from(v).clamp(0.0, 1.0)) as f32;
        Picture::new(width, height, pixels.iter().map(|rgb| rgb.map(encode)).collect())
    }

    /// Pixels per row, at least 1.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows, at least 1.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The pixels, row-major, top row first, sRGB-encoded, in [0, 1].
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }

    /// Luma of every pixel: Rec. 709 weights on the encoded values, in [0, 1].
    pub(crate) fn luma(&self) -> Plane {
        self.plane(luma)
    }

    /// One number per pixel.
    pub(crate) fn plane(&self, value: impl Fn([f64; 3]) -> f64) -> Plane {
        let values = self.pixels.iter().map(|rgb| value(rgb.map(f64::from))).collect();
        Plane { width: self.width, height: self.height, values }
    }
}

fn check_length(
    width: usize,
    height: usize,
    channels: usize,
    found: usize,
) -> Result<(), MeasureError> {
    if width == 0 || height == 0 {
        return Err(MeasureError::Empty { width, height });
    }
    // Saturation is safe: no slice is usize::MAX elements long, save of zero-sized types.
    let expected = width.saturating_mul(height).saturating_mul(channels);
    if expected == found { Ok(()) } else { Err(MeasureError::WrongLength { expected, found }) }
}

/// Two encoded values mixed in linear light.
fn blend(front: f32, back: f32, alpha: f32) -> f32 {
    if alpha == 1.0 {
        return front; // exactly, without the trip through linear light
    }
    let [front, back, alpha] = [front, back, alpha].map(f64::from);
    let mixed = alpha * linear_from_srgb(front) + (1.0 - alpha) * linear_from_srgb(back);
    srgb_from_linear(mixed) as f32
}

/// Pictures by formula, so that another program can make the very same ones.
#[cfg(test)]
pub(crate) mod samples {
    use super::Picture;

    /// The 8-bit picture called `name`: a polynomial in x, y and channel, modulo 256.
    pub(crate) fn picture(name: &str, width: usize, height: usize) -> Picture {
        let mut samples = Vec::with_capacity(width * height * 3);
        for y in 0..height as i64 {
            for x in 0..width as i64 {
                for c in 0..3 {
                    samples.push(sample(name, width, height, x, y, c).rem_euclid(256) as u8);
                }
            }
        }
        Picture::from_rgb(width, height, &samples).expect("the samples fill the size")
    }

    fn sample(name: &str, width: usize, height: usize, x: i64, y: i64, c: i64) -> i64 {
        let rings = |cx: i64| ((x - cx).pow(2) + (y - 15).pow(2)) / (8 + 4 * c);
        let checks = (x / 4 + y / 4) % 2 * (200 + 20 * c) + 20;
        match name {
            "black" => 0,
            "white" => 255,
            "green" => [0, 255, 0][c as usize],
            "blue" => [0, 0, 255][c as usize],
            "dot" if (x, y) == (width as i64 / 2, height as i64 / 2) => 255,
            "dot" => 0,
            "ramp" => x * 5 + y * 3 + c * 40,
            "shifted" => (x + 1) * 5 + y * 3 + c * 40,
            "rings" => rings(20),
            "moved" => rings(21),
            "coarse" => rings(20) % 256 / 32 * 32,
            "noise" => x * x * 3 + y * 7 * (c + 1) + x * y * (c + 2),
            "checks" => checks,
            "tinted" => checks + [-10, 0, 15][c as usize],
            _ => panic!("no sample picture is called {name}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eight_and_sixteen_bits_agree_at_the_ends() {
        let eight = Picture::from_rgb(1, 1, &[0u8, 255, 51]).unwrap();
        let sixteen = Picture::from_rgb(1, 1, &[0u16, 65535, 13107]).unwrap();
        assert_eq!(eight, sixteen);
        assert_eq!(eight.pixels(), [[0.0, 1.0, 0.2]]);
    }

    #[test]
    fn alpha_blends_in_linear_light() {
        let rgba = [255u8, 255, 255, 255, 9, 9, 9, 0, 255, 0, 255, 128];
        let over = Picture::from_rgba(3, 1, &rgba, [0.0, 1.0, 0.0]).unwrap();
        assert_eq!(over.pixels()[0], [1.0, 1.0, 1.0]);
        assert_eq!(over.pixels()[1], [0.0, 1.0, 0.0]);
        let expected = srgb_from_linear(128.0 / 255.0) as f32; // 0.7366, not 0.502
        assert!((over.pixels()[2][0] - expected).abs() < 1e-6);
        let alpha = Picture::alpha_of_rgba(3, 1, &rgba).unwrap();
        assert_eq!(alpha.pixels()[1], [0.0; 3]);
    }

    #[test]
    fn linear_light_is_encoded_and_clamped() {
        let picture = Picture::from_linear(1, 1, &[[-1.0, f32::INFINITY, 0.5]]).unwrap();
        let [r, g, b] = picture.pixels()[0];
        assert_eq!((r, g), (0.0, 1.0));
        assert!((b - 0.735_357).abs() < 1e-6);
    }

    #[test]
    fn bad_input_is_an_error() {
        use MeasureError::*;
        let empty = Err(Empty { width: 0, height: 2 });
        assert_eq!(Picture::from_rgb::<u8>(0, 2, &[]), empty);
        let short = Err(WrongLength { expected: 12, found: 11 });
        assert_eq!(Picture::from_rgb(2, 2, &[0u8; 11]), short);
        assert!(Picture::from_rgb(usize::MAX, 2, &[0u8; 3]).is_err());
        assert!(Picture::from_linear(1, 1, &[[0.0, f32::NAN, 0.0]]).is_err());
        let above = Picture::new(2, 2, vec![[0.0; 3], [0.0; 3], [0.0; 3], [0.5, 1.5, 0.0]]);
        assert_eq!(above, Err(OutOfRange { x: 1, y: 1, value: 1.5 }));
    }
}
