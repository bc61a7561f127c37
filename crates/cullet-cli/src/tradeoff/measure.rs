//! One scene: its reference, every configuration's picture and error, then all of them in turn against
//! the clock. Errors are those of the very frames, programs and settings that are timed.

use std::cell::{Cell, RefCell};
use std::iter;
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;
use cullet::{Frame, FrameStats, Prepared, Renderer, Settings, View};
use cullet_measure::{Comparison, MeasureError, Order, Picture, Rounds, Summary};

use super::knobs::{Configuration, configurations, endless_light};
use super::metrics::{Drawn, Errors, Measuring, Metric, picture};
use super::plan::{
    Budget, Costs, FEWEST_ROUNDS, REFERENCE_SHARE, ROUNDS, STUDIES_SHARE, affordable,
    time_for_rounds,
};
use super::reference::{Reference, Room};
use super::study::{Studies, Study, Subject};
use crate::exit::Failure;
use crate::message::Progress;

/// Configurations that are measured whatever the budget: the presets.
const NEEDED: usize = 3;

/// How often the default is measured besides.
const CONTROLS: usize = 3;

/// All rivals take turns in so many places in memory, for where one lies is worth some percent of its time,
/// and stays the same for a whole run (Mytkowicz, Diwan, Hauswirth and Sweeney, "Producing Wrong
/// Data Without Doing Anything Obviously Wrong!", 2009).
const PLACES: usize = 5;

/// A configuration, measured.
pub struct Measured {
    /// What it is.
    pub configuration: Configuration,
    /// Seconds per frame.
    pub time: Summary,
    /// Seconds over those of the first, round by round.
    pub ratio: Summary,
    /// How wrong it is.
    pub errors: Errors,
    /// Its picture.
    pub picture: Picture,
}

/// All of a scene.
pub struct SceneMeasured {
    /// The truth.
    pub reference: Reference,
    /// Most important first; the first is the default.
    pub all: Vec<Measured>,
    /// What did not fit into the budget, as `knob value`.
    pub left_out: Vec<String>,
    /// Rounds timed.
    pub n_rounds: usize,
    /// The default some times more, as if it were another: against itself,
    /// round by round. By what these are off from 1 no two rows can be told apart.
    pub controls: Vec<Comparison>,
    /// What was measured by itself.
    pub studies: Vec<Study>,
}

/// What a run says about where it is.
pub struct Reporter<'a> {
    /// The scene, and which of how many.
    pub scene: String,
    pub budget: &'a Budget,
    /// Scenes in all.
    pub n_scenes: usize,
    pub line: &'a Option<Progress>,
}

impl Reporter<'_> {
    /// Shows a step, where somebody looks.
    pub fn say(&self, step: &str) {
        if let Some(line) = self.line {
            let left = self.budget.left().as_secs();
            line.update(&format!("{}: {step}, at most {left} s left", self.scene));
        }
    }
}

/// What is looked at, and the truth about it.
struct Scene<'a> {
    prepared: &'a Prepared,
    view: &'a View,
    reference: &'a Reference,
}

/// Memory to draw with.
#[derive(Default)]
struct Memory {
    renderer: Renderer,
    frame: Frame,
}

impl Memory {
    fn draw(&mut self, prepared: &Prepared, view: &View, settings: &Settings) -> FrameStats {
        self.renderer.render(prepared, view, settings, &mut self.frame)
    }
}

/// The time a frame takes: of this thread where it is alone at work, or else of the wall.
pub fn clock(threads: usize) -> Box<dyn FnMut() -> Duration> {
    let start = Instant::now();
    match ThreadTime::try_now() {
        Ok(_) if threads == 1 => Box::new(|| ThreadTime::now().as_duration()),
        _ => Box::new(move || start.elapsed()),
    }
}

