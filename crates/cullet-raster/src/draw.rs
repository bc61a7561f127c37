//! An assembled cluster into a tile: find its triangles there, set them up eight at a time, fill.
//!
//! With [`Assembly`] the fast path of [`crate::set_up`] and [`crate::cover`], with the same result
//! to the last bit.

use fearless_simd::{Level, Simd, i32x8, prelude::*};

use crate::assembly::{Assembly, BITS, MAX_TRIANGLES, load};
use crate::blocks::fill_blocks;
use crate::boxes8::Boxes;
use crate::depth::{ReversedF32, reversed_key};
use crate::depth8::{Corners8, Planes8};
use crate::edges8::{Eight, edge, lane_of};
use crate::fill::{self, KeepSample, TileTriangle, fill};
use crate::level::dispatch_wide;
use crate::narrow;
use crate::patch::{self, Values};
use crate::piece::{PieceBox, Place, in_tile};
use crate::plain::{self, fill_plain};
use crate::samples::{Offset, Samples};
use crate::setup::ScreenTriangle;
use crate::small::{self, Small};
use crate::small_patch;
use crate::tile::TileBuffer;

/// How often a block must have been written to for its farthest sample to be looked for again on behalf
/// of one triangle.
const WORTH_A_LOOK: u32 = 4;

/// Draws `assembly` into `tile`, which has the samples that it was made for, or one. `keep` is asked per sample where
/// the material has holes. Returns how many samples were won, later losers included, which depends on the order of
/// triangles. The picture depends neither on that, nor on the order of calls, nor on the instruction set that the
/// assembly was made for.
pub fn draw(tile: &mut TileBuffer, assembly: &Assembly, keep: Option<&mut KeepSample<'_>>) -> u64 {
    debug_assert!([Samples::One, assembly.samples].contains(&tile.samples()), "made for others");
    let Some(level) = assembly.wide else { return plain::draw(tile, assembly, keep) };
    // One copy of the wide code per number of samples.
    match tile.samples() {
        Samples::One => draw_any::<1>(level, tile, assembly, keep),
        Samples::Two => draw_any::<2>(level, tile, assembly, keep),
        Samples::Four => draw_any::<4>(level, tile, assembly, keep),
        Samples::Eight => draw_any::<8>(level, tile, assembly, keep),
    }
}

fn draw_any<const N: usize>(
    level: Level,
    tile: &mut TileBuffer,
    assembly: &Assembly,
    keep: Option<&mut KeepSample<'_>>,
) -> u64 {
    let mut offsets = [[0; 2]; N];
    offsets.copy_from_slice(tile.samples().offsets());
    let mut job = Job { tile, assembly, offsets, keep, n_won: 0 };
    dispatch_wide!(level, simd => job.run(simd));
    job.n_won
}

/// Clusters with so many places for triangles are worth looking again at blocks.
const MANY: usize = 32;

/// How often a block was written to for its farthest sample to be looked for again on behalf of a cluster.
const TOUCHES: u32 = 16;

struct Job<'j, 'k, const N: usize> {
    tile: &'j mut TileBuffer,
    assembly: &'j Assembly,
    offsets: [Offset; N],
    keep: Option<&'j mut KeepSample<'k>>,
    n_won: u64,
}

