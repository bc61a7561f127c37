//! What does each culling test lose, leave over and cost, on boxes of every kind?
//!
//! Boxes and frusta are those of `cullet cull --distributions`. *Lost* is what a test rejects though the
//! exact test keeps it; or, for the exact test itself, though its centre or a corner lies surely inside
//! all planes. *In vain* is what it keeps though the exact test rejects it. Times are of one box after the
//! other on one thread, medians of rounds in which the tests take turns.

use std::hint::black_box;
use std::time::Duration;

use cullet::cull::distributions::{Distribution, Sample};
use cullet::cull::{Aabb, Frustum, Sat, Test, visible};
use cullet_measure::{Order, Rounds, Summary};

use super::super::doubt::Outcome;
use super::super::findings::Verdict;
use super::super::measure::clock;
use super::super::words::short;
use super::{Claim, Study};

const TESTS: [(Test, &str); 5] = [
    (Test::Corners, "corners"),
    (Test::PVertex, "p-vertex"),
    (Test::Reverse, "reverse"),
    (Test::Both, "both"),
    (Test::Sat, "sat"),
];

/// Frusta per kind of boxes.
const FRUSTA: usize = 12;

// Where in [`TESTS`].
const P_VERTEX: usize = 1;
const REVERSE: usize = 2;
const BOTH: usize = 3;
const SAT: usize = 4;

/// Counts of one kind of boxes, by test.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    n_kept: [u64; TESTS.len()],
    n_in_vain: [u64; TESTS.len()],
    n_lost: [u64; TESTS.len()],
}

/// Every kind of boxes.
pub fn study() -> Study {
    let mut lines = Vec::new();
    let (mut n_lost, mut n_boxes) = ([0; TESTS.len()], 0);
    let mut narrows = Vec::new();
    let mut ns = Vec::new();
    for kind in Distribution::ALL {
        let samples: Vec<Sample> = kind.samples(1).take(FRUSTA).collect();
        let mut counts = Counts::default();
        for Sample { frustum, boxes } in &samples {
            counts.add(frustum, boxes);
            n_boxes += boxes.len();
        }
        let of_kind = ns_per_box(&samples);
        let waste =
            |test: usize| 100.0 * counts.n_in_vain[test] as f64 / counts.n_kept[test].max(1) as f64;
        let vain = counts.n_in_vain;
        narrows.push(vain[BOTH] <= vain[P_VERTEX] && vain[BOTH] <= vain[REVERSE] && vain[SAT] == 0);
        for (test, n) in n_lost.iter_mut().enumerate() {
            *n += counts.n_lost[test];
        }
        let numbers = (0..TESTS.len()).flat_map(|test| [waste(test), of_kind[test]]);
        lines.push((kind.name().to_owned(), numbers.collect()));
        ns.push(of_kind);
    }
    let columns =
        TESTS.iter().flat_map(|(_, name)| [format!("{name} in vain %"), format!("{name} ns")]);
    let by_test = |figure: &dyn Fn(usize) -> String| {
        let words =
            TESTS.iter().enumerate().map(|(test, (_, name))| format!("{name} {}", figure(test)));
        words.collect::<Vec<_>>().join(", ")
    };
    let mean = |test: usize| ns.iter().map(|of_kind| of_kind[test]).sum::<f64>() / ns.len() as f64;
    let verdict = |holds, figures| Verdict {
        scene: format!("{n_boxes} boxes"),
        outcome: Outcome::exactly(holds),
        figures,
    };
    let lost = by_test(&|test| format!("lost {}", n_lost[test]));
    let kept = by_test(&|test| {
        let waste = lines.iter().map(|(_, numbers): &(String, Vec<f64>)| numbers[2 * test]);
        let (least, most) = waste.fold((100.0, 0.0), |(a, b): (f64, f64), w| (a.min(w), b.max(w)));
        format!("{} to {}% in vain at {} ns", short(least), short(most), short(mean(test)))
    });
    Study {
        name: "culling",
        scene: None,
        about: "of what each test keeps, the percentage that the exact test rejects, and nanoseconds per box, \
                by kind of boxes",
        columns: columns.collect(),
        lines: lines.clone(),
        claims: vec![
            Claim {
                text: "No test loses a visible box",
                verdict: verdict(n_lost.iter().all(|n| *n == 0), lost),
            },
            Claim {
                text: "Both tests together keep no more in vain than either, the exact test nothing",
                verdict: verdict(narrows.iter().all(|holds| *holds), kept),
            },
        ],
    }
}

