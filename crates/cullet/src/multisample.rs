//! Colours from several samples per pixel: one where they agree, a mean where they do not.
//!
//! A pixel is shaded once per triangle seen in it, in the middle of the samples that see it: inside the
//! triangle, and, with all triangles together, in the middle of the pixel, so that a surface looks
//! alike whether its triangles meet in a pixel or not. (The places of samples add up to nothing. The
//! OpenGL 4.6 specification, 14.3.1, leaves any place inside to the maker, and calls it the
//! centroid.) Colours are averaged in linear light, weighted by samples, with
//! alpha counted in (Porter & Duff 1984, "Compositing Digital Images"), so nothing of a
//! transparent background shows.

use std::ops::Range;

use cullet_raster::{BLOCK, NO_TRIANGLE, Samples, TileBuffer};
use cullet_shade::wide::encode_all;
use fearless_simd::{Simd, dispatch, prelude::*, u32x8};
use glam::Vec4;

use crate::frame::Target;
use crate::tile_shader::{TileShader, Wanted};
use crate::{Region, Settings};

/// Memory for pixels whose samples disagree.
#[derive(Debug, Default)]
pub(crate) struct EdgeScratch {
    /// Ids of a rectangle where all samples of a pixel agree, else [`NO_TRIANGLE`].
    whole: Vec<u32>,
    edges: Vec<Edge>,
    /// Places whose colours edges are made of: the first `n_wanted`, and room for more.
    wanted: Vec<Wanted>,
    n_wanted: usize,
    /// Samples that see each of `wanted`.
    weights: Vec<f32>,
    colors: Vec<Vec4>,
    codes: Vec<[u8; 4]>,
}

/// A pixel whose samples disagree.
#[derive(Clone, Copy, Debug)]
struct Edge {
    /// Where it goes.
    out: u32,
    /// How many of the places wanted are its own.
    n_wanted: u32,
}

impl EdgeScratch {
    /// Memory held.
    pub(crate) fn bytes(&self) -> usize {
        4 * (self.whole.capacity() + self.weights.capacity() + self.codes.capacity())
            + self.edges.capacity() * size_of::<Edge>()
            + self.wanted.capacity() * size_of::<Wanted>()
            + self.colors.capacity() * size_of::<Vec4>()
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
    ) {
        let nothing = u32x8::splat(simd, NO_TRIANGLE);
        let width = whole.len();
        let room = self.n_wanted + N * width;
        if self.wanted.len() < room {
            self.wanted.resize(room, Wanted::default());
            self.weights.resize(room, 0.0);
        }
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
            let mut edges = !agree.to_bitmask() & 0xff >> (8 - (width - first).min(8));
            while edges != 0 {
                let at = edges.trailing_zeros() as usize % 8;
                edges &= edges - 1;
                let seen: &[u32; N] = seen[at * N..].first_chunk().expect("those of a pixel");
                self.edge(*seen, place.right(first + at));
            }
            first += 8;
        }
    }

    /// A pixel whose samples see different triangles.
    #[inline(always)]
    #[expect(clippy::needless_range_loop, reason = "iterators beside vectors may become calls")]
    fn edge<const N: usize>(&mut self, ids: [u32; N], place: Place) {
        let mut n_wanted = 0;
        let (_, free) = self.wanted.split_at_mut(self.n_wanted);
        let (_, free_weights) = self.weights.split_at_mut(self.n_wanted);
        let wanted: &mut [Wanted; N] = free.first_chunk_mut().expect("room for all");
        let weights: &mut [f32; N] = free_weights.first_chunk_mut().expect("room for all");
        // No branches: nobody could foresee them. What is not wanted is written over.
        for sample in 0..N {
            let seen = ids[sample];
            let mut own = 0;
            for other in 0..N {
                own |= usize::from(ids[other] == seen) << other;
            }
            let Middle { x, y, weight } = middles_of::<N>()[own];
            let (x, y) = (place.x as i32 * 16 + 8 + x, place.y as i32 * 16 + 8 + y);
            wanted[n_wanted % N] = Wanted { id: seen, x, y };
            weights[n_wanted % N] = weight;
            let is_first = own & ((1 << sample) - 1) == 0;
            n_wanted += usize::from(is_first & (seen != NO_TRIANGLE));
        }
        self.n_wanted += n_wanted;
        self.edges.push(Edge { out: place.out as u32, n_wanted: n_wanted as u32 });
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
    ) {
        let (width, height) = (rect.width as usize, rect.height as usize);
        // Eights reach into the next row, which is written later.
        self.whole.resize((width * height + 8).max(self.whole.len()), NO_TRIANGLE);
        let (ids, ids_stride) = tile.ids_from(place);
        for i in 0..height {
            let ids = &ids[i * ids_stride..];
            let place = Place { x: rect.x, y: rect.y + i as u32, out: i * stride };
            self.row::<S, N>(simd, ids, place, i * width..(i + 1) * width);
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
    /// The mean of their places, sixteenths of a pixel from the pixel's centre.
    x: i32,
    y: i32,
    /// How many there are.
    weight: f32,
}

/// By which samples there are, a bit each, their middle.
const fn middles<const SETS: usize>(samples: Samples) -> [Middle; SETS] {
    let offsets = samples.offsets();
    let mut all = [Middle { x: 0, y: 0, weight: 0.0 }; SETS];
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
        // To the nearest, halves up.
        let [x, y] = [(2 * sum[0] + n).div_euclid(2 * n), (2 * sum[1] + n).div_euclid(2 * n)];
        all[set] = Middle { x, y, weight: n as f32 };
        set += 1;
    }
    all
}

