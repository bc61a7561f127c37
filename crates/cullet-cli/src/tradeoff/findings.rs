//! What the figures say, in words made from nothing but the figures.

use cullet_measure::Comparison;
use serde::Serialize;

use super::doubt::{self, Outcome};
use super::knobs::KNOBS;
use super::measure::SceneMeasured;
use super::study::{self, Study};
use super::table::Row;
use super::words::{Range, distinct};
use super::{calls, domination, expectations};

/// One sentence, and what kind it is.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// `confirmed`, `refuted` or `cannot tell` for an expectation, else `measured`.
    pub kind: Kind,
    /// The sentence.
    pub text: String,
}

/// What a sentence is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// An expectation that holds on every scene, beyond doubt.
    Confirmed,
    /// One that does not hold on some scene, beyond doubt.
    Refuted,
    /// One that the figures are not sure enough to tell.
    #[serde(rename = "cannot tell")]
    CannotTell,
    /// A trade.
    Measured,
}

impl Kind {
    /// As people read it.
    pub const fn name(self) -> &'static str {
        match self {
            Kind::Confirmed => "confirmed",
            Kind::Refuted => "refuted",
            Kind::CannotTell => "cannot tell",
            Kind::Measured => "measured",
        }
    }
}

impl From<Outcome> for Kind {
    fn from(outcome: Outcome) -> Kind {
        match outcome {
            Outcome::Confirmed => Kind::Confirmed,
            Outcome::CannotTell => Kind::CannotTell,
            Outcome::Refuted => Kind::Refuted,
        }
    }
}

/// The verdict on a claim, and the figures behind it, for one scene.
#[derive(Clone, Debug)]
pub struct Verdict {
    pub scene: String,
    pub outcome: Outcome,
    pub figures: String,
}

impl Finding {
    /// An expectation about all scenes with what became of it on each: refuted by one that refutes
    /// it, else not told where one does not tell. `None` where nothing was measured of it.
    pub fn of(text: &str, verdicts: &[Verdict]) -> Option<Finding> {
        let outcome = verdicts.iter().map(|verdict| verdict.outcome).reduce(Outcome::and)?;
        let several = verdicts.iter().any(|verdict| verdict.outcome != outcome);
        let figures = verdicts.iter().map(|Verdict { scene, outcome, figures }| {
            let own =
                if several { format!(" {}", Kind::from(*outcome).name()) } else { String::new() };
            format!("{scene}{own}: {figures}")
        });
        let figures: Vec<String> = figures.collect();
        Some(Finding { kind: outcome.into(), text: format!("{text} ({})", figures.join("; ")) })
    }
}

/// The default of a scene, measured once more as if it were another: the copy that is farthest off.
pub struct Control {
    /// The scene.
    pub scene: String,
    /// Of its time, how much the two differ.
    pub off: f64,
    /// How far that may be off itself.
    pub doubt: f64,
    /// Configurations, and metrics of them, that there was no time for.
    pub n_left_out: usize,
}

/// Times that are the same to within this are the same: what the default may be dominated by.
const SAME: f64 = domination::SAVES;

impl Control {
    /// Of a scene that was measured.
    pub fn of(scene: &str, measured: &SceneMeasured) -> Control {
        let off = |control: &&Comparison| (control.ratios.median - 1.0).abs();
        let worst = measured.controls.iter().max_by(|a, b| off(a).total_cmp(&off(b)));
        let worst = worst.expect("there are controls");
        let (off, ratios) = (off(&worst), &worst.ratios);
        let n_left_out = measured.left_out.len();
        Control { scene: scene.into(), off, doubt: doubt::of_median(ratios), n_left_out }
    }

    /// Whether what is the same takes the same time.
    fn verdict(&self) -> Verdict {
        let Control { scene, off, doubt, .. } = self;
        let outcome = Outcome::below(*off, SAME, *doubt);
        let figures = format!("off by {:.1}%, known to {:.1}%", 100.0 * off, 100.0 * doubt);
        Verdict { scene: scene.clone(), outcome, figures }
    }
}

/// All sentences.
pub struct Findings {
    /// What one expects, with its verdict, and what else stands out.
    pub expectations: Vec<Finding>,
    /// A trade per value of a knob.
    pub trades: Vec<Finding>,
}

