//! How many floats lie between two results.
//!
//! IEEE 754 lays out the floats of one sign in the order of their bits; folding the
//! negative half over makes one line of integers, and the distance is a subtraction.

/// Steps from `a` to `b` along the f32s; 0 for equal values, -0 and +0 included.
///
/// Infinity is one step beyond the largest finite value. A NaN is `u32::MAX` from
/// everything, itself included; no two numbers are that far apart.
pub fn ulps(a: f32, b: f32) -> u32 {
    if a.is_nan() || b.is_nan() {
        return u32::MAX;
    }
    let rank = |v: f32| {
        let magnitude = (v.to_bits() & (u32::MAX >> 1)) as i32;
        if v.is_sign_negative() { -magnitude } else { magnitude }
    };
    rank(a).abs_diff(rank(b))
}

/// Steps from `a` to `b` along the f64s, as [`ulps`]; a NaN is `u64::MAX` from everything.
pub fn ulps64(a: f64, b: f64) -> u64 {
    if a.is_nan() || b.is_nan() {
        return u64::MAX;
    }
    let rank = |v: f64| {
        let magnitude = (v.to_bits() & (u64::MAX >> 1)) as i64;
        if v.is_sign_negative() { -magnitude } else { magnitude }
    };
    rank(a).abs_diff(rank(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(a: f32, b: f32, expected: u32) {
        assert_eq!(ulps(a, b), expected);
        assert_eq!(ulps(b, a), expected);
        assert_eq!(ulps(-a, -b), expected);
    }

    #[test]
    fn neighbours_are_one_apart() {
        check(1.0, 1.0, 0);
        check(0.0, -0.0, 0);
        check(1.0, 1.0 + f32::EPSILON, 1);
        check(1.0, 2.0, 1 << 23);
        check(f32::MAX, f32::INFINITY, 1);
        check(f32::from_bits(1), -f32::from_bits(1), 2);
        check(f32::INFINITY, f32::NEG_INFINITY, 0xff00_0000);
    }

    #[test]
    fn nan_is_far_from_everything() {
        check(f32::NAN, f32::NAN, u32::MAX);
        check(f32::NAN, 0.0, u32::MAX);
        assert_eq!(ulps64(f64::NAN, 0.0), u64::MAX);
    }

    #[test]
    fn doubles_likewise() {
        assert_eq!(ulps64(1.0, 1.0 + f64::EPSILON), 1);
        assert_eq!(ulps64(-0.0, 0.0), 0);
        assert_eq!(ulps64(-f64::from_bits(3), f64::from_bits(4)), 7);
        assert_eq!(ulps64(f64::MAX, f64::INFINITY), 1);
    }
}
