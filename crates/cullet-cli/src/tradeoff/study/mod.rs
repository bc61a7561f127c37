//! What one expects that no knob's rows answer: each question measured by itself, with a table of its
//! figures and a verdict.

pub mod culling;
pub mod edges;
pub mod progressive;
pub mod sines;
pub mod subpixel;
pub mod transforms;

use std::time::{Duration, Instant};

use cullet::{Prepared, Settings, View};
use cullet_measure::Perceived;
use serde::Serialize;

use super::findings::Finding;
use super::words::distinct;
use crate::exit::Failure;

/// One question on one scene, or on scenes of its own.
#[derive(Clone, Debug, Serialize)]
pub struct Study {
    /// In one word.
    pub name: &'static str,
    /// The scene of the command line; `None` where the study makes its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scene: Option<String>,
    /// What is measured, and how.
    pub about: &'static str,
    /// What the numbers of a line are.
    pub columns: Vec<String>,
    /// A name, and its numbers.
    pub lines: Vec<(String, Vec<f64>)>,
    /// The expectations, as they came out here.
    #[serde(skip)]
    pub claims: Vec<Claim>,
}

/// An expectation, and its verdict on one scene.
#[derive(Clone, Debug)]
pub struct Claim {
    pub text: &'static str,
    pub verdict: super::findings::Verdict,
}

/// The expectations of all studies, those of one text over all scenes together.
pub fn findings(studies: &[Study]) -> Vec<Finding> {
    let claims: Vec<&Claim> = studies.iter().flat_map(|study| &study.claims).collect();
    let texts = distinct(claims.iter().map(|claim| claim.text));
    let finding = |text: &str| {
        let own = claims.iter().filter(|claim| claim.text == text);
        Finding::of(text, &own.map(|claim| claim.verdict.clone()).collect::<Vec<_>>())
    };
    texts.into_iter().filter_map(finding).collect()
}

/// What a study of a scene looks at.
pub struct Subject<'a> {
    pub scene: &'a str,
    pub prepared: &'a Prepared,
    pub view: &'a View,
    /// The default's.
    pub settings: Settings,
    /// The reference picture.
    pub truth: &'a Perceived,
    /// What it took to find.
    pub truth_took: Duration,
}

/// Studies, as long as there is time; one begun is finished.
pub struct Studies {
    /// Those that were made.
    pub done: Vec<Study>,
    /// The names of those that were not.
    pub left_out: Vec<String>,
    until: Instant,
}

impl Studies {
    /// None yet.
    pub fn within(time: Duration) -> Studies {
        Studies { done: Vec::new(), left_out: Vec::new(), until: Instant::now() + time }
    }

    /// Those that make their own scenes.
    pub fn general(mut self) -> Result<Studies, Failure> {
        self.run("transforms", transforms::study)?;
        self.run("subpixel", subpixel::study)?;
        self.run("culling", || Ok(culling::study()))?;
        Ok(self)
    }

    /// Those of a scene.
    pub fn of(mut self, subject: &Subject<'_>) -> Result<Studies, Failure> {
        // Its own reference is one of few samples.
        self.run_in(subject.truth_took / 2, "edges", || edges::study(subject))?;
        self.run("sines", || sines::study(subject))?;
        self.run("progressive", || progressive::study(subject))?;
        Ok(self)
    }

    fn run(
        &mut self,
        name: &str,
        study: impl FnOnce() -> Result<Study, Failure>,
    ) -> Result<(), Failure> {
        self.run_in(Duration::ZERO, name, study)
    }

    /// If there is time for as long as it `takes`.
    fn run_in(
        &mut self,
        takes: Duration,
        name: &str,
        study: impl FnOnce() -> Result<Study, Failure>,
    ) -> Result<(), Failure> {
        if Instant::now() + takes < self.until {
            self.done.push(study()?);
        } else {
            self.left_out.push(format!("study {name}"));
        }
        Ok(())
    }
}

/// Numbers from 0 to 1 that look random and are the same everywhere.
struct Random(u64);

impl Random {
    /// By a linear congruence (Knuth's MMIX), the upper 32 bits.
    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 32) as f64 / (1_u64 << 32) as f64
    }
}

#[cfg(test)]
pub mod tests {
    use cullet::scene::synth::synth;
    use cullet::{Antialias, Frame, Renderer, Viewport, frame_scene};
    use cullet_measure::PIXELS_PER_DEGREE;

    use super::super::doubt::Outcome;
    use super::super::findings::{Kind, Verdict};
    use super::super::metrics::picture;
    use super::*;

    /// A study of a small picture of a synthetic scene.
    pub fn of_scene(name: &str, study: impl Fn(&Subject<'_>) -> Result<Study, Failure>) -> Study {
        let prepared = Prepared::new(synth(name).unwrap()).unwrap();
        let viewport = Viewport::new(96, 64).unwrap();
        let view = View::new(&frame_scene(&prepared, viewport.aspect()), viewport);
        let settings = Settings { threads: 1, ..Settings::default() };
        let (accumulate, antialias) = (16, Antialias::None);
        let (mut renderer, mut frame) = (Renderer::default(), Frame::default());
        let many = Settings { accumulate, antialias, ..settings };
        renderer.render(&prepared, &view, &many, &mut frame);
        let truth = &Perceived::of(&picture(&frame).unwrap(), PIXELS_PER_DEGREE);
        let (prepared, view, truth_took) = (&prepared, &view, Duration::ZERO);
        let subject = Subject { scene: name, prepared, view, settings, truth, truth_took };
        study(&subject).unwrap_or_else(|failure| panic!("{failure:?}"))
    }

    #[test]
    fn claims_of_one_text_are_one_finding() {
        let study = |scene: &str, outcome| Study {
            name: "x",
            scene: Some(scene.into()),
            about: "",
            columns: Vec::new(),
            lines: Vec::new(),
            claims: vec![Claim {
                text: "So",
                verdict: Verdict { scene: scene.into(), outcome, figures: "1".into() },
            }],
        };
        let all = findings(&[study("a", Outcome::Confirmed), study("b", Outcome::Refuted)]);
        assert_eq!(all.len(), 1);
        assert_eq!(all[0].kind, Kind::Refuted);
    }

    #[test]
    fn without_time_studies_are_left_out_by_name() {
        let studies = Studies::within(Duration::ZERO).general().unwrap_or_else(|_| panic!());
        assert!(studies.done.is_empty());
        assert_eq!(studies.left_out, ["study transforms", "study subpixel", "study culling"]);
    }
}
