//! Can it be seen? Boxes, spheres, planes, frusta, rays, and the tests between them.
//!
//! Pure functions over plain f64 values; nothing here knows what a mesh or a pixel is.
//! Handedness, the look direction and the order of the planes are those of the convention
//! table in `cullet_transform`.
//!
//! ```
//! use cullet_cull::{Aabb, Frustum, Test, Visibility, classify, visible};
//! use cullet_transform::{Camera, Projection};
//! use glam::DVec3;
//!
//! let lens = Projection::Perspective { yfov: 1.0, near: 0.1, far: f64::INFINITY };
//! let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, lens)?;
//! let frustum = Frustum::from_camera(&camera, 16.0 / 9.0);
//! let house = Aabb { min: DVec3::new(-3.0, -1.0, -20.0), max: DVec3::new(3.0, 5.0, -14.0) };
//! assert!(visible(Test::PVertex, &frustum, &house));
//! assert_eq!(classify(&frustum, &house), Visibility::Inside);
//! # Ok::<(), cullet_transform::CameraError>(())
//! ```
//!
//! # Where to start
//!
//! | question | answer |
//! | --- | --- |
//! | what does the camera see? | [`Frustum::from_camera`], or [`Frustum::from_matrix`] of any matrix |
//! | may this box be visible? | [`visible`], by any [`Test`]; [`planes_cutting`] also says what to clip |
//! | exactly? | [`Sat`], [`classify`] |
//! | several tests, counted? | [`Ladder`], [`CullStats`] |
//! | many boxes? | [`wide::Boxes8`] for a list, [`wide::Coarse8`] for a long one, [`Hierarchy`] for a world |
//! | which lights matter where? | [`light_visible`], [`Clusters`] |
//! | too small to matter? | [`projected_size_px`] |
//! | how large is a mesh that moves? | [`bounds`] |
//! | which test pays? | [`distributions`] |
//!
//! # What every visibility test here promises
//!
//! - Sets are closed: touching is visible.
//! - A test may keep what is hidden, it never drops what exact arithmetic calls visible.
//!   What it keeps too much by rounding is at most [`ROUNDING`] of the terms it added up; a little
//!   more by the reverse test, see [`Frustum::bounds`].
//! - A box with a NaN is kept by every test, so bad data is seen rather than lost; a box
//!   with some `min > max` (and no NaN) is empty and is never visible.
//! - Infinite extents are legal, and `0 * inf` counts as 0: a plane parallel to an axis
//!   does not care how far a box reaches along it.
//!
//! # Without std
//!
//! With default features off, core and alloc are enough, here and in all dependencies. Only
//! [`wide::levels`] and `Level::new()`, which ask the machine what it can, are missing then:
//! the caller passes a level, `Level::baseline()` if nothing is known.

#![cfg_attr(not(any(feature = "std", test)), no_std)]

extern crate alloc;

mod aabb;
mod apex;
mod contribution;
mod corners;
mod frustum;
mod halfspace;
mod hierarchy;
mod implied;
mod ladder;
mod lights;
mod matrix;
mod number;
mod p_vertex;
mod plane;
mod ray;
mod ray_aabb;
mod ray_triangle;
mod reverse;
mod rounding;
mod sat;
mod sphere;
mod verdict;

pub mod bounds;
pub mod distributions;
pub mod wide;

pub use aabb::Aabb;
pub use contribution::{projected_size_px, projected_sphere_size_px};
pub use corners::corners_visible;
pub use cullet_transform::PlaneMask;
pub use frustum::Frustum;
pub use hierarchy::{
    Cone, Counts, Fault, Hierarchy, Join, MAX_FRUSTA, MAX_LEVELS, NodeBox, Overlap, Quality,
    WalkStats, overlap_box, overlap_cone, overlap_sphere,
};
pub use ladder::{Count, CullStats, InOut, Ladder, Test, Visibility, classify, visible};
pub use lights::{ClusterLights, Clusters, LightRange, light_visible, slice_depths};
pub use matrix::{DepthRange, FrustumError};
pub use p_vertex::{p_vertex_visible, planes_cutting, planes_cutting_coherent};
pub use plane::Plane;
pub use ray::Ray;
pub use ray_aabb::ray_aabb;
pub use ray_triangle::{TriangleHit, ray_triangle};
pub use reverse::reverse_visible;
pub use rounding::ROUNDING;
pub use sat::Sat;
pub use sphere::{Sphere, sphere_visible};
pub use verdict::{Fate, Verdict};
