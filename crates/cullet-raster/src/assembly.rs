//! Primitive assembly: a cluster on the screen, made once, drawn into every tile that it reaches.
//!
//! Vertices are placed, triangles decided, eight at a time: what is outside, has no area or faces
//! away is counted and gone. Of the others the borders are kept, so that a tile finds its own
//! quickly. The few triangles that are clipped, or larger than 64 px, take the plain set-up and are
//! kept as screen triangles.

use cullet_transform::{ClipPoint, PlaneMask, Viewport};
use fearless_simd::{Level, Simd, i32x8, mask32x8, prelude::*, u32x8};
use glam::{DMat4, Vec3};

use crate::clip::{GuardBand, Polygon};
use crate::fixed::Fixed;
use crate::level::dispatch_wide;
use crate::piece::PieceBox;
use crate::placed::{Lens, MAX_VERTICES, Placed};
use crate::plain;
use crate::precision::{Precision, Transforms};
use crate::prefetch::prefetch_all;
use crate::samples::Samples;
use crate::setup::{Facing, Outcome, Placer, ScreenTriangle, SetupCounters, Vertex, whole};

/// Subpixel bits of the fast path.
pub(crate) const BITS: u32 = 8;

/// Most triangles of a cluster.
pub const MAX_TRIANGLES: usize = 128;

/// Spans from which on products of differences might leave 32 bits.
const LARGE: i32 = 1 << 14;

/// Triangles of an object that lie together, with vertices of their own.
#[derive(Clone, Copy, Debug)]
pub struct Cluster<'a> {
    /// Model-space x, y and z of the vertices, as many values each: whole groups of eight, the last
    /// filled up with any, at most [`MAX_VERTICES`](crate::MAX_VERTICES).
    pub positions: [&'a [f32]; 3],
    /// Corners of the triangles, at most [`MAX_TRIANGLES`], indices into the vertices; the fourth
    /// number has no meaning.
    pub corners: &'a [[u8; 4]],
    /// What to add to the object's first id to have each triangle's.
    pub ids: &'a [u32],
}

/// What the triangles of an object share in a view.
#[derive(Clone, Copy, Debug)]
pub struct Object {
    /// Model to clip space.
    pub clip_from_model: DMat4,
    /// The picture.
    pub viewport: Viewport,
    /// Planes that may cut the object; others are not tested.
    pub planes: PlaneMask,
    /// Which side is drawn.
    pub facing: Facing,
    /// Id of the object's first triangle.
    pub first_id: u32,
    /// How exactly it is drawn.
    pub precision: Precision,
    /// Where pixels are sampled. Tiles may be drawn with one sample as well.
    pub samples: Samples,
}

/// A cluster in a view, whatever the tile: its triangles that may hold a sample.
#[derive(Clone, Debug)]
pub struct Assembly {
    pub(crate) placed: Placed,
    /// How many places there are in the following, in whole groups of eight.
    pub(crate) n: usize,
    /// Corners, clockwise as seen; the fourth number has no meaning.
    pub(crate) corners: [[u8; 4]; MAX_TRIANGLES],
    pub(crate) ids: [u32; MAX_TRIANGLES],
    /// Borders, units: left, right, upper, lower. At places of triangles that are not drawn the left one is to the
    /// right of the right one, beyond every tile.
    pub(crate) borders: [[i32; MAX_TRIANGLES]; 4],
    /// Keys of the nearest corners; unless pixels have one sample.
    pub(crate) nearest: [i32; MAX_TRIANGLES],
    /// Clipped and large triangles, nearest first; all triangles, where the wide code does not serve.
    pub(crate) pieces: Vec<ScreenTriangle>,
    /// Where each of them may show, for the wide code.
    pub(crate) boxes: Vec<PieceBox>,
    /// Ids of clipped triangles.
    clipped: Vec<u32>,
    pub(crate) precision: Precision,
    pub(crate) samples: Samples,
    /// The instruction set that draws it; none if all of it is in `pieces`, for the plain code.
    pub(crate) wide: Option<Level>,
    /// Of the plain way.
    vertices: Vec<Vertex>,
    counters: SetupCounters,
}

