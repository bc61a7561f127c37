//! Which mesh is drawn where?

use super::nodes::{self, Visit};
use super::{Input, Output, instances, materials, name_or, pose, primitive};
use crate::{LoadError, Mesh, Object};
use glam::DAffine3;

/// Makes an object of every primitive of every visible node, once per instance. Meshes are
/// shared, except those that are posed for their node.
pub(super) fn load(
    input: &Input<'_>,
    visits: &[Visit],
    output: &mut Output,
) -> Result<(), LoadError> {
    let root = &input.document.root;
    let joints = pose::Joints::new(input, visits, output);
    // For each mesh of the file: for each primitive, its index in the scene.
    let mut loaded: Vec<Option<Vec<Option<usize>>>> = vec![None; root.meshes.len()];
    for (node, visit) in visits.iter().enumerate().filter(|(_, visit)| visit.visible) {
        let json = &root.nodes[visit.file_index];
        let Some(mesh) = json.mesh.map(|mesh| mesh.value()) else { continue };
        let world_from_instances = instances::of(input, output, node, json)?;
        let pose = pose::Pose::of(input, output, &joints, node, json)?;
        let indices = match &pose {
            Some(pose) => load_mesh(input, output, mesh, Some(pose))?,
            None => match &loaded[mesh] {
                Some(indices) => indices.clone(),
                None => {
                    let indices = load_mesh(input, output, mesh, None)?;
                    loaded[mesh].insert(indices).clone()
                }
            },
        };
        let skinned = pose.is_some_and(|pose| pose.is_in_world_space());
        for (i, world_from_model) in world_from_instances.iter().enumerate() {
            for (j, mesh_index) in indices.iter().enumerate() {
                let Some(mesh_index) = *mesh_index else { continue };
                nodes::check_limit(input, output)?;
                let mut name = output.scene.nodes[node].name.clone();
                if world_from_instances.len() > 1 {
                    name += &format!("/instance {i}");
                }
                if indices.len() > 1 {
                    name += &format!("/primitive {j}");
                }
                output.scene.objects.push(Object {
                    name,
                    node,
                    mesh: mesh_index,
                    material: materials::index(&root.meshes[mesh].primitives[j]),
                    world_from_model: if skinned { DAffine3::IDENTITY } else { *world_from_model },
                });
            }
        }
    }
    Ok(())
}

/// Adds the primitives of a mesh to the scene; `None` for those that are left out.
fn load_mesh(
    input: &Input<'_>,
    output: &mut Output,
    mesh: usize,
    pose: Option<&pose::Pose<'_>>,
) -> Result<Vec<Option<usize>>, LoadError> {
    let json = &input.document.root.meshes[mesh];
    let mesh_name = name_or(&json.name, "mesh", mesh);
    let mut indices = Vec::with_capacity(json.primitives.len());
    for (i, primitive_json) in json.primitives.iter().enumerate() {
        let mut name = mesh_name.clone();
        if json.primitives.len() > 1 {
            name += &format!("/primitive {i}");
        }
        let place = format!("mesh `{mesh_name}`, primitive {i}");
        // Any number of nodes may pose one mesh, so even what is left out counts.
        output.count_decoded::<Mesh>(input, 1)?;
        let loaded = primitive::load(input, output, &place, primitive_json, pose.is_some())?;
        let Some((mut mesh, rows)) = loaded else {
            indices.push(None);
            continue;
        };
        mesh.name = name;
        if let Some(pose) = pose {
            pose.apply(input, output, &place, primitive_json, &rows, &mut mesh)?;
        }
        indices.push(Some(output.scene.meshes.len()));
        output.scene.meshes.push(mesh);
    }
    Ok(indices)
}
