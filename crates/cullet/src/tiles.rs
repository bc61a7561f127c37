//! The picture tile by tile: each is drawn whole, front to back, by one thread.

use std::sync::atomic::Ordering;
use std::time::Duration;

use cullet_raster::{
    Cluster, DrawScratch, KeepSample, Object, Samples, SetupCounters, TileBuffer, TileRect, draw,
};

use crate::bins::{Bins, Grid};
use crate::shading::Scene;
use crate::tile_shader::ShadeScratch;
use crate::visibility::Corners;
use crate::visible_clusters::{VisibleCluster, VisibleClusters};

/// What all tiles of a frame are drawn from.
pub(crate) struct TileDrawer<'a> {
    pub scene: Scene<'a>,
    pub grid: Grid,
    pub bins: &'a Bins,
    pub clusters: &'a VisibleClusters,
    pub samples: Samples,
}

/// Memory of one thread, and what it did.
#[derive(Debug, Default)]
pub(crate) struct TileScratch {
    pub raster: RasterScratch,
    pub shade: ShadeScratch,
    pub done: Done,
}

/// Memory for drawing.
#[derive(Debug, Default)]
pub(crate) struct RasterScratch {
    pub buffer: TileBuffer,
    draw: DrawScratch,
}

/// What a thread did in a frame.
#[derive(Debug, Default)]
pub(crate) struct Done {
    pub triangles: SetupCounters,
    pub n_samples_written: u64,
    pub n_pixels: u64,
    pub raster: Duration,
    pub shade: Duration,
}

impl TileScratch {
    /// Memory held.
    pub fn bytes(&self) -> usize {
        self.raster.buffer.bytes() + self.shade.bytes() + size_of::<Self>()
    }
}

impl TileDrawer<'_> {
    /// Draws the tile in a column and a row of the grid into the buffer of `scratch`.
    pub fn tile(
        &self,
        scratch: &mut RasterScratch,
        done: &mut Done,
        [column, row]: [u32; 2],
        samples: Samples,
    ) {
        let Scene { prepared, view, settings, planes } = self.scene;
        let Grid { side, first, size } = self.grid;
        let origin = [(first[0] + column) * side, (first[1] + row) * side];
        scratch.buffer.begin(origin, side as usize, samples);
        let mut corners = Corners::new(prepared, view, planes);
        let mut of_item = None;
        for &place in self.bins.of((row * size[0] + column) as usize) {
            let cluster = self.clusters.at(place);
            let rect = part(cluster, origin, side);
            let level = settings.simd;
            if settings.occlusion && scratch.buffer.hides(level, rect, cluster.shown.nearest) {
                continue;
            }
            let item = &prepared.items()[cluster.item_idx as usize];
            let clip_from_model = match of_item {
                Some((item_idx, matrix)) if item_idx == cluster.item_idx => matrix,
                _ => view.clip_from_model(&item.world_from_model),
            };
            of_item = Some((cluster.item_idx, clip_from_model));
            let object = Object {
                clip_from_model,
                viewport: view.viewport(),
                planes: cluster.planes,
                facing: item.facing,
                first_id: item.first_triangle,
            };
            let clusters = prepared.clusters(cluster.item_idx as usize);
            let geometry = clusters.geometry(cluster.cluster_idx as usize);
            let mut keep = |id: u32, [x, y]: [i32; 2]| {
                let (triangle, interpolator) = corners.of(id);
                let place = [f64::from(x) / 16.0, f64::from(y) / 16.0];
                triangle.keeps(&interpolator.fragment_at(place), settings)
            };
            let keep: Option<&mut KeepSample<'_>> =
                if item.masked { Some(&mut keep) } else { None };
            self.cluster(scratch, done, cluster, &geometry, &object, keep);
        }
    }

    fn cluster(
        &self,
        scratch: &mut RasterScratch,
        done: &mut Done,
        cluster: &VisibleCluster,
        geometry: &Cluster<'_>,
        object: &Object,
        keep: Option<&mut KeepSample<'_>>,
    ) {
        let RasterScratch { buffer, draw: memory } = scratch;
        let drawn = draw(self.scene.settings.simd, buffer, memory, geometry, object, keep);
        done.n_samples_written += drawn.samples;
        if !cluster.drawn.swap(true, Ordering::Relaxed) {
            done.triangles += drawn.triangles;
        }
    }
}

/// The pixels of a tile, counted from its corner, that a cluster may show in.
fn part(cluster: &VisibleCluster, origin: [u32; 2], side: u32) -> TileRect {
    let range = |[start, end]: [i32; 2], origin: u32| {
        let cut = |at: i32| (at - origin as i32).clamp(0, side as i32) as usize;
        [cut(start), cut(end)]
    };
    TileRect { x: range(cluster.shown.x, origin[0]), y: range(cluster.shown.y, origin[1]) }
}
