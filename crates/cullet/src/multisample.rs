//! Colours from several samples per pixel: one where they agree, a mean where they do not.
//!
//! A pixel is shaded once per triangle seen in it, in the middle of the samples that see it: inside the
//! triangle, and, with all triangles together, in the middle of the pixel, so that a surface looks
//! alike whether its triangles meet in a pixel or not. (The places of samples add up to nothing. The
//! OpenGL 4.6 specification, 14.3.1, leaves any place inside to the maker, and calls it the
//! centroid.) [`EdgeShading::Centre`] takes the pixel's centre instead, as that specification has it for
//! variables that are not declared `centroid`. Colours are averaged in linear light, weighted by samples, with
//! alpha counted in (Porter & Duff 1984, "Compositing Digital Images"), so nothing of a
//! transparent background shows.

use std::ops::Range;

use cullet_raster::{BLOCK, NO_TRIANGLE, Samples, TileBuffer};
use cullet_shade::wide::encode_all;
use fearless_simd::{Simd, dispatch, prelude::*, u32x8};
use glam::{Vec3, Vec4};

use crate::frame::Target;
use crate::tile_shader::{TileShader, Wanted};
use crate::{EdgeShading, Region, Settings};

/// Memory for pixels whose samples disagree.
#[derive(Debug, Default)]
pub(crate) struct EdgeScratch {
    /// Ids of a rectangle where all samples of a pixel agree, else [`NO_TRIANGLE`].
    whole: Vec<u32>,
    /// The first `n.edges`, and room for more.
    edges: Vec<Edge>,
    /// Places whose colours edges are made of, those of each one after another: the first `n.wanted`, and room for
    /// more.
    wanted: Vec<Wanted>,
    /// What each of `wanted` is to its edge.
    shares: Vec<Share>,
    n: Counts,
    colors: Vec<Vec4>,
    means: Vec<Vec4>,
    codes: Vec<[u8; 4]>,
}

/// How many there are.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    edges: usize,
    wanted: usize,
}

/// A pixel whose samples disagree.
#[derive(Clone, Copy, Debug, Default)]
struct Edge {
    /// Where it goes.
    out: u32,
    /// The part of its samples that see nothing.
    unseen: f32,
}

/// A part of an edge.
#[derive(Clone, Copy, Debug, Default)]
struct Share {
    edge: u32,
    /// How many of its samples, of one.
    part: f32,
}

impl EdgeScratch {
    /// Memory held.
    pub(crate) fn bytes(&self) -> usize {
        4 * (self.whole.capacity() + self.codes.capacity())
            + self.edges.capacity() * size_of::<Edge>()
            + self.wanted.capacity() * size_of::<Wanted>()
            + self.shares.capacity() * size_of::<Share>()
            + (self.colors.capacity() + self.means.capacity()) * size_of::<Vec4>()
    }

    /// Sorts pixels of a row, the first at `place`, into those of one triangle, which go to `whole`, and others.
    /// `ids` are those of all samples, pixel by pixel; they and `whole` go on for eight pixels more.
    #[inline(always)]
    fn row<S: Simd, const N: usize>(
        &mut self,
        simd: S,
        ids: &[u32],
        place: Place,
        whole: Range<usize>,
        middles: &[Middle],
    ) {
        let nothing = u32x8::splat(simd, NO_TRIANGLE);
        let width = whole.len();
        self.make_room(width.next_multiple_of(8), N);
        let mut first = 0;
        while first < width {
            let seen = &ids[first * N..(first + 8) * N];
            let at = whole.start + first;
            let whole = &mut self.whole[at..at + 8];
            let planes = by_sample::<S, N>(simd, seen);
            let mut differs = u32x8::splat(simd, 0);
            for sample in 1..N {
                differs |= planes[sample] ^ planes[0];
            }
            let agree = differs.simd_eq(0);
            agree.select(planes[0], nothing).store_slice(whole);
            let edges = !agree.to_bitmask() & 0xff >> (8 - (width - first).min(8));
            if edges != 0 {
                self.eight(simd, &planes, seen, edges, place.right(first), middles);
            }
            first += 8;
        }
    }

