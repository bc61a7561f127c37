//! One frame: cull, set up, cover, shade.

use std::time::Instant;

use cullet_cull::{Frustum, planes_cutting};
use cullet_raster::{
    DepthFormat, Fragment, Interpolator, KeepAll, KeepIf, NO_TRIANGLE, ReversedF32, ScreenTriangle,
    SetupCounters, Tile, Triangles, cover, set_up,
};
use cullet_scene::AlphaMode;
use cullet_shade::alpha;
use cullet_transform::{ClipPoint, PlaneMask, View};
use glam::DMat4;

use crate::raycast::Raycaster;
use crate::schedule::{for_each, thread_count};
use crate::shading::{Shaded, Visible, VisibleTriangle, shade};
use crate::{CullTest, Frame, FrameStats, Item, Prepared, Region, RendererKind, Settings};

/// Subpixel positions: 24.8 fixed point.
pub(crate) const SUBPIXEL_BITS: u32 = 8;

type Depth = ReversedF32;

/// Triangles set up by one job.
const CHUNK_TRIANGLES: u32 = 4096;

/// Jobs set up before their triangles are covered; bounds the memory of set-up triangles.
const BATCH_CHUNKS: usize = 16;

/// Scratch memory; it carries nothing from one frame to the next.
#[derive(Debug, Default)]
pub struct Renderer {
    ids: Vec<u32>,
    depth: Vec<<Depth as DepthFormat>::Code>,
    /// Per item: the planes that cut it, or `None` when it was thrown out.
    planes: Vec<Option<PlaneMask>>,
    chunks: Vec<Chunk>,
}

/// A list of triangles, some items long, and what setting them up gave.
#[derive(Debug, Default)]
struct Chunk {
    segments: Vec<Segment>,
    n_triangles: u32,
    points: Vec<ClipPoint>,
    triangles: Vec<[u32; 3]>,
    out: Vec<ScreenTriangle>,
    counters: SetupCounters,
}

/// Triangles `first..first + len` of an item, with the screen triangles they became.
#[derive(Clone, Debug)]
struct Segment {
    item_idx: usize,
    first: u32,
    len: u32,
    out: std::ops::Range<usize>,
}

impl Renderer {
    /// Draws `prepared` as `view` sees it into `frame`. Cannot fail.
    pub fn render(
        &mut self,
        prepared: &Prepared,
        view: &View,
        settings: &Settings,
        frame: &mut Frame,
    ) -> FrameStats {
        let start = Instant::now();
        let threads = thread_count(settings.threads);
        let region = visible_region(view, settings);
        let mut stats = FrameStats::default();
        self.cull(prepared, view, settings.cull, &mut stats);
        stats.stages.cull = start.elapsed();
        frame.reset(region.width, region.height, settings.passes);

        let shaded = match settings.renderer {
            RendererKind::Raster => {
                self.raster(prepared, view, settings, threads, region, &mut stats);
                let visible = VisibilityBuffer {
                    prepared,
                    view,
                    planes: &self.planes,
                    region,
                    ids: &self.ids,
                };
                shade(&visible, view, settings, threads, region, frame)
            }
            RendererKind::Raycast { snapped } => {
                let start = Instant::now();
                let caster = Raycaster::new(prepared, view, settings, &self.planes, snapped);
                stats.stages.geometry = start.elapsed();
                shade(&caster, view, settings, threads, region, frame)
            }
        };
        let Shaded { n_pixels, shade, resolve } = shaded;
        (stats.pixels_shaded, stats.stages.shade, stats.stages.resolve) =
            (n_pixels, shade, resolve);
        stats.scratch_bytes = self.scratch_bytes();
        stats.total = start.elapsed();
        stats
    }

    /// Decides which objects may be in the view, and which planes cut them.
    fn cull(&mut self, prepared: &Prepared, view: &View, test: CullTest, stats: &mut FrameStats) {
        let frustum = Frustum::from_camera(view.camera(), view.viewport().aspect());
        let frustum = frustum.relative_to_eye();
        self.planes.clear();
        for item in prepared.items() {
            stats.objects.n_in += 1;
            let planes = if item.bounds.is_empty() {
                let n = u64::from(item.n_triangles);
                stats.objects.n_empty += 1;
                stats.triangles +=
                    SetupCounters { n_in: n, n_not_finite: n, ..SetupCounters::default() };
                None
            } else if test == CullTest::None {
                Some(PlaneMask::ALL)
            } else {
                stats.boxes_tested += 1;
                // The same matrix that takes the vertices on their way, so that the box holds
                // them with all their rounding.
                let relative_from_model = view.relative_from_model(&item.world_from_model);
                let bounds = item.bounds_model.transformed(&relative_from_model);
                let planes = planes_cutting(&bounds, &frustum, PlaneMask::ALL);
                stats.objects.n_outside += u64::from(planes.is_none());
                planes
            };
            stats.objects.n_drawn += u64::from(planes.is_some());
            self.planes.push(planes);
        }
    }

