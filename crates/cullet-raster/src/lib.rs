//! Which pixels? Clipping, fixed-point set-up, coverage and depth.
//!
//! The rasterizer knows positions and ids, never materials. Three steps, each its own function:
//!
//! 1. [`set_up`] takes the clip-space corners of an object's triangles, clips the few that need
//!    it, snaps them to fixed point and keeps those that face the right way;
//! 2. [`cover`] writes id and depth of one set-up triangle into the samples it wins;
//! 3. [`Interpolator`] says afterwards where on its triangle a pixel lies, for shading.
//!
//! Integers decide coverage, floats decide colour: after the snap, coverage is exact.
//!
//! **The rule** (Direct3D 11.3 functional specification, 3.4.1 and 3.4.2; the Vulkan
//! specification's rasterization chapter agrees): screen positions are snapped to 1/256 px,
//! halves to even; facing and zero area are decided after snapping; a sample exactly on an edge
//! belongs to the triangle only if that is a top edge (horizontal, above the rest) or a left one.
//! Pixels are sampled at their centres.

mod assembly;
mod blocks;
mod boxes8;
mod clip;
mod cover;
mod depth;
mod depth8;
mod draw;
mod edges8;
mod fill;
mod fixed;
mod fragment;
mod interpolate;
mod level;
mod narrow;
mod patch;
mod piece;
mod placed;
mod plain;
mod precision;
mod prefetch;
mod samples;
mod setup;
mod shares4;
mod small;
mod small_patch;
mod strip;
#[cfg(test)]
mod testing;
mod tile;

pub mod reference;

pub use assembly::{Assembly, Cluster, MAX_TRIANGLES, Object};
pub use cover::{Keep, KeepAll, KeepIf, NO_TRIANGLE, Tile, cover};
pub use depth::{DepthFormat, ReversedF32, StandardF32, StandardU16, StandardU24};
pub use draw::draw;
pub use fill::KeepSample;
pub use fixed::{Fixed, GUARD_BAND, guard_band, snap};
pub use fragment::Fragment;
pub use interpolate::Interpolator;
pub use placed::MAX_VERTICES;
pub use precision::{DepthKind, Precision, SubpixelBits, Transforms};
pub use prefetch::{prefetch, prefetch_all};
pub use samples::{Offset, Samples};
pub use setup::{Facing, Placer, ScreenTriangle, SetupCounters, Triangles, Vertex, set_up};
pub use shares4::{BLOCK, Corners4, Placement, Shares4, shares4};
pub use tile::{TileBuffer, TileRect};
