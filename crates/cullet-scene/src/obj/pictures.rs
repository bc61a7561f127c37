//! The images that materials name: each is read once.

use std::collections::BTreeMap;

use crate::files::Root;
use crate::gltf::images::{Failure, decode_one, placeholder};
use crate::{Image, LoadError, LoadOptions, Sampler, Texture};

use super::notes::Notes;

/// The images and textures of a scene as they are found.
pub(super) struct Pictures<'a> {
    files: &'a Root,
    options: &'a LoadOptions,
    pixels_left: u64,
    pub images: Vec<Image>,
    pub textures: Vec<Texture>,
    idx_of_path: BTreeMap<String, usize>,
    /// Parallel to `images`: the few ways in which each is sampled.
    textures_of_image: Vec<Vec<usize>>,
}

impl<'a> Pictures<'a> {
    pub fn new(files: &'a Root, options: &'a LoadOptions) -> Pictures<'a> {
        let pixels_left = options.max_image_pixels;
        Pictures {
            files,
            options,
            pixels_left,
            images: Vec::new(),
            textures: Vec::new(),
            idx_of_path: BTreeMap::new(),
            textures_of_image: Vec::new(),
        }
    }

    /// The texture of an image that `library` names. One that cannot be read shows the
    /// placeholder.
    pub fn texture(
        &mut self,
        path: &str,
        library: &str,
        sampler: Sampler,
        notes: &mut Notes,
    ) -> Result<usize, LoadError> {
        let image = match self.idx_of_path.get(path) {
            Some(known) => *known,
            None => {
                let image = self.read(path, library, notes)?;
                self.images.push(Image { name: path.into(), ..image });
                self.textures_of_image.push(Vec::new());
                self.idx_of_path.insert(path.into(), self.images.len() - 1);
                self.images.len() - 1
            }
        };
        let known = &mut self.textures_of_image[image];
        if let Some(same) = known.iter().find(|&&known| self.textures[known].sampler == sampler) {
            return Ok(*same);
        }
        known.push(self.textures.len());
        self.textures.push(Texture { image, sampler });
        Ok(self.textures.len() - 1)
    }

    fn read(&mut self, path: &str, library: &str, notes: &mut Notes) -> Result<Image, LoadError> {
        if !self.options.textures {
            return Ok(Image::default());
        }
        let problem = match self.read_bytes(path, library) {
            Err(error @ LoadError::Limit { .. }) => return Err(error),
            Err(error) => error.to_string(),
            Ok(bytes) => match decode_one(&bytes, &mut self.pixels_left) {
                Ok(image) => return Ok(image),
                Err(Failure::Damaged(problem)) => format!("{path}: {problem}"),
                Err(Failure::TooBig) => {
                    return Err(LoadError::Limit {
                        path: path.into(),
                        what: "the number of pixels up to this image".into(),
                        limit: self.options.max_image_pixels,
                        option: "--max-image-pixels",
                    });
                }
            },
        };
        notes.warn_each(format!("texture {problem}; a checkerboard is shown instead"));
        Ok(placeholder())
    }

    /// Looks beside the library, then beside the scene, then for the bare file name there:
    /// many exporters write the path that the image had on their machine.
    fn read_bytes(&self, path: &str, library: &str) -> Result<Vec<u8>, LoadError> {
        let slashed = library.replace('\\', "/");
        let folder = slashed.rsplit_once('/').map(|(folder, _)| format!("{folder}/{path}"));
        let bare = path.rsplit(['/', '\\']).next().unwrap_or(path);
        let first = self.files.read_path(folder.as_deref().unwrap_or(path));
        let read = [path, bare].into_iter().fold(first, |read, name| match read {
            Err(LoadError::Read { .. } | LoadError::Invalid { .. }) => self.files.read_path(name),
            read => read,
        });
        // The error should name the path as it is written.
        match read {
            Err(LoadError::Read { source, .. }) => {
                Err(LoadError::Read { path: path.into(), source })
            }
            read => read,
        }
    }
}
