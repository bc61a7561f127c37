//! The picture's rectangle of pixels, and the last step of the chain: ndc to screen.

use crate::{NdcPoint, ScreenPoint};

/// Longest side of a picture in pixels: with the guard band, 24.8 fixed point and its edge
/// functions then stay inside 64-bit integers.
pub const MAX_SIDE: u32 = 32768;

/// Why a viewport cannot be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ViewportError {
    /// A side of 0 pixels.
    #[error("a picture of {0}x{1} pixels has no pixels; give both sides at least 1")]
    Empty(u32, u32),
    /// A side longer than [`MAX_SIDE`].
    #[error("a picture of {0}x{1} pixels is too large: no side may exceed {MAX_SIDE} pixels")]
    TooLarge(u32, u32),
}

/// Width and height of the picture in pixels, each in `1..=MAX_SIDE`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Viewport {
    width: u32,
    height: u32,
}

impl Viewport {
    /// Checks the sides.
    pub fn new(width: u32, height: u32) -> Result<Self, ViewportError> {
        if width == 0 || height == 0 {
            return Err(ViewportError::Empty(width, height));
        }
        if width > MAX_SIDE || height > MAX_SIDE {
            return Err(ViewportError::TooLarge(width, height));
        }
        Ok(Viewport { width, height })
    }

    /// Pixels across.
    pub const fn width(self) -> u32 {
        self.width
    }

    /// Pixels down.
    pub const fn height(self) -> u32 {
        self.height
    }

    /// Width over height.
    pub fn aspect(self) -> f64 {
        f64::from(self.width) / f64::from(self.height)
    }

    /// Half as many pixels each way, rounded up.
    #[must_use]
    pub const fn halved(self) -> Viewport {
        Viewport { width: self.width.div_ceil(2), height: self.height.div_ceil(2) }
    }

    /// Ndc (y up, -1..1) to pixels (y down, origin top left). Depth passes through.
    pub fn screen_from_ndc(self, ndc: NdcPoint) -> ScreenPoint {
        ScreenPoint {
            x: (0.5 + 0.5 * ndc.x) * f64::from(self.width),
            y: (0.5 - 0.5 * ndc.y) * f64::from(self.height),
            depth: ndc.depth,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_are_checked() {
        assert_eq!(Viewport::new(0, 3), Err(ViewportError::Empty(0, 3)));
        assert_eq!(Viewport::new(3, 0), Err(ViewportError::Empty(3, 0)));
        assert_eq!(Viewport::new(65535, 1), Err(ViewportError::TooLarge(65535, 1)));
        assert_eq!(Viewport::new(MAX_SIDE, 1).map(Viewport::width), Ok(MAX_SIDE));
    }

    #[test]
    fn ndc_corners_land_on_picture_corners() {
        let viewport = Viewport::new(640, 480).unwrap();
        let screen = |x, y| {
            let p = viewport.screen_from_ndc(NdcPoint { x, y, depth: 0.5 });
            (p.x, p.y)
        };
        assert_eq!(screen(-1.0, 1.0), (0.0, 0.0));
        assert_eq!(screen(1.0, -1.0), (640.0, 480.0));
        assert_eq!(screen(0.0, 0.0), (320.0, 240.0));
    }
}
