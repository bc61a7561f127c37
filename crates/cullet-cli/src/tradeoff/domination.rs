//! Who is beaten by whom, all errors considered.
//!
//! One picture and one metric do not see all that a setting is for: bilinear filtering may be a little
//! truer than trilinear on a still picture, and it shimmers. So of two configurations one *dominates* the
//! other if it takes less time and is no less true by every metric that was measured of both. Fronts, in the
//! table, are per metric.

use super::doubt::{Error, Outcome, is_faster, is_faster_among, is_truer, of_pair, widened};
use super::findings::{Control, Finding, Kind, Verdict};
use super::knobs::QUALITY;
use super::metrics::Metric;
use super::table::Row;
use super::words::{distinct, short};

/// What a configuration has to save before the default counts as dominated, as a share of time.
pub const SAVES: f64 = 0.05;

/// A bargain has less than this share of the default's error, for no more than [`SAVES`] more time.
const BARGAIN: f64 = 0.75;

/// All rows of a configuration that differ in their metric.
type Configuration<'a> = Vec<&'a Row>;

/// The configurations of a scene.
fn configurations<'a>(rows: &'a [Row], scene: &str) -> Vec<Configuration<'a>> {
    let own = || rows.iter().filter(move |row| row.scene == scene);
    let group = |number| {
        let mut all: Configuration<'a> = Vec::new();
        for row in own().filter(|row| row.configuration == number) {
            if !all.iter().any(|known| known.metric == row.metric) {
                all.push(row);
            }
        }
        all
    };
    distinct(own().map(|row| row.configuration)).into_iter().map(group).collect()
}

/// The rows of both, by the metrics they share.
fn shared<'a>(
    a: &'a Configuration<'_>,
    b: &'a Configuration<'_>,
) -> impl Iterator<Item = (&'a Row, &'a Row)> {
    a.iter().filter_map(|a| Some((*a, *b.iter().find(|b| b.metric == a.metric)?)))
}

/// Whether `other`, one of `n`, takes less than `share` of the time of `own` and is no less true.
fn dominates(
    other: &Configuration<'_>,
    own: &Configuration<'_>,
    share: f64,
    n: usize,
) -> Option<Outcome> {
    let errors = shared(other, own).map(|(other, own)| is_truer(own, other).not());
    Some(errors.reduce(Outcome::and)?.and(is_faster_among(other[0], own[0], share, n)))
}

/// Whether nothing dominates `own`, and what comes nearest to it.
fn stands(own: &Configuration<'_>, all: &[Configuration<'_>], share: f64) -> (Outcome, String) {
    let mut outcome = Outcome::Confirmed;
    let mut rivals = Vec::new();
    for other in all.iter().filter(|other| other[0].configuration != own[0].configuration) {
        let Some(beats) = dominates(other, own, share, all.len() - 1) else { continue };
        outcome = outcome.and(beats.not());
        if beats != Outcome::Refuted {
            rivals.push((beats, other[0]));
        }
    }
    // What is slower, if not for sure, is no news.
    rivals.retain(|(beats, row)| *beats == Outcome::Confirmed || row.time_ms < own[0].time_ms);
    rivals.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.time_ms.total_cmp(&b.1.time_ms)));
    let words = rivals.iter().take(3).map(|(beats, row)| {
        let may = if *beats == Outcome::Confirmed { "" } else { "perhaps " };
        format!("{may}by {}, {}", row.name(), saving(row, own[0], all.len() - 1))
    });
    let words: Vec<String> = words.collect();
    let figures = match (words.is_empty(), outcome) {
        (true, Outcome::Confirmed) => "by none".into(),
        (true, _) => "by none for sure".into(),
        (false, _) => words.join(", "),
    };
    (outcome, figures)
}

/// `-5.1% ± 0.8%` of the time, as one of `n`.
fn saving(row: &Row, own: &Row, n: usize) -> String {
    let doubt = widened(of_pair(row, own), n);
    format!(
        "{:+.1}% ± {:.1}% of its time",
        100.0 * (row.time_ms / own.time_ms - 1.0),
        100.0 * doubt
    )
}