static MIDDLES_OF_TWO: [Middle; 4] = middles(Samples::Two);
static MIDDLES_OF_FOUR: [Middle; 16] = middles(Samples::Four);
static MIDDLES_OF_EIGHT: [Middle; 256] = middles(Samples::Eight);

/// [`middles`] of the pattern of `N` samples; of one there are no edges.
#[inline(always)]
fn middles_of<const N: usize>() -> &'static [Middle] {
    match N {
        2 => &MIDDLES_OF_TWO,
        4 => &MIDDLES_OF_FOUR,
        8 => &MIDDLES_OF_EIGHT,
        _ => &[],
    }
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
        scratch.edges.clear();
        scratch.n_wanted = 0;
        let width = rect.width as usize;
        dispatch!(self.scene.settings.simd, simd => match tile.samples() {
            Samples::One => scratch.rows::<_, 1>(simd, tile, rect, place, out.stride),
            Samples::Two => scratch.rows::<_, 2>(simd, tile, rect, place, out.stride),
            Samples::Four => scratch.rows::<_, 4>(simd, tile, rect, place, out.stride),
            Samples::Eight => scratch.rows::<_, 8>(simd, tile, rect, place, out.stride),
        });
        let n_whole = self.blocks(rect, &scratch.whole, width, out);
        let n_wanted = scratch.n_wanted;
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
        let one_sample = 1.0 / tile.samples().count() as f32;
        let Settings { background, encoding, simd, .. } = *self.scene.settings;
        let EdgeScratch { edges, weights, colors, codes, .. } = &mut scratch;
        // The mean of each edge takes the place of one of its own colours, or of one before.
        let mut first = 0;
        for (i, edge) in edges.iter().enumerate() {
            let own = first..first + edge.n_wanted as usize;
            first = own.end;
            let seen = colors[own.clone()].iter().zip(&weights[own]);
            colors[i] = blend(seen, one_sample, background);
        }
        let means = &colors[..edges.len()];
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
        let n_edges = scratch.edges.len() as u64;
        self.scratch.edges = scratch;
        n_whole + n_edges
    }
}

/// The mean of colours of so many samples each; all other samples see the background.
fn blend<'a>(
    colors: impl Iterator<Item = (&'a Vec4, &'a f32)>,
    one_sample: f32,
    background: Vec4,
) -> Vec4 {
    let (mut sum, mut seen) = (Vec4::ZERO, 0.0);
    for (color, n) in colors {
        sum += (color.truncate() * color.w).extend(color.w) * (n * one_sample);
        seen += n * one_sample;
    }
    let unseen = 1.0 - seen; // exact: multiples of an eighth
    if unseen > 0.0 {
        sum += (background.truncate() * background.w).extend(background.w) * unseen;
    }
    let partly = sum.w > 0.0 && sum.w < 1.0;
    if partly { (sum.truncate() / sum.w).extend(sum.w) } else { sum }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_of_a_pixel_are_shaded_around_its_middle() {
        fn check<const N: usize>(ids: [u32; N], samples: Samples) {
            let offsets: &[[i32; 2]; N] = samples.offsets().first_chunk().unwrap();
            let mut scratch = EdgeScratch {
                wanted: vec![Wanted::default(); N],
                weights: vec![0.0; N],
                ..EdgeScratch::default()
            };
            scratch.edge(ids, Place { x: 3, y: 5, out: 7 });
            let mut sum = [0.0; 2];
            let wanted = &scratch.wanted[..scratch.n_wanted];
            for (wanted, weight) in wanted.iter().zip(&scratch.weights) {
                let seen = offsets.iter().zip(ids).filter(|(_, id)| *id == wanted.id);
                let places: Vec<[f64; 2]> = seen.map(|(at, _)| at.map(f64::from)).collect();
                assert_eq!(places.len() as f32, *weight);
                let place = [wanted.x - 3 * 16 - 8, wanted.y - 5 * 16 - 8].map(f64::from);
                for axis in 0..2 {
                    let exact: f64 = places.iter().map(|at| at[axis]).sum::<f64>();
                    assert!((place[axis] - exact / f64::from(*weight)).abs() <= 0.5);
                    sum[axis] += f64::from(*weight) * place[axis];
                }
            }
            let n_seen = ids.iter().filter(|id| **id != NO_TRIANGLE).count();
            let weights = &scratch.weights[..scratch.n_wanted];
            assert_eq!(weights.iter().sum::<f32>(), n_seen as f32);
            if n_seen == N {
                assert!(sum.iter().all(|sum| sum.abs() <= 0.5 * N as f64), "{ids:?}: {sum:?}");
            }
        }
        for case in 0..4u32.pow(4) {
            let own = |sample: u32| match case >> (2 * sample) & 3 {
                0 => NO_TRIANGLE,
                id => id,
            };
            check([own(0), own(1)], Samples::Two);
            check([own(0), own(1), own(2), own(3)], Samples::Four);
            check([0, 1, 2, 3, 1, 0, 3, 2].map(own), Samples::Eight);
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
        let mean = blend([(&red, &1.0), (&green, &2.0)].into_iter(), 0.25, Vec4::ONE);
        assert_eq!(mean, Vec4::new(0.5, 0.75, 0.25, 1.0));
        let clear = Vec4::new(9.0, 9.0, 9.0, 0.0);
        let mean = blend([(&red, &1.0), (&green, &1.0)].into_iter(), 0.25, clear);
        assert_eq!(mean, Vec4::new(0.5, 0.5, 0.0, 0.5));
    }
}