/// Measures one view until about `end`.
pub fn scene(
    prepared: &Prepared,
    view: &View,
    common: &dyn Fn(&mut Settings),
    threads: usize,
    end: Instant,
    report: &Reporter<'_>,
) -> Result<SceneMeasured, Failure> {
    let begun = Instant::now();
    let whole = end.saturating_duration_since(begun);
    let mut configurations = configurations(common);
    let base = configurations[0].settings;
    let room =
        Room { time: whole.mul_f64(REFERENCE_SHARE), rays: report.budget.rays(report.n_scenes) };
    let mut lit = Settings::balanced();
    endless_light(&mut lit);
    common(&mut lit);
    let say = &mut |step: &str| report.say(step);
    let reference = Reference::find(prepared, view, &base, &lit, room, say)?;

    let subject = Subject {
        scene: &report.scene,
        prepared,
        view,
        settings: base,
        truth: &reference.perceived.whole,
        truth_took: begun.elapsed(),
    };
    report.say("studies");
    let Studies { done: studies, mut left_out, .. } =
        Studies::within(whole.mul_f64(STUDIES_SHARE)).of(&subject)?;
    let mut now = clock(threads);
    let mut rivals: Vec<(Configuration, f64)> = Vec::new();
    let mut places: Vec<Memory> = Vec::new();
    places.resize_with(PLACES, Memory::default);
    let mut drawn = Vec::new();
    let mut costs = Costs::default();
    for (i, configuration) in configurations.drain(..).enumerate() {
        report.say(&format!("errors of {}", name(&configuration)));
        // What is left has to do for the rounds of those before.
        let rounds = time_for_rounds(rivals.iter().map(|(_, seconds)| *seconds));
        let until = end.checked_sub(Duration::from_secs_f64(rounds)).unwrap_or(begun);
        if i >= NEEDED && !costs.fit(&metrics(&configuration), until) {
            left_out.extend(names(&configuration));
            continue;
        }
        let settings = configuration.settings;
        let memory = &mut places[i % PLACES];
        let start = Instant::now();
        let stats = memory.draw(prepared, view, &settings);
        let seconds = start.elapsed().as_secs_f64();
        costs.expect_frames(seconds);
        let scene = Scene { prepared, view, reference: &reference };
        let (metrics, plan) = (metrics(&configuration), (&mut costs, until));
        let (errors, picture, skipped) =
            measure_errors(memory, &settings, &scene, &stats, metrics, plan)
                .map_err(Failure::input)?;
        for metric in skipped {
            let uses = configuration.uses.iter().filter(|(.., metrics)| metrics.contains(&metric));
            left_out.extend(
                uses.map(|(knob, value, _)| format!("{knob} {value} by {}", metric.name())),
            );
        }
        drawn.push((errors, picture));
        rivals.push((configuration, seconds));
    }

    let left = end.saturating_duration_since(Instant::now());
    let costs: Vec<f64> = rivals.iter().map(|(_, seconds)| *seconds).collect();
    let affordable = affordable(&costs, NEEDED, left.as_secs_f64());
    let kept: Vec<_> = rivals.into_iter().zip(drawn).zip(&affordable).collect();
    let mut measured = Vec::new();
    for (((configuration, _), of_one), kept) in kept {
        match kept {
            true => measured.push((configuration, of_one)),
            false => left_out.extend(names(&configuration)),
        }
    }

    report.say("rounds");
    let rivals = measured.iter().map(|(configuration, _)| configuration.settings);
    let rivals: Vec<Settings> = iter::repeat_n(base, CONTROLS).chain(rivals).collect();
    let (places, n): (Vec<_>, _) = (places.into_iter().map(RefCell::new).collect(), Cell::new(0));
    let mut tell = || {
        report.say(&format!("round {}", n.get()));
        n.set(n.get() + 1);
    };
    let draw = |i: usize| {
        let memory = &places[(i + n.get()) % PLACES];
        memory.borrow_mut().draw(prepared, view, &rivals[i]);
    };
    let draw = &draw;
    let mut calls: Vec<_> = (0..rivals.len()).map(|i| move || draw(i)).collect();
    let mut turns: Vec<&mut dyn FnMut()> = vec![&mut tell];
    turns.extend(calls.iter_mut().map(|call| call as &mut dyn FnMut()));
    let rounds = Rounds {
        warm_up: 0, // each has drawn its frame for the errors
        at_least: FEWEST_ROUNDS,
        at_most: 7 * ROUNDS,
        budget: end.saturating_duration_since(Instant::now()),
        order: Order::Turning,
    };
    let seconds = rounds.time_on(&mut *now, &mut turns);
    drop(turns);

    let (controls, rows) = seconds[1..].split_at(CONTROLS);
    let base = &rows[0];
    let against = |own: &Vec<f64>| Comparison::of(base, own).expect("at least one round");
    let controls = controls.iter().map(against).collect();
    let all = measured.into_iter().zip(rows).map(|((configuration, of_one), own)| {
        let Comparison { b: time, ratios: ratio, .. } = against(own);
        let (errors, picture) = of_one;
        Measured { configuration, time, ratio, errors, picture }
    });
    let (all, n_rounds) = (all.collect(), base.len());
    Ok(SceneMeasured { reference, all, left_out, n_rounds, controls, studies })
}

/// The errors of the picture in `memory`, the picture, and the metrics that there was no time for.
fn measure_errors(
    memory: &mut Memory,
    settings: &Settings,
    scene: &Scene<'_>,
    stats: &FrameStats,
    metrics: Vec<Metric>,
    plan: (&mut Costs, Instant),
) -> Result<(Errors, Picture, Vec<Metric>), MeasureError> {
    let (costs, until) = plan;
    let picture = picture(&memory.frame)?;
    let Scene { prepared, view, reference } = *scene;
    let drawn =
        Drawn { prepared, view, settings, picture: &picture, n_kept: stats.objects.n_drawn };
    let mut measuring = Measuring::new(drawn, reference);
    let mut skipped = Vec::new();
    for (i, metric) in metrics.into_iter().enumerate() {
        // One is measured whatever the time: without any there would be no row.
        if i > 0 && !costs.fit(&[metric], until) {
            skipped.push(metric);
            continue;
        }
        let start = Instant::now();
        measuring.measure(&mut memory.renderer, metric)?;
        costs.learn(metric, start.elapsed());
    }
    Ok((measuring.errors, picture, skipped))
}

/// What metrics are measured of a configuration.
fn metrics(configuration: &Configuration) -> Vec<Metric> {
    let all = configuration.uses.iter().flat_map(|(.., metrics)| *metrics);
    let mut metrics: Vec<Metric> = all.copied().collect();
    metrics.sort_unstable();
    metrics.dedup();
    metrics
}

/// The values of knobs that a configuration is.
fn names(configuration: &Configuration) -> impl Iterator<Item = String> {
    configuration.uses.iter().map(|(knob, value, _)| format!("{knob} {value}"))
}

/// The first of them.
pub fn name(configuration: &Configuration) -> String {
    names(configuration).next().unwrap_or_default()
}
