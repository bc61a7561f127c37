//! Loading on several cores: images are decoded, and made into pyramids if wanted, while geometry is read.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use cullet_scene::{
    Derived, Image, LoadError, LoadOptions, Run, Scene, Task, TaskKind, load_glb_bytes_with,
    load_with,
};
use cullet_shade::Mips;

use crate::schedule::{for_each, thread_count};

/// Time that parts of loading took, all threads together: parts overlap, so the sum may be more
/// than the wall time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LoadTimes {
    /// Vertices and triangles of glTF files.
    pub geometry: Duration,
    /// Pixels of images.
    pub images: Duration,
    /// Smaller copies of images, where the scene is [loaded to be drawn](load_to_draw).
    pub pyramids: Duration,
}

/// [`cullet_scene::load`] on `threads` threads, 0 for one per core. The scene, its warnings and
/// errors are the same for every number of threads.
pub fn load(
    path: &Path,
    options: &LoadOptions,
    threads: usize,
) -> Result<(Scene, LoadTimes), LoadError> {
    Workers::new(threads, false).load(|run| load_with(path, options, run))
}

/// [`load`] for a scene that is going to be [prepared](crate::Prepared): each image is made into a pyramid where it has
/// been decoded, with its pixels still at hand. The scene draws the same, but its images have no pixels any more;
/// what became of them is in [`Image::derived`].
pub fn load_to_draw(
    path: &Path,
    options: &LoadOptions,
    threads: usize,
) -> Result<(Scene, LoadTimes), LoadError> {
    Workers::new(threads, true).load(|run| load_with(path, options, run))
}

/// [`cullet_scene::load_glb_bytes`] on `threads` threads, 0 for one per core.
pub fn load_glb_bytes(
    bytes: Vec<u8>,
    name: &str,
    options: &LoadOptions,
    threads: usize,
) -> Result<(Scene, LoadTimes), LoadError> {
    Workers::new(threads, false).load(|run| load_glb_bytes_with(bytes, name, options, run))
}

/// [`load_glb_bytes`] as [`load_to_draw`] has it.
pub fn load_glb_bytes_to_draw(
    bytes: Vec<u8>,
    name: &str,
    options: &LoadOptions,
    threads: usize,
) -> Result<(Scene, LoadTimes), LoadError> {
    Workers::new(threads, true).load(|run| load_glb_bytes_with(bytes, name, options, run))
}

/// Pyramids by their gist: comparing each with all others would take long where there are many.
type Made = BTreeMap<Vec<u16>, Vec<Arc<Mips>>>;

/// Runs tasks and adds up how long they take, in nanoseconds.
struct Workers {
    threads: usize,
    /// The pyramids that have been made; `None` where images keep their pixels.
    made: Option<Mutex<Made>>,
    geometry: AtomicU64,
    images: AtomicU64,
    pyramids: AtomicU64,
}

impl Workers {
    fn new(threads: usize, to_draw: bool) -> Workers {
        let [geometry, images, pyramids] = [const { AtomicU64::new(0) }; 3];
        let made = to_draw.then(Mutex::default);
        Workers { threads: thread_count(threads), made, geometry, images, pyramids }
    }

    fn load(
        self,
        load: impl FnOnce(Run<'_>) -> Result<Scene, LoadError>,
    ) -> Result<(Scene, LoadTimes), LoadError> {
        let scene = load(&|tasks| self.run(tasks))?;
        Ok((scene, self.times()))
    }

    fn run(&self, tasks: Vec<Task<'_>>) {
        for_each(self.threads, tasks.into_iter(), |task| {
            let sum = match task.kind {
                TaskKind::Geometry => &self.geometry,
                TaskKind::Image => &self.images,
            };
            let start = Instant::now();
            let for_pyramids = Cell::new(Duration::ZERO);
            task.run_with(&|image: &mut Image| {
                if let Some(made) = &self.made {
                    let start = Instant::now();
                    derive(image, made);
                    for_pyramids.set(start.elapsed());
                }
            });
            let for_pyramids = for_pyramids.get();
            add(sum, start.elapsed() - for_pyramids);
            add(&self.pyramids, for_pyramids);
        });
    }

    fn times(self) -> LoadTimes {
        let [geometry, images, pyramids] = [self.geometry, self.images, self.pyramids]
            .map(|sum| Duration::from_nanos(sum.into_inner()));
        LoadTimes { geometry, images, pyramids }
    }
}

/// Moves the pixels of an image into a pyramid, which takes their place. Equal ones, of files of different bytes
/// perhaps, are one.
fn derive(image: &mut Image, made: &Mutex<Made>) {
    let Image { width, height, .. } = *image;
    let rgba = std::mem::take(&mut image.rgba);
    let pyramid = Arc::new(Mips::new(Image { width, height, rgba, ..Image::default() }));
    let gist = pyramid.gist().to_vec();
    let mut made = made.lock().unwrap_or_else(PoisonError::into_inner);
    let alike = made.entry(gist).or_default();
    let pyramid = match alike.iter().find(|known| **known == pyramid) {
        Some(known) => Arc::clone(known),
        None => {
            alike.push(Arc::clone(&pyramid));
            pyramid
        }
    };
    image.derived = Some(Derived::new(pyramid));
}

fn add(sum: &AtomicU64, took: Duration) {
    sum.fetch_add(took.as_nanos() as u64, Ordering::Relaxed);
}

#[cfg(test)]
mod tests {
    use cullet_scene::synth::synth;
    use cullet_scene::write_glb;