impl<const N: usize> Job<'_, '_, N> {
    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S) {
        let mut here = [0u8; MAX_TRIANGLES + 8];
        let mut n = 0;
        if N > 1 && self.assembly.n >= MANY {
            self.tile.look_again::<_, TOUCHES>(simd);
        }
        for first in (0..self.assembly.n).step_by(8) {
            let [left, right, upper, lower] = &self.assembly.borders;
            let boxes = Boxes::new(
                self.tile,
                i32x8::from_slice(simd, &left[first..first + 8]),
                i32x8::from_slice(simd, &right[first..first + 8]),
                i32x8::from_slice(simd, &upper[first..first + 8]),
                i32x8::from_slice(simd, &lower[first..first + 8]),
            );
            let mut holds = boxes.hold();
            let corners = boxes.corners(self.tile);
            while holds != 0 {
                let lane = holds.trailing_zeros() as usize % 8;
                holds &= holds - 1;
                here[n] = (first + lane) as u8;
                let nearest = self.assembly.nearest[first + lane];
                // A pixel of one sample is drawn as soon as asked about. No branch: nobody could foresee it.
                let is_hidden = N > 1 && corners.hide(self.tile, lane, nearest);
                n += usize::from(!is_hidden);
            }
        }
        for first in (0..n).step_by(8) {
            let eight = here[first..].first_chunk().expect("a margin of eight");
            self.eight(simd, eight, (n - first).min(8));
        }
        let Assembly { pieces, boxes, .. } = self.assembly;
        for i in 0..pieces.len() {
            if self.may_show(&boxes[i]) {
                self.screen_triangle(simd, &pieces[i]);
            }
        }
    }

    /// Whether a screen triangle reaches the tile and is not behind all of it.
    #[inline(always)]
    fn may_show(&self, PieceBox { x, y, nearest }: &PieceBox) -> bool {
        let side = self.tile.side() as i32;
        let [left, top] = self.tile.origin();
        x[0] < left + side
            && x[1] > left
            && y[0] < top + side
            && y[1] > top
            && !self.tile.all_hides(*nearest)
    }

    /// The first `n` of eight triangles that have a box here.
    #[inline(always)]
    fn eight<S: Simd>(&mut self, simd: S, triangles: &[u8; 8], n: usize) {
        let assembly = self.assembly;
        let placed = &assembly.placed;
        let (mut x, mut y) = ([[0; 8]; 3], [[0; 8]; 3]);
        let mut depth = [[0.0; 8]; 3];
        let mut id = [0; 8];
        // Not a loop of eight: of that the compiler makes gathers, which are slow.
        let mut lane = 0;
        while lane < n {
            let triangle = triangles[lane % 8] as usize % MAX_TRIANGLES;
            let [a, b, c, _] = assembly.corners[triangle];
            let [a, b, c] = [a as usize, b as usize, c as usize];
            (x[0][lane], x[1][lane], x[2][lane]) = (placed.x[a], placed.x[b], placed.x[c]);
            (y[0][lane], y[1][lane], y[2][lane]) = (placed.y[a], placed.y[b], placed.y[c]);
            (depth[0][lane], depth[1][lane], depth[2][lane]) =
                (placed.depth[a], placed.depth[b], placed.depth[c]);
            id[lane] = assembly.ids[triangle];
            lane += 1;
        }
        let [ax, bx, cx] = load(simd, x);
        let [ay, by, cy] = load(simd, y);
        let boxes = Boxes::new(
            self.tile,
            ax.min(bx).min(cx),
            ax.max(bx).max(cx),
            ay.min(by).min(cy),
            ay.max(by).max(cy),
        );
        let ([start_x, end_x], [start_y, end_y]) = (boxes.x, boxes.y);
        let area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
        let [left, top] = self.tile.origin();
        let (px, py) = (((start_x + left) << 8) + 128, ((start_y + top) << 8) + 128);
        let edges = [
            edge(simd, bx, by, cx, cy, px, py),
            edge(simd, cx, cy, ax, ay, px, py),
            edge(simd, ax, ay, bx, by, px, py),
        ];
        let (width, height) = (end_x - start_x, end_y - start_y);
        let mut todo = 0xffu64 >> (8 - n);
        let limit = if N == 1 { small::SMALL } else { small_patch::SMALL };
        let small = width.max(height).simd_le(limit).to_bitmask() & todo;
        let corners = Corners8 {
            area,
            corner: [ax, ay],
            drop: [edges[0].drop, edges[1].drop, edges[2].drop],
            run: [edges[0].run, edges[1].run, edges[2].run],
            depth: &depth,
        };
        let planes = corners.planes(simd);
        let is_worth_it = N > 1 || small & small.wrapping_sub(1) != 0;
        if self.keep.is_none() && small != 0 && is_worth_it {
            todo &= !small;
            let small8 = Small {
                x: start_x,
                y: start_y,
                width,
                height,
                value: [edges[0].value, edges[1].value, edges[2].value],
                left: corners.drop,
                down: corners.run,
                planes,
                depth: &depth,
                id: &id,
            };
            let n_won = match N {
                1 => small8.fill(simd, self.tile, small),
                _ => {
                    let rest = [edges[0].rest, edges[1].rest, edges[2].rest];
                    let pairs = [edges[0].pair(), edges[1].pair(), edges[2].pair()];
                    small8.fill_patches::<N>(simd, self.tile, small, rest, pairs)
                }
            };
            self.n_won += u64::from(n_won);
        }
        if todo == 0 {
            return;
        }
        let eight = Eight {
            x: [start_x.into(), end_x.into()],
            y: [start_y.into(), end_y.into()],
            value: [edges[0].value.into(), edges[1].value.into(), edges[2].value.into()],
            rest: [edges[0].rest.into(), edges[1].rest.into(), edges[2].rest.into()],
            left: [edges[0].drop.into(), edges[1].drop.into(), edges[2].drop.into()],
            down: [edges[0].run.into(), edges[1].run.into(), edges[2].run.into()],
            pairs: [edges[0].pair().into(), edges[1].pair().into(), edges[2].pair().into()],
            planes: Planes8::new(simd, planes),
        };
        while todo != 0 {
            let lane = todo.trailing_zeros() as usize;
            todo &= todo - 1;
            let depth = [depth[0][lane], depth[1][lane], depth[2][lane]];
            // A few pixels are drawn as soon as asked about; those of materials without holes have been, above.
            let is_small = N > 1 && small >> lane & 1 != 0;
            if !is_small {
                let nearest = depth[0].max(depth[1]).max(depth[2]);
                let key = reversed_key(nearest as f32);
                if self.tile.blocks_hide::<_, WORTH_A_LOOK>(simd, eight.rect(lane), key) {
                    continue;
                }
            }
            let triangle = eight.triangle(lane, id[lane], depth);
            let keep = self.keep.as_deref_mut();
            let pairs = lane_of(&eight.pairs, lane);
            let is_narrow = triangle.rect.x[1] - triangle.rect.x[0] <= narrow::SIDE;
            let won = match N {
                1 if is_narrow && keep.is_none() => narrow::fill(simd, self.tile, &triangle, pairs),
                1 => fill(simd, self.tile, &triangle, keep),
                _ => {
                    let values = Values::of_short::<N>(simd, &triangle, pairs);
                    patch::fill::<S, N>(simd, self.tile, &triangle, values, keep)
                }
            };
            self.n_won += u64::from(won);
        }
    }

    #[inline(always)]
    fn screen_triangle<S: Simd>(&mut self, simd: S, triangle: &ScreenTriangle) {
        let won = match in_tile(self.tile, triangle) {
            Place::Outside => return,
            Place::Inside(triangle) => self.blocks(simd, &triangle),
            Place::TooLarge(rect) => {
                let keep = self.keep.as_deref_mut();
                fill_plain::<ReversedF32, BITS>(self.tile, triangle, rect, keep)
            }
        };
        self.n_won += u64::from(won);
    }

    /// A triangle that may fill blocks.
    #[inline(always)]
    fn blocks<S: Simd>(&mut self, simd: S, triangle: &TileTriangle) -> u32 {
        let keep = self.keep.as_deref_mut();
        let (tile, offsets) = (&mut *self.tile, &self.offsets);
        if N == 1 {
            fill_blocks::<_, fill::Column<S>, N>(simd, tile, triangle, offsets, &(), keep)
        } else {
            let values = Values::new(simd, triangle, offsets);
            fill_blocks::<_, patch::Column<S, N>, N>(simd, tile, triangle, offsets, &values, keep)
        }
    }
}

