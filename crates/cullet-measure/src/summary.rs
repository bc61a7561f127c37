//! Many measurements of one thing as a few robust numbers.

/// Order statistics of a set of measurements, in their own unit (seconds for timings).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// How many were taken, at least 1.
    pub n: usize,
    /// The smallest: the figure least disturbed by others on the machine.
    pub min: f64,
    /// First quartile.
    pub q1: f64,
    /// The middle, the figure to report.
    pub median: f64,
    /// Third quartile.
    pub q3: f64,
    /// The largest.
    pub max: f64,
    /// Arithmetic mean; pulled up by stragglers.
    pub mean: f64,
}

impl Summary {
    /// The summary of `samples` in any order, `None` when there are none.
    ///
    /// Quartiles are interpolated between ranks (Hyndman and Fan, "Sample Quantiles in
    /// Statistical Packages", 1996, definition 7). NaN counts as larger than infinity and
    /// makes the mean NaN.
    pub fn of(samples: &[f64]) -> Option<Summary> {
        let sorted = sorted(samples);
        let (&min, &max) = (sorted.first()?, sorted.last()?);
        Some(Summary {
            n: sorted.len(),
            min,
            q1: quantile_of_sorted(&sorted, 0.25),
            median: quantile_of_sorted(&sorted, 0.5),
            q3: quantile_of_sorted(&sorted, 0.75),
            max,
            mean: samples.iter().sum::<f64>() / samples.len() as f64,
        })
    }

    /// Half the interquartile range as a fraction of the median: half of all samples lie
    /// about this close to it. 0 when the quartiles agree.
    pub fn spread(&self) -> f64 {
        let half_range = 0.5 * (self.q3 - self.q1);
        if half_range == 0.0 { 0.0 } else { half_range / self.median }
    }

    /// How far off the median may be, as a fraction of it: the 95% notch of a box plot,
    /// 1.57 interquartile ranges over the square root of n (McGill, Tukey, Larsen,
    /// "Variations of Box Plots", 1978). Shrinks as samples come in; the spread does not.
    /// Infinite for fewer than five samples, whose quartiles say too little.
    pub fn uncertainty(&self) -> f64 {
        if self.n < 5 {
            return f64::INFINITY;
        }
        2.0 * 1.57 * self.spread() / (self.n as f64).sqrt()
    }
}

pub(crate) fn sorted(samples: &[f64]) -> Vec<f64> {
    let mut sorted = samples.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted
}

/// The value at rank `q (n - 1)`, interpolated linearly; NaN for no samples.
pub(crate) fn quantile_of_sorted(sorted: &[f64], q: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let rank = q.clamp(0.0, 1.0) * last as f64;
    let (below, above) = (sorted[rank.floor() as usize], sorted[rank.ceil() as usize]);
    // Equal neighbours first: between two infinities there is no difference to scale.
    if below == above { below } else { below + (above - below) * rank.fract() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_samples_are_their_own_quartiles() {
        let summary = Summary::of(&[4.0, 1.0, 10.0, 2.0, 3.0]).unwrap();
        let Summary { n, min, q1, median, q3, max, mean } = summary;
        assert_eq!((n, min, q1, median, q3, max, mean), (5, 1.0, 2.0, 3.0, 4.0, 10.0, 4.0));
        assert_eq!(summary.spread(), 1.0 / 3.0);
        assert!((summary.uncertainty() - 1.57 * 2.0 / 3.0 / 5f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn quartiles_fall_between_ranks() {
        let summary = Summary::of(&[1.0, 2.0, 3.0, 4.0]).unwrap();
        assert_eq!((summary.q1, summary.median, summary.q3), (1.75, 2.5, 3.25));
    }

    #[test]
    fn one_sample_has_no_spread_and_none_no_summary() {
        let one = Summary::of(&[0.0]).unwrap();
        assert_eq!((one.spread(), one.uncertainty()), (0.0, f64::INFINITY));
        assert_eq!(Summary::of(&[f64::INFINITY; 3]).unwrap().median, f64::INFINITY);
        assert_eq!(Summary::of(&[]), None);
    }

    #[test]
    fn nan_sorts_last() {
        let summary = Summary::of(&[f64::NAN, 1.0, 2.0]).unwrap();
        assert_eq!((summary.min, summary.median), (1.0, 2.0));
        assert!(summary.max.is_nan() && summary.mean.is_nan());
    }
}
