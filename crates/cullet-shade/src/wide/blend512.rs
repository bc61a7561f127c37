//! Texels blended with vectors of 512 bits: the operations of [`super::sampler`], in its order, on eight pixels of
//! two levels at once, or on sixteen of one.
//!
//! There, a pixel is blended at a time, its channels side by side, and most instructions move things about. Here the
//! rows of texels of eight pixels are turned while they are still short whole numbers, 32 to a vector; from then on a
//! lane is a pixel.

use std::arch::x86_64::*;

use fearless_simd::{Avx512, f32x8, f32x16, kernel, prelude::*, u16x8};

use super::column::Column;
use super::sampler::{LevelTaps, Taps};

/// The upper rows of two sources, then the lower rows.
#[inline(always)]
fn rows(token: Avx512, texels: &[u16], [(a, i), (b, j)]: [(&LevelTaps, usize); 2]) -> [__m128i; 4] {
    let (a_upper, a_lower) = a.rows(texels, i);
    let (b_upper, b_lower) = b.rows(texels, j);
    [
        u16x8::from_slice(token, a_upper).into(),
        u16x8::from_slice(token, b_upper).into(),
        u16x8::from_slice(token, a_lower).into(),
        u16x8::from_slice(token, b_lower).into(),
    ]
}

kernel!(
    /// Red, green and blue of the first `n` places, whole groups, in steps of texels.
    #[inline]
    #[expect(clippy::needless_range_loop, reason = "iterators over vectors may become calls")]
    pub(super) fn blend(
        token: Avx512,
        texels: &[u16],
        taps: &Taps,
        n: usize,
        out: &mut [Column<f32>; 3],
    ) {
        let Taps { fine, coarse, blend, is_fine } = taps;
        let mut pixels = [_mm512_setzero_si512(); 8];
        for group in 0..n.div_ceil(16) {
            let is_fine = is_fine[group];
            for half in 0..if is_fine { 1 } else { 2 } {
                // The second source: eight other pixels, or the other level.
                let a_at = 16 * group + 8 * half;
                let (b, b_at) = if is_fine { (fine, a_at + 8) } else { (coarse, a_at) };
                // In each part of 128 bits: left red, green, blue and alpha, and right. Pixel by pixel, for
                // the places of all at once are too many for the registers.
                let n_sources = n.saturating_sub(a_at).min(8);
                for i in 0..n_sources {
                    let [a, b, c, d] = rows(token, texels, [(fine, a_at + i), (b, b_at + i)]);
                    let upper = _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(a), b);
                    let lower = _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(c), d);
                    pixels[i] = _mm512_inserti64x4::<1>(_mm512_castsi256_si512(upper), lower);
                }
                let [p0, p1, p2, p3, p4, p5, p6, p7] = pixels;
                // Of two pixels each.
                let left01 = _mm512_unpacklo_epi16(p0, p1);
                let left23 = _mm512_unpacklo_epi16(p2, p3);
                let left45 = _mm512_unpacklo_epi16(p4, p5);
                let left67 = _mm512_unpacklo_epi16(p6, p7);
                let right01 = _mm512_unpackhi_epi16(p0, p1);
                let right23 = _mm512_unpackhi_epi16(p2, p3);
                let right45 = _mm512_unpackhi_epi16(p4, p5);
                let right67 = _mm512_unpackhi_epi16(p6, p7);
                // Red and green of four, then blue and alpha.
                let left_rg =
                    [_mm512_unpacklo_epi32(left01, left23), _mm512_unpacklo_epi32(left45, left67)];
                let left_b =
                    [_mm512_unpackhi_epi32(left01, left23), _mm512_unpackhi_epi32(left45, left67)];
                let right_rg = [
                    _mm512_unpacklo_epi32(right01, right23),
                    _mm512_unpacklo_epi32(right45, right67),
                ];
                let right_b = [
                    _mm512_unpackhi_epi32(right01, right23),
                    _mm512_unpackhi_epi32(right45, right67),
                ];
                let left = [
                    _mm512_unpacklo_epi64(left_rg[0], left_rg[1]),
                    _mm512_unpackhi_epi64(left_rg[0], left_rg[1]),
                    _mm512_unpacklo_epi64(left_b[0], left_b[1]),
                ];
                let right = [
                    _mm512_unpacklo_epi64(right_rg[0], right_rg[1]),
                    _mm512_unpackhi_epi64(right_rg[0], right_rg[1]),
                    _mm512_unpacklo_epi64(right_b[0], right_b[1]),
                ];
                let x = weights(token, &fine.x, a_at, &b.x, b_at);
                let y = weights(token, &fine.y, a_at, &b.y, b_at);
                let mut colors = [_mm512_setzero_ps(); 3];
                for channel in 0..3 {
                    let left = rows_blended(token, left[channel], y);
                    let right = rows_blended(token, right[channel], y);
                    let across = _mm512_mul_ps(_mm512_sub_ps(right, left), x);
                    colors[channel] = _mm512_add_ps(left, across);
                }
                for channel in 0..3 {
                    let out = &mut out[channel].0;
                    let color: f32x16<_> = colors[channel].simd_into(token);
                    if is_fine {
                        color.store_slice(&mut out[a_at..a_at + 16]);
                    } else {
                        let (fine, coarse) = color.split();
                        let blend = f32x8::from_slice(token, &blend.0[a_at..a_at + 8]);
                        let color = fine + (coarse - fine) * blend;
                        color.store_slice(&mut out[a_at..a_at + 8]);
                    }
                }
            }
        }
    }
);

/// Eight weights of each of two sources.
#[inline(always)]
fn weights(token: Avx512, a: &Column<f32>, a_at: usize, b: &Column<f32>, b_at: usize) -> __m512 {
    let a = f32x8::from_slice(token, &a.0[a_at..a_at + 8]);
    let b = f32x8::from_slice(token, &b.0[b_at..b_at + 8]);
    a.combine(b).into()
}

kernel!(
    /// A channel of texels in the upper and in the lower row.
    #[inline(always)]
    fn rows_blended(token: Avx512, rows: __m512i, y: __m512) -> __m512 {
        let upper = _mm512_cvtepu16_epi32(_mm512_castsi512_si256(rows));
        let lower = _mm512_cvtepu16_epi32(_mm512_extracti64x4_epi64::<1>(rows));
        let (upper, lower) = (_mm512_cvtepi32_ps(upper), _mm512_cvtepi32_ps(lower));
        _mm512_add_ps(upper, _mm512_mul_ps(_mm512_sub_ps(lower, upper), y))
    }
);
