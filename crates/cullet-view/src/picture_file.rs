//! Pictures as files.

use std::fs::File;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};

/// `pixels` (0RGB, row-major, `width * height`) as a .png file in memory.
pub fn png(pixels: &[u32], width: u32, height: u32) -> io::Result<Vec<u8>> {
    let rgb = pixels.iter().map(|pixel| pixel.to_be_bytes());
    let rgb: Vec<u8> = rgb.flat_map(|[_, r, g, b]| [r, g, b]).collect();
    let mut file = Vec::new();
    PngEncoder::new(&mut file)
        .write_image(&rgb, width, height, ExtendedColorType::Rgb8)
        .map_err(io::Error::other)?;
    Ok(file)
}

/// Writes `bytes` to the first of `cullet-view-0001.png`, `-0002`, … in `folder` that does not
/// exist yet, and says which.
pub fn write_numbered(folder: &Path, bytes: &[u8]) -> io::Result<PathBuf> {
    for number in 1..10_000 {
        let path = folder.join(format!("cullet-view-{number:04}.png"));
        match File::create_new(&path) {
            Ok(mut file) => {
                let written = file.write_all(bytes);
                return written.map(|()| path);
            }
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
    Err(io::Error::new(ErrorKind::AlreadyExists, "all numbers up to 9999 are taken"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_survive_their_file() {
        let pixels = [0xff_0000, 0x00_ff00, 0x00_00ff, 0x12_3456, 0, 0xff_ffff];
        let file = image::load_from_memory(&png(&pixels, 3, 2).unwrap()).unwrap().to_rgb8();
        assert_eq!((file.width(), file.height()), (3, 2));
        assert_eq!(file.get_pixel(0, 1).0, [0x12, 0x34, 0x56]);
    }

    #[test]
    fn screenshots_never_overwrite() {
        let folder = tempfile::tempdir().unwrap();
        let taken = folder.path().join("cullet-view-0001.png");
        std::fs::write(&taken, "precious").unwrap();
        for expected in ["cullet-view-0002.png", "cullet-view-0003.png"] {
            let path = write_numbered(folder.path(), b"new").unwrap();
            assert_eq!(path, folder.path().join(expected));
        }
        assert_eq!(std::fs::read(&taken).unwrap(), b"precious");
        assert!(write_numbered(&folder.path().join("none"), b"").is_err());
    }
}