#[cfg(test)]
mod tests {
    use cullet_transform::{PlaneMask, Viewport};
    use glam::{DMat4, Vec3};

    use super::*;
    use crate::assembly::{Cluster, Object};
    use crate::fixed::Fixed;
    use crate::precision::{DepthKind, Precision, SubpixelBits, Transforms};
    use crate::setup::{Facing, SetupCounters, Vertex};
    use crate::testing::{Random, levels};

    const SIZE: u32 = 150;

    struct Case {
        positions: [Vec<f32>; 3],
        corners: Vec<[u8; 4]>,
        ids: Vec<u32>,
        object: Object,
    }

    /// A cluster in a view down -z, near 0.1, with triangles of about `size` at distances around 2.
    fn case(random: &mut Random, size: f64, facing: Facing) -> Case {
        let n = 24 + 8 * (random.next() * 20.0) as usize;
        let mut positions = [vec![], vec![], vec![]];
        let (mut centre, mut sizes) = ([0.0; 3], [size; 3]);
        for i in 0..n {
            if i % 3 == 0 {
                centre = [0, 1, 2].map(|_| random.next() * 2.4 - 1.2);
                centre[2] -= 1.5;
                // Some are thin and tall.
                sizes[0] = if random.next() < 0.3 { 0.04 * size } else { size };
            }
            for (axis, list) in positions.iter_mut().enumerate() {
                // Some lie on a coarse grid: repeated corners, equal depths, samples on edges.
                let value = centre[axis] + (random.next() - 0.5) * sizes[axis];
                let coarse = random.next() < 0.1;
                list.push(if coarse { (value * 8.0).round() / 8.0 } else { value } as f32);
            }
        }
        let n_triangles = 1 + (random.next() * 120.0) as usize;
        let corner = |random: &mut Random| (random.next() * n as f64) as u8;
        let corners = (0..n_triangles).map(|i| {
            let near = 3 * (i % (n / 3)) as u8;
            match random.next() < 0.9 {
                true => [near, near + 1, near + 2, 0],
                false => [corner(random), corner(random), corner(random), 0],
            }
        });
        let corners: Vec<_> = corners.collect();
        let mut ids: Vec<u32> = (0..n_triangles as u32).collect();
        ids.rotate_left((random.next() * n_triangles as f64) as usize);
        let clip_from_model = DMat4::from_cols_array(&[
            1.3, 0.0, 0.0, 0.0, 0.0, 1.3, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.1, 0.0,
        ]);
        let viewport = Viewport::new(SIZE, SIZE).unwrap();
        let planes = PlaneMask::ALL;
        let precision = Precision::default();
        let object = Object {
            clip_from_model,
            viewport,
            planes,
            facing,
            first_id: 1000,
            precision,
            samples: Samples::One,
        };
        Case { positions, corners, ids, object }
    }

