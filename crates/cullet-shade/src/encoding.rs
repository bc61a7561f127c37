//! Ways from linear light to 8-bit sRGB: the exact one, and two that are off by a code at most.
//!
//! The exact one is a table too, whose buckets follow the exponent of a float and hold a carry
//! ([`crate::srgb`]). The others do without the carry, or without the table; scalar twins and wide code
//! give the same codes.

use std::sync::LazyLock;

use fearless_simd::{Simd, SimdCvtTruncate, prelude::*};

use crate::select::clamp;
use crate::srgb::{encode8, encode8_exact};
use crate::wide::Lanes;

/// How colours become 8-bit codes; 16-bit ones are always exact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Encoding {
    /// The code nearest to the exact curve, for every float.
    #[default]
    Exact,
    /// A plain table of 4096 evenly spaced values: off by one code at most. Steps are 4/5 of a code in
    /// the darkest part, where a fifth of all values get the wrong one.
    Table,
    /// A cubic in the fourth root, no table: 1/18 of a code off before rounding, so by one code at most
    /// after it.
    Polynomial,
}

/// Steps of the plain table.
const STEPS: f32 = 4095.0;

/// The code of every step.
static TABLE: LazyLock<[u8; 4096]> =
    LazyLock::new(|| std::array::from_fn(|step| encode8_exact(step as f32 / STEPS)));

/// Up to here the curve is a line.
pub(crate) const LINEAR_END: f32 = 0.003_130_8;

/// The curve beyond, by powers of the fourth root: the best such cubic (by Lawson's iteration), off by
/// 2.15e-4 at most.
const CUBIC: [f32; 4] = [-0.071_762_465, 0.255_803_1, 0.952_565_14, -0.136_820_54];

impl Encoding {
    /// The 8-bit code; ends and NaN as in [`encode8`].
    pub fn encode8(self, linear: f32) -> u8 {
        match self {
            Encoding::Exact => encode8(linear),
            Encoding::Table => TABLE[(clamp(linear, 0.0, 1.0) * STEPS + 0.5) as usize],
            Encoding::Polynomial => {
                let x = clamp(linear, 0.0, 1.0);
                let root = x.sqrt().sqrt();
                let curve = ((root * CUBIC[3] + CUBIC[2]) * root + CUBIC[1]) * root + CUBIC[0];
                let encoded = if x > LINEAR_END { curve } else { x * 12.92 };
                (encoded * 255.0 + 0.5) as u8
            }
        }
    }
}

/// [`Encoding::Table`] of values, whole groups, in place: floats by their bits in, codes out. The table is
/// read in a pass of its own, as [`crate::srgb`] has it.
#[inline(always)]
pub(crate) fn encode_by_table<S: Simd, V: Lanes<S>>(simd: S, values: &mut [u32]) {
    let table = &*TABLE;
    for group in values.chunks_exact_mut(V::LEN) {
        let steps = inside::<S, V>(simd, group) * STEPS + 0.5;
        V::Uints::truncate_from(steps).store_slice(group);
    }
    for value in values {
        *value = u32::from(table[*value as usize % 4096]);
    }
}

/// [`Encoding::Polynomial`] of values, whole groups, in place: floats by their bits in, codes out.
#[inline(always)]
pub(crate) fn encode_by_polynomial<S: Simd, V: Lanes<S>>(simd: S, values: &mut [u32]) {
    let end = V::splat(simd, LINEAR_END);
    for group in values.chunks_exact_mut(V::LEN) {
        let x = inside::<S, V>(simd, group);
        let root = x.sqrt().sqrt();
        let curve = ((root * CUBIC[3] + CUBIC[2]) * root + CUBIC[1]) * root + CUBIC[0];
        let encoded = x.simd_gt(end).select(curve, x * 12.92);
        V::Uints::truncate_from(encoded * 255.0 + 0.5).store_slice(group);
    }
}

