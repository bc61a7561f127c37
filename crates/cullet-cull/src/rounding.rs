//! Arithmetic that errs on the side of keeping.
//!
//! A sum of a few products in floating point is off by at most a small multiple of
//! 2^-53 times the sum of the sizes of its terms (Higham, "Accuracy and Stability of
//! Numerical Algorithms", 2002, chapter 3). Every test here counts that error against
//! exclusion. Infinite extents need one rule more than IEEE 754 has: a factor that is
//! exactly zero silences an infinite one.

use glam::DVec3;

/// The relative rounding allowance of this crate: 64 units of 2^-53.
///
/// A dozen roundings separate a camera's numbers from a verdict (basis, plane, product,
/// sum, and those of the clip-space chain that draws the same vertices); 64 leaves room.
pub const ROUNDING: f64 = 64.0 / (1_u64 << 53) as f64;

/// `a * b` by component, where `0 * inf` is 0. NaN stays NaN.
pub(crate) fn times(a: DVec3, b: DVec3) -> DVec3 {
    DVec3::new(times_1(a.x, b.x), times_1(a.y, b.y), times_1(a.z, b.z))
}

/// `|a * b|` by component, as a term of an error bound: at least the smallest normal
/// number unless a factor is zero, so that the bound also covers what underflow loses.
pub(crate) fn size(a: DVec3, b: DVec3) -> DVec3 {
    let exact = a.cmpeq(DVec3::ZERO) | b.cmpeq(DVec3::ZERO);
    DVec3::select(exact, DVec3::ZERO, (a * b).abs().max(DVec3::splat(f64::MIN_POSITIVE)))
}

/// `a * d - b * c`, rounded, but zero only if it is zero, and never of the wrong sign
/// (barring underflow and overflow). Exchanging `a, b` with `c, d` negates the result exactly.
///
/// Rounding keeps order, so two products that round differently compare as they should;
/// two that round alike differ by what the roundings dropped, which `fma` recovers
/// (Kahan's difference of products; Jeannerod, Louvet and Muller 2013).
pub(crate) fn cross_2(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let (ad, bc) = (a * d, b * c);
    if ad == bc { libm::fma(a, d, -ad) - libm::fma(b, c, -bc) } else { ad - bc }
}

/// `a + b` and what its rounding dropped, exactly (Knuth 1969).
pub(crate) fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let of_b = sum - a;
    (sum, (a - (sum - of_b)) + (b - of_b))
}

/// `a * b` and what its rounding dropped, exactly, barring underflow.
pub(crate) fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    (product, libm::fma(a, b, -product))
}

fn times_1(a: f64, b: f64) -> f64 {
    let silenced = (a == 0.0 && b.is_infinite()) || (b == 0.0 && a.is_infinite());
    if silenced { 0.0 } else { a * b }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_silences_infinity_but_not_nan() {
        let product = times(DVec3::new(0.0, -0.0, 2.0), DVec3::new(f64::INFINITY, 1.0, 3.0));
        assert_eq!(product, DVec3::new(0.0, 0.0, 6.0));
        assert!(times_1(0.0, f64::NAN).is_nan());
        assert_eq!(times_1(f64::NEG_INFINITY, -2.0), f64::INFINITY);
    }

    #[test]
    fn the_difference_of_products_keeps_its_sign() {
        let e = f64::EPSILON;
        // (1 + e)(1 - e) = 1 - e^2 rounds to 1.
        assert_eq!(cross_2(1.0 + e, 1.0, 1.0, 1.0 - e), -e * e);
        assert_eq!(cross_2(1.0, 1.0 - e, 1.0 + e, 1.0), e * e);
        assert_eq!(cross_2(3.0, 2.0, 6.0, 4.0), 0.0);
    }

    #[test]
    fn a_size_is_never_lost_to_underflow() {
        let tiny = DVec3::splat(1e-200);
        assert_eq!(size(tiny, tiny), DVec3::splat(f64::MIN_POSITIVE));
        assert_eq!(size(DVec3::ZERO, DVec3::INFINITY), DVec3::ZERO);
    }
}