    /// Room for as many edges more.
    #[inline(always)]
    fn make_room(&mut self, n: usize, n_samples: usize) {
        let (edges, wanted) = (self.n.edges + n, self.n.wanted + n * n_samples);
        if self.edges.len() < edges {
            self.edges.resize(edges, Edge::default());
        }
        if self.wanted.len() < wanted {
            self.wanted.resize(wanted, Wanted::default());
            self.shares.resize(wanted, Share::default());
        }
    }

    /// Those of eight pixels, the first at `place`, that are `edges`, a bit each. Room has been made for all. `planes`
    /// are the ids that `seen` has pixel by pixel; `middles` say where sets of samples are shaded.
    #[inline(always)]
    fn eight<S: Simd, const N: usize>(
        &mut self,
        simd: S,
        planes: &[u32x8<S>; N],
        seen: &[u32],
        edges: u64,
        place: Place,
        middles: &[Middle],
    ) {
        let zero = u32x8::splat(simd, 0);
        // By sample, which of a pixel's samples see the same, a bit each.
        let mut sets = [zero; N];
        for sample in 0..N {
            sets[sample] |= 1 << sample;
            for other in sample + 1..N {
                let same = planes[sample].simd_eq(planes[other]);
                sets[sample] |= same.select(u32x8::splat(simd, 1 << other), zero);
                sets[other] |= same.select(u32x8::splat(simd, 1 << sample), zero);
            }
        }
        // Places wanted, `N` bits a pixel: of each set the first sample.
        let mut wanted = 0;
        let mut own = [[0; 8]; N];
        let mut n_unseen = zero;
        for sample in 0..N {
            let is_nothing = planes[sample].simd_eq(NO_TRIANGLE);
            let is_first = (sets[sample] & ((1 << sample) - 1)).simd_eq(0) & !is_nothing;
            wanted |= spread::<N>((is_first.to_bitmask() & edges) as u8) << sample;
            sets[sample].store_slice(&mut own[sample]);
            n_unseen += is_nothing.select(u32x8::splat(simd, 1), zero);
        }
        let n_unseen: [u32; 8] = n_unseen.into();
        let first_edge = self.n.edges;
        let new_edges: &mut [Edge; 8] =
            self.edges[first_edge..].first_chunk_mut().expect("room for all");
        let (mut left, mut n) = (edges, 0);
        while left != 0 {
            let pixel = left.trailing_zeros() as usize % 8;
            left &= left - 1;
            let out = (place.out + pixel) as u32;
            new_edges[n % 8] = Edge { out, unseen: n_unseen[pixel] as f32 / N as f32 };
            n += 1;
        }
        self.n.edges += n;
        let new = self.n.wanted..self.n.wanted + 8 * N;
        let (new_wanted, new_shares) = (&mut self.wanted[new.clone()], &mut self.shares[new]);
        let seen = &seen[..8 * N];
        let mut n = 0;
        while wanted != 0 {
            let bit = wanted.trailing_zeros() as usize % (8 * N);
            wanted &= wanted - 1;
            let (pixel, sample) = (bit / N, bit % N);
            let Middle { x, y, part } = middles[own[sample][pixel] as usize];
            let corner = [16 * (place.x + pixel as u32) as i32, 16 * place.y as i32];
            let (x, y) = (corner[0] + 8 + x, corner[1] + 8 + y);
            new_wanted[n] = Wanted { id: seen[bit], x, y };
            let before = edges & ((1 << pixel) - 1);
            new_shares[n] = Share { edge: first_edge as u32 + before.count_ones(), part };
            n += 1;
        }
        self.n.wanted += n;
    }

