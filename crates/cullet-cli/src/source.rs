//! Where a scene comes from: a file, standard input, or a formula.

use std::io::{Read, stdin};
use std::path::{Path, PathBuf};

use clap::Args;
use cullet::scene::synth::synth;
use cullet::scene::{Images, LoadOptions, Scene};
use cullet::{LoadTimes, load, load_glb_bytes};

use crate::exit::Failure;
use crate::message::Progress;

/// The scene and how much of the machine it may use.
#[derive(Args, Clone, Debug)]
pub struct Source {
    /// A .glb, .gltf or .obj file; `-` reads a .glb from standard input; `synth:NAME[:PARAMETER]`
    /// computes a scene (`cullet synth --list` names them)
    #[arg(value_name = "SCENE")]
    pub path: PathBuf,
    #[command(flatten)]
    pub limits: LoadOptions,
}

impl Source {
    /// Loads or computes the scene, on `threads` threads (0: one per core); says what took how long.
    pub fn load(&self, threads: usize, images: Images) -> Result<(Scene, LoadTimes), Failure> {
        let _progress = Progress::show("loading");
        let options = &LoadOptions { images, ..self.limits.clone() };
        if self.path == Path::new("-") {
            // One byte more than allowed is enough to know that it is too much.
            let mut bytes = Vec::new();
            let mut input = stdin().lock().take(options.max_file_bytes.saturating_add(1));
            let read = input.read_to_end(&mut bytes);
            read.map_err(|error| Failure::input(format!("standard input: {error}")))?;
            return Ok(load_glb_bytes(bytes, "standard input", options, threads)?);
        }
        match self.path.to_str().and_then(|path| path.strip_prefix("synth:")) {
            Some(spec) => Ok((synth(spec).map_err(Failure::usage)?, LoadTimes::default())),
            None => Ok(load(&self.path, options, threads)?),
        }
    }
}
