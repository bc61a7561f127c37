//! The scene as plain data: flat lists that refer to each other by index.
//!
//! Nothing here is optional in spirit but not in type: what a file may lack is an
//! `Option`, so that everything after loading can skip it. Spaces: mesh data is in model
//! space, `world_from_*` matrices take it to world space (right-handed, y up). Colours are
//! linear; image bytes are as the file has them (sRGB encoded for base colours).

use glam::{Affine2, DAffine3, Vec2, Vec3, Vec4};

use crate::Derived;

/// A loaded scene.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// What to call the scene in messages: the file name, or `synth:NAME`.
    pub name: String,
    /// Every drawn thing, in scene order: one per primitive of each visited node.
    pub objects: Vec<Object>,
    /// Triangle lists; objects refer to them, so instances share them.
    pub meshes: Vec<Mesh>,
    /// Materials; index 0 is always there and is the default of the file format.
    pub materials: Vec<Material>,
    /// Image + sampler pairs.
    pub textures: Vec<Texture>,
    /// Decoded images. One that was not wanted (see [`crate::LoadOptions`]) has no pixels.
    pub images: Vec<Image>,
    /// Cameras, one per node that has one, in scene order.
    pub cameras: Vec<SceneCamera>,
    /// Nodes in the order visited; parents come before children.
    pub nodes: Vec<Node>,
    /// Things that went wrong and were mended, one sentence each, naming file and place.
    pub warnings: Vec<String>,
    /// Things in the file that no picture needs or that cannot be drawn yet, one phrase each.
    pub left_out: Vec<String>,
    /// Every extension the file names, and how it is treated.
    pub extensions: Vec<Extension>,
    /// Names of the animations in the file (they are not played yet).
    pub animations: Vec<String>,
}

/// One primitive of one node: the unit of culling, of `id` passes and of statistics.
#[derive(Clone, Debug)]
pub struct Object {
    /// `node` or `node/primitive 1`; never empty.
    pub name: String,
    /// Index into [`Scene::nodes`].
    pub node: usize,
    /// Index into [`Scene::meshes`].
    pub mesh: usize,
    /// Index into [`Scene::materials`].
    pub material: usize,
    /// Model to world, composed in f64 from the root. Finite; may be singular or mirrored.
    pub world_from_model: DAffine3,
}

/// An indexed triangle list. All present attribute lists are as long as `positions`.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Name in the file, or a made-up one.
    pub name: String,
    /// Model space. May hold NaN or infinities: such triangles are dropped when drawn.
    pub positions: Vec<Vec3>,
    /// Model space, as in the file (not necessarily unit). `None`: shade flat.
    pub normals: Option<Vec<Vec3>>,
    /// Texture coordinates, sets 0 and 1; v grows downwards in the image (glTF).
    pub uvs: [Option<Vec<Vec2>>; 2],
    /// Linear RGBA that multiplies the base colour.
    pub colors: Option<Vec<Vec4>>,
    /// Corner indices; every index is below `positions.len()`. Counter-clockwise is front.
    pub triangles: Vec<[u32; 3]>,
}

/// The parts of a material that Cullet draws with so far.
#[derive(Clone, Debug)]
pub struct Material {
    /// Name in the file, or a made-up one.
    pub name: String,
    /// Linear RGBA factor.
    pub base_color: Vec4,
    /// Multiplies the factor; sRGB encoded.
    pub base_color_texture: Option<TextureRef>,
    /// What the alpha channel means.
    pub alpha: AlphaMode,
    /// Draw back faces too, with flipped normals.
    pub double_sided: bool,
    /// Meant to be shown without light (`KHR_materials_unlit`). `lambert` lights it like any other:
    /// there the kind of a material only says where its base colour comes from.
    pub unlit: bool,
}

impl Default for Material {
    /// White, opaque, single-sided, lit.
    fn default() -> Self {
        Material {
            name: "default".into(),
            base_color: Vec4::ONE,
            base_color_texture: None,
            alpha: AlphaMode::Opaque,
            double_sided: false,
            unlit: false,
        }
    }
}