    /// The plain way: set up, then sample by sample in 128-bit integers.
    fn expected<const BITS: u32>(case: &Case, samples: Samples) -> Expected {
        let Object { viewport, planes, precision, .. } = case.object;
        let transforms = precision.transforms;
        let placer = crate::Placer::<BITS>::with(transforms, viewport, planes);
        let [x, y, z] = &case.positions;
        let vertices = (0..x.len()).map(|i| {
            let point = Vec3::new(x[i], y[i], z[i]);
            placer.place(transforms.clip(&case.object.clip_from_model, point))
        });
        let vertices: Vec<Vertex> = vertices.collect();
        let (mut out, mut counters) = (Vec::new(), SetupCounters::default());
        let mut clipped = Vec::new();
        for (corners, id) in case.corners.iter().zip(&case.ids) {
            let [a, b, c, _] = corners.map(u32::from);
            let input = crate::Triangles {
                vertices: &vertices,
                triangles: &[[a, b, c]],
                first_vertex: 0,
                first_id: case.object.first_id + id,
                facing: case.object.facing,
            };
            let own = crate::set_up(&placer, &input, &mut out);
            if own.n_clipped > 0 {
                clipped.push(input.first_id);
            }
            counters += own;
        }
        let nothing = vec![(0, crate::NO_TRIANGLE); (SIZE * SIZE) as usize];
        let planes = samples.offsets().iter().map(|offset| {
            let mut plane = nothing.clone();
            for triangle in &out {
                let moved = triangle.corners.map(|c| Fixed {
                    x: c.x - (i64::from(offset[0]) << BITS) / 16,
                    y: c.y - (i64::from(offset[1]) << BITS) / 16,
                });
                let edges = crate::cover::Edges::new::<BITS>(triangle, [0, 0]);
                let depth = crate::cover::DepthPlane::new::<BITS>(triangle, &edges);
                let bounds = |values: [i64; 3]| {
                    let first = values.into_iter().min().unwrap() >> BITS;
                    let last = values.into_iter().max().unwrap() >> BITS;
                    first.clamp(0, SIZE.into())..(last + 1).clamp(0, SIZE.into())
                };
                let [xs, ys] = [bounds(moved.map(|c| c.x)), bounds(moved.map(|c| c.y))];
                for (x, y) in ys.flat_map(|y| xs.clone().map(move |x| (x, y))) {
                    if !crate::reference::covers::<BITS>(moved, x, y) {
                        continue;
                    }
                    let row = depth.row(y as f64 + f64::from(offset[1]) / 16.0);
                    let at = depth.at(row, x as f64 + f64::from(offset[0]) / 16.0);
                    let key = case.object.precision.depth.key(at);
                    let old = &mut plane[(y * i64::from(SIZE) + x) as usize];
                    if key > old.0 || (key == old.0 && triangle.id < old.1) {
                        *old = (key, triangle.id);
                    }
                }
            }
            plane
        });
        clipped.sort_unstable();
        Expected { planes: planes.collect(), counters, clipped }
    }

