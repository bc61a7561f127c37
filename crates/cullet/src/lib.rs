//! A software rasterizer: one prepared scene and one view in, one frame out.
//!
//! ```
//! use cullet::{Frame, Prepared, Renderer, Settings, View, Viewport, frame_scene, scene};
//!
//! let scene = scene::synth::synth("sphere:16")?;
//! let prepared = Prepared::new(scene)?;
//! let viewport = Viewport::new(64, 48)?;
//! let view = View::new(&frame_scene(&prepared, viewport.aspect()), viewport);
//! let mut frame = Frame::default();
//! let stats = Renderer::default().render(&prepared, &view, &Settings::default(), &mut frame);
//! assert_eq!(frame.rgba8.len(), 64 * 48);
//! assert!(stats.pixels_shaded > 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A frame is a function from values to values: it reads no file, prints nothing, and cannot
//! fail. The same prepared scene, view and settings give the same bytes for every number of
//! threads, with culling on or off, in debug and in release builds.

mod accumulate;
mod adaptive;
mod batch;
mod bins;
mod cameras;
mod clusters;
mod coarse;
mod culling;
mod curve;
mod cutouts;
mod draws;
mod frame;
mod framing;
mod items;
mod legend;
mod loading;
mod multisample;
mod occluders;
mod passes;
mod prepared;
mod preparing;
mod raycast;
mod renderer;
mod resolution;
mod schedule;
mod screen_box;
mod settings;
mod shading;
mod stats;
mod supersample;
mod tile_data;
mod tile_shader;
mod tiles;
mod visibility;
mod visible_clusters;

pub use accumulate::{Accumulation, sample_place};
pub use cameras::camera_of;
pub use frame::{Frame, Region};
pub use framing::{DEFAULT_DIRECTION, frame_direction, frame_scene};
pub use items::Item;
pub use legend::{LegendEntry, legend};
pub use loading::{LoadTimes, load, load_glb_bytes, load_glb_bytes_to_draw, load_to_draw};
pub use passes::{Pass, Passes};
pub use prepared::{PrepareError, Prepared};
pub use preparing::PrepareTimes;
pub use renderer::Renderer;
pub use resolution::Resolution;
pub use settings::{Antialias, EdgeShading, RendererKind, Settings, ShadingRate};
pub use stats::{FrameStats, ObjectCounters, Stages};
pub use visible_clusters::ClusterCounters;

pub use cullet_cull as cull;
pub use cullet_cull::Test as CullTest;
pub use cullet_cull::wide::Level;
pub use cullet_raster as raster;
pub use cullet_scene as scene;
pub use cullet_shade as shade;
pub use cullet_transform as transform;

pub use cullet_raster::{DepthKind, SubpixelBits, Transforms};
pub use cullet_shade::{
    Arithmetic, Division, Encoding, Filter, Light, LightError, PointLight, Shading,
};
pub use cullet_transform::{Camera, CameraError, Projection, View, Viewport, ViewportError};
