//! Trilinear filtering of many pixels: [`mod@crate::sampler`], wide.
//!
//! Where the texels lie is found for a group of pixels at once, then each pixel blends its own (but see
//! `blend512`): left and right neighbours are 16 bytes in a row, so one load fetches and one vector holds them; rows
//! are blended first, then left and right of both levels at once, then the levels. In this
//! form equal ends blend to exactly themselves.
//!
//! Places are f32 here, where the scalar sampler has f64: they are off by at most 1e-7 of the
//! picture's side, as texture coordinates are anyway.

use cullet_raster::prefetch;
use cullet_scene::Wrap;
#[cfg(target_arch = "x86_64")]
use fearless_simd::Level;
use fearless_simd::{Simd, SimdCvtFloat, SimdCvtTruncate, f32x4, f32x8, i32x8, prelude::*, u16x8};

use super::column::{Column, Lanes, MOST_GROUPS, ROOM};
use super::fixed::{self, Eight, Fixed, Sixteen};
use super::run::Places;
use super::turn::{fours, turned4};
use crate::sampler::{Arithmetic, Filter, LOG2, MOST_SAMPLES};
use crate::texture::{STRIP, Texture};

/// The most levels a texture can have here.
const MAX_LEVELS: usize = 32;

/// A texture, what sampling asks of it in the form that it asks for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sampler<'a> {
    texels: &'a [u16],
    /// Where each level and the next begin, in texels.
    first: [(i32, i32); MAX_LEVELS],
    width: u32,
    height: u32,
    coarsest: f32,
    wrap: [Wrap; 2],
    filter: Filter,
    arithmetic: Arithmetic,
    /// The part of a pixel that a sample stands for.
    area: f32,
}

impl<'a> Sampler<'a> {
    /// `None` for what the wide code does not serve: nearest texels, which are for looking
    /// closely, and textures too large to number their texels in an i32.
    pub fn new(texture: &'a Texture, filter: Filter, arithmetic: Arithmetic) -> Option<Self> {
        let mips = &*texture.mips;
        let (base, texels) = (mips.level(0), mips.all_texels());
        if filter == Filter::Nearest || texels.len() > i32::MAX as usize {
            return None;
        }
        let mut first = [(0, 0); MAX_LEVELS];
        for (level, first) in first.iter_mut().enumerate() {
            let begin = |level: usize| mips.first_texel(level.min(mips.n_levels() - 1)) as i32;
            *first = (begin(level), begin(level + 1));
        }
        Some(Sampler {
            texels,
            first,
            width: base.width(),
            height: base.height(),
            coarsest: (mips.n_levels() - 1) as f32,
            wrap: texture.wrap,
            filter,
            arithmetic,
            area: filter.area(),
        })
    }

    /// Whether texels are blended in whole numbers.
    pub fn is_fixed(&self) -> bool {
        self.arithmetic != Arithmetic::Float
    }

    /// The squared length in texels of the longer side of a pixel, by the changes of texture
    /// coordinates per pixel; NaN if either side is.
    #[inline(always)]
    pub fn footprint<S: Simd, V: Lanes<S>>(&self, ddx: [V; 2], ddy: [V; 2]) -> V {
        let (width, height) = (self.width as f32, self.height as f32);
        let [xu, xv] = [ddx[0] * width, ddx[1] * height];
        let [yu, yv] = [ddy[0] * width, ddy[1] * height];
        let (x2, y2) = (xu * xu + xv * xv, yu * yu + yv * yv);
        // A comparison with NaN is false: then their sum, which is NaN too.
        let longer2 = x2.simd_gt(y2).select(x2, x2 + y2);
        y2.simd_ge(x2).select(y2, longer2)
    }

