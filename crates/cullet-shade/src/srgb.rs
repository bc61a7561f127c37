//! Between linear light and sRGB bytes, exactly.
//!
//! Decoding looks up one of 256 floats. Encoding to 8 bits asks for the number of
//! thresholds at or below a value, where threshold `k` is the smallest f32 that the exact
//! curve rounds to code `k`: the leading bits of the float say where to start counting,
//! and they are fine enough that one more step finishes, which is a carry. So the fast encoder
//! *is* the rounded exact curve, for every f32. Vectors of 512 bits have another way to the same
//! codes (`pieces`).
//!
//! Values are linear or encoded in `[0, 1]`; alpha never passes through here.
//! Source: IEC 61966-2-1:1999, the transfer function with its printed constants.

#[cfg(target_arch = "x86_64")]
mod pieces;

use std::sync::LazyLock;

#[cfg(target_arch = "x86_64")]
use fearless_simd::Level;
use fearless_simd::{Simd, prelude::*};

use crate::select::clamp;
use crate::wide::Lanes;

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
    let bits = clamp(linear, SMALLEST, 1.0).to_bits();
    encoder().code(bits) as u8
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
const FIRST_BUCKET: usize = (127 - 13) << (23 - BUCKET_SHIFT);
/// The bucket that begins with 1.
const LAST_BUCKET: usize = 127 << (23 - BUCKET_SHIFT);

/// The start of the first bucket.
const SMALLEST: f32 = 1.0 / 8192.0;

/// What encoding looks up.
pub(crate) struct Encoder {
    /// For each bucket the code of its smallest float in the upper half, and in the lower one what is
    /// missing for a carry there from the first float of the next code on: the sum with the low
    /// bits of a float has the float's code in its upper half.
    ///
    /// One for each upper half of a float, so that it is the place, and no bounds are checked. The few
    /// that are used lie side by side.
    buckets: Box<[u32; 1 << 16]>,
    #[cfg(target_arch = "x86_64")]
    pieces: pieces::Pieces,
}

static ENCODER: LazyLock<Encoder> = LazyLock::new(|| {
    let mut buckets = vec![0; 1 << 16].into_boxed_slice();
    for (bucket, entry) in buckets.iter_mut().enumerate().take(LAST_BUCKET + 1).skip(FIRST_BUCKET) {
        let first = (bucket as u32) << BUCKET_SHIFT;
        let last = first + (1 << BUCKET_SHIFT) - 1;
        let code = |bits: u32| u32::from(encode8_exact(f32::from_bits(bits)));
        let next = code(first) + 1;
        let missing = if code(last) == next {
            (1 << BUCKET_SHIFT) - (smallest_with_code(next as u8, first, last) - first)
        } else {
            0
        };
        *entry = (code(first) << BUCKET_SHIFT) + missing;
    }
    Encoder {
        buckets: buckets.try_into().expect("as many as there are upper halves"),
        #[cfg(target_arch = "x86_64")]
        pieces: pieces::Pieces::new(),
    }
});

/// The table, for whoever has many colours to encode.
pub(crate) fn encoder() -> &'static Encoder {
    &ENCODER
}

impl Encoder {
    /// The code of a float in [`SMALLEST`]`..=1`, by its bits.
    #[inline(always)]
    fn code(&self, bits: u32) -> u32 {
        (self.start(bits) + (bits & 0xffff)) >> BUCKET_SHIFT
    }

    #[inline(always)]
    fn start(&self, bits: u32) -> u32 {
        self.buckets[usize::from((bits >> BUCKET_SHIFT) as u16)]
    }

