//! Trilinear filtering of eight pixels: [`mod@crate::sampler`], wide.
//!
//! Where the texels lie is found for eight pixels at once, then each pixel blends its own: left and
//! right neighbours are 16 bytes in a row, so one load fetches and one vector holds them; rows
//! are blended first, then left and right of both levels at once, then the levels. In this
//! form equal ends blend to exactly themselves.
//!
//! Places are f32 here, where the scalar sampler has f64: they are off by at most 1e-7 of the
//! picture's side, as texture coordinates are anyway.

use cullet_raster::prefetch;
use cullet_scene::Wrap;
use fearless_simd::{
    Simd, SimdCvtFloat, SimdCvtTruncate, f32x4, f32x8, i32x8, prelude::*, u16x8, u32x8,
};

use super::fixed::{self, Eight, Fixed, Sixteen};
use super::run::Places;
use crate::sampler::{Arithmetic, Filter, MOST_SAMPLES};
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
    pub fn footprint8<S: Simd>(&self, ddx: [f32x8<S>; 2], ddy: [f32x8<S>; 2]) -> f32x8<S> {
        let (width, height) = (self.width as f32, self.height as f32);
        let [xu, xv] = [ddx[0] * width, ddx[1] * height];
        let [yu, yv] = [ddy[0] * width, ddy[1] * height];
        let (x2, y2) = (xu * xu + xv * xv, yu * yu + yv * yv);
        // A comparison with NaN is false: then their sum, which is NaN too.
        let longer2 = x2.simd_gt(y2).select(x2, x2 + y2);
        y2.simd_ge(x2).select(y2, longer2)
    }

    /// A footprint cut along its longer axis, see [`Filter::Anisotropic`]: the squared length in texels of
    /// a piece, as [`Sampler::footprint8`] would give it, and the longer axis and the number of pieces.
    #[inline(always)]
    pub fn stretch8<S: Simd>(
        &self,
        simd: S,
        ddx: [f32x8<S>; 2],
        ddy: [f32x8<S>; 2],
    ) -> (f32x8<S>, [f32x8<S>; 3]) {
        let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
        let (width, height) = (self.width as f32, self.height as f32);
        let [xu, xv] = [ddx[0] * width, ddx[1] * height];
        let [yu, yv] = [ddy[0] * width, ddy[1] * height];
        let (x2, y2) = (xu * xu + xv * xv, yu * yu + yv * yv);
        let is_finite = (x2 + y2).simd_lt(f32x8::splat(simd, f32::INFINITY)); // false for NaN
        let x_is_longer = x2.simd_gt(y2);
        let longer2 = x_is_longer.select(x2, y2);
        let shorter2 = x_is_longer.select(y2, x2);
        let shorter2 = shorter2.simd_gt(one).select(shorter2, one);
        let most = f32x8::splat(simd, MOST_SAMPLES);
        let n = (longer2 / shorter2).sqrt() + 0.5;
        let n = n.simd_lt(most).select(n, most);
        let n = f32x8::float_from(i32x8::truncate_from(is_finite.select(n, one)));
        let n = n.simd_gt(one).select(n, one);
        let u = is_finite.select(x_is_longer.select(ddx[0], ddy[0]), zero);
        let v = is_finite.select(x_is_longer.select(ddx[1], ddy[1]), zero);
        let piece2 = is_finite.select(longer2 / (n * n), self.footprint8(ddx, ddy));
        (piece2, [u, v, n])
    }

    /// The means of `n` samples along the longer axis of each of eight footprints, in steps of texels;
    /// always in floats.
    #[inline(always)]
    #[expect(clippy::needless_range_loop, reason = "iterators over vectors may become calls")]
    pub fn mean8<S: Simd>(
        &self,
        simd: S,
        uv: [f32x8<S>; 2],
        lod: f32x8<S>,
        [axis_u, axis_v, n]: [f32x8<S>; 3],
        taps: &mut Taps,
    ) -> [[f32; 4]; 8] {
        let zero = f32x8::splat(simd, 0.0);
        let n_of: [f32; 8] = n.into();
        let mut most = 1;
        for n in n_of {
            most = most.max(n as usize);
        }
        let mut means = [[0.0; 4]; 8];
        let mut texels = [[[0.0; 4]; 8]; EIGHTS];
        for first in (0..most).step_by(EIGHTS) {
            let count = EIGHTS.min(most - first);
            for tap in 0..count {
                let i = f32x8::splat(simd, (first + tap) as f32);
                let along = (i + 0.5) / n - 0.5;
                let along = i.simd_lt(n).select(along, zero); // of no weight, and near
                let uv = [uv[0] + axis_u * along, uv[1] + axis_v * along];
                self.find8(simd, uv, lod, taps, tap);
            }
            self.blend_floats(simd, taps, count, &mut texels);
            for tap in 0..count {
                let i = first + tap;
                let share = 1.0 / (i + 1) as f32;
                for lane in 0..8 {
                    if i < n_of[lane] as usize {
                        let mean = f32x4::simd_from(simd, means[lane]);
                        let texel = f32x4::simd_from(simd, texels[tap][lane]);
                        means[lane] = (mean + (texel - mean) * share).into();
                    }
                }
            }
        }
        means
    }

    /// Level of detail, in `0..=n_levels - 1`, of a footprint, as in [`mod@crate::sampler`].
    #[inline(always)]
    pub fn lod8<S: Simd>(&self, simd: S, longer2: f32x8<S>) -> f32x8<S> {
        let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
        let coarsest = f32x8::splat(simd, self.coarsest);
        let longer2 = longer2 * self.area;
        // Four times the area is a level, and two binary exponents.
        let bits = longer2.bitcast::<i32x8<S>>();
        let level = (bits - 1.0_f32.to_bits() as i32) >> 24;
        let rest2 = (bits - (level << 24)).bitcast::<f32x8<S>>(); // of 1..4
        let share = if self.filter == Filter::Bilinear {
            // Halfway goes to the finer level.
            rest2.simd_gt(f32x8::splat(simd, 2.0)).select(one, zero)
        } else {
            rest2.sqrt() - one
        };
        let lod = f32x8::float_from(level) + share;
        let lod = lod.simd_lt(coarsest).select(lod, coarsest);
        let lod = longer2.simd_gt(one).select(lod, zero);
        // Not a number.
        longer2.simd_ge(zero).select(lod, coarsest)
    }

    /// Finds the texels around eight places, `8 * eight..` of `taps`. `lod` is as
    /// [`Sampler::lod8`] gives it.
    #[inline(always)]
    pub fn find8<S: Simd>(
        &self,
        simd: S,
        uv: [f32x8<S>; 2],
        lod: f32x8<S>,
        taps: &mut Taps,
        eight: usize,
    ) {
        let finer = i32x8::truncate_from(lod);
        let blend = lod - f32x8::float_from(finer);
        let place = [fold8(simd, uv[0], self.wrap[0]), fold8(simd, uv[1], self.wrap[1])];
        taps.blend[eight] = blend.into();
        taps.is_fine[eight] = !blend.simd_gt(f32x8::splat(simd, 0.0)).any_true();
        let levels: [i32; 8] = finer.into();
        let (own, coarser) = self.first[levels[0] as usize % MAX_LEVELS];
        let (mut first, mut first_coarser) = ([own; 8], [coarser; 8]);
        if !finer.simd_eq(i32x8::splat(simd, levels[0])).all_true() {
            for lane in 0..8 {
                let level = levels[lane] as usize % MAX_LEVELS;
                (first[lane], first_coarser[lane]) = self.first[level];
            }
        }
        self.find_in(simd, place, finer, first, &mut taps.fine, eight);
        if !taps.is_fine[eight] {
            // Beyond the coarsest level is that level again.
            self.find_in(simd, place, finer + 1, first_coarser, &mut taps.coarse, eight);
        }
    }

    /// Sends for the texels of the first `n` eights of places: most of them are read for the first time, and
    /// blending would wait for each. Neighbours of one triangle share lines of memory, others may not.
    #[inline(always)]
    pub fn send_for<S: Simd>(&self, simd: S, places: &Places, taps: &Taps, n: usize) {
        for eight in 0..n {
            let lanes = if places.is_one_triangle(simd, eight) { 3 } else { 1 };
            for lane in (0..8).step_by(lanes) {
                taps.fine.send_for(self.texels, eight, lane);
                if !taps.is_fine[eight] {
                    taps.coarse.send_for(self.texels, eight, lane);
                }
            }
        }
    }

    /// The four texels around each of eight places, each place in a level of its own, which
    /// begins at a texel of its own.
    #[inline(always)]
    fn find_in<S: Simd>(
        &self,
        simd: S,
        place: [f32x8<S>; 2],
        level: i32x8<S>,
        first: [i32; 8],
        taps: &mut LevelTaps,
        eight: usize,
    ) {
        let (columns, rows) = (side(simd, self.width, level), side(simd, self.height, level));
        let (left, x) = neighbours8(simd, place[0], columns, self.wrap[0]);
        let (upper, y) = neighbours8(simd, place[1], rows, self.wrap[1]);
        // As `texture::Size` has it.
        let widest = i32x8::splat(simd, STRIP as i32);
        let stride = columns.simd_lt(widest).select(columns, widest) + 1;
        let strip_len = stride * (rows + 1);
        let strip = (left >> STRIP.trailing_zeros()) * strip_len;
        let above =
            i32x8::simd_from(simd, first) + strip + upper * stride + (left & (STRIP as i32 - 1));
        taps.above[eight] = (above << 2).bitcast::<u32x8<S>>().into();
        taps.stride[eight] = (stride << 2).bitcast::<u32x8<S>>().into();
        taps.x[eight] = x.into();
        taps.y[eight] = y.into();
    }

    /// The colours of the first `n` eights of places, in steps of texels. Without `SPECIAL` in floats.
    #[inline(always)]
    pub fn blend_all<S: Simd, const SPECIAL: bool>(
        &self,
        simd: S,
        taps: &Taps,
        n: usize,
        out: &mut [[[f32; 4]; 8]; EIGHTS],
    ) {
        match self.arithmetic {
            _ if !SPECIAL => self.blend_floats(simd, taps, n, out),
            Arithmetic::Float => self.blend_floats(simd, taps, n, out),
            Arithmetic::Sixteen => self.blend_fixed::<_, Sixteen>(simd, taps, n, out),
            Arithmetic::Eight => self.blend_fixed::<_, Eight>(simd, taps, n, out),
        }
    }

    /// In whole numbers.
    #[inline(always)]
    fn blend_fixed<S: Simd, F: Fixed>(
        &self,
        simd: S,
        taps: &Taps,
        n: usize,
        out: &mut [[[f32; 4]; 8]; EIGHTS],
    ) {
        for (eight, out) in out.iter_mut().enumerate().take(n) {
            let weights =
                |of: &[f32; 8]| -> [i32; 8] { F::weights(f32x8::simd_from(simd, *of)).into() };
            let LevelTaps { x, y, .. } = &taps.fine;
            let [x, y] = [weights(&x[eight]), weights(&y[eight])];
            if taps.is_fine[eight] {
                for lane in 0..8 {
                    let rows = self.fixed_rows::<F>(&taps.fine, eight, lane, y[lane]);
                    out[lane] = fixed::color::<F>(&rows, x[lane] as i16);
                }
                continue;
            }
            let LevelTaps { x: coarse_x, y: coarse_y, .. } = &taps.coarse;
            let [coarse_x, coarse_y] = [weights(&coarse_x[eight]), weights(&coarse_y[eight])];
            let blend = weights(&taps.blend[eight]);
            for lane in 0..8 {
                let fine = self.fixed_rows::<F>(&taps.fine, eight, lane, y[lane]);
                let coarse = self.fixed_rows::<F>(&taps.coarse, eight, lane, coarse_y[lane]);
                let [left, right] = fixed::halves(&fine, &coarse);
                let x = [x[lane] as i16, coarse_x[lane] as i16];
                let levels = fixed::mix_halves::<F>(&left, &right, x);
                out[lane] = fixed::color::<F>(&levels, blend[lane] as i16);
            }
        }
    }

    /// [`Sampler::rows`] in whole numbers.
    #[inline(always)]
    fn fixed_rows<F: Fixed>(
        &self,
        taps: &LevelTaps,
        eight: usize,
        lane: usize,
        y: i32,
    ) -> [i16; 8] {
        let (upper, lower) = taps.rows(self.texels, eight, lane);
        fixed::mix::<F>(&fixed::pair::<F>(upper), &fixed::pair::<F>(lower), y as i16)
    }

    #[inline(always)]
    #[expect(clippy::needless_range_loop, reason = "iterators over vectors may become calls")]
    fn blend_floats<S: Simd>(
        &self,
        simd: S,
        taps: &Taps,
        n: usize,
        out: &mut [[[f32; 4]; 8]; EIGHTS],
    ) {
        let Taps { fine, coarse, blend, is_fine } = taps;
        for eight in 0..n {
            let out = &mut out[eight];
            if is_fine[eight] {
                for lane in 0..8 {
                    let (left, right) = self.rows(simd, fine, eight, lane).split();
                    let color = left + (right - left) * fine.x[eight][lane];
                    out[lane] = color.into();
                }
                continue;
            }
            for lane in 0..8 {
                let (fine_left, fine_right) = self.rows(simd, fine, eight, lane).split();
                let (coarse_left, coarse_right) = self.rows(simd, coarse, eight, lane).split();
                let left = fine_left.combine(coarse_left);
                let right = fine_right.combine(coarse_right);
                let x = f32x4::splat(simd, fine.x[eight][lane])
                    .combine(f32x4::splat(simd, coarse.x[eight][lane]));
                let (fine, coarse) = (left + (right - left) * x).split();
                let color = fine + (coarse - fine) * blend[eight][lane];
                out[lane] = color.into();
            }
        }
    }

    /// The left texels, blended, and the right ones.
    #[inline(always)]
    fn rows<S: Simd>(&self, simd: S, taps: &LevelTaps, eight: usize, lane: usize) -> f32x8<S> {
        let (upper, lower) = taps.rows(self.texels, eight, lane);
        let (upper, lower) = (pair(simd, upper), pair(simd, lower));
        upper + (lower - upper) * taps.y[eight][lane]
    }
}

