//! Where is it? The spaces of a frame, cameras, viewports, and the matrices between them.
//!
//! # The convention table
//!
//! Everything else in Cullet refers to this table and to no other.
//!
//! | question | answer |
//! | --- | --- |
//! | handedness | right-handed, y up, in model, world and view space |
//! | view space | the eye is the origin, x right, y up, the camera looks down **-z** |
//! | clip space | inside: `-w <= x <= w`, `-w <= y <= w`, `0 <= z <= w`; `w` is the distance along the view axis (perspective) or 1 (orthographic) |
//! | depth (`z / w`) | **reversed**: 1 at the near plane, 0 at the far plane or at infinity |
//! | far plane | infinite unless the camera says otherwise |
//! | ndc | x right and y up in -1..1, z = depth |
//! | screen space | pixels, x right, **y down**, origin at the top left corner of the picture |
//! | pixel centres | at one half: pixel (0, 0) is sampled at (0.5, 0.5) |
//! | front faces | counter-clockwise as seen (y up) |
//! | matrices | column vectors, named target first: `clip_from_view * view_from_world` |
//! | angles | radians |
//!
//! # Precision
//!
//! Every matrix of a frame is composed in f64, with the eye subtracted from the translation
//! of a node before anything else, so a scene far from the origin keeps its precision.
//! Points stay f64 up to the snap to fixed point: the error of a screen position is then
//! far below the 2^-10 px that the rasterizer promises, whatever the field of view.
//! Trigonometry comes from the `libm` crate, so the same camera gives the same bits on
//! every machine.

#![cfg_attr(not(any(feature = "std", test)), no_std)]

extern crate alloc;

mod camera;
mod planes;
mod sincos;
mod spaces;
mod view;
mod viewport;

pub mod reference;

pub use camera::{Camera, CameraError, Kind, Projection, Window};
pub use planes::{Plane, PlaneMask};
pub use sincos::{SinCos, SinCosTable};
pub use spaces::{ClipPoint, NdcPoint, ScreenPoint};
pub use view::View;
pub use viewport::{MAX_SIDE, Viewport, ViewportError};