    /// Fills the id and depth buffers of `region`.
    fn raster(
        &mut self,
        prepared: &Prepared,
        view: &View,
        settings: &Settings,
        threads: usize,
        region: Region,
        stats: &mut FrameStats,
    ) {
        let n_pixels = region.width as usize * region.height as usize;
        self.ids.clear();
        self.ids.resize(n_pixels, NO_TRIANGLE);
        self.depth.clear();
        self.depth.resize(n_pixels, Depth::FARTHEST);

        let drawn = self.planes.iter().enumerate().filter(|(_, planes)| planes.is_some());
        let mut pending = drawn.flat_map(|(i, _)| segments(i, &prepared.items()[i])).peekable();
        while pending.peek().is_some() {
            let start = Instant::now();
            let n_chunks = fill_chunks(&mut self.chunks, &mut pending);
            let chunks = &mut self.chunks[..n_chunks];
            let planes = &self.planes;
            for_each(threads, chunks.iter_mut(), |chunk| chunk.set_up(prepared, view, planes));
            let middle = Instant::now();
            stats.stages.geometry += middle - start;

            let rows = (region.height as usize).div_ceil(4 * threads).max(8);
            let stride = rows * region.width as usize;
            let (ids, depth) = (self.ids.chunks_mut(stride), self.depth.chunks_mut(stride));
            let bands: Vec<_> = ids.zip(depth).enumerate().collect();
            let written = std::sync::atomic::AtomicU64::new(0);
            for_each(threads, bands.into_iter(), |(i, (ids, depth))| {
                let y = region.y + (i * rows) as u32;
                let mut tile = Tile::<Depth> { x: region.x, y, width: region.width, ids, depth };
                let mut n = 0;
                for chunk in &*chunks {
                    n += chunk.cover(prepared, view, settings, planes, &mut tile);
                }
                written.fetch_add(n, std::sync::atomic::Ordering::Relaxed);
            });
            stats.samples_written += written.into_inner();
            for chunk in &*chunks {
                stats.triangles += chunk.counters;
            }
            stats.stages.raster += middle.elapsed();
        }
    }

    fn scratch_bytes(&self) -> u64 {
        let chunks: usize = self.chunks.iter().map(Chunk::bytes).sum();
        let pixels = size_of_val(&self.ids[..]) + size_of_val(&self.depth[..]);
        (pixels + size_of_val(&self.planes[..]) + chunks) as u64
    }
}

/// The part of the picture to draw, cut to the picture.
fn visible_region(view: &View, settings: &Settings) -> Region {
    let (width, height) = (view.viewport().width(), view.viewport().height());
    let all = Region { x: 0, y: 0, width, height };
    let Some(region) = settings.region else { return all };
    let (x, y) = (region.x.min(width - 1), region.y.min(height - 1));
    let (right, bottom) =
        (region.x.saturating_add(region.width), region.y.saturating_add(region.height));
    Region {
        x,
        y,
        width: right.min(width).saturating_sub(x).max(1),
        height: bottom.min(height).saturating_sub(y).max(1),
    }
}

/// Cuts an item into pieces of at most [`CHUNK_TRIANGLES`].
fn segments(item_idx: usize, item: &Item) -> impl Iterator<Item = Segment> + use<> {
    let n = item.n_triangles;
    (0..n).step_by(CHUNK_TRIANGLES as usize).map(move |first| {
        let len = CHUNK_TRIANGLES.min(n - first);
        Segment { item_idx, first, len, out: 0..0 }
    })
}

/// Deals the next segments out to chunks; returns how many chunks got any.
fn fill_chunks(
    chunks: &mut Vec<Chunk>,
    pending: &mut std::iter::Peekable<impl Iterator<Item = Segment>>,
) -> usize {
    chunks.resize_with(BATCH_CHUNKS, Chunk::default);
    for (i, chunk) in chunks.iter_mut().enumerate() {
        chunk.segments.clear();
        chunk.n_triangles = 0;
        if pending.peek().is_none() {
            return i;
        }
        while let Some(segment) = pending.next_if(|next| {
            chunk.n_triangles == 0 || chunk.n_triangles + next.len <= CHUNK_TRIANGLES
        }) {
            chunk.n_triangles += segment.len;
            chunk.segments.push(segment);
        }
    }
    BATCH_CHUNKS
}

