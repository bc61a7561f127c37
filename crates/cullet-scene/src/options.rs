//! How much of a file to load, and how much of the machine it may use.

use crate::{AlphaMode, Material};

/// What to load and when to stop. All limits are for one whole scene, so that no
/// arrangement of small parts gets around them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoadOptions {
    /// Limit for the scene file and all files it names together, in bytes
    pub max_file_bytes: u64,
    /// Limit for all decoded images together, in pixels
    pub max_image_pixels: u64,
    /// Limit for visited nodes plus the objects made from them
    pub max_nodes: usize,
    /// Limit for the triangles of all meshes, each mesh counted once
    pub max_triangles: u64,
    // Triangles and vertices, morph targets and matrices too. What OBJ files hold is at most a few
    // times their own size.
    /// Limit for the geometry that is decoded from glTF, in bytes
    pub max_decoded_bytes: u64,
    /// Which images to decode. The others stay empty.
    pub images: Images,
}

/// Which images to decode: those that base colours of drawn objects use, or fewer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Images {
    /// All that base colours use.
    #[default]
    BaseColors,
    /// Only those whose alpha decides what is covered: enough for pictures of shapes.
    Masks,
    /// None.
    None,
}

impl Images {
    /// Whether the base colour image of a material is decoded.
    pub(crate) fn wants(self, material: &Material) -> bool {
        match self {
            Images::BaseColors => true,
            Images::Masks => matches!(material.alpha, AlphaMode::Mask { .. }),
            Images::None => false,
        }
    }
}

impl Default for LoadOptions {
    /// 4 GiB of files, 2 GiB of pixels, a million nodes, a hundred million triangles and
    /// 4 GiB of geometry.
    fn default() -> Self {
        LoadOptions {
            max_file_bytes: 1 << 32,
            max_image_pixels: 1 << 29,
            max_nodes: 1_000_000,
            max_triangles: 100_000_000,
            max_decoded_bytes: 1 << 32,
            images: Images::BaseColors,
        }
    }
}
