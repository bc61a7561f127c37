//! What no frame asks for often enough to show: sines and cosines, by the call.
//!
//! A frame takes one tangent per camera, so the trade is measured by itself, on a million angles: within a
//! few turns, as most are; and up to 1e9, where bringing the angle near 0 is most of the work of
//! `libm`. The rows of each stand under a scene of their own.

use std::hint::black_box;
use std::mem;
use std::time::Duration;

use cullet::transform::{SinCos, SinCosTable};
use cullet_measure::{Comparison, Order, Rounds, Summary};

use super::measure::clock;
use super::plan::FEWEST_ROUNDS;

/// Angles of one size.
struct Range {
    scene: &'static str,
    /// Radians, either sign.
    most: f64,
}

const RANGES: [Range; 2] =
    [Range { scene: "calls", most: 20.0 }, Range { scene: "calls to 1e9", most: 1e9 }];

/// Whether rows stand under this name.
pub fn is_scene(name: &str) -> bool {
    RANGES.iter().any(|range| range.scene == name)
}

/// The name of the knob.
pub const KNOB: &str = "sincos";

/// Calls per row: what `time_ms` is the time of, so that a millisecond is a nanosecond per call.
const CALLS: u32 = 1_000_000;
/// Calls per measurement.
const SAMPLE: u32 = 50_000;

/// A way to compute them, measured.
pub struct Call {
    /// The name that its row stands under.
    pub scene: &'static str,
    /// Its name.
    pub value: &'static str,
    /// Seconds for a million calls.
    pub time: Summary,
    /// Over those of the first, round by round.
    pub ratio: Summary,
    /// Its median in each part of the run, over that of all.
    pub parts: Vec<f64>,
    /// Largest error.
    pub error: f64,
}

/// All ways on all ranges, measured in several parts of a run: what a processor does at one time it need
/// not do at another, and one part alone would be surer of its figures than they are.
pub struct Calls {
    ways: Ways,
    ranges: Vec<OfRange>,
    /// Tables and angles of earlier parts, kept so that those of the next lie elsewhere in memory.
    left: Vec<(Ways, Vec<Vec<f64>>)>,
}

type Ways = [(&'static str, SinCos); 5];

/// What is known of one range.
struct OfRange {
    scene: &'static str,
    angles: Vec<f64>,
    /// Seconds of a million calls, by way and round.
    seconds: [Vec<f64>; 5],
    /// How many rounds there were after each part.
    ends: Vec<usize>,
}

impl Calls {
    /// Nothing is measured yet.
    pub fn new() -> Calls {
        let table = |n| SinCos::Table(SinCosTable::new(n));
        let ways = [
            ("libm", SinCos::Libm),
            ("polynomial", SinCos::Polynomial),
            ("table256", table(256)),
            ("table4096", table(4096)),
            ("table65536", table(65536)),
        ];
        let of_range = |range: &Range| OfRange {
            scene: range.scene,
            angles: (0..SAMPLE).map(|i| range.most * place(i)).collect(),
            seconds: Default::default(),
            ends: Vec::new(),
        };
        Calls { ways, ranges: RANGES.iter().map(of_range).collect(), left: Vec::new() }
    }

    /// Measures all, within about `budget`.
    pub fn measure(&mut self, budget: Duration) {
        let ways = self.ways.clone();
        let angles = self.ranges.iter_mut().map(|range| {
            let copy = range.angles.clone();
            mem::replace(&mut range.angles, copy)
        });
        self.left.push((mem::replace(&mut self.ways, ways), angles.collect()));
        for range in &mut self.ranges {
            let mut calls = self.ways.each_ref().map(|(_, way)| {
                let angles = &range.angles;
                move || {
                    let sum = angles.iter().map(|&angle| way.of(angle));
                    black_box(sum.fold((0.0, 0.0), |sum, (s, c)| (sum.0 + s, sum.1 + c)));
                }
            });
            let mut turns: Vec<&mut dyn FnMut()> =
                calls.iter_mut().map(|call| call as &mut dyn FnMut()).collect();
            let rounds = Rounds {
                warm_up: 2,
                at_least: FEWEST_ROUNDS,
                at_most: 101,
                budget: budget / RANGES.len() as u32,
                order: Order::Turning,
            };
            let seconds = rounds.time_on(&mut *clock(1), &mut turns);
            for (known, new) in range.seconds.iter_mut().zip(seconds) {
                known.extend(new.iter().map(|s| s * f64::from(CALLS) / f64::from(SAMPLE)));
            }
            range.ends.push(range.seconds[0].len());
        }
    }

    /// For each range a list, `libm` first. There has been a measurement.
    pub fn all(&self) -> Vec<Vec<Call>> {
        let of_range = |range: &OfRange| {
            let ways = self.ways.iter().zip(&range.seconds);
            let call = |((value, way), own): (&(&'static str, SinCos), &Vec<f64>)| {
                let Comparison { b: time, ratios: ratio, .. } =
                    Comparison::of(&range.seconds[0], own).expect("at least one round");
                let starts = std::iter::once(&0).chain(&range.ends);
                let parts = starts.zip(&range.ends).map(|(&start, &end)| {
                    Comparison::of(&range.seconds[0][start..end], &own[start..end])
                        .expect("at least one round")
                });
                let parts = parts.map(|part| part.ratios.median / ratio.median).collect();
                let errors = range.angles.iter().map(|&angle| error(way, angle));
                let (scene, error) = (range.scene, errors.fold(0.0, f64::max));
                Call { scene, value, time, ratio, parts, error }
            };
            ways.map(call).collect()
        };
        self.ranges.iter().map(of_range).collect()
    }
}

/// Number `i` of numbers from -1 to 1, evenly.
fn place(i: u32) -> f64 {
    let golden = f64::from(i) * 0.618_033_988_749_895;
    2.0 * (golden - golden.floor()) - 1.0
}

fn error(way: &SinCos, angle: f64) -> f64 {
    let ((sin, cos), truth) = (way.of(angle), libm::sincos(angle));
    (sin - truth.0).abs().max((cos - truth.1).abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_add_up_and_errors_are_within_what_is_promised() {
        let mut calls = Calls::new();
        calls.measure(Duration::ZERO);
        calls.measure(Duration::ZERO);
        let all = calls.all();
        assert_eq!(all.len(), RANGES.len());
        for (of_range, range) in all.iter().zip(RANGES) {
            for (call, (name, way)) in of_range.iter().zip(&calls.ways) {
                assert_eq!((call.value, call.scene, call.ratio.n), (*name, range.scene, 6));
                assert!(call.error <= way.error(), "{name}: {}", call.error);
                assert_eq!(call.parts.len(), 2);
                assert!(call.parts.iter().all(|part| *part > 0.0));
            }
        }
    }
}