impl Default for Assembly {
    fn default() -> Self {
        Assembly {
            placed: Placed::default(),
            n: 0,
            corners: [[0; 4]; MAX_TRIANGLES],
            ids: [0; MAX_TRIANGLES],
            borders: [[0; MAX_TRIANGLES]; 4],
            nearest: [0; MAX_TRIANGLES],
            pieces: Vec::new(),
            boxes: Vec::new(),
            clipped: Vec::new(),
            precision: Precision::default(),
            samples: Samples::One,
            wide: None,
            vertices: Vec::new(),
            counters: SetupCounters::default(),
        }
    }
}

/// A left border beyond all others.
const NOWHERE: i32 = i32::MAX / 2;

impl Assembly {
    /// Makes it that of `cluster`, to be drawn with the instructions of `level`.
    pub fn assemble(&mut self, level: Level, cluster: &Cluster<'_>, object: &Object) {
        self.n = 0;
        self.pieces.clear();
        self.boxes.clear();
        self.clipped.clear();
        (self.precision, self.samples) = (object.precision, object.samples);
        let is_wide = object.precision.is_wide() && !level.is_fallback();
        self.wide = is_wide.then_some(level);
        if is_wide {
            self.assemble_wide(level, cluster, object);
        } else {
            let Assembly { vertices, pieces, clipped, .. } = self;
            self.counters = plain::assemble(cluster, object, vertices, pieces, clipped);
        }
        // Large triangles hide each other, and what is hidden costs little. Ids make counters the same
        // whatever sorts them.
        self.pieces.sort_unstable_by(|a, b| {
            b.nearest().total_cmp(&a.nearest()).then_with(|| a.id.cmp(&b.id))
        });
        if is_wide {
            self.boxes.extend(self.pieces.iter().map(|piece| PieceBox::new(piece, object.samples)));
        }
    }

    fn assemble_wide(&mut self, level: Level, cluster: &Cluster<'_>, object: &Object) {
        let lens = Lens {
            clip_from_model: object.clip_from_model,
            viewport: object.viewport,
            planes: object.planes,
            guard: GuardBand::new(object.viewport, BITS),
        };
        for list in cluster.positions {
            prefetch_all(list, 0..list.len());
        }
        prefetch_all(cluster.corners, 0..cluster.corners.len());
        prefetch_all(cluster.ids, 0..cluster.ids.len());
        let n = cluster.corners.len().min(MAX_TRIANGLES);
        self.counters = SetupCounters { n_in: n as u64, ..SetupCounters::default() };
        let mut job = Job { out: self, cluster, object, lens, keys: [0; MAX_VERTICES] };
        dispatch_wide!(level, simd => job.run(simd, n));
    }

    /// What became of the triangles.
    pub fn counters(&self) -> SetupCounters {
        self.counters
    }

    /// Ids of triangles that were clipped and drawn. Their depths are those of the snapped pieces, so they are
    /// good for comparing, not for reading distances off them.
    pub fn clipped(&self) -> &[u32] {
        &self.clipped
    }

    /// Memory held beside the assembly itself.
    pub fn bytes(&self) -> usize {
        self.pieces.capacity() * size_of::<ScreenTriangle>()
            + self.boxes.capacity() * size_of::<PieceBox>()
            + self.clipped.capacity() * 4
            + self.vertices.capacity() * size_of::<Vertex>()
    }
}

struct Job<'j> {
    out: &'j mut Assembly,
    cluster: &'j Cluster<'j>,
    object: &'j Object,
    lens: Lens,
    /// Of the depths of vertices, unless pixels have one sample.
    keys: [i32; MAX_VERTICES],
}

