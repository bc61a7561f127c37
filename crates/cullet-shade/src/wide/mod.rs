//! Eight or sixteen pixels at a time, each of a triangle of its own.
//!
//! 1. [`set_up`] makes a [`Record`] of each triangle: planes over the picture of all that its
//!    colour depends on.
//! 2. [`paint`] takes [`Run`]s of pixels that show one [`Paint`], a group of pixels at a time: it reads their attributes
//!    off the records, samples, lights, and hands colours on, as bytes or as they are.
//!
//! Values are f32, in planes near their pixels; the few pixels for which that is not good enough
//! are handed back, to be asked of the plain code ([`crate::shade`]). A pixel's colour
//! depends on nothing but itself, its triangle and the block of the picture that it lies in
//! ([`cullet_raster::BLOCK`]): not on which pixels share a group, nor on the instruction set.

#[cfg(target_arch = "x86_64")]
mod blend512;
mod codes;
mod column;
mod cutout;
mod fixed;
mod paint;
mod point;
mod record;
mod run;
mod sampler;
#[cfg(test)]
mod tests;
mod turn;

pub use codes::encode_all;
pub(crate) use column::Lanes;
#[cfg(test)]
pub(crate) use column::WIDEST;
#[cfg(test)]
pub(crate) use column::wide;
pub use cutout::Cutout;
pub use paint::{Out, Paint, Planes, Scratch, paint};
pub use point::PointPlanes;
pub use record::{ColorPlanes, Group, Record, set_up};
pub use run::Run;
