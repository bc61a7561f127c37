//! What the figures say, in words made from nothing but the figures.

use cullet_measure::{Comparison, Trade, dominated_by};
use serde::Serialize;

use super::calls;
use super::knobs::{DIVISION, KNOBS, POINT_LIGHT, QUALITY, SRGB};
use super::measure::SceneMeasured;
use super::metrics::Metric;
use super::table::{Row, panels};

/// One sentence, and what kind it is.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// `confirmed` or `refuted` for an expectation, else `measured`.
    pub kind: Kind,
    /// The sentence.
    pub text: String,
}

/// What a sentence is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// An expectation that holds on every scene.
    Confirmed,
    /// An expectation that does not.
    Refuted,
    /// A trade.
    Measured,
}

/// The default of a scene, measured once more as if it were another.
pub struct Control {
    /// The scene.
    pub scene: String,
    /// Of its time, how much the two differ.
    pub off: f64,
    /// The larger of the spreads.
    pub spread: f64,
}

impl Control {
    /// Of a scene that was measured.
    pub fn of(scene: &str, measured: &SceneMeasured) -> Control {
        let Comparison { a, b, .. } = measured.control;
        let off = (1.0 - b.median / a.median).abs();
        Control { scene: scene.into(), off, spread: a.spread().max(b.spread()) }
    }
}

/// All sentences: expectations first, then a trade per value of a knob.
pub fn findings(rows: &[Row], controls: &[Control]) -> Vec<Finding> {
    let mut all: Vec<Finding> = control(controls).into_iter().collect();
    all.extend(expectations(rows));
    for knob in KNOBS.iter().map(|knob| knob.name).chain([calls::KNOB]) {
        let values = distinct(rows.iter().filter(|row| row.knob == knob).map(|row| row.value));
        for value in values {
            all.extend(trade(rows, knob, value));
        }
    }
    all
}