    /// [`EdgeScratch::row`] for all rows of a rectangle, whose upper left pixel is at `column`, `row` in
    /// `tile`.
    #[inline(always)]
    fn rows<S: Simd, const N: usize>(
        &mut self,
        simd: S,
        tile: &TileBuffer,
        rect: Region,
        place: [u32; 2],
        stride: usize,
        shading: EdgeShading,
    ) {
        let middles = middles_of(tile.samples(), shading);
        let (width, height) = (rect.width as usize, rect.height as usize);
        // Eights reach into the next row, which is written later.
        self.whole.resize((width * height + 8).max(self.whole.len()), NO_TRIANGLE);
        let (ids, ids_stride) = tile.ids_from(place);
        for i in 0..height {
            let ids = &ids[i * ids_stride..];
            let place = Place { x: rect.x, y: rect.y + i as u32, out: i * stride };
            self.row::<S, N>(simd, ids, place, i * width..(i + 1) * width, middles);
        }
    }
}

/// The ids of eight pixels, sample by sample. Each round brings values of even places into the first half, so that the
/// number of the sample, the lowest bits of a place, moves to its highest.
#[inline(always)]
fn by_sample<S: Simd, const N: usize>(simd: S, ids: &[u32]) -> [u32x8<S>; N] {
    let mut all = [u32x8::splat(simd, 0); N];
    for i in 0..N {
        all[i] = u32x8::from_slice(simd, &ids[8 * i..8 * i + 8]);
    }
    let mut round = 1;
    while round < N {
        let before = all;
        for i in 0..N / 2 {
            all[i] = before[2 * i].unzip_low(before[2 * i + 1]);
            all[N / 2 + i] = before[2 * i].unzip_high(before[2 * i + 1]);
        }
        round *= 2;
    }
    all
}

/// A pixel of the picture, and where it goes.
#[derive(Clone, Copy, Debug)]
struct Place {
    x: u32,
    y: u32,
    out: usize,
}

impl Place {
    /// `n` pixels to the right.
    fn right(self, n: usize) -> Self {
        Place { x: self.x + n as u32, out: self.out + n, ..self }
    }
}

/// Some samples of a pixel taken together.
#[derive(Clone, Copy, Debug)]
struct Middle {
    /// Where they are shaded, sixteenths of a pixel from the pixel's centre.
    x: i32,
    y: i32,
    /// How many they are, of one.
    part: f32,
}

/// By which samples there are, a bit each, their middle.
const fn middles<const SETS: usize>(samples: Samples, shading: EdgeShading) -> [Middle; SETS] {
    let offsets = samples.offsets();
    let mut all = [Middle { x: 0, y: 0, part: 0.0 }; SETS];
    let mut set = 1;
    while set < SETS {
        let (mut sum, mut n, mut sample) = ([0, 0], 0, 0);
        while sample < offsets.len() {
            if set >> sample & 1 != 0 {
                sum = [sum[0] + offsets[sample][0], sum[1] + offsets[sample][1]];
                n += 1;
            }
            sample += 1;
        }
        all[set].part = n as f32 / offsets.len() as f32;
        if let EdgeShading::Covered = shading {
            // To the nearest, halves up.
            all[set].x = (2 * sum[0] + n).div_euclid(2 * n);
            all[set].y = (2 * sum[1] + n).div_euclid(2 * n);
        }
        set += 1;
    }
    all
}

/// [`middles`] of a pattern; of one sample there are no edges.
fn middles_of(samples: Samples, shading: EdgeShading) -> &'static [Middle] {
    use EdgeShading::{Centre, Covered};
    use Samples::{Eight, Four, One, Two};
    static TWO: [[Middle; 4]; 2] = [middles(Two, Covered), middles(Two, Centre)];
    static FOUR: [[Middle; 16]; 2] = [middles(Four, Covered), middles(Four, Centre)];
    static EIGHT: [[Middle; 256]; 2] = [middles(Eight, Covered), middles(Eight, Centre)];
    let kind = usize::from(shading == Centre);
    match samples {
        One => &[],
        Two => &TWO[kind],
        Four => &FOUR[kind],
        Eight => &EIGHT[kind],
    }
}

