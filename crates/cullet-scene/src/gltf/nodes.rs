//! Which nodes does the scene have, and where are they?
//!
//! The walk keeps its own stack, so depth costs no call stack, and refuses a node that it
//! meets twice, so cycles and doubled children end at once.

use ::gltf::json::camera::Type as CameraType;
use ::gltf::json::validation::Checked;
use ::gltf::json::{Camera as CameraJson, Index};
use glam::DAffine3;

use super::{Input, Output, name_or};
use crate::{Lens, LoadError, Node, SceneCamera};

/// A node that was visited. The list of visits is parallel to [`crate::Scene::nodes`].
pub(super) struct Visit {
    /// Index in the file.
    pub file_index: usize,
    /// Neither it nor an ancestor is hidden.
    pub visible: bool,
}

/// Fills in the nodes and cameras of the scene: parents first, siblings in file order.
pub(super) fn walk(input: &Input<'_>, output: &mut Output) -> Result<Vec<Visit>, LoadError> {
    struct Pending {
        file_index: usize,
        parent: Option<usize>,
        visible: bool,
    }

    let root = &input.document.root;
    let mut met = vec![false; root.nodes.len()];
    let mut visits: Vec<Visit> = Vec::new();
    let top = |file_index| Pending { file_index, parent: None, visible: true };
    let mut stack: Vec<Pending> = roots(input, output).into_iter().rev().map(top).collect();
    while let Some(Pending { file_index, parent, visible }) = stack.pop() {
        let json = &root.nodes[file_index];
        let name = name_or(&json.name, "node", file_index);
        let place = || format!("node `{name}`");
        if std::mem::replace(&mut met[file_index], true) {
            let problem = "is reached twice, but nodes must form trees";
            return Err(LoadError::invalid(input.name, place(), problem, "export the model again"));
        }
        check_limit(input, output)?;
        let world_from_parent =
            parent.map_or(DAffine3::IDENTITY, |parent| output.scene.nodes[parent].world_from_node);
        let world_from_node = world_from_parent * input.document.parent_from_node[file_index];
        if !world_from_node.is_finite() {
            output.warn(&place(), "has a transform that is not finite; left out with its children");
            continue;
        }
        let visible = visible && is_visible(json);
        if !visible && json.mesh.is_some() {
            output.leave_out("hidden nodes with a mesh");
        }
        let node = output.scene.nodes.len();
        if let Some(camera) = json.camera.and_then(|camera| root.get(camera)) {
            match lens(camera) {
                Some(lens) => output.scene.cameras.push(SceneCamera {
                    name: camera.name.clone().unwrap_or_else(|| name.clone()),
                    node,
                    world_from_camera: world_from_node,
                    lens,
                }),
                None => output.warn(&place(), "has a camera without a lens; left out"),
            }
        }
        output.scene.nodes.push(Node { name, parent, world_from_node });
        visits.push(Visit { file_index, visible });
        let children = json.children.iter().flatten().rev();
        stack.extend(children.map(|child| Pending {
            file_index: child.value(),
            parent: Some(node),
            visible,
        }));
    }
    Ok(visits)
}

/// Refuses one more node or object than [`crate::LoadOptions::max_nodes`].
pub(super) fn check_limit(input: &Input<'_>, output: &Output) -> Result<(), LoadError> {
    if output.scene.nodes.len() + output.scene.objects.len() < input.options.max_nodes {
        return Ok(());
    }
    Err(too_many(input))
}

/// The refusal of too many nodes or objects.
pub(super) fn too_many(input: &Input<'_>) -> LoadError {
    LoadError::Limit {
        path: input.name.to_string(),
        what: "the number of nodes and objects".into(),
        limit: input.options.max_nodes as u64,
        option: "--max-nodes",
    }
}

/// The roots of the default scene, else of the first scene, else of the file.
fn roots(input: &Input<'_>, output: &mut Output) -> Vec<usize> {
    let root = &input.document.root;
    let scene = root.scene.unwrap_or(Index::new(0));
    for _ in 1..root.scenes.len() {
        output.leave_out("scenes besides the one drawn");
    }
    if let Some(scene) = root.get(scene) {
        return scene.nodes.iter().map(Index::value).collect();
    }
    let mut is_child = vec![false; root.nodes.len()];
    for child in root.nodes.iter().flat_map(|node| node.children.iter().flatten()) {
        is_child[child.value()] = true;
    }
    if !root.nodes.is_empty() {
        output.warn("scenes", "there are none; all nodes without a parent are drawn");
    }
    if !is_child.contains(&false) {
        is_child.fill(false); // Everything is in a cycle, and the walk will say so.
    }
    (0..is_child.len()).filter(|&i| !is_child[i]).collect()
}

fn is_visible(json: &::gltf::json::Node) -> bool {
    let extension = json.extensions.as_ref().and_then(|all| all.others.get("KHR_node_visibility"));
    extension.and_then(|extension| extension.get("visible")?.as_bool()).unwrap_or(true)
}

fn lens(json: &CameraJson) -> Option<Lens> {
    match json.type_ {
        Checked::Valid(CameraType::Perspective) => {
            json.perspective.as_ref().map(|lens| Lens::Perspective {
                yfov: lens.yfov.into(),
                aspect: lens.aspect_ratio.map(f64::from),
                near: lens.znear.into(),
                far: lens.zfar.map_or(f64::INFINITY, f64::from),
            })
        }
        Checked::Valid(CameraType::Orthographic) => {
            json.orthographic.as_ref().map(|lens| Lens::Orthographic {
                xmag: lens.xmag.into(),
                ymag: lens.ymag.into(),
                near: lens.znear.into(),
                far: lens.zfar.into(),
            })
        }
        Checked::Invalid => None,
    }
}