    /// A footprint cut along its longer axis, see [`Filter::Anisotropic`]: the squared length in texels of
    /// a piece, as [`Sampler::footprint`] would give it, and the longer axis and the number of pieces.
    #[inline(always)]
    pub fn stretch<S: Simd, V: Lanes<S>>(&self, simd: S, ddx: [V; 2], ddy: [V; 2]) -> (V, [V; 3]) {
        let (zero, one) = (V::splat(simd, 0.0), V::splat(simd, 1.0));
        let (width, height) = (self.width as f32, self.height as f32);
        let [xu, xv] = [ddx[0] * width, ddx[1] * height];
        let [yu, yv] = [ddy[0] * width, ddy[1] * height];
        let (x2, y2) = (xu * xu + xv * xv, yu * yu + yv * yv);
        let is_finite = (x2 + y2).simd_lt(V::splat(simd, f32::INFINITY)); // false for NaN
        let x_is_longer = x2.simd_gt(y2);
        let longer2 = x_is_longer.select(x2, y2);
        let shorter2 = x_is_longer.select(y2, x2);
        let shorter2 = shorter2.simd_gt(one).select(shorter2, one);
        let most = V::splat(simd, MOST_SAMPLES);
        let n = (longer2 / shorter2).sqrt() + 0.5;
        let n = n.simd_lt(most).select(n, most);
        let n = V::float_from(V::Ints::truncate_from(is_finite.select(n, one)));
        let n = n.simd_gt(one).select(n, one);
        let u = is_finite.select(x_is_longer.select(ddx[0], ddy[0]), zero);
        let v = is_finite.select(x_is_longer.select(ddx[1], ddy[1]), zero);
        let piece2 = is_finite.select(longer2 / (n * n), self.footprint::<S, V>(ddx, ddy));
        (piece2, [u, v, n])
    }

    /// The means of `n` samples along the longer axis of each footprint of a group, in steps of texels;
    /// always in floats.
    #[inline(always)]
    #[expect(clippy::needless_range_loop, reason = "iterators over vectors may become calls")]
    #[expect(clippy::too_many_arguments, reason = "what a group has, and where it goes")]
    pub fn means<S: Simd, V: Lanes<S>>(
        &self,
        simd: S,
        uv: [V; 2],
        lod: V,
        [axis_u, axis_v, n]: [V; 3],
        taps: &mut Taps,
        texels: &mut [[f32; 4]; ROOM],
        means: &mut [[f32; 4]],
    ) {
        let zero = V::splat(simd, 0.0);
        let n_of = n.as_slice();
        let mut most = 1;
        for lane in 0..V::LEN {
            most = most.max(n_of[lane] as usize);
        }
        means.fill([0.0; 4]);
        let at_once = ROOM / V::LEN;
        for first in (0..most).step_by(at_once) {
            let count = at_once.min(most - first);
            for tap in 0..count {
                let i = V::splat(simd, (first + tap) as f32);
                let along = (i + 0.5) / n - 0.5;
                let along = i.simd_lt(n).select(along, zero); // of no weight, and near
                let uv = [uv[0] + axis_u * along, uv[1] + axis_v * along];
                self.find(simd, uv, lod, taps, tap);
            }
            self.blend_floats::<S, V>(simd, taps, count * V::LEN, texels);
            for tap in 0..count {
                let i = first + tap;
                let share = 1.0 / (i + 1) as f32;
                for lane in 0..V::LEN {
                    if i < n_of[lane] as usize {
                        let mean = f32x4::simd_from(simd, means[lane]);
                        let texel = f32x4::simd_from(simd, texels[tap * V::LEN + lane]);
                        means[lane] = (mean + (texel - mean) * share).into();
                    }
                }
            }
        }
    }

