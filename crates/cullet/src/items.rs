//! An object made ready to draw.

use cullet_cull::Aabb;
use cullet_raster::Facing;
use cullet_scene::{AlphaMode, Material, Mesh, Object};
use cullet_shade::{Needs, Shading, mirrors, normal_matrix};
use cullet_transform::View;
use glam::{DAffine3, Mat3};

/// One object of the scene with what every frame needs to know about it.
#[derive(Clone, Copy, Debug)]
pub struct Item {
    /// Global id of the object's first triangle; its others follow.
    pub first_triangle: u32,
    /// Number of triangles.
    pub n_triangles: u32,
    /// Index into the scene's meshes.
    pub mesh: usize,
    /// Index into the scene's materials.
    pub material: usize,
    /// Model to world.
    pub world_from_model: DAffine3,
    /// Model-space normals to world space, any length.
    pub normal_world_from_model: Mat3,
    /// Model-space box around all triangles whose corners are numbers.
    pub bounds_model: Aabb,
    /// The same in world space.
    pub bounds: Aabb,
    /// The object is mirrored: its front faces run clockwise.
    pub mirrored: bool,
    /// Which faces are drawn.
    pub facing: Facing,
    /// Samples must be asked whether they are there.
    pub masked: bool,
    lambert: Needs,
    unlit: Needs,
}

impl Item {
    pub(crate) fn new(
        object: &Object,
        mesh: &Mesh,
        material: &Material,
        bounds_model: &Aabb,
        first_triangle: u32,
    ) -> Self {
        let mirrored = mirrors(&object.world_from_model);
        let facing = match (material.double_sided, mirrored) {
            (true, _) => Facing::Both,
            (false, false) => Facing::CounterClockwise,
            (false, true) => Facing::Clockwise,
        };
        Item {
            first_triangle,
            n_triangles: mesh.triangles.len() as u32,
            mesh: object.mesh,
            material: object.material,
            world_from_model: object.world_from_model,
            normal_world_from_model: normal_matrix(&object.world_from_model),
            bounds_model: *bounds_model,
            bounds: bounds_model.transformed(&object.world_from_model),
            mirrored,
            facing,
            masked: matches!(material.alpha, AlphaMode::Mask { .. }),
            lambert: Needs::of(mesh, material, Shading::Lambert),
            unlit: Needs::of(mesh, material, Shading::Unlit),
        }
    }

    /// Whether global triangle `id` is one of its own.
    pub(crate) fn holds(&self, id: u32) -> bool {
        id.wrapping_sub(self.first_triangle) < self.n_triangles
    }

    /// The box that culling tests: world axes, counted from the eye of `view`. Made by the matrix
    /// that takes the vertices on their way, so that it holds them with all their rounding.
    pub fn bounds_from_eye(&self, view: &View) -> Aabb {
        self.bounds_model.transformed(&view.relative_from_model(&self.world_from_model))
    }

    /// What its colours need.
    pub fn needs(&self, shading: Shading) -> Needs {
        match shading {
            Shading::Lambert => self.lambert,
            Shading::Unlit => self.unlit,
        }
    }
}
