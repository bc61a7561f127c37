//! Does it show in a frame how its sines are computed?
//!
//! A frame takes none by itself; whoever turns things does. Here the eye is turned around what it looks at,
//! by angles small and large, with the sine and the cosine of each way to compute them, and the frame is
//! compared with that of `libm`.

use cullet::transform::{SinCos, SinCosTable};
use cullet::{Camera, Frame, Renderer, Settings, View};
use cullet_measure::{PIXELS_PER_DEGREE, Perceived};
use glam::{DMat3, DVec3};

use super::super::doubt::Outcome;
use super::super::findings::Verdict;
use super::super::metrics::picture;
use super::super::words::short;
use super::{Claim, Study, Subject};
use crate::exit::Failure;

/// Radians. The large one is a small one after many turns: what an animation that never ends asks for.
const ANGLES: [f64; 2] = [0.05, 0.05 + 1e8 * std::f64::consts::TAU];

/// FLIP that nobody sees.
const UNSEEN: f64 = 0.01;

/// One scene.
pub fn study(subject: &Subject<'_>) -> Result<Study, Failure> {
    let table = |n| SinCos::Table(SinCosTable::new(n));
    let ways =
        [("polynomial", SinCos::Polynomial), ("table256", table(256)), ("table4096", table(4096))];
    let mut renderer = Renderer::default();
    let mut seen = |way: &SinCos, angle: f64| {
        let camera = turned(subject, way.of(angle))?;
        let view = View::new(&camera, subject.view.viewport());
        let mut frame = Frame::default();
        let settings = Settings { threads: 0, ..subject.settings };
        renderer.render(subject.prepared, &view, &settings, &mut frame);
        let picture = picture(&frame).map_err(Failure::input)?;
        Ok::<_, Failure>(Perceived::of(&picture, PIXELS_PER_DEGREE))
    };
    let mut lines: Vec<(String, Vec<f64>)> =
        ways.iter().map(|(name, _)| ((*name).into(), Vec::new())).collect();
    for angle in ANGLES {
        let truth = seen(&SinCos::Libm, angle)?;
        for ((_, way), (_, flips)) in ways.iter().zip(&mut lines) {
            flips.push(truth.flip(&seen(way, angle)?).map_err(Failure::input)?.mean());
        }
    }
    let most = |flips: &Vec<f64>| flips.iter().copied().fold(0.0, f64::max);
    let figures: Vec<String> =
        lines.iter().map(|(name, flips)| format!("{name} {}", short(most(flips)))).collect();
    let outcome = Outcome::exactly(lines.iter().all(|(_, flips)| most(flips) <= UNSEEN));
    Ok(Study {
        name: "sines",
        scene: Some(subject.scene.into()),
        about: "FLIP of a frame whose eye was turned by a polynomial or a table, against libm",
        columns: ["a small angle", "after 1e8 turns"].map(String::from).to_vec(),
        lines,
        claims: vec![Claim {
            text: "Turning the eye by a polynomial or a table of sines changes no frame by more than FLIP .01",
            verdict: Verdict { scene: subject.scene.into(), outcome, figures: figures.join(", ") },
        }],
    })
}

/// The camera turned around the point it looks at, as far away as the middle of the scene.
fn turned(subject: &Subject<'_>, (sin, cos): (f64, f64)) -> Result<Camera, Failure> {
    let camera = subject.view.camera();
    let bounds = subject.prepared.bounds();
    let middle = if bounds.is_empty() { DVec3::ZERO } else { bounds.center() };
    let distance = (middle - camera.eye()).dot(-camera.back()).abs();
    let distance = if distance > 0.0 && distance.is_finite() { distance } else { 1.0 };
    let target = camera.eye() - camera.back() * distance;
    let turn = DMat3::from_cols(DVec3::new(cos, 0.0, -sin), DVec3::Y, DVec3::new(sin, 0.0, cos));
    let eye = target + turn * (camera.eye() - target);
    Camera::look_at(eye, target, turn * camera.up(), camera.projection()).map_err(Failure::usage)
}

#[cfg(test)]
mod tests {
    use super::super::tests::of_scene;
    use super::*;

    #[test]
    fn polynomials_show_nothing_and_coarse_tables_more() {
        let study = of_scene("knots", study);
        let flips: Vec<&Vec<f64>> = study.lines.iter().map(|(_, flips)| flips).collect();
        let [polynomial, coarse, fine] = flips[..] else { panic!("three ways") };
        for angle in 0..ANGLES.len() {
            assert!(polynomial[angle] < 1e-4, "{polynomial:?}");
            assert!(fine[angle] <= coarse[angle], "{fine:?} {coarse:?}");
        }
        assert!(coarse.iter().any(|flip| *flip > 0.0));
    }
}
