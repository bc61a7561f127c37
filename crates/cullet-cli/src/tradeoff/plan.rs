//! What fits: wall time shared out among scenes, and among the steps of each.

use std::time::{Duration, Instant};

/// The share of the budget that is planned with; the rest is for what takes longer than measured.
const PLANNED: f64 = 0.92;

/// Rounds that the figures should come from.
pub const ROUNDS: usize = 15;

/// Rounds that they come from where even that does not fit.
const FEWEST_ROUNDS: usize = 3;

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

/// What of the list of rivals is timed, and how often.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// By rival: whether it stays.
    pub kept: Vec<bool>,
    /// Rounds that are affordable, after one to warm up.
    pub rounds: usize,
}

/// Chooses among rivals of these costs per round (seconds), most important first, what fits into
/// `seconds` with [`ROUNDS`] rounds and one to warm up. The first `needed` always stay. Where even
/// they do not fit, there are fewer rounds.
pub fn plan(costs: &[f64], needed: usize, seconds: f64) -> Plan {
    let per_round = seconds / (ROUNDS + 1) as f64;
    let mut sum: f64 = costs.iter().take(needed).sum();
    let mut kept = vec![true; costs.len()];
    for (kept, cost) in kept.iter_mut().zip(costs).skip(needed) {
        *kept = sum + cost <= per_round;
        sum += if *kept { *cost } else { 0.0 };
    }
    let rounds = (seconds / sum.max(1e-9)) as usize;
    Plan { kept, rounds: rounds.saturating_sub(1).clamp(FEWEST_ROUNDS, ROUNDS) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_fits_stays_in_order_of_importance() {
        let plan_of = |seconds| plan(&[1.0, 2.0, 4.0, 1.0], 2, seconds);
        assert_eq!(plan_of(1000.0), Plan { kept: vec![true; 4], rounds: 15 });
        // 4 a round: the dear one goes, the cheap one after it stays.
        assert_eq!(plan_of(64.0), Plan { kept: vec![true, true, false, true], rounds: 15 });
        assert_eq!(plan_of(27.0), Plan { kept: vec![true, true, false, false], rounds: 8 });
        assert_eq!(plan_of(0.0), Plan { kept: vec![true, true, false, false], rounds: 3 });
    }

    #[test]
    fn scenes_share_what_is_left() {
        let budget = Budget::new(Duration::from_secs(100));
        let share = budget.end_of_scene(4) - Instant::now();
        assert!(share > Duration::from_secs(22) && share <= Duration::from_secs(23));
        assert!(budget.left() > Duration::from_secs(99));
        let spent = Budget::new(Duration::ZERO);
        assert!(spent.end_of_scene(1) <= Instant::now());
    }
}