    /// Level of detail, in `0..=n_levels - 1`, of a footprint, as in [`mod@crate::sampler`].
    #[inline(always)]
    pub fn levels<S: Simd, V: Lanes<S>>(&self, simd: S, longer2: V) -> V {
        let (zero, one) = (V::splat(simd, 0.0), V::splat(simd, 1.0));
        let coarsest = V::splat(simd, self.coarsest);
        let longer2 = longer2 * self.area;
        // Four times the area is a level, and two binary exponents.
        let bits = longer2.bitcast::<V::Ints>();
        let level = (bits - 1.0_f32.to_bits() as i32) >> 24;
        let rest2 = (bits - (level << 24)).bitcast::<V>(); // of 1..4
        let share = match self.filter {
            // Halfway goes to the finer level.
            Filter::Bilinear => rest2.simd_gt(V::splat(simd, 2.0)).select(one, zero),
            Filter::TrilinearLog => log2_of_1_to_2::<S, V>(rest2.sqrt()),
            _ => rest2.sqrt() - one,
        };
        let lod = V::float_from(level) + share;
        let lod = lod.simd_lt(coarsest).select(lod, coarsest);
        let lod = longer2.simd_gt(one).select(lod, zero);
        // Not a number.
        longer2.simd_ge(zero).select(lod, coarsest)
    }

    /// Finds the texels around the places of a group. `lod` is as [`Sampler::levels`] gives it.
    #[inline(always)]
    #[expect(clippy::needless_range_loop, reason = "iterators over vectors may become calls")]
    pub fn find<S: Simd, V: Lanes<S>>(
        &self,
        simd: S,
        uv: [V; 2],
        lod: V,
        taps: &mut Taps,
        group: usize,
    ) {
        let finer = V::Ints::truncate_from(lod);
        let blend = lod - V::float_from(finer);
        let place = [fold(simd, uv[0], self.wrap[0]), fold(simd, uv[1], self.wrap[1])];
        taps.blend.set(group, blend);
        let is_fine = !blend.simd_gt(V::splat(simd, 0.0)).any_true();
        taps.is_fine[group] = is_fine;
        let levels = finer.as_slice();
        let (own, coarser) = self.first[levels[0] as usize % MAX_LEVELS];
        let mut first = V::Ints::splat(simd, own);
        let mut first_coarser = V::Ints::splat(simd, coarser);
        if !finer.simd_eq(V::Ints::splat(simd, levels[0])).all_true() {
            for lane in 0..V::LEN {
                let level = levels[lane] as usize % MAX_LEVELS;
                let (own, coarser) = self.first[level];
                first.as_mut_slice()[lane] = own;
                first_coarser.as_mut_slice()[lane] = coarser;
            }
        }
        self.find_in(simd, place, finer, first, &mut taps.fine, group);
        if !is_fine {
            // Beyond the coarsest level is that level again.
            self.find_in(simd, place, finer + 1, first_coarser, &mut taps.coarse, group);
        }
    }

    /// Sends for the texels of the first `n_groups`: most of them are read for the first time, and
    /// blending would wait for each.
    #[inline(always)]
    pub fn send_for<S: Simd, V: Lanes<S>>(
        &self,
        simd: S,
        places: &Places,
        taps: &Taps,
        n_groups: usize,
    ) {
        for group in 0..n_groups {
            let is_one = places.is_one_triangle::<S, V>(simd, group);
            taps.fine.send_for::<S, V>(self.texels, group, is_one);
            if !taps.is_fine[group] {
                taps.coarse.send_for::<S, V>(self.texels, group, is_one);
            }
        }
    }

    /// The four texels around each place of a group, each place in a level of its own, which
    /// begins at a texel of its own.
    #[inline(always)]
    fn find_in<S: Simd, V: Lanes<S>>(
        &self,
        simd: S,
        place: [V; 2],
        level: V::Ints,
        first: V::Ints,
        taps: &mut LevelTaps,
        group: usize,
    ) {
        let (columns, rows) =
            (side::<S, V>(simd, self.width, level), side::<S, V>(simd, self.height, level));
        let (left, x) = neighbours(simd, place[0], columns, self.wrap[0]);
        let (upper, y) = neighbours(simd, place[1], rows, self.wrap[1]);
        // As `texture::Size` has it.
        let widest = V::Ints::splat(simd, STRIP as i32);
        let stride = columns.min(widest) + 1;
        let strip_len = stride * (rows + 1);
        let strip = (left >> STRIP.trailing_zeros()) * strip_len;
        let above = first + strip + upper * stride + (left & (STRIP as i32 - 1));
        taps.above.set(group, (above << 2).bitcast::<V::Uints>());
        taps.stride.set(group, (stride << 2).bitcast::<V::Uints>());
        taps.x.set(group, x);
        taps.y.set(group, y);
    }

