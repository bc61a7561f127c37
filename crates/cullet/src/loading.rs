//! Loading on several cores: images are decoded while geometry is read.

use std::path::Path;

use cullet_scene::{LoadError, LoadOptions, Scene, load_glb_bytes_with, load_with};

use crate::schedule::{run_tasks, thread_count};

/// [`cullet_scene::load`] on `threads` threads, 0 for one per core. The scene, its warnings and
/// errors are the same for every number of threads.
pub fn load(path: &Path, options: &LoadOptions, threads: usize) -> Result<Scene, LoadError> {
    let threads = thread_count(threads);
    load_with(path, options, &|tasks| run_tasks(threads, tasks))
}

/// [`cullet_scene::load_glb_bytes`] on `threads` threads, 0 for one per core.
pub fn load_glb_bytes(
    bytes: Vec<u8>,
    name: &str,
    options: &LoadOptions,
    threads: usize,
) -> Result<Scene, LoadError> {
    let threads = thread_count(threads);
    load_glb_bytes_with(bytes, name, options, &|tasks| run_tasks(threads, tasks))
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
                    .map_err(|error| error.to_string())
            };
            let one = format!("{:?}", load(1));
            for threads in [2, 5, 0] {
                assert!(format!("{:?}", load(threads)) == one, "{threads}");
            }
        }
    }
}
