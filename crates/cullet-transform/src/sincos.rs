//! Sine and cosine three ways: true to the last bits, by polynomial, by table.
//!
//! The frame itself asks for one tangent per camera and takes it from `libm`; these are for whoever
//! turns many things per frame, and for the question whether a table still pays.
//!
//! The polynomial and the table first bring the angle near 0 by whole quarter turns. Pi/2 is
//! subtracted in three parts, the first two so short that their products with a whole number below
//! 2^30 are exact (Cody and Waite, "Software Manual for the Elementary Functions", 1980), which
//! keeps the stated errors for angles up to 1e9 radians, ends of quadrants included. Angles beyond
//! go to `libm`, as do NaN and infinities, which give NaN.

use alloc::vec::Vec;

/// How to compute sines and cosines. Errors are absolute, for any angle.
#[derive(Clone, Debug, PartialEq)]
pub enum SinCos {
    /// By the `libm` crate: off by less than 1 ulp.
    Libm,
    /// By short polynomials around the nearest quarter turn: off by at most 2e-9.
    Polynomial,
    /// From a table with straight lines between its entries: off by at most
    /// [`SinCosTable::error`].
    Table(SinCosTable),
}

impl SinCos {
    /// The sine and the cosine of an angle in radians.
    #[inline]
    pub fn of(&self, radians: f64) -> (f64, f64) {
        match self {
            SinCos::Polynomial if is_reducible(radians) => polynomial(radians),
            SinCos::Table(table) if is_reducible(radians) => table.of(radians),
            _ => libm::sincos(radians),
        }
    }

    /// The largest error.
    pub fn error(&self) -> f64 {
        match self {
            SinCos::Libm => f64::EPSILON,
            SinCos::Polynomial => 2e-9,
            SinCos::Table(table) => table.error(),
        }
    }
}

/// Whether [`reduced`] keeps its promise. False for NaN.
fn is_reducible(radians: f64) -> bool {
    radians.abs() <= 1e9
}

/// Adding and subtracting this rounds what is below 2^51 to a whole number, half to even.
const TO_WHOLE: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52

/// Pi/2 in parts of 23 and 23 bits and the rest.
const HALF_PI: [f64; 3] = {
    let (high, middle) = (0x3FF9_21FB_4000_0000, 0x3E74_442D_0000_0000);
    let low = 0x3CF8_4698_98CC_5170;
    [f64::from_bits(high), f64::from_bits(middle), f64::from_bits(low)]
};

/// An angle as quarter turns, rounded to a whole number, and the rest, within pi/4 of 0 and a little.
#[inline]
fn reduced(radians: f64) -> (f64, f64) {
    let quarters = (radians * core::f64::consts::FRAC_2_PI + TO_WHOLE) - TO_WHOLE;
    let [high, middle, low] = HALF_PI;
    (quarters, ((radians - quarters * high) - quarters * middle) - quarters * low)
}

