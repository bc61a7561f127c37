//! Colours from triangle ids: the second half of a frame, a block of the picture at a time.
//!
//! 1. Rows are taken apart into runs of one triangle each, and each run's triangle is looked up in a
//!    small table; those met for the first time get a number ([`Batch`]).
//! 2. They are set up, object by object ([`Draws`]), into records ([`cullet_shade::wide`]).
//! 3. Runs are grouped by paint, and coloured eight or sixteen pixels at a time.
//!
//! A triangle is set up anew for each block (64 x 64 px of the whole picture), so a pixel's colour
//! does not depend on what part of the picture is asked for, in what order, or by which thread.

use cullet_raster::{BLOCK, Samples, prefetch};
use cullet_shade::Needs;
use cullet_shade::wide::{self, ColorPlanes, Group, Out, Paint, Planes, PointPlanes, Record};
use glam::Vec4;

use crate::adaptive::AdaptiveScratch;
use crate::batch::{BATCH, Batch, Rectangle};
use crate::coarse::CoarseScratch;
use crate::draws::Draws;
use crate::frame::Target;
use crate::multisample::EdgeScratch;
use crate::shading::{Places, Run, Scene};
use crate::shading::{encode, encode_linear, fill_background, fill_background_from, fill_run};
use crate::tile_data::{Distance, fill_data};
use crate::tiles::RasterScratch;
use crate::visibility::{CornerSlots, Corners, scan};
use crate::{Pass, Passes, Region, Resolution, Settings, ShadingRate};

/// A place of the picture whose colour is wanted.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Wanted {
    /// The triangle seen there.
    pub id: u32,
    /// 1/16 px from the left border of the whole picture; the centre of a pixel is at 8.
    pub x: i32,
    /// The same, down from the upper border.
    pub y: i32,
}

/// Sixteenths of a pixel along a block.
const SUBPIXELS: i32 = 16 * BLOCK as i32;

/// Memory for shading, one per thread; it carries nothing from one frame to the next.
#[derive(Debug)]
pub(crate) struct ShadeScratch {
    draws: Draws,
    pub(crate) batch: Batch,
    /// By record, the draw of the triangle and its paint.
    draw_of: Vec<u32>,
    paint_of: Vec<u32>,
    /// The block that the records of the batch are of, its upper left pixel.
    block: [u32; 2],
    /// The draws of the batch, some of them again.
    seen: Vec<u32>,
    wanted: Vec<(u32, u32)>,
    records: Vec<Record>,
    colors: Vec<ColorPlanes>,
    points: Vec<PointPlanes>,
    n_runs_of_paint: Vec<u32>,
    left: Vec<wide::Run>,
    painting: wide::Scratch,
    corners: CornerSlots,
    pub(crate) edges: EdgeScratch,
    pub(crate) coarse: CoarseScratch,
    pub(crate) adaptive: AdaptiveScratch,
}

impl Default for ShadeScratch {
    fn default() -> Self {
        ShadeScratch {
            draws: Draws::default(),
            batch: Batch::default(),
            draw_of: vec![0; BATCH],
            paint_of: vec![0; BATCH],
            block: [0; 2],
            seen: Vec::new(),
            wanted: vec![(0, 0); BATCH],
            records: vec![Record::default(); BATCH],
            colors: Vec::new(),
            points: Vec::new(),
            n_runs_of_paint: Vec::new(),
            left: Vec::new(),
            painting: wide::Scratch::default(),
            corners: CornerSlots::default(),
            edges: EdgeScratch::default(),
            coarse: CoarseScratch::default(),
            adaptive: AdaptiveScratch::default(),
        }
    }
}

impl ShadeScratch {
    /// Forgets the frame before, to be called before each.
    pub(crate) fn begin(&mut self) {
        self.batch.begin();
        self.draws.forget();
        self.corners.forget();
    }

    /// Memory held.
    pub(crate) fn bytes(&self) -> usize {
        self.draws.bytes()
            + Batch::bytes()
            + BATCH * (16 + size_of::<Record>())
            + self.colors.capacity() * size_of::<ColorPlanes>()
            + self.corners.bytes()
            + self.points.capacity() * size_of::<PointPlanes>()
            + self.edges.bytes()
            + self.coarse.bytes()
            + self.adaptive.bytes()
    }
}

/// Shades parts of one frame on one thread.
pub(crate) struct TileShader<'a> {
    pub(crate) scene: Scene<'a>,
    pub(crate) scratch: &'a mut ShadeScratch,
    distance: Option<Distance>,
}

