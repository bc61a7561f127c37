//! Is MSAA as good as SSAA where nothing but geometry has edges?
//!
//! The scene without its textures, against a reference of its own. Pixels are compared where
//! that picture has edges; `accumulate 4` has four samples per pixel as both have, in a pattern like that
//! of MSAA, while SSAA's four lie on a grid.

use std::time::Duration;

use cullet::{Antialias, Frame, Prepared, Renderer, Settings};

use super::super::doubt::Error;
use super::super::expectations::AS_GOOD;
use super::super::findings::Verdict;
use super::super::metrics::{Metric, against, picture};
use super::super::reference::{Reference, Room};
use super::super::words::short;
use super::{Claim, Study, Subject};
use crate::exit::Failure;

/// One scene.
pub fn study(subject: &Subject<'_>) -> Result<Study, Failure> {
    let mut scene = subject.prepared.scene().clone();
    scene.materials.iter_mut().for_each(|material| material.base_color_texture = None);
    let prepared = Prepared::new(scene)?;
    let settings = subject.settings;
    // As few samples as a reference may have: enough to tell tenths, and their halves say so.
    let room = Room { time: Duration::ZERO, rays: 0 };
    let reference =
        Reference::find(&prepared, subject.view, &settings, &settings, room, &mut |_| ())?;
    let of = |antialias, accumulate| Settings { antialias, accumulate, ..settings };
    let ways = [
        ("none", of(Antialias::None, 1)),
        ("msaa4", of(Antialias::Msaa4, 1)),
        ("ssaa4", of(Antialias::Ssaa4, 1)),
        ("accumulate 4", of(Antialias::None, 4)),
    ];
    let (mut renderer, mut frame) = (Renderer::default(), Frame::default());
    let mut errors = Vec::new();
    for (name, way) in &ways {
        let settings = Settings { threads: 0, ..*way };
        renderer.render(&prepared, subject.view, &settings, &mut frame);
        let drawn = picture(&frame).map_err(Failure::input)?;
        let error = |truth| against(truth, &drawn, Metric::EdgeRmse).map_err(Failure::input);
        let [even, odd] = &reference.halves;
        errors.push((*name, Error::new(error(&reference.picture)?, [error(even)?, error(odd)?])));
    }
    let [_, multi, grid, _] = &errors[..] else { unreachable!("four ways") };
    let outcome = multi.1.below(&grid.1, AS_GOOD);
    let figures: Vec<String> =
        errors.iter().map(|(name, error)| format!("{name} {}", short(error.whole()))).collect();
    Ok(Study {
        name: "edges",
        scene: Some(subject.scene.into()),
        about: "root mean square error along the edges of the scene without its textures",
        columns: vec!["error".into()],
        lines: errors.iter().map(|(name, error)| ((*name).into(), vec![error.whole()])).collect(),
        claims: vec![Claim {
            text: "On edges of geometry alone, MSAA is as good as SSAA of as many samples to within a tenth",
            verdict: Verdict { scene: subject.scene.into(), outcome, figures: figures.join(", ") },
        }],
    })
}

#[cfg(test)]
mod tests {
    use super::super::super::doubt::Outcome;
    use super::super::tests::of_scene;
    use super::*;

    #[test]
    fn more_samples_are_truer_on_edges() {
        let study = of_scene("box-grid:3", study);
        let errors: Vec<f64> = study.lines.iter().map(|(_, numbers)| numbers[0]).collect();
        let [none, multi, grid, _] = errors[..] else { panic!("four ways") };
        assert!(multi < none && grid < none, "{errors:?}");
        assert_ne!(study.claims[0].verdict.outcome, Outcome::Refuted, "{errors:?}");
    }
}
