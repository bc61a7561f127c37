//! Trilinear filtering of eight pixels: [`mod@crate::sampler`], wide.
//!
//! Where the texels lie is found for eight pixels at once, then each pixel blends its own: left and
//! right neighbours are eight bytes in a row, so one load fetches and one vector holds them; rows
//! are blended first, then left and right, then levels. Places are folded and scaled in f64 as
//! there. Colours differ from the scalar sampler's by rounding alone.

use cullet_scene::Wrap;
use fearless_simd::{
    Simd, SimdCvtFloat, SimdCvtTruncate, f32x4, f32x8, f64x4, i32x8, prelude::*, u16x8,
};
use glam::Vec4;

use crate::texture::{Mips, STEP, Texture};

/// Whether texel numbers fit the wide code: exact as f32, their products in i32.
pub(crate) fn fits(texture: &Texture) -> bool {
    let level = texture.mips.level(0);
    let (width, height) = (u64::from(level.width()), u64::from(level.height()));
    width <= 1 << 22 && height <= 1 << 22 && width * height < 1 << 31
}

/// The places of eight pixels in a texture and their changes per pixel.
pub(crate) struct Footprint8<S: Simd> {
    pub uv: [f32x8<S>; 2],
    pub ddx: [f32x8<S>; 2],
    pub ddy: [f32x8<S>; 2],
}

/// Writes the colours of the first `n` of eight pixels; `texture` must [fit](fits).
#[inline(always)]
pub(crate) fn trilinear8<S: Simd>(
    simd: S,
    texture: &Texture,
    footprint: &Footprint8<S>,
    n: usize,
    out: &mut [Vec4; 8],
) {
    let mips = &*texture.mips;
    let lod = lod8(simd, mips, footprint);
    let finer = i32x8::truncate_from(lod);
    let blend = lod - f32x8::float_from(finer);
    let place = [
        fold8(simd, footprint.uv[0], texture.wrap[0]),
        fold8(simd, footprint.uv[1], texture.wrap[1]),
    ];
    let fine_taps = Taps8::new(simd, texture, place, finer);
    let finer: [i32; 8] = finer.into();
    let zero = f32x8::splat(simd, 0.0);
    if !blend.simd_gt(zero).any_true() {
        for (lane, out) in out.iter_mut().enumerate().take(n) {
            *out = vec4(fine_taps.bilinear(simd, mips, lane, finer[lane]));
        }
        return;
    }
    let coarser = i32x8::truncate_from(lod) + 1;
    let coarse_taps = Taps8::new(simd, texture, place, coarser);
    let blend: [f32; 8] = blend.into();
    for (lane, out) in out.iter_mut().enumerate().take(n) {
        let color = fine_taps.bilinear(simd, mips, lane, finer[lane]);
        *out = vec4(if blend[lane] > 0.0 {
            let coarser = coarse_taps.bilinear(simd, mips, lane, finer[lane] + 1);
            color + (coarser - color) * blend[lane]
        } else {
            color
        });
    }
}

#[inline(always)]
fn vec4<S: Simd>(v: f32x4<S>) -> Vec4 {
    Vec4::from_array(v.into())
}

/// Level of detail, in `0..=n_levels - 1`.
#[inline(always)]
fn lod8<S: Simd>(simd: S, mips: &Mips, footprint: &Footprint8<S>) -> f32x8<S> {
    let base = mips.level(0);
    let (width, height) = (base.width() as f32, base.height() as f32);
    let [xu, xv] = [footprint.ddx[0] * width, footprint.ddx[1] * height];
    let [yu, yv] = [footprint.ddy[0] * width, footprint.ddy[1] * height];
    let (x2, y2) = (xu * xu + xv * xv, yu * yu + yv * yv);
    let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
    let coarsest = f32x8::splat(simd, (mips.n_levels() - 1) as f32);
    let longer2 = x2.simd_gt(y2).select(x2, y2);
    let lod = log2_8(longer2) * 0.5;
    let lod = lod.simd_lt(coarsest).select(lod, coarsest);
    let lod = longer2.simd_gt(one).select(lod, zero);
    // Not a number in either axis; infinities have passed, their logarithm is 128.
    (x2 + y2).simd_ge(zero).select(lod, coarsest)
}