impl<'a> TileShader<'a> {
    /// `scratch` has begun the frame of `scene`.
    pub(crate) fn new(scene: Scene<'a>, scratch: &'a mut ShadeScratch) -> Self {
        scratch.draws.resize(scene.prepared.items().len());
        TileShader {
            scene,
            scratch,
            distance: Distance::new(scene.view, scene.settings.precision()),
        }
    }

    /// Fills passes of a rectangle of the picture, whose upper left pixel is at `place` in `tile`.
    /// Returns how many pixels show something.
    pub(crate) fn tile(
        &mut self,
        rect: Region,
        raster: &RasterScratch,
        place: [u32; 2],
        passes: Passes,
        out: &mut Target<'_>,
    ) -> u64 {
        let tile = &raster.buffer;
        if tile.is_empty() {
            out.clear_data([rect.width, rect.height], passes);
            if passes.needs_color() {
                fill_background(self.scene.settings, rect, out);
                encode_linear(self.scene.settings, rect, out);
            }
            return 0;
        }
        match tile.samples() {
            Samples::One => self.one_sample(rect, raster, place, passes, out),
            _ => {
                let n_pixels = self.multisampled(rect, tile, place, out);
                encode_linear(self.scene.settings, rect, out);
                n_pixels
            }
        }
    }

    /// [`TileShader::tile`] with one sample per pixel.
    fn one_sample(
        &mut self,
        rect: Region,
        raster: &RasterScratch,
        place: [u32; 2],
        passes: Passes,
        out: &mut Target<'_>,
    ) -> u64 {
        let scene = self.scene;
        let (ids, stride) = raster.buffer.ids_from(place);
        let mut n_pixels = 0;
        if passes.needs_color() {
            n_pixels = self.blocks(rect, ids, stride, 0, out);
            encode_linear(self.scene.settings, rect, out);
        }
        let data = passes.data();
        if data != Passes::NONE || !passes.needs_color() {
            let (level, tile) = (scene.settings.simd, &raster.buffer);
            let (filled, n) =
                fill_data(level, scene.prepared, self.distance, rect, tile, place, data, out);
            n_pixels = n;
            let left = data.without(filled);
            out.clear_data([rect.width, rect.height], left);
            // Clipped triangles have their distances from their corners.
            let clipped = if filled.contains(Pass::Depth) { &raster.clipped[..] } else { &[] };
            if left != Passes::NONE || !clipped.is_empty() {
                let slots = &mut self.scratch.corners;
                let mut corners = Corners::new(&scene, slots);
                // Of most triangles a bit tells that they are not clipped.
                let bit_of = |id: u32| 1_u64 << (id % 64);
                let bits = clipped.iter().fold(0, |bits, id| bits | bit_of(*id));
                let mut last = None;
                scan(rect, ids, stride, &mut |id, [x, y], len| {
                    let is_clipped = bits & bit_of(id) != 0 && clipped.binary_search(&id).is_ok();
                    let start = (y - rect.y) as usize * out.stride + (x - rect.x) as usize;
                    if is_clipped {
                        let distances = match last {
                            Some((last, distances)) if last == id => distances,
                            _ => corners.of(id).0.distances(scene.view),
                        };
                        last = Some((id, distances));
                        let out = &mut out.depth[start..start + len];
                        let planes = &corners.ready(id).interpolator;
                        planes.fill_row(scene.settings.simd, distances, [x, y], out);
                    }
                    if left != Passes::NONE {
                        let (triangle, interpolator) = corners.of(id);
                        let run = Run { x, y, len, places: Places::Planes(interpolator) };
                        fill_run(&scene, out, start, &triangle, &run, left);
                    }
                });
            }
        }
        n_pixels
    }

    /// Linear RGBA, alpha 1, of what is seen at each of `wanted`, places of visible triangles.
    pub(crate) fn colors(&mut self, wanted: &[Wanted], out: &mut [Vec4]) {
        let block_of = |wanted: &Wanted| [wanted.x / SUBPIXELS, wanted.y / SUBPIXELS];
        let mut first = 0;
        for part in wanted.chunk_by(|a, b| block_of(a) == block_of(b)) {
            let out = &mut out[first..first + part.len()];
            self.colors_in_block(block_of(&part[0]).map(|at| at as u32), part, out);
            first += part.len();
        }
    }

    /// [`TileShader::colors`] where all places are in one block, which is the so many'th across and down. Triangles
    /// of the same block that have records keep them.
    pub(crate) fn colors_in_block(&mut self, block: [u32; 2], wanted: &[Wanted], out: &mut [Vec4]) {
        let corner = block.map(|at| at as i32 * SUBPIXELS);
        let block = block.map(|at| at * BLOCK);
        for (part, out) in wanted.chunks(BATCH).zip(out.chunks_mut(BATCH)) {
            let ShadeScratch { batch, block: of, .. } = &mut *self.scratch;
            if *of == block && batch.has_room(part.len()) {
                batch.begin_more();
            } else {
                batch.begin();
            }
            batch.singles(part, corner, 0);
            self.paint(block, &mut Out::Linear(out));
        }
    }

