//! Reciprocals and inverse square roots without dividing: a start from the bits, then Newton's steps.
//!
//! The bits of a float, read as an integer, are nearly its logarithm; turned around they give a start
//! that is off by 5.06% (reciprocal) or 3.43% (inverse root). A step of Newton squares that: a
//! relative error `e` becomes `e^2`, or `3/2 e^2 + 1/2 |e|^3`. After two steps 6.6e-6 and 4.8e-6 are left.
//!
//! The instructions made for this (`rcpps`, `rsqrtps`) are not used: their bits differ from maker to
//! maker. These are `+ - *` alone, so scalar twins and wide code give the same bits everywhere.
//!
//! Source: Blinn, "Floating-Point Tricks", IEEE Computer Graphics and Applications 17(4), 1997; the
//! constants are those of the smallest error, found by search.

use fearless_simd::{Simd, prelude::*};

use crate::wide::Lanes;

/// How shading divides by `w` and normalises.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Division {
    /// Division and square root as IEEE 754 has them.
    #[default]
    Exact,
    /// Two steps of Newton: a relative error up to 7e-6 in texture coordinates, normals and lights, on the
    /// pixels that wide code colours. What is beyond 1e-30..1e30 takes the plain, exact way.
    Approximate,
}

/// Within these, squares included, nothing below leaves the range of normal floats.
pub(crate) const RANGE: [f32; 2] = [1e-30, 1e30];

const RECIPROCAL: u32 = 0x7ef3_11c7;
const INVERSE_ROOT: u32 = 0x5f37_5a7f;

/// `1 / x` within 7e-6 of itself, for `x` in 1e-30..=1e30; elsewhere any number.
pub fn reciprocal(x: f32) -> f32 {
    let y = f32::from_bits(RECIPROCAL.wrapping_sub(x.to_bits()));
    let y = y * (2.0 - x * y);
    y * (2.0 - x * y)
}

/// `1 / sqrt(x)` within 6e-6 of itself, for `x` in 1e-30..=1e30; elsewhere any number.
pub fn inverse_sqrt(x: f32) -> f32 {
    let half = x * 0.5;
    let y = f32::from_bits(INVERSE_ROOT.wrapping_sub(x.to_bits() >> 1));
    let y = y * (1.5 - half * y * y);
    y * (1.5 - half * y * y)
}

/// [`reciprocal`] of many.
#[inline(always)]
pub(crate) fn reciprocals<S: Simd, V: Lanes<S>>(simd: S, x: V) -> V {
    let two = V::splat(simd, 2.0);
    let start = V::Uints::splat(simd, RECIPROCAL) - x.bitcast::<V::Uints>();
    let y: V = start.bitcast();
    let y = y * (two - x * y);
    y * (two - x * y)
}

/// [`inverse_sqrt`] of many.
#[inline(always)]
pub(crate) fn inverse_sqrts<S: Simd, V: Lanes<S>>(simd: S, x: V) -> V {
    let most = V::splat(simd, 1.5);
    let half = x * 0.5;
    let start = V::Uints::splat(simd, INVERSE_ROOT) - (x.bitcast::<V::Uints>() >> 1);
    let y: V = start.bitcast();
    let y = y * (most - half * y * y);
    y * (most - half * y * y)
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;

    use super::*;
    use crate::testing::{Random, levels};
    use crate::wide::{WIDEST, wide};

    /// Largest relative error over all of `[1, 4)`, which repeats in every two octaves.
    fn worst(of: impl Fn(f32) -> f32, exact: impl Fn(f64) -> f64, bits: [u32; 2]) -> f64 {
        let all = (bits[0]..bits[1]).step_by(7).map(f32::from_bits);
        let error = |x: f32| (f64::from(of(x)) / exact(f64::from(x)) - 1.0).abs();
        all.map(error).fold(0.0, f64::max)
    }

    #[test]
    fn errors_are_within_what_is_stated() {
        let octaves = [1.0_f32.to_bits(), 4.0_f32.to_bits()];
        let found = worst(reciprocal, |x| 1.0 / x, octaves);
        assert!((6e-6..7e-6).contains(&found), "{found:e}");
        let found = worst(inverse_sqrt, |x| 1.0 / x.sqrt(), octaves);
        assert!((4e-6..6e-6).contains(&found), "{found:e}");
    }

    #[test]
    fn they_hold_over_the_whole_range() {
        let range = RANGE.map(f32::to_bits);
        for bits in (range[0]..=range[1]).step_by(1009) {
            let x = f32::from_bits(bits);
            let exact = f64::from(x);
            assert!((f64::from(reciprocal(x)) * exact - 1.0).abs() < 7e-6, "1 / {x:e}");
            let root = f64::from(inverse_sqrt(x)) * exact.sqrt();
            assert!((root - 1.0).abs() < 6e-6, "1 / sqrt {x:e}");
        }
    }

    #[test]
    fn many_are_one_by_one_on_every_instruction_set() {
        #[inline(always)]
        fn both_wide<S: Simd>(simd: S, x: [f32; WIDEST]) -> [[f32; WIDEST]; 2] {
            wide!(S, both(simd, x))
        }
        #[inline(always)]
        fn both<S: Simd, V: Lanes<S>>(simd: S, x: [f32; WIDEST]) -> [[f32; WIDEST]; 2] {
            let mut out = [[0.0; WIDEST]; 2];
            for first in (0..WIDEST).step_by(V::LEN) {
                let x = V::from_slice(simd, &x[first..][..V::LEN]);
                reciprocals(simd, x).store_slice(&mut out[0][first..][..V::LEN]);
                inverse_sqrts(simd, x).store_slice(&mut out[1][first..][..V::LEN]);
            }
            out
        }
        let mut random = Random::new(5);
        for _ in 0..20_000 {
            let x: [f32; WIDEST] = [(); WIDEST].map(|()| f32::from_bits(random.bits()));
            let bits = |all: [f32; WIDEST]| all.map(|y| if y.is_nan() { 0 } else { y.to_bits() });
            for (name, level) in levels() {
                let [reciprocals, roots] = dispatch!(level, simd => both_wide(simd, x));
                assert_eq!(bits(reciprocals), bits(x.map(reciprocal)), "{name} {x:?}");
                assert_eq!(bits(roots), bits(x.map(inverse_sqrt)), "{name} {x:?}");
            }
        }
    }
}
