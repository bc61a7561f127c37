//! Which is faster? Rivals run in turn, ABCABC…, so that whatever else the machine does
//! slows them alike.
//!
//! Within a round the rivals stand close in time, so the ratio of a round is steadier than
//! either figure in it; the median of those ratios is the answer, and their spread says
//! how far to trust it. Each rival finds the caches as its predecessor leaves them: always the same one,
//! so that rounds are alike, or in every round another ([`Order`]), so that no rival is always behind the
//! one that leaves least.

use crate::Summary;
use std::time::{Duration, Instant};

/// Who follows whom in a round.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// ABCD, ABCD, ...: what a rival inherits from its predecessor is in its figures, and in no spread.
    #[default]
    Fixed,
    /// Each round begins with another rival and goes around in other steps, the same in every run:
    /// predecessors change, so that what they leave behind is part of the spread.
    Turning,
}

/// How many rounds to run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rounds {
    /// Rounds run first and not counted.
    pub warm_up: usize,
    /// Rounds counted whatever the budget says; at least one is.
    pub at_least: usize,
    /// Rounds never exceeded.
    pub at_most: usize,
    /// Wall time for all rounds, warm-up included; a round begun is finished.
    pub budget: Duration,
    /// Who follows whom.
    pub order: Order,
}

impl Default for Rounds {
    /// One warm-up, then 15 to 101 rounds within 2 s.
    fn default() -> Self {
        let (budget, order) = (Duration::from_secs(2), Order::Fixed);
        Rounds { warm_up: 1, at_least: 15, at_most: 101, budget, order }
    }
}

impl Rounds {
    /// Seconds of wall time, per rival one figure per round, in the order of the rounds.
    ///
    /// One call is one sample: a call should last well above the clock's resolution, some
    /// microseconds, so let short work loop by itself.
    pub fn time(&self, rivals: &mut [&mut dyn FnMut()]) -> Vec<Vec<f64>> {
        let start = Instant::now();
        self.time_by(&mut || start.elapsed(), &mut || start.elapsed(), rivals)
    }

    /// [`Rounds::time`] in seconds of another clock, which only has to run forwards: that of the
    /// processor time of a thread, say, which stands still while other programs have the processor.
    /// The budget is wall time all the same.
    pub fn time_on(
        &self,
        clock: &mut dyn FnMut() -> Duration,
        rivals: &mut [&mut dyn FnMut()],
    ) -> Vec<Vec<f64>> {
        let start = Instant::now();
        self.time_by(&mut || start.elapsed(), clock, rivals)
    }

    /// [`Rounds::time`] for two, already compared.
    pub fn compare(&self, a: &mut dyn FnMut(), b: &mut dyn FnMut()) -> Comparison {
        let seconds = self.time(&mut [a, b]);
        Comparison::of(&seconds[0], &seconds[1]).expect("at least one round")
    }

    /// [`Rounds::time`] by any clock, and a budget by another that starts at zero.
    fn time_by(
        &self,
        spent: &mut dyn FnMut() -> Duration,
        clock: &mut dyn FnMut() -> Duration,
        rivals: &mut [&mut dyn FnMut()],
    ) -> Vec<Vec<f64>> {
        for _ in 0..self.warm_up {
            rivals.iter_mut().for_each(|rival| rival());
        }
        let mut seconds = vec![Vec::new(); rivals.len()];
        for n_done in 1.. {
            for i in self.order.of_round(n_done - 1, rivals.len()) {
                let begun = clock();
                rivals[i]();
                seconds[i].push(clock().saturating_sub(begun).as_secs_f64());
            }
            let over = n_done >= self.at_least && spent() >= self.budget;
            if over || n_done >= self.at_most {
                break;
            }
        }
        seconds
    }
}

impl Order {
    /// The rivals of a round among `n`, in turn.
    fn of_round(self, round: usize, n: usize) -> impl Iterator<Item = usize> {
        let (first, step) = match self {
            Order::Fixed => (0, 1),
            Order::Turning => {
                // Steps that meet all of them: those without a divisor in common with their number.
                let steps: Vec<usize> = (1..n.max(2)).filter(|step| gcd(*step, n) == 1).collect();
                (round % n.max(1), steps[round % steps.len()])
            }
        };
        (0..n).map(move |i| (first + i * step) % n)
    }
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// B against A, from samples taken in the same rounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// The figures of A, seconds.
    pub a: Summary,
    /// The figures of B, seconds.
    pub b: Summary,
    /// B / A round by round: below 1, B is faster. Its median is the answer, its
    /// [`Summary::spread`] how far rounds disagree.
    pub ratios: Summary,
}

