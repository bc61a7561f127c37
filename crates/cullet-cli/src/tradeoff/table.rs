//! The rows of the table, their fronts, and both as CSV.
//!
//! Numbers are rounded before fronts are found, so that whoever reads the table finds the same ones.

use cullet_measure::{Align, Standing, Table, Trade, standings};
use serde::Serialize;

use super::calls::{self, Call};
use super::doubt::{self, Outcome};
use super::knobs::is_plain;
use super::measure::SceneMeasured;
use super::metrics::Metric;
use super::words::{distinct, short};

/// Significant digits of every number.
const DIGITS: usize = 5;

/// One value of one knob on one scene, by one metric.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    pub scene: String,
    pub knob: &'static str,
    pub value: &'static str,
    /// Milliseconds: the default's median times `time_ratio`, so that what slows whole rounds down does
    /// not tell rows apart.
    pub time_ms: f64,
    /// Median over rounds of the time against that of the default in the same round.
    pub time_ratio: f64,
    /// Half the interquartile range of the ratio, and so of `time_ms`, as a fraction of it. The
    /// default's is that of a copy of it against it.
    pub spread: f64,
    /// How far `time_ms` may be off against other rows of the scene, as a fraction of it: see
    /// [`super::doubt`]. Infinite of less than three rounds.
    #[serde(rename = "time_uncertainty")]
    pub time_doubt: f64,
    #[serde(serialize_with = "metric_name")]
    pub metric: Metric,
    /// 0 for none.
    pub error: f64,
    /// The errors against either half of the reference's samples, where it is made of samples; of
    /// shimmer, in every other pixel and in those between.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error_by_halves: Option<[f64; 2]>,
    /// What one pixel adds to the error, where pixels are counted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error_of_one: Option<f64>,
    /// On the front of its scene and metric, or close behind.
    pub pareto: bool,
    /// Beaten, by no more than its spread in time, and in error by what cannot be told or next to nothing.
    pub tied: bool,
    /// This value is the default's.
    pub default: bool,
    /// Drawn by the plain code, one sample at a time: its time is that of such code, not of the value.
    pub plain_code: bool,
    /// Rounds behind the time.
    pub rounds: usize,
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
        Trade { cost: self.time_ms, uncertainty: self.spread, error: self.error }
    }
}

/// All rows of a scene.
pub fn of_scene(scene: &str, measured: &SceneMeasured) -> Vec<Row> {
    let mut rows = Vec::new();
    let (base, controls) = (&measured.all[0].time, &measured.controls);
    let of_controls = doubt::of_controls(controls);
    for (configuration, one) in measured.all.iter().enumerate() {
        // Against itself the default has no spread: that of a copy stands for it.
        let ratio = if configuration == 0 { &controls[0].ratios } else { &one.ratio };
        for (knob, value, metrics) in &one.configuration.uses {
            for &metric in *metrics {
                let Some(error) = one.errors.get(metric) else { continue };
                rows.push(Row {
                    scene: scene.to_owned(),
                    knob,
                    value,
                    time_ms: rounded(1e3 * base.median * one.ratio.median),
                    time_ratio: rounded(one.ratio.median),
                    spread: rounded(ratio.spread()),
                    time_doubt: rounded(doubt::of_row(ratio, of_controls)),
                    metric,
                    error: rounded(error),
                    error_by_halves: one.errors.get_by_halves(metric).map(|e| e.map(rounded)),
                    error_of_one: (metric == Metric::IdPpm)
                        .then(|| rounded(one.errors.ppm_of_a_pixel)),
                    pareto: false,
                    tied: false,
                    default: configuration == 0,
                    plain_code: is_plain(&one.configuration.settings),
                    rounds: one.ratio.n,
                    configuration,
                });
            }
        }
    }
    rows
}

