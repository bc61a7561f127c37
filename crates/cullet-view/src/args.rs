//! The command line of the viewer.

use std::path::PathBuf;

use clap::Parser;
use cullet::scene::synth::synth;
use cullet::scene::{LoadOptions, Scene};
use cullet::{Camera, camera_of, load_to_draw};
use cullet_view::HELP;

use crate::{Failure, INPUT, USAGE};

const AFTER_HELP: &str = "A script holds one step per line: `size W H`, `key NAME` (b c f h p r space home escape \
    0 to 5), `drag RIGHT DOWN`, `pan RIGHT DOWN` (pixels), `wheel STEPS`, `screenshot FILE.png`, \
    `quit`; `#` starts a comment.\n\n\
    Exit codes: 0 done, 2 wrong usage, 3 input unreadable or invalid, 4 the scene requires \
    something unsupported, 5 a limit was reached, 6 no window can be opened or a picture cannot be written";

/// Shows a scene in a window, and what culling does to it.
#[derive(Parser, Debug)]
#[command(name = "cullet-view", version, about, after_help = after_help())]
pub struct Args {
    /// A .glb, .gltf or .obj file; `synth:NAME[:PARAMETER]` computes a scene (`cullet synth
    /// --list` names them)
    pub scene: PathBuf,
    /// Where to start: `auto` shows everything; or an index or name from the file
    #[arg(long, value_name = "SPEC", default_value = "auto")]
    pub camera: String,
    /// Size of the window in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = size)]
    pub size: (u32, u32),
    /// Replay a script instead of opening a window (see below); needs no display
    #[arg(long, value_name = "FILE")]
    pub script: Option<PathBuf>,
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

impl Args {
    /// Loads or computes the scene.
    pub fn load(&self) -> Result<Scene, Failure> {
        let options = LoadOptions {
            max_file_bytes: self.max_file_bytes,
            max_image_pixels: self.max_image_pixels,
            max_nodes: self.max_nodes,
            max_triangles: self.max_triangles,
            max_decoded_bytes: self.max_decoded_bytes,
            ..LoadOptions::default()
        };
        match self.scene.to_str().and_then(|path| path.strip_prefix("synth:")) {
            Some(spec) => synth(spec).map_err(|error| Failure::new(USAGE, error)),
            None => Ok(load_to_draw(&self.scene, &options, 0)?.0),
        }
    }

    /// The camera of the scene that was asked for; `None` means to show everything.
    pub fn camera(&self, scene: &Scene) -> Result<Option<Camera>, Failure> {
        if self.camera == "auto" {
            return Ok(None);
        }
        let by_name = || scene.cameras.iter().find(|camera| camera.name == self.camera);
        let by_index = self.camera.parse().ok().and_then(|i: usize| scene.cameras.get(i));
        let camera = by_index.or_else(by_name).ok_or_else(|| {
            let known = match scene.cameras.len() {
                0 => "the scene has none; leave `--camera` out to see it all".to_owned(),
                n => format!("the scene has {n}, from 0"),
            };
            let what = format!("there is no camera `{}`: {known}", self.camera);
            Failure::new(USAGE, what)
        })?;
        camera_of(camera).map(Some).map_err(|error| Failure::new(INPUT, error))
    }
}

fn after_help() -> String {
    let mut text = String::from("In the window:\n");
    for (key, what) in HELP {
        text += &format!("  {key:<12}{what}\n");
    }
    text + "\n" + AFTER_HELP
}

fn size(text: &str) -> Result<(u32, u32), String> {
    let sides = text.split_once(['x', 'X']);
    let sides = sides.and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    match sides {
        Some((width, height)) if width > 0 && height > 0 => Ok((width, height)),
        _ => Err("give width x height in pixels, both at least 1, like 1280x720".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes() {
        assert_eq!(size("640x480"), Ok((640, 480)));
        for text in ["", "640", "0x1", "1x0", "-1x5", "1.5x2", "4294967296x1"] {
            assert!(size(text).is_err(), "{text}");
        }
    }
}