    /// [`encode8`] of values, whole groups, in place: floats by their bits in, codes out.
    ///
    /// The table is read in a pass of its own: values on their way between vectors and single
    /// numbers would otherwise wait for each other.
    #[inline(always)]
    pub fn encode_all<S: Simd, V: Lanes<S>>(&self, simd: S, values: &mut [u32]) {
        #[cfg(target_arch = "x86_64")]
        if V::LEN == 16
            && let Level::Avx512(token) = simd.level()
        {
            return pieces::encode(token, &self.pieces, self, values);
        }
        let (low, high) = (V::splat(simd, SMALLEST), V::splat(simd, 1.0));
        let mut starts = [0; AT_ONCE];
        for values in values.chunks_mut(AT_ONCE) {
            let n = values.len();
            let mut first = 0;
            while first < n {
                let group = &mut values[first..first + V::LEN];
                let linear: V = V::Uints::from_slice(simd, group).bitcast();
                let inside = linear.simd_gt(low).select(linear, low); // NaN is low
                let inside = inside.simd_lt(high).select(inside, high);
                inside.bitcast::<V::Uints>().store_slice(group);
                first += V::LEN;
            }
            for i in 0..n {
                starts[i] = self.start(values[i]);
            }
            let mut first = 0;
            while first < n {
                let group = &mut values[first..first + V::LEN];
                let low_bits = V::Uints::from_slice(simd, group) & V::Uints::splat(simd, 0xffff);
                let starts = &starts[first..first + V::LEN];
                let sum = V::Uints::from_slice(simd, starts) + low_bits;
                (sum >> BUCKET_SHIFT).store_slice(group);
                first += V::LEN;
            }
        }
    }
}

/// Values that pass through the table together.
const AT_ONCE: usize = 128;

/// Between two floats, both by their bits, the first below. Positive floats order like their bits,
/// so it is found by bisection.
fn smallest_with_code(code: u8, below: u32, reached: u32) -> u32 {
    let (mut below, mut reached) = (below, reached);
    while reached - below > 1 {
        let middle = below + (reached - below) / 2;
        if encode8_exact(f32::from_bits(middle)) >= code {
            reached = middle;
        } else {
            below = middle;
        }
    }
    reached
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;

    use super::*;
    use crate::testing::Random;
    use crate::wide::wide;

    /// The bits of the smallest float of a code.
    fn threshold(code: u8) -> u32 {
        smallest_with_code(code, 0, 1.0_f32.to_bits())
    }

    #[track_caller]
    fn check(linear: f32) {
        assert_eq!(encode8(linear), encode8_exact(linear), "at {linear:e}");
    }

    #[test]
    fn fast_and_exact_agree_around_every_threshold() {
        for code in 1..=255 {
            let threshold = threshold(code);
            (threshold - 4..=threshold + 4).for_each(|bits| check(f32::from_bits(bits)));
            assert_eq!(encode8(f32::from_bits(threshold)), code);
            assert_eq!(encode8(f32::from_bits(threshold - 1)), code - 1);
        }
    }

    #[test]
    fn no_float_is_near_a_tie() {
        for code in 1..=255 {
            let threshold = threshold(code);
            for linear in [threshold - 1, threshold].map(f32::from_bits) {
                let exact = encode_exact(f64::from(linear)) * 255.0;
                assert!((exact - (f64::from(code) - 0.5)).abs() > 1e-12, "code {code}");
            }
        }
    }

    #[test]
    fn fast_and_exact_agree_around_every_bucket() {
        for bucket in FIRST_BUCKET as u32..=LAST_BUCKET as u32 {
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
    fn many_are_one_by_one() {
        #[inline(always)]
        fn all<S: Simd, V: Lanes<S>>(simd: S, values: &mut [u32]) {
            encoder().encode_all::<S, V>(simd, values);
        }
        #[inline(always)]
        fn all_wide<S: Simd>(simd: S, values: &mut [u32]) {
            wide!(S, all(simd, values));
        }
        let mut random = Random::new(2);
        let mut linear = Vec::new();
        for i in 0..200_000 {
            let code = threshold((1 + i % 255) as u8);
            linear.extend([random.bits(), random.unit().to_bits(), random.bits()]);
            linear.push(code - (i as u32 / 255) % 2);
        }
        let each: Vec<u32> =
            linear.iter().map(|bits| u32::from(encode8(f32::from_bits(*bits)))).collect();
        for (name, level) in crate::testing::levels() {
            let mut values = linear.clone();
            dispatch!(level, simd => all_wide(simd, &mut values));
            assert!(values == each, "{name}");
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
