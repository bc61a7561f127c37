//! From the bytes of image files to pixels.
//!
//! Images are recognised by content, never by name. Sizes are asked of all before any is decoded,
//! so that the limit holds before memory is taken; then each is a task of its own. Files of the
//! same bytes are decoded once: exporters write one image under many names.

use std::borrow::Cow;
use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::io::Cursor;

use image::{ImageFormat, ImageReader, Limits};
use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;
use zune_jpeg::JpegDecoder;

use crate::Image;
use crate::tasks::{Run, Task};

/// Why there are no pixels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Failure {
    /// The file is damaged or of an unknown kind, in words.
    Damaged(String),
    /// More pixels than are left.
    TooBig,
}

/// The file of an image that can be decoded as far as its header tells.
#[derive(Debug)]
pub(crate) struct Encoded<'a> {
    bytes: Cow<'a, [u8]>,
    format: ImageFormat,
    width: u32,
    height: u32,
}

impl<'a> Encoded<'a> {
    /// Reads the header of a PNG, JPEG or WebP file, and takes its size off `pixels_left`.
    pub fn open(bytes: Cow<'a, [u8]>, pixels_left: &mut u64) -> Result<Encoded<'a>, Failure> {
        let format = match image::guess_format(&bytes) {
            Ok(format @ (ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP)) => format,
            _ => return Err(Failure::Damaged("is neither PNG, JPEG nor WebP".into())),
        };
        let size = ImageReader::with_format(Cursor::new(&*bytes), format).into_dimensions();
        let (width, height) = size.map_err(damaged)?;
        let encoded = Encoded { bytes, format, width, height };
        *pixels_left = pixels_left.checked_sub(encoded.n_pixels()).ok_or(Failure::TooBig)?;
        Ok(encoded)
    }

    fn n_pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// The pixels, as RGBA with 8 bits. The image has no name yet.
    pub fn decode(&self) -> Result<Image, Failure> {
        if self.format == ImageFormat::Jpeg
            && let Some(image) = self.decode_jpeg()
        {
            return Ok(image);
        }
        self.decode_any()
    }

    /// A whole JPEG of three colours straight to RGBA: a pass and a buffer less than
    /// [`Self::decode_any`], with the same pixels. `None` for all others.
    fn decode_jpeg(&self) -> Option<Image> {
        let (width, height) = (self.width as usize, self.height as usize);
        let options = DecoderOptions::default()
            .set_strict_mode(false)
            .set_max_width(width)
            .set_max_height(height)
            .jpeg_set_out_colorspace(ColorSpace::RGBA);
        let mut decoder = JpegDecoder::new_with_options(ZCursor::new(&*self.bytes), options);
        decoder.decode_headers().ok()?;
        if decoder.input_colorspace() != Some(ColorSpace::YCbCr)
            || decoder.dimensions() != Some((width, height))
        {
            return None;
        }
        let rgba = decoder.decode().ok()?;
        let (width, height) = (self.width, self.height);
        let is_whole = rgba.len() as u64 == 4 * self.n_pixels();
        is_whole.then(|| Image { width, height, rgba, ..Image::default() })
    }

    /// Every format and kind that `image` can read.
    fn decode_any(&self) -> Result<Image, Failure> {
        let mut reader = ImageReader::with_format(Cursor::new(&*self.bytes), self.format);
        let mut limits = Limits::no_limits();
        limits.max_alloc = Some(self.n_pixels().saturating_mul(MAX_BYTES_PER_PIXEL) + SPARE_BYTES);
        reader.limits(limits);
        let rgba = reader.decode().map_err(damaged)?.into_rgba8();
        let (width, height) = rgba.dimensions();
        Ok(Image { width, height, rgba: rgba.into_raw(), ..Image::default() })
    }
}

/// What became of one file.
pub(crate) type Decoded = Result<Image, Failure>;

/// Decodes all files that could be opened, while `meanwhile` runs, which is taken to be long.
/// An error in `opened` stays one.
pub(crate) fn decode_all<'t>(
    opened: &'t [Result<Encoded<'_>, Failure>],
    run: Run<'_>,
    meanwhile: Option<Task<'t>>,
) -> Vec<Decoded> {
    let mut known = BTreeMap::new();
    let first_equal = |(i, opened): (usize, &'t Result<Encoded<'_>, _>)| match opened {
        Ok(Encoded { bytes, .. }) => *known.entry((bytes.len(), &**bytes)).or_insert(i),
        Err(_) => i,
    };
    let first: Vec<usize> = opened.iter().enumerate().map(first_equal).collect();

    let mut decoded: Vec<Decoded> = opened
        .iter()
        .map(|opened| opened.as_ref().map(|_| Image::default()).map_err(Failure::clone))
        .collect();
    let mut places_of_file: BTreeMap<usize, Vec<&mut Decoded>> = BTreeMap::new();
    for (place, first) in decoded.iter_mut().zip(&first) {
        places_of_file.entry(*first).or_default().push(place);
    }
    let job = |(i, places): (usize, _)| Some((opened[i].as_ref().ok()?, places));
    let mut jobs: Vec<_> = places_of_file.into_iter().filter_map(job).collect();
    // The longest first: what is left at the end for one thread alone should be short.
    jobs.sort_by_key(|(encoded, _)| Reverse(encoded.n_pixels()));
    let tasks = jobs.into_iter().map(|(encoded, places)| {
        Task::image(move |finish| {
            let mut places = places.into_iter();
            let first = places.next().expect("every file has a place");
            *first = encoded.decode();
            if let Ok(image) = first {
                finish(image);
            }
            places.for_each(|place| *place = first.clone());
        })
    });
    run(meanwhile.into_iter().chain(tasks).collect());
    decoded
}

