//! Depth formats: how near a sample is, in a few bytes.
//!
//! A sample's depth is interpolated in f64 as reversed depth (1 near, 0 far) and rounded once,
//! into the format. What the formats cost and lose: Upchurch & Desbrun 2012, "Tightening the
//! Precision of Perspective Rendering"; Reed 2015, "Depth Precision Visualized".

/// A way to store depth. `Code`s of the same format are compared by [`DepthFormat::nearer`];
/// equal codes are a tie, which the lower triangle id wins.
pub trait DepthFormat: Copy + core::fmt::Debug + Send + Sync + 'static {
    /// What is stored per sample.
    type Code: Copy + PartialEq + Send + Sync + core::fmt::Debug;
    /// Farther than, or as far as, everything.
    const FARTHEST: Self::Code;
    /// Rounds reversed depth, in `0..=1`, to the nearest code.
    fn encode(reversed: f64) -> Self::Code;
    /// Whether `a` is strictly nearer than `b`.
    fn nearer(a: Self::Code, b: Self::Code) -> bool;
    /// The code as an integer, at least 0, that is larger where the code is nearer, and 0 for
    /// [`DepthFormat::FARTHEST`]: one order for all formats.
    fn key(code: Self::Code) -> i32;
}

/// The key of a reversed depth in `0..=1`, [`ReversedF32`]: the bits of floats that are not
/// negative are in the order of their values.
#[inline(always)]
pub(crate) fn reversed_key(depth: f32) -> i32 {
    (depth + 0.0).to_bits() as i32 // the sum has no negative zero
}

/// f32, 1 at the near plane. The default. In perspective about 1e-7 of the distance at any
/// distance, as long as near over distance is a normal f32 (above 1.2e-38). In orthographic
/// views 6e-8 of far minus near, everywhere: there, keep far no farther than needed.
#[derive(Clone, Copy, Debug)]
pub struct ReversedF32;

/// f32, 0 at the near plane, as OpenGL has it.
#[derive(Clone, Copy, Debug)]
pub struct StandardF32;

/// 24 bits, 0 at the near plane.
#[derive(Clone, Copy, Debug)]
pub struct StandardU24;

/// 16 bits, 0 at the near plane.
#[derive(Clone, Copy, Debug)]
pub struct StandardU16;

impl DepthFormat for ReversedF32 {
    type Code = f32;
    const FARTHEST: f32 = 0.0;
    fn encode(reversed: f64) -> f32 {
        reversed as f32
    }
    fn nearer(a: f32, b: f32) -> bool {
        a > b
    }
    fn key(code: Self::Code) -> i32 {
        reversed_key(code)
    }
}

impl DepthFormat for StandardF32 {
    type Code = f32;
    const FARTHEST: f32 = 1.0;
    fn encode(reversed: f64) -> f32 {
        (1.0 - reversed) as f32
    }
    fn nearer(a: f32, b: f32) -> bool {
        a < b
    }
    fn key(code: Self::Code) -> i32 {
        1f32.to_bits() as i32 - reversed_key(code)
    }
}

impl DepthFormat for StandardU24 {
    type Code = u32;
    const FARTHEST: u32 = (1 << 24) - 1;
    fn encode(reversed: f64) -> u32 {
        ((1.0 - reversed) * f64::from(Self::FARTHEST)).round_ties_even() as u32
    }
    fn nearer(a: u32, b: u32) -> bool {
        a < b
    }
    fn key(code: Self::Code) -> i32 {
        (Self::FARTHEST - code) as i32
    }
}

impl DepthFormat for StandardU16 {
    type Code = u16;
    const FARTHEST: u16 = u16::MAX;
    fn encode(reversed: f64) -> u16 {
        ((1.0 - reversed) * f64::from(u16::MAX)).round_ties_even() as u16
    }
    fn nearer(a: u16, b: u16) -> bool {
        a < b
    }
    fn key(code: Self::Code) -> i32 {
        i32::from(Self::FARTHEST - code)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check<D: DepthFormat>() {
        let codes: Vec<_> = (0..=1000).map(|i| D::encode(f64::from(i) / 1000.0)).collect();
        assert_eq!(codes[0], D::FARTHEST);
        for pair in codes.windows(2) {
            assert!(D::nearer(pair[1], pair[0]) && !D::nearer(pair[0], pair[1]));
        }
        assert!(!D::nearer(codes[7], codes[7]));
        assert_eq!(D::key(D::FARTHEST), 0);
        assert!(codes.windows(2).all(|pair| D::key(pair[0]) < D::key(pair[1])));
    }

    #[test]
    fn every_format_orders_depths() {
        check::<ReversedF32>();
        check::<StandardF32>();
        check::<StandardU24>();
        check::<StandardU16>();
    }

    #[test]
    fn reversed_f32_tells_far_things_apart() {
        let (near, d) = (0.1, 1e9);
        let gap = d * 1e-6;
        assert_ne!(ReversedF32::encode(near / d), ReversedF32::encode(near / (d + gap)));
        assert_eq!(StandardU24::encode(near / d), StandardU24::encode(near / (d + gap)));
    }
}
