//! Where a scene comes from: a file, standard input, or a formula.

use std::io::{Read, stdin};
use std::path::{Path, PathBuf};

use clap::Args;
use cullet::scene::synth::{NAMES, synth};
use cullet::scene::{Images, LoadOptions, Scene};
use cullet::{LoadTimes, load, load_glb_bytes, load_glb_bytes_to_draw, load_to_draw};

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
    limits: Limits,
}

/// How much a scene may take.
#[derive(Args, Clone, Copy, Debug)]
pub struct Limits {
    /// Limit for the scene file and all files it names together, in bytes
    #[arg(long, value_name = "BYTES", default_value_t = LoadOptions::default().max_file_bytes)]
    #[arg(help_heading = "Limits")]
    max_file_bytes: u64,
    /// Limit for all decoded images together, in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = LoadOptions::default().max_image_pixels)]
    #[arg(help_heading = "Limits")]
    max_image_pixels: u64,
    /// Limit for visited nodes plus the objects made from them
    #[arg(long, value_name = "COUNT", default_value_t = LoadOptions::default().max_nodes)]
    #[arg(help_heading = "Limits")]
    max_nodes: usize,
    /// Limit for the triangles of all meshes, each mesh counted once
    #[arg(long, value_name = "COUNT", default_value_t = LoadOptions::default().max_triangles)]
    #[arg(help_heading = "Limits")]
    max_triangles: u64,
    /// Limit for the geometry that is decoded from glTF, in bytes
    #[arg(long, value_name = "BYTES", default_value_t = LoadOptions::default().max_decoded_bytes)]
    #[arg(help_heading = "Limits")]
    max_decoded_bytes: u64,
}

impl Limits {
    /// As the loader takes them.
    fn options(&self) -> LoadOptions {
        LoadOptions {
            max_file_bytes: self.max_file_bytes,
            max_image_pixels: self.max_image_pixels,
            max_nodes: self.max_nodes,
            max_triangles: self.max_triangles,
            max_decoded_bytes: self.max_decoded_bytes,
            ..LoadOptions::default()
        }
    }
}

impl Source {
    /// A scene under `limits`.
    pub fn new(path: PathBuf, limits: Limits) -> Source {
        Source { path, limits }
    }

    /// The limits as the loader takes them.
    pub fn limits(&self) -> LoadOptions {
        self.limits.options()
    }

    /// Loads or computes the scene, on `threads` threads (0: one per core); says what took how long.
    pub fn load(&self, threads: usize, images: Images) -> Result<(Scene, LoadTimes), Failure> {
        self.load_for(threads, images, false)
    }

    /// [`Source::load`] where the scene is to be drawn, see [`cullet::load_to_draw`].
    pub fn load_to_draw(
        &self,
        threads: usize,
        images: Images,
    ) -> Result<(Scene, LoadTimes), Failure> {
        self.load_for(threads, images, true)
    }

    fn load_for(
        &self,
        threads: usize,
        images: Images,
        to_draw: bool,
    ) -> Result<(Scene, LoadTimes), Failure> {
        let _progress = Progress::show("loading");
        let options = &LoadOptions { images, ..self.limits() };
        if self.path == Path::new("-") {
            // One byte more than allowed is enough to know that it is too much.
            let mut bytes = Vec::new();
            let mut input = stdin().lock().take(options.max_file_bytes.saturating_add(1));
            let read = input.read_to_end(&mut bytes);
            read.map_err(|error| Failure::input(format!("standard input: {error}")))?;
            let load = if to_draw { load_glb_bytes_to_draw } else { load_glb_bytes };
            return Ok(load(bytes, "standard input", options, threads)?);
        }
        let path = self.path.to_str().unwrap_or_default();
        if let Some(spec) = path.strip_prefix("synth:") {
            return Ok((synth(spec).map_err(Failure::usage)?, LoadTimes::default()));
        }
        let load = if to_draw { load_to_draw } else { load };
        load(&self.path, options, threads).map_err(|error| {
            let mut failure = Failure::from(error);
            if is_name(path) && !self.path.exists() {
                failure.message += &format!("; did you mean synth:{path}?");
            }
            failure
        })
    }
}

/// Whether `synth:` may have been left out before this.
fn is_name(path: &str) -> bool {
    let name = path.split(':').next().unwrap_or_default();
    name == "extreme" || NAMES.iter().any(|(known, _)| *known == name)
}