/// Taylor's series, economised by nothing: the first term left out bounds the error.
fn polynomial(radians: f64) -> (f64, f64) {
    let (quarters, x) = reduced(radians);
    let x2 = x * x;
    let sin =
        x + x * x2 * (-1.0 / 6.0 + x2 * (1.0 / 120.0 + x2 * (-1.0 / 5040.0 + x2 / 362_880.0)));
    let cos = 1.0
        + x2 * (-0.5
            + x2 * (1.0 / 24.0 + x2 * (-1.0 / 720.0 + x2 * (1.0 / 40320.0 - x2 / 3_628_800.0))));
    // The low bits of a whole number are those of the number as an integer, whatever its sign.
    match quarters as i64 & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// Sines of equal steps of a turn.
#[derive(Clone, Debug, PartialEq)]
pub struct SinCosTable {
    /// One turn, and a quarter more for the cosine, and one entry for the last line to end at.
    sines: Vec<f32>,
    /// Steps per turn.
    n: usize,
}

impl SinCosTable {
    /// A table of `n` steps per turn, a power of two of at least 4, others are rounded up to one (at
    /// most 2^20).
    pub fn new(n: usize) -> SinCosTable {
        let n = n.clamp(4, 1 << 20).next_power_of_two();
        let angle = |i: usize| i as f64 * (core::f64::consts::TAU / n as f64);
        let sines = (0..=n + n / 4).map(|i| libm::sin(angle(i)) as f32).collect();
        SinCosTable { sines, n }
    }

    /// Steps per turn.
    pub fn n_steps(&self) -> usize {
        self.n
    }

    /// The largest error: that of a chord under an arc of one step, `(tau / n)^2 / 8`, and of entries
    /// rounded to f32.
    pub fn error(&self) -> f64 {
        let step = core::f64::consts::TAU / self.n as f64;
        step * step / 8.0 + 1e-7
    }

    fn of(&self, radians: f64) -> (f64, f64) {
        let (quarters, rest) = reduced(radians);
        let steps = rest * (self.n as f64 / core::f64::consts::TAU);
        let below = ((steps - 0.5) + TO_WHOLE) - TO_WHOLE;
        let part = steps - below;
        let quarter = self.n / 4;
        // Both are whole, so wrapping around a turn is a mask.
        let quarters = (quarters as i64 & 3) as usize * quarter;
        let i = (below as i64 as usize).wrapping_add(quarters) & (self.n - 1);
        let between = |i: usize| {
            let (a, b) = (f64::from(self.sines[i]), f64::from(self.sines[i + 1]));
            a + (b - a) * part
        };
        (between(i), between(i + quarter))
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::{FRAC_PI_2, FRAC_PI_4};

    use super::*;

    fn ways() -> Vec<SinCos> {
        let tables = [4, 64, 256, 4096].map(|n| SinCos::Table(SinCosTable::new(n)));
        [SinCos::Libm, SinCos::Polynomial].into_iter().chain(tables).collect()
    }

    #[track_caller]
    fn check(way: &SinCos, radians: f64) {
        let (sin, cos) = way.of(radians);
        let (true_sin, true_cos) = libm::sincos(radians);
        let error = (sin - true_sin).abs().max((cos - true_cos).abs());
        assert!(error <= way.error(), "{radians:e}: {error:e}, stated {:e}", way.error());
    }

    #[test]
    fn errors_are_as_stated_at_all_sizes_of_angles() {
        let mut state = 1_u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        for way in ways() {
            for exponent in -300..=12 {
                for _ in 0..40 {
                    check(&way, (2.0 * random() - 1.0) * libm::pow(10.0, f64::from(exponent)));
                }
            }
            for _ in 0..20_000 {
                check(&way, (2.0 * random() - 1.0) * 1e9);
            }
        }
    }

    #[test]
    fn errors_are_as_stated_at_and_beside_ends_of_quadrants() {
        for way in ways() {
            for k in (-64..=64).chain([1 << 20, (1 << 29) + 1, 636_619_770, -636_619_771]) {
                for end in [f64::from(k) * FRAC_PI_2, f64::from(k) * FRAC_PI_2 + FRAC_PI_4] {
                    for angle in [end.next_down(), end, end.next_up()] {
                        check(&way, angle);
                    }
                }
            }
            for angle in [0.0, -0.0, 5e-324, 1e9, -1e9, 1e9_f64.next_up(), 1e22, f64::MAX] {
                check(&way, angle);
            }
        }
    }

    #[test]
    fn what_is_no_angle_gives_nan() {
        for way in ways() {
            for angle in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                let (sin, cos) = way.of(angle);
                assert!(sin.is_nan() && cos.is_nan());
            }
        }
    }

    #[test]
    fn a_table_is_as_wrong_as_a_chord_and_no_better() {
        for n in [16, 256] {
            let table = SinCosTable::new(n);
            let middle = core::f64::consts::TAU / n as f64 * (f64::from(n as u32 / 4) + 0.5);
            let error = (SinCos::Table(table.clone()).of(middle).0 - libm::sin(middle)).abs();
            assert!(error > 0.9 * table.error() - 2e-7, "{n}: {error:e}");
        }
        assert_eq!(SinCosTable::new(0).n_steps(), 4);
        assert_eq!(SinCosTable::new(1000).n_steps(), 1024);
    }
}