/// What the alpha channel means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    /// Ignored.
    Opaque,
    /// Drawn where alpha is at least `cutoff`.
    Mask {
        /// Smallest alpha that is drawn.
        cutoff: f32,
    },
    /// To be blended; drawn as opaque so far, with a warning at load.
    Blend,
}

/// A texture as a material uses it.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureRef {
    /// Index into [`Scene::textures`].
    pub texture: usize,
    /// Which of the two texture coordinate sets (0 or 1).
    pub uv_set: usize,
    /// KHR_texture_transform, when it changes anything: `uv' = transform * uv`.
    pub transform: Option<Affine2>,
}

/// An image and how to sample it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Texture {
    /// Index into [`Scene::images`].
    pub image: usize,
    /// Filters and wrap modes.
    pub sampler: Sampler,
}

/// Filters and wrap modes of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Sampler {
    /// Along u.
    pub wrap_u: Wrap,
    /// Along v.
    pub wrap_v: Wrap,
    /// The file asks for nearest-texel magnification.
    pub nearest_mag: bool,
    /// The file asks for nearest-texel minification.
    pub nearest_min: bool,
}

/// What happens to texture coordinates outside 0..1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Wrap {
    /// Tile.
    #[default]
    Repeat,
    /// Tile, every other tile mirrored.
    Mirror,
    /// Stay at the edge texel.
    Clamp,
}

/// A decoded image.
#[derive(Clone, Debug, Default)]
pub struct Image {
    /// Name, URI or a made-up one.
    pub name: String,
    /// Pixels across; 0 when not decoded.
    pub width: u32,
    /// Pixels down; 0 when not decoded.
    pub height: u32,
    /// Row-major RGBA, 8 bits, top row first, straight alpha; `width * height * 4` bytes.
    pub rgba: Vec<u8>,
    /// The real image could not be read and this is the visible stand-in.
    pub placeholder: bool,
    /// What who loads the scene has made of the pixels, see [`Task::run_with`](crate::Task::run_with); they may have
    /// moved into it. Loading itself leaves it empty.
    pub derived: Option<Derived>,
}

/// A camera that the file has.
#[derive(Clone, Debug)]
pub struct SceneCamera {
    /// Name of the camera or else of its node; may be empty.
    pub name: String,
    /// Index into [`Scene::nodes`].
    pub node: usize,
    /// Camera to world; the camera looks down its own -z, y up.
    pub world_from_camera: DAffine3,
    /// Its lens.
    pub lens: Lens,
}

/// The lens of a camera in a file, as written there (checked when it becomes a
/// `cullet_transform::Camera`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens {
    /// Perspective.
    Perspective {
        /// Vertical field of view in radians.
        yfov: f64,
        /// Width over height, when the file fixes it.
        aspect: Option<f64>,
        /// Near distance.
        near: f64,
        /// Far distance; infinity when the file has none.
        far: f64,
    },
    /// Orthographic.
    Orthographic {
        /// Half the width of the view in scene units.
        xmag: f64,
        /// Half the height of the view in scene units.
        ymag: f64,
        /// Near distance.
        near: f64,
        /// Far distance.
        far: f64,
    },
}

/// A node, for names and legends. Geometry does not look at it any more.
#[derive(Clone, Debug)]
pub struct Node {
    /// Name in the file, or `node 3`.
    pub name: String,
    /// Index into [`Scene::nodes`].
    pub parent: Option<usize>,
    /// Node to world.
    pub world_from_node: DAffine3,
}

/// An extension that the file names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Extension {
    /// Its registered name.
    pub name: String,
    /// The file says that it cannot be drawn without.
    pub required: bool,
    /// How it is treated.
    pub treatment: Treatment,
}

/// How an extension is treated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Treatment {
    /// Drawn as meant.
    Supported,
    /// Drawn, but not as meant.
    Approximated,
    /// Has no effect on the picture, or none yet.
    Ignored,
}