fn damaged(error: image::ImageError) -> Failure {
    Failure::Damaged(format!("cannot be decoded: {error}"))
}

/// 16-bit RGBA and as much again for the decoder.
const MAX_BYTES_PER_PIXEL: u64 = 16;
/// For tables and metadata.
const SPARE_BYTES: u64 = 1 << 26;

/// 8x8 pixels of magenta and black, in place of an image that cannot be shown: a missing texture
/// should be seen, not guessed at.
pub(crate) fn placeholder() -> Image {
    let pixel = |i: usize| match (i + i / 8) % 2 {
        0 => [255, 0, 255, 255],
        _ => [0, 0, 0, 255],
    };
    let rgba = (0..64).flat_map(pixel).collect();
    Image { width: 8, height: 8, rgba, placeholder: true, ..Image::default() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{DynamicImage, GrayImage, ImageBuffer, Luma};

    use crate::tasks::TaskKind;

    fn encode(image: DynamicImage, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    fn decode(bytes: &[u8], pixels_left: &mut u64) -> Decoded {
        Encoded::open(Cow::Borrowed(bytes), pixels_left)?.decode()
    }

    #[test]
    fn grey_and_16_bit_images_become_rgba() {
        let grey = GrayImage::from_pixel(2, 1, Luma([100]));
        let bytes = encode(grey.into(), ImageFormat::Png);
        let image = decode(&bytes, &mut 2).unwrap();
        assert_eq!((image.width, image.height), (2, 1));
        assert_eq!(image.rgba, [100, 100, 100, 255, 100, 100, 100, 255]);

        let deep: ImageBuffer<Luma<u16>, Vec<u16>> = ImageBuffer::from_pixel(1, 1, Luma([0xffff]));
        let bytes = encode(deep.into(), ImageFormat::Png);
        assert_eq!(decode(&bytes, &mut 9).unwrap().rgba, [255; 4]);
    }

    #[test]
    fn jpeg_has_the_same_pixels_by_either_way() {
        let mut seed = 1u32;
        let mut noise = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 24) as u8
        };
        // Widths around the widths of wide code, smooth and rough.
        for (width, height) in [(1, 1), (7, 9), (16, 16), (33, 17), (130, 40)] {
            let mut picture = image::RgbImage::from_fn(width, height, |x, y| {
                image::Rgb([(3 * x) as u8, (5 * y) as u8, (x + y) as u8])
            });
            for (i, pixel) in picture.pixels_mut().enumerate() {
                if i % 3 == 0 {
                    pixel.0 = [noise(), noise(), noise()];
                }
            }
            let bytes = encode(picture.into(), ImageFormat::Jpeg);
            let encoded = Encoded::open(Cow::Borrowed(&bytes), &mut 10_000).unwrap();
            let fast = encoded.decode_jpeg().expect("three colours");
            let plain = encoded.decode_any().unwrap();
            assert_eq!((fast.width, fast.height), (width, height));
            assert!(fast.rgba == plain.rgba, "{width}x{height}");
        }
        let grey = encode(GrayImage::new(9, 9).into(), ImageFormat::Jpeg);
        let encoded = Encoded::open(Cow::Borrowed(&grey), &mut 100).unwrap();
        assert!(encoded.decode_jpeg().is_none());
        assert_eq!(encoded.decode().unwrap().rgba.len(), 4 * 81);
    }

    #[test]
    fn the_pixel_budget_is_asked_before_decoding() {
        let bytes = encode(GrayImage::new(4, 4).into(), ImageFormat::Png);
        let mut pixels_left = 20;
        assert!(decode(&bytes, &mut pixels_left).is_ok());
        assert_eq!(pixels_left, 4);
        assert!(matches!(decode(&bytes, &mut pixels_left), Err(Failure::TooBig)));
    }

    #[test]
    fn damaged_images_are_refused() {
        let bytes = encode(GrayImage::new(64, 64).into(), ImageFormat::Png);
        for cut in [&b""[..], b"GIF89a", &bytes[..40], &bytes[..bytes.len() - 30]] {
            assert!(matches!(decode(cut, &mut 9999), Err(Failure::Damaged(_))));
        }
    }

    #[test]
    fn files_of_the_same_bytes_are_decoded_once_and_every_place_has_the_pixels() {
        let grey =
            |value| encode(GrayImage::from_pixel(3, 2, Luma([value])).into(), ImageFormat::Png);
        let (a, b) = (grey(1), grey(2));
        let cut = &b[..b.len() - 20];
        let open = |bytes| Encoded::open(Cow::Borrowed(bytes), &mut 100);
        let files = [&a[..], &b, &a, cut, b"text", cut];
        let opened: Vec<_> = files.into_iter().map(open).collect();
        let n_tasks = std::sync::Mutex::new(0);
        let run = |tasks: Vec<Task<'_>>| {
            *n_tasks.lock().unwrap() = tasks.len();
            tasks.into_iter().rev().for_each(Task::run);
        };
        let mut ran = false;
        let decoded = decode_all(&opened, &run, Some(Task::new(TaskKind::Geometry, || ran = true)));
        assert_eq!(*n_tasks.lock().unwrap(), 1 + 3);
        assert!(ran);
        for (i, value) in [(0, 1), (1, 2), (2, 1)] {
            let image = decoded[i].as_ref().unwrap();
            assert_eq!((image.width, image.height), (3, 2));
            assert!(image.rgba.chunks(4).all(|pixel| pixel == [value, value, value, 255]));
        }
        assert!(decoded[3..].iter().all(|decoded| matches!(decoded, Err(Failure::Damaged(_)))));
    }
}