impl Comparison {
    /// Pairs the samples up by round; rounds that only one of them has are left out.
    /// `None` when no round is left.
    pub fn of(a: &[f64], b: &[f64]) -> Option<Comparison> {
        let n_rounds = a.len().min(b.len());
        let (a, b) = (&a[..n_rounds], &b[..n_rounds]);
        let ratios: Vec<f64> = a.iter().zip(b).map(|(a, b)| b / a).collect();
        Some(Comparison { a: Summary::of(a)?, b: Summary::of(b)?, ratios: Summary::of(&ratios)? })
    }

    /// Median of B over median of A. Where it disagrees with the median of the ratios by
    /// more than their spread, the machine changed its pace midway.
    pub fn ratio_of_medians(&self) -> f64 {
        self.b.median / self.a.median
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::{Cell, RefCell};

    #[test]
    fn rivals_take_turns_and_the_warm_up_is_not_counted() {
        let order = RefCell::new(String::new());
        let rounds = Rounds { warm_up: 1, at_least: 2, at_most: 2, ..Default::default() };
        let seconds = rounds.time(&mut [
            &mut || order.borrow_mut().push('A'),
            &mut || order.borrow_mut().push('B'),
            &mut || order.borrow_mut().push('C'),
        ]);
        assert_eq!(order.into_inner(), "ABCABCABC");
        assert_eq!(seconds.iter().map(Vec::len).collect::<Vec<_>>(), [2, 2, 2]);
    }

    #[test]
    fn turning_rounds_hold_everybody_once_and_change_predecessors() {
        for n in [0, 1, 2, 3, 8, 12, 43] {
            let mut followed = std::collections::BTreeSet::new();
            for round in 0..60 {
                let order: Vec<usize> = Order::Turning.of_round(round, n).collect();
                let mut sorted = order.clone();
                sorted.sort_unstable();
                assert!(sorted.into_iter().eq(0..n), "{n} in round {round}");
                followed.extend(order.windows(2).filter(|pair| pair[1] == 0).map(|pair| pair[0]));
            }
            assert!(followed.len() >= n / 4, "{n}: {followed:?}");
        }
        let fixed: Vec<usize> = Order::Fixed.of_round(5, 4).collect();
        assert_eq!(fixed, [0, 1, 2, 3]);
    }

    #[test]
    fn a_drifting_machine_leaves_the_pairwise_ratio_alone() {
        let time = Cell::new(0.0);
        let pace = Cell::new(1.0);
        let mut a = || {
            pace.set(pace.get() * 1.1); // every round a tenth slower
            time.set(time.get() + pace.get());
        };
        let mut b = || time.set(time.get() + 0.5 * pace.get());
        let rounds = Rounds { at_least: 15, at_most: 15, ..Default::default() };
        let now = || Duration::from_secs_f64(time.get());
        let seconds = rounds.time_by(&mut { now }, &mut { now }, &mut [&mut a, &mut b]);
        let comparison = Comparison::of(&seconds[0], &seconds[1]).unwrap();
        assert_eq!(comparison.a.n, 15);
        assert!(comparison.a.spread() > 0.3);
        assert!((comparison.ratios.median - 0.5).abs() < 1e-6);
        assert!(comparison.ratios.spread() < 1e-6);
        assert!((comparison.ratio_of_medians() - 0.5).abs() < 1e-6);
    }

    #[test]
    fn the_budget_ends_the_rounds_but_not_before_the_least() {
        let count = |at_least, budget_seconds| {
            let time = Cell::new(Duration::ZERO);
            let budget = Duration::from_secs(budget_seconds);
            let rounds = Rounds { warm_up: 1, at_least, at_most: 50, budget, ..Default::default() };
            let mut work = || time.set(time.get() + Duration::from_secs(1));
            rounds.time_by(&mut || time.get(), &mut || time.get(), &mut [&mut work])[0].len()
        };
        assert_eq!(count(0, 0), 1);
        assert_eq!(count(15, 5), 15);
        assert_eq!(count(3, 11), 10);
        assert_eq!(count(3, 1000), 50);
    }

    #[test]
    fn another_clock_gives_the_seconds_and_wall_time_the_budget() {
        let time = Cell::new(Duration::ZERO);
        let rounds = Rounds { budget: Duration::ZERO, at_least: 2, ..Default::default() };
        let mut hour = || time.set(time.get() + Duration::from_secs(3600));
        let seconds = rounds.time_on(&mut || time.get(), &mut [&mut hour]);
        assert_eq!(seconds, [[3600.0, 3600.0]]);
    }

    #[test]
    fn comparing_pairs_rounds_up() {
        let comparison = Comparison::of(&[1.0, 2.0, 4.0], &[2.0, 4.0]).unwrap();
        assert_eq!((comparison.a.n, comparison.ratios.n), (2, 2));
        assert_eq!(comparison.ratios.median, 2.0);
        assert_eq!(Comparison::of(&[], &[1.0]), None);
        let real = Rounds::default().compare(&mut || (), &mut || ());
        assert!(real.a.n >= 15);
    }
}
