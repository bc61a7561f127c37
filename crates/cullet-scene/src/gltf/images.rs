//! What pixels do the base colours need?
//!
//! One that cannot be shown becomes a visible checkerboard with a warning. Which images are needed
//! is known for sure only when all geometry is there; what the document promises is decoded while
//! the geometry is read, and counts if the promise was kept.

use std::borrow::Cow;

use super::accessor::view_bytes;
use super::nodes::Visit;
use super::{Input, Output, materials, primitive};
use crate::images::{Decoded, Encoded, Failure, decode_all, placeholder};
use crate::tasks::Task;
use crate::{Image, Images as Which, LoadError};

/// The images that objects are going to use.
pub(super) struct Images<'a> {
    /// Which of the images in the file, increasing.
    wanted: Vec<usize>,
    /// Of each of them: the file, or what is wrong with it. Or why the load must stop.
    opened: Result<Vec<Result<Encoded<'a>, Failure>>, LoadError>,
}

impl<'a> Images<'a> {
    /// Reads the files that will be used if all primitives can be.
    pub fn expected(input: &Input<'a>, visits: &[Visit], output: &Output) -> Images<'a> {
        let root = &input.document.root;
        let mut used = vec![false; output.scene.materials.len()];
        for visit in visits.iter().filter(|visit| visit.visible) {
            let mesh = root.nodes[visit.file_index].mesh;
            for json in mesh.iter().flat_map(|mesh| &root.meshes[mesh.value()].primitives) {
                used[materials::index(json)] |= primitive::is_made_of_triangles(json);
            }
        }
        Images::open(input, wanted(input.options.images, output, &used), output)
    }

    fn open(input: &Input<'a>, wanted: Vec<usize>, output: &Output) -> Images<'a> {
        let mut pixels_left = input.options.max_image_pixels;
        let open = |&i: &usize| match read(input, i) {
            Ok(bytes) => match Encoded::open(bytes, &mut pixels_left) {
                Err(Failure::TooBig) => Err(too_big(input, &place(output, i))),
                opened => Ok(opened),
            },
            Err(error @ LoadError::Limit { .. }) => Err(error),
            Err(error) => Ok(Err(Failure::Damaged(error.to_string()))),
        };
        let opened = wanted.iter().map(open).collect();
        Images { wanted, opened }
    }

    /// Decodes them while `meanwhile` runs.
    pub fn decode<'t>(&'t self, input: &Input<'_>, meanwhile: Option<Task<'t>>) -> Vec<Decoded> {
        let opened = self.opened.as_ref().map_or(&[][..], Vec::as_slice);
        decode_all(opened, input.run, meanwhile)
    }

    /// Puts the decoded images into the scene, with its objects complete.
    pub fn finish(
        self,
        input: &Input<'a>,
        decoded: Vec<Decoded>,
        n_file_bytes_before: u64,
        output: &mut Output,
    ) -> Result<(), LoadError> {
        let mut used = vec![false; output.scene.materials.len()];
        for object in &output.scene.objects {
            used[object.material] = true;
        }
        materials::warn_about_blending(output, &used);
        materials::leave_out_other_textures(input, output, &used);
        if input.options.images == Which::Masks {
            let n_all = wanted(Which::BaseColors, output, &used).len();
            for _ in wanted(Which::Masks, output, &used).len()..n_all {
                output.leave_out("images that the passes do not show");
            }
        }
        let wanted = wanted(input.options.images, output, &used);
        if wanted != self.wanted {
            // Something cannot be drawn after all, and what it would have used must count for
            // nothing. Rare, so simply done again.
            input.files.set_used(n_file_bytes_before);
            let images = Images::open(input, wanted, output);
            let decoded = images.decode(input, None);
            return images.place(decoded, output);
        }
        self.place(decoded, output)
    }

    fn place(self, decoded: Vec<Decoded>, output: &mut Output) -> Result<(), LoadError> {
        self.opened?;
        for (i, decoded) in self.wanted.into_iter().zip(decoded) {
            let image = decoded.unwrap_or_else(|failure| {
                let problem = match failure {
                    Failure::Damaged(problem) => problem,
                    Failure::TooBig => unreachable!("stops the load when the file is opened"),
                };
                let place = place(output, i);
                output.warn(&place, format_args!("{problem}; a checkerboard is shown instead"));
                placeholder()
            });
            let name = std::mem::take(&mut output.scene.images[i].name);
            output.scene.images[i] = Image { name, ..image };
        }
        Ok(())
    }
}

/// The images that the used materials need.
fn wanted(which: Which, output: &Output, used_materials: &[bool]) -> Vec<usize> {
    let mut used = vec![false; output.scene.images.len()];
    let materials = output.scene.materials.iter().zip(used_materials);
    for (material, _) in materials.filter(|pair| *pair.1 && which.wants(pair.0)) {
        if let Some(texture) = &material.base_color_texture {
            used[output.scene.textures[texture.texture].image] = true;
        }
    }
    (0..used.len()).filter(|&i| used[i]).collect()
}

fn place(output: &Output, image: usize) -> String {
    format!("image `{}`", output.scene.images[image].name)
}

fn read<'a>(input: &Input<'a>, image: usize) -> Result<Cow<'a, [u8]>, LoadError> {
    let json = &input.document.root.images[image];
    let damaged =
        |problem: String| LoadError::invalid(input.name, "", problem, "export the model again");
    match (json.buffer_view, &json.uri) {
        (Some(view), _) => view_bytes(&input.document.root, input.buffers, view)
            .map(Cow::Borrowed)
            .map_err(damaged),
        (None, Some(uri)) => input.files.read(uri).map(Cow::Owned),
        (None, None) => Err(damaged("has neither a file nor a buffer view".into())),
    }
}

fn too_big(input: &Input<'_>, place: &str) -> LoadError {
    LoadError::Limit {
        path: input.name.to_string(),
        what: format!("the number of pixels up to {place}"),
        limit: input.options.max_image_pixels,
        option: "--max-image-pixels",
    }
}
