//! The rows of the table, their fronts, and both as CSV.
//!
//! Numbers are rounded before fronts are found, so that whoever reads the table finds the same ones.

use cullet_measure::{Align, Standing, Table, Trade, standings};
use serde::Serialize;

use super::calls::{self, Call};
use super::findings::short;
use super::measure::SceneMeasured;
use super::metrics::Metric;

/// Significant digits of every number.
const DIGITS: usize = 5;

/// One value of one knob on one scene, by one metric.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    pub scene: String,
    pub knob: &'static str,
    pub value: &'static str,
    /// Milliseconds, the median of the rounds.
    pub time_ms: f64,
    /// Median over rounds of the time against that of the default in the same round.
    pub time_ratio: f64,
    /// Half the interquartile range of `time_ms` as a fraction of it.
    pub spread: f64,
    #[serde(serialize_with = "metric_name")]
    pub metric: Metric,
    /// 0 for none.
    pub error: f64,
    /// On the front of its scene and metric, or so close behind that the spread does not tell.
    pub pareto: bool,
    /// Beaten, by no more than its spread in time and by next to nothing in error.
    pub tied: bool,
    /// This value is the default's.
    pub default: bool,
    /// Rounds behind the time.
    pub rounds: usize,
    /// The spread of the ratio.
    pub ratio_spread: f64,
    /// The configuration, counted within its scene.
    pub configuration: usize,
}

fn metric_name<S: serde::Serializer>(metric: &Metric, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(metric.name())
}

impl Row {
    /// `knob value`.
    pub fn name(&self) -> String {
        format!("{} {}", self.knob, self.value)
    }

    /// As the front sees it.
    pub fn trade(&self) -> Trade {
        Trade { cost: self.time_ms, spread: self.spread, error: self.error }
    }
}

/// All rows of a scene.
pub fn of_scene(scene: &str, measured: &SceneMeasured) -> Vec<Row> {
    let mut rows = Vec::new();
    for (configuration, one) in measured.all.iter().enumerate() {
        for (knob, value, metrics) in &one.configuration.uses {
            for &metric in *metrics {
                let Some(error) = one.errors.get(metric) else { continue };
                rows.push(Row {
                    scene: scene.to_owned(),
                    knob,
                    value,
                    time_ms: rounded(1e3 * one.time.median),
                    time_ratio: rounded(one.ratio.median),
                    spread: rounded(one.time.spread()),
                    metric,
                    error: rounded(error),
                    pareto: false,
                    tied: false,
                    default: configuration == 0,
                    rounds: one.time.n,
                    ratio_spread: rounded(one.ratio.spread()),
                    configuration,
                });
            }
        }
    }
    rows
}

/// The rows of what is measured by the call.
pub fn of_calls(calls: &[Call]) -> Vec<Row> {
    let row = |(configuration, call): (usize, &Call)| Row {
        scene: calls::SCENE.into(),
        knob: calls::KNOB,
        value: call.value,
        time_ms: rounded(1e3 * call.time.median),
        time_ratio: rounded(call.ratio.median),
        spread: rounded(call.time.spread()),
        metric: Metric::MaxAbs,
        error: rounded(call.error),
        pareto: false,
        tied: false,
        default: configuration == 0,
        rounds: call.time.n,
        ratio_spread: rounded(call.ratio.spread()),
        configuration,
    };
    calls.iter().enumerate().map(row).collect()
}

/// Scenes and metrics that there are rows of, in the order of the rows.
pub fn panels(rows: &[Row]) -> Vec<(String, Metric)> {
    let mut panels = Vec::new();
    for row in rows {
        let panel = (row.scene.clone(), row.metric);
        if !panels.contains(&panel) {
            panels.push(panel);
        }
    }
    panels
}

/// Says of each row whether it is on the front of its scene and metric.
pub fn find_fronts(rows: &mut [Row]) {
    for (scene, metric) in panels(rows) {
        let mut own: Vec<&mut Row> =
            rows.iter_mut().filter(|row| row.scene == scene && row.metric == metric).collect();
        let trades: Vec<Trade> = own.iter().map(|row| row.trade()).collect();
        for ((row, standing), own) in own.iter_mut().zip(standings(&trades)).zip(&trades) {
            row.tied = standing != Standing::Front && is_tied(own, &trades);
            row.pareto = row.tied || standing == Standing::Front;
        }
    }
}

/// The share of an error that nobody sees.
const NEGLIGIBLE: f64 = 0.01;

/// Whether whatever beats `own` does so by no more than its spread in time, and next to nothing in
/// error.
fn is_tied(own: &Trade, all: &[Trade]) -> bool {
    let beats = |other: &&Trade| other.cost <= own.cost && other.error <= own.error;
    all.iter().filter(beats).all(|other| {
        1.0 - other.cost / own.cost <= own.spread && other.error >= (1.0 - NEGLIGIBLE) * own.error
    })
}