impl Job<'_> {
    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S, n: usize) {
        let (placed, positions) = (&mut self.out.placed, self.cluster.positions);
        match self.object.precision.transforms {
            Transforms::F64 => placed.place::<S, BITS>(simd, &self.lens, positions),
            Transforms::F32 => placed.place_single::<S, BITS>(simd, &self.lens, positions),
        }
        if self.object.samples != Samples::One {
            placed.find_keys(simd, positions[0].len(), &mut self.keys);
        }
        for first in (0..n).step_by(8) {
            self.eight(simd, first, (n - first).min(8));
        }
    }

    #[inline(always)]
    fn corners(&self, triangle: usize) -> [usize; 3] {
        // No `map`: its closures would not be compiled for the instruction set.
        let [a, b, c, _] = self.cluster.corners[triangle];
        [a as usize, b as usize, c as usize]
    }

    /// Triangles `first..first + n`.
    #[inline(always)]
    fn eight<S: Simd>(&mut self, simd: S, first: usize, n: usize) {
        let corners = eight_from(self.cluster.corners, first);
        let (mut x, mut y) = ([[0; 8]; 3], [[0; 8]; 3]);
        let placed = &self.out.placed;
        for lane in 0..8 {
            let [a, b, c, _] = corners[lane];
            let [a, b, c] = [a as usize, b as usize, c as usize];
            (x[0][lane], x[1][lane], x[2][lane]) = (placed.x[a], placed.x[b], placed.x[c]);
            (y[0][lane], y[1][lane], y[2][lane]) = (placed.y[a], placed.y[b], placed.y[c]);
        }
        let mut plain = 0xffu64 >> (8 - n);
        if self.out.placed.special {
            plain = self.special(first, n);
        }
        let [ax, bx, cx] = load(simd, x);
        let [ay, by, cy] = load(simd, y);
        let (left, right) = (ax.min(bx).min(cx), ax.max(bx).max(cx));
        let (upper, lower) = (ay.min(by).min(cy), ay.max(by).max(cy));
        let span = (right - left) | (lower - upper);
        let mut large = span.simd_ge(LARGE).to_bitmask() & plain;
        plain &= !large;
        let area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
        let clockwise = area.simd_gt(0).to_bitmask();
        let zero = area.simd_eq(0).to_bitmask() & plain;
        let (one, other) = (clockwise & plain, plain & !clockwise & !zero);
        let (mut drawn, away) = match self.object.facing {
            Facing::Both => (one | other, 0),
            Facing::CounterClockwise => (other, one),
            Facing::Clockwise => (one, other),
        };
        let counters = &mut self.out.counters;
        counters.n_zero_area += u64::from(zero.count_ones());
        counters.n_facing_away += u64::from(away.count_ones());
        counters.n_drawn += u64::from(drawn.count_ones());

        drawn &= hold_samples([left, right, upper, lower], self.object.samples);
        if drawn != 0 {
            let ids = eight_from(self.cluster.ids, first);
            let ids = u32x8::simd_from(simd, ids) + self.object.first_id;
            // All eight as they are: what is not drawn lies nowhere. To pack what is drawn takes longer than to
            // pass it over.
            let drawn: mask32x8<S> = SimdMask::from_bitmask(simd, drawn);
            let left = drawn.select(left, i32x8::splat(simd, NOWHERE));
            let out = &mut *self.out;
            let group = out.n..out.n + 8;
            let [lefts, rights, uppers, lowers] = &mut out.borders;
            left.store_slice(&mut lefts[group.clone()]);
            right.store_slice(&mut rights[group.clone()]);
            upper.store_slice(&mut uppers[group.clone()]);
            lower.store_slice(&mut lowers[group.clone()]);
            // A pixel of one sample is drawn as soon as asked about.
            if self.object.samples != Samples::One {
                let mut key = [[0; 8]; 3];
                for lane in 0..8 {
                    let [a, b, c, _] = corners[lane];
                    let [a, b, c] = [a as usize, b as usize, c as usize];
                    (key[0][lane], key[1][lane], key[2][lane]) =
                        (self.keys[a], self.keys[b], self.keys[c]);
                }
                let [a, b, c] = load(simd, key);
                a.max(b).max(c).store_slice(&mut out.nearest[group.clone()]);
            }
            ids.store_slice(&mut out.ids[group.clone()]);
            let turned: [u32; 8] = turned(simd, corners, area).into();
            let into = out.corners[group].first_chunk_mut::<8>().expect("a group of eight");
            for lane in 0..8 {
                into[lane] = turned[lane].to_le_bytes();
            }
            out.n += 8;
        }
        while large != 0 {
            self.one(first + large.trailing_zeros() as usize);
            large &= large - 1;
        }
    }

    /// Deals with those that planes have to do with; returns the others.
    #[inline(never)]
    fn special(&mut self, first: usize, n: usize) -> u64 {
        let mut plain = 0xffu64 >> (8 - n);
        for lane in 0..n {
            let [a, b, c] = self.corners(first + lane);
            let placed = &self.out.placed;
            if placed.outside[a] & placed.outside[b] & placed.outside[c] != 0 {
                self.out.counters.n_outside += 1;
                plain &= !(1 << lane);
            } else if placed.cuts[a] | placed.cuts[b] | placed.cuts[c] != 0 {
                self.one(first + lane);
                plain &= !(1 << lane);
            }
        }
        plain
    }

    /// [`crate::set_up`] for one triangle that is not outside.
    #[inline(never)]
    fn one(&mut self, index: usize) {
        let [x, y, z] = self.cluster.positions;
        let [a, b, c] = self.corners(index);
        let id = self.object.first_id + self.cluster.ids[index];
        let facing = self.object.facing;
        let transforms = self.object.precision.transforms;
        let point =
            |i: usize| transforms.clip(&self.lens.clip_from_model, Vec3::new(x[i], y[i], z[i]));
        let Assembly { placed, pieces, clipped, counters, .. } = &mut *self.out;
        let cuts = PlaneMask::from_bits(placed.cuts[a] | placed.cuts[b] | placed.cuts[c]);
        let outcome = if cuts.is_empty() {
            let at = |i: usize| Fixed { x: placed.x[i].into(), y: placed.y[i].into() };
            let depth = [placed.depth[a], placed.depth[b], placed.depth[c]];
            whole([at(a), at(b), at(c)], depth, facing, id, pieces)
        } else {
            let points = [point(a), point(b), point(c)];
            if !points.iter().all(ClipPoint::is_finite) {
                counters.n_not_finite += 1;
                return;
            }
            let polygon = self.lens.guard.clip(Polygon::triangle(&points), cuts);
            let placer = Placer::<BITS>::with(transforms, self.lens.viewport, self.lens.planes);
            let outcome = placer.finish(polygon.corners(), facing, id, pieces);
            if matches!(outcome, Outcome::Drawn) {
                clipped.push(id);
            }
            outcome
        };
        counters.count(outcome, !cuts.is_empty());
    }
}

