//! How soon is a picture good? Half the resolution first, then frames of one sample, each shifted by a part of
//! a pixel, and their mean after each: what a viewer shows while nobody moves. Beside it, adaptive
//! resolution and the full frame of the default.
//!
//! Times add up from the first frame on, processor time of one thread or wall time, as for the rows;
//! medians of a few runs.

use std::time::Duration;

use cullet::{
    Accumulation, Antialias, Filter, Frame, Pass, Passes, Renderer, Resolution, Settings,
    sample_place,
};
use cullet_measure::{PIXELS_PER_DEGREE, Perceived, Picture, Summary};
use glam::Vec4;

use super::super::doubt::{Outcome, of_median};
use super::super::findings::Verdict;
use super::super::measure::clock;
use super::super::metrics::picture;
use super::super::words::short;
use super::{Claim, Study, Subject};
use crate::exit::Failure;

/// Frames that become one picture in the end.
const FRAMES: u32 = 16;
/// FLIP is taken after so many of them.
const LOOKS: [u32; 5] = [1, 2, 4, 8, 16];
/// Runs that times are medians of.
const RUNS: usize = 5;
/// FLIP below which a picture is good enough to show.
const GOOD: f64 = 0.05;

/// A picture that is there at some time.
struct Shown {
    name: String,
    /// Milliseconds since the start.
    ms: f64,
    /// How far they may be off, as a fraction.
    doubt: f64,
    flip: f64,
}

/// One scene.
pub fn study(subject: &Subject<'_>) -> Result<Study, Failure> {
    let truth = subject.truth;
    let base = subject.settings;
    let half = Settings { resolution: Resolution::Half, ..base };
    let adaptive = Settings { resolution: Resolution::Adaptive, ..base };
    let alone = |name: &str, settings: &Settings| {
        let (time, picture) = drawn(subject, settings)?;
        let (ms, doubt) = (time.median, of_median(&time));
        Ok::<_, Failure>(Shown { name: name.into(), ms, doubt, flip: flip(truth, &picture)? })
    };
    let (half, adaptive, full) =
        (alone("half", &half)?, alone("adaptive", &adaptive)?, alone("full", &base)?);
    let steps = progressive(subject, &half)?;
    let all: Vec<&Shown> = [&half, &adaptive, &full].into_iter().chain(&steps).collect();

    let soonest = |shown: &mut dyn Iterator<Item = &Shown>| {
        let good = shown.filter(|shown| shown.flip < GOOD);
        good.map(|shown| (shown.ms, shown.doubt)).min_by(|a, b| a.0.total_cmp(&b.0))
    };
    let in_steps = soonest(&mut std::iter::once(&half).chain(&steps));
    let ms = |time: Option<(f64, f64)>| {
        time.map_or("never".into(), |(ms, _)| format!("after {} ms", short(ms)))
    };
    let times = format!(
        "progressive {}, adaptive {}, full {}",
        ms(in_steps),
        ms(soonest(&mut std::iter::once(&adaptive))),
        ms(soonest(&mut std::iter::once(&full)))
    );
    let no_later = match (in_steps, soonest(&mut std::iter::once(&full))) {
        (Some(a), Some(b)) => Outcome::below(a.0 / b.0, 1.0, a.1.max(b.1)),
        (a, _) => Outcome::exactly(a.is_some()),
    };
    let falls = steps.windows(2).all(|pair| pair[1].flip <= pair[0].flip);
    let path = steps.iter().map(|s| format!("{} after {} ms", short(s.flip), short(s.ms)));
    let path = path.collect::<Vec<_>>().join(", ");
    let verdict = |outcome, figures| Verdict { scene: subject.scene.into(), outcome, figures };
    Ok(Study {
        name: "progressive",
        scene: Some(subject.scene.into()),
        about: "FLIP over time: half the resolution, then the mean of ever more frames of one sample; beside it \
                adaptive resolution and the full frame of the default",
        columns: ["ms", "FLIP"].map(String::from).to_vec(),
        lines: all.iter().map(|shown| (shown.name.clone(), vec![shown.ms, shown.flip])).collect(),
        claims: vec![
            Claim {
                text: "Progressive drawing has a picture of FLIP below .05 sooner than the full frame",
                verdict: verdict(no_later, times),
            },
            Claim {
                text: "Each doubling of the frames of progressive drawing makes a truer picture",
                verdict: verdict(Outcome::exactly(falls), path),
            },
        ],
    })
}

