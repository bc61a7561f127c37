//! Many colours to codes: [`Encoding::encode8`], wide.

use fearless_simd::{Level, Simd, SimdCvtTruncate, dispatch, f32x4, f32x8, prelude::*, u32x8};
use glam::Vec4;

use super::paint::transposed;
use crate::encoding::{Encoding, encode_by_polynomial, encode_by_table};
use crate::srgb::{Encoder, encoder};

/// Linear RGBA to 8-bit sRGB with linear alpha, as many as there are of both. Numbers outside `[0, 1]` become its
/// ends, what is not a number 0; alpha is rounded, halves to even.
pub fn encode_all(simd: Level, encoding: Encoding, colors: &[Vec4], codes: &mut [[u8; 4]]) {
    let encoder = encoder();
    dispatch!(simd, simd => encode_wide(simd, encoding, encoder, colors, codes));
}

/// Added and taken away, it rounds small numbers to whole ones, halves to even.
const TO_WHOLE: f32 = 12_582_912.0;

#[inline(always)]
fn encode_wide<S: Simd>(
    simd: S,
    encoding: Encoding,
    encoder: &Encoder,
    colors: &[Vec4],
    codes: &mut [[u8; 4]],
) {
    let n = colors.len().min(codes.len());
    let mut first = 0;
    while first < n {
        let len = (n - first).min(8);
        let mut eight = [Vec4::ZERO; 8];
        match colors[first..].first_chunk() {
            Some(colors) => eight = *colors,
            None => eight[..len].copy_from_slice(&colors[first..first + len]),
        }
        let [a, b, c, d, e, f, g, h] = eight;
        let [r, g, b, a] = transposed(&[
            f32x4::simd_from(simd, a.to_array()),
            f32x4::simd_from(simd, b.to_array()),
            f32x4::simd_from(simd, c.to_array()),
            f32x4::simd_from(simd, d.to_array()),
            f32x4::simd_from(simd, e.to_array()),
            f32x4::simd_from(simd, f.to_array()),
            f32x4::simd_from(simd, g.to_array()),
            f32x4::simd_from(simd, h.to_array()),
        ]);
        let mut rgb = [
            r.bitcast::<u32x8<S>>().into(),
            g.bitcast::<u32x8<S>>().into(),
            b.bitcast::<u32x8<S>>().into(),
        ];
        match encoding {
            Encoding::Exact => encoder.encode_all(simd, &mut rgb),
            Encoding::Table => encode_by_table(simd, &mut rgb),
            Encoding::Polynomial => encode_by_polynomial(simd, &mut rgb),
        }
        let [r, g, b] = [
            u32x8::simd_from(simd, rgb[0]),
            u32x8::simd_from(simd, rgb[1]),
            u32x8::simd_from(simd, rgb[2]),
        ];
        let (zero, most) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 255.0));
        let alpha = a * 255.0;
        let alpha = alpha.simd_gt(zero).select(alpha, zero); // NaN is 0
        let alpha = alpha.simd_lt(most).select(alpha, most);
        let alpha = u32x8::truncate_from(alpha + TO_WHOLE - TO_WHOLE);
        let all: [u32; 8] = (r | g << 8 | b << 16 | alpha << 24).into();
        for lane in 0..len {
            codes[first + lane] = all[lane].to_le_bytes();
        }
        first += 8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Random, levels};

    #[test]
    fn codes_are_those_of_one_number_at_a_time() {
        let mut random = Random::new(3);
        let odd = [f32::NAN, f32::INFINITY, -1.0, -0.0, 0.0, 1.0, 2.0, 0.5 / 255.0, 1.5 / 255.0];
        let mut number = || match random.unit() {
            x if x < 0.3 => odd[(x * 30.0) as usize],
            x => 1.5 * x - 0.2,
        };
        let colors: Vec<Vec4> =
            (0..1003).map(|_| Vec4::new(number(), number(), number(), number())).collect();
        for encoding in [Encoding::Exact, Encoding::Table, Encoding::Polynomial] {
            let plain: Vec<[u8; 4]> = colors
                .iter()
                .map(|c| {
                    let [r, g, b] = [c.x, c.y, c.z].map(|x| encoding.encode8(x));
                    [r, g, b, (c.w * 255.0).round_ties_even() as u8]
                })
                .collect();
            for (name, simd) in levels() {
                for n in [0, 1, 7, 8, 9, 1003] {
                    let mut codes = vec![[7; 4]; 1003];
                    encode_all(simd, encoding, &colors[..n], &mut codes);
                    assert_eq!(codes[..n], plain[..n], "{name}, {n}");
                    assert!(codes[n..].iter().all(|code| *code == [7; 4]));
                }
            }
        }
    }
}