    /// What a case comes to.
    struct Expected {
        /// By sample a picture of keys and ids.
        planes: Vec<Vec<(i32, u32)>>,
        counters: SetupCounters,
        clipped: Vec<u32>,
    }

    /// Memory that is used again and again, as in the frames of a renderer.
    #[derive(Default)]
    struct Used {
        tile: TileBuffer,
        assembly: Assembly,
    }

    #[test]
    fn tiles_show_what_the_plain_code_covers() {
        let random = &mut Random(1);
        let facings = [Facing::Both, Facing::CounterClockwise, Facing::Clockwise];
        let (mut shown, mut used) = (0, Used::default());
        for round in 0..36 {
            let size = [0.02, 0.1, 0.6, 3.0, 40.0, 3000.0][round % 6];
            let mut case = case(random, size, facings[round / 6 % 3]);
            case.object.precision.transforms = [Transforms::F64, Transforms::F32][round / 3 % 2];
            let samples = Samples::ALL[round / 2 % 4];
            let side = [8, 64, 24, 128, 32, 256][(round / 3 + round / 18) % 6];
            let expected = expected::<8>(&case, samples);
            for level in levels() {
                shown += check(&case, level, samples, side, &expected, &mut used);
            }
        }
        assert!(shown > 100_000, "{shown}");
    }

    /// Draws a case in tiles and compares them with the whole picture, sample by sample. Returns
    /// how many samples show something.
    fn check(
        case: &Case,
        level: Level,
        samples: Samples,
        side: usize,
        Expected { planes, counters, clipped }: &Expected,
        Used { tile, assembly }: &mut Used,
    ) -> usize {
        let mut shown = 0;
        let [x, y, z] = &case.positions;
        let cluster = Cluster { positions: [x, y, z], corners: &case.corners, ids: &case.ids };
        assembly.assemble(level, &cluster, &Object { samples, ..case.object });
        assert_eq!(assembly.counters(), *counters);
        let mut got = assembly.clipped().to_vec();
        got.sort_unstable();
        assert_eq!(got, *clipped);
        let starts = || (0..SIZE).step_by(side);
        for (left, top) in starts().flat_map(|y| starts().map(move |x| (x, y))) {
            tile.begin([left, top], side, samples);
            draw(tile, assembly, None);
            tile.validate();
            for (sample, plane) in planes.iter().enumerate() {
                let (rows, columns) = (
                    (side as u32).min(SIZE - top) as usize,
                    (side as u32).min(SIZE - left) as usize,
                );
                for row in 0..rows {
                    let start = (top as usize + row) * SIZE as usize + left as usize;
                    let want = &plane[start..start + columns];
                    let (keys, ids) = (tile.keys(sample, row), tile.ids(sample, row));
                    let got = keys.zip(ids);
                    let got: Vec<_> = got.take(columns).collect();
                    assert_eq!(got, want, "{level:?} {:?} {left} {top} {row}", case.object);
                    shown += got.iter().filter(|(key, _)| *key != 0).count();
                }
            }
        }
        shown
    }