/// The table of the contract.
pub fn csv(rows: &[Row]) -> String {
    let columns =
        ["scene", "knob", "value", "time_ms", "time_ratio", "spread", "metric", "error", "pareto"];
    let mut table = Table::new(&columns.map(|name| (name, Align::Left)));
    for row in rows {
        table.push([
            row.scene.clone(),
            row.knob.into(),
            row.value.into(),
            row.time_ms.to_string(),
            row.time_ratio.to_string(),
            row.spread.to_string(),
            row.metric.name().into(),
            row.error.to_string(),
            row.pareto.to_string(),
        ]);
    }
    table.to_csv()
}

/// The fronts alone, for people: of each scene and metric the settings that nothing beats, fastest
/// first.
pub fn fronts(rows: &[Row]) -> String {
    let (left, right) = (Align::Left, Align::Right);
    let columns = [
        ("scene", left),
        ("metric", left),
        ("front", left),
        ("ms", right),
        ("ratio", right),
        ("spread", right),
        ("error", right),
    ];
    let mut table = Table::new(&columns);
    for (scene, metric) in panels(rows) {
        let of_panel = |row: &&Row| row.scene == scene && row.metric == metric;
        let mut front: Vec<&Row> =
            rows.iter().filter(of_panel).filter(|row| row.pareto && !row.tied).collect();
        front.sort_by(|a, b| a.time_ms.total_cmp(&b.time_ms));
        // Of several values that mean one configuration, the first.
        front.dedup_by_key(|row| row.configuration);
        for row in front {
            table.push([
                scene.clone(),
                metric.name().into(),
                row.name(),
                short(row.time_ms),
                format!("{:.2}", row.time_ratio),
                format!("{:.1}%", 100.0 * row.spread),
                short(row.error),
            ]);
        }
    }
    table.to_string()
}

/// A number as the table has it.
pub fn rounded(value: f64) -> f64 {
    if !value.is_finite() {
        return value;
    }
    format!("{value:.*e}", DIGITS - 1).parse().unwrap_or(value)
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// A row with these figures.
    pub fn row(scene: &str, value: &'static str, time_ms: f64, error: f64) -> Row {
        Row {
            scene: scene.into(),
            knob: "aa",
            value,
            time_ms,
            time_ratio: time_ms,
            spread: 0.01,
            metric: Metric::Flip,
            error,
            pareto: false,
            tied: false,
            default: value == "msaa4",
            rounds: 15,
            ratio_spread: 0.01,
            configuration: 0,
        }
    }

    #[test]
    fn fronts_are_per_scene_and_metric() {
        let mut rows = vec![
            row("a", "none", 1.0, 0.3),
            row("a", "msaa2", 2.0, 0.4),
            row("b", "none", 5.0, 0.5),
            Row { metric: Metric::EdgeRmse, ..row("a", "msaa2", 2.0, 0.4) },
        ];
        find_fronts(&mut rows);
        assert_eq!(
            rows.iter().map(|row| row.pareto).collect::<Vec<_>>(),
            [true, false, true, true]
        );
        assert_eq!(panels(&rows).len(), 3);
    }

    #[test]
    fn what_the_spread_does_not_tell_apart_is_tied() {
        let mut rows = vec![
            row("a", "msaa4", 1.0, 0.1),
            row("a", "msaa2", 1.005, 0.1001),
            row("a", "none", 1.005, 0.11),
            row("a", "msaa8", 1.02, 0.1),
        ];
        find_fronts(&mut rows);
        let standing = |row: &Row| (row.pareto, row.tied);
        let all: Vec<_> = rows.iter().map(standing).collect();
        assert_eq!(all, [(true, false), (true, true), (false, false), (false, false)]);
    }

    #[test]
    fn people_see_each_configuration_on_a_front_once() {
        let fast = row("a", "none", 1.0, 0.3);
        let mut rows = vec![
            Row { configuration: 1, ..row("a", "msaa8", 2.0, 0.2) },
            fast.clone(),
            Row { knob: "quality", value: "fast", ..fast },
        ];
        find_fronts(&mut rows);
        let expected = "scene  metric  front     ms  ratio  spread  error\n\
                        a      flip    aa none    1   1.00    1.0%    0.3\n\
                        a      flip    aa msaa8   2   2.00    1.0%    0.2\n";
        assert_eq!(fronts(&rows), expected);
    }

    #[test]
    fn numbers_are_short_and_read_back() {
        for (value, text) in [(1.0 / 3.0, "0.33333"), (12_345.67, "12346"), (0.0, "0")] {
            assert_eq!(rounded(value).to_string(), text);
        }
        let csv = csv(&[row("a,b", "none", 1.5, 2e-9)]);
        let lines: Vec<_> = csv.lines().collect();
        assert_eq!(lines[0], "scene,knob,value,time_ms,time_ratio,spread,metric,error,pareto");
        assert_eq!(lines[1], "\"a,b\",aa,none,1.5,1.5,0.01,flip,0.000000002,false");
    }
}
