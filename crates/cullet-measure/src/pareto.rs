//! Which trades are worth making? Those that nothing beats in both cost and error.
//!
//! A point is *beaten* by another that is at least as good in both and better in one. Points that
//! nothing beats are the front. Costs are measured and uncertain, so a point beaten in cost
//! alone, and by no more than its own uncertainty, is [`Standing::Tied`]: another run may well put it
//! first, and saying which of the two is cheaper would be reading noise.
//!
//! Source of the term: Pareto, "Manuale di economia politica", 1906; the plain quadratic search
//! serves the hundreds of points that people look at.

/// One configuration: what it costs and how wrong it is. Smaller is better in both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trade {
    /// Usually seconds or milliseconds, above 0.
    pub cost: f64,
    /// How far the cost may be off, as a fraction of it; [`Summary::uncertainty`].
    ///
    /// [`Summary::uncertainty`]: crate::Summary::uncertainty
    pub uncertainty: f64,
    /// At least 0.
    pub error: f64,
}

/// How a trade stands among others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing {
    /// Nothing beats it.
    Front,
    /// Beaten in cost alone, by no more than its uncertainty.
    Tied,
    /// Beaten, by this one: of all that beat it the cheapest, the first of equals.
    Beaten(usize),
}

impl Standing {
    /// Whether the trade is worth showing as one to make.
    pub fn is_kept(self) -> bool {
        !matches!(self, Standing::Beaten(_))
    }
}

/// How each of `trades` stands among all of them, in their order. One whose cost or error is NaN
/// beats nothing, and is beaten by every other that has both (itself, where there is none).
pub fn standings(trades: &[Trade]) -> Vec<Standing> {
    (0..trades.len()).map(|i| standing(trades, i)).collect()
}

fn standing(trades: &[Trade], i: usize) -> Standing {
    let beaters = || (0..trades.len()).filter(|&other| beats(&trades[other], &trades[i]));
    let Some(cheapest) = beaters().min_by(|a, b| trades[*a].cost.total_cmp(&trades[*b].cost))
    else {
        return if is_number(&trades[i]) { Standing::Front } else { Standing::Beaten(i) };
    };
    let equally_true = beaters().all(|other| trades[other].error == trades[i].error);
    let excess = 1.0 - trades[cheapest].cost / trades[i].cost;
    if equally_true && excess <= trades[i].uncertainty {
        Standing::Tied
    } else {
        Standing::Beaten(cheapest)
    }
}

/// The share of its cost that trade `i` would save by becoming the cheapest other that is no less
/// true; 0 where there is none. What "dominated by 5%" means.
pub fn dominated_by(trades: &[Trade], i: usize) -> f64 {
    let truer = trades.iter().filter(|other| beats(other, &trades[i]));
    truer.map(|other| 1.0 - other.cost / trades[i].cost).fold(0.0, f64::max)
}

fn is_number(trade: &Trade) -> bool {
    !trade.cost.is_nan() && !trade.error.is_nan()
}

fn beats(a: &Trade, b: &Trade) -> bool {
    if !is_number(b) {
        return is_number(a);
    }
    a.cost <= b.cost && a.error <= b.error && (a.cost < b.cost || a.error < b.error)
}

#[cfg(test)]
mod tests {
    use super::Standing::{Beaten, Front, Tied};
    use super::*;

    fn trades<const N: usize>(points: [(f64, f64); N]) -> Vec<Trade> {
        points.map(|(cost, error)| Trade { cost, uncertainty: 0.02, error }).to_vec()
    }

    #[track_caller]
    fn check<const N: usize>(points: [(f64, f64); N], expected: [Standing; N]) {
        assert_eq!(standings(&trades(points)), expected);
    }

    #[test]
    fn what_is_slower_and_worse_is_beaten_by_the_cheapest_that_is_better() {
        check([(1.0, 3.0), (2.0, 2.0), (3.0, 1.0), (2.5, 2.5)], [Front, Front, Front, Beaten(1)]);
        check([(1.0, 1.0), (2.0, 1.0), (3.0, 2.0)], [Front, Beaten(0), Beaten(0)]);
    }

    #[test]
    fn equals_share_the_front() {
        check([(1.0, 1.0), (1.0, 1.0)], [Front, Front]);
        check([(1.0, 1.0), (1.0, 2.0)], [Front, Beaten(0)]);
    }

    #[test]
    fn within_the_uncertainty_and_equally_true_is_a_tie() {
        check([(1.0, 1.0), (1.02, 1.0)], [Front, Tied]);
        check([(1.0, 1.0), (1.03, 1.0)], [Front, Beaten(0)]);
        check([(1.0, 0.9), (1.01, 1.0)], [Front, Beaten(0)]);
        check([(1.0, 0.0), (1.005, 0.0), (1.01, 0.0)], [Front, Tied, Tied]);
        assert!(Front.is_kept() && Tied.is_kept() && !Beaten(0).is_kept());
    }

    #[test]
    fn numbers_beat_what_is_none() {
        let nan = f64::NAN;
        check([(nan, 1.0), (9.0, 9.0), (1.0, nan)], [Beaten(1), Front, Beaten(1)]);
        check([(nan, nan)], [Beaten(0)]);
        check([], []);
    }

    #[test]
    fn domination_is_a_share_of_the_cost() {
        let trades = trades([(8.0, 1.0), (10.0, 1.0), (4.0, 2.0)]);
        assert!((dominated_by(&trades, 1) - 0.2).abs() < 1e-12);
        assert_eq!(dominated_by(&trades, 0), 0.0);
        assert_eq!(dominated_by(&trades, 2), 0.0);
    }

    #[test]
    fn every_trade_off_the_front_has_one_on_it_that_beats_it() {
        let mut state = 1_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 28) + 1.0
        };
        let points: Vec<Trade> = (0..200).map(|_| (next(), next())).map(trade).collect();
        let all = standings(&points);
        for (i, standing) in all.iter().enumerate() {
            let beater = points.iter().zip(&all).any(|(other, s)| {
                *s == Front && other.cost <= points[i].cost && other.error <= points[i].error
            });
            assert!(beater);
            if *standing == Front {
                assert!(!points.iter().any(|other| beats(other, &points[i])));
            }
        }
        fn trade((cost, error): (f64, f64)) -> Trade {
            Trade { cost, uncertainty: 0.0, error }
        }
    }
}
