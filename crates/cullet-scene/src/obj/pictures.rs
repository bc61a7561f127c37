//! The images that materials name: each is read once, and decoded when all are known.

use std::borrow::Cow;
use std::collections::BTreeMap;

use crate::files::Root;
use crate::images::{Encoded, Failure, decode_all, placeholder};
use crate::tasks::Run;
use crate::{Image, Images, LoadError, LoadOptions, Sampler, Texture};

use super::notes::Notes;

/// The images and textures of a scene as they are found.
pub(super) struct Pictures<'a> {
    files: &'a Root,
    options: &'a LoadOptions,
    pixels_left: u64,
    /// Of each image: its file, what is wrong with that, or `None` when it is not wanted.
    opened: Vec<Option<Result<Encoded<'static>, Failure>>>,
    /// Parallel to `opened`: where among the warnings one about it belongs.
    places: Vec<usize>,
    pub textures: Vec<Texture>,
    idx_of_path: BTreeMap<String, usize>,
    /// Parallel to `opened`: the few ways in which each is sampled.
    textures_of_image: Vec<Vec<usize>>,
}

impl<'a> Pictures<'a> {
    pub fn new(files: &'a Root, options: &'a LoadOptions) -> Pictures<'a> {
        let pixels_left = options.max_image_pixels;
        Pictures {
            files,
            options,
            pixels_left,
            opened: Vec::new(),
            places: Vec::new(),
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
                let image = self.opened.len();
                let opened = self.open(path, library)?;
                self.opened.push(opened);
                self.places.push(notes.n_warnings());
                self.textures_of_image.push(Vec::new());
                self.idx_of_path.insert(path.into(), image);
                image
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

    fn open(
        &mut self,
        path: &str,
        library: &str,
    ) -> Result<Option<Result<Encoded<'static>, Failure>>, LoadError> {
        if self.options.images != Images::BaseColors {
            return Ok(None); // no material here is a mask
        }
        let opened = match self.read_bytes(path, library) {
            Err(error @ LoadError::Limit { .. }) => return Err(error),
            Err(error) => Err(Failure::Damaged(error.to_string())),
            Ok(bytes) => match Encoded::open(Cow::Owned(bytes), &mut self.pixels_left) {
                Err(Failure::Damaged(problem)) => {
                    Err(Failure::Damaged(format!("{path}: {problem}")))
                }
                Err(Failure::TooBig) => {
                    return Err(LoadError::Limit {
                        path: path.into(),
                        what: "the number of pixels up to this image".into(),
                        limit: self.options.max_image_pixels,
                        option: "--max-image-pixels",
                    });
                }
                Ok(encoded) => Ok(encoded),
            },
        };
        Ok(Some(opened))
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

    /// Decodes everything that was opened. Images that cannot be shown are placeholders.
    pub fn decode(self, run: Run<'_>, notes: &mut Notes) -> (Vec<Image>, Vec<Texture>) {
        let n_images = self.opened.len();
        let mut images = vec![Image::default(); n_images];
        for (path, i) in self.idx_of_path {
            images[i].name = path;
        }
        let wanted: Vec<usize> = (0..n_images).filter(|&i| self.opened[i].is_some()).collect();
        let opened: Vec<_> = self.opened.into_iter().flatten().collect();
        let decoded = decode_all(&opened, run, None);
        // The last first, so that the places of the others stay right.
        for ((i, opened), decoded) in wanted.into_iter().zip(&opened).zip(decoded).rev() {
            let name = std::mem::take(&mut images[i].name);
            let image = decoded.unwrap_or_else(|failure| {
                let problem = match (failure, opened) {
                    (Failure::Damaged(problem), Err(_)) => problem,
                    (Failure::Damaged(problem), Ok(_)) => format!("{name}: {problem}"),
                    (Failure::TooBig, _) => unreachable!("stops the load when it is opened"),
                };
                let text = format!("texture {problem}; a checkerboard is shown instead");
                notes.insert(self.places[i], text);
                placeholder()
            });
            images[i] = Image { name, ..image };
        }
        (images, self.textures)
    }
}