    /// The colours of the first `n` places, in steps of texels. Without `SPECIAL` in floats.
    #[inline(always)]
    pub fn blend_all<S: Simd, V: Lanes<S>, const SPECIAL: bool>(
        &self,
        simd: S,
        taps: &Taps,
        n: usize,
        out: &mut [[f32; 4]; ROOM],
    ) {
        match self.arithmetic {
            _ if !SPECIAL => self.blend_floats::<S, V>(simd, taps, n, out),
            Arithmetic::Float => self.blend_floats::<S, V>(simd, taps, n, out),
            Arithmetic::Sixteen => self.blend_fixed::<S, V, Sixteen>(simd, taps, n, out),
            Arithmetic::Eight => self.blend_fixed::<S, V, Eight>(simd, taps, n, out),
        }
    }

    /// Red, green and blue as [`Sampler::blend_all`] has them; of the last group those beyond `n` mean nothing.
    /// `texels` is scratch.
    #[inline(always)]
    pub fn blend_colors<S: Simd, V: Lanes<S>, const SPECIAL: bool>(
        &self,
        simd: S,
        taps: &Taps,
        n: usize,
        texels: &mut [[f32; 4]; ROOM],
        out: &mut [Column<f32>; 3],
    ) {
        #[cfg(target_arch = "x86_64")]
        if !SPECIAL
            && V::LEN == 16
            && let Level::Avx512(token) = simd.level()
        {
            return super::blend512::blend(token, self.texels, taps, n, out);
        }
        self.blend_all::<S, V, SPECIAL>(simd, taps, n, texels);
        for group in 0..n.div_ceil(V::LEN) {
            set_colors::<S, V>(simd, texels, group, out);
        }
    }

    /// In whole numbers.
    #[inline(always)]
    fn blend_fixed<S: Simd, V: Lanes<S>, F: Fixed>(
        &self,
        simd: S,
        taps: &Taps,
        n: usize,
        out: &mut [[f32; 4]; ROOM],
    ) {
        for (group, out) in out[..n].chunks_mut(V::LEN).enumerate() {
            let weights = |of: &Column<f32>| F::weights::<S, V>(simd, of.get(simd, group));
            let [x, y] = [weights(&taps.fine.x), weights(&taps.fine.y)];
            let [x, y] = [x.as_slice(), y.as_slice()];
            if taps.is_fine[group] {
                for (lane, out) in out.iter_mut().enumerate() {
                    let rows = self.fixed_rows::<S, V, F>(&taps.fine, group, lane, y[lane]);
                    *out = fixed::color::<F>(&rows, x[lane] as i16);
                }
                continue;
            }
            let [coarse_x, coarse_y] = [weights(&taps.coarse.x), weights(&taps.coarse.y)];
            let [coarse_x, coarse_y] = [coarse_x.as_slice(), coarse_y.as_slice()];
            let blend = weights(&taps.blend);
            let blend = blend.as_slice();
            for (lane, out) in out.iter_mut().enumerate() {
                let fine = self.fixed_rows::<S, V, F>(&taps.fine, group, lane, y[lane]);
                let coarse = self.fixed_rows::<S, V, F>(&taps.coarse, group, lane, coarse_y[lane]);
                let [left, right] = fixed::halves(&fine, &coarse);
                let x = [x[lane] as i16, coarse_x[lane] as i16];
                let levels = fixed::mix_halves::<F>(&left, &right, x);
                *out = fixed::color::<F>(&levels, blend[lane] as i16);
            }
        }
    }

