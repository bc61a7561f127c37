//! Where the tests differ: what each leaves over on generated boxes of nine kinds.

use cullet::cull::distributions::{Distribution, Sample};
use cullet::cull::{Sat, Test, Verdict};

use super::verdicts::TESTS;

/// One kind of boxes and frusta.
#[derive(Clone, Debug)]
pub struct Waste {
    /// Which.
    pub distribution: Distribution,
    /// Boxes asked about.
    pub n_boxes: u64,
    /// Kept by each of [`TESTS`].
    pub n_in: [u64; TESTS.len()],
}

impl Waste {
    /// Asks every test about the boxes of `n_samples` frusta.
    pub fn measure(distribution: Distribution, n_samples: usize, seed: u64) -> Waste {
        let mut waste = Waste { distribution, n_boxes: 0, n_in: [0; TESTS.len()] };
        for Sample { frustum, boxes } in distribution.samples(seed).take(n_samples) {
            let sat = Sat::new(&frustum);
            waste.n_boxes += boxes.len() as u64;
            for bounds in &boxes {
                let verdict = Verdict::on(bounds, &sat);
                for (test, n) in TESTS.iter().zip(&mut waste.n_in) {
                    *n += u64::from(verdict.keeps(*test));
                }
            }
        }
        waste
    }

    /// Boxes that `test`, one of [`TESTS`], keeps.
    pub fn n_in(&self, test: Test) -> u64 {
        TESTS.iter().zip(self.n_in).find(|(known, _)| **known == test).map_or(0, |(_, n)| n)
    }

    /// Percent of what `test` keeps that is not visible.
    pub fn percent(&self, test: Test) -> f64 {
        let kept = self.n_in(test);
        100.0 * kept.saturating_sub(self.n_in(Test::Sat)) as f64 / kept.max(1) as f64
    }
}
