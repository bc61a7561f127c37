//! Geometry in portions: triangles go through set-up a chunk at a time, so that cores share the
//! work and the memory of set-up triangles stays bounded.

use std::iter::Peekable;
use std::ops::Range;

use cullet_raster::{
    KeepAll, KeepIf, Placer, ReversedF32, ScreenTriangle, SetupCounters, Tile, Triangles, Vertex,
    cover, set_up,
};
use cullet_transform::{ClipPoint, PlaneMask, View};
use glam::Vec3;

use crate::settings::SUBPIXEL_BITS;
use crate::visibility::Corners;
use crate::{Item, Prepared, Settings};

/// Triangles set up by one job.
const CHUNK_TRIANGLES: u32 = 4096;

/// Jobs set up before their triangles are covered; bounds the memory of set-up triangles.
const BATCH_CHUNKS: usize = 16;

/// How samples store depth.
pub(crate) type Depth = ReversedF32;

/// A list of triangles, some items long, and what setting them up gave.
#[derive(Debug, Default)]
pub(crate) struct Chunk {
    segments: Vec<Segment>,
    n_triangles: u32,
    vertices: Vec<Vertex>,
    triangles: Vec<[u32; 3]>,
    out: Vec<ScreenTriangle>,
    pub(crate) counters: SetupCounters,
}

/// Triangles `first..first + len` of an item, with the screen triangles they became.
#[derive(Clone, Debug)]
pub(crate) struct Segment {
    item_idx: usize,
    first: u32,
    len: u32,
    out: Range<usize>,
}

/// The least range that all corners lie in.
fn vertices_of(triangles: &[[u32; 3]]) -> Range<usize> {
    let corners = || triangles.iter().flatten().map(|&corner| corner as usize);
    corners().min().map_or(0..0, |first| first..corners().max().unwrap_or(first) + 1)
}

/// Cuts an item into pieces of at most [`CHUNK_TRIANGLES`].
pub(crate) fn segments(item_idx: usize, item: &Item) -> impl Iterator<Item = Segment> + use<> {
    let n = item.n_triangles;
    (0..n).step_by(CHUNK_TRIANGLES as usize).map(move |first| {
        let len = CHUNK_TRIANGLES.min(n - first);
        Segment { item_idx, first, len, out: 0..0 }
    })
}

/// Deals the next segments out to chunks; returns how many chunks got any.
pub(crate) fn fill_chunks(
    chunks: &mut Vec<Chunk>,
    pending: &mut Peekable<impl Iterator<Item = Segment>>,
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
    pub(crate) fn set_up(
        &mut self,
        prepared: &Prepared,
        view: &View,
        planes: &[Option<PlaneMask>],
    ) {
        self.counters = SetupCounters::default();
        self.out.clear();
        for segment in &mut self.segments {
            let item = &prepared.items()[segment.item_idx];
            let mesh = prepared.mesh(item);
            let range = segment.first as usize..(segment.first + segment.len) as usize;
            let mut triangles = &mesh.triangles[range];
            let clip_from_model = view.clip_from_model(&item.world_from_model);
            let planes = planes[segment.item_idx].unwrap_or_default();
            let placer = Placer::<SUBPIXEL_BITS>::new(view.viewport(), planes);
            let place = |position: &Vec3| {
                placer.place(ClipPoint::from_model(&clip_from_model, position.as_dvec3()))
            };
            self.vertices.clear();
            let used = vertices_of(triangles);
            let mut first_vertex = used.start as u32;
            if used.len() <= 3 * triangles.len() {
                self.vertices.extend(mesh.positions[used].iter().map(place));
            } else {
                // Indices all over the mesh: every corner by itself.
                let corners = triangles.iter().flatten().map(|&i| &mesh.positions[i as usize]);
                self.vertices.extend(corners.map(place));
                self.triangles.clear();
                self.triangles.extend((0..segment.len).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]));
                (triangles, first_vertex) = (&self.triangles, 0);
            }
            let input = Triangles {
                vertices: &self.vertices,
                triangles,
                first_vertex,
                first_id: item.first_triangle + segment.first,
                facing: item.facing,
            };
            let start = self.out.len();
            self.counters += set_up(&placer, &input, &mut self.out);
            segment.out = start..self.out.len();
        }
    }

    /// Covers `tile` with all set-up triangles.
    pub(crate) fn cover(
        &self,
        prepared: &Prepared,
        view: &View,
        settings: &Settings,
        planes: &[Option<PlaneMask>],
        tile: &mut Tile<'_, Depth>,
    ) -> u64 {
        let mut written = 0;
        let mut corners = Corners::new(prepared, view, planes);
        for segment in &self.segments {
            let item = &prepared.items()[segment.item_idx];
            let triangles = &self.out[segment.out.clone()];
            if item.masked {
                let mut keep = KeepIf(|id, x, y| {
                    let (triangle, interpolator) = corners.of(id);
                    triangle.keeps(&interpolator.fragment(x, y), settings)
                });
                for triangle in triangles {
                    written += cover::<Depth, SUBPIXEL_BITS, _>(tile, triangle, &mut keep);
                }
            } else {
                for triangle in triangles {
                    written += cover::<Depth, SUBPIXEL_BITS, _>(tile, triangle, &mut KeepAll);
                }
            }
        }
        written
    }

    /// Memory held.
    pub(crate) fn bytes(&self) -> usize {
        self.vertices.capacity() * size_of::<Vertex>()
            + self.triangles.capacity() * size_of::<[u32; 3]>()
            + self.out.capacity() * size_of::<ScreenTriangle>()
            + self.segments.capacity() * size_of::<Segment>()
    }
}
