//! Colours from triangle ids: the second half of a frame, a block of the picture at a time.
//!
//! 1. Each pixel's triangle is looked up in a small table; those met for the first time get a
//!    number.
//! 2. They are set up, object by object, into records ([`cullet_shade::wide`]).
//! 3. Pixels are grouped by paint, and coloured eight at a time.
//!
//! A triangle is set up anew for each block (64 x 64 px of the whole picture), so a pixel's colour
//! does not depend on what part of the picture is asked for, in what order, or by which thread.

use cullet_raster::{BLOCK, NO_TRIANGLE, Placement, Samples};
use cullet_shade::Needs;
use cullet_shade::wide::{
    ColorPlanes, Group, Out, Paint, Pixel, PointPlanes, Record, paint, set_up,
};
use glam::Vec4;

use crate::adaptive::AdaptiveScratch;
use crate::coarse::CoarseScratch;
use crate::frame::Target;
use crate::multisample::EdgeScratch;
use crate::shading::{Places, Run, Scene};
use crate::shading::{encode, encode_linear, fill_background, fill_background_from, fill_run};
use crate::tile_data::{Distance, fill_data};
use crate::tiles::RasterScratch;
use crate::visibility::{CornerSlots, Corners, scan};
use crate::{Pass, Passes, Region, Resolution, Settings, ShadingRate};

/// Pixels coloured at once: those of a block.
const BATCH: usize = (BLOCK * BLOCK) as usize;

/// Slots of the table of triangles.
const SLOTS: usize = 2048;

/// Slots of the table that remembers whose an id was.
const HINTS: usize = 1024;

/// A place of the picture whose colour is wanted.
#[derive(Clone, Copy, Debug)]
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
    paints: Vec<PaintKey>,
    table: Vec<u64>,
    /// Which batch the entries of the table are of.
    epoch: u16,
    /// The triangles of the batch, by the numbers of their records.
    ids: Vec<u32>,
    draw_of: Vec<u32>,
    paint_of: Vec<u32>,
    /// The draws of the batch.
    batch: Vec<u32>,
    wanted: Vec<(u32, u32)>,
    records: Vec<Record>,
    colors: Vec<ColorPlanes>,
    points: Vec<PointPlanes>,
    pub(crate) pixels: Vec<Pixel>,
    sorted: Vec<Pixel>,
    n_pixels_of_paint: Vec<u32>,
    left: Vec<u32>,
    corners: CornerSlots,
    pub(crate) edges: EdgeScratch,
    pub(crate) coarse: CoarseScratch,
    pub(crate) adaptive: AdaptiveScratch,
}

/// An object as this frame draws it.
#[derive(Debug)]
struct Draw {
    item: usize,
    first_triangle: u32,
    n_triangles: u32,
    placement: Placement,
    needs: Needs,
    paint: u32,
    /// Triangles of the batch, and where the next of them goes in the list.
    n_wanted: u32,
    next: u32,
}

/// What pixels must have in common to be coloured together, and an item that has it.
#[derive(Debug)]
struct PaintKey {
    material: usize,
    needs: Needs,
    item: usize,
}

/// The objects met in this frame.
#[derive(Debug, Default)]
struct Draws {
    all: Vec<Draw>,
    /// By item, the draw's index + 1, or 0.
    of_item: Vec<u32>,
    /// By some bits of a triangle's id, the draw that it was last found in.
    hints: Vec<u32>,
}