/// Eight of a list; beyond its last there is any other, which nobody looks at.
#[inline(always)]
fn eight_from<T: Copy + Default>(list: &[T], first: usize) -> [T; 8] {
    let rest = &list[first..];
    if let Some(eight) = rest.first_chunk() {
        return *eight;
    }
    let mut eight = [T::default(); 8];
    eight[..rest.len()].copy_from_slice(rest);
    eight
}

/// Corners in clockwise order, a byte each from the lowest on: the second and the third change places
/// where twice the area is not positive.
#[inline(always)]
fn turned<S: Simd>(simd: S, corners: [[u8; 4]; 8], area: i32x8<S>) -> u32x8<S> {
    let [a, b, c, d, e, f, g, h] = corners;
    let whole = [
        u32::from_le_bytes(a),
        u32::from_le_bytes(b),
        u32::from_le_bytes(c),
        u32::from_le_bytes(d),
        u32::from_le_bytes(e),
        u32::from_le_bytes(f),
        u32::from_le_bytes(g),
        u32::from_le_bytes(h),
    ];
    let whole = u32x8::simd_from(simd, whole) & 0x00ff_ffff;
    let swapped = whole & 0xff | (whole & 0xff00) << 8 | whole >> 8 & 0xff00;
    area.simd_gt(0).select(whole, swapped)
}

/// Which of eight boxes between borders have a sample between them, a bit each.
#[inline(always)]
fn hold_samples<S: Simd>([left, right, upper, lower]: [i32x8<S>; 4], samples: Samples) -> u64 {
    let [columns, rows] = [pixels8(left, right, samples), pixels8(upper, lower, samples)];
    (columns[0].simd_lt(columns[1]) & rows[0].simd_lt(rows[1])).to_bitmask()
}

/// Pixels along an axis that may have samples between two borders: the first, and the one after the last.
#[inline(always)]
pub(crate) fn pixels8<S: Simd>(low: i32x8<S>, high: i32x8<S>, samples: Samples) -> [i32x8<S>; 2] {
    let reach = 16 * samples.reach();
    [(low + (127 - reach)) >> 8, ((high + (reach - 128)) >> 8) + 1]
}

#[inline(always)]
pub(crate) fn load<S: Simd>(simd: S, [a, b, c]: [[i32; 8]; 3]) -> [i32x8<S>; 3] {
    [i32x8::simd_from(simd, a), i32x8::simd_from(simd, b), i32x8::simd_from(simd, c)]
}