    /// [`Sampler::rows`] in whole numbers.
    #[inline(always)]
    fn fixed_rows<S: Simd, V: Lanes<S>, F: Fixed>(
        &self,
        taps: &LevelTaps,
        group: usize,
        lane: usize,
        y: i32,
    ) -> [i16; 8] {
        let (upper, lower) = taps.rows(self.texels, group * V::LEN + lane);
        fixed::mix::<F>(&fixed::pair::<F>(upper), &fixed::pair::<F>(lower), y as i16)
    }

    #[inline(always)]
    #[expect(clippy::needless_range_loop, reason = "iterators over vectors may become calls")]
    fn blend_floats<S: Simd, V: Lanes<S>>(
        &self,
        simd: S,
        taps: &Taps,
        n: usize,
        out: &mut [[f32; 4]; ROOM],
    ) {
        let Taps { fine, coarse, blend, is_fine } = taps;
        let n = n.min(ROOM);
        for group in 0..n.div_ceil(V::LEN) {
            let first = group * V::LEN;
            let end = n.min(first + V::LEN);
            if is_fine[group] {
                for i in first..end {
                    let (left, right) = self.rows(simd, fine, i).split();
                    let color = left + (right - left) * fine.x.0[i];
                    out[i] = color.into();
                }
                continue;
            }
            for i in first..end {
                let (fine_left, fine_right) = self.rows(simd, fine, i).split();
                let (coarse_left, coarse_right) = self.rows(simd, coarse, i).split();
                let left = fine_left.combine(coarse_left);
                let right = fine_right.combine(coarse_right);
                let x = f32x4::splat(simd, fine.x.0[i]).combine(f32x4::splat(simd, coarse.x.0[i]));
                let (fine, coarse) = (left + (right - left) * x).split();
                let color = fine + (coarse - fine) * blend.0[i];
                out[i] = color.into();
            }
        }
    }

    /// The left texels, blended, and the right ones.
    #[inline(always)]
    fn rows<S: Simd>(&self, simd: S, taps: &LevelTaps, i: usize) -> f32x8<S> {
        let (upper, lower) = taps.rows(self.texels, i);
        let (upper, lower) = (pair(simd, upper), pair(simd, lower));
        upper + (lower - upper) * taps.y.0[i]
    }
}

/// Red, green and blue of a group, from all channels pixel by pixel.
#[inline(always)]
pub(super) fn set_colors<S: Simd, V: Lanes<S>>(
    simd: S,
    texels: &[[f32; 4]; ROOM],
    group: usize,
    out: &mut [Column<f32>; 3],
) {
    let texels = &texels[group * V::LEN..][..V::LEN];
    let [r, g, b, _] = turned4::<S, V>(&fours(simd, texels));
    out[0].set(group, r);
    out[1].set(group, g);
    out[2].set(group, b);
}

/// Texels around places.
#[derive(Debug, Default)]
pub(super) struct Taps {
    pub(super) fine: LevelTaps,
    pub(super) coarse: LevelTaps,
    /// From the finer level to the coarser.
    pub(super) blend: Column<f32>,
    /// No place of a group needs the coarser level.
    pub(super) is_fine: [bool; MOST_GROUPS],
}

/// In one level: the first channel of the upper left neighbour, how many channels later the lower
/// left one has its own, and how far right and down from the upper left one.
#[derive(Debug, Default)]
pub(super) struct LevelTaps {
    above: Column<u32>,
    stride: Column<u32>,
    pub(super) x: Column<f32>,
    pub(super) y: Column<f32>,
}