/// Base 2 logarithm of numbers of at least 1, within 2e-7 and 1e-7 of itself; exact for powers of
/// two; 128 for infinity.
///
/// The exponent, and of the mantissa `m` in 0.7..1.4 the series
/// `2 / ln 2 (s + s^3 / 3 + s^5 / 5 + ...)` with `s = (m - 1) / (m + 1)`, four terms: what is left
/// out is below 4.1e-8.
/// Source: Abramowitz & Stegun, "Handbook of Mathematical Functions", 1964, 4.1.27.
#[inline(always)]
fn log2_8<S: Simd>(x: f32x8<S>) -> f32x8<S> {
    const SQRT_HALF: i32 = 0x3f35_04f3;
    const MANTISSA: i32 = 0x007f_ffff;
    let shifted = x.bitcast::<i32x8<S>>() - SQRT_HALF;
    let exponent = f32x8::float_from(shifted >> 23);
    let m = ((shifted & MANTISSA) + SQRT_HALF).bitcast::<f32x8<S>>();
    let s = (m - 1.0) / (m + 1.0);
    let s2 = s * s;
    let series = s2 * 0.412_198_58 + 0.577_078_04;
    let series = (s2 * series + 0.961_796_7) * s2 + 2.885_39;
    exponent + series * s
}

/// Eight f64 numbers.
type F64x8<S> = [f64x4<S>; 2];

/// A coordinate brought into one period, as the scalar sampler does it.
#[inline(always)]
fn fold8<S: Simd>(simd: S, u: f32x8<S>, wrap: Wrap) -> F64x8<S> {
    let (low, high) = u.widen();
    [fold4(simd, low, wrap), fold4(simd, high, wrap)]
}

#[inline(always)]
fn fold4<S: Simd>(simd: S, u: f64x4<S>, wrap: Wrap) -> f64x4<S> {
    let (zero, one) = (f64x4::splat(simd, 0.0), f64x4::splat(simd, 1.0));
    let folded = match wrap {
        Wrap::Repeat => u - u.floor(),
        Wrap::Mirror => u - (u * 0.5).floor() * 2.0,
        Wrap::Clamp => u.simd_lt(one).select(u, u.simd_ge(one).select(one, zero)),
    };
    folded.simd_ge(zero).select(folded, zero) // NaN, also from an infinity
}

/// The four texels around each of eight places, each place in a level of its own.
struct Taps8<S: Simd> {
    /// Number of the upper left texel.
    above: [i32; 8],
    /// Number of the lower left texel.
    below: [i32; 8],
    /// From a left texel to the right one.
    step: [i32; 8],
    /// How far right and down from the upper left centre.
    x: [f32; 8],
    y: [f32; 8],
    simd: std::marker::PhantomData<S>,
}

impl<S: Simd> Taps8<S> {
    #[inline(always)]
    fn new(simd: S, texture: &Texture, place: [F64x8<S>; 2], level: i32x8<S>) -> Self {
        let base = texture.mips.level(0);
        let (columns, rows) = (side(simd, base.width(), level), side(simd, base.height(), level));
        let (left, right, x) = neighbours8(simd, place[0], columns, texture.wrap[0]);
        let (upper, lower, y) = neighbours8(simd, place[1], rows, texture.wrap[1]);
        Taps8 {
            above: (upper * (columns + 1) + left).into(),
            below: (lower * (columns + 1) + left).into(),
            step: (right - left).into(),
            x: x.into(),
            y: y.into(),
            simd: std::marker::PhantomData,
        }
    }

