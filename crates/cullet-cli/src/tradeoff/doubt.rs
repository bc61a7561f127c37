//! What the figures are able to tell, and what they are not.
//!
//! * **Times** are ratios to the default, round by round, so that what slows a whole round cancels. A
//!   ratio is known to the 95% interval of its median ([`Summary::uncertainty`]), and not better than to what
//!   copies of the default are off from it, for whatever stays the same in all rounds of a run and is
//!   another in the next ([`of_controls`]). Of less than five rounds, whose quartiles say nothing, twice the
//!   whole range is taken.
//!   Where many rivals are asked about one claim, intervals are widened to hold together ([`widened`]).
//! * **Errors** against a picture made of samples are known as far as the samples are many: an order of
//!   two errors is told only where their difference is larger than that by which the two halves of the
//!   samples disagree about it; of shimmer, every other pixel and those between. Two halves are no 95%
//!   interval: of differences that are chance alone three in ten are told.
//!   Pixels that show another triangle are counted: two counts are told apart beyond 1.96 roots of their sum,
//!   which is the 95% interval of their difference if no pixel is in both, and too wide else.
//!   Other errors against exact references have no doubt.
//!
//! What is within its doubt is neither so nor not so: [`Outcome::CannotTell`].

use cullet_measure::{Comparison, Summary};

use super::table::Row;

/// What becomes of a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Outcome {
    /// It is so, beyond doubt.
    Confirmed,
    /// It may be so.
    CannotTell,
    /// It is not so, beyond doubt.
    Refuted,
}

impl Outcome {
    /// Of a claim that something is below `limit`, known to within `doubt`.
    pub fn below(value: f64, limit: f64, doubt: f64) -> Outcome {
        if value + doubt < limit {
            Outcome::Confirmed
        } else if value - doubt >= limit {
            Outcome::Refuted
        } else {
            Outcome::CannotTell
        }
    }

    /// Of a claim about what is counted or exact.
    pub fn exactly(holds: bool) -> Outcome {
        if holds { Outcome::Confirmed } else { Outcome::Refuted }
    }

    /// Of the opposite claim.
    pub fn not(self) -> Outcome {
        match self {
            Outcome::Confirmed => Outcome::Refuted,
            Outcome::CannotTell => Outcome::CannotTell,
            Outcome::Refuted => Outcome::Confirmed,
        }
    }

    /// Of both claims together: one that is refuted refutes all.
    pub fn and(self, other: Outcome) -> Outcome {
        self.max(other)
    }
}

/// How far a median may be off, as a fraction of it.
pub fn of_median(summary: &Summary) -> f64 {
    match summary.n {
        0..=2 => f64::INFINITY,
        3..=4 => 2.0 * (summary.max - summary.min) / summary.median,
        _ => summary.uncertainty(),
    }
}

/// How far ratios may be off by what stays the same in all rounds of a run: by what the copies of the default are
/// off from it.
pub fn of_controls(controls: &[Comparison]) -> f64 {
    let ratios: Vec<f64> = controls.iter().map(|control| control.ratios.median).collect();
    of_parts(&ratios)
}

/// How far a ratio may be off that was found `parts` times at different times and places, each here over what was
/// found of all: the 95% interval of so few, by Student's distribution ("The Probable Error of a Mean", 1908).
pub fn of_parts(parts: &[f64]) -> f64 {
    let quantile = match parts.len() {
        0 => return f64::INFINITY,
        1 => 12.71,
        2 => 4.303,
        3 => 3.182,
        4 => 2.776,
        _ => 2.571,
    };
    let squares = parts.iter().map(|part| (part - 1.0).powi(2));
    quantile * (squares.sum::<f64>() / parts.len() as f64).sqrt()
}

/// How far the median ratio of a row may be off: by chance, and by what [`of_controls`] says.
pub fn of_row(ratio: &Summary, of_controls: f64) -> f64 {
    of_median(ratio).hypot(of_controls)
}

