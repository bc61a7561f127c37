//! When do vertices need f64? A smooth sphere, its model coordinates ever farther from their origin, or
//! its lens ever longer, drawn with f32 and with f64 transforms.
//!
//! Counted are *hard* differences: pixels with another triangle than the truth has in their
//! centre and 1/8 px from it on all four sides, so that no snap to 1/256 px explains them. The truth is
//! drawn with f64 transforms on a grid of 2^-16 px, by the plain code.

use cullet::scene::synth::synth;
use cullet::{
    Camera, Frame, Pass, Passes, Prepared, Projection, Renderer, Settings, SubpixelBits,
    Transforms, View, Viewport,
};
use glam::{DVec3, Vec3};

use super::super::doubt::Outcome;
use super::super::findings::Verdict;
use super::super::words::short;
use super::{Claim, Study};
use crate::exit::Failure;

/// A way to look at the sphere.
struct Case {
    name: &'static str,
    /// Of model coordinates; the node takes it back.
    offset: f32,
    /// Of the node and the eye, in the world.
    world: f64,
    /// Degrees.
    yfov: f64,
    /// Whether f64 may pay here, by what one expects.
    may_pay: bool,
}

const CASES: [Case; 9] = {
    const fn case(name: &'static str, offset: f32, world: f64, yfov: f64, may_pay: bool) -> Case {
        Case { name, offset, world, yfov, may_pay }
    }
    [
        case("no offset, 45 degrees", 0.0, 0.0, 45.0, false),
        case("model offset 1e3", 1e3, 0.0, 45.0, false),
        case("model offset 1e4", 1e4, 0.0, 45.0, false),
        case("model offset 1e5", 1e5, 0.0, 45.0, true),
        case("model offset 1e6", 1e6, 0.0, 45.0, true),
        case("world offset 1e7", 0.0, 1e7, 45.0, true),
        case("1 degree", 0.0, 0.0, 1.0, false),
        case("0.1 degrees", 0.0, 0.0, 0.1, false),
        case("0.01 degrees", 0.0, 0.0, 0.01, true),
    ]
};

const SIZE: [u32; 2] = [320, 240];

/// Every case.
pub fn study() -> Result<Study, Failure> {
    let mut lines = Vec::new();
    let mut outcome = Outcome::Confirmed;
    let (mut pays, mut does_not) = (Vec::new(), Vec::new());
    for case in &CASES {
        let (prepared, view) = look(case)?;
        let [single, double] = [Transforms::F32, Transforms::F64]
            .map(|transforms| hard_ppm(&prepared, &view, transforms));
        if single > double {
            outcome = outcome.and(Outcome::exactly(case.may_pay));
            pays.push(format!("{} ({} against {} ppm)", case.name, short(single), short(double)));
        } else {
            does_not.push(case.name);
        }
        lines.push((case.name.to_owned(), vec![single, double]));
    }
    let list = |names: &[String]| if names.is_empty() { "none".into() } else { names.join(", ") };
    let does_not: Vec<String> = does_not.into_iter().map(String::from).collect();
    let figures = format!("pays at {}; not at {}", list(&pays), list(&does_not));
    Ok(Study {
        name: "transforms",
        scene: None,
        about: "pixels of a million with another triangle than the truth has there and 1/8 px around: a \
                sphere, its model coordinates moved away from their origin, its node and the eye moved \
                through the world, or seen through a longer lens",
        columns: vec!["f32 ppm".into(), "f64 ppm".into()],
        lines,
        claims: vec![Claim {
            text: "f64 transforms pay only at offsets of 1e5 or more, or below .1 degrees of field of view",
            verdict: Verdict { scene: "sphere".into(), outcome, figures },
        }],
    })
}

fn look(case: &Case) -> Result<(Prepared, View), Failure> {
    let mut scene = synth("sphere:48").map_err(Failure::usage)?;
    // Oblique, so that no coordinate stays small.
    let (way, world) = (DVec3::new(0.6, 0.5, 0.8), DVec3::new(1.0, 0.0, -1.0) * case.world);
    for mesh in &mut scene.meshes {
        mesh.positions.iter_mut().for_each(|p| *p += Vec3::splat(case.offset));
    }
    let back = DVec3::splat(f64::from(case.offset));
    for object in &mut scene.objects {
        let local = object.world_from_model.matrix3;
        object.world_from_model.translation += world - local * back;
    }
    let yfov = case.yfov.to_radians();
    let distance = 1.2 / libm::sin(0.5 * yfov);
    let lens = Projection::Perspective { yfov, near: 0.1 * distance, far: f64::INFINITY };
    let eye = world + way.normalize() * distance;
    let camera = Camera::look_at(eye, world, DVec3::Y, lens).map_err(Failure::usage)?;
    let viewport = Viewport::new(SIZE[0], SIZE[1])?;
    Ok((Prepared::new(scene)?, View::new(&camera, viewport)))
}

fn hard_ppm(prepared: &Prepared, view: &View, transforms: Transforms) -> f64 {
    let mut renderer = Renderer::default();
    let mut triangles = |view: &View, settings: &Settings| {
        let mut frame = Frame::default();
        let passes = Passes::NONE.with(Pass::Triangle);
        renderer.render(prepared, view, &Settings { passes, ..*settings }, &mut frame);
        frame.triangle
    };
    let truth = Settings { subpixel_bits: SubpixelBits::Sixteen, ..Settings::default() };
    let centre = triangles(view, &truth);
    let around = [(0.125, 0.0), (-0.125, 0.0), (0.0, 0.125), (0.0, -0.125)]
        .map(|(right, down)| triangles(&view.shifted(right, down), &truth));
    let drawn = triangles(view, &Settings { transforms, ..Settings::default() });
    let is_hard =
        |i: &usize| around.iter().all(|frame| frame[*i] == centre[*i]) && drawn[*i] != centre[*i];
    (0..centre.len()).filter(is_hard).count() as f64 / centre.len() as f64 * 1e6
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn double_precision_has_no_hard_differences_and_single_has_them_far_out() {
        let study = study().unwrap_or_else(|failure| panic!("{failure:?}"));
        assert_eq!(study.lines.len(), CASES.len());
        for (name, values) in &study.lines {
            assert_eq!(values[1], 0.0, "{name}");
        }
        let single = |name| study.lines.iter().find(|(known, _)| known == name).unwrap().1[0];
        assert_eq!(single("no offset, 45 degrees"), 0.0);
        assert!(single("model offset 1e6") > 1e4);
    }
}
