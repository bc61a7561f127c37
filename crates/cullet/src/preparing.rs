//! What takes long before the first frame, on all cores: texture pyramids and clusters.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use cullet_scene::{self as scene, Image, Mesh, Scene};
use cullet_shade::{Mips, Texture};

use crate::clusters::Clusters;
use crate::schedule::for_each;

/// Meshes of more triangles keep several threads busy.
const LARGE: usize = 1 << 17;

/// What a scene is drawn with.
pub(crate) struct Made {
    /// By texture.
    pub textures: Vec<Texture>,
    /// By mesh.
    pub clusters: Vec<Clusters>,
    /// Time that each took, all threads together.
    pub times: PrepareTimes,
}

/// Time that parts of preparation took, all threads together: parts overlap, so the sum may be more than the wall
/// time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PrepareTimes {
    /// Smaller copies of images.
    pub pyramids: Duration,
    /// Meshes cut into clusters. Of a large one the wall time.
    pub clusters: Duration,
}

/// Something one thread makes.
enum Job<'j> {
    Pyramid(Image, &'j OnceLock<Arc<Mips>>),
    Clusters(&'j Mesh, &'j mut Clusters),
}

/// Cuts every mesh, and moves the pixels of each image that is shown into a pyramid that its textures share, and those
/// of equal images too: exporters write one image under many names.
///
/// The largest meshes are cut by all threads, then the rest is made side by side; what takes long comes first, for
/// what is left at the end for one thread alone should be little.
pub(crate) fn make(scene: &mut Scene, threads: usize) -> Made {
    let mut equal = BTreeMap::new();
    let first: Vec<usize> =
        scene.textures.iter().map(|t| first_equal(scene, t, &mut equal)).collect();
    let mut is_shown = vec![false; scene.images.len()];
    first.iter().for_each(|&image| is_shown[image] = true);
    let mips: Vec<OnceLock<Arc<Mips>>> = scene.images.iter().map(|_| OnceLock::new()).collect();
    let all = scene.images.iter_mut().map(std::mem::take).zip(&mips).zip(is_shown);
    let mut images = Vec::new();
    for (image, mips) in all.filter_map(|(job, is_shown)| is_shown.then_some(job)) {
        match pyramid_of(&image) {
            Some(pyramid) => drop(mips.set(pyramid)),
            None => images.push((image, mips)),
        }
    }
    images.sort_by_key(|(image, _)| Reverse(image.rgba.len()));

    let mut clusters = vec![Clusters::default(); scene.meshes.len()];
    let mut meshes: Vec<_> = scene.meshes.iter().zip(&mut clusters).collect();
    meshes.sort_by_key(|(mesh, _)| Reverse(mesh.triangles.len()));
    let n_large = meshes.partition_point(|(mesh, _)| mesh.triangles.len() > LARGE);
    let others = meshes.split_off(n_large);
    let times = [AtomicU64::new(0), AtomicU64::new(0)];
    let [pyramid_time, cluster_time] = &times;
    for (mesh, clusters) in meshes {
        timed(cluster_time, || *clusters = Clusters::new(mesh, threads));
    }

    let pyramids = images.into_iter().map(|(image, mips)| Job::Pyramid(image, mips));
    let others = others.into_iter().map(|(mesh, clusters)| Job::Clusters(mesh, clusters));
    let jobs: Vec<Job<'_>> = pyramids.chain(others).collect();
    for_each(threads, jobs.into_iter(), |job| match job {
        Job::Pyramid(image, mips) => timed(pyramid_time, || {
            mips.get_or_init(|| Arc::new(Mips::new(image)));
        }),
        Job::Clusters(mesh, clusters) => {
            timed(cluster_time, || *clusters = Clusters::new(mesh, 1));
        }
    });

    let texture = |(texture, image): (&scene::Texture, usize)| {
        let mips = mips[image].get().expect("every image that is shown has a pyramid");
        Texture::shared(Arc::clone(mips), texture.sampler)
    };
    let textures = scene.textures.iter().zip(first).map(texture).collect();
    let [pyramids, clusters_took] = times.map(|sum| Duration::from_nanos(sum.into_inner()));
    Made { textures, clusters, times: PrepareTimes { pyramids, clusters: clusters_took } }
}

/// Does `work` and adds the nanoseconds that it took.
fn timed(sum: &AtomicU64, work: impl FnOnce()) {
    let start = Instant::now();
    work();
    sum.fetch_add(start.elapsed().as_nanos() as u64, Ordering::Relaxed);
}

/// That of an image of which one has been made, see [`load_to_draw`](crate::load_to_draw).
fn pyramid_of(image: &Image) -> Option<Arc<Mips>> {
    image.derived.as_ref()?.get()
}

/// An image that is shown, and whose pixels have gone where they cannot be found.
pub(crate) fn without_pixels(scene: &Scene) -> Option<&Image> {
    let mut images = scene.textures.iter().map(|texture| &scene.images[texture.image]);
    images.find(|image| {
        image.derived.is_some() && image.rgba.is_empty() && pyramid_of(image).is_none()
    })
}

/// What images are equal by.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
enum Key<'s> {
    Pixels(u32, u32, &'s [u8]),
    /// The address of what took the place of the pixels, which equal ones share.
    Derived(usize),
}

/// The image a texture shows, or one that is equal and that an earlier one shows.
fn first_equal<'s>(
    scene: &'s Scene,
    texture: &scene::Texture,
    known: &mut BTreeMap<Key<'s>, usize>,
) -> usize {
    let image = &scene.images[texture.image];
    let key = match pyramid_of(image) {
        Some(pyramid) => Key::Derived(Arc::as_ptr(&pyramid).addr()),
        None => Key::Pixels(image.width, image.height, &image.rgba),
    };
    *known.entry(key).or_insert(texture.image)
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
        let made = |threads| make(&mut scene.clone(), threads);
        let one = made(1);
        for threads in [2, 5] {
            let many = made(threads);
            assert_eq!(format!("{:?}", many.clusters), format!("{:?}", one.clusters));
            let (many, one) = (many.textures, &one.textures);
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
