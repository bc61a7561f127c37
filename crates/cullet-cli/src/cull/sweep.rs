//! The frames of a path as a whole: how the middling ones do, and the worst.

use super::Shown;
use cullet::cull::Test;

/// One figure over all cameras.
#[derive(Clone, Debug)]
pub struct Metric {
    /// As keys of reports have it.
    pub name: &'static str,
    /// What it says, for people.
    pub title: &'static str,
    /// Per camera, in the order of the path.
    pub values: Vec<f64>,
}

impl Metric {
    /// The value that `share` of the cameras (0..=1) do not exceed: one that a camera has.
    pub fn percentile(&self, share: f64) -> f64 {
        let mut sorted = self.values.clone();
        sorted.sort_by(f64::total_cmp);
        let rank = (share * sorted.len() as f64).ceil() as usize;
        sorted.get(rank.max(1) - 1).copied().unwrap_or(f64::NAN)
    }

    /// The camera with the greatest value, the first of equals.
    pub fn worst(&self) -> usize {
        let mut worst = 0;
        for (i, value) in self.values.iter().enumerate() {
            if *value > self.values[worst] {
                worst = i;
            }
        }
        worst
    }
}

/// Every figure that tells cameras apart.
pub fn metrics(shown: &[Shown]) -> Vec<Metric> {
    let metric = |name, title, value: &dyn Fn(&Shown) -> Option<f64>| {
        let values: Option<Vec<f64>> = shown.iter().map(value).collect();
        values.map(|values| Metric { name, title, values })
    };
    let kept = |test: Test| move |s: &Shown| Some(s.figures.of(test).n_in as f64);
    let wasted = |test: Test| move |s: &Shown| Some(s.figures.of(test).n_false_visible as f64);
    let of_tree = |value: fn(&Shown) -> f64| move |s: &Shown| Some(value(s));
    let drawn = |i: usize, value: fn(&super::downstream::Drawn) -> f64| {
        move |s: &Shown| s.drawn.get(i).map(value)
    };
    [
        metric("visible", "boxes visible", &kept(Test::Sat)),
        metric("p_vertex_false_visible", "false visible, p-vertex", &wasted(Test::PVertex)),
        metric("both_false_visible", "false visible, both", &wasted(Test::Both)),
        metric(
            "boxes_tested",
            "boxes tested by the walk",
            &of_tree(|s| s.figures.tree.n_boxes_tested() as f64),
        ),
        metric("walk_ms", "walk, ms", &of_tree(|s| s.figures.tree.ms.warm())),
        metric("triangles_all", "triangles, no culling", &drawn(0, |d| d.n_triangles() as f64)),
        metric("triangles", "triangles, with culling", &drawn(1, |d| d.n_triangles() as f64)),
        metric("frame_ms_all", "frame, no culling, ms", &drawn(0, |d| d.ms())),
        metric("frame_ms", "frame, with culling, ms", &drawn(1, |d| d.ms())),
    ]
    .into_iter()
    .flatten()
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_values_of_cameras() {
        let values = (0..100).map(|i| f64::from(i * 37 % 100)).collect();
        let metric = Metric { name: "", title: "", values };
        assert_eq!([0.0, 0.5, 0.9, 1.0].map(|p| metric.percentile(p)), [0.0, 49.0, 89.0, 99.0]);
        assert_eq!(metric.values[metric.worst()], 99.0);
        let one = Metric { values: vec![3.0], ..metric };
        assert_eq!((one.percentile(0.5), one.worst()), (3.0, 0));
    }
}