impl LevelTaps {
    /// Neighbours of one triangle share lines of memory.
    #[inline(always)]
    fn send_for<S: Simd, V: Lanes<S>>(&self, texels: &[u16], group: usize, is_one: bool) {
        let (above, stride) = (self.above.of(group, V::LEN), self.stride.of(group, V::LEN));
        if is_one {
            for lane in (0..V::LEN).step_by(3) {
                prefetch(texels, above[lane] as usize);
                prefetch(texels, above[lane] as usize + stride[lane] as usize);
            }
        } else {
            for lane in 0..V::LEN {
                prefetch(texels, above[lane] as usize);
                prefetch(texels, above[lane] as usize + stride[lane] as usize);
            }
        }
    }

    /// The channels of the upper two texels of a place and of the lower two. Both pairs are cut from one
    /// slice, so that its ends are compared with those of the texture once.
    #[inline(always)]
    pub(super) fn rows<'a>(&self, texels: &'a [u16], i: usize) -> (&'a [u16], &'a [u16]) {
        let (above, stride) = (self.above.0[i] as usize, self.stride.0[i] as usize);
        let len = stride + 8;
        let both = &texels[above..above + len];
        (&both[..8], &both[stride..])
    }
}

/// A texel and the one after it.
#[inline(always)]
fn pair<S: Simd>(simd: S, channels: &[u16]) -> f32x8<S> {
    let (left, right) = u16x8::from_slice(simd, channels).widen();
    // Signed, which is one instruction.
    f32x8::float_from(left.combine(right).bitcast::<i32x8<S>>())
}

/// As in [`mod@crate::sampler`], to the bit.
#[inline(always)]
fn log2_of_1_to_2<S: Simd, V: Lanes<S>>(x: V) -> V {
    let s = (x - 1.0) / (x + 1.0);
    let s2 = s * s;
    (((s2 * LOG2[3] + LOG2[2]) * s2 + LOG2[1]) * s2 + LOG2[0]) * s
}

/// A coordinate brought into 0..=1, where the picture is; what is not a number becomes 0.
#[inline(always)]
fn fold<S: Simd, V: Lanes<S>>(simd: S, u: V, wrap: Wrap) -> V {
    let (zero, one) = (V::splat(simd, 0.0), V::splat(simd, 1.0));
    let folded = match wrap {
        Wrap::Repeat => u - u.floor(),
        Wrap::Mirror => {
            let folded = u - (u * 0.5).floor() * 2.0;
            folded.simd_gt(one).select(one + one - folded, folded)
        }
        Wrap::Clamp => u.simd_lt(one).select(u, u.simd_ge(one).select(one, zero)),
    };
    folded.simd_ge(zero).select(folded, zero) // NaN, also from an infinity
}

/// Texels along one axis of each level; see [`crate::texture`].
#[inline(always)]
fn side<S: Simd, V: Lanes<S>>(simd: S, base: u32, level: V::Ints) -> V::Ints {
    let one = V::Ints::splat(simd, 1);
    let halved = V::Ints::splat(simd, base as i32) >> level;
    halved.max(one)
}

/// The texel whose centre is the last before a place in 0..=1, and how far it is from there to the
/// next, which is the one after in memory.
#[inline(always)]
fn neighbours<S: Simd, V: Lanes<S>>(simd: S, place: V, n: V::Ints, wrap: Wrap) -> (V::Ints, V) {
    let (zero, n) = (V::splat(simd, 0.0), V::float_from(n));
    let last = n - 1.0;
    let x = place * n - 0.5;
    let before = x.simd_lt(zero);
    if wrap == Wrap::Repeat {
        let x = before.select(x + n, x);
        // Where a sum is rounded up to n, the way from the last texel is a whole one.
        let i = x.simd_lt(n).select(x, last);
        let i = V::Ints::truncate_from(i);
        return (i, x - V::float_from(i));
    }
    let x = before.select(zero, x);
    let x = x.simd_lt(last).select(x, last);
    let i = V::Ints::truncate_from(x);
    (i, x - V::float_from(i))
}