impl Chunk {
    /// Transforms and sets up all segments.
    fn set_up(&mut self, prepared: &Prepared, view: &View, planes: &[Option<PlaneMask>]) {
        self.counters = SetupCounters::default();
        self.out.clear();
        for segment in &mut self.segments {
            let item = &prepared.items()[segment.item_idx];
            let mesh = prepared.mesh(item);
            let range = segment.first as usize..(segment.first + segment.len) as usize;
            let clip_from_model = view.clip_from_model(&item.world_from_model);
            self.points.clear();
            self.points.extend(mesh.triangles[range].iter().flatten().map(|&i| {
                ClipPoint::from_model(&clip_from_model, mesh.positions[i as usize].as_dvec3())
            }));
            self.triangles.clear();
            self.triangles.extend((0..segment.len).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]));
            let input = Triangles {
                points: &self.points,
                triangles: &self.triangles,
                first_id: item.first_triangle + segment.first,
                planes: planes[segment.item_idx].unwrap_or_default(),
                facing: item.facing,
            };
            let start = self.out.len();
            self.counters += set_up::<SUBPIXEL_BITS>(view.viewport(), &input, &mut self.out);
            segment.out = start..self.out.len();
        }
    }

    /// Covers `tile` with all set-up triangles.
    fn cover(
        &self,
        prepared: &Prepared,
        view: &View,
        settings: &Settings,
        planes: &[Option<PlaneMask>],
        tile: &mut Tile<'_, Depth>,
    ) -> u64 {
        let mut written = 0;
        for segment in &self.segments {
            let item = &prepared.items()[segment.item_idx];
            let triangles = &self.out[segment.out.clone()];
            if item.masked {
                let mut corners = Corners::new(prepared, view, planes);
                let mut keep = KeepIf(|id, x, y| {
                    let (triangle, interpolator) = corners.of(id);
                    is_kept(triangle, &interpolator.fragment(x, y), settings)
                });
                for triangle in triangles {
                    written += cover::<Depth, SUBPIXEL_BITS>(tile, triangle, &mut keep);
                }
            } else {
                for triangle in triangles {
                    written += cover::<Depth, SUBPIXEL_BITS>(tile, triangle, &mut KeepAll);
                }
            }
        }
        written
    }

    fn bytes(&self) -> usize {
        self.points.capacity() * size_of::<ClipPoint>()
            + self.triangles.capacity() * size_of::<[u32; 3]>()
            + self.out.capacity() * size_of::<ScreenTriangle>()
            + self.segments.capacity() * size_of::<Segment>()
    }
}

/// Whether a masked material has matter at a fragment.
pub(crate) fn is_kept(
    triangle: &VisibleTriangle<'_>,
    fragment: &Fragment,
    settings: &Settings,
) -> bool {
    match triangle.surface.material.alpha {
        AlphaMode::Mask { cutoff } => {
            alpha(&triangle.surface, triangle.corners, fragment, settings.filter) >= cutoff
        }
        AlphaMode::Opaque | AlphaMode::Blend => true,
    }
}

/// The visibility buffer of a region, read back as fragments.
struct VisibilityBuffer<'a> {
    prepared: &'a Prepared,
    view: &'a View,
    planes: &'a [Option<PlaneMask>],
    region: Region,
    ids: &'a [u32],
}

impl Visible for VisibilityBuffer<'_> {
    fn row<'a>(
        &'a self,
        y: u32,
        xs: std::ops::Range<u32>,
        fragments: &mut Vec<Fragment>,
        emit: &mut dyn FnMut(u32, &VisibleTriangle<'a>, &[Fragment]),
    ) {
        let mut corners = Corners::new(self.prepared, self.view, self.planes);
        let start = (y - self.region.y) as usize * self.region.width as usize;
        let ids = &self.ids[start..start + xs.len()];
        let mut x = xs.start;
        for run in ids.chunk_by(|a, b| a == b) {
            if run[0] != NO_TRIANGLE {
                let (triangle, interpolator) = corners.of(run[0]);
                fragments.clear();
                fragments.extend((x..).take(run.len()).map(|x| interpolator.fragment(x, y)));
                emit(x, triangle, fragments);
            }
            x += run.len() as u32;
        }
    }
}

/// The last triangle asked for, ready to be interpolated over.
struct Corners<'a> {
    prepared: &'a Prepared,
    view: &'a View,
    planes: &'a [Option<PlaneMask>],
    clip_from_model: Option<(usize, DMat4)>,
    last: Option<(u32, VisibleTriangle<'a>, Interpolator)>,
}

impl<'a> Corners<'a> {
    fn new(prepared: &'a Prepared, view: &'a View, planes: &'a [Option<PlaneMask>]) -> Self {
        Corners { prepared, view, planes, clip_from_model: None, last: None }
    }

    fn of(&mut self, id: u32) -> (&VisibleTriangle<'a>, &Interpolator) {
        if self.last.as_ref().is_none_or(|(last, ..)| *last != id) {
            self.last = None;
        }
        let last = match self.last.take() {
            Some(last) => last,
            None => self.look_up(id),
        };
        let (_, triangle, interpolator) = self.last.insert(last);
        (triangle, interpolator)
    }

    fn look_up(&mut self, id: u32) -> (u32, VisibleTriangle<'a>, Interpolator) {
        let mut triangle = VisibleTriangle::new(self.prepared, id, true);
        let item_idx = triangle.item_idx;
        let clip_from_model = match self.clip_from_model {
            Some((last, matrix)) if last == item_idx => matrix,
            _ => self.view.clip_from_model(&triangle.item.world_from_model),
        };
        self.clip_from_model = Some((item_idx, clip_from_model));
        let corners = triangle.positions().map(|p| ClipPoint::from_model(&clip_from_model, p));
        let planes = self.planes[item_idx].unwrap_or_default();
        let interpolator =
            Interpolator::new::<SUBPIXEL_BITS>(self.view.viewport(), &corners, planes);
        triangle.front = interpolator.is_clockwise() == triangle.item.mirrored;
        (id, triangle, interpolator)
    }
}