/// How far the ratio of the times of two rows of one scene may be off. Both are known by their ratios to the
/// default, so if one is the default, there is nothing to add.
pub fn of_pair(a: &Row, b: &Row) -> f64 {
    match a.default || b.default {
        true => a.time_doubt.max(b.time_doubt),
        false => a.time_doubt.hypot(b.time_doubt),
    }
}

/// Whether `a` takes less than `share` of the time of `b`, both of one scene.
pub fn is_faster(a: &Row, b: &Row, share: f64) -> Outcome {
    is_faster_among(a, b, share, 1)
}

/// [`is_faster`], where `n` rivals are asked about one claim: of fifty intervals of 95% some miss
/// by chance, so each is made as much wider as keeps all of them together at 95%.
pub fn is_faster_among(a: &Row, b: &Row, share: f64, n: usize) -> Outcome {
    let doubt = widened(of_pair(a, b), n);
    Outcome::below(a.time_ms / b.time_ms, share, doubt)
}

/// A 95% interval as one of `n` that hold together with 95% (Bonferroni), by the tail of the normal
/// distribution, to a few percent.
pub fn widened(doubt: f64, n: usize) -> f64 {
    const Z: f64 = 1.96;
    doubt * (1.0 + 2.0 * (n.max(1) as f64).ln() / (Z * Z)).sqrt()
}

/// Whether `a` is truer than `b`, both of one scene and metric: confirmed and refuted mean a difference
/// that is told. No difference at all is none.
pub fn is_truer(a: &Row, b: &Row) -> Outcome {
    let (a, b) = (Error::of(a), Error::of(b));
    a.below(&b, 1.0)
}

/// An error, and what either half of its reference makes of it.
#[derive(Clone, Copy, Debug)]
pub struct Error {
    whole: f64,
    halves: [f64; 2],
    /// What one adds to it, if it is a count.
    of_one: f64,
}

impl Error {
    /// Against all samples, and against either half.
    pub fn new(whole: f64, halves: [f64; 2]) -> Error {
        Error { whole, halves, of_one: 0.0 }
    }

    /// Against all samples.
    pub fn whole(&self) -> f64 {
        self.whole
    }

    /// That of a row.
    pub fn of(row: &Row) -> Error {
        let halves = row.error_by_halves.unwrap_or([row.error; 2]);
        Error { whole: row.error, halves, of_one: row.error_of_one.unwrap_or(0.0) }
    }

    /// The error on the straight line from this to another, `part` of the way.
    pub fn towards(self, other: Error, part: f64) -> Error {
        let mix = |a: f64, b: f64| a + (b - a) * part;
        let [even, odd] = [0, 1].map(|half| mix(self.halves[half], other.halves[half]));
        Error { whole: mix(self.whole, other.whole), halves: [even, odd], of_one: self.of_one }
    }

    /// Whether it is below `share` of another.
    pub fn below(&self, other: &Error, share: f64) -> Outcome {
        let [even, odd] = [0, 1].map(|half| self.halves[half] - share * other.halves[half]);
        let counts = self.whole + share * share * other.whole;
        let by_chance = 1.96 * (self.of_one * counts).sqrt();
        Outcome::below(self.whole - share * other.whole, 0.0, (even - odd).abs() + by_chance)
    }
}

#[cfg(test)]
mod tests {
    use super::super::table::tests::row;
    use super::*;

    #[test]
    fn what_is_within_its_doubt_is_not_told() {
        for (value, outcome) in [
            (0.9, Outcome::Confirmed),
            (0.97, Outcome::CannotTell),
            (1.04, Outcome::CannotTell),
            (1.1, Outcome::Refuted),
            (f64::NAN, Outcome::CannotTell),
        ] {
            assert_eq!(Outcome::below(value, 1.0, 0.05), outcome, "{value}");
        }
        assert_eq!(Outcome::below(0.1, 1.0, f64::INFINITY), Outcome::CannotTell);
        assert_eq!(Outcome::Confirmed.and(Outcome::CannotTell), Outcome::CannotTell);
        assert_eq!(Outcome::Refuted.and(Outcome::CannotTell), Outcome::Refuted);
        assert_eq!(Outcome::Confirmed.not(), Outcome::Refuted);
    }