    /// What is drawn first hides some of what comes after it, and never too much.
    #[test]
    fn clusters_share_a_tile_in_any_order() {
        let random = &mut Random(9);
        let (mut tile, mut assembly) = (TileBuffer::default(), Assembly::default());
        let mut shown = 0;
        for round in 0..36 {
            let sizes = [[40.0, 0.05], [3.0, 0.2], [0.6, 0.6]][round % 3];
            let samples = Samples::ALL[round / 3 % 4];
            let mut cases = sizes.map(|size| case(random, size, Facing::Both));
            if round % 2 == 0 {
                // A wall across the triangles.
                let corners = |at: [f32; 3]| at.map(|at| 1.5 * at).repeat(8);
                let (x, y) = (corners([-9.0, 9.0, 0.0]), corners([-9.0, -9.0, 18.0]));
                cases[0].positions = [x, y, vec![-1.5; 24]];
                (cases[0].corners, cases[0].ids) = (vec![[0, 1, 2, 0]], vec![0]);
            }
            cases[1].object.first_id += 1000;
            let [mut want, others] = [0, 1].map(|i| expected::<8>(&cases[i], samples).planes);
            for (own, other) in want.iter_mut().flatten().zip(others.iter().flatten()) {
                let nearer = other.0 > own.0 || other.0 == own.0 && other.1 < own.1;
                *own = if nearer { *other } else { *own };
            }
            for (level, order) in
                levels().into_iter().flat_map(|level| [[0, 1], [1, 0]].map(|order| (level, order)))
            {
                for (left, top) in [(0, 0), (64, 0), (64, 64)] {
                    tile.begin([left, top], 64, samples);
                    for case in order.map(|i| &cases[i]) {
                        let [x, y, z] = &case.positions;
                        let (corners, ids) = (&case.corners[..], &case.ids[..]);
                        let cluster = Cluster { positions: [x, y, z], corners, ids };
                        assembly.assemble(level, &cluster, &Object { samples, ..case.object });
                        draw(&mut tile, &assembly, None);
                        tile.validate();
                    }
                    for (sample, plane) in want.iter().enumerate() {
                        for row in 0..64 {
                            let start = (top as usize + row) * SIZE as usize + left as usize;
                            let (keys, ids) = (tile.keys(sample, row), tile.ids(sample, row));
                            let got: Vec<_> = keys.zip(ids).collect();
                            assert_eq!(
                                got,
                                plane[start..start + 64],
                                "{level:?} {samples:?} {round}"
                            );
                            shown += got.iter().filter(|(key, _)| *key != 0).count();
                        }
                    }
                }
            }
        }
        assert!(shown > 100_000, "{shown}");
    }

    #[test]
    fn every_grid_and_format_of_depth_follows_the_rule() {
        let random = &mut Random(3);
        let facings = [Facing::Both, Facing::CounterClockwise, Facing::Clockwise];
        let (mut shown, mut used) = (0, Used::default());
        let all = SubpixelBits::ALL.map(|bits| DepthKind::ALL.map(|depth| (bits, depth)));
        for (round, &(subpixel_bits, depth)) in all.as_flattened().iter().enumerate() {
            for size in [0.1, 0.6, 40.0] {
                let mut case = case(random, size, facings[round % 3]);
                let transforms = [Transforms::F64, Transforms::F32][round / 2 % 2];
                case.object.precision = Precision { transforms, subpixel_bits, depth };
                let samples = Samples::ALL[(round + round / 4) % 4];
                let expected = match subpixel_bits {
                    SubpixelBits::Four => expected::<4>(&case, samples),
                    SubpixelBits::Eight => expected::<8>(&case, samples),
                    SubpixelBits::Twelve => expected::<12>(&case, samples),
                    SubpixelBits::Sixteen => expected::<16>(&case, samples),
                };
                shown += check(&case, Level::new(), samples, 64, &expected, &mut used);
            }
        }
        assert!(shown > 100_000, "{shown}");
    }

