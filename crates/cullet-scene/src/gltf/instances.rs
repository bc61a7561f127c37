//! Where does a node put its mesh? EXT_mesh_gpu_instancing may say: in many places.

use ::gltf::json::accessor::Accessor as AccessorJson;
use ::gltf::json::{Index, Node};
use glam::{DAffine3, DVec3};
use serde_json::Value;

use super::accessor::Accessor;
use super::{Input, Output, document, nodes};
use crate::LoadError;

/// World from model for every instance of node `node` of the scene, which is `json` in the
/// file: one, unless the extension says otherwise.
pub(super) fn of(
    input: &Input<'_>,
    output: &mut Output,
    node: usize,
    json: &Node,
) -> Result<Vec<DAffine3>, LoadError> {
    let world_from_node = output.scene.nodes[node].world_from_node;
    let extension =
        json.extensions.as_ref().and_then(|all| all.others.get("EXT_mesh_gpu_instancing"));
    let Some(attributes) = extension.and_then(|extension| extension.get("attributes")) else {
        return Ok(vec![world_from_node]);
    };
    let place = format!("node `{}`", output.scene.nodes[node].name);
    let [translations, rotations, scales] = match open(input, attributes) {
        Ok(accessors) => accessors,
        Err(problem) => {
            output.lose(&place, &format!("instances cannot be read: {problem}"));
            return Ok(Vec::new());
        }
    };
    let counts = [&translations, &rotations, &scales].map(|list| list.as_ref().map(|a| a.count));
    let count = counts.into_iter().flatten().min().unwrap_or(1);
    if count > input.options.max_nodes as u64 {
        return Err(nodes::too_many(input));
    }
    output.count_decoded::<DAffine3>(input, count)?;
    let vector = |list: &Option<Accessor<'_>>, i: u64, default: DVec3| {
        list.as_ref().map_or(default, |list| DVec3::from_array(list.row::<3>(i).map(f64::from)))
    };
    let mut instances = Vec::with_capacity(count as usize);
    for i in 0..count {
        let rotation = rotations.as_ref().map_or([0.0, 0.0, 0.0, 1.0], |list| list.row::<4>(i));
        let node_from_instance = DAffine3::from_scale_rotation_translation(
            vector(&scales, i, DVec3::ONE),
            document::rotation(rotation.map(f64::from)),
            vector(&translations, i, DVec3::ZERO),
        );
        let world_from_instance = world_from_node * node_from_instance;
        if world_from_instance.is_finite() {
            instances.push(world_from_instance);
        }
    }
    let n_bad = count - instances.len() as u64;
    if n_bad > 0 {
        output.warn(&place, format_args!("{n_bad} instances have no finite transform; left out"));
    }
    Ok(instances)
}

fn open<'a>(input: &Input<'a>, attributes: &Value) -> Result<[Option<Accessor<'a>>; 3], String> {
    let one = |name: &str| -> Result<Option<Accessor<'a>>, String> {
        let Some(index) = attributes.get(name) else { return Ok(None) };
        let index = document::whole_number(index).and_then(|index| u32::try_from(index).ok());
        let index: Index<AccessorJson> = Index::new(index.ok_or("a bad accessor index")?);
        Accessor::open(&input.document.root, input.buffers, index).map(Some)
    };
    Ok([one("TRANSLATION")?, one("ROTATION")?, one("SCALE")?])
}