/// Bits with zeros between: `N` places for each.
#[inline(always)]
fn spread<const N: usize>(bits: u8) -> u64 {
    let of = match N {
        2 => &SPREAD_BY_TWO,
        4 => &SPREAD_BY_FOUR,
        _ => &SPREAD_BY_EIGHT,
    };
    of[usize::from(bits)]
}

static SPREAD_BY_TWO: [u64; 256] = spreads(2);
static SPREAD_BY_FOUR: [u64; 256] = spreads(4);
static SPREAD_BY_EIGHT: [u64; 256] = spreads(8);

const fn spreads(n: usize) -> [u64; 256] {
    let mut all = [0; 256];
    let mut bits = 0;
    while bits < 256 {
        let mut bit = 0;
        while bit < 8 {
            all[bits] |= (bits as u64 >> bit & 1) << (n * bit);
            bit += 1;
        }
        bits += 1;
    }
    all
}

impl TileShader<'_> {
    /// Colours `rect`, whose upper left pixel is at `place` in `tile`, and the background. Returns how
    /// many pixels show something.
    pub(crate) fn multisampled(
        &mut self,
        rect: Region,
        tile: &TileBuffer,
        place: [u32; 2],
        out: &mut Target<'_>,
    ) -> u64 {
        let mut scratch = std::mem::take(&mut self.scratch.edges);
        scratch.n = Counts::default();
        let width = rect.width as usize;
        let shading = self.scene.settings.edge_shading;
        dispatch!(self.scene.settings.simd, simd => match tile.samples() {
            Samples::One => scratch.rows::<_, 1>(simd, tile, rect, place, out.stride, shading),
            Samples::Two => scratch.rows::<_, 2>(simd, tile, rect, place, out.stride, shading),
            Samples::Four => scratch.rows::<_, 4>(simd, tile, rect, place, out.stride, shading),
            Samples::Eight => scratch.rows::<_, 8>(simd, tile, rect, place, out.stride, shading),
        });
        let Counts { edges: n_edges, wanted: n_wanted } = scratch.n;
        let n_whole = self.blocks(rect, &scratch.whole, width, n_edges, out);
        if scratch.colors.len() < n_wanted {
            scratch.colors.resize(n_wanted, Vec4::ZERO);
        }
        let (wanted, colors) = (&scratch.wanted[..n_wanted], &mut scratch.colors[..n_wanted]);
        let (first, last) = ([rect.x, rect.y], [rect.x + rect.width - 1, rect.y + rect.height - 1]);
        let (block, last_block) = (first.map(|at| at / BLOCK), last.map(|at| at / BLOCK));
        if block == last_block {
            self.colors_in_block(block, wanted, colors);
        } else {
            self.colors(wanted, colors);
        }
        let Settings { mut background, encoding, simd, edge_shading, .. } = *self.scene.settings;
        if edge_shading == EdgeShading::Centre {
            scratch.colors[..n_wanted].iter_mut().for_each(clamp);
            clamp(&mut background);
        }
        let EdgeScratch { edges, shares, colors, means, codes, .. } = &mut scratch;
        let (edges, shares) = (&edges[..n_edges], &shares[..n_wanted]);
        blend(edges, shares, colors, background, means);
        if out.linear.is_empty() {
            codes.resize(means.len().max(codes.len()), [0; 4]);
            encode_all(simd, encoding, means, codes);
            for (edge, code) in edges.iter().zip(codes) {
                out.rgba8[edge.out as usize] = *code;
            }
        } else {
            for (edge, color) in edges.iter().zip(means) {
                out.linear[edge.out as usize] = *color;
            }
        }
        self.scratch.edges = scratch;
        n_whole + n_edges as u64
    }
}

