//! Compare and select: `max` and `clamp` with one meaning on every machine.
//!
//! `f32::max` and its SIMD relatives disagree about NaN and signed zeros; a comparison
//! followed by a choice does not.

/// `a` where it is greater, else `b`; so a NaN `a` gives `b`, and a NaN `b` gives `b`.
pub fn max<T: PartialOrd>(a: T, b: T) -> T {
    if a > b { a } else { b }
}

/// `x` within `low..=high`; NaN gives `low`.
pub fn clamp<T: PartialOrd>(x: T, low: T, high: T) -> T {
    if x > low { if x < high { x } else { high } } else { low }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nan_is_decided() {
        assert_eq!(max(f32::NAN, 1.0), 1.0);
        assert!(max(1.0, f32::NAN).is_nan());
        assert_eq!(clamp(f32::NAN, 2.0, 3.0), 2.0);
    }

    #[test]
    fn clamp_keeps_the_inside_and_both_ends() {
        for (x, expected) in [(-1, 0), (0, 0), (3, 3), (7, 7), (8, 7)] {
            assert_eq!(clamp(x, 0, 7), expected);
        }
    }
}
