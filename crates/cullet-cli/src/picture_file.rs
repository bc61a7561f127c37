//! Picture files: formats, what each can hold, and samples to bytes.

use std::io::Cursor;
use std::path::Path;

use clap::ValueEnum;
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::codecs::webp::WebPEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageResult};

/// A kind of picture file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// PNG.
    Png,
    /// JPEG, quality 90.
    Jpeg,
    /// WebP, lossless.
    WebP,
    /// OpenEXR, f32.
    #[cfg(feature = "exr")]
    Exr,
    /// Binary portable pixmap.
    Ppm,
    /// Little-endian f32 and nothing else.
    F32,
}

impl Format {
    /// The format that the extension of `path` names.
    pub fn of(path: &Path) -> Option<Format> {
        Some(match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "png" => Format::Png,
            "jpg" | "jpeg" => Format::Jpeg,
            "webp" => Format::WebP,
            #[cfg(feature = "exr")]
            "exr" => Format::Exr,
            "ppm" => Format::Ppm,
            "f32" => Format::F32,
            _ => return None,
        })
    }

    /// Holds floats, and so linear colour.
    pub fn is_float(self) -> bool {
        match self {
            #[cfg(feature = "exr")]
            Format::Exr => true,
            Format::F32 => true,
            _ => false,
        }
    }

    /// Can hold 16 bits per sample.
    pub fn has_16_bits(self) -> bool {
        matches!(self, Format::Png | Format::Ppm)
    }

    /// Can hold an alpha channel.
    pub fn has_alpha(self) -> bool {
        !matches!(self, Format::Jpeg | Format::Ppm)
    }

    /// Longest side in pixels.
    pub fn max_side(self) -> u32 {
        match self {
            Format::WebP => 16383,
            _ => u32::MAX,
        }
    }
}

/// How hard PNG files are packed. Never changes a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PngCompression {
    /// Quick to write, files about a third larger.
    Fast,
    /// In between.
    Default,
    /// Slow to write, smallest files.
    Best,
}

/// A picture in memory, row-major, top row first.
#[derive(Clone, Debug, PartialEq)]
pub struct Pixels {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Samples per pixel, 1 to 4.
    pub channels: usize,
    /// `width * height * channels` of them.
    pub samples: Samples,
}

/// The numbers of a picture.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// 8 bits.
    U8(Vec<u8>),
    /// 16 bits.
    U16(Vec<u16>),
    /// Floats.
    F32(Vec<f32>),
}

/// The bytes of a file that holds `pixels`. Fails when the format cannot hold them.
pub fn encode(
    format: Format,
    pixels: &Pixels,
    compression: PngCompression,
) -> Result<Vec<u8>, String> {
    let mut file = Cursor::new(Vec::new());
    let written = match format {
        Format::Png => {
            let (level, filter) = match compression {
                PngCompression::Fast => (CompressionType::Fast, FilterType::Up),
                PngCompression::Default => (CompressionType::Default, FilterType::Adaptive),
                PngCompression::Best => (CompressionType::Best, FilterType::Adaptive),
            };
            write(PngEncoder::new_with_quality(&mut file, level, filter), pixels)
        }
        Format::Jpeg => write(JpegEncoder::new_with_quality(&mut file, 90), pixels),
        Format::WebP => write(WebPEncoder::new_lossless(&mut file), pixels),
        #[cfg(feature = "exr")]
        Format::Exr => {
            write(image::codecs::openexr::OpenExrEncoder::new(&mut file), &at_least_rgb(pixels))
        }
        Format::Ppm => return Ok(ppm(&at_least_rgb(pixels))),
        Format::F32 => {
            let Samples::F32(samples) = &pixels.samples else {
                return Err("a file of floats needs floats".into());
            };
            return Ok(samples.iter().flat_map(|sample| sample.to_le_bytes()).collect());
        }
    };
    written.map_err(|error| error.to_string())?;
    Ok(file.into_inner())
}

fn write(encoder: impl ImageEncoder, pixels: &Pixels) -> ImageResult<()> {
    let (color, bytes): (_, &[u8]) = match (&pixels.samples, pixels.channels) {
        (Samples::U8(samples), 1) => (ExtendedColorType::L8, samples),
        (Samples::U8(samples), 4) => (ExtendedColorType::Rgba8, samples),
        (Samples::U8(samples), _) => (ExtendedColorType::Rgb8, samples),
        (Samples::U16(samples), 1) => (ExtendedColorType::L16, bytemuck::cast_slice(samples)),
        (Samples::U16(samples), 4) => (ExtendedColorType::Rgba16, bytemuck::cast_slice(samples)),
        (Samples::U16(samples), _) => (ExtendedColorType::Rgb16, bytemuck::cast_slice(samples)),
        (Samples::F32(samples), 4) => (ExtendedColorType::Rgba32F, bytemuck::cast_slice(samples)),
        (Samples::F32(samples), _) => (ExtendedColorType::Rgb32F, bytemuck::cast_slice(samples)),
    };
    encoder.write_image(bytes, pixels.width, pixels.height, color)
}