impl Findings {
    /// From the rows, the controls and the studies alone.
    pub fn of(rows: &[Row], controls: &[Control], studies: &[Study]) -> Findings {
        let verdicts: Vec<Verdict> = controls.iter().map(Control::verdict).collect();
        let text =
            "Three copies of the default, measured in the same rounds, take its time to within 5%";
        let mut expectations: Vec<Finding> = Finding::of(text, &verdicts).into_iter().collect();
        expectations.extend(domination::findings(rows, controls));
        expectations.extend(expectations::findings(rows));
        expectations.extend(study::findings(studies));
        expectations.extend(domination::bargains(rows));
        let mut trades = Vec::new();
        for knob in KNOBS.iter().map(|knob| knob.name).chain([calls::KNOB]) {
            let values = distinct(rows.iter().filter(|row| row.knob == knob).map(|row| row.value));
            trades.extend(values.into_iter().filter_map(|value| trade(rows, knob, value)));
        }
        Findings { expectations, trades }
    }

    /// Those with a verdict and those without, in a row.
    pub fn all(&self) -> impl Iterator<Item = &Finding> {
        self.expectations.iter().chain(&self.trades)
    }
}

/// What a value gains and costs against the default.
fn trade(rows: &[Row], knob: &str, value: &str) -> Option<Finding> {
    let own: Vec<&Row> = rows.iter().filter(|r| r.knob == knob && r.value == value).collect();
    if own.first()?.default {
        return None;
    }
    let ratios = Range::of(own.iter().map(|row| row.time_ratio))?;
    let mut text = format!("{knob} {value} takes {} the time of the default", ratios.times());
    let metrics = distinct(own.iter().map(|row| row.metric));
    let mut clauses = Vec::new();
    for metric in metrics {
        let of_metric = || own.iter().filter(move |row| row.metric == metric);
        let errors = Range::of(of_metric().map(|row| row.error))?;
        let defaults = of_metric().filter_map(|row| default_of(rows, row)).map(|row| row.error);
        let defaults = Range::of(defaults)?;
        let (n, n_front) = (of_metric().count(), of_metric().filter(|row| row.pareto).count());
        let front = match own[0].plain_code {
            true => "its time is that of plain code".into(),
            false => format!("on the front of {n_front} of {n}"),
        };
        clauses.push(format!(
            "{} {} instead of {} ({front})",
            metric.name(),
            errors.words(),
            defaults.words()
        ));
    }
    text += &format!(": {}", clauses.join(", "));
    Some(Finding { kind: Kind::Measured, text })
}

/// The row of the default beside `row`.
fn default_of<'a>(rows: &'a [Row], row: &Row) -> Option<&'a Row> {
    let beside = |other: &&Row| {
        other.scene == row.scene && other.metric == row.metric && other.knob == row.knob
    };
    rows.iter().filter(beside).find(|other| other.default)
}

#[cfg(test)]
mod tests {
    use super::super::table::find_fronts;
    use super::super::table::tests::row;
    use super::*;

    #[test]
    fn a_trade_is_told_with_its_range_over_scenes() {
        let mut rows = vec![
            row("a", "msaa4", 1.0, 0.1),
            row("a", "none", 0.5, 0.3),
            row("b", "msaa4", 1.0, 0.2),
            row("b", "none", 0.6, 0.25),
        ];
        find_fronts(&mut rows);
        let all = Findings::of(&rows, &[], &[]).trades;
        let text = "aa none takes 0.50 to 0.60 times the time of the default: flip 0.25 to 0.3 \
                    instead of 0.1 to 0.2 (on the front of 2 of 2)";
        assert_eq!(all.last(), Some(&Finding { kind: Kind::Measured, text: text.into() }));
    }

    #[test]
    fn what_is_measured_twice_agrees_or_says_so() {
        let first = |off, doubt| {
            let control = Control { scene: "a".into(), off, doubt, n_left_out: 0 };
            Findings::of(&[], &[control], &[]).expectations.remove(0)
        };
        assert_eq!(first(0.02, 0.02).kind, Kind::Confirmed);
        assert_eq!(first(0.04, 0.02).kind, Kind::CannotTell);
        assert_eq!(first(0.08, 0.02).kind, Kind::Refuted);
        assert_eq!(first(0.03, f64::INFINITY).kind, Kind::CannotTell);
        assert!(first(0.03, 0.02).text.ends_with("(a: off by 3.0%, known to 2.0%)"));
    }

    #[test]
    fn one_scene_refutes_and_one_leaves_open() {
        let verdict =
            |scene: &str, outcome| Verdict { scene: scene.into(), outcome, figures: "1".into() };
        let (yes, open) = (verdict("a", Outcome::Confirmed), verdict("b", Outcome::CannotTell));
        let finding = Finding::of("So", &[yes, open]).unwrap();
        assert_eq!(finding.kind, Kind::CannotTell);
        assert_eq!(finding.text, "So (a confirmed: 1; b cannot tell: 1)");
        let alone = Finding::of("So", &[verdict("a", Outcome::Refuted)]).unwrap();
        assert_eq!((alone.kind, alone.text), (Kind::Refuted, "So (a: 1)".into()));
        assert_eq!(Finding::of("So", &[]), None);
    }
}