/// Eights of places that go through a stage before the next begins: enough for one stage's long
/// chains of arithmetic to overlap, few enough to stay in the nearest cache.
pub(super) const EIGHTS: usize = 8;

/// Texels around places.
#[derive(Debug, Default)]
pub(super) struct Taps {
    fine: LevelTaps,
    coarse: LevelTaps,
    /// From the finer level to the coarser.
    blend: [[f32; 8]; EIGHTS],
    /// No place of an eight needs the coarser level.
    is_fine: [bool; EIGHTS],
}

/// In one level: the first channel of the upper left neighbour, how many channels later the lower
/// left one has its own, and how far right and down from the upper left one.
#[derive(Debug, Default)]
struct LevelTaps {
    above: [[u32; 8]; EIGHTS],
    stride: [[u32; 8]; EIGHTS],
    x: [[f32; 8]; EIGHTS],
    y: [[f32; 8]; EIGHTS],
}

impl LevelTaps {
    #[inline(always)]
    fn send_for(&self, texels: &[u16], eight: usize, lane: usize) {
        let (above, stride) = (self.above[eight][lane] as usize, self.stride[eight][lane] as usize);
        prefetch(texels, above);
        prefetch(texels, above + stride);
    }

    /// The channels of the upper two texels and of the lower two. Both pairs are cut from one slice,
    /// so that its ends are compared with those of the texture once.
    #[inline(always)]
    fn rows<'a>(&self, texels: &'a [u16], eight: usize, lane: usize) -> (&'a [u16], &'a [u16]) {
        let (above, stride) = (self.above[eight][lane] as usize, self.stride[eight][lane] as usize);
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

/// A coordinate brought into 0..=1, where the picture is; what is not a number becomes 0.
#[inline(always)]
fn fold8<S: Simd>(simd: S, u: f32x8<S>, wrap: Wrap) -> f32x8<S> {
    let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
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
fn side<S: Simd>(simd: S, base: u32, level: i32x8<S>) -> i32x8<S> {
    let one = i32x8::splat(simd, 1);
    let halved = simd.shrv_i32x8(i32x8::splat(simd, base as i32), level);
    halved.simd_gt(one).select(halved, one)
}

/// The texel whose centre is the last before a place in 0..=1, and how far it is from there to the
/// next, which is the one after in memory.
#[inline(always)]
fn neighbours8<S: Simd>(simd: S, place: f32x8<S>, n: i32x8<S>, wrap: Wrap) -> (i32x8<S>, f32x8<S>) {
    let (zero, n) = (f32x8::splat(simd, 0.0), f32x8::float_from(n));
    let last = n - 1.0;
    let x = place * n - 0.5;
    let before = x.simd_lt(zero);
    if wrap == Wrap::Repeat {
        let x = before.select(x + n, x);
        // Where a sum is rounded up to n, the way from the last texel is a whole one.
        let i = x.simd_lt(n).select(x, last);
        let i = i32x8::truncate_from(i);
        return (i, x - f32x8::float_from(i));
    }
    let x = before.select(zero, x);
    let x = x.simd_lt(last).select(x, last);
    let i = i32x8::truncate_from(x);
    (i, x - f32x8::float_from(i))
}
