//! Error per pixel, and the few numbers that sum it up.

use crate::summary::{quantile_of_sorted, sorted};

/// One error per pixel, row-major, top row first, at least one pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorMap {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `width * height` errors; FLIP's lie in [0, 1], 0 = no visible difference.
    pub values: Vec<f32>,
}

impl ErrorMap {
    /// Mean over all pixels; NaN for a map without pixels.
    pub fn mean(&self) -> f64 {
        self.values.iter().map(|&v| f64::from(v)).sum::<f64>() / self.values.len() as f64
    }

    /// The largest error; NaN for a map without pixels.
    pub fn max(&self) -> f64 {
        self.quantile(1.0)
    }

    /// The error that a fraction `q` in [0, 1] of the pixels does not exceed, interpolated
    /// between neighbours in rank (0.5 = median); NaN for a map without pixels.
    pub fn quantile(&self, q: f64) -> f64 {
        let values: Vec<f64> = self.values.iter().map(|&v| f64::from(v)).collect();
        quantile_of_sorted(&sorted(&values), q)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_quantiles() {
        let map = ErrorMap { width: 2, height: 2, values: vec![0.5, 0.0, 1.0, 0.25] };
        assert_eq!(map.mean(), 0.4375);
        assert_eq!(map.max(), 1.0);
        assert_eq!(map.quantile(0.5), 0.375);
        assert_eq!(map.quantile(0.0), 0.0);
    }
}
