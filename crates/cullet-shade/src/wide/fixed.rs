//! Texels blended in whole numbers of 16 bits, instead of floats.
//!
//! A blend of `a` and `b` with weight `f` stays between them, and is exactly `a` where they are
//! equal. Each rounds once: down, by up to a whole step of 1/32767, or to the nearest step of 1/255, by up to
//! half of one. So of three blends in a row (rows, columns, levels) the result is off by at most
//! three steps or one and a half, and by what cutting the texels (half a step of 1/32767, a whole one of
//! 1/255) and the weights (2^-16, or 2^-8 of the difference) makes.
//!
//! Written lane by lane, over arrays, for the compiler to find the 16-bit instructions.

use fearless_simd::{Simd, SimdCvtTruncate, prelude::*};

use super::column::Lanes;
use crate::sampler::Arithmetic;
use crate::texture::STEP;

/// Eight channels: of two texels, left and right, or of two levels.
type Channels = [i16; 8];

/// Whole numbers of which [`Arithmetic`] they are.
pub(super) trait Fixed {
    /// A channel of a texel.
    fn texel(channel: u16) -> i16;
    /// Weights in 0..=1, in the lower halves.
    fn weights<S: Simd, V: Lanes<S>>(simd: S, weights: V) -> V::Ints;
    /// From `a`, weight 0, towards `b`, weight 1.
    fn mix(a: i16, b: i16, weight: i16) -> i16;
    /// Steps of texels ([`STEP`]) in one of these.
    const STEPS: f32;
}

/// 15 bits of colour, 16 of weight.
pub(super) struct Sixteen;

impl Fixed for Sixteen {
    #[inline(always)]
    fn texel(channel: u16) -> i16 {
        (channel >> 1) as i16
    }

    /// A whole one is 65535 / 65536. From a half on, 16 bits are a negative number.
    #[inline(always)]
    fn weights<S: Simd, V: Lanes<S>>(simd: S, weights: V) -> V::Ints {
        V::Ints::truncate_from(weights * 65536.0).min(V::Ints::splat(simd, 65535))
    }

    /// With a weight from a half on the way is counted from `b`: `b + (b - a) (f - 1)`.
    #[inline(always)]
    fn mix(a: i16, b: i16, weight: i16) -> i16 {
        let way = b.wrapping_sub(a);
        let part = (i32::from(way) * i32::from(weight)) >> 16;
        let base = a.wrapping_add(way & (weight >> 15));
        base.wrapping_add(part as i16)
    }

    const STEPS: f32 = 65535.0 / 32767.0;
}

/// 8 bits of colour, 7 of weight.
pub(super) struct Eight;

impl Fixed for Eight {
    #[inline(always)]
    fn texel(channel: u16) -> i16 {
        (channel >> 8) as i16
    }

    #[inline(always)]
    fn weights<S: Simd, V: Lanes<S>>(_: S, weights: V) -> V::Ints {
        V::Ints::truncate_from(weights * 128.0 + 0.5)
    }

    #[inline(always)]
    fn mix(a: i16, b: i16, weight: i16) -> i16 {
        // Up to 255 * 128 + 64: just below the end of 16 bits.
        let way = b.wrapping_sub(a).wrapping_mul(weight).wrapping_add(64);
        a.wrapping_add(way >> 7)
    }

    const STEPS: f32 = 257.0;
}

/// Two texels, left and right, from a row.
#[inline(always)]
pub(super) fn pair<F: Fixed>(channels: &[u16]) -> Channels {
    let channels: &[u16; 8] = channels.first_chunk().expect("two texels");
    let mut lanes = [0; 8];
    for i in 0..8 {
        lanes[i] = F::texel(channels[i]);
    }
    lanes
}

/// All lanes with one weight.
#[inline(always)]
pub(super) fn mix<F: Fixed>(a: &Channels, b: &Channels, weight: i16) -> Channels {
    let mut out = [0; 8];
    for i in 0..8 {
        out[i] = F::mix(a[i], b[i], weight);
    }
    out
}

/// The left halves of two, and the right halves.
#[inline(always)]
pub(super) fn halves(a: &Channels, b: &Channels) -> [Channels; 2] {
    let [mut left, mut right] = [[0; 8]; 2];
    for i in 0..4 {
        (left[i], left[i + 4]) = (a[i], b[i]);
        (right[i], right[i + 4]) = (a[i + 4], b[i + 4]);
    }
    [left, right]
}

/// The first four lanes with one weight, the last four with another.
#[inline(always)]
pub(super) fn mix_halves<F: Fixed>(a: &Channels, b: &Channels, weights: [i16; 2]) -> Channels {
    let mut out = [0; 8];
    for i in 0..8 {
        out[i] = F::mix(a[i], b[i], weights[i / 4]);
    }
    out
}

/// A colour in steps of texels, of the first four lanes blended with the last four.
#[inline(always)]
pub(super) fn color<F: Fixed>(lanes: &Channels, weight: i16) -> [f32; 4] {
    let mut out = [0.0; 4];
    for i in 0..4 {
        out[i] = f32::from(F::mix(lanes[i], lanes[i + 4], weight)) * F::STEPS;
    }
    out
}

impl Arithmetic {
    /// How far a channel, in `[0, 1]`, can be from that of exact arithmetic.
    pub fn error(self) -> f32 {
        match self {
            Arithmetic::Float => 8.0 * f32::EPSILON,
            Arithmetic::Sixteen => 3.5 / 32767.0 + 3.0 / 65536.0 + STEP,
            // The texel is rounded down, a whole step; weights by 1/256 of the difference.
            Arithmetic::Eight => 1.0 / 255.0 + 3.0 * (0.5 / 255.0 + 1.0 / 256.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch, f32x8};

    use super::*;
    use crate::testing::Random;

    fn weight<F: Fixed>(weight: f32) -> i16 {
        #[inline(always)]
        fn of<S: Simd, F: Fixed>(simd: S, weight: f32) -> i32 {
            F::weights(simd, f32x8::splat(simd, weight)).as_slice()[0]
        }
        dispatch!(Level::new(), simd => of::<_, F>(simd, weight)) as i16
    }

    fn check<F: Fixed>(steps: f64, weight_error: f64) {
        let random = &mut Random::new(5);
        let mut number = |end: u32| (random.within(0.0, end as f32) as u32).min(end - 1);
        for _ in 0..200_000 {
            let [a, b] = [number(65536), number(65536)].map(|channel| F::texel(channel as u16));
            let weight = number(65537) as f32 / 65536.0;
            let whole = super::tests::weight::<F>(weight);
            let mixed = F::mix(a, b, whole);
            assert!((a.min(b)..=a.max(b)).contains(&mixed), "{a} {b} {weight}");
            let exact = f64::from(a) + (f64::from(b) - f64::from(a)) * f64::from(weight);
            let way = (f64::from(b) - f64::from(a)).abs();
            let error = (f64::from(mixed) - exact).abs();
            assert!(error <= steps + way * weight_error, "{a} {b} {weight}: {error}");
            assert_eq!(F::mix(a, a, whole), a);
        }
        assert_eq!(f32::from(F::texel(65535)) * F::STEPS * STEP, 1.0);
        assert_eq!(F::texel(0), 0);
    }

    #[test]
    fn a_blend_stays_between_its_ends_and_near_the_exact_one() {
        check::<Sixteen>(1.0, 1.0 / 65536.0);
        check::<Eight>(0.5, 0.5 / 128.0);
    }
}