    /// The colour of one of the places.
    #[inline(always)]
    fn bilinear(&self, simd: S, mips: &Mips, lane: usize, level: i32) -> f32x4<S> {
        let texels = mips.all_texels().as_chunks().0;
        let first = mips.first_texel(level as usize);
        let step = self.step[lane];
        let upper = pair(simd, texels, first + self.above[lane] as usize, step);
        let lower = pair(simd, texels, first + self.below[lane] as usize, step);
        let (left, right) = (upper + (lower - upper) * self.y[lane]).split();
        (left + (right - left) * self.x[lane]) * STEP
    }
}

/// A texel and the one `step` behind it.
#[inline(always)]
fn pair<S: Simd>(simd: S, texels: &[[u16; 4]], first: usize, step: i32) -> f32x8<S> {
    let [a, b, c, d] = texels[first];
    let [e, f, g, h] = texels[(first as i32 + step) as usize];
    let (left, right) = u16x8::simd_from(simd, [a, b, c, d, e, f, g, h]).widen();
    f32x8::float_from(left.combine(right))
}

/// Texels along one axis of each level; see [`crate::texture`].
#[inline(always)]
fn side<S: Simd>(simd: S, base: u32, level: i32x8<S>) -> i32x8<S> {
    let one = i32x8::splat(simd, 1);
    let halved = simd.shrv_i32x8(i32x8::splat(simd, base as i32), level);
    halved.simd_gt(one).select(halved, one)
}

/// The texels whose centres enclose the place, and how far it is towards the second.
#[inline(always)]
fn neighbours8<S: Simd>(
    simd: S,
    folded: F64x8<S>,
    n: i32x8<S>,
    wrap: Wrap,
) -> (i32x8<S>, i32x8<S>, f32x8<S>) {
    let (n_low, n_high) = f32x8::float_from(n).widen();
    let (low, high) = (folded[0] * n_low - 0.5, folded[1] * n_high - 0.5);
    let (floor_low, floor_high) = (low.floor(), high.floor());
    let fraction = (low - floor_low).narrow(high - floor_high);
    let i = i32x8::truncate_from(floor_low.narrow(floor_high));
    (wrapped8(simd, i, n, wrap), wrapped8(simd, i + 1, n, wrap), fraction)
}

/// The texel that stands for texel `i` of the endless plane, for `i` at most one texel outside
/// the period.
#[inline(always)]
fn wrapped8<S: Simd>(simd: S, i: i32x8<S>, n: i32x8<S>, wrap: Wrap) -> i32x8<S> {
    let zero = i32x8::splat(simd, 0);
    match wrap {
        Wrap::Repeat => {
            let i = i.simd_lt(zero).select(i + n, i);
            i.simd_lt(n).select(i, i - n)
        }
        Wrap::Mirror => {
            let i = i.simd_lt(n).select(i, n + n - 1 - i);
            i.simd_lt(zero).select(zero - 1 - i, i)
        }
        Wrap::Clamp => {
            let i = i.simd_lt(zero).select(zero, i);
            i.simd_lt(n).select(i, n - 1)
        }
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};

    use super::*;

    fn log2(x: f32) -> f32 {
        #[inline(always)]
        fn first<S: Simd>(simd: S, x: f32) -> f32 {
            <[f32; 8]>::from(log2_8(f32x8::splat(simd, x)))[0]
        }
        dispatch!(Level::new(), simd => first(simd, x))
    }

    #[test]
    fn logarithms_are_within_their_stated_error() {
        for bits in (1.0_f32.to_bits()..f32::MAX.to_bits()).step_by(4099) {
            let x = f32::from_bits(bits);
            let exact = libm::log2(f64::from(x));
            let error = (f64::from(log2(x)) - exact).abs();
            assert!(error <= 2e-7 + 1e-7 * exact, "{error:e} at {x:e}");
        }
        for exponent in 0..128 {
            assert_eq!(log2(f32::from_bits((127 + exponent) << 23)), exponent as f32);
        }
        assert_eq!(log2(f32::INFINITY), 128.0);
    }
}
