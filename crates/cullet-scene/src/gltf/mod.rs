//! glTF 2.0: from bytes to a [`Scene`].
//!
//! ```text
//! container -> document -> buffers -> materials -> nodes -+-> objects -+-> scene
//!                                                         |      |     |
//!                                                         |  primitive (accessor), pose, instances
//!                                                         |            |
//!                                                         +-> images --+
//! ```
//!
//! What cannot be drawn stops the load; what can be drawn without a damaged part is drawn,
//! with a warning that names the part.

mod accessor;
mod buffers;
mod container;
mod document;
mod extensions;
mod images;
mod instances;
mod materials;
mod nodes;
mod objects;
mod pose;
mod primitive;

use std::borrow::Cow;
use std::collections::BTreeMap;

use self::document::Document;
use self::images::Images;
use crate::files::Root;
use crate::tasks::{Run, Task, TaskKind};
use crate::{LoadError, LoadOptions, Material, Scene};

/// Loads a glTF scene, binary or text; `name` is for messages, `files` reads what it names.
pub(crate) fn load(
    bytes: &[u8],
    name: &str,
    files: &Root,
    options: &LoadOptions,
    run: Run<'_>,
) -> Result<Scene, LoadError> {
    let document = document::read(bytes, name)?;
    let buffers = buffers::read(&document, name, files)?;
    let input = Input { name, options, files, run, document: &document, buffers: &buffers };
    let mut output = Output::new(&input);
    materials::load(&input, &mut output);
    let visits = nodes::walk(&input, &mut output)?;

    let n_file_bytes = files.used();
    let images = Images::expected(&input, &visits, &output);
    let mut loaded = Ok(());
    let geometry = Task::new(TaskKind::Geometry, || {
        loaded = objects::load(&input, &visits, &mut output);
    });
    let decoded = images.decode(&input, Some(geometry));
    loaded?;
    images.finish(&input, decoded, n_file_bytes, &mut output)?;
    output.finish(name)
}

/// What a load starts from.
struct Input<'a> {
    name: &'a str,
    options: &'a LoadOptions,
    files: &'a Root,
    run: Run<'a>,
    document: &'a Document<'a>,
    buffers: &'a [Cow<'a, [u8]>],
}

/// What a load has so far.
struct Output {
    scene: Scene,
    /// Phrases without their number, and how often each was said.
    left_out: BTreeMap<String, usize>,
    /// The first primitive that was left out for being damaged.
    first_damage: Option<String>,
    n_triangles: u64,
    n_decoded_bytes: u64,
}

impl Output {
    fn new(input: &Input<'_>) -> Output {
        let scene = Scene {
            name: input.name.to_string(),
            materials: vec![Material::default()],
            extensions: input.document.extensions.clone(),
            animations: input.document.animations.clone(),
            ..Scene::default()
        };
        Output {
            scene,
            left_out: BTreeMap::new(),
            first_damage: None,
            n_triangles: 0,
            n_decoded_bytes: 0,
        }
    }

    /// Something at `place` was mended as the second half of `what` says.
    fn warn(&mut self, place: &str, what: impl std::fmt::Display) {
        self.scene.warnings.push(format!("{}: {place}: {what}", self.scene.name));
    }

    /// Something drawable at `place` is not drawn because it is damaged.
    fn lose(&mut self, place: &str, problem: &str) {
        self.warn(place, format_args!("{problem}; left out"));
        self.first_damage.get_or_insert_with(|| format!("{place}: {problem}"));
    }

    /// Something that cannot be drawn yet is left out; `what` is a plural without number.
    fn leave_out(&mut self, what: &str) {
        *self.left_out.entry(what.to_string()).or_default() += 1;
    }

    /// Counts `n` values that are about to be decoded, of type `T`. What a file claims may be
    /// far more than it holds, so this comes before memory is taken or time spent.
    fn count_decoded<T>(&mut self, input: &Input<'_>, n: u64) -> Result<(), LoadError> {
        let limit = input.options.max_decoded_bytes;
        let n_bytes = n.saturating_mul(size_of::<T>() as u64);
        self.n_decoded_bytes = self.n_decoded_bytes.saturating_add(n_bytes);
        if self.n_decoded_bytes <= limit {
            return Ok(());
        }
        Err(LoadError::Limit {
            path: input.name.to_string(),
            what: "the size of the decoded geometry in bytes".into(),
            limit,
            option: "--max-decoded-bytes",
        })
    }

    fn finish(mut self, name: &str) -> Result<Scene, LoadError> {
        if self.scene.objects.is_empty()
            && let Some(damage) = self.first_damage
        {
            let problem = format!("nothing can be drawn: {damage}");
            return Err(LoadError::invalid(name, "", problem, "export the model again"));
        }
        self.scene.left_out =
            self.left_out.iter().map(|(what, n)| format!("{what}: {n}")).collect();
        Ok(self.scene)
    }
}

/// A name for messages: as in the file, or made up from kind and index.
fn name_or(name: &Option<String>, kind: &str, index: usize) -> String {
    match name {
        Some(name) if !name.is_empty() => name.clone(),
        _ => format!("{kind} {index}"),
    }
}
