//! What shape does a mesh have at rest? Default morph weights, then the skin.
//!
//! A skinned vertex is the mean of where its joints would put it, weighted; the transform
//! of the node that carries the mesh does not count (glTF 2.0, section 3.7.3.3). Everything
//! is baked in f64: a posed mesh belongs to one node and a skinned one is in world space.

use ::gltf::json::accessor::{Accessor as AccessorJson, Type};
use ::gltf::json::mesh::{MorphTarget, Primitive, Semantic};
use ::gltf::json::{Index, Node};
use glam::{DAffine3, DMat3, DMat4, DVec3, Vec3};

use super::accessor::Accessor;
use super::nodes::Visit;
use super::primitive::{Rows, open_optional};
use super::{Input, Output};
use crate::{LoadError, Mesh};

/// World from node, for every node of the file that is in the scene.
pub(super) struct Joints(Vec<Option<DAffine3>>);

impl Joints {
    pub fn new(input: &Input<'_>, visits: &[Visit], output: &Output) -> Joints {
        let mut joints = vec![None; input.document.root.nodes.len()];
        for (visit, node) in visits.iter().zip(&output.scene.nodes) {
            joints[visit.file_index] = Some(node.world_from_node);
        }
        Joints(joints)
    }
}

/// How one node bends its mesh.
pub(super) struct Pose<'a> {
    weights: &'a [f32],
    /// World from model, for each joint. Empty: no skin.
    world_from_joints: Vec<DAffine3>,
}

impl<'a> Pose<'a> {
    /// The pose of node `node` of the scene, which is `json` in the file. `None`: its mesh is
    /// drawn as it is.
    pub fn of(
        input: &Input<'a>,
        output: &mut Output,
        joints: &Joints,
        node: usize,
        json: &'a Node,
    ) -> Result<Option<Pose<'a>>, LoadError> {
        let root = &input.document.root;
        let mesh = json.mesh.and_then(|mesh| root.get(mesh));
        let weights = json.weights.as_ref().or_else(|| mesh?.weights.as_ref());
        let weights = weights.map_or(&[][..], Vec::as_slice);
        let weights = if weights.iter().any(|&weight| weight != 0.0) { weights } else { &[] };
        let world_from_joints = world_from_joints(input, output, joints, node, json)?;
        let is_posed = !weights.is_empty() || !world_from_joints.is_empty();
        Ok(is_posed.then_some(Pose { weights, world_from_joints }))
    }

    /// The mesh leaves model space.
    pub fn is_in_world_space(&self) -> bool {
        !self.world_from_joints.is_empty()
    }

    /// Bends `mesh`, whose vertices are `rows` of the accessors of `json`.
    pub fn apply(
        &self,
        input: &Input<'_>,
        output: &mut Output,
        place: &str,
        json: &Primitive,
        rows: &Rows,
        mesh: &mut Mesh,
    ) -> Result<(), LoadError> {
        let targets = json.targets.iter().flatten();
        for (target, &weight) in targets.zip(self.weights).filter(|(_, weight)| **weight != 0.0) {
            // Any number of targets may share their accessors, so the file does not bound them.
            output.count_decoded::<[Vec3; 2]>(input, rows.len())?;
            if let Err(problem) = morph(input, target, weight, rows, mesh) {
                output.warn(place, format_args!("a morph target cannot be read: {problem}"));
            }
        }
        if self.is_in_world_space() {
            self.skin(input, output, place, json, rows, mesh);
        }
        Ok(())
    }

    fn skin(
        &self,
        input: &Input<'_>,
        output: &mut Output,
        place: &str,
        json: &Primitive,
        rows: &Rows,
        mesh: &mut Mesh,
    ) {
        let mut open = |semantic: Semantic| {
            open_optional(input, output, place, json, semantic, &[Type::Vec4], 0)
        };
        let mut sets = Vec::new();
        for set in 0..MAX_SETS {
            let (joints, weights) = (open(Semantic::Joints(set)), open(Semantic::Weights(set)));
            match (joints, weights) {
                (Some(joints), Some(weights)) => sets.push((joints, weights)),
                _ => break,
            }
        }
        let mut n_unbound = 0;
        for (vertex, row) in rows.iter().enumerate() {
            let mut sum = DMat4::ZERO;
            for (joints, weights) in &sets {
                let pairs = joints.integers::<4>(row).into_iter().zip(weights.fractions::<4>(row));
                for (joint, weight) in pairs.filter(|(_, weight)| *weight > 0.0) {
                    if let Some(world_from_joint) = self.world_from_joints.get(joint as usize) {
                        sum += DMat4::from(*world_from_joint) * f64::from(weight);
                    }
                }
            }
            let total = sum.w_axis.w;
            let world_from_model = if total > 0.0 && total.is_finite() {
                DAffine3::from_mat4(sum * (1.0 / total))
            } else {
                n_unbound += 1;
                self.world_from_joints[0]
            };
            let position = mesh.positions[vertex].as_dvec3();
            mesh.positions[vertex] = world_from_model.transform_point3(position).as_vec3();
            if let Some(normals) = &mut mesh.normals {
                let normal = outward(world_from_model.matrix3) * normals[vertex].as_dvec3();
                normals[vertex] = normal.normalize_or_zero().as_vec3();
            }
        }
        if self.world_from_joints[0].matrix3.determinant() < 0.0 {
            mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        if n_unbound > 0 {
            let problem = format!("{n_unbound} vertices hang on no joint; bound to the first");
            output.warn(place, problem);
        }
    }
}