/// Whether what is the same takes the same time.
fn control(controls: &[Control]) -> Option<Finding> {
    let figures: Vec<String> = controls
        .iter()
        .map(|Control { scene, off, spread }| {
            format!("{scene}: {:.1}%, spread {:.1}%", 100.0 * off, 100.0 * spread)
        })
        .collect();
    let holds = controls.iter().all(|control| control.off <= control.spread);
    let kind = if holds { Kind::Confirmed } else { Kind::Refuted };
    let text = "The default, measured a second time in the same rounds, takes the same time to within its \
                spread";
    (!figures.is_empty())
        .then(|| Finding { kind, text: format!("{text} ({})", figures.join("; ")) })
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
        clauses.push(format!(
            "{} {} instead of {} (on the front of {n_front} of {n})",
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

/// What one expects, and whether it is so.
fn expectations(rows: &[Row]) -> Vec<Finding> {
    let scenes = distinct(rows.iter().map(|row| row.scene.as_str()));
    let find = |scene: &str, knob: &str, value: &str, metric: Metric| {
        rows.iter().find(|row| {
            row.scene == scene && row.knob == knob && row.value == value && row.metric == metric
        })
    };
    let mut all = Vec::new();
    // Every scene gives its verdict and figures, where it has the rows.
    let mut expect = |text: &str, of_scene: &dyn Fn(&str) -> Option<(bool, String)>| {
        let verdicts: Vec<_> =
            scenes.iter().filter_map(|scene| Some((scene, of_scene(scene)?))).collect();
        if verdicts.is_empty() {
            return;
        }
        let holds = verdicts.iter().all(|(_, (holds, _))| *holds);
        let kind = if holds { Kind::Confirmed } else { Kind::Refuted };
        let figures = verdicts.iter().map(|(scene, (_, figures))| format!("{scene}: {figures}"));
        let figures: Vec<_> = figures.collect();
        all.push(Finding { kind, text: format!("{text} ({})", figures.join("; ")) });
    };

    expect("Trilinear filtering shimmers least", &|scene| {
        let of = |value| Some(find(scene, "texture", value, Metric::Shimmer)?.error);
        let (nearest, bilinear, trilinear) = (of("nearest")?, of("bilinear")?, of("trilinear")?);
        let figures = [nearest, bilinear, trilinear].map(short).join(" > ");
        let holds = trilinear < bilinear && trilinear < nearest;
        Some((holds, if holds { figures } else { figures.replace('>', "/") }))
    });
    expect("Anisotropic filtering is nearer to the truth than trilinear", &|scene| {
        let of = |value| find(scene, "texture", value, Metric::Flip);
        let (trilinear, stretched) = (of("trilinear")?, of("anisotropic")?);
        let figures = format!(
            "FLIP {} in {} ms, trilinear {} in {} ms",
            short(stretched.error),
            short(stretched.time_ms),
            short(trilinear.error),
            short(trilinear.time_ms)
        );
        Some((stretched.error < trilinear.error, figures))
    });
    expect(
        "On edges, those in textures included, MSAA is as good as as many frames to within a tenth",
        &|scene| {
            let edge = |knob, value| Some(find(scene, knob, value, Metric::EdgeRmse)?.error);
            let (multi, whole) = (edge("aa", "msaa4")?, edge("accumulate", "4")?);
            Some((multi <= 1.1 * whole, format!("{} against {}", short(multi), short(whole))))
        },
    );
    expect("Adaptive resolution beats half resolution at equal time", &|scene| {
        let of = |value| find(scene, "resolution", value, Metric::Flip);
        let (half, adaptive, full) = (of("half")?, of("adaptive")?, of("full")?);
        // Halfway between half and full, one would have the error of the line between them.
        let part = (adaptive.time_ms - half.time_ms) / (full.time_ms - half.time_ms);
        let line = half.error + (full.error - half.error) * part.clamp(0.0, 1.0);
        let figures = format!(
            "FLIP {} in {} ms, half {} in {} ms, full {} in {} ms",
            short(adaptive.error),
            short(adaptive.time_ms),
            short(half.error),
            short(half.time_ms),
            short(full.error),
            short(full.time_ms)
        );
        Some((adaptive.time_ms < full.time_ms && adaptive.error < line, figures))
    });
    expect("A table of sines is no faster than a polynomial", &|scene| {
        let time = |value| Some(find(scene, calls::KNOB, value, Metric::MaxAbs)?.time_ms);
        let (polynomial, small, libm) = (time("polynomial")?, time("table256")?, time("libm")?);
        let figures = format!(
            "{} ns for the table, {} for the polynomial, {} for libm",
            short(small),
            short(polynomial),
            short(libm)
        );
        Some((small >= 0.95 * polynomial, figures))
    });
    expect("The exact test keeps no object that is outside", &|scene| {
        let row = find(scene, "cull", "sat", Metric::FalseVisible)?;
        Some((row.error == 0.0, format!("{} ppm", short(row.error))))
    });
    expect("Occlusion changes no pixel", &|scene| {
        let of = |value| Some(find(scene, "occlusion", value, Metric::IdPpm)?.error);
        let (on, off) = (of("on")?, of("off")?);
        Some((on == off, format!("{} and {} ppm", short(on), short(off))))
    });
    expect("Leaving out what lies beyond the end of a light changes no pixel", &|scene| {
        let of = |value| {
            let error = |metric| Some(find(scene, POINT_LIGHT, value, metric)?.error);
            Some((error(Metric::LightFlip)?, error(Metric::LightMax)?))
        };
        let (left_out, all) = (of("1")?, of("1-everywhere")?);
        let words = |(flip, most)| format!("FLIP {}, at most {}", short(flip), short(most));
        Some((left_out == all, format!("{} and {}", words(left_out), words(all))))
    });
    expect("A light that ends takes less time than one that does not", &|scene| {
        let of = |value| find(scene, POINT_LIGHT, value, Metric::LightFlip);
        let (none, near, endless) = (of("none")?, of("0.5")?, of("inf")?);
        let figures = format!(
            "{} ms with a reach of 0.5, {} without end, {} without the light; FLIP {}",
            short(near.time_ms),
            short(endless.time_ms),
            short(none.time_ms),
            short(near.error)
        );
        let doubt = 1.0 - (near.spread + endless.spread);
        Some((near.time_ms < doubt * endless.time_ms, figures))
    });
    for (text, knob, value) in [
        ("Reciprocals without dividing save time", DIVISION, "approximate"),
        ("A plain table of sRGB codes saves time", SRGB, "table"),
        ("A polynomial for sRGB codes saves time", SRGB, "polynomial"),
    ] {
        expect(text, &|scene| {
            let of = |value| find(scene, knob, value, Metric::DefaultMax);
            let (rough, exact) = (of(value)?, of("exact")?);
            let figures = format!(
                "{} ms, exact {} ms, off by {} at most",
                short(rough.time_ms),
                short(exact.time_ms),
                short(rough.error)
            );
            let doubt = 1.0 - (rough.spread + exact.spread);
            Some((rough.time_ms < doubt * exact.time_ms, figures))
        });
    }

    let of_preset = |row: &&Row| row.knob == QUALITY;
    expect("The default is beaten by no configuration by more than 5% of its time", &|scene| {
        let own = || rows.iter().filter(move |row| row.scene == scene);
        let mut worst: Option<(f64, String)> = None;
        for (_, metric) in
            panels(rows).into_iter().filter(|(of, metric)| of == scene && *metric != Metric::MaxAbs)
        {
            let panel: Vec<&Row> = own().filter(|row| row.metric == metric).collect();
            let Some(i) = panel.iter().position(|row| row.default) else {
                continue;
            };
            let trades: Vec<Trade> = panel.iter().map(|row| row.trade()).collect();
            let share = dominated_by(&trades, i);
            let by = panel.iter().filter(|row| row.error <= panel[i].error);
            let by = by.min_by(|a, b| a.time_ms.total_cmp(&b.time_ms)).map(|row| row.name());
            if worst.as_ref().is_none_or(|(most, _)| share > *most) {
                let by = if share > 0.0 {
                    format!(" by {}", by.unwrap_or_default())
                } else {
                    String::new()
                };
                worst = Some((share, format!("{:.1}% in {}{by}", 100.0 * share, metric.name())));
            }
        }
        worst.map(|(share, figures)| (share <= 0.05, figures))
    });
    for preset in ["fast", "balanced", "reference"] {
        expect(&format!("The preset {preset} is on its fronts"), &|scene| {
            let own =
                || rows.iter().filter(of_preset).filter(|r| r.scene == scene && r.value == preset);
            let off: Vec<_> =
                own().filter(|row| !row.pareto).map(|row| row.metric.name()).collect();
            own().next()?;
            let figures =
                if off.is_empty() { "all".into() } else { format!("not {}", off.join(", ")) };
            Some((off.is_empty(), figures))
        });
    }
    all
}

/// Least and most.
struct Range {
    least: f64,
    most: f64,
}

impl Range {
    fn of(values: impl Iterator<Item = f64>) -> Option<Range> {
        values.fold(None, |range, value| {
            let Range { least, most } = range.unwrap_or(Range { least: value, most: value });
            Some(Range { least: least.min(value), most: most.max(value) })
        })
    }

    /// `0.1 to 0.2`, or one number where they print alike.
    fn words(&self) -> String {
        let (least, most) = (short(self.least), short(self.most));
        if least == most { least } else { format!("{least} to {most}") }
    }

    fn times(&self) -> String {
        let (least, most) = (format!("{:.2}", self.least), format!("{:.2}", self.most));
        if least == most { format!("{least} times") } else { format!("{least} to {most} times") }
    }
}

/// Three digits.
pub fn short(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let digits = 2 - value.abs().log10().floor() as i32;
    if (-3..=6).contains(&digits) {
        let text = format!("{value:.*}", digits.max(0) as usize);
        if !text.contains('.') {
            return text;
        }
        return text.trim_end_matches('0').trim_end_matches('.').to_owned();
    }
    let text = format!("{value:.2e}");
    let Some((digits, exponent)) = text.split_once('e') else { return text };
    format!("{}e{exponent}", digits.trim_end_matches('0').trim_end_matches('.'))
}

/// The values that differ, in the order they come in.
pub fn distinct<T: PartialEq>(values: impl Iterator<Item = T>) -> Vec<T> {
    let mut distinct = Vec::new();
    for value in values {
        if !distinct.contains(&value) {
            distinct.push(value);
        }
    }
    distinct
}

#[cfg(test)]
mod tests {
    use super::super::table::find_fronts;
    use super::super::table::tests::row;
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        for (value, text) in [
            (0.0, "0"),
            (0.012345, "0.0123"),
            (1.0, "1"),
            (250_000.0, "250000"),
            (3.2e-9, "3.2e-9"),
            (12.34, "12.3"),
        ] {
            assert_eq!(short(value), text);
        }
    }

    #[test]
    fn a_trade_is_told_with_its_range_over_scenes() {
        let mut rows = vec![
            row("a", "msaa4", 1.0, 0.1),
            row("a", "none", 0.5, 0.3),
            row("b", "msaa4", 1.0, 0.2),
            row("b", "none", 0.6, 0.25),
        ];
        find_fronts(&mut rows);
        let all = findings(&rows, &[]);
        let text = "aa none takes 0.50 to 0.60 times the time of the default: flip 0.25 to 0.3 \
                    instead of 0.1 to 0.2 (on the front of 2 of 2)";
        assert_eq!(all.last(), Some(&Finding { kind: Kind::Measured, text: text.into() }));
        let default = "The default is beaten by no configuration by more than 5% of its time \
                       (a: 0.0% in flip; b: 0.0% in flip)";
        assert_eq!(all[0], Finding { kind: Kind::Confirmed, text: default.into() });
    }

    #[test]
    fn what_is_measured_twice_agrees_or_says_so() {
        let first = |off| {
            let control = Control { scene: "a".into(), off, spread: 0.02 };
            findings(&[], &[control]).remove(0)
        };
        assert_eq!(first(0.02).kind, Kind::Confirmed);
        assert_eq!(first(0.03).kind, Kind::Refuted);
        assert!(first(0.03).text.ends_with("(a: 3.0%, spread 2.0%)"));
    }

    #[test]
    fn expectations_are_judged_by_the_rows_alone() {
        let shimmer = |value, error| Row {
            knob: "texture",
            metric: Metric::Shimmer,
            ..row("a", value, 1.0, error)
        };
        let rows = |trilinear| {
            [shimmer("nearest", 0.3), shimmer("bilinear", 0.2), shimmer("trilinear", trilinear)]
        };
        let first = |trilinear| findings(&rows(trilinear), &[]).remove(0);
        assert_eq!(first(0.1).kind, Kind::Confirmed);
        assert_eq!(first(0.1).text, "Trilinear filtering shimmers least (a: 0.3 > 0.2 > 0.1)");
        assert_eq!(first(0.25).kind, Kind::Refuted);
    }
}
