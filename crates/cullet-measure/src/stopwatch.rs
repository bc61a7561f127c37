//! How long does it take? Asked again until the answer holds still or the budget ends.
//!
//! Work shorter than the clock can tell is repeated within a sample, the number of
//! repeats found by doubling, which warms caches and branch predictors on the way. Then
//! samples are taken until the median is known well enough.
//!
//! To compare two pieces of work use [`Rounds`](crate::Rounds): figures taken minutes
//! apart on a shared machine differ by more than the work does.

use crate::Summary;
use std::hint::black_box;
use std::time::{Duration, Instant};

/// When to stop measuring, and how finely to sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stopwatch {
    /// Samples taken whatever the budget says; at least one is.
    pub at_least: usize,
    /// Samples never exceeded, however unsteady.
    pub at_most: usize,
    /// Wall time for warm-up and samples together; a sample begun is finished.
    pub budget: Duration,
    /// Stop once [`Summary::uncertainty`] is below this fraction.
    pub steady: f64,
    /// Repeat short work until a sample lasts this long.
    pub sample: Duration,
}

impl Default for Stopwatch {
    /// 10 to 10 000 samples of 1 ms or more within 1 s, until the median is known to 0.5%.
    fn default() -> Self {
        Stopwatch {
            at_least: 10,
            at_most: 10_000,
            budget: Duration::from_secs(1),
            steady: 0.005,
            sample: Duration::from_millis(1),
        }
    }
}

impl Stopwatch {
    /// Seconds per call of `work`, wall time. What it returns is dropped within the
    /// measured time but never optimised away.
    pub fn measure<T>(&self, mut work: impl FnMut() -> T) -> Summary {
        let start = Instant::now();
        let call = &mut || drop(black_box(work()));
        self.measure_by(&mut || start.elapsed(), call)
    }

    /// [`Stopwatch::measure`] by any clock that starts at zero.
    fn measure_by(&self, now: &mut dyn FnMut() -> Duration, work: &mut dyn FnMut()) -> Summary {
        let mut calls = |n: u64, now: &mut dyn FnMut() -> Duration| {
            let begun = now();
            (0..n).for_each(|_| work());
            now() - begun
        };
        let mut repeats = 1;
        while calls(repeats, now) < self.sample && now() < self.budget {
            repeats *= 2;
        }
        let mut samples = Vec::new();
        let mut look_at = self.at_least;
        loop {
            samples.push(calls(repeats, now).as_secs_f64() / repeats as f64);
            let n = samples.len();
            let spent = n >= self.at_most || (n >= self.at_least && now() >= self.budget);
            if spent || n >= look_at {
                let summary = Summary::of(&samples).expect("at least one sample");
                if spent || summary.uncertainty() < self.steady {
                    return summary;
                }
                look_at = n + n / 8 + 1; // a look costs a sort
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    /// Measures work whose nth call lasts `micros(n)`, by a clock that nothing else moves.
    fn measured(stopwatch: Stopwatch, micros: impl Fn(u64) -> u64) -> (Summary, u64) {
        let (time, n_calls) = (Cell::new(Duration::ZERO), Cell::new(0));
        let summary = stopwatch.measure_by(&mut || time.get(), &mut || {
            time.set(time.get() + Duration::from_micros(micros(n_calls.get())));
            n_calls.set(n_calls.get() + 1);
        });
        (summary, n_calls.get())
    }

    #[test]
    fn steady_work_needs_the_fewest_samples() {
        let (summary, n_calls) = measured(Stopwatch::default(), |_| 2000);
        assert_eq!((summary.n, n_calls), (10, 11));
        assert_eq!((summary.min, summary.median, summary.max), (0.002, 0.002, 0.002));
    }

    #[test]
    fn short_work_is_repeated_to_fill_a_sample() {
        let (summary, n_calls) = measured(Stopwatch::default(), |_| 1);
        assert_eq!(summary.n, 10);
        assert_eq!(n_calls, 2047 + 10 * 1024); // 1 + 2 + … + 1024 to warm up
        assert!((summary.median - 1e-6).abs() < 1e-12);
    }

    #[test]
    fn unsteady_work_ends_with_the_budget() {
        let unsteady = |n: u64| if n.is_multiple_of(2) { 1000 } else { 3000 };
        let stopwatch = Stopwatch { budget: Duration::from_millis(100), ..Default::default() };
        let (summary, _) = measured(stopwatch, unsteady);
        assert!((48..=50).contains(&summary.n), "{}", summary.n);
        assert_eq!((summary.min, summary.max), (0.001, 0.003));
    }

    #[test]
    fn at_most_beats_at_least() {
        let (summary, _) = measured(Stopwatch { at_most: 3, ..Default::default() }, |_| 2000);
        assert_eq!(summary.n, 3);
    }

    #[test]
    fn slow_work_is_still_measured_once() {
        let stopwatch = Stopwatch { at_least: 0, ..Default::default() };
        let (summary, n_calls) = measured(stopwatch, |_| 5_000_000);
        assert_eq!((summary.n, summary.median, n_calls), (1, 5.0, 2));
    }

    #[test]
    fn real_time_passes() {
        let stopwatch = Stopwatch { budget: Duration::from_millis(20), ..Default::default() };
        let summary = stopwatch.measure(|| std::thread::sleep(Duration::from_millis(2)));
        assert!(summary.min >= 0.002);
    }
}
