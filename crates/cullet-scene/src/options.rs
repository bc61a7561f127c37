//! How much of a file to load, and how much of the machine it may use.

/// What to load and when to stop. All limits are for one whole scene, so that no
/// arrangement of small parts gets around them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoadOptions {
    /// Bytes of the scene file and all files it names. `--max-file-bytes`.
    pub max_file_bytes: u64,
    /// Pixels of all images that are decoded. `--max-image-pixels`.
    pub max_image_pixels: u64,
    /// Visits of nodes plus objects made from them. `--max-nodes`.
    pub max_nodes: usize,
    /// Triangles of all meshes, each counted once however often it is placed.
    /// `--max-triangles`.
    pub max_triangles: u64,
    /// Bytes of the geometry that is decoded from glTF: triangles and vertices, morph targets
    /// and matrices too. What OBJ files hold is at most a few times their own size.
    /// `--max-decoded-bytes`.
    pub max_decoded_bytes: u64,
    /// Decode the images that base colours use. Without, they stay empty.
    pub textures: bool,
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
            textures: true,
        }
    }
}