/// The rows of what is measured by the call, over one range of angles.
pub fn of_calls(calls: &[Call]) -> Vec<Row> {
    let row = |(configuration, call): (usize, &Call)| Row {
        scene: call.scene.into(),
        knob: calls::KNOB,
        value: call.value,
        time_ms: rounded(1e3 * calls[0].time.median * call.ratio.median),
        time_ratio: rounded(call.ratio.median),
        spread: rounded(call.ratio.spread()),
        time_doubt: rounded(doubt::of_row(&call.ratio, doubt::of_parts(&call.parts))),
        metric: Metric::MaxAbs,
        error: rounded(call.error),
        error_by_halves: None,
        error_of_one: None,
        pareto: false,
        tied: false,
        default: configuration == 0,
        plain_code: false,
        rounds: call.ratio.n,
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
        let of_all = standings(&trades);
        let all: Vec<Row> = own.iter().map(|row| Row::clone(row)).collect();
        for (row, standing) in own.iter_mut().zip(of_all) {
            row.tied = standing != Standing::Front && is_tied(row, &all);
            row.pareto = row.tied || standing == Standing::Front;
        }
    }
}

/// Whether whatever beats `own` does so by no more than its spread in time, and in error by what the
/// figures do not tell or next to nothing.
fn is_tied(own: &Row, all: &[Row]) -> bool {
    let beats = |other: &&Row| other.time_ms <= own.time_ms && other.error <= own.error;
    all.iter().filter(beats).all(|other| {
        1.0 - other.time_ms / own.time_ms <= own.spread
            && (doubt::is_truer(other, own) != Outcome::Confirmed
                || own.error_by_halves.is_some()
                    && own.error - other.error <= NEXT_TO_NOTHING * own.error)
    })
}

/// Of an error against a picture of samples: that one code differs in a thousandth of all pixels is told
/// there, and no reason to prefer either.
const NEXT_TO_NOTHING: f64 = 0.005;

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

/// Whether there is a front to speak of: one configuration alone beats nobody.
pub fn has_front(rows: &[&Row]) -> bool {
    distinct(rows.iter().map(|row| row.configuration)).len() > 1
}

/// The fronts alone, for people: of each scene and metric the settings that nothing beats, fastest
/// first. Without those whose times are of plain code, and fronts of nothing but the default.
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
        let panel: Vec<&Row> = rows.iter().filter(of_panel).collect();
        if !has_front(&panel) {
            continue;
        }
        let on_front = |row: &&Row| row.pareto && !row.tied && !row.plain_code;
        let mut front: Vec<&Row> = panel.into_iter().filter(on_front).collect();
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
            spread: 0.02,
            time_doubt: 0.01,
            metric: Metric::Flip,
            error,
            error_by_halves: None,
            error_of_one: None,
            pareto: false,
            tied: false,
            default: value == "msaa4",
            plain_code: false,
            rounds: 15,
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
    fn what_the_figures_do_not_tell_apart_is_tied() {
        let halves = |row: Row, even, odd| Row { error_by_halves: Some([even, odd]), ..row };
        let mut rows = vec![
            halves(row("a", "msaa4", 1.0, 0.1), 0.1, 0.1),
            halves(row("a", "msaa2", 1.005, 0.101), 0.099, 0.103), // neither told
            halves(row("a", "none", 1.005, 0.101), 0.101, 0.101),  // less true
            halves(row("a", "msaa8", 1.03, 0.1), 0.1, 0.1),        // slower
            halves(row("a", "ssaa4", 1.005, 0.100_4), 0.100_4, 0.100_4), // hardly less true
        ];
        find_fronts(&mut rows);
        let standing = |row: &Row| (row.pareto, row.tied);
        let all: Vec<_> = rows.iter().map(standing).collect();
        let (tied, beaten) = ((true, true), (false, false));
        assert_eq!(all, [(true, false), tied, beaten, beaten, tied]);
    }

    #[test]
    fn people_see_each_configuration_on_a_front_once() {
        let fast = Row { configuration: 2, ..row("a", "none", 1.0, 0.3) };
        let mut rows = vec![
            row("alone", "none", 1.0, 0.3),
            Row { plain_code: true, configuration: 3, ..row("a", "msaa2", 3.0, 0.1) },
            Row { configuration: 1, ..row("a", "msaa8", 2.0, 0.2) },
            fast.clone(),
            Row { knob: "quality", value: "fast", ..fast },
        ];
        find_fronts(&mut rows);
        let expected = "scene  metric  front     ms  ratio  spread  error\n\
                        a      flip    aa none    1   1.00    2.0%    0.3\n\
                        a      flip    aa msaa8   2   2.00    2.0%    0.2\n";
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
        assert_eq!(lines[1], "\"a,b\",aa,none,1.5,1.5,0.02,flip,0.000000002,false");
    }
}
