//! Between linear light and sRGB bytes, exactly.
//!
//! Decoding looks up one of 256 floats. Encoding to 8 bits asks for the number of
//! thresholds at or below a value, where threshold `k` is the smallest f32 that the exact
//! curve rounds to code `k`: the leading bits of the float say where to start counting,
//! and they are fine enough that one comparison finishes. So the fast encoder *is* the
//! rounded exact curve, for every f32.
//!
//! Values are linear or encoded in `[0, 1]`; alpha never passes through here.
//! Source: IEC 61966-2-1:1999, the transfer function with its printed constants.

use std::sync::LazyLock;

use crate::select::clamp;

/// Linear light of each 8-bit code, rounded once from the f64 curve.
pub static DECODE: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|code| decode_exact(code as f64 / 255.0) as f32));

/// Linear light, in `[0, 1]`, of an 8-bit code.
pub fn decode8(code: u8) -> f32 {
    DECODE[usize::from(code)]
}

/// The 8-bit code nearest to the exact curve at `linear`.
///
/// NaN and everything up to 0 give 0; everything from 1 up, infinity included, gives 255.
pub fn encode8(linear: f32) -> u8 {
    let encoder = &*ENCODER;
    if linear >= 1.0 {
        return 255;
    }
    let above_black = linear >= encoder.thresholds[1]; // false for NaN
    if !above_black {
        return 0;
    }
    let bucket = (linear.to_bits() >> BUCKET_SHIFT) - FIRST_BUCKET;
    let code = encoder.first_code[bucket as usize];
    code + u8::from(linear >= encoder.thresholds[usize::from(code) + 1])
}

/// The 16-bit code nearest to the exact curve; ends and NaN as in [`encode8`].
pub fn encode16(linear: f32) -> u16 {
    nearest_code(linear, 65535.0) as u16
}

/// The exact curve, rounded once to f32. Clamps to `[0, 1]`; NaN gives 0.
pub fn encode(linear: f32) -> f32 {
    encode_exact(clamp(f64::from(linear), 0.0, 1.0)) as f32
}

/// Twin of [`encode8`]: the exact curve in f64, rounded to the nearest code. No f32 lies so
/// near a boundary between codes that f64 could misjudge it (a test looks).
pub fn encode8_exact(linear: f32) -> u8 {
    nearest_code(linear, 255.0) as u8
}

fn nearest_code(linear: f32, white: f64) -> u32 {
    let encoded = encode_exact(clamp(f64::from(linear), 0.0, 1.0));
    (encoded * white + 0.5) as u32 // in 0.5..=white + 0.5
}

/// Linear to encoded, both in `[0, 1]`, in f64.
pub fn encode_exact(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055
    }
}

/// Encoded to linear, both in `[0, 1]`, in f64.
pub fn decode_exact(encoded: f64) -> f64 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
}

/// Buckets are 1/128 of an octave: the curve rises by at most 0.88 of a code in one.
const BUCKET_SHIFT: u32 = 16;
/// The bucket of 2^-13, just below the first threshold.
const FIRST_BUCKET: u32 = (127 - 13) << (23 - BUCKET_SHIFT);
/// Thirteen octaves, up to 1.
const N_BUCKETS: usize = 13 << (23 - BUCKET_SHIFT);

struct Encoder {
    /// `thresholds[k]`: the smallest f32 whose nearest code is `k`. The first is unused; a
    /// last one, never reached, spares the comparison a bound.
    thresholds: [f32; 257],
    /// Code of the smallest float in each bucket.
    first_code: [u8; N_BUCKETS],
}

static ENCODER: LazyLock<Encoder> = LazyLock::new(|| Encoder {
    thresholds: std::array::from_fn(|code| match code {
        0 => 0.0,
        256 => f32::INFINITY,
        _ => smallest_with_code(code as u8),
    }),
    first_code: std::array::from_fn(|bucket| {
        encode8_exact(f32::from_bits((FIRST_BUCKET + bucket as u32) << BUCKET_SHIFT))
    }),
});

/// Positive floats order like their bits, so the threshold is found by bisection.
fn smallest_with_code(code: u8) -> f32 {
    let (mut below, mut reached) = (0, 1.0_f32.to_bits());
    while reached - below > 1 {
        let middle = below + (reached - below) / 2;
        if encode8_exact(f32::from_bits(middle)) >= code {
            reached = middle;
        } else {
            below = middle;
        }
    }
    f32::from_bits(reached)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    #[track_caller]
    fn check(linear: f32) {
        assert_eq!(encode8(linear), encode8_exact(linear), "at {linear:e}");
    }

    #[test]
    fn fast_and_exact_agree_around_every_threshold() {
        for code in 1..=255 {
            let threshold = smallest_with_code(code).to_bits();
            (threshold - 4..=threshold + 4).for_each(|bits| check(f32::from_bits(bits)));
            assert_eq!(encode8(f32::from_bits(threshold)), code);
            assert_eq!(encode8(f32::from_bits(threshold - 1)), code - 1);
        }
    }

    #[test]
    fn no_float_is_near_a_tie() {
        for code in 1..=255 {
            let threshold = smallest_with_code(code).to_bits();
            for linear in [threshold - 1, threshold].map(f32::from_bits) {
                let exact = encode_exact(f64::from(linear)) * 255.0;
                assert!((exact - (f64::from(code) - 0.5)).abs() > 1e-12, "code {code}");
            }
        }
    }

    #[test]
    fn fast_and_exact_agree_around_every_bucket() {
        for bucket in FIRST_BUCKET..=FIRST_BUCKET + N_BUCKETS as u32 {
            let bits = bucket << BUCKET_SHIFT;
            (bits - 2..=bits + 2).for_each(|bits| check(f32::from_bits(bits)));
        }
    }

    #[test]
    fn fast_and_exact_agree_on_a_million_floats() {
        let mut random = Random::new(1);
        for _ in 0..500_000 {
            check(random.unit());
            check(f32::from_bits(random.bits()));
        }
    }

    #[test]
    fn ends_are_clamped() {
        let cases = [
            (f32::NAN, 0),
            (f32::NEG_INFINITY, 0),
            (-0.0, 0),
            (f32::from_bits(1), 0),
            (1.0, 255),
            (1.0 - f32::EPSILON, 255),
            (f32::INFINITY, 255),
        ];
        for (linear, code) in cases {
            assert_eq!(encode8(linear), code);
            assert_eq!(encode16(linear), u16::from(code) * 257);
        }
        assert_eq!((encode(f32::NAN), encode(-1.0), encode(9.0)), (0.0, 0.0, 1.0));
    }

    #[test]
    fn every_code_survives_the_round_trip() {
        for code in 0..=255 {
            assert_eq!(encode8(decode8(code)), code);
            assert_eq!(encode16(decode8(code)), u16::from(code) * 257);
        }
    }

    #[test]
    fn the_curve_has_its_known_values() {
        assert_eq!((decode8(0), decode8(255)), (0.0, 1.0));
        assert!((decode8(128) - 0.215_860_5).abs() < 1e-7);
        assert!((encode(0.5) - 0.735_357).abs() < 1e-7);
    }
}
