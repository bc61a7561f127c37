//! Two kinds of number that know what they do not know.
//!
//! The planes that [`implied`](crate::implied) derives are products and sums of the frustum's own.
//! Derived in [`Interval`]s they are as good as a camera's rounded numbers allow; derived in
//! [`Expansion`]s, from a matrix taken at its word, they are exact. One text serves both.

use alloc::vec::Vec;
use core::cmp::Ordering;

use crate::rounding::{two_product, two_sum};

/// A real number for the purposes of sums, products and signs.
pub(crate) trait Number: Clone {
    fn zero() -> Self;
    fn plus(&self, other: &Self) -> Self;
    fn times(&self, other: &Self) -> Self;
    fn negated(&self) -> Self;
    /// Against zero; `None` if that is not known.
    fn sign(&self) -> Option<Ordering>;
}

/// Some number within `error` of `value`, which are finite.
///
/// Every operation adds its own rounding to the error (running error analysis: Wilkinson 1986;
/// Higham 2002, section 3.3). Zero without error is exactly zero and annihilates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interval {
    pub value: f64,
    pub error: f64,
}

impl Interval {
    /// `value` correctly rounded from `exact` known within `error`; twice the worst case, which
    /// covers the roundings of the errors themselves.
    fn rounded(value: f64, error: f64) -> Interval {
        Interval { value, error: error + f64::EPSILON * (value.abs() + error) }
    }
}

impl Number for Interval {
    fn zero() -> Self {
        Interval { value: 0.0, error: 0.0 }
    }

    fn plus(&self, other: &Self) -> Self {
        Interval::rounded(self.value + other.value, self.error + other.error)
    }

    fn times(&self, other: &Self) -> Self {
        let reach = |i: &Self| i.value.abs() + i.error;
        if reach(self) == 0.0 || reach(other) == 0.0 {
            return Interval::zero();
        }
        let error = self.value.abs() * other.error + self.error * reach(other);
        Interval::rounded(self.value * other.value, 2.0 * f64::MIN_POSITIVE + error)
    }

    fn negated(&self) -> Self {
        Interval { value: -self.value, ..*self }
    }

    fn sign(&self) -> Option<Ordering> {
        let certain = self.value.abs() > self.error || self.error == 0.0;
        self.value.partial_cmp(&0.0).filter(|_| certain)
    }
}

/// A sum of f64 that overlap in no bit, the smallest first: exact, as long as nothing over- or
/// underflows.
///
/// Source: Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
/// Predicates", 1997. Its grow-expansion keeps sums nonadjacent, so the greatest term
/// has the sign of the whole, and at least half its size.
#[derive(Clone, Debug, Default)]
pub(crate) struct Expansion(Vec<f64>);

impl Expansion {
    pub fn from_sum(terms: impl IntoIterator<Item = f64>) -> Self {
        let mut sum = Expansion::default();
        terms.into_iter().for_each(|term| sum.grow(term));
        sum
    }

    /// Rounded, off by less than 4 units of 2^-53 of itself.
    pub fn value(&self) -> f64 {
        self.0.iter().sum()
    }

    pub fn scaled(&self, factor: f64) -> Self {
        self.times(&Expansion::from_sum([factor]))
    }

    fn grow(&mut self, term: f64) {
        let mut carry = term;
        self.0.retain_mut(|part| {
            (carry, *part) = two_sum(carry, *part);
            *part != 0.0
        });
        if carry != 0.0 {
            self.0.push(carry);
        }
    }
}

impl Number for Expansion {
    fn zero() -> Self {
        Expansion::default()
    }

    fn plus(&self, other: &Self) -> Self {
        let mut sum = self.clone();
        other.0.iter().for_each(|&term| sum.grow(term));
        sum
    }

    fn times(&self, other: &Self) -> Self {
        let mut product = Expansion::default();
        for &a in &self.0 {
            for &b in &other.0 {
                let (high, low) = two_product(a, b);
                product.grow(low);
                product.grow(high);
            }
        }
        product
    }

    fn negated(&self) -> Self {
        Expansion(self.0.iter().map(|term| -term).collect())
    }

    fn sign(&self) -> Option<Ordering> {
        self.0.last().map_or(Some(Ordering::Equal), |greatest| greatest.partial_cmp(&0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expansions_lose_nothing() {
        let a = Expansion::from_sum([1e30, 1.0, -1e30, 1e-30]);
        assert_eq!(a.plus(&Expansion::from_sum([-1.0])).value(), 1e-30);
        let b = a.times(&a).plus(&a.scaled(-2.0)).plus(&Expansion::from_sum([1.0]));
        // (1 + e)^2 - 2 (1 + e) + 1 = e^2, up to the square's own rounding.
        assert!((b.value() / 1e-60 - 1.0).abs() < 1e-15);
        assert_eq!(b.plus(&b.negated()).sign(), Some(Ordering::Equal));
    }

    #[test]
    fn intervals_admit_what_they_lost() {
        let exactly = |value| Interval { value, error: 0.0 };
        let third = Interval { value: 1.0 / 3.0, error: f64::EPSILON };
        let zero = third.times(&exactly(3.0)).plus(&exactly(-1.0));
        assert_eq!(zero.sign(), None);
        assert_eq!(zero.times(&Interval::zero()).sign(), Some(Ordering::Equal));
        assert_eq!(third.negated().sign(), Some(Ordering::Less));
        let tiny = exactly(1e-200);
        assert_eq!(tiny.times(&tiny).sign(), None);
    }
}