    /// Colours `rect` from ids, background where there are none; see [`TileShader::tile`]. `n_others` pixels show no id
    /// here, and need no background: they will have other colours. (Only full shading asks.)
    pub(crate) fn blocks(
        &mut self,
        rect: Region,
        ids: &[u32],
        stride: usize,
        n_others: usize,
        out: &mut Target<'_>,
    ) -> u64 {
        let blocks = blocks(rect);
        let Settings { shading_rate, resolution, .. } = *self.scene.settings;
        match (shading_rate, resolution) {
            (ShadingRate::One, Resolution::Adaptive) => {
                blocks.map(|block| self.adaptive_block(rect, block, ids, stride, out)).sum()
            }
            (ShadingRate::One, _) => {
                blocks.map(|block| self.block(rect, block, ids, stride, n_others, out)).sum()
            }
            (ShadingRate::Two, _) => {
                fill_background(self.scene.settings, rect, out);
                blocks.map(|block| self.coarse_block(rect, block, ids, stride, out)).sum()
            }
        }
    }

    /// Colours the part of `rect` that lies in a block.
    fn block(
        &mut self,
        rect: Region,
        block: [u32; 2],
        ids: &[u32],
        stride: usize,
        n_others: usize,
        out: &mut Target<'_>,
    ) -> u64 {
        let [left, top, right, bottom] = part_in(rect, block);
        let batch = &mut self.scratch.batch;
        batch.begin();
        let (row, column) = ((top - rect.y) as usize, (left - rect.x) as usize);
        let size = [right - left, bottom - top];
        let first = row * out.stride + column;
        let rectangle = Rectangle {
            ids: &ids[row * stride + column..],
            stride,
            size,
            out: first,
            out_stride: out.stride,
            place: [16 * (left - block[0]) + 8, 16 * (top - block[1]) + 8],
        };
        batch.rectangle(self.scene.settings.simd, &rectangle);
        let n_pixels = batch.n_pixels();
        // Where as many are seen as there are pixels without others', nothing is left for the background.
        let n_own = (rect.width * rect.height) as usize - n_others;
        if n_pixels < n_own.min((size[0] * size[1]) as usize) {
            fill_background_from(self.scene.settings, size, first, out);
        }
        let mut out = if out.linear.is_empty() {
            Out::Bytes(&mut *out.rgba8)
        } else {
            Out::Linear(&mut *out.linear)
        };
        self.paint(block, &mut out);
        n_pixels as u64
    }

    /// Colours the pixels of the batch.
    pub(crate) fn paint(&mut self, block: [u32; 2], out: &mut Out<'_>) {
        if self.scratch.batch.n_pixels() == 0 {
            return;
        }
        self.set_up(block);
        self.paint_more(block, out);
    }

    /// Colours other pixels of triangles that have been set up.
    pub(crate) fn paint_more(&mut self, block: [u32; 2], out: &mut Out<'_>) {
        let scratch = &mut *self.scratch;
        let Draws { all, paints, .. } = &scratch.draws;
        let counts = &mut scratch.n_runs_of_paint;
        counts.clear();
        counts.resize(paints.len(), 0);
        for draw in &scratch.seen {
            counts[all[*draw as usize].paint as usize] = 1;
        }
        let is_one = counts.iter().sum::<u32>() == 1;
        let batch = &mut scratch.batch;
        let simd = self.scene.settings.simd;
        let mut runs =
            if is_one { batch.runs() } else { batch.by_paint(simd, &scratch.paint_of, counts) };
        let look = self.scene.look();
        let ShadeScratch { records, colors, points, left, painting, .. } = scratch;
        left.clear();
        let planes = Planes { records, colors, points };
        for (key, count) in paints.iter().zip(counts).filter(|(_, count)| **count > 0) {
            let n = if is_one { runs.len() } else { *count as usize };
            let (own, others) = runs.split_at(n);
            runs = others;
            let prepared = self.scene.prepared;
            let surface = prepared.surface(&prepared.items()[key.item]);
            let paint = Paint::new(&surface, key.needs, &look);
            wide::paint(&paint, own, &planes, painting, out, left);
        }
        if !left.is_empty() {
            self.paint_left(block, out);
        }
    }