/// More joints per vertex than anyone writes.
const MAX_SETS: u32 = 4;

/// World from bind pose for every joint; empty without a usable skin.
fn world_from_joints(
    input: &Input<'_>,
    output: &mut Output,
    joints: &Joints,
    node: usize,
    json: &Node,
) -> Result<Vec<DAffine3>, LoadError> {
    let root = &input.document.root;
    let Some(skin) = json.skin.and_then(|skin| root.get(skin)) else { return Ok(Vec::new()) };
    output.count_decoded::<DAffine3>(input, skin.joints.len() as u64)?;
    let place = format!("skin of node `{}`", output.scene.nodes[node].name);
    let inverse_binds = match skin.inverse_bind_matrices {
        None => None,
        Some(index) => match Accessor::open(root, input.buffers, index) {
            Ok(list) if list.shape == Type::Mat4 && list.count >= skin.joints.len() as u64 => {
                Some(list)
            }
            Ok(_) => {
                output.warn(&place, "has bad inverse bind matrices; drawn unskinned");
                return Ok(Vec::new());
            }
            Err(problem) => {
                output.warn(&place, format_args!("{problem}; drawn unskinned"));
                return Ok(Vec::new());
            }
        },
    };
    let world_from_bind = |(i, joint): (usize, &Index<Node>)| -> Option<DAffine3> {
        let world_from_joint = (*joints.0.get(joint.value())?)?;
        let joint_from_bind = inverse_binds.as_ref().map_or(DAffine3::IDENTITY, |list| {
            DAffine3::from_mat4(DMat4::from_cols_array(&list.row::<16>(i as u64).map(f64::from)))
        });
        Some(world_from_joint * joint_from_bind).filter(DAffine3::is_finite)
    };
    let world_from_joints: Option<_> =
        skin.joints.iter().enumerate().map(world_from_bind).collect();
    Ok(world_from_joints.unwrap_or_else(|| {
        output.warn(&place, "has a joint that is not in the scene; drawn unskinned");
        Vec::new()
    }))
}

fn morph(
    input: &Input<'_>,
    target: &MorphTarget,
    weight: f32,
    rows: &Rows,
    mesh: &mut Mesh,
) -> Result<(), String> {
    let add = |index: Option<Index<AccessorJson>>, list: Option<&mut Vec<Vec3>>| {
        let (Some(index), Some(list)) = (index, list) else { return Ok(()) };
        let moves = Accessor::open(&input.document.root, input.buffers, index)?;
        if moves.shape != Type::Vec3 || moves.count < rows.end() {
            return Err("it does not fit the mesh".to_string());
        }
        for (value, row) in list.iter_mut().zip(rows.iter()) {
            let by = DVec3::from_array(moves.row::<3>(row).map(f64::from));
            *value = (value.as_dvec3() + by * f64::from(weight)).as_vec3();
        }
        Ok(())
    };
    add(target.positions, Some(&mut mesh.positions))?;
    add(target.normals, mesh.normals.as_mut())
}

/// Takes normals where the matrix takes surfaces, also when it is singular. They keep
/// pointing outwards when it mirrors, because the triangles are turned around then.
fn outward(m: DMat3) -> DMat3 {
    let cofactors = DMat3::from_cols(
        m.y_axis.cross(m.z_axis),
        m.z_axis.cross(m.x_axis),
        m.x_axis.cross(m.y_axis),
    );
    if m.determinant() < 0.0 { -cofactors } else { cofactors }
}