/// By a single metric: what takes less than `share` of the time and is no less true by it, if less
/// true by others.
fn by_one_metric(own: &Configuration<'_>, all: &[Configuration<'_>], share: f64) -> Vec<String> {
    let mut words = Vec::new();
    for other in all {
        let (mut no_worse, mut worse) = (Vec::new(), Vec::new());
        for (other, own) in shared(other, own) {
            let is_worse = is_truer(own, other) == Outcome::Confirmed;
            if is_worse { &mut worse } else { &mut no_worse }.push(other.metric.name());
        }
        let n = all.len() - 1;
        let faster = is_faster_among(other[0], own[0], share, n) != Outcome::Refuted
            && is_faster_among(other[0], own[0], 1.0, n) == Outcome::Confirmed;
        if faster && !no_worse.is_empty() && !worse.is_empty() {
            let (name, saving) = (other[0].name(), saving(other[0], own[0], n));
            let (good, bad) = (no_worse.join(" and "), worse.join(" and "));
            words.push(format!("{name}, {saving}, is no less true by {good}, but is by {bad}"));
        }
    }
    words
}

/// Whether the default and the presets stand. Where configurations were left out, nobody can tell that they
/// do.
pub fn findings(rows: &[Row], controls: &[Control]) -> Vec<Finding> {
    let scenes =
        distinct(rows.iter().filter(|row| row.knob == QUALITY).map(|row| row.scene.as_str()));
    let about = |value: &str, share: f64| {
        let of_scene = |scene: &&str| {
            let all = configurations(rows, scene);
            let is_it =
                |row: &Row| row.scene == *scene && row.knob == QUALITY && row.value == value;
            let number = rows.iter().find(|row| is_it(row))?.configuration;
            let own = all.iter().find(|own| own[0].configuration == number)?;
            let (mut outcome, mut figures) = stands(own, &all, share);
            let is_cut = |control: &Control| control.scene == *scene && control.n_left_out > 0;
            if controls.iter().any(is_cut) {
                outcome = outcome.and(Outcome::CannotTell);
                figures += " of what was measured";
            }
            for words in by_one_metric(own, &all, share) {
                figures += ", while ";
                figures += &words;
            }
            Some(Verdict { scene: (*scene).into(), outcome, figures })
        };
        scenes.iter().filter_map(of_scene).collect::<Vec<_>>()
    };
    let mut all = Vec::new();
    let text = format!(
        "No configuration dominates the default: takes over {:.0}% less time and is no less true by \
         every metric measured of both",
        100.0 * SAVES
    );
    all.extend(Finding::of(&text, &about("balanced", 1.0 - SAVES)));
    for preset in ["fast", "balanced", "reference"] {
        let text = format!(
            "Nothing is faster than the preset {preset} and no less true by every metric measured of both"
        );
        all.extend(Finding::of(&text, &about(preset, 1.0)));
    }
    all
}

/// What is hardly slower than the default and much truer: the default is not beaten by it, and one may
/// still want it.
pub fn bargains(rows: &[Row]) -> Vec<Finding> {
    let mut words = Vec::new();
    for scene in distinct(rows.iter().map(|row| row.scene.as_str())) {
        let all = configurations(rows, scene);
        let Some(own) = all.iter().find(|own| own[0].default) else { continue };
        for other in all.iter().filter(|other| !other[0].default) {
            if is_faster(other[0], own[0], 1.0 + SAVES) != Outcome::Confirmed {
                continue;
            }
            let is_seen = |metric: Metric| metric.is_of_samples() || metric == Metric::Shimmer;
            let truer: Vec<String> = shared(other, own)
                .filter(|(other, own)| {
                    let much = Error::of(other).below(&Error::of(own), BARGAIN);
                    is_seen(own.metric) && much == Outcome::Confirmed
                })
                .map(|(other, own)| {
                    format!("{} of its {}", short(other.error / own.error), own.metric.name())
                })
                .collect();
            if !truer.is_empty() {
                let (name, saving) = (other[0].name(), saving(other[0], own[0], 1));
                words.push(format!("{scene}: {name}, {saving}, has {}", truer.join(", ")));
            }
        }
    }
    let text = format!(
        "Much truer than the default (under {BARGAIN} of its error) for at most {:.0}% more time",
        100.0 * SAVES
    );
    let finding = Finding { kind: Kind::Measured, text: format!("{text}: {}", words.join("; ")) };
    if words.is_empty() { Vec::new() } else { vec![finding] }
}