impl Counts {
    fn add(&mut self, frustum: &Frustum, boxes: &[Aabb]) {
        let sat = Sat::new(frustum);
        for bounds in boxes {
            let is_visible = sat.visible(bounds);
            for (i, (test, _)) in TESTS.iter().enumerate() {
                let is_kept = keeps(*test, bounds, frustum, &sat);
                self.n_kept[i] += u64::from(is_kept);
                self.n_in_vain[i] += u64::from(is_kept && !is_visible);
                let is_lost = !is_kept && (is_visible || is_surely_visible(bounds, frustum));
                self.n_lost[i] += u64::from(is_lost);
            }
        }
    }
}

fn keeps(test: Test, bounds: &Aabb, frustum: &Frustum, sat: &Sat) -> bool {
    match test {
        Test::Sat => sat.visible(bounds),
        test => visible(test, frustum, bounds),
    }
}

/// Whether a corner or the centre is inside of every plane.
fn is_surely_visible(bounds: &Aabb, frustum: &Frustum) -> bool {
    let bounds = bounds.relative_to(frustum.origin());
    let points = bounds.corners().into_iter().chain([bounds.center()]);
    let inside = |point| (0..6).all(|plane| frustum.holds(plane, &Aabb { min: point, max: point }));
    points.into_iter().any(inside)
}

/// Nanoseconds per box, by test.
fn ns_per_box(samples: &[Sample]) -> [f64; TESTS.len()] {
    let sats: Vec<Sat> = samples.iter().map(|sample| Sat::new(&sample.frustum)).collect();
    let mut tasks = TESTS.map(|(test, _)| {
        let (samples, sats) = (samples, &sats);
        move || {
            for (Sample { frustum, boxes }, sat) in samples.iter().zip(sats) {
                black_box(boxes.iter().filter(|b| keeps(test, b, frustum, sat)).count());
            }
        }
    });
    let mut turns: Vec<&mut dyn FnMut()> =
        tasks.iter_mut().map(|task| task as &mut dyn FnMut()).collect();
    let budget = Duration::from_millis(60);
    let rounds = Rounds { warm_up: 1, at_least: 5, at_most: 101, budget, order: Order::Turning };
    let seconds = rounds.time_on(&mut *clock(1), &mut turns);
    let n_boxes: usize = samples.iter().map(|sample| sample.boxes.len()).sum();
    let median = |own: &Vec<f64>| Summary::of(own).map_or(0.0, |summary| summary.median);
    std::array::from_fn(|i| median(&seconds[i]) * 1e9 / n_boxes.max(1) as f64)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn nothing_is_lost_and_finer_tests_leave_less() {
        let study = study();
        assert_eq!(study.lines.len(), Distribution::ALL.len());
        for claim in &study.claims {
            assert_eq!(claim.verdict.outcome, Outcome::Confirmed, "{}", claim.verdict.figures);
        }
        let waste = |test: usize| study.lines.iter().map(move |(_, numbers)| numbers[2 * test]);
        assert!(waste(P_VERTEX).any(|percent| percent > 20.0));
        assert!(waste(REVERSE).any(|percent| percent > 20.0));
    }

    #[test]
    fn what_is_in_the_middle_of_the_view_is_surely_visible() {
        let sample = Distribution::Small.samples(3).next().unwrap();
        let (bounds, corners) = (sample.frustum.bounds(), sample.frustum.corners());
        let middle = corners.iter().map(|corner| corner.truncate()).sum::<DVec3>() / 8.0;
        assert!(is_surely_visible(&Aabb { min: middle, max: middle }, &sample.frustum));
        let beside = bounds.max + (bounds.max - bounds.min);
        assert!(!is_surely_visible(&Aabb { min: beside, max: beside }, &sample.frustum));
    }
}
