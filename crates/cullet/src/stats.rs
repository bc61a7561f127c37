//! What a frame did and how long each part took.

use std::time::Duration;

use cullet_raster::SetupCounters;

use crate::ClusterCounters;

/// Counters and times of one frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct FrameStats {
    /// From the start of culling to pixels in memory.
    pub total: Duration,
    /// Where the time went.
    pub stages: Stages,
    /// Boxes tested against the view.
    pub boxes_tested: u64,
    /// What became of the objects.
    pub objects: ObjectCounters,
    /// Triangles of objects that culling threw out whole.
    pub n_triangles_of_culled_objects: u64,
    /// What became of the clusters of the objects that were drawn.
    pub clusters: ClusterCounters,
    /// Triangles of clusters that were thrown out whole.
    pub n_triangles_of_culled_clusters: u64,
    /// What became of the triangles of the clusters that were drawn, and of those that
    /// cannot be.
    pub triangles: SetupCounters,
    /// Samples that a triangle won, later losers included: a measure of the rasterizer's work. Tiles are drawn whole, also
    /// where they reach beyond the picture or its region, so it depends on [`tile_px`](crate::Settings::tile_px), and
    /// on what is left out as hidden, and, since later losers depend on the order, on whether wide code draws or the
    /// fallback; not on threads. Colours and data that are drawn apart, as with several samples a pixel, count both; of
    /// accumulated frames one counts, of supersampling the finer picture.
    pub samples_written: u64,
    /// Pixels that show something.
    pub pixels_shaded: u64,
    /// Bytes of the renderer's own buffers (without the frame).
    pub scratch_bytes: u64,
}

/// Wall time per stage.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stages {
    /// Boxes against the view.
    pub cull: Duration,
    /// Transform, clip, snap, set up.
    pub geometry: Duration,
    /// Coverage and depth.
    pub raster: Duration,
    /// Kernels, their colours to 8-bit sRGB where no linear picture is asked for, and data passes.
    pub shade: Duration,
    /// Background, and the linear picture to 8-bit sRGB.
    pub resolve: Duration,
}

impl Stages {
    /// One after the other.
    pub(crate) fn plus(&self, later: &Stages) -> Stages {
        Stages {
            cull: self.cull + later.cull,
            geometry: self.geometry + later.geometry,
            raster: self.raster + later.raster,
            shade: self.shade + later.shade,
            resolve: self.resolve + later.resolve,
        }
    }
}

/// What became of the objects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ObjectCounters {
    /// Objects in the scene.
    pub n_in: u64,
    /// Objects without a single drawable triangle.
    pub n_empty: u64,
    /// Thrown out: outside the view.
    pub n_outside: u64,
    /// Thrown out: smaller on the picture than [`Settings::min_size_px`](crate::Settings::min_size_px).
    pub n_small: u64,
    /// Handed to the rasterizer.
    pub n_drawn: u64,
}
