//! Putting a scene together: what every synthetic scene shares.
//!
//! Lists grow by `add`-like calls that return indices. Transforms are given relative to
//! the parent, and composed in f64 as a loader would.

use glam::{DAffine3, DMat3, DMat4, DVec3, Vec3, Vec4};

use crate::{
    AlphaMode, Image, Lens, Material, Mesh, Node, Object, Sampler, Scene, SceneCamera, Texture,
    TextureRef,
};

/// A scene under construction.
pub(super) struct Builder {
    scene: Scene,
}

impl Builder {
    /// An empty scene with the default material.
    pub fn new(name: &str) -> Builder {
        let scene = Scene {
            name: format!("synth:{name}"),
            materials: vec![Material::default()],
            ..Scene::default()
        };
        Builder { scene }
    }

    /// The finished scene.
    pub fn finish(self) -> Scene {
        self.scene
    }

    /// An image with a sampler of its own.
    pub fn texture(&mut self, image: Image, sampler: Sampler) -> TextureRef {
        let image = self.image(image);
        self.resample(image, sampler)
    }

    /// An image, for [`Builder::resample`].
    pub fn image(&mut self, image: Image) -> usize {
        self.scene.images.push(image);
        self.scene.images.len() - 1
    }

    /// A sampler for an image that is there already.
    pub fn resample(&mut self, image: usize, sampler: Sampler) -> TextureRef {
        self.scene.textures.push(Texture { image, sampler });
        TextureRef { texture: self.scene.textures.len() - 1, uv_set: 0, transform: None }
    }

    /// Any material.
    pub fn material(&mut self, material: Material) -> usize {
        self.scene.materials.push(material);
        self.scene.materials.len() - 1
    }

    /// An opaque material of one colour (linear).
    pub fn plain(&mut self, name: &str, color: [f32; 3]) -> usize {
        let base_color = Vec3::from(color).extend(1.0);
        self.material(Material { name: name.into(), base_color, ..Material::default() })
    }

    /// An opaque material with a repeated image.
    pub fn textured(&mut self, name: &str, image: Image) -> usize {
        let texture = self.texture(image, Sampler::default());
        self.material(Material {
            name: name.into(),
            base_color_texture: Some(texture),
            ..Material::default()
        })
    }

    /// A double-sided material that is cut out where the image is transparent.
    pub fn cut_out(&mut self, name: &str, texture: TextureRef) -> usize {
        self.material(Material {
            name: name.into(),
            base_color: Vec4::ONE,
            base_color_texture: Some(texture),
            alpha: AlphaMode::Mask { cutoff: 0.5 },
            double_sided: true,
            unlit: false,
        })
    }

    /// A mesh to be placed any number of times.
    pub fn mesh(&mut self, name: &str, mesh: Mesh) -> usize {
        self.scene.meshes.push(Mesh { name: name.into(), ..mesh });
        self.scene.meshes.len() - 1
    }

    /// A node; `local` is relative to `parent`.
    pub fn node(&mut self, name: &str, parent: Option<usize>, local: DAffine3) -> usize {
        let world_from_parent =
            parent.map_or(DAffine3::IDENTITY, |parent| self.scene.nodes[parent].world_from_node);
        let world_from_node = world_from_parent * local;
        self.scene.nodes.push(Node { name: name.into(), parent, world_from_node });
        self.scene.nodes.len() - 1
    }

    /// A node that draws one mesh.
    pub fn place(
        &mut self,
        name: &str,
        parent: Option<usize>,
        local: DAffine3,
        (mesh, material): (usize, usize),
    ) -> usize {
        let node = self.node(name, parent, local);
        let world_from_model = self.scene.nodes[node].world_from_node;
        let name = name.to_owned();
        self.scene.objects.push(Object { name, node, mesh, material, world_from_model });
        node
    }

    /// A mesh used once, with a node of the same name.
    pub fn single(&mut self, name: &str, local: DAffine3, mesh: Mesh, material: usize) -> usize {
        let mesh = self.mesh(name, mesh);
        self.place(name, None, local, (mesh, material))
    }

    /// A camera on a node of its own.
    pub fn camera(&mut self, parent: Option<usize>, local: DAffine3, lens: Lens) {
        let node = self.node("camera", parent, local);
        self.scene.cameras.push(SceneCamera {
            name: "camera".into(),
            node,
            world_from_camera: self.scene.nodes[node].world_from_node,
            lens,
        });
    }

    /// A perspective camera at `eye` that looks at `target`; `yfov` in degrees.
    pub fn look(&mut self, eye: [f64; 3], target: [f64; 3], yfov: f64) {
        let lens = Lens::Perspective {
            yfov: yfov.to_radians(),
            aspect: None,
            near: 0.05,
            far: f64::INFINITY,
        };
        self.camera(None, looking(eye.into(), target.into()), lens);
    }
}

/// Camera to world for a camera at `eye` that looks at `target`, y up.
pub(super) fn looking(eye: DVec3, target: DVec3) -> DAffine3 {
    let back = (eye - target).normalize();
    let right = DVec3::Y.cross(back).normalize();
    let up = back.cross(right);
    DAffine3::from_mat3_translation(DMat3::from_cols(right, up, back), eye)
}

/// A move.
pub(super) fn at(x: f64, y: f64, z: f64) -> DAffine3 {
    DAffine3::from_translation(DVec3::new(x, y, z))
}

/// A scale along the axes.
pub(super) fn scaled(x: f64, y: f64, z: f64) -> DAffine3 {
    DAffine3::from_scale(DVec3::new(x, y, z))
}

/// A turn about the y axis, counter-clockwise seen from above, in degrees.
pub(super) fn turned(degrees: f64) -> DAffine3 {
    DAffine3::from_mat4(DMat4::from_rotation_y(degrees.to_radians()))
}

/// A turn about the x axis, in degrees.
pub(super) fn tilted(degrees: f64) -> DAffine3 {
    DAffine3::from_mat4(DMat4::from_rotation_x(degrees.to_radians()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_looks_down_its_own_minus_z() {
        let world_from_camera = looking(DVec3::new(3.0, 4.0, 5.0), DVec3::new(1.0, 2.0, -1.0));
        let ahead = world_from_camera.transform_vector3(DVec3::NEG_Z);
        let expected = DVec3::new(-2.0, -2.0, -6.0).normalize();
        assert!(ahead.abs_diff_eq(expected, 1e-12), "{ahead}");
        assert!((world_from_camera.matrix3.determinant() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn children_move_with_their_parents() {
        let mut builder = Builder::new("test");
        let parent = builder.node("parent", None, at(1.0, 2.0, 3.0) * scaled(2.0, 2.0, 2.0));
        let child = builder.node("child", Some(parent), at(1.0, 0.0, 0.0));
        let scene = builder.finish();
        let origin = scene.nodes[child].world_from_node.transform_point3(DVec3::ZERO);
        assert_eq!(origin, DVec3::new(3.0, 2.0, 3.0));
    }
}