/// Brings a colour into what 8 bits can hold, as OpenGL does before it averages: continued beyond its triangle, it
/// may be anything, and one sample would outweigh the others.
fn clamp(color: &mut Vec4) {
    *color = Vec4::from_array(color.to_array().map(|channel| channel.clamp(0.0, 1.0)));
}

/// The means of the colours of edges; samples that see nothing see the background.
fn blend(
    edges: &[Edge],
    shares: &[Share],
    colors: &[Vec4],
    background: Vec4,
    means: &mut Vec<Vec4>,
) {
    means.clear();
    means.resize(edges.len(), Vec4::ZERO);
    for (share, color) in shares.iter().zip(colors) {
        means[share.edge as usize] += premultiplied(*color) * share.part;
    }
    let background = premultiplied(background);
    for (edge, mean) in edges.iter().zip(means) {
        if edge.unseen > 0.0 {
            *mean += background * edge.unseen;
        }
        if mean.w > 0.0 && mean.w < 1.0 {
            *mean = (mean.truncate() / mean.w).extend(mean.w);
        }
    }
}

/// With alpha counted into the colour.
fn premultiplied(color: Vec4) -> Vec4 {
    color * Vec3::splat(color.w).extend(1.0)
}

#[cfg(test)]
mod tests {
    use cullet_scene::{Material, Mesh, Node, Object, synth::synth};
    use cullet_transform::{Camera, Projection, View, Viewport};
    use glam::{DAffine3, DVec3, Vec2};

    use super::*;
    use crate::{Antialias, Frame, Pass, Passes, Prepared, Renderer, camera_of, frame_scene};

    #[test]
    fn triangles_of_a_pixel_are_shaded_around_its_middle() {
        /// Fifteen pixels with these ids in some order, and a few that show one triangle.
        fn check<const N: usize>(ids: [u32; N], samples: Samples, shading: EdgeShading) {
            let offsets: &[[i32; 2]; N] = samples.offsets().first_chunk().unwrap();
            let pixels: [[u32; N]; 24] = std::array::from_fn(|pixel| {
                let other = 100 * pixel as u32;
                if pixel % 5 == 3 {
                    return [other; N];
                }
                let own = |i: usize| ids[(i + pixel) % N];
                std::array::from_fn(|i| own(i).checked_add(other).unwrap_or(NO_TRIANGLE))
            });
            let is_edge = |pixel: &[u32; N]| pixel.iter().any(|id| *id != pixel[0]);
            for (name, level) in cullet_cull::wide::levels() {
                let mut scratch = EdgeScratch { whole: vec![0; 24], ..EdgeScratch::default() };
                let place = Place { x: 3, y: 5, out: 7 };
                let (all, middles) = (pixels.as_flattened(), middles_of(samples, shading));
                dispatch!(level, simd => scratch.row::<_, N>(simd, all, place, 0..15, middles));
                for (pixel, whole) in pixels[..15].iter().zip(&scratch.whole) {
                    let expected = if is_edge(pixel) { NO_TRIANGLE } else { pixel[0] };
                    assert_eq!(*whole, expected, "{name}");
                }
                let mut edges = scratch.edges[..scratch.n.edges].iter().enumerate();
                let wanted = &scratch.wanted[..scratch.n.wanted];
                let mut all = wanted.iter().zip(&scratch.shares).peekable();
                for (column, pixel) in pixels[..15].iter().enumerate() {
                    if !is_edge(pixel) {
                        continue;
                    }
                    let (number, edge) = edges.next().unwrap();
                    assert_eq!(edge.out as usize, 7 + column);
                    let (mut sum, mut n_seen, mut known) = ([0.0; 2], 0.0, Vec::new());
                    while let Some((wanted, share)) =
                        all.next_if(|(_, share)| share.edge as usize == number)
                    {
                        let seen = offsets.iter().zip(pixel).filter(|(_, id)| **id == wanted.id);
                        let places: Vec<[f64; 2]> = seen.map(|(at, _)| at.map(f64::from)).collect();
                        let weight = places.len() as f64;
                        assert_eq!(weight as f32 / N as f32, share.part);
                        assert!(weight > 0.0 && !known.contains(&wanted.id));
                        known.push(wanted.id);
                        let place =
                            [wanted.x - (3 + column as i32) * 16 - 8, wanted.y - 5 * 16 - 8];
                        if shading == EdgeShading::Centre {
                            assert_eq!(place, [0, 0], "{name}");
                            n_seen += share.part;
                            continue;
                        }
                        for axis in 0..2 {
                            let exact: f64 = places.iter().map(|at| at[axis]).sum::<f64>();
                            let place = f64::from(place[axis]);
                            assert!((place - exact / weight).abs() <= 0.5);
                            sum[axis] += weight * place;
                        }
                        n_seen += share.part;
                    }
                    assert_eq!(n_seen + edge.unseen, 1.0, "{name}");
                    let n_nothing = pixel.iter().filter(|id| **id == NO_TRIANGLE).count();
                    assert_eq!(edge.unseen, n_nothing as f32 / N as f32, "{name}");
                    if n_nothing == 0 {
                        let limit = 0.5 * N as f64;
                        assert!(sum.iter().all(|sum| sum.abs() <= limit), "{pixel:?}: {sum:?}");
                    }
                }
                assert!(edges.next().is_none() && all.next().is_none(), "{name}");
            }
        }
        for case in 0..4u32.pow(4) {
            let own = |sample: u32| match case >> (2 * sample) & 3 {
                0 => NO_TRIANGLE,
                id => id,
            };
            for shading in [EdgeShading::Covered, EdgeShading::Centre] {
                check([own(0), own(1)], Samples::Two, shading);
                check([own(0), own(1), own(2), own(3)], Samples::Four, shading);
                check([0, 1, 2, 3, 1, 0, 3, 2].map(own), Samples::Eight, shading);
            }
        }
    }

