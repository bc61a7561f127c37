//! What one expects of the knobs, and whether the rows say so. Verdicts follow the rules of
//! [`super::doubt`].

use super::calls;
use super::doubt::{Error, Outcome, is_faster, is_truer, of_pair};
use super::findings::{Finding, Verdict};
use super::knobs::{DIVISION, POINT_LIGHT, SRGB};
use super::metrics::Metric;
use super::table::Row;
use super::words::{distinct, short};

/// As good as: within a tenth.
pub const AS_GOOD: f64 = 1.1;

/// The rows, and what is made of them.
struct Expectations<'a> {
    rows: &'a [Row],
    all: Vec<Finding>,
}

/// Every expectation that there are rows of.
pub fn findings(rows: &[Row]) -> Vec<Finding> {
    let mut expectations = Expectations { rows, all: Vec::new() };
    expectations.textures();
    expectations.edges();
    expectations.resolution();
    expectations.sines();
    expectations.culling();
    expectations.lights();
    expectations.arithmetic();
    expectations.all
}

impl<'a> Expectations<'a> {
    fn find(&self, scene: &str, knob: &str, value: &str, metric: Metric) -> Option<&'a Row> {
        self.rows.iter().find(|row| {
            row.scene == scene && row.knob == knob && row.value == value && row.metric == metric
        })
    }

    /// Every scene gives its verdict and figures, where it has the rows.
    fn expect(&mut self, text: &str, of_scene: impl Fn(&Self, &str) -> Option<(Outcome, String)>) {
        let scenes = distinct(self.rows.iter().map(|row| row.scene.as_str()));
        let verdict = |scene: &&str| {
            let (outcome, figures) = of_scene(self, scene)?;
            Some(Verdict { scene: (*scene).into(), outcome, figures })
        };
        let verdicts: Vec<Verdict> = scenes.iter().filter_map(verdict).collect();
        self.all.extend(Finding::of(text, &verdicts));
    }

    fn textures(&mut self) {
        self.expect("Trilinear filtering shimmers least", |own, scene| {
            let of = |value| own.find(scene, "texture", value, Metric::Shimmer);
            let (nearest, bilinear, trilinear) =
                (of("nearest")?, of("bilinear")?, of("trilinear")?);
            let outcome = is_truer(trilinear, bilinear).and(is_truer(trilinear, nearest));
            let figures = [("nearest", nearest), ("bilinear", bilinear), ("trilinear", trilinear)]
                .map(|(name, row)| format!("{name} {}", short(row.error)));
            Some((outcome, figures.join(", ")))
        });
        self.expect("Anisotropic filtering is nearer to the truth than trilinear", |own, scene| {
            let of = |value| own.find(scene, "texture", value, Metric::Flip);
            let (trilinear, stretched) = (of("trilinear")?, of("anisotropic")?);
            let figures = format!("FLIP {}, trilinear {}", point(stretched), point(trilinear));
            Some((is_truer(stretched, trilinear), figures))
        });
    }

    fn edges(&mut self) {
        let text = "On edges, those in textures included, MSAA is as good as as many frames to within a tenth";
        self.expect(text, |own, scene| {
            let edge = |knob, value| own.find(scene, knob, value, Metric::EdgeRmse);
            let (multi, whole) = (edge("aa", "msaa4")?, edge("accumulate", "4")?);
            let outcome = Error::of(multi).below(&Error::of(whole), AS_GOOD);
            Some((outcome, format!("{} against {}", short(multi.error), short(whole.error))))
        });
        let text = "Beside edges MSAA is not a tenth truer than one sample, and SSAA is truer";
        self.expect(text, |own, scene| {
            let flat = |value| own.find(scene, "aa", value, Metric::FlatRmse);
            let (one, multi, whole) = (flat("none")?, flat("msaa4")?, flat("ssaa4")?);
            let no_truer = Error::of(one).below(&Error::of(multi), AS_GOOD);
            let figures = [("none", one), ("msaa4", multi), ("ssaa4", whole)].map(|(name, row)| {
                format!("{name} {} ({:.1} dB)", short(row.error), -20.0 * row.error.log10())
            });
            Some((no_truer.and(is_truer(whole, one)), figures.join(", ")))
        });
    }

    fn resolution(&mut self) {
        self.expect("Adaptive resolution beats half resolution at equal time", |own, scene| {
            let of = |value| own.find(scene, "resolution", value, Metric::Flip);
            let (half, adaptive, full) = (of("half")?, of("adaptive")?, of("full")?);
            // Halfway between half and full, one would have the error of the line between them.
            let part = (adaptive.time_ms - half.time_ms) / (full.time_ms - half.time_ms);
            let line = Error::of(half).towards(Error::of(full), part.clamp(0.0, 1.0));
            let outcome = is_faster(adaptive, full, 1.0).and(Error::of(adaptive).below(&line, 1.0));
            let figures =
                format!("FLIP {}, half {}, full {}", point(adaptive), point(half), point(full));
            Some((outcome, figures))
        });
    }

    fn sines(&mut self) {
        self.expect("A table of sines is no faster than a polynomial", |own, scene| {
            let of = |value| own.find(scene, calls::KNOB, value, Metric::MaxAbs);
            let (polynomial, table, libm) = (of("polynomial")?, of("table256")?, of("libm")?);
            let figures = format!(
                "{} ns for the table, {} for the polynomial, {} for libm",
                short(table.time_ms),
                short(polynomial.time_ms),
                short(libm.time_ms)
            );
            Some((is_faster(table, polynomial, 1.0).not(), figures))
        });
    }

    fn culling(&mut self) {
        self.expect("The exact test keeps no object that is outside", |own, scene| {
            let row = own.find(scene, "cull", "sat", Metric::FalseVisible)?;
            Some((Outcome::exactly(row.error == 0.0), format!("{} ppm", short(row.error))))
        });
        self.expect("Occlusion makes no more and no fewer pixels wrong", |own, scene| {
            let of = |value| Some(own.find(scene, "occlusion", value, Metric::IdPpm)?.error);
            let (on, off) = (of("on")?, of("off")?);
            Some((Outcome::exactly(on == off), format!("{} and {} ppm", short(on), short(off))))
        });
    }

    fn lights(&mut self) {
        self.expect(
            "Leaving out what lies beyond the end of a light changes no error",
            |own, scene| {
                let of = |value| {
                    let error = |metric| Some(own.find(scene, POINT_LIGHT, value, metric)?.error);
                    Some((error(Metric::LightFlip)?, error(Metric::LightMax)?))
                };
                let (left_out, all) = (of("1")?, of("1-everywhere")?);
                let words = |(flip, most)| format!("FLIP {}, at most {}", short(flip), short(most));
                let figures = format!("{} and {}", words(left_out), words(all));
                Some((Outcome::exactly(left_out == all), figures))
            },
        );
        self.expect("A light that ends takes less time than one that does not", |own, scene| {
            let of = |value| own.find(scene, POINT_LIGHT, value, Metric::LightFlip);
            let (none, near, endless) = (of("none")?, of("0.5")?, of("inf")?);
            let figures = format!(
                "{} with a reach of 0.5, {} without the light; FLIP {}",
                against(near, endless, "that without end"),
                against(none, endless, "it"),
                short(near.error)
            );
            Some((is_faster(near, endless, 1.0), figures))
        });
    }

    fn arithmetic(&mut self) {
        for (text, knob, value) in [
            ("Reciprocals without dividing save time", DIVISION, "approximate"),
            ("A plain table of sRGB codes saves time", SRGB, "table"),
            ("A polynomial for sRGB codes saves time", SRGB, "polynomial"),
        ] {
            self.expect(text, |own, scene| {
                let of = |value| own.find(scene, knob, value, Metric::DefaultMax);
                let (rough, exact) = (of(value)?, of("exact")?);
                let times = against(rough, exact, "exact");
                let figures = format!("{times}, off by {} at most", short(rough.error));
                Some((is_faster(rough, exact, 1.0), figures))
            });
        }
    }
}

