//! What pixels do the base colours need?
//!
//! Images are recognised by content, never by name. One that cannot be shown becomes a
//! visible checkerboard with a warning: a missing texture should be seen, not guessed at.

use std::io::Cursor;

use ::gltf::json::Image as ImageJson;
use image::{ImageFormat, ImageReader, Limits};

use super::accessor::view_bytes;
use super::{Input, Output, materials};
use crate::{Image, LoadError};

/// Decodes the images that the base colours of drawn objects use.
pub(super) fn decode(input: &Input<'_>, output: &mut Output) -> Result<(), LoadError> {
    let mut used_materials = vec![false; output.scene.materials.len()];
    for object in &output.scene.objects {
        used_materials[object.material] = true;
    }
    materials::warn_about_blending(output, &used_materials);
    if !input.options.textures {
        return Ok(());
    }
    let mut used_images = vec![false; output.scene.images.len()];
    for (material, _) in output.scene.materials.iter().zip(&used_materials).filter(|pair| *pair.1) {
        if let Some(texture) = &material.base_color_texture {
            used_images[output.scene.textures[texture.texture].image] = true;
        }
    }
    let mut pixels_left = input.options.max_image_pixels;
    for i in (0..used_images.len()).filter(|&i| used_images[i]) {
        let json = &input.document.root.images[i];
        let name = std::mem::take(&mut output.scene.images[i].name);
        let place = format!("image `{name}`");
        let decoded = match read_bytes(input, json) {
            Ok(bytes) => decode_one(&bytes, &mut pixels_left),
            Err(error @ LoadError::Limit { .. }) => return Err(error),
            Err(error) => Err(Failure::Damaged(error.to_string())),
        };
        output.scene.images[i] = match decoded {
            Ok(image) => Image { name, ..image },
            Err(Failure::Damaged(problem)) => {
                output.warn(&place, format_args!("{problem}; a checkerboard is shown instead"));
                Image { name, ..placeholder() }
            }
            Err(Failure::TooBig) => {
                return Err(LoadError::Limit {
                    path: input.name.to_string(),
                    what: format!("the number of pixels up to {place}"),
                    limit: input.options.max_image_pixels,
                    option: "--max-image-pixels",
                });
            }
        };
    }
    Ok(())
}

fn read_bytes(input: &Input<'_>, json: &ImageJson) -> Result<Vec<u8>, LoadError> {
    let damaged =
        |problem: String| LoadError::invalid(input.name, "", problem, "export the model again");
    match (json.buffer_view, &json.uri) {
        (Some(view), _) => view_bytes(&input.document.root, input.buffers, view)
            .map(<[u8]>::to_vec)
            .map_err(damaged),
        (None, Some(uri)) => input.files.read(uri),
        (None, None) => Err(damaged("has neither a file nor a buffer view".into())),
    }
}

pub(crate) enum Failure {
    Damaged(String),
    TooBig,
}

/// Decodes PNG, JPEG or WebP to RGBA with 8 bits, and takes its size off `pixels_left`.
pub(crate) fn decode_one(bytes: &[u8], pixels_left: &mut u64) -> Result<Image, Failure> {
    let damaged =
        |error: image::ImageError| Failure::Damaged(format!("cannot be decoded: {error}"));
    let format = match image::guess_format(bytes) {
        Ok(format @ (ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP)) => format,
        _ => return Err(Failure::Damaged("is neither PNG, JPEG nor WebP".into())),
    };
    let size = ImageReader::with_format(Cursor::new(bytes), format).into_dimensions();
    let (width, height) = size.map_err(damaged)?;
    let n_pixels = u64::from(width) * u64::from(height);
    if n_pixels > *pixels_left {
        return Err(Failure::TooBig);
    }
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(n_pixels.saturating_mul(MAX_BYTES_PER_PIXEL) + SPARE_BYTES);
    reader.limits(limits);
    let rgba = reader.decode().map_err(damaged)?.into_rgba8();
    *pixels_left -= n_pixels;
    Ok(Image { width, height, rgba: rgba.into_raw(), ..Image::default() })
}

/// 16-bit RGBA and as much again for the decoder.
const MAX_BYTES_PER_PIXEL: u64 = 16;
/// For tables and metadata.
const SPARE_BYTES: u64 = 1 << 26;

/// 8x8 pixels of magenta and black.
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

    fn encode(image: DynamicImage, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn grey_and_16_bit_images_become_rgba() {
        let grey = GrayImage::from_pixel(2, 1, Luma([100]));
        let bytes = encode(grey.into(), ImageFormat::Png);
        let image = decode_one(&bytes, &mut 2).ok().unwrap();
        assert_eq!((image.width, image.height), (2, 1));
        assert_eq!(image.rgba, [100, 100, 100, 255, 100, 100, 100, 255]);

        let deep: ImageBuffer<Luma<u16>, Vec<u16>> = ImageBuffer::from_pixel(1, 1, Luma([0xffff]));
        let bytes = encode(deep.into(), ImageFormat::Png);
        assert_eq!(decode_one(&bytes, &mut 9).ok().unwrap().rgba, [255; 4]);
    }

    #[test]
    fn the_pixel_budget_is_asked_before_decoding() {
        let bytes = encode(GrayImage::new(4, 4).into(), ImageFormat::Png);
        let mut pixels_left = 20;
        assert!(decode_one(&bytes, &mut pixels_left).is_ok());
        assert_eq!(pixels_left, 4);
        assert!(matches!(decode_one(&bytes, &mut pixels_left), Err(Failure::TooBig)));
    }

    #[test]
    fn damaged_images_are_refused() {
        let bytes = encode(GrayImage::new(64, 64).into(), ImageFormat::Png);
        for cut in [&b""[..], b"GIF89a", &bytes[..40], &bytes[..bytes.len() - 30]] {
            assert!(matches!(decode_one(cut, &mut 9999), Err(Failure::Damaged(_))));
        }
    }
}
