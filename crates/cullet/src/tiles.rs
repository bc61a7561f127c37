//! The picture tile by tile: each is drawn whole, front to back, by one thread.

use std::sync::atomic::Ordering;
use std::time::Duration;

use cullet_raster::{
    Assembly, KeepSample, Object, Samples, SetupCounters, TileBuffer, TileRect, draw, prefetch,
};

use crate::bins::{Bins, Grid};
use crate::cutouts::{CutoutSlots, Cutouts};
use crate::shading::Scene;
use crate::supersample::FineTile;
use crate::tile_shader::ShadeScratch;
use crate::visible_clusters::{VisibleCluster, VisibleClusters};

/// What all tiles of a frame are drawn from.
pub(crate) struct TileDrawer<'a> {
    pub scene: Scene<'a>,
    pub grid: Grid,
    pub bins: &'a Bins,
    pub clusters: &'a VisibleClusters,
    pub samples: Samples,
    /// Pixels drawn for each one of the frame along a side.
    pub per_side: u32,
}

/// Memory of one thread, and what it did.
#[derive(Debug, Default)]
pub(crate) struct TileScratch {
    pub raster: RasterScratch,
    pub shade: ShadeScratch,
    pub fine: FineTile,
    pub done: Done,
}

/// Memory for drawing.
#[derive(Debug, Default)]
pub(crate) struct RasterScratch {
    pub buffer: TileBuffer,
    /// Triangles of this tile that were clipped, in order.
    pub clipped: Vec<u32>,
    assemblies: Assemblies,
    cutouts: CutoutSlots,
}

impl RasterScratch {
    fn bytes(&self) -> usize {
        self.buffer.bytes()
            + self.clipped.capacity() * 4
            + self.assemblies.bytes()
            + self.cutouts.bytes()
    }
}

/// Clusters assembled last, for a cluster is mostly drawn into several tiles near each other.
#[derive(Debug, Default)]
struct Assemblies {
    /// As many as have been wanted so far: the first frame of a small scene should not wait for more memory than it
    /// needs.
    made: Vec<Assembly>,
    slots: Vec<Slot>,
    /// How many of them are used.
    n: usize,
}

/// Where assemblies are looked for.
#[derive(Clone, Copy, Debug)]
struct Slot {
    /// Whose assembly it holds, or `NOBODY`.
    place: u32,
    /// Its number among those made, or `NONE`.
    assembly: u32,
}

impl Slot {
    const EMPTY: Slot = Slot { place: NOBODY, assembly: NONE };
}

/// Most assemblies kept by a thread.
const SLOTS: usize = 512;

const NOBODY: u32 = u32::MAX;
const NONE: u32 = u32::MAX;

/// So many clusters before its turn one is sent for: most are hidden, and take no longer than memory does.
const AHEAD: usize = 8;

impl Assemblies {
    /// Forgets the frame before; there will be up to `n` clusters. Slots keep their assemblies, so that a frame like
    /// the one before finds memory of the size that it needs.
    fn begin(&mut self, n: usize) {
        self.n = n.clamp(1, SLOTS);
        self.slots.iter_mut().for_each(|slot| slot.place = NOBODY);
        if self.slots.len() < self.n {
            self.slots.resize(self.n, Slot::EMPTY);
            self.made.reserve(self.n - self.made.len());
        }
    }

    /// The assembly of the cluster with number `place`, made by `assemble` if need be.
    fn of(&mut self, place: u32, assemble: impl FnOnce(&mut Assembly)) -> &Assembly {
        let slot = &mut self.slots[place as usize % self.n];
        if slot.place != place {
            if slot.assembly == NONE {
                slot.assembly = self.made.len() as u32;
                self.made.push(Assembly::default());
            }
            slot.place = place;
            assemble(&mut self.made[slot.assembly as usize]);
        }
        &self.made[slot.assembly as usize]
    }

    /// Memory in use; what is only reserved is not there yet.
    fn bytes(&self) -> usize {
        let more: usize = self.made.iter().map(Assembly::bytes).sum();
        size_of_val(&self.made[..]) + size_of_val(&self.slots[..]) + more
    }
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
    /// Makes ready for a frame of `n_clusters`.
    pub fn begin(&mut self, n_clusters: usize) {
        self.done = Done::default();
        self.raster.assemblies.begin(n_clusters);
        self.raster.cutouts.forget();
        self.shade.begin();
    }

    /// Memory held.
    pub fn bytes(&self) -> usize {
        self.raster.bytes() + self.shade.bytes() + self.fine.bytes() + size_of::<Self>()
    }
}

impl TileDrawer<'_> {
    /// How many tiles of a row hold nothing, from one on.
    pub fn n_empty(&self, [column, row]: [u32; 2]) -> u32 {
        let is_empty = |column: &u32| {
            let tile = (row * self.grid.size[0] + column) as usize;
            self.bins.of(tile).is_empty()
        };
        (column..self.grid.size[0]).take_while(is_empty).count() as u32
    }

    /// Draws the tile in a column and a row of the grid into the buffer of `scratch`.
    pub fn tile(
        &self,
        scratch: &mut RasterScratch,
        done: &mut Done,
        [column, row]: [u32; 2],
        samples: Samples,
    ) {
        let Scene { prepared, settings, .. } = self.scene;
        let Grid { side, first, size } = self.grid;
        let origin = [(first[0] + column) * side, (first[1] + row) * side];
        let RasterScratch { buffer, clipped, assemblies, cutouts } = scratch;
        buffer.begin(origin, side as usize, samples);
        clipped.clear();
        let places = self.bins.of((row * size[0] + column) as usize);
        let clusters = &*self.clusters.sorted;
        for (i, &place) in places.iter().enumerate() {
            if let Some(&later) = places.get(i + AHEAD) {
                prefetch(clusters, later as usize);
            }
            let cluster = &clusters[place as usize];
            let rect = part(cluster, origin, side);
            let level = settings.simd;
            if settings.occlusion && buffer.hides(level, rect, cluster.shown.nearest) {
                continue;
            }
            let assembly = assemblies.of(place, |assembly| self.assemble(cluster, assembly));
            let item = &prepared.items()[cluster.item_idx as usize];
            done.n_samples_written += if item.masked {
                let mut cutouts =
                    Cutouts::new(self.scene, cluster.item_idx as usize, &mut *cutouts);
                let keep: &mut KeepSample<'_> =
                    &mut |id, place, wanted| cutouts.keep(id, place, wanted);
                draw(buffer, assembly, Some(keep))
            } else {
                draw(buffer, assembly, None)
            };
            clipped.extend_from_slice(assembly.clipped());
            if !cluster.drawn.swap(true, Ordering::Relaxed) {
                done.triangles += assembly.counters();
            }
        }
        clipped.sort_unstable();
    }

    fn assemble(&self, cluster: &VisibleCluster, out: &mut Assembly) {
        let Scene { prepared, view, settings, .. } = self.scene;
        let item = &prepared.items()[cluster.item_idx as usize];
        let object = Object {
            clip_from_model: view.clip_from_model(&item.world_from_model),
            viewport: view.viewport(),
            planes: cluster.planes,
            facing: item.facing,
            first_id: item.first_triangle,
            precision: settings.precision(),
            samples: self.samples,
        };
        let clusters = prepared.clusters(cluster.item_idx as usize);
        out.assemble(settings.simd, &clusters.geometry(cluster.cluster_idx as usize), &object);
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