/// `0.03 in 7.5 ms`.
fn point(row: &Row) -> String {
    format!("{} in {} ms", short(row.error), short(row.time_ms))
}

/// `0.97 ± 0.01 times the time of ...`.
fn against(a: &Row, b: &Row, name: &str) -> String {
    let (ratio, doubt) = (a.time_ms / b.time_ms, of_pair(a, b));
    format!("{ratio:.3} ± {:.3} times the time of {name}", ratio * doubt)
}

#[cfg(test)]
mod tests {
    use super::super::findings::Kind;
    use super::super::table::tests::row;
    use super::*;

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
        let first = |trilinear| findings(&rows(trilinear)).remove(0);
        assert_eq!(first(0.1).kind, Kind::Confirmed);
        let text =
            "Trilinear filtering shimmers least (a: nearest 0.3, bilinear 0.2, trilinear 0.1)";
        assert_eq!(first(0.1).text, text);
        assert_eq!(first(0.25).kind, Kind::Refuted);
    }

    #[test]
    fn savings_are_told_as_far_as_times_are_known() {
        let of = |value, time_ms| Row {
            knob: DIVISION,
            metric: Metric::DefaultMax,
            ..row("a", value, time_ms, 0.0)
        };
        let kind = |time_ms| {
            let rows = [of("approximate", time_ms), of("exact", 1.0)];
            findings(&rows).remove(0).kind
        };
        assert_eq!(kind(0.98), Kind::Confirmed);
        assert_eq!(kind(0.995), Kind::CannotTell);
        assert_eq!(kind(1.02), Kind::Refuted);
    }
}