/// Milliseconds of a frame, and its picture.
fn drawn(subject: &Subject<'_>, settings: &Settings) -> Result<(Summary, Picture), Failure> {
    let mut now = clock(settings.threads);
    let (mut renderer, mut frame) = (Renderer::default(), Frame::default());
    let mut times = Vec::new();
    for run in 0..=RUNS {
        let begun = now();
        renderer.render(subject.prepared, subject.view, settings, &mut frame);
        if run > 0 {
            times.push(ms(now().saturating_sub(begun)));
        }
    }
    let times = Summary::of(&times).expect("at least one run");
    Ok((times, picture(&frame).map_err(Failure::input)?))
}

/// The pictures after [`LOOKS`] frames; `half` has been shown before.
fn progressive(subject: &Subject<'_>, half: &Shown) -> Result<Vec<Shown>, Failure> {
    let Subject { prepared, view, settings, truth, .. } = subject;
    let settings = Settings {
        passes: Passes::NONE.with(Pass::Linear),
        antialias: Antialias::None,
        filter: Filter::Oversampled(FRAMES.ilog2() as u8),
        ..*settings
    };
    let mut now = clock(settings.threads);
    let (mut renderer, mut frame) = (Renderer::default(), Frame::default());
    let mut times = vec![Vec::new(); LOOKS.len()];
    let mut shown = Vec::new();
    for run in 0..RUNS {
        let mut sum = Accumulation::default();
        let mut spent = Duration::ZERO;
        for i in 0..FRAMES {
            let begun = now();
            // In an order that spreads the first few over the pixel.
            let place = i.reverse_bits() >> (u32::BITS - FRAMES.ilog2());
            let [x, y] = sample_place(place, FRAMES);
            renderer.render(prepared, &view.shifted(x - 0.5, y - 0.5), &settings, &mut frame);
            sum.add(&frame.linear, settings.threads);
            spent += now().saturating_sub(begun);
            let Some(look) = LOOKS.iter().position(|n| *n == i + 1) else { continue };
            times[look].push(ms(spent));
            if run == 0 {
                let picture = shown_picture(&sum, &frame)?;
                let name = format!("{} frames", i + 1);
                shown.push(Shown { name, ms: 0.0, doubt: 0.0, flip: flip(truth, &picture)? });
            }
        }
    }
    for (shown, times) in shown.iter_mut().zip(&times) {
        let times = Summary::of(times).expect("at least one run");
        shown.ms = half.ms + times.median;
        shown.doubt = of_median(&times).max(half.doubt);
    }
    Ok(shown)
}

/// The mean so far as it is shown: in 8 bits, as all pictures that are measured.
fn shown_picture(sum: &Accumulation, frame: &Frame) -> Result<Picture, Failure> {
    let (width, height) = (frame.width as usize, frame.height as usize);
    let color = |i| Vec4::truncate(sum.mean(i)).to_array();
    let colors: Vec<[f32; 3]> = (0..width * height).map(color).collect();
    let exact = Picture::from_linear(width, height, &colors).map_err(Failure::input)?;
    let codes = exact.pixels().iter().flatten().map(|v| (255.0 * v).round() as u8);
    Picture::from_rgb(width, height, &codes.collect::<Vec<u8>>()).map_err(Failure::input)
}

fn flip(truth: &Perceived, picture: &Picture) -> Result<f64, Failure> {
    let map = truth.flip(&Perceived::of(picture, PIXELS_PER_DEGREE)).map_err(Failure::input)?;
    Ok(map.mean())
}

fn ms(time: Duration) -> f64 {
    1e3 * time.as_secs_f64()
}

#[cfg(test)]
mod tests {
    use super::super::tests::of_scene;
    use super::*;

    #[test]
    fn pictures_get_truer_and_time_goes_on() {
        // Against the mean of all frames everything before is less true.
        let study = of_scene("knots", study);
        let numbers: Vec<&Vec<f64>> = study.lines.iter().map(|(_, numbers)| numbers).collect();
        let (alone, steps) = numbers.split_at(3);
        assert_eq!(steps.len(), LOOKS.len());
        assert!(steps.windows(2).all(|pair| pair[0][0] < pair[1][0] && pair[0][1] > pair[1][1]));
        assert!(alone[0][1] > alone[2][1], "half is worse than full");
        assert!(steps[4][1] < 1e-3, "all frames are the truth: {}", steps[4][1]);
    }
}