    /// A tilted plane of many triangles, all over the picture, with a texture.
    fn plane() -> (Prepared, View) {
        const SIDE: u32 = 24;
        let mut scene = synth("interior").unwrap();
        let textured =
            |m: &Material| m.base_color_texture.as_ref().is_some_and(|t| t.transform.is_none());
        let material = scene.materials.iter().position(textured).unwrap();
        let at = |i: u32| Vec2::new((i % SIDE) as f32, (i / SIDE) as f32) / (SIDE - 1) as f32 - 0.5;
        let of_square = |i: u32| [[i, i + 1, i + SIDE + 1], [i, i + SIDE + 1, i + SIDE]];
        let squares = (0..SIDE * (SIDE - 1)).filter(|i| i % SIDE < SIDE - 1);
        scene.meshes = vec![Mesh {
            positions: (0..SIDE * SIDE).map(|i| (at(i) * 16.0).extend(at(i).x * 6.0)).collect(),
            uvs: [Some((0..SIDE * SIDE).map(at).collect()), None],
            triangles: squares.flat_map(of_square).collect(),
            ..Mesh::default()
        }];
        let world_from_model = DAffine3::from_translation(DVec3::new(0.0, 0.0, -9.0));
        let name = "plane".to_owned();
        scene.nodes = vec![Node { name, parent: None, world_from_node: world_from_model }];
        let name = "plane".to_owned();
        scene.objects = vec![Object { name, node: 0, mesh: 0, material, world_from_model }];
        let lens = Projection::Perspective { yfov: 0.7, near: 0.1, far: f64::INFINITY };
        let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, lens).unwrap();
        (Prepared::new(scene).unwrap(), View::new(&camera, Viewport::new(150, 101).unwrap()))
    }

    /// What a surface is at the centre of a pixel does not depend on where its triangles meet.
    #[test]
    fn a_surface_shaded_at_centres_is_that_of_one_sample() {
        let (prepared, view) = plane();
        let linear = |antialias, edge_shading| {
            let passes = Passes::NONE.with(Pass::Linear);
            let settings = Settings { passes, antialias, edge_shading, ..Settings::default() };
            let mut frame = Frame::default();
            Renderer::default().render(&prepared, &view, &settings, &mut frame);
            frame.linear
        };
        let one = linear(Antialias::None, EdgeShading::Covered);
        let n_off = |other: Vec<Vec4>| {
            let off = |(a, b): &(&Vec4, &Vec4)| (**a - **b).abs().max_element() > 1e-4;
            one.iter().zip(&other).filter(off).count()
        };
        for antialias in [Antialias::Msaa2, Antialias::Msaa4, Antialias::Msaa8] {
            assert_eq!(n_off(linear(antialias, EdgeShading::Centre)), 0, "{antialias:?}");
            let n_covered = n_off(linear(antialias, EdgeShading::Covered));
            assert!(n_covered > 10, "{antialias:?}: {n_covered}");
        }
    }

    /// Slivers, whose colours at the centre of a pixel they touch may be anything.
    #[test]
    fn colours_from_beyond_a_triangle_stay_colours() {
        for name in ["showpiece", "knots", "slivers:90"] {
            let prepared = Prepared::new(synth(name).unwrap()).unwrap();
            let viewport = Viewport::new(160, 90).unwrap();
            let own = prepared.scene().cameras.first().and_then(|own| camera_of(own).ok());
            let camera = own.unwrap_or_else(|| frame_scene(&prepared, viewport.aspect()));
            let view = View::new(&camera, viewport);
            for antialias in [Antialias::Msaa2, Antialias::Msaa4, Antialias::Msaa8] {
                let passes = Passes::NONE.with(Pass::Linear);
                let edge_shading = EdgeShading::Centre;
                let settings = Settings { passes, antialias, edge_shading, ..Settings::default() };
                let mut frame = Frame::default();
                Renderer::default().render(&prepared, &view, &settings, &mut frame);
                let range = |color: &Vec4| color.min_element() >= 0.0 && color.max_element() <= 1.0;
                assert!(frame.linear.iter().all(range), "{name} {antialias:?}");
            }
        }
    }

    #[test]
    fn ids_are_sorted_by_sample() {
        fn check<const N: usize>() {
            let ids: Vec<u32> = (0..8 * N as u32).collect();
            for (name, level) in cullet_cull::wide::levels() {
                let got =
                    dispatch!(level, simd => by_sample::<_, N>(simd, &ids).map(<[u32; 8]>::from));
                for (sample, plane) in got.iter().enumerate() {
                    let want = |pixel: usize| (pixel * N + sample) as u32;
                    assert!(
                        (0..8).all(|pixel| plane[pixel] == want(pixel)),
                        "{name} {N} {plane:?}"
                    );
                }
            }
        }
        check::<2>();
        check::<4>();
        check::<8>();
    }

    #[test]
    fn means_count_alpha_in() {
        let red = Vec4::new(1.0, 0.0, 0.0, 1.0);
        let green = Vec4::new(0.0, 1.0, 0.0, 1.0);
        let clear = Vec4::new(9.0, 9.0, 9.0, 0.0);
        let share = |edge, part| Share { edge, part };
        let mut means = vec![Vec4::NAN; 3];
        let edges = [Edge { out: 0, unseen: 0.25 }, Edge { out: 1, unseen: 0.5 }];
        let shares = [share(0, 0.25), share(0, 0.5), share(1, 0.25), share(1, 0.25)];
        let colors = [red, green, red, green];
        blend(&edges, &shares, &colors, Vec4::ONE, &mut means);
        assert_eq!(means, [Vec4::new(0.5, 0.75, 0.25, 1.0), Vec4::new(0.75, 0.75, 0.5, 1.0)]);
        blend(&edges, &shares, &colors, clear, &mut means);
        assert_eq!(means[1], Vec4::new(0.5, 0.5, 0.0, 0.5));
    }
}