    /// Layers that fill the view, nearest last: only the nearest is drawn.
    #[test]
    fn large_triangles_of_a_cluster_are_drawn_nearest_first() {
        let random = &mut Random(7);
        let Case { object, .. } = case(random, 1.0, Facing::Both);
        let distances = [5.0, 3.0, 4.0, 2.0, 1.0_f32];
        let corners = [[-9.0, -9.0], [9.0, -9.0], [0.0, 18.0_f32]];
        let of = |axis: fn([f32; 2], f32) -> f32| {
            let places = distances.map(|distance| corners.map(|corner| axis(corner, distance)));
            let mut list = places.as_flattened().to_vec();
            list.resize(16, 0.0);
            list
        };
        let [x, y, z] = [of(|[x, _], d| x * d), of(|[_, y], d| y * d), of(|_, d| -d)];
        let corners: Vec<[u8; 4]> = (0..5).map(|i| [3 * i, 3 * i + 1, 3 * i + 2, 0]).collect();
        let ids = [0, 1, 2, 3, 4];
        let cluster = Cluster { positions: [&x, &y, &z], corners: &corners, ids: &ids };
        for (level, samples) in levels().into_iter().flat_map(|l| Samples::ALL.map(|s| (l, s))) {
            let (mut tile, mut assembly) = (TileBuffer::default(), Assembly::default());
            assembly.assemble(level, &cluster, &Object { samples, ..object });
            tile.begin([64, 64], 64, samples);
            let n_won = draw(&mut tile, &assembly, None);
            assert_eq!(n_won, 64 * 64 * samples.count() as u64, "{samples:?}");
            assert!((0..64).all(|row| tile.ids(0, row).all(|id| id == 1004)));
        }
    }

    #[test]
    fn samples_without_matter_are_left_alone() {
        let random = &mut Random(5);
        let case = case(random, 1.0, Facing::Both);
        let [x, y, z] = &case.positions;
        let cluster = Cluster { positions: [x, y, z], corners: &case.corners, ids: &case.ids };
        // Holes that depend on the triangle and on the place, to a sixteenth of a pixel.
        let has_matter = |id: u32, [x, y]: [i32; 2]| (id as i32 * 7 + x * 3 + y * 5) / 16 % 3 > 0;
        for samples in Samples::ALL {
            let object = Object { samples, ..case.object };
            let mut pictures = Vec::new();
            for level in levels() {
                let (mut tile, mut assembly) = (TileBuffer::default(), Assembly::default());
                assembly.assemble(level, &cluster, &object);
                tile.begin([64, 64], 64, samples);
                let keep = &mut |id: u32, [x, y]: [i32; 2], wanted: u64| {
                    assert!(x >= 16 * 64 && y >= 16 * 64 && wanted != 0 && wanted < 256);
                    let kept = (0..8).filter(|lane| has_matter(id, [x + 16 * lane, y]));
                    kept.map(|lane| 1 << lane).sum()
                };
                draw(&mut tile, &assembly, Some(keep));
                tile.validate();
                let mut picture = Vec::new();
                for (sample, [dx, dy]) in samples.offsets().iter().enumerate() {
                    for row in 0..64 {
                        for (column, id) in tile.ids(sample, row).enumerate() {
                            let place = [column, row].map(|at| 16 * (64 + at as i32) + 8);
                            let place = [place[0] + dx, place[1] + dy];
                            assert!(id == crate::NO_TRIANGLE || has_matter(id, place));
                        }
                        picture.extend(tile.keys(sample, row).zip(tile.ids(sample, row)));
                    }
                }
                pictures.push(picture);
            }
            assert!(pictures[0].iter().any(|(_, id)| *id != crate::NO_TRIANGLE));
            assert!(pictures.iter().all(|picture| *picture == pictures[0]), "{samples:?}");
        }
    }
}