#[cfg(test)]
mod tests {
    use super::super::table::tests::row;
    use super::*;

    /// The default, and another with these figures by FLIP and by shimmer.
    fn pair(time_ms: f64, flip: f64, shimmer: f64) -> Vec<Row> {
        let of = |value, configuration, time_ms, error, metric| Row {
            knob: QUALITY,
            configuration,
            metric,
            ..row("a", value, time_ms, error)
        };
        let default =
            |error, metric| Row { default: true, ..of("balanced", 0, 1.0, error, metric) };
        vec![
            default(0.1, Metric::Flip),
            default(0.1, Metric::Shimmer),
            of("other", 1, time_ms, flip, Metric::Flip),
            of("other", 1, time_ms, shimmer, Metric::Shimmer),
        ]
    }

    #[track_caller]
    fn check(rows: &[Row], kind: Kind, says: &str) {
        let first = findings(rows, &[]).remove(0);
        assert_eq!(first.kind, kind, "{}", first.text);
        assert!(first.text.contains(says), "{}", first.text);
    }

    #[test]
    fn the_default_is_dominated_by_what_is_faster_and_true_by_all_metrics() {
        check(
            &pair(0.9, 0.1, 0.1),
            Kind::Refuted,
            "(a: by quality other, -10.0% ± 1.0% of its time)",
        );
        check(&pair(0.945, 0.09, 0.1), Kind::CannotTell, "perhaps by quality other");
        check(&pair(0.97, 0.09, 0.1), Kind::Confirmed, "(a: by none)");
        let mut unsure = pair(1.02, 0.09, 0.1);
        unsure[2].time_doubt = 0.1;
        check(&unsure, Kind::CannotTell, "(a: by none for sure)");
        check(&pair(0.9, 0.09, 0.11), Kind::Confirmed, "no less true by flip, but is by shimmer");
        // Half of the samples says so, half does not.
        let mut rows = pair(0.9, 0.11, 0.1);
        rows[2].error_by_halves = Some([0.09, 0.13]);
        check(&rows, Kind::CannotTell, "perhaps");
    }

    #[test]
    fn what_was_left_out_might_dominate() {
        let control = |n_left_out| Control { scene: "a".into(), off: 0.0, doubt: 0.0, n_left_out };
        let first = |rows: &[Row], n| findings(rows, &[control(n)]).remove(0);
        let stands = pair(0.97, 0.09, 0.1);
        assert_eq!(first(&stands, 0).kind, Kind::Confirmed);
        assert_eq!(first(&stands, 1).kind, Kind::CannotTell);
        assert!(first(&stands, 1).text.ends_with("(a: by none of what was measured)"));
        assert_eq!(first(&pair(0.9, 0.1, 0.1), 1).kind, Kind::Refuted);
    }

    #[test]
    fn what_is_hardly_slower_and_much_truer_is_told() {
        let told = |rows: &[Row]| bargains(rows).first().map(|finding| finding.text.clone());
        let text = told(&pair(1.02, 0.05, 0.1)).unwrap();
        assert!(
            text.ends_with(": a: quality other, +2.0% ± 1.0% of its time, has 0.5 of its flip")
        );
        assert_eq!(told(&pair(1.05, 0.05, 0.1)), None);
        assert_eq!(told(&pair(1.02, 0.09, 0.1)), None);
    }
}