    #[test]
    fn many_intervals_are_wider_so_as_to_hold_together() {
        // Two-sided quantiles of the normal distribution at 5%, .5% and .1%, over that at 5%.
        for (n, wider) in [(1, 1.0), (10, 2.807 / 1.96), (50, 3.291 / 1.96)] {
            assert!((widened(1.0, n) / wider - 1.0).abs() < 0.05, "{n}: {}", widened(1.0, n));
        }
    }

    #[test]
    fn what_no_number_of_rounds_takes_away_is_in_doubt() {
        let control = |ratio| Comparison::of(&[1.0; 9], &[ratio; 9]).unwrap();
        let off = of_controls(&[control(1.03), control(0.96), control(1.0)]);
        assert!((off - 3.182 * (0.002_5_f64 / 3.0).sqrt()).abs() < 1e-9);
        assert_eq!(of_controls(&[]), f64::INFINITY);
        let steady = Summary::of(&[1.0; 9]).unwrap();
        assert_eq!(of_row(&steady, off), off);
        assert_eq!(of_row(&Summary::of(&[1.0]).unwrap(), off), f64::INFINITY);
    }

    #[test]
    fn doubts_of_two_add_up_unless_one_is_the_default() {
        let own = |value, time_doubt| Row { time_doubt, ..row("a", value, 1.0, 0.1) };
        let (default, a, b) = (own("msaa4", 0.02), own("none", 0.03), own("msaa2", 0.04));
        assert_eq!(of_pair(&a, &default), 0.03);
        assert!((of_pair(&a, &b) - 0.05).abs() < 1e-12);
        assert_eq!(is_faster(&Row { time_ms: 0.955, ..a.clone() }, &b, 1.0), Outcome::CannotTell);
        assert_eq!(is_faster(&Row { time_ms: 0.9, ..a }, &b, 1.0), Outcome::Confirmed);
    }

    #[test]
    fn few_rounds_know_little() {
        let of = |samples: &[f64]| of_median(&Summary::of(samples).unwrap());
        assert_eq!(of(&[1.0, 1.0]), f64::INFINITY);
        assert!((of(&[1.0, 0.9, 1.1]) - 0.4).abs() < 1e-12);
        assert!(of(&[0.9, 0.95, 1.0, 1.05, 1.1]) < 0.4);
    }

    #[test]
    fn errors_are_as_sure_as_halves_agree() {
        let with =
            |error, halves| Row { error_by_halves: Some(halves), ..row("a", "x", 1.0, error) };
        let a = with(0.1, [0.1, 0.1]);
        assert_eq!(is_truer(&a, &with(0.2, [0.19, 0.21])), Outcome::Confirmed);
        assert_eq!(is_truer(&with(0.2, [0.19, 0.21]), &a), Outcome::Refuted);
        assert_eq!(is_truer(&a, &with(0.11, [0.09, 0.13])), Outcome::CannotTell);
        // Without a doubt, equal is not truer.
        assert_eq!(is_truer(&a, &a), Outcome::Refuted);
        // 34 and 33 pixels, 34 and 6.
        let counted = |n: f64| Row { error_of_one: Some(8.0), ..row("a", "x", 1.0, 8.0 * n) };
        assert_eq!(is_truer(&counted(33.0), &counted(34.0)), Outcome::CannotTell);
        assert_eq!(is_truer(&counted(6.0), &counted(34.0)), Outcome::Confirmed);
        let exact = |error| row("a", "x", 1.0, error);
        assert_eq!(is_truer(&exact(0.1), &exact(0.100_01)), Outcome::Confirmed);
    }
}