impl Default for ShadeScratch {
    fn default() -> Self {
        ShadeScratch {
            draws: Draws { hints: vec![0; HINTS], ..Draws::default() },
            paints: Vec::new(),
            table: vec![0; SLOTS + 1],
            epoch: 0,
            ids: vec![0; BATCH + 1],
            draw_of: vec![0; BATCH],
            paint_of: vec![0; BATCH],
            batch: Vec::new(),
            wanted: vec![(0, 0); BATCH],
            records: vec![Record::default(); BATCH],
            colors: Vec::new(),
            points: Vec::new(),
            pixels: vec![Pixel::default(); BATCH + 1],
            sorted: vec![Pixel::default(); BATCH + 1],
            n_pixels_of_paint: Vec::new(),
            left: Vec::new(),
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
        self.draws.forget();
        self.paints.clear();
        self.corners.forget();
    }

    /// Memory held.
    pub(crate) fn bytes(&self) -> usize {
        self.draws.all.capacity() * size_of::<Draw>()
            + (self.draws.of_item.capacity() + HINTS) * 4
            + SLOTS * 8
            + BATCH * (20 + 2 * size_of::<Pixel>() + size_of::<Record>())
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
        scratch.draws.of_item.resize(scene.prepared.items().len(), 0);
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
            // Data is where nothing is from the start.
            if passes.needs_color() {
                fill_background(self.scene.settings, rect, out);
                encode_linear(self.scene.settings.encoding, rect, out);
            }
            return 0;
        }
        match tile.samples() {
            Samples::One => self.one_sample(rect, raster, place, passes, out),
            _ => {
                let n_pixels = self.multisampled(rect, tile, place, out);
                encode_linear(self.scene.settings.encoding, rect, out);
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
            n_pixels = self.blocks(rect, ids, stride, out);
            encode_linear(self.scene.settings.encoding, rect, out);
        }
        let data = passes.data();
        if data != Passes::NONE || !passes.needs_color() {
            let (filled, n) =
                fill_data(scene.prepared, self.distance, rect, &raster.buffer, place, data, out);
            n_pixels = n;
            let left = data.without(filled);
            // Clipped triangles have their distances from their corners.
            let clipped = if data.contains(Pass::Depth) { &raster.clipped[..] } else { &[] };
            if left != Passes::NONE || !clipped.is_empty() {
                let slots = &mut self.scratch.corners;
                let mut corners = Corners::new(&scene, slots);
                scan(rect, ids, stride, &mut |id, [x, y], len| {
                    let is_clipped = clipped.binary_search(&id).is_ok();
                    let wanted = if is_clipped { left.with(Pass::Depth) } else { left };
                    if wanted != Passes::NONE {
                        let (triangle, interpolator) = corners.of(id);
                        let run = Run { x, y, len, places: Places::Planes(interpolator) };
                        let start = (y - rect.y) as usize * out.stride + (x - rect.x) as usize;
                        fill_run(&scene, out, start, &triangle, &run, wanted);
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
            let [x, y] = block_of(&part[0]);
            let block = [x as u32 * BLOCK, y as u32 * BLOCK];
            for part in part.chunks(BATCH) {
                let mut batch = Batch::begin(self.scratch);
                for (i, wanted) in part.iter().enumerate() {
                    let x = (wanted.x - x * SUBPIXELS) as f32 * 0.0625;
                    let y = (wanted.y - y * SUBPIXELS) as f32 * 0.0625;
                    batch.push(wanted.id, (first + i) as u32, x, y);
                }
                let (n_triangles, n_pixels) = (batch.n_triangles, batch.n_pixels);
                self.paint(block, n_triangles, n_pixels, &mut Out::Linear(out));
                first += part.len();
            }
        }
    }

    /// Colours `rect` from ids, background where there are none; see [`TileShader::tile`].
    pub(crate) fn blocks(
        &mut self,
        rect: Region,
        ids: &[u32],
        stride: usize,
        out: &mut Target<'_>,
    ) -> u64 {
        let Settings { shading_rate, resolution, .. } = *self.scene.settings;
        let part = match (shading_rate, resolution) {
            (ShadingRate::One, Resolution::Adaptive) => Self::adaptive_block,
            (ShadingRate::One, _) => Self::block,
            (ShadingRate::Two, _) => {
                fill_background(self.scene.settings, rect, out);
                Self::coarse_block
            }
        };
        blocks(rect).map(|block| part(self, rect, block, ids, stride, out)).sum()
    }

    /// Colours the part of `rect` that lies in a block.
    fn block(
        &mut self,
        rect: Region,
        block: [u32; 2],
        ids: &[u32],
        stride: usize,
        out: &mut Target<'_>,
    ) -> u64 {
        let [left, top] = [block[0].max(rect.x), block[1].max(rect.y)];
        let right = (block[0] + BLOCK).min(rect.x + rect.width);
        let bottom = (block[1] + BLOCK).min(rect.y + rect.height);
        let mut batch = Batch::begin(self.scratch);
        for y in top..bottom {
            let (row, column) = ((y - rect.y) as usize, (left - rect.x) as usize);
            let start = row * stride + column;
            let ids = &ids[start..start + (right - left) as usize];
            let mut place = (row * out.stride + column) as u32;
            let (mut x, y) = ((left - block[0]) as f32 + 0.5, (y - block[1]) as f32 + 0.5);
            let (eights, rest) = ids.as_chunks::<8>();
            for eight in eights {
                batch.push8(eight, place, x, y);
                (place, x) = (place + 8, x + 8.0);
            }
            for &id in rest {
                batch.push(id, place, x, y);
                (place, x) = (place + 1, x + 1.0);
            }
        }
        let (n_triangles, n_pixels) = (batch.n_triangles, batch.n_pixels);
        let size = [right - left, bottom - top];
        if n_pixels < (size[0] * size[1]) as usize {
            let first = (top - rect.y) as usize * out.stride + (left - rect.x) as usize;
            fill_background_from(self.scene.settings, size, first, out);
        }
        let mut out = if out.linear.is_empty() {
            Out::Bytes(&mut *out.rgba8)
        } else {
            Out::Linear(&mut *out.linear)
        };
        self.paint(block, n_triangles, n_pixels, &mut out);
        n_pixels as u64
    }

    /// Colours the pixels of a batch.
    pub(crate) fn paint(
        &mut self,
        block: [u32; 2],
        n_triangles: usize,
        n_pixels: usize,
        out: &mut Out<'_>,
    ) {
        if n_pixels == 0 {
            return;
        }
        self.set_up(block, n_triangles);
        self.paint_more(block, n_triangles, n_pixels, out);
    }

    /// Colours more pixels of triangles that the last batch has set up.
    pub(crate) fn paint_more(
        &mut self,
        block: [u32; 2],
        n_triangles: usize,
        n_pixels: usize,
        out: &mut Out<'_>,
    ) {
        let n_paints = self.group_by_paint(n_triangles, n_pixels);
        let Scene { prepared, .. } = self.scene;
        let look = self.scene.look();
        let mut first = 0;
        for i in 0..self.scratch.paints.len() {
            let n = self.scratch.n_pixels_of_paint[i] as usize;
            if n == 0 {
                continue;
            }
            let ShadeScratch { paints, pixels, sorted, records, colors, points, left, .. } =
                &mut *self.scratch;
            let list = if n_paints == 1 { pixels } else { sorted };
            let list = &list[first..first + n];
            let surface = prepared.surface(&prepared.items()[paints[i].item]);
            let key = Paint::new(&surface, paints[i].needs, &look);
            left.clear();
            paint(&key, list, records, colors, points, out, left);
            if !left.is_empty() {
                self.paint_left(block, n_paints == 1, first, out);
            }
            first += n;
        }
    }

    /// Makes the records of the triangles of a batch.
    fn set_up(&mut self, block: [u32; 2], n_triangles: usize) {
        let Scene { prepared, settings, .. } = self.scene;
        let scratch = &mut *self.scratch;
        scratch.batch.clear();
        let draws_of = &mut scratch.draw_of[..n_triangles];
        for (id, draw) in scratch.ids.iter().zip(&mut *draws_of) {
            *draw = scratch.draws.of(&self.scene, &mut scratch.paints, *id);
        }
        for run in draws_of.chunk_by(|a, b| a == b) {
            let draw = &mut scratch.draws.all[run[0] as usize];
            if draw.n_wanted == 0 {
                scratch.batch.push(run[0]);
            }
            draw.n_wanted += run.len() as u32;
        }
        let mut first = 0;
        for draw in &scratch.batch {
            let draw = &mut scratch.draws.all[*draw as usize];
            draw.next = first;
            first += draw.n_wanted;
        }
        let mut record = 0;
        for run in draws_of.chunk_by(|a, b| a == b) {
            let draw = &mut scratch.draws.all[run[0] as usize];
            let wanted = &mut scratch.wanted[draw.next as usize..][..run.len()];
            draw.next += run.len() as u32;
            let ids = &scratch.ids[record..record + run.len()];
            scratch.paint_of[record..record + run.len()].fill(draw.paint);
            for (wanted, id) in wanted.iter_mut().zip(ids) {
                *wanted = (id - draw.first_triangle, record as u32);
                record += 1;
            }
        }
        let mut first = 0;
        for draw in &scratch.batch {
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
            set_up(settings.simd, &group, wanted, records, colors, &mut scratch.points);
            first += wanted.len();
            draw.n_wanted = 0;
        }
    }

    /// Sorts the pixels of a batch by paint, if there are several; returns how many there are.
    fn group_by_paint(&mut self, n_triangles: usize, n_pixels: usize) -> usize {
        let ShadeScratch {
            paints, batch, draws, paint_of, pixels, sorted, n_pixels_of_paint, ..
        } = &mut *self.scratch;
        let counts = n_pixels_of_paint;
        counts.clear();
        counts.resize(paints.len(), 0);
        let first = draws.all[batch[0] as usize].paint;
        if batch.iter().all(|draw| draws.all[*draw as usize].paint == first) {
            counts[first as usize] = n_pixels as u32;
            return 1;
        }
        for draw in &*batch {
            counts[draws.all[*draw as usize].paint as usize] = 1;
        }
        let (pixels, paint_of) = (&pixels[..n_pixels], &paint_of[..n_triangles]);
        // Once through all pixels for each paint: there are few, and branches would be many.
        let mut end = 0;
        for (paint, count) in (0..).zip(counts.iter_mut()).filter(|(_, count)| **count > 0) {
            let first = end;
            for pixel in pixels {
                sorted[end] = *pixel;
                end += usize::from(paint_of[pixel.record as usize] == paint);
            }
            *count = (end - first) as u32;
        }
        2
    }

    /// Colours the pixels that wide code has left, one by one.
    #[cold]
    fn paint_left(&mut self, block: [u32; 2], unsorted: bool, first: usize, out: &mut Out<'_>) {
        let scene = self.scene;
        let ShadeScratch { pixels, sorted, left, ids, corners, .. } = &mut *self.scratch;
        let list = if unsorted { pixels } else { sorted };
        let mut corners = Corners::new(&scene, corners);
        for &i in &*left {
            let pixel = &list[first + i as usize];
            let (triangle, interpolator) = corners.of(ids[pixel.record as usize]);
            let x = f64::from(block[0]) + f64::from(pixel.x);
            let y = f64::from(block[1]) + f64::from(pixel.y);
            let color = triangle.color(&scene, &interpolator.fragment_at([x, y]));
            match out {
                Out::Linear(out) => out[pixel.out as usize] = color,
                Out::Bytes(out) => out[pixel.out as usize] = encode(scene.settings.encoding, color),
            }
        }
    }
}

/// Corners of the blocks that a rectangle reaches.
fn blocks(rect: Region) -> impl Iterator<Item = [u32; 2]> {
    let first = |at: u32| at - at % BLOCK;
    let columns = move || (first(rect.x)..rect.x + rect.width).step_by(BLOCK as usize);
    (first(rect.y)..rect.y + rect.height)
        .step_by(BLOCK as usize)
        .flat_map(move |y| columns().map(move |x| [x, y]))
}

/// Pixels on their way into a batch.
pub(crate) struct Batch<'s> {
    /// The last slot is never looked at.
    table: &'s mut [u64; SLOTS + 1],
    ids: &'s mut [u32],
    pixels: &'s mut [Pixel],
    key: u64,
    pub(crate) n_triangles: usize,
    pub(crate) n_pixels: usize,
}

impl<'s> Batch<'s> {
    pub(crate) fn begin(scratch: &'s mut ShadeScratch) -> Self {
        scratch.epoch = scratch.epoch.wrapping_add(1);
        if scratch.epoch == 0 {
            scratch.table.fill(0);
            scratch.epoch = 1;
        }
        Batch {
            table: scratch.table.first_chunk_mut().expect("a table of that size"),
            ids: &mut scratch.ids,
            pixels: &mut scratch.pixels,
            key: u64::from(scratch.epoch) << 16,
            n_triangles: 0,
            n_pixels: 0,
        }
    }

    /// Without a branch, since neighbours of small triangles are beyond prediction: what is not to
    /// be kept is written where the next will be, or where nobody looks.
    #[inline(always)]
    pub(crate) fn push(&mut self, id: u32, out: u32, x: f32, y: f32) {
        let is_there = id != NO_TRIANGLE;
        let record = self.record_of(id, is_there);
        self.pixels[self.n_pixels] = Pixel { record, out, x, y };
        self.n_pixels += usize::from(is_there);
    }

    /// A place of a triangle whose record is known.
    #[inline(always)]
    pub(crate) fn put(&mut self, pixel: Pixel) {
        self.pixels[self.n_pixels] = pixel;
        self.n_pixels += 1;
    }

    /// Neighbours in a row.
    #[inline(always)]
    fn push8(&mut self, ids: &[u32; 8], out: u32, x: f32, y: f32) {
        let mut differences = 0;
        for id in ids {
            differences |= id ^ ids[0];
        }
        if differences != 0 {
            for (i, &id) in ids.iter().enumerate() {
                self.push(id, out + i as u32, x + i as f32, y);
            }
        } else if ids[0] != NO_TRIANGLE {
            let record = self.record_of(ids[0], true);
            let pixels = &mut self.pixels[self.n_pixels..self.n_pixels + 8];
            for (i, pixel) in pixels.iter_mut().enumerate() {
                *pixel = Pixel { record, out: out + i as u32, x: x + i as f32, y };
            }
            self.n_pixels += 8;
        }
    }

    /// The number of a triangle's record, a new one if it is not known.
    #[inline(always)]
    pub(crate) fn record_of(&mut self, id: u32, is_there: bool) -> u32 {
        let slot = (id ^ id >> 11) as usize % SLOTS;
        let (known, key) = (self.table[slot], u64::from(id) << 32 | self.key);
        let is_known = (known ^ key) >> 16 == 0;
        let record = if is_known { known & 0xffff } else { self.n_triangles as u64 };
        self.table[if is_known { SLOTS } else { slot }] = key | record;
        self.ids[self.n_triangles] = id;
        self.n_triangles += usize::from(!is_known & is_there);
        record as u32
    }
}

impl Draws {
    fn forget(&mut self) {
        for draw in self.all.drain(..) {
            if let Some(of_item) = self.of_item.get_mut(draw.item) {
                *of_item = 0;
            }
        }
    }

    /// The draw that triangle `id` is of.
    #[inline]
    fn of(&mut self, scene: &Scene<'_>, paints: &mut Vec<PaintKey>, id: u32) -> u32 {
        let hint = &mut self.hints[(id >> 6) as usize % HINTS];
        if let Some(draw) = self.all.get(*hint as usize)
            && id.wrapping_sub(draw.first_triangle) < draw.n_triangles
        {
            return *hint;
        }
        let item_idx = scene.prepared.item_of(id);
        if self.of_item[item_idx] == 0 {
            let item = &scene.prepared.items()[item_idx];
            let needs = scene.needs(item);
            let same = |key: &PaintKey| key.material == item.material && key.needs == needs;
            let paint = paints.iter().position(same).unwrap_or_else(|| {
                paints.push(PaintKey { material: item.material, needs, item: item_idx });
                paints.len() - 1
            });
            self.all.push(Draw {
                item: item_idx,
                first_triangle: item.first_triangle,
                n_triangles: item.n_triangles,
                placement: Placement::new(
                    scene.view.clip_from_model(&item.world_from_model),
                    scene.view.viewport(),
                    scene.planes[item_idx].unwrap_or_default(),
                    scene.settings.subpixel_bits,
                ),
                needs,
                paint: paint as u32,
                n_wanted: 0,
                next: 0,
            });
            self.of_item[item_idx] = self.all.len() as u32;
        }
        *hint = self.of_item[item_idx] - 1;
        *hint
    }
}

#[cfg(test)]
mod tests {
    use cullet_scene::synth::synth;
    use cullet_shade::PointLight;
    use cullet_transform::{PlaneMask, Viewport};
    use glam::{DVec3, Vec3};

    use super::*;
    use crate::{
        Antialias, CullTest, Frame, Pass, Prepared, Renderer, Settings, View, camera_of,
        frame_scene,
    };

    const SIZE: [u32; 2] = [150, 101];

    /// Prepared scenes with their own cameras: textures, colours, masks, mirrored nodes, slivers.
    fn scenes() -> Vec<(Prepared, View)> {
        let names = ["interior", "knots", "masks", "slivers:90", "city:3"];
        let scenes = names.into_iter().map(|name| {
            let prepared = Prepared::new(synth(name).unwrap()).unwrap();
            let viewport = Viewport::new(SIZE[0], SIZE[1]).unwrap();
            let camera = prepared.scene().cameras.first().and_then(|own| camera_of(own).ok());
            let camera = camera.unwrap_or_else(|| frame_scene(&prepared, viewport.aspect()));
            (prepared, View::new(&camera, viewport))
        });
        scenes.collect()
    }

    /// A picture of everything that colours come from, and of the colours.
    fn frame(prepared: &Prepared, view: &View, settings: &Settings) -> Frame {
        let mut frame = Frame::default();
        Renderer::default().render(prepared, view, settings, &mut frame);
        frame
    }

    fn settings() -> Settings {
        let passes = Passes::COLOR.with(Pass::Linear).with(Pass::Triangle);
        Settings { passes, antialias: Antialias::None, threads: 1, ..Settings::default() }
    }

    /// Calls `check` with a shader for each scene, its picture and the ids of that.
    fn for_each_scene(check: impl Fn(&mut TileShader<'_>, &Frame, &[u32])) {
        let settings = settings();
        for (prepared, view) in &scenes() {
            let frame = frame(prepared, view, &settings);
            let ids: Vec<u32> = frame.triangle.iter().map(|id| id.wrapping_sub(1)).collect();
            assert!(ids.iter().any(|id| *id != NO_TRIANGLE));
            // Which planes cut what: with all of them asked about nothing is missed.
            let planes = vec![Some(PlaneMask::ALL); prepared.items().len()];
            let scene = Scene { prepared, view, settings: &settings, planes: &planes };
            check(&mut TileShader::new(scene, &mut ShadeScratch::default()), &frame, &ids);
        }
    }

    #[test]
    fn any_places_in_any_order_have_the_colours_of_the_picture() {
        for_each_scene(|shader, frame, ids| {
            let seen = (0..).zip(ids).filter(|(_, id)| **id != NO_TRIANGLE);
            let seen: Vec<(usize, u32)> = seen.map(|(i, id)| (i, *id)).collect();
            let wanted = |&(i, id): &(usize, u32)| {
                let [x, y] = [i as i32 % SIZE[0] as i32, i as i32 / SIZE[0] as i32];
                Wanted { id, x: 16 * x + 8, y: 16 * y + 8 }
            };
            for step in [1, 7, 64] {
                let part: Vec<_> = seen.iter().rev().step_by(step).collect();
                let wanted: Vec<Wanted> = part.iter().map(|seen| wanted(seen)).collect();
                let mut colors = vec![Vec4::NAN; wanted.len()];
                shader.colors(&wanted, &mut colors);
                for ((i, _), color) in part.iter().zip(&colors) {
                    assert_eq!(*color, frame.linear[*i], "pixel {i}, every {step}");
                }
            }
        });
    }

    #[test]
    fn squares_of_pixels_have_the_colour_of_their_middle() {
        for_each_scene(|shader, _, ids| {
            let Scene { prepared, view, .. } = shader.scene;
            let coarse = Settings { shading_rate: ShadingRate::Two, ..settings() };
            let coarse = frame(prepared, view, &coarse);
            let seen = (0..).zip(ids).filter(|(_, id)| **id != NO_TRIANGLE);
            let seen: Vec<(usize, u32)> = seen.map(|(i, id)| (i, *id)).collect();
            let wanted = |&(i, id): &(usize, u32)| {
                let [x, y] = [i as i32 % SIZE[0] as i32, i as i32 / SIZE[0] as i32];
                let [x, y] = [x & !1, y & !1];
                Wanted { id, x: 16 * x + 16, y: 16 * y + 16 }
            };
            let wanted: Vec<Wanted> = seen.iter().map(wanted).collect();
            let mut colors = vec![Vec4::NAN; wanted.len()];
            shader.colors(&wanted, &mut colors);
            for ((i, _), color) in seen.iter().zip(&colors) {
                assert_eq!(*color, coarse.linear[*i], "pixel {i}");
            }
            let ids_too: Vec<u32> = coarse.triangle.iter().map(|id| id.wrapping_sub(1)).collect();
            assert!(ids_too == ids);
            for antialias in [Antialias::None, Antialias::Msaa4] {
                let passes = Passes::COLOR;
                let shading_rate = ShadingRate::Two;
                let whole = Settings { passes, shading_rate, antialias, ..settings() };
                let region = Region { x: 33, y: 21, width: 71, height: 55 };
                let part = Settings { region: Some(region), tile_px: 24, ..whole };
                let (whole, part) = (frame(prepared, view, &whole), frame(prepared, view, &part));
                for (y, row) in part.rgba8.chunks(71).enumerate() {
                    let start = (21 + y) * SIZE[0] as usize + 33;
                    assert!(row == &whole.rgba8[start..start + 71], "row {y}");
                }
            }
        });
    }

    /// A sample that the triangle covers is asked of the plain code, at the same place.
    #[test]
    fn off_centre_colours_are_those_of_the_plain_code() {
        for_each_scene(|shader, _, ids| {
            let scene = shader.scene;
            let mut slots = CornerSlots::default();
            let mut corners = Corners::new(&scene, &mut slots);
            let mut wanted = Vec::new();
            for (i, &id) in ids.iter().enumerate().filter(|(_, id)| **id != NO_TRIANGLE) {
                let [x, y] = [i as i32 % SIZE[0] as i32, i as i32 / SIZE[0] as i32];
                let place = Wanted { id, x: 16 * x + 3, y: 16 * y + 11 };
                let (_, interpolator) = corners.of(id);
                let at = [place.x, place.y].map(|at| f64::from(at) / 16.0);
                let weights = interpolator.fragment_at(at).weights;
                if weights.min_element() > 0.0 && weights != glam::DVec3::splat(1.0 / 3.0) {
                    wanted.push(place);
                }
            }
            assert!(wanted.len() > 500);
            let mut colors = vec![Vec4::NAN; wanted.len()];
            shader.colors(&wanted, &mut colors);
            let mut errors: Vec<f32> = Vec::new();
            for (place, color) in wanted.iter().zip(&colors) {
                let (triangle, interpolator) = corners.of(place.id);
                let at = [place.x, place.y].map(|at| f64::from(at) / 16.0);
                let plain = triangle.color(&scene, &interpolator.fragment_at(at));
                errors.push((*color - plain).abs().max_element());
            }
            errors.sort_by(f32::total_cmp);
            let (len, worst) = (errors.len(), errors[errors.len() - 1]);
            println!(
                "{}: p99 {:.1e}, worst {worst:.1e}",
                scene.prepared.scene().name,
                errors[len * 99 / 100]
            );
            // Textures of 512 texels: a place 1e-7 off is 5e-5 of a texel off.
            assert!(errors[len * 99 / 100] < 1e-4 && worst < 2e-3);
        });
    }

    /// Outside of its triangle, before and behind the eye, a colour is still a colour.
    #[test]
    fn places_that_are_not_covered_are_harmless() {
        for_each_scene(|shader, _, ids| {
            let known = ids.iter().filter(|id| **id != NO_TRIANGLE).step_by(11);
            let wanted: Vec<Wanted> = (0..)
                .zip(known)
                .map(|(i, &id)| Wanted {
                    id,
                    x: i * 7919 % (16 * SIZE[0] as i32),
                    y: i * 6367 % (16 * SIZE[1] as i32),
                })
                .collect();
            let mut colors = vec![Vec4::NAN; wanted.len()];
            shader.colors(&wanted, &mut colors);
            assert!(colors.iter().all(|color| color.is_finite()));
        });
    }

    /// A light that reaches some objects of a scene, and part of some of those.
    #[test]
    fn a_light_at_a_point_is_that_of_the_plain_code_and_skipped_where_it_ends() {
        for (prepared, view) in &scenes() {
            let bounds = prepared.bounds();
            let size = bounds.half_extent().length();
            let place = bounds.center() + DVec3::new(0.2, 0.2, 0.3) * size;
            let mut pictures = Vec::new();
            for radius in [0.0, 0.3, 1.0, f64::INFINITY] {
                let radius = (radius * size) as f32;
                let light = PointLight::new(place, Vec3::new(9.0, 5.0, 2.0), radius).unwrap();
                let settings = Settings { point_light: Some(light), ..settings() };
                let lit = frame(prepared, view, &settings);
                let all = Settings { cull: CullTest::None, ..settings };
                assert!(frame(prepared, view, &all).linear == lit.linear, "{radius}");
                let planes = vec![Some(PlaneMask::ALL); prepared.items().len()];
                let scene = Scene { prepared, view, settings: &all, planes: &planes };
                let mut slots = CornerSlots::default();
                let mut corners = Corners::new(&scene, &mut slots);
                let mut errors = Vec::new();
                for (i, id) in lit.triangle.iter().enumerate().filter(|(_, id)| **id != 0) {
                    let (triangle, interpolator) = corners.of(id - 1);
                    let [x, y] = [i as u32 % SIZE[0], i as u32 / SIZE[0]];
                    let plain = triangle.color(&scene, &interpolator.fragment(x, y));
                    assert!(plain.is_finite());
                    errors.push((lit.linear[i] - plain).abs().max_element());
                }
                errors.sort_by(f32::total_cmp);
                assert!(errors[errors.len() * 99 / 100] < 1e-3, "{radius}");
                pictures.push(lit.linear);
            }
            assert!(pictures[0] == frame(prepared, view, &settings()).linear);
            assert!(pictures[3] != pictures[0]);
        }
    }

    #[test]
    fn a_picture_in_parts_is_the_picture() {
        let settings = Settings { passes: Passes::COLOR, ..settings() };
        for (prepared, view) in &scenes() {
            let whole = frame(prepared, view, &settings);
            for region in [
                Region { x: 0, y: 0, width: 150, height: 1 },
                Region { x: 63, y: 62, width: 3, height: 37 },
                Region { x: 149, y: 0, width: 1, height: 101 },
                Region { x: 17, y: 5, width: 100, height: 90 },
            ] {
                let part = Settings { region: Some(region), ..settings };
                let part = frame(prepared, view, &part);
                for y in 0..region.height {
                    let start = ((region.y + y) * SIZE[0] + region.x) as usize;
                    let width = region.width as usize;
                    let row = &part.rgba8[y as usize * width..][..width];
                    assert!(row == &whole.rgba8[start..start + width], "{region:?}, row {y}");
                }
            }
        }
    }
}
