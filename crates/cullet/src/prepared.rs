//! A scene made ready: everything that does not depend on the view, computed once.

use cullet_cull::{Aabb, Hierarchy};
use cullet_scene::{Mesh, Scene, TextureRef};
use cullet_shade::{Surface, Texture, srgb};
use glam::Vec3;

use crate::Item;
use crate::clusters::Clusters;
use crate::preparing::{Made, PrepareTimes, make, without_pixels};
use crate::schedule::thread_count;

/// Numbers of triangles, and two that mean something else, fit into 31 bits, so that no sum of two of them
/// overflows.
const MAX_TRIANGLES: u32 = (1 << 31) - 2;

/// Why a scene cannot be prepared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PrepareError {
    /// More triangles than there are ids.
    #[error("{scene}: draws {n_triangles} triangles; at most {} can be drawn", MAX_TRIANGLES)]
    TooManyTriangles {
        /// Name of the scene.
        scene: String,
        /// Triangles of all objects, instances counted each.
        n_triangles: u64,
    },
    /// Whoever loaded the scene has moved pixels into something of their own.
    #[error(
        "{scene}: the pixels of image `{image}` have moved into what is no texture pyramid; load it again"
    )]
    NoPixels {
        /// Name of the scene.
        scene: String,
        /// Name of the image.
        image: String,
    },
}

/// A scene with boxes, texture pyramids and kernels.
#[derive(Debug)]
pub struct Prepared {
    scene: Scene,
    textures: Vec<Texture>,
    items: Vec<Item>,
    /// Items without a triangle whose corners are numbers.
    empty: Vec<u32>,
    n_triangles: u64,
    /// By mesh.
    clusters: Vec<Clusters>,
    hierarchy: Hierarchy,
    times: PrepareTimes,
}

impl Prepared {
    /// Prepares every object, on all cores. Boxes are computed from the vertices, whatever a file
    /// claims.
    pub fn new(scene: Scene) -> Result<Self, PrepareError> {
        Prepared::with_threads(scene, 0)
    }

    /// Like [`Prepared::new`] on `threads` threads, 0 for one per core, which does not show in what
    /// is prepared.
    pub fn with_threads(mut scene: Scene, threads: usize) -> Result<Self, PrepareError> {
        let n_triangles: u64 =
            scene.objects.iter().map(|o| scene.meshes[o.mesh].triangles.len() as u64).sum();
        if n_triangles > u64::from(MAX_TRIANGLES) {
            return Err(PrepareError::TooManyTriangles { scene: scene.name, n_triangles });
        }
        if let Some(image) = without_pixels(&scene) {
            let image = image.name.clone();
            return Err(PrepareError::NoPixels { scene: scene.name, image });
        }
        let Made { textures, clusters, times } = make(&mut scene, thread_count(threads));
        let bounds: Vec<Aabb> = clusters.iter().map(Clusters::bounds).collect();
        let mut first_triangle = 0;
        let items = scene.objects.iter().map(|object| {
            let mesh = &scene.meshes[object.mesh];
            let material = &scene.materials[object.material];
            let item = Item::new(object, mesh, material, &bounds[object.mesh], first_triangle);
            first_triangle += item.n_triangles;
            item
        });
        let items: Vec<Item> = items.collect();
        let empty = (0..).zip(&items).filter(|(_, item)| item.bounds.is_empty());
        let empty = empty.map(|(i, _)| i).collect();
        let boxes: Vec<Aabb> = items.iter().map(|item| item.bounds).collect();
        srgb::encode8(0.0); // its table is made at the first use, which no frame should pay for
        let hierarchy = Hierarchy::build(&boxes);
        Ok(Prepared { scene, textures, items, empty, n_triangles, clusters, hierarchy, times })
    }

    /// The scene as loaded (its image bytes have moved into the texture pyramids).
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The objects, in scene order.
    pub fn items(&self) -> &[Item] {
        &self.items
    }

    /// Items that have nothing to show, whatever the view.
    pub(crate) fn empty_items(&self) -> &[u32] {
        &self.empty
    }

    /// Triangles of all items.
    pub(crate) fn n_triangles(&self) -> u64 {
        self.n_triangles
    }

    /// The tree over the boxes of the items.
    pub fn hierarchy(&self) -> &Hierarchy {
        &self.hierarchy
    }

    /// What preparation took how long.
    pub fn times(&self) -> PrepareTimes {
        self.times
    }

    /// World-space box around everything.
    pub fn bounds(&self) -> Aabb {
        self.items.iter().fold(Aabb::EMPTY, |all, item| all.union(&item.bounds))
    }

    /// Index of the item that global triangle `id` belongs to.
    pub(crate) fn item_of(&self, id: u32) -> usize {
        self.items.partition_point(|item| item.first_triangle <= id) - 1
    }

    /// The clusters of an item's mesh.
    pub(crate) fn clusters(&self, item_idx: usize) -> &Clusters {
        &self.clusters[self.items[item_idx].mesh]
    }

    pub(crate) fn mesh(&self, item: &Item) -> &Mesh {
        &self.scene.meshes[item.mesh]
    }

    /// What a kernel reads of an item.
    pub(crate) fn surface(&self, item: &Item) -> Surface<'_> {
        let material = &self.scene.materials[item.material];
        let texture = material.base_color_texture.as_ref();
        Surface {
            mesh: self.mesh(item),
            material,
            texture: texture.map(|TextureRef { texture, .. }| &self.textures[*texture]),
            world_from_model: item.world_from_model,
            normal_world_from_model: item.normal_world_from_model,
        }
    }
}

/// The corners of the triangles that can be drawn: those of which every corner is a number.
pub(crate) fn drawable(mesh: &Mesh) -> impl Iterator<Item = [Vec3; 3]> {
    let corners = mesh.triangles.iter().map(|t| t.map(|i| mesh.positions[i as usize]));
    corners.filter(|corners| corners.iter().all(|p| p.is_finite()))
}