    use super::*;
    use crate::PrepareError;
    use crate::preparing::make;

    #[test]
    fn threads_do_not_show() {
        let bytes = write_glb(&synth("showpiece").unwrap()).unwrap();
        let damaged = |at: usize| {
            let mut bytes = bytes.clone();
            bytes[at] ^= 0x55;
            bytes
        };
        // The images are behind the geometry.
        let files = [bytes.clone(), damaged(bytes.len() - 99), damaged(bytes.len() / 2)];
        for bytes in files {
            let load = |threads| {
                load_glb_bytes(bytes.clone(), "t.glb", &LoadOptions::default(), threads)
                    .map(|(scene, _)| scene)
                    .map_err(|error| error.to_string())
            };
            let plain = load(1);
            let one = format!("{plain:?}");
            for threads in [2, 5, 0] {
                assert!(format!("{:?}", load(threads)) == one, "{threads}");
            }
            let options = LoadOptions::default();
            match (load_glb_bytes_to_draw(bytes.clone(), "t.glb", &options, 2), plain) {
                (Ok((mut to_draw, _)), Ok(mut plain)) => {
                    assert_eq!(to_draw.warnings, plain.warnings);
                    let [to_draw, plain] = [make(&mut to_draw, 1), make(&mut plain, 1)];
                    for (a, b) in to_draw.textures.iter().zip(&plain.textures) {
                        assert!(a.mips == b.mips);
                    }
                }
                (Err(error), Err(plain)) => assert_eq!(error.to_string(), plain),
                _ => panic!("only one can be loaded"),
            }
        }
    }

    #[test]
    fn pyramids_are_those_of_the_pixels() {
        let bytes = write_glb(&synth("showpiece").unwrap()).unwrap();
        let options = LoadOptions::default();
        let (mut plain, times) = load_glb_bytes(bytes.clone(), "t.glb", &options, 1).unwrap();
        assert!(plain.images.iter().all(|image| image.derived.is_none() && !image.rgba.is_empty()));
        assert_eq!(times.pyramids, Duration::ZERO);
        let plain = make(&mut plain, 1);
        for threads in [1, 2, 5] {
            let (mut scene, _) =
                load_glb_bytes_to_draw(bytes.clone(), "t.glb", &options, threads).unwrap();
            let is_moved = |image: &Image| image.derived.is_some() && image.rgba.is_empty();
            assert!(!scene.images.is_empty() && scene.images.iter().all(is_moved));
            // What is made of a copy is made for the scene as well.
            for made in [make(&mut scene.clone(), threads), make(&mut scene, threads)] {
                assert_eq!(made.textures.len(), plain.textures.len());
                for (made, plain) in made.textures.iter().zip(&plain.textures) {
                    assert!(made.mips.levels().eq(plain.mips.levels()), "{threads} threads");
                }
            }
        }
    }

    #[test]
    fn equal_pixels_become_one_pyramid() {
        let made = Mutex::default();
        let derived = |grey: u8, last: u8, width, height| {
            let mut rgba = vec![grey; 4 * (width * height) as usize];
            *rgba.last_mut().unwrap() = last;
            let mut image = Image { width, height, rgba, ..Image::default() };
            derive(&mut image, &made);
            image.derived.unwrap().get::<Mips>().unwrap()
        };
        let first = derived(7, 7, 3, 2);
        assert!(Arc::ptr_eq(&first, &derived(7, 7, 3, 2)));
        for other in [derived(8, 7, 3, 2), derived(7, 7, 2, 3), derived(7, 8, 3, 2)] {
            assert!(!Arc::ptr_eq(&first, &other));
        }
        // So little that the small levels do not show it.
        let [one, other] = [7, 8].map(|last| derived(7, last, 512, 512));
        assert!(one.gist() == other.gist() && !Arc::ptr_eq(&one, &other));
    }

    #[test]
    fn pixels_that_cannot_be_found_are_an_error() {
        let mut scene = synth("showpiece").unwrap();
        scene.images.iter_mut().for_each(|image| image.derived = Some(Derived::new(Arc::new(7))));
        assert!(crate::Prepared::new(scene.clone()).is_ok(), "the pixels are still there");
        let image = &mut scene.images[scene.textures[0].image];
        image.rgba.clear();
        let error = PrepareError::NoPixels { scene: scene.name.clone(), image: image.name.clone() };
        assert_eq!(crate::Prepared::new(scene).unwrap_err(), error);
    }
}
