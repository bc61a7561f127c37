//! What no frame asks for often enough to show: sines and cosines, by the call.
//!
//! A frame takes one tangent per camera, so the trade is measured by itself, on a million angles: within a
//! few turns, as most are; and up to 1e9, where bringing the angle near 0 is most of the work of
//! `libm`. The rows of each stand under a scene of their own.

use std::hint::black_box;
use std::time::Duration;

use cullet::transform::{SinCos, SinCosTable};
use cullet_measure::{Comparison, Order, Rounds, Summary};

use super::measure::clock;
use super::plan::ROUNDS;

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
    /// Largest error.
    pub error: f64,
}

/// Measures all ways on all ranges, within about `budget`: for each range a list, `libm` first.
pub fn measure(budget: Duration) -> Vec<Vec<Call>> {
    RANGES.iter().map(|range| of_range(range, budget / RANGES.len() as u32)).collect()
}

fn of_range(range: &Range, budget: Duration) -> Vec<Call> {
    let table = |n| SinCos::Table(SinCosTable::new(n));
    let ways = [
        ("libm", SinCos::Libm),
        ("polynomial", SinCos::Polynomial),
        ("table256", table(256)),
        ("table4096", table(4096)),
        ("table65536", table(65536)),
    ];
    let angles: Vec<f64> = (0..SAMPLE).map(|i| range.most * place(i)).collect();
    let mut calls: Vec<_> = ways
        .iter()
        .map(|(_, way)| {
            || {
                let sum = angles.iter().map(|&angle| way.of(angle));
                black_box(sum.fold((0.0, 0.0), |sum, (s, c)| (sum.0 + s, sum.1 + c)));
            }
        })
        .collect();
    let mut turns: Vec<&mut dyn FnMut()> =
        calls.iter_mut().map(|call| call as &mut dyn FnMut()).collect();
    let rounds =
        Rounds { warm_up: 2, at_least: ROUNDS, at_most: 101, budget, order: Order::Turning };
    let seconds = rounds.time_on(&mut *clock(1), &mut turns);
    let per_call: Vec<Vec<f64>> = seconds
        .iter()
        .map(|own| own.iter().map(|s| s * f64::from(CALLS) / f64::from(SAMPLE)).collect())
        .collect();
    let all = ways.iter().zip(&per_call).map(|((value, way), own)| {
        let Comparison { b: time, ratios: ratio, .. } =
            Comparison::of(&per_call[0], own).expect("at least one round");
        let error = angles.iter().map(|&angle| error(way, angle)).fold(0.0, f64::max);
        Call { scene: range.scene, value, time, ratio, error }
    });
    all.collect()
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