/// Floats from their bits, clamped to `[0, 1]`; NaN is 0.
#[inline(always)]
fn inside<S: Simd, V: Lanes<S>>(simd: S, bits: &[u32]) -> V {
    let (zero, one) = (V::splat(simd, 0.0), V::splat(simd, 1.0));
    let x: V = V::Uints::from_slice(simd, bits).bitcast();
    let x = x.simd_gt(zero).select(x, zero);
    x.simd_lt(one).select(x, one)
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;

    use super::*;
    use crate::srgb::encode_exact;
    use crate::testing::{Random, levels};
    use crate::wide::{WIDEST, wide};

    const ROUGH: [Encoding; 2] = [Encoding::Table, Encoding::Polynomial];

    /// Floats in `[0, 1]`: evenly, and evenly by exponent.
    fn some() -> Vec<f32> {
        let mut random = Random::new(1);
        let by_exponent = (0..0x3f80_0000_u32).step_by(4001).map(f32::from_bits);
        (0..200_000).map(|_| random.unit()).chain(by_exponent).collect()
    }

    #[test]
    fn no_code_is_off_by_more_than_one() {
        for encoding in ROUGH {
            let mut n_off = 0;
            for linear in some() {
                let off = encoding.encode8(linear).abs_diff(encode8(linear));
                assert!(off <= 1, "{encoding:?} at {linear:e}");
                n_off += u32::from(off);
            }
            assert!(n_off > 0, "{encoding:?} is exact?");
        }
    }

    #[test]
    fn the_cubic_is_within_its_stated_error() {
        let mut worst: f64 = 0.0;
        for linear in some().into_iter().filter(|linear| *linear > LINEAR_END) {
            let root = linear.sqrt().sqrt();
            let curve = ((root * CUBIC[3] + CUBIC[2]) * root + CUBIC[1]) * root + CUBIC[0];
            worst = worst.max((f64::from(curve) - encode_exact(f64::from(linear))).abs());
        }
        assert!(worst < 1.0 / 18.0 / 255.0 && worst > 2e-4, "{worst:e}");
    }

    #[test]
    fn wrong_codes_are_as_rare_as_stated() {
        let share = |encoding: Encoding, low: f32, high: f32| {
            let n = 100_000;
            let at = |i| low + (high - low) * i as f32 / n as f32;
            let wrong = |i: &i32| encoding.encode8(at(*i)) != encode8(at(*i));
            (0..n).filter(wrong).count() as f32 / n as f32
        };
        let dark = share(Encoding::Table, 0.0, 0.003);
        assert!((0.15..0.25).contains(&dark), "{dark}");
        assert!(share(Encoding::Table, 0.05, 1.0) < 0.04);
        assert!(share(Encoding::Polynomial, 0.0, 1.0) < 1.0 / 18.0);
    }

    #[test]
    fn ends_are_those_of_the_exact_way() {
        for encoding in ROUGH {
            for linear in [f32::NAN, f32::NEG_INFINITY, -1.0, -0.0, 0.0, 1e-45] {
                assert_eq!(encoding.encode8(linear), 0, "{encoding:?} {linear}");
            }
            for linear in [1.0, 1.0_f32.next_up(), 1e30, f32::INFINITY] {
                assert_eq!(encoding.encode8(linear), 255, "{encoding:?} {linear}");
            }
        }
    }

    #[test]
    fn many_are_one_by_one_on_every_instruction_set() {
        #[inline(always)]
        fn all_wide<S: Simd>(simd: S, encoding: Encoding, values: &mut [u32]) {
            wide!(S, all(simd, encoding, values));
        }
        #[inline(always)]
        fn all<S: Simd, V: Lanes<S>>(simd: S, encoding: Encoding, values: &mut [u32]) {
            match encoding {
                Encoding::Table => encode_by_table::<S, V>(simd, values),
                _ => encode_by_polynomial::<S, V>(simd, values),
            }
        }
        let mut random = Random::new(2);
        let odd = [0.0, -0.0, 1.0, f32::NAN, f32::INFINITY, -1.0, 1e-45, 2.0].map(f32::to_bits);
        let mut values = odd.to_vec();
        while values.len() < 10_000 * WIDEST {
            values.extend([random.bits(), random.unit().to_bits()]);
        }
        for encoding in ROUGH {
            let each: Vec<u32> = values
                .iter()
                .map(|bits| u32::from(encoding.encode8(f32::from_bits(*bits))))
                .collect();
            for (name, level) in levels() {
                let mut codes = values.clone();
                dispatch!(level, simd => all_wide(simd, encoding, &mut codes));
                assert_eq!(codes, each, "{encoding:?} {name}");
            }
        }
    }
}
