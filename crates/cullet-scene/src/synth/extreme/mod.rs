//! Scenes at the ends of the ranges: bad numbers, huge and tiny ones, odd lenses and nodes.
//!
//! Each comes with an ordinary twin, which shows about as much, in about as many pixels, by
//! ordinary numbers; what an extreme costs is measured against its twin. What each must look
//! like is in `docs/extremes.md`.

mod geometry;
mod space;
mod surface;

use super::SynthError;
use super::build::{Builder, looking};
use crate::{Lens, Material, Scene};

/// One extreme: its name, what it shows, and its builder, which is told whether the ordinary
/// twin is wanted.
type Extreme = (&'static str, &'static str, fn(ordinary: bool) -> Scene);

const EXTREMES: [Extreme; 16] = [
    (
        "not-a-number",
        "a sphere of which every 40th vertex is NaN or infinite",
        geometry::not_a_number,
    ),
    ("through-the-eye", "a tunnel of strips that begin behind the eye", geometry::through_the_eye),
    ("ground", "one triangle 1e9 wide, all corners outside a far plane at 100", geometry::ground),
    ("no-area", "needles, and red triangles with one corner twice", geometry::no_area),
    ("huge", "triangles with corners at 1e9 and at 3e38", geometry::huge),
    ("ties", "squares in one plane: the first in the scene is seen", geometry::ties),
    ("narrow", "a field of view of 0.001 degrees", space::narrow),
    ("wide", "a field of view of 179.99 degrees", space::wide),
    ("far", "spheres at 1e-3 to 1e30, near 1e-6, no far plane", space::far),
    ("depth", "pairs of planes 3e-7 of their distance apart, up to 1e11", space::depth),
    ("offset", "boxes and camera moved by (2^27, 0, -2^27)", space::offset),
    (
        "nested-scales",
        "boxes in a node scaled by 2^20 in one scaled by 2^-20",
        space::nested_scales,
    ),
    ("flattened", "balls flattened along x, y and z, and one without extent", surface::flattened),
    (
        "mirrored",
        "mirrored nodes above, the same mirrored in their meshes below",
        surface::mirrored,
    ),
    ("textures", "images of 1x1 to 16384x1, coordinates up to 1e30", surface::textures),
    ("denormals", "a sphere with coordinates below 2^-140, scaled up", surface::denormals),
];

/// Every name that stands behind `extreme:`, with what it shows.
pub const NAMES: [(&str, &str); EXTREMES.len()] = {
    let mut names = [("", ""); EXTREMES.len()];
    let mut i = 0;
    while i < names.len() {
        names[i] = (EXTREMES[i].0, EXTREMES[i].1);
        i += 1;
    }
    names
};

/// The scene `NAME` or its twin `NAME:ordinary`.
pub(super) fn build(parameter: &str) -> Result<Scene, SynthError> {
    let (name, ordinary) = match parameter.strip_suffix(":ordinary") {
        Some(name) => (name, true),
        None => (parameter, false),
    };
    let found = EXTREMES.iter().find(|(known, ..)| *known == name);
    let (_, _, build) = found.ok_or_else(|| SynthError::Parameter {
        name: "extreme".into(),
        parameter: parameter.into(),
        expected: NAMES.map(|(name, _)| name).join(", "),
    })?;
    Ok(build(ordinary))
}

/// A perspective lens; `yfov` in degrees.
fn lens(yfov: f64, near: f64, far: f64) -> Lens {
    Lens::Perspective { yfov: yfov.to_radians(), aspect: None, near, far }
}

/// A camera at `eye` that looks at `target` through any lens.
fn look(builder: &mut Builder, eye: [f64; 3], target: [f64; 3], lens: Lens) {
    builder.camera(None, looking(eye.into(), target.into()), lens);
}

/// A material of one colour that is seen from both sides.
fn double_sided(builder: &mut Builder, name: &str, [r, g, b]: [f32; 3]) -> usize {
    let base_color = glam::Vec4::new(r, g, b, 1.0);
    let name = name.into();
    builder.material(Material { name, base_color, double_sided: true, ..Material::default() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{synth::synth, write_glb};

    #[test]
    fn every_extreme_and_its_twin_is_made_with_a_camera() {
        for (name, _) in NAMES {
            for spec in [format!("extreme:{name}"), format!("extreme:{name}:ordinary")] {
                let scene = synth(&spec).unwrap();
                assert_eq!(scene.name, format!("synth:{spec}"));
                assert_eq!(scene.cameras.len(), 1, "{spec}");
                assert!(!scene.objects.is_empty(), "{spec}");
                assert!(scene.objects.iter().all(|o| o.world_from_model.is_finite()), "{spec}");
                // A file cannot hold NaN; everything else can be handed on.
                assert_eq!(write_glb(&scene).is_ok(), spec != "extreme:not-a-number", "{spec}");
            }
        }
    }

    #[test]
    fn other_names_are_refused_with_the_list() {
        for spec in ["extreme", "extreme:", "extreme:nothing", "extreme:huge:"] {
            let message = synth(spec).unwrap_err().to_string();
            assert!(message.contains("not-a-number, through-the-eye"), "{message}");
        }
    }
}
