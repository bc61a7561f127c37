//! Wavefront OBJ with its MTL libraries: from bytes to a [`Scene`].
//!
//! ```text
//! clean -> tobj -> polygon -> scene
//!           mtl -> pictures --^
//! ```
//!
//! Every group (`o` or `g`) is a node, and its faces of one material are one object,
//! `group/material`. Faces without normals are shaded flat; smoothing groups have no
//! effect. Texture coordinates change from v up to v down. Vertex colours are taken as
//! sRGB, as the exporters that write them do, and become linear.

mod clean;
mod mtl;
mod notes;
mod pictures;
mod polygon;

use std::collections::BTreeMap;
use std::path::Path;

use glam::{DAffine3, Vec2, Vec3, Vec4};

use self::notes::Notes;
use self::pictures::Pictures;
use crate::files::Root;
use crate::tasks::Run;
use crate::{LoadError, LoadOptions, Material, Mesh, Node, Object, Scene};

/// Loads an OBJ file and what it names, all below its folder.
///
/// Damaged faces are left out, missing materials and images are replaced, both with a
/// warning; other statements that cannot be read are errors with their line. A file
/// without faces is an empty scene with a warning.
pub(crate) fn load(path: &Path, options: &LoadOptions, run: Run<'_>) -> Result<Scene, LoadError> {
    let files = Root::beside(path, options);
    let bytes = files.read_scene(path)?;
    let shown = path.display().to_string();
    let stem = path.file_stem().map_or("unnamed".into(), |stem| stem.to_string_lossy());
    let mut notes = Notes::default();

    let cleaned = clean::clean(&bytes, &stem, &mut notes).map_err(|problem| {
        let place =
            if problem.line == 0 { String::new() } else { format!("line {}", problem.line) };
        LoadError::invalid(&shown, place, problem.text, "export the model again")
    })?;
    let library = mtl::read_libraries(&cleaned.libraries, &files, &mut notes)?;
    let mut pictures = Pictures::new(&files, options);
    let mut materials = vec![Material { double_sided: true, ..Material::default() }];
    for name in &cleaned.materials {
        materials.push(mtl::material(name, &library, &mut pictures, &mut notes)?);
    }

    let (images, textures) = pictures.decode(run, &mut notes);

    let models = read_models(&cleaned).map_err(|error| {
        LoadError::invalid(&shown, "", error.to_string(), "export the model again")
    })?;
    let mut parts = Parts::new(options, &shown);
    for model in models {
        parts.add(model)?;
    }
    let mut scene = parts.into_scene(&materials);
    if scene.objects.is_empty() {
        notes.warn_each("holds no geometry that can be drawn".into());
    }
    (scene.warnings, scene.left_out) = notes.finish(&shown);
    scene.name = shown;
    scene.materials = materials;
    scene.images = images;
    scene.textures = textures;
    Ok(scene)
}

/// One model per stretch of faces. Material ids count [`clean::Cleaned::materials`].
fn read_models(cleaned: &clean::Cleaned) -> Result<Vec<tobj::Model>, tobj::LoadError> {
    // `tobj` only needs to know the names, and knows them from a library in front.
    let text = format!("mtllib all\n{}", cleaned.text);
    let names = || {
        let name = |name: &String| tobj::Material { name: name.clone(), ..Default::default() };
        let ids = cleaned.materials.iter().cloned().zip(0..).collect();
        Ok((cleaned.materials.iter().map(name).collect(), ids))
    };
    let options = tobj::LoadOptions { single_index: true, ..Default::default() };
    tobj::load_obj_buf(&mut text.as_bytes(), &options, |_| names()).map(|(models, _)| models)
}

/// What makes faces part of the same mesh: group, material, and which attributes they have.
type Key = (String, usize, [bool; 2]);

/// The meshes as they grow.
struct Parts<'a> {
    options: &'a LoadOptions,
    shown: &'a str,
    n_triangles: u64,
    idx_of_key: BTreeMap<Key, usize>,
    meshes: Vec<(Key, Mesh)>,
}

