//! Why two pictures cannot be compared, or one cannot be made.

use crate::Picture;

/// What was wrong with the pictures handed in.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum MeasureError {
    /// Only pictures of one size can be compared; sizes are (width, height) in pixels.
    #[error("sizes differ: the reference is {}x{}, the candidate {}x{}",
        reference.0, reference.1, candidate.0, candidate.1)]
    SizesDiffer {
        /// Size of the reference.
        reference: (usize, usize),
        /// Size of the candidate.
        candidate: (usize, usize),
    },
    /// A picture without pixels has no mean of anything.
    #[error("a picture needs at least one pixel, not {width}x{height}")]
    Empty {
        /// Width asked for, pixels.
        width: usize,
        /// Height asked for, pixels.
        height: usize,
    },
    /// The samples do not fill the size given.
    #[error("expected {expected} samples, found {found}")]
    WrongLength {
        /// Width times height times channels.
        expected: usize,
        /// Length of the slice.
        found: usize,
    },
    /// A value is NaN or lies outside [0, 1], where sRGB-encoded values live.
    #[error("{value} at pixel ({x}, {y}) is not a number from 0 to 1")]
    OutOfRange {
        /// Column, 0 at the left.
        x: usize,
        /// Row, 0 at the top.
        y: usize,
        /// The offending value.
        value: f32,
    },
}

/// `Ok` when the two may be compared.
pub(crate) fn same_size(reference: &Picture, candidate: &Picture) -> Result<(), MeasureError> {
    let size = |p: &Picture| (p.width(), p.height());
    if size(reference) == size(candidate) {
        return Ok(());
    }
    Err(MeasureError::SizesDiffer { reference: size(reference), candidate: size(candidate) })
}
