//! What colour? Samplers, mipmaps and shading kernels.
//!
//! The rasterizer says where a pixel lies on its triangle (a [`Fragment`]); this crate
//! fetches what the material needs there, and no more, and answers with linear RGBA.
//!
//! - [`srgb`]: the exact curve between bytes and linear light; [`Encoding`]: cheaper ways to bytes.
//! - [`texture`]: an image and its smaller copies; [`sampler`]: its colour at a place.
//! - [`needs`]: which data a material asks for; [`kernel`]: one function for each answer.
//! - [`surface`]: normals, positions and texture coordinates, for kernels and passes.
//! - [`division`]: reciprocals and inverse roots without dividing.
//! - [`mod@reference`]: the plain f64 twin by which the rest is judged.
//!
//! Same input, same bytes, on every machine: arithmetic is `+ - * /`, square root and
//! compare-and-select in a written order; transcendental functions come from `libm`, or have
//! their error stated.
//! Nothing here fails once built, and odd input (NaN, infinities, singular matrices,
//! images without pixels) has a stated outcome.
//!
//! [`Fragment`]: cullet_raster::Fragment

pub mod division;
pub mod kernel;
pub mod needs;
pub mod reference;
pub mod sampler;
pub mod srgb;
pub mod surface;
pub mod texture;
pub mod wide;

mod encoding;
mod light;
mod select;
#[cfg(test)]
mod testing;

pub use division::Division;
pub use encoding::Encoding;
pub use fearless_simd::Level as SimdLevel;
pub use kernel::{Look, Triangle, alpha, base_color, shade};
pub use light::{Light, LightError, PointLight};
pub use needs::{Needs, Shading};
pub use sampler::{Arithmetic, Filter, sample, sample_alpha};
pub use surface::{Surface, mirrors, normal_matrix, uv, world_normal, world_position};
pub use texture::{Level, Mips, Texture};