impl<'a> Parts<'a> {
    fn new(options: &'a LoadOptions, shown: &'a str) -> Parts<'a> {
        let (idx_of_key, meshes) = (BTreeMap::new(), Vec::new());
        Parts { options, shown, n_triangles: 0, idx_of_key, meshes }
    }

    fn add(&mut self, model: tobj::Model) -> Result<(), LoadError> {
        let tobj::Model { mesh: source, name } = model;
        if source.indices.is_empty() {
            return Ok(());
        }
        let attributes = [!source.normals.is_empty(), !source.texcoords.is_empty()];
        let key = (name, source.material_id.map_or(0, |id| id + 1), attributes);
        let idx = *self.idx_of_key.entry(key.clone()).or_insert(self.meshes.len());
        if idx == self.meshes.len() {
            self.meshes.push((key, Mesh::default()));
        }
        let mesh = &mut self.meshes[idx].1;
        let n_before = mesh.triangles.len();
        append(mesh, &source);
        self.n_triangles += (mesh.triangles.len() - n_before) as u64;
        self.limit(
            "the number of triangles",
            self.n_triangles,
            self.options.max_triangles,
            "--max-triangles",
        )?;
        let n_nodes = 2 * self.meshes.len() as u64; // an object and at most one node each
        self.limit("the number of nodes", n_nodes, self.options.max_nodes as u64, "--max-nodes")
    }

    fn limit(&self, what: &str, n: u64, limit: u64, option: &'static str) -> Result<(), LoadError> {
        if n <= limit {
            return Ok(());
        }
        Err(LoadError::Limit { path: self.shown.into(), what: what.into(), limit, option })
    }

    /// A node per group in order of first appearance, and an object per mesh.
    fn into_scene(self, materials: &[Material]) -> Scene {
        let mut scene = Scene::default();
        let mut node_of_group = BTreeMap::new();
        for ((group, material, _), mesh) in self.meshes {
            let node = *node_of_group.entry(group.clone()).or_insert(scene.nodes.len());
            if node == scene.nodes.len() {
                let world_from_node = DAffine3::IDENTITY;
                scene.nodes.push(Node { name: group.clone(), parent: None, world_from_node });
            }
            let name = match material {
                0 => group,
                _ => format!("{group}/{}", materials[material].name),
            };
            let (mesh_idx, world_from_model) = (scene.meshes.len(), DAffine3::IDENTITY);
            scene.meshes.push(Mesh { name: name.clone(), ..mesh });
            scene.objects.push(Object { name, node, mesh: mesh_idx, material, world_from_model });
        }
        scene.objects.sort_by_key(|object| object.node);
        scene
    }
}

/// Adds vertices and triangulated faces of a `tobj` mesh to `mesh`, which has the same
/// attributes or is empty.
fn append(mesh: &mut Mesh, source: &tobj::Mesh) {
    let first = mesh.positions.len() as u32;
    let positions: Vec<Vec3> = vec3s(&source.positions).collect();
    if !source.normals.is_empty() {
        mesh.normals.get_or_insert_default().extend(vec3s(&source.normals));
    }
    if !source.texcoords.is_empty() {
        let v_down = source.texcoords.chunks_exact(2).map(|uv| Vec2::new(uv[0], 1.0 - uv[1]));
        mesh.uvs[0].get_or_insert_default().extend(v_down);
    }
    if !source.vertex_color.is_empty() {
        let colors = vec3s(&source.vertex_color).map(linear_from_srgb);
        mesh.colors.get_or_insert_default().extend(colors);
    }
    let triangles = vec![3; source.indices.len() / 3];
    let arities = if source.face_arities.is_empty() { &triangles } else { &source.face_arities };
    let mut rest = &source.indices[..];
    let mut corners = Vec::new();
    for arity in arities {
        let (face, behind) = rest.split_at((*arity as usize).min(rest.len()));
        rest = behind;
        corners.clear();
        corners.extend(face.iter().map(|i| positions[*i as usize]));
        polygon::triangulate(&corners, |triangle| {
            mesh.triangles.push(triangle.map(|corner| first + face[corner]));
        });
    }
    mesh.positions.extend(positions);
}

fn vec3s(flat: &[f32]) -> impl Iterator<Item = Vec3> {
    flat.chunks_exact(3).map(Vec3::from_slice)
}

/// Source: IEC 61966-2-1, 1999. Values outside 0..1 are clamped.
fn linear_from_srgb(color: Vec3) -> Vec4 {
    let linear = |encoded: f32| {
        let encoded = f64::from(encoded).clamp(0.0, 1.0);
        let linear = if encoded <= 0.04045 {
            encoded / 12.92
        } else {
            libm::pow((encoded + 0.055) / 1.055, 2.4)
        };
        linear as f32
    };
    Vec4::new(linear(color.x), linear(color.y), linear(color.z), 1.0)
}

#[cfg(test)]
mod tests;
