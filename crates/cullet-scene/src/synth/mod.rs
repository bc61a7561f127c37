//! Scenes without files: computed from a name and a number, the same bits everywhere.
//!
//! Two kinds: measuring scenes, whose contents can be told from their parameters, and
//! showpieces, which are made to be looked at. Each brings a camera.

mod build;
mod city;
mod extreme;
mod interior;
mod knots;
mod masks;
mod measure;
mod shapes;
mod showpiece;
mod spheres;
mod textures;

use crate::Scene;

pub use extreme::NAMES as EXTREMES;

/// Every name that [`synth`] knows, with its parameter and what it shows; and `extreme:` with one
/// of [`EXTREMES`].
pub const NAMES: &[(&str, &str)] = &[
    ("box-grid", "box-grid:N: N * N * N boxes that share one mesh (1 to 64, default 20)"),
    ("sphere", "sphere:N: one smooth sphere of N segments around (3 to 2048, default 64)"),
    (
        "slivers",
        "slivers:N: a fan of N needles and strips down to 1/512 px (1 to 65536, default 720)",
    ),
    ("far-away", "far-away:D: boxes and their camera moved by (D, 0, -D) (default 134217728)"),
    (
        "tiles",
        "tiles:N: N * N quads that cover (i+1)(j+1)/(N*N) of their cells (1 to 256, default 8)",
    ),
    ("city", "city:N: N * N blocks of towers that share a dozen meshes (1 to 64, default 12)"),
    ("showpiece", "a still life on a terrace: every material, 30 thousand triangles"),
    ("knots", "smooth torus knots: vertex colours, mirrored and unevenly scaled nodes"),
    ("masks", "leaves and fences cut out by alpha; wrap modes and texture transforms"),
    ("interior", "a room with columns, seen from inside"),
    ("spheres", "spheres from 8 to 64 segments, flat above and smooth below"),
];

/// Why a scene cannot be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SynthError {
    /// There is no scene of that name.
    #[error("there is no synthetic scene `{name}`; choose one of {}", known())]
    Unknown {
        /// The name asked for.
        name: String,
    },
    /// The scene takes no parameter, or not this one.
    #[error("`{parameter}` is no parameter for `{name}`; give {expected}")]
    Parameter {
        /// The name asked for.
        name: String,
        /// What stands after the colon.
        parameter: String,
        /// What may stand there.
        expected: String,
    },
}

/// Makes the scene that `spec` asks for: a name of [`NAMES`], or `name:parameter`.
///
/// The result depends on nothing but `spec`.
pub fn synth(spec: &str) -> Result<Scene, SynthError> {
    let spec = Spec::new(spec);
    let mut scene = match spec.name {
        "extreme" => extreme::build(spec.parameter.unwrap_or_default())?,
        "box-grid" => measure::box_grid(spec.count(20, 64)?),
        "sphere" => measure::sphere(spec.count_from(3, 64, 2048)?),
        "slivers" => measure::slivers(spec.count(720, 65536)?),
        "far-away" => measure::far_away(spec.distance(134_217_728.0)?),
        "tiles" => measure::tiles(spec.count(8, 256)?),
        "city" => city::build(spec.count(12, 64)?),
        "showpiece" => spec.only(showpiece::build)?,
        "knots" => spec.only(knots::build)?,
        "masks" => spec.only(masks::build)?,
        "interior" => spec.only(interior::build)?,
        "spheres" => spec.only(spheres::build)?,
        name => return Err(SynthError::Unknown { name: name.into() }),
    };
    scene.name = format!("synth:{}", spec.whole);
    Ok(scene)
}

/// A request, split at its first colon.
struct Spec<'a> {
    whole: &'a str,
    name: &'a str,
    parameter: Option<&'a str>,
}

