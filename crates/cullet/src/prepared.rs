//! A scene made ready: everything that does not depend on the view, computed once.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use cullet_cull::{Aabb, Hierarchy};
use cullet_scene::{self as scene, Image, Mesh, Scene, TextureRef};
use cullet_shade::{Mips, Surface, Texture, srgb};
use glam::Vec3;

use crate::Item;
use crate::clusters::Clusters;
use crate::schedule::{for_each, thread_count};

/// Numbers of triangles, and two that mean something else, fit into 31 bits, so that no sum of two of them
/// overflows.
const MAX_TRIANGLES: u32 = (1 << 31) - 2;

/// Meshes of more triangles keep several threads busy.
const LARGE: usize = 1 << 17;

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
    pyramid_time: Duration,
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
        let clusters = clusters(&scene.meshes, thread_count(threads));
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
        let start = Instant::now();
        let textures = textures(&mut scene, thread_count(threads));
        let pyramid_time = start.elapsed();
        srgb::encode8(0.0); // its table is made at the first use, which no frame should pay for
        let hierarchy = Hierarchy::build(&boxes);
        Ok(Prepared {
            scene,
            textures,
            items,
            empty,
            n_triangles,
            clusters,
            hierarchy,
            pyramid_time,
        })
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

    /// Wall time that the texture pyramids took.
    pub fn pyramid_time(&self) -> Duration {
        self.pyramid_time
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

/// Cuts every mesh on all cores: the largest by themselves, then others side by side, larger ones first.
fn clusters(meshes: &[Mesh], threads: usize) -> Vec<Clusters> {
    let n_triangles = |mesh: &Mesh| mesh.triangles.len();
    let mut clusters = vec![Clusters::default(); meshes.len()];
    let mut jobs: Vec<_> = clusters.iter_mut().zip(meshes).collect();
    jobs.sort_by_key(|(_, mesh)| Reverse(n_triangles(mesh)));
    let n_large = jobs.partition_point(|(_, mesh)| n_triangles(mesh) > LARGE);
    let others = jobs.split_off(n_large);
    jobs.into_iter().for_each(|(clusters, mesh)| *clusters = Clusters::new(mesh, threads));
    for_each(threads, others.into_iter(), |(clusters, mesh)| *clusters = Clusters::new(mesh, 1));
    clusters
}

/// Moves the pixels of each image that is shown into a pyramid that its textures share, and those
/// of equal images too: exporters write one image under many names. The largest come first: what is
/// left at the end for one thread alone should be small.
fn textures(scene: &mut Scene, threads: usize) -> Vec<Texture> {
    let mut equal = BTreeMap::new();
    let first: Vec<usize> =
        scene.textures.iter().map(|t| first_equal(scene, t, &mut equal)).collect();
    let mut is_shown = vec![false; scene.images.len()];
    first.iter().for_each(|&image| is_shown[image] = true);
    let mips: Vec<OnceLock<Arc<Mips>>> = scene.images.iter().map(|_| OnceLock::new()).collect();
    let images = scene.images.iter_mut().map(std::mem::take).zip(&mips).zip(is_shown);
    let mut jobs: Vec<_> = images.filter_map(|(job, is_shown)| is_shown.then_some(job)).collect();
    jobs.sort_by_key(|(image, _)| Reverse(image.rgba.len()));
    for_each(threads, jobs.into_iter(), |(image, mips)| {
        mips.get_or_init(|| Arc::new(Mips::new(image)));
    });
    let texture = |(texture, image): (&scene::Texture, usize)| {
        let mips = mips[image].get().expect("every image that is shown has a pyramid");
        Texture::shared(Arc::clone(mips), texture.sampler)
    };
    scene.textures.iter().zip(first).map(texture).collect()
}

/// The image a texture shows, or one with the same pixels that an earlier one shows.
fn first_equal<'s>(
    scene: &'s Scene,
    texture: &scene::Texture,
    known: &mut BTreeMap<(u32, u32, &'s [u8]), usize>,
) -> usize {
    let Image { width, height, rgba, .. } = &scene.images[texture.image];
    *known.entry((*width, *height, rgba)).or_insert(texture.image)
}

#[cfg(test)]
mod tests {
    use cullet_scene::synth::synth;

    use super::*;

    #[test]
    fn equal_images_share_a_pyramid_whatever_the_number_of_threads() {
        let mut scene = synth("showpiece").unwrap();
        let n = scene.textures.len();
        assert!(n > 1);
        for i in 0..n {
            let copy =
                Image { name: "copy".into(), ..scene.images[scene.textures[i].image].clone() };
            scene.textures.push(scene::Texture { image: scene.images.len(), ..scene.textures[i] });
            scene.images.push(copy);
        }
        let prepare = |threads| Prepared::with_threads(scene.clone(), threads).unwrap().textures;
        let one = prepare(1);
        for threads in [2, 5] {
            let many = prepare(threads);
            assert_eq!(many.len(), 2 * n);
            for i in 0..n {
                assert!(Arc::ptr_eq(&many[i].mips, &many[n + i].mips));
                let (a, b) = (many[i].mips.levels(), one[i].mips.levels());
                assert!(a.eq(b));
                assert_eq!(many[i].wrap, one[i].wrap);
            }
        }
    }
}
