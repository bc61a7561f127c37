//! Loading on several cores: images are decoded while geometry is read.

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use cullet_scene::{LoadError, LoadOptions, Scene, Task, TaskKind, load_glb_bytes_with, load_with};

use crate::schedule::{for_each, thread_count};

/// Time that parts of loading took, all threads together: parts overlap, so the sum may be more
/// than the wall time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LoadTimes {
    /// Vertices and triangles of glTF files.
    pub geometry: Duration,
    /// Pixels of images.
    pub images: Duration,
}

/// [`cullet_scene::load`] on `threads` threads, 0 for one per core. The scene, its warnings and
/// errors are the same for every number of threads.
pub fn load(
    path: &Path,
    options: &LoadOptions,
    threads: usize,
) -> Result<(Scene, LoadTimes), LoadError> {
    let clock = Clock::new(threads);
    let scene = load_with(path, options, &|tasks| clock.run(tasks))?;
    Ok((scene, clock.times()))
}

/// [`cullet_scene::load_glb_bytes`] on `threads` threads, 0 for one per core.
pub fn load_glb_bytes(
    bytes: Vec<u8>,
    name: &str,
    options: &LoadOptions,
    threads: usize,
) -> Result<(Scene, LoadTimes), LoadError> {
    let clock = Clock::new(threads);
    let scene = load_glb_bytes_with(bytes, name, options, &|tasks| clock.run(tasks))?;
    Ok((scene, clock.times()))
}

/// Runs tasks and adds up how long they take, in nanoseconds.
struct Clock {
    threads: usize,
    geometry: AtomicU64,
    images: AtomicU64,
}

impl Clock {
    fn new(threads: usize) -> Clock {
        let threads = thread_count(threads);
        Clock { threads, geometry: AtomicU64::new(0), images: AtomicU64::new(0) }
    }

    fn run(&self, tasks: Vec<Task<'_>>) {
        for_each(self.threads, tasks.into_iter(), |task| {
            let sum = match task.kind {
                TaskKind::Geometry => &self.geometry,
                TaskKind::Image => &self.images,
            };
            let start = Instant::now();
            task.run();
            sum.fetch_add(start.elapsed().as_nanos() as u64, Ordering::Relaxed);
        });
    }

    fn times(self) -> LoadTimes {
        let [geometry, images] =
            [self.geometry, self.images].map(|sum| Duration::from_nanos(sum.into_inner()));
        LoadTimes { geometry, images }
    }
}

#[cfg(test)]
mod tests {
    use cullet_scene::synth::synth;
    use cullet_scene::write_glb;

    use super::*;

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
            let one = format!("{:?}", load(1));
            for threads in [2, 5, 0] {
                assert!(format!("{:?}", load(threads)) == one, "{threads}");
            }
        }
    }
}
