//! What fits: wall time shared out among scenes, and among the steps of each.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use super::metrics::{Metric, SHIMMER_FRAMES};

/// The share of the budget that is planned with; the rest is for what takes longer than measured.
const PLANNED: f64 = 0.85;

/// The share of a scene's time that its reference may take.
pub const REFERENCE_SHARE: f64 = 0.35;

/// The share of a scene's time, and of the whole budget, in which studies are begun.
pub const STUDIES_SHARE: f64 = 0.12;

/// What the f64 ray caster is known to cast on one or two cores.
const RAYS_PER_SECOND: f64 = 1e5;

/// Rounds that the figures should come from.
pub const ROUNDS: usize = 15;

/// Rounds that they come from where even that does not fit.
pub const FEWEST_ROUNDS: usize = 3;

/// The share of the time for rounds that they are planned to take.
const MARGIN: f64 = 0.85;

/// Wall time for the whole run.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    start: Instant,
    total: Duration,
}

impl Budget {
    /// Begins now.
    pub fn new(total: Duration) -> Budget {
        Budget { start: Instant::now(), total }
    }

    /// Time gone.
    pub fn elapsed(&self) -> Duration {
        self.start.elapsed()
    }

    /// Rays that the reference of each of `n` scenes may take. Not measured but assumed, so that two runs
    /// have the same reference.
    pub fn rays(&self, n: usize) -> u64 {
        let seconds = REFERENCE_SHARE * self.total.as_secs_f64() / n.max(1) as f64;
        (RAYS_PER_SECOND * seconds) as u64
    }

    /// When the first of `n` scenes that are left should be done.
    pub fn end_of_scene(&self, n: usize) -> Instant {
        let left = self.total.mul_f64(PLANNED).saturating_sub(self.elapsed());
        Instant::now() + left / n.max(1) as u32
    }

    /// What is left of all of it.
    pub fn left(&self) -> Duration {
        self.total.saturating_sub(self.elapsed())
    }
}

/// Seconds that [`ROUNDS`] rounds of rivals of these costs (seconds) are planned to take.
pub fn time_for_rounds(costs: impl Iterator<Item = f64>) -> f64 {
    costs.sum::<f64>() * ROUNDS as f64 / MARGIN
}

/// What measuring by each metric takes, as far as it is known: what it took the last time.
#[derive(Clone, Debug, Default)]
pub struct Costs {
    known: BTreeMap<Metric, Duration>,
}

impl Costs {
    /// That a frame takes so many seconds, for metrics that draw frames and have not been measured.
    pub fn expect_frames(&mut self, seconds: f64) {
        let frames = |n: u32| Duration::from_secs_f64(seconds * f64::from(n));
        self.known.entry(Metric::Shimmer).or_insert(frames(SHIMMER_FRAMES));
        self.known.entry(Metric::IdPpm).or_insert(frames(1));
    }

    /// That measuring by `metric` took so long.
    pub fn learn(&mut self, metric: Metric, took: Duration) {
        self.known.insert(metric, took);
    }

    /// Whether there is time for all of `metrics` until then.
    pub fn fit(&self, metrics: &[Metric], until: Instant) -> bool {
        let takes: Duration = metrics.iter().filter_map(|metric| self.known.get(metric)).sum();
        Instant::now() + takes < until
    }
}

/// Which of rivals of these costs per round (seconds), most important first, are timed: those that
/// fit into `seconds` with [`ROUNDS`] rounds. The first `needed` always are.
pub fn affordable(costs: &[f64], needed: usize, seconds: f64) -> Vec<bool> {
    let per_round = MARGIN * seconds / ROUNDS as f64;
    let mut sum: f64 = costs.iter().take(needed).sum();
    let mut kept = vec![true; costs.len()];
    for (kept, cost) in kept.iter_mut().zip(costs).skip(needed) {
        *kept = sum + cost <= per_round;
        sum += if *kept { *cost } else { 0.0 };
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_fits_stays_in_order_of_importance() {
        let seconds = |per_round: f64| per_round * ROUNDS as f64 / MARGIN + 1e-9;
        let kept = |per_round| affordable(&[1.0, 2.0, 4.0, 1.0], 2, seconds(per_round));
        assert_eq!(kept(8.0), [true, true, true, true]);
        // The dear one goes, the cheap one after it stays.
        assert_eq!(kept(4.0), [true, true, false, true]);
        assert_eq!(kept(3.0), [true, true, false, false]);
        assert_eq!(kept(0.0), [true, true, false, false]);
    }

    #[test]
    fn what_a_metric_took_it_will_take_again() {
        let mut costs = Costs::default();
        let soon = Instant::now() + Duration::from_secs(60);
        let all = [Metric::Flip, Metric::Shimmer];
        assert!(costs.fit(&all, soon));
        costs.expect_frames(1.0);
        assert!(costs.fit(&all, soon));
        costs.learn(Metric::Flip, Duration::from_secs(30));
        assert!(!costs.fit(&all, soon) && costs.fit(&[Metric::Flip], soon));
        costs.learn(Metric::Shimmer, Duration::from_secs(1));
        costs.expect_frames(9.0);
        assert!(costs.fit(&all, soon));
        assert!(!costs.fit(&[], Instant::now()));
    }

    #[test]
    fn scenes_share_what_is_left() {
        let budget = Budget::new(Duration::from_secs(100));
        let share = budget.end_of_scene(4) - Instant::now();
        let planned = Duration::from_secs_f64(100.0 * PLANNED / 4.0);
        assert!(share <= planned && share > planned - Duration::from_secs(1));
        assert!(budget.left() > Duration::from_secs(99));
        let spent = Budget::new(Duration::ZERO);
        assert!(spent.end_of_scene(1) <= Instant::now());
    }
}