impl<'a> Spec<'a> {
    fn new(whole: &'a str) -> Spec<'a> {
        match whole.split_once(':') {
            Some((name, parameter)) => Spec { whole, name, parameter: Some(parameter) },
            None => Spec { whole, name: whole, parameter: None },
        }
    }

    fn count(&self, default: u32, max: u32) -> Result<u32, SynthError> {
        self.count_from(1, default, max)
    }

    fn count_from(&self, min: u32, default: u32, max: u32) -> Result<u32, SynthError> {
        let Some(text) = self.parameter else { return Ok(default) };
        let count = text.parse().ok().filter(|count| (min..=max).contains(count));
        count.ok_or_else(|| self.refuse(format!("a whole number from {min} to {max}")))
    }

    fn distance(&self, default: f64) -> Result<f64, SynthError> {
        let Some(text) = self.parameter else { return Ok(default) };
        let distance = text.parse().ok().filter(|distance: &f64| distance.abs() <= 1e15);
        distance.ok_or_else(|| self.refuse("a number from -1e15 to 1e15".into()))
    }

    fn only(&self, build: fn() -> Scene) -> Result<Scene, SynthError> {
        match self.parameter {
            None => Ok(build()),
            Some(_) => Err(self.refuse("the name alone".into())),
        }
    }

    fn refuse(&self, expected: String) -> SynthError {
        let parameter = self.parameter.unwrap_or_default().to_owned();
        SynthError::Parameter { name: self.name.to_owned(), parameter, expected }
    }
}

fn known() -> String {
    let names: Vec<_> = NAMES.iter().map(|(name, _)| *name).collect();
    format!("{}, extreme:NAME", names.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_makes_a_sound_scene_with_a_camera() {
        for (name, _) in NAMES {
            let scene = synth(name).unwrap();
            assert_eq!(scene.name, format!("synth:{name}"));
            assert_eq!(scene.cameras.len(), 1, "{name}");
            assert!(!scene.objects.is_empty() && scene.warnings.is_empty(), "{name}");
            check_indices(&scene);
        }
    }

    #[track_caller]
    fn check_indices(scene: &Scene) {
        let name = &scene.name;
        for object in &scene.objects {
            assert!(!object.name.is_empty(), "{name}");
            assert!(object.mesh < scene.meshes.len(), "{name}");
            assert!(object.material < scene.materials.len(), "{name}");
            assert_eq!(object.world_from_model, scene.nodes[object.node].world_from_node);
            assert!(object.world_from_model.is_finite(), "{name}");
        }
        for (idx, node) in scene.nodes.iter().enumerate() {
            assert!(node.parent.is_none_or(|parent| parent < idx), "{name}");
        }
        for mesh in &scene.meshes {
            let n = mesh.positions.len();
            assert!(mesh.normals.as_ref().is_none_or(|list| list.len() == n), "{name}");
            assert!(mesh.uvs.iter().flatten().all(|list| list.len() == n), "{name}");
            assert!(mesh.colors.as_ref().is_none_or(|list| list.len() == n), "{name}");
            assert!(mesh.triangles.iter().flatten().all(|i| (*i as usize) < n), "{name}");
            assert!(mesh.positions.iter().all(|position| position.is_finite()), "{name}");
        }
        for texture in &scene.textures {
            assert!(texture.image < scene.images.len(), "{name}");
        }
        let textures =
            scene.materials.iter().filter_map(|material| material.base_color_texture.as_ref());
        assert!(textures.into_iter().all(|used| used.texture < scene.textures.len()), "{name}");
    }

    #[test]
    fn parameters_are_checked() {
        assert!(matches!(synth("teapot"), Err(SynthError::Unknown { .. })));
        for spec in ["box-grid:0", "box-grid:x", "sphere:2", "far-away:nan", "knots:3", "tiles:"] {
            assert!(matches!(synth(spec), Err(SynthError::Parameter { .. })), "{spec}");
        }
        let message = synth("sphere:2").unwrap_err().to_string();
        assert_eq!(message, "`2` is no parameter for `sphere`; give a whole number from 3 to 2048");
    }

    #[test]
    fn the_showpiece_is_rich_but_small() {
        let scene = synth("showpiece").unwrap();
        let n_triangles: usize =
            scene.objects.iter().map(|object| scene.meshes[object.mesh].triangles.len()).sum();
        assert!((20_000..60_000).contains(&n_triangles), "{n_triangles} triangles");
    }
}