    /// Makes the records of those triangles of the batch that have none.
    fn set_up(&mut self, block: [u32; 2]) {
        let Scene { prepared, settings, .. } = self.scene;
        let scratch = &mut *self.scratch;
        let n_known = scratch.batch.n_set_up();
        if n_known == 0 {
            scratch.seen.clear();
            scratch.block = block;
        }
        debug_assert_eq!(scratch.block, block);
        let n_seen = scratch.seen.len();
        let ids = &scratch.batch.ids()[n_known..];
        let draws_of = &mut scratch.draw_of[..ids.len()];
        for (id, draw) in ids.iter().zip(&mut *draws_of) {
            *draw = scratch.draws.of(&self.scene, *id);
        }
        for run in draws_of.chunk_by(|a, b| a == b) {
            let draw = &mut scratch.draws.all[run[0] as usize];
            if draw.n_wanted == 0 {
                scratch.seen.push(run[0]);
            }
            draw.n_wanted += run.len() as u32;
        }
        let mut first = 0;
        for draw in &scratch.seen[n_seen..] {
            let draw = &mut scratch.draws.all[*draw as usize];
            draw.next = first;
            first += draw.n_wanted;
        }
        let mut record = n_known;
        for run in draws_of.chunk_by(|a, b| a == b) {
            let draw = &mut scratch.draws.all[run[0] as usize];
            let wanted = &mut scratch.wanted[draw.next as usize..][..run.len()];
            draw.next += run.len() as u32;
            let ids = &ids[record - n_known..][..run.len()];
            let triangles = &prepared.mesh(&prepared.items()[draw.item]).triangles;
            scratch.paint_of[record..record + run.len()].fill(draw.paint);
            for (wanted, id) in wanted.iter_mut().zip(ids) {
                let triangle = id - draw.first_triangle;
                prefetch(triangles, triangle as usize);
                *wanted = (triangle, record as u32);
                record += 1;
            }
        }
        let mut first = 0;
        for draw in &scratch.seen[n_seen..] {
            let draw = &mut scratch.draws.all[*draw as usize];
            let item = &prepared.items()[draw.item];
            let wanted = &scratch.wanted[first..first + draw.n_wanted as usize];
            let group = Group {
                surface: prepared.surface(item),
                placement: &draw.placement,
                needs: draw.needs,
                mirrored: item.mirrored,
                light: settings.light,
                point_light: settings
                    .point_light
                    .filter(|_| draw.needs.contains(Needs::POINT_LIGHT)),
                block,
            };
            if draw.needs.contains(Needs::VERTEX_COLOR) && scratch.colors.is_empty() {
                scratch.colors.resize(BATCH, ColorPlanes::default());
            }
            if group.point_light.is_some() && scratch.points.is_empty() {
                scratch.points.resize(BATCH, PointPlanes::default());
            }
            let (records, colors) = (&mut scratch.records, &mut scratch.colors);
            wide::set_up(settings.simd, &group, wanted, records, colors, &mut scratch.points);
            first += wanted.len();
            draw.n_wanted = 0;
        }
        scratch.batch.all_set_up();
    }

    /// Colours the pixels that wide code has left, one by one.
    #[cold]
    fn paint_left(&mut self, block: [u32; 2], out: &mut Out<'_>) {
        let scene = self.scene;
        let ShadeScratch { left, batch, corners, .. } = &mut *self.scratch;
        let mut corners = Corners::new(&scene, corners);
        for pixel in &*left {
            let (triangle, interpolator) = corners.of(batch.ids()[pixel.record()]);
            let place = pixel.place();
            let at = [0, 1].map(|i| f64::from(block[i]) + f64::from(place[i]) / 16.0);
            let color = triangle.color(&scene, &interpolator.fragment_at(at));
            match out {
                Out::Linear(out) => out[pixel.out as usize] = color,
                Out::Bytes(out) => out[pixel.out as usize] = encode(scene.settings.encoding, color),
            }
        }
    }
}

/// The part of a rectangle that lies in a block: its borders, left, upper, right and lower.
pub(crate) fn part_in(rect: Region, block: [u32; 2]) -> [u32; 4] {
    [
        block[0].max(rect.x),
        block[1].max(rect.y),
        (block[0] + BLOCK).min(rect.x + rect.width),
        (block[1] + BLOCK).min(rect.y + rect.height),
    ]
}

/// Corners of the blocks that a rectangle reaches.
fn blocks(rect: Region) -> impl Iterator<Item = [u32; 2]> {
    let first = |at: u32| at - at % BLOCK;
    let columns = move || (first(rect.x)..rect.x + rect.width).step_by(BLOCK as usize);
    (first(rect.y)..rect.y + rect.height)
        .step_by(BLOCK as usize)
        .flat_map(move |y| columns().map(move |x| [x, y]))
}

#[cfg(test)]
mod tests;