/// Binary PPM by hand: the encoder at hand has no 16 bits. Alpha and floats never get here.
fn ppm(pixels: &Pixels) -> Vec<u8> {
    let header = |white: u16| format!("P6\n{} {}\n{white}\n", pixels.width, pixels.height);
    match &pixels.samples {
        Samples::U8(samples) => [header(255).as_bytes(), samples].concat(),
        Samples::U16(samples) => {
            let bytes = samples.iter().flat_map(|sample| sample.to_be_bytes());
            header(65535).into_bytes().into_iter().chain(bytes).collect()
        }
        Samples::F32(_) => unreachable!("plans give floats to float formats only"),
    }
}

/// Grey three times, or two channels and a third of zeros, for formats without either.
fn at_least_rgb(pixels: &Pixels) -> Pixels {
    fn widen<T: Copy + Default>(samples: &[T], channels: usize) -> Vec<T> {
        let rgb = |pixel: &[T]| match *pixel {
            [grey] => [grey; 3],
            [r, g] => [r, g, T::default()],
            _ => unreachable!("only one or two channels are widened"),
        };
        samples.chunks_exact(channels).flat_map(rgb).collect()
    }
    if pixels.channels > 2 {
        return pixels.clone();
    }
    let samples = match &pixels.samples {
        Samples::U8(samples) => Samples::U8(widen(samples, pixels.channels)),
        Samples::U16(samples) => Samples::U16(widen(samples, pixels.channels)),
        Samples::F32(samples) => Samples::F32(widen(samples, pixels.channels)),
    };
    Pixels { channels: 3, samples, ..*pixels }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(channels: usize, samples: Samples) -> Pixels {
        Pixels { width: 2, height: 1, channels, samples }
    }

    fn file(format: Format, pixels: &Pixels) -> Vec<u8> {
        encode(format, pixels, PngCompression::Fast).unwrap()
    }

    #[test]
    fn extensions_name_formats_in_any_case() {
        assert_eq!(Format::of(Path::new("a.b/x.PNG")), Some(Format::Png));
        assert_eq!(Format::of(Path::new("x.jpeg")), Some(Format::Jpeg));
        for path in ["x", "x.", ".png", "x.gif", "png"] {
            assert_eq!(Format::of(Path::new(path)), None, "{path}");
        }
    }

    #[test]
    fn lossless_formats_give_back_what_they_got() {
        let bytes = vec![0, 1, 2, 253, 254, 255];
        let rgb = picture(3, Samples::U8(bytes.clone()));
        for format in [Format::Png, Format::WebP, Format::Ppm] {
            let read = image::load_from_memory(&file(format, &rgb)).unwrap();
            assert_eq!(read.into_rgb8().into_raw(), bytes, "{format:?}");
        }
        let words = vec![0, 1, 256, 65535, 40000, 7];
        let rgb = picture(3, Samples::U16(words.clone()));
        for format in [Format::Png, Format::Ppm] {
            let read = image::load_from_memory(&file(format, &rgb)).unwrap();
            assert_eq!(read.into_rgb16().into_raw(), words, "{format:?}");
        }
        let grey = file(Format::Png, &picture(1, Samples::U16(vec![5, 65535])));
        let read = image::load_from_memory(&grey).unwrap();
        assert_eq!(read.into_luma16().into_raw(), [5, 65535]);
    }

    #[test]
    fn every_compression_holds_the_same_pixels() {
        let rgba = picture(4, Samples::U8((0..8).collect()));
        for compression in PngCompression::value_variants() {
            let png = encode(Format::Png, &rgba, *compression).unwrap();
            let read = image::load_from_memory(&png).unwrap().into_rgba8();
            assert_eq!(read.into_raw(), (0..8).collect::<Vec<u8>>());
        }
    }

    #[test]
    fn float_formats_keep_infinities() {
        let depth = picture(1, Samples::F32(vec![1.5, f32::INFINITY]));
        let raw = file(Format::F32, &depth);
        assert_eq!(raw, [1.5f32.to_le_bytes(), f32::INFINITY.to_le_bytes()].concat());
        #[cfg(feature = "exr")]
        {
            let read = image::load_from_memory(&file(Format::Exr, &depth)).unwrap();
            let read = read.into_rgb32f().into_raw();
            assert_eq!(read[0], 1.5);
            assert_eq!(read[3..], [f32::INFINITY; 3]);
        }
    }
}
