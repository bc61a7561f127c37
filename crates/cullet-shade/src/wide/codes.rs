//! Many colours to codes: [`Encoding::encode8`], wide.

use fearless_simd::{Level, Simd, SimdCvtTruncate, dispatch, prelude::*};
use glam::Vec4;

use super::column::{Lanes, WIDEST, wide};
use super::turn::{fours, turned4};
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
    wide!(S, encode_groups(simd, encoding, encoder, colors, codes));
}

#[inline(always)]
fn encode_groups<S: Simd, V: Lanes<S>>(
    simd: S,
    encoding: Encoding,
    encoder: &Encoder,
    colors: &[Vec4],
    codes: &mut [[u8; 4]],
) {
    let n = colors.len().min(codes.len());
    let mut first = 0;
    while first < n {
        let len = (n - first).min(V::LEN);
        let mut group = [[0.0; 4]; WIDEST];
        for lane in 0..len {
            group[lane] = colors[first + lane].to_array();
        }
        let [r, g, b, a] = turned4::<S, V>(&fours(simd, &group[..V::LEN]));
        let mut rgb = [0; 3 * WIDEST];
        let rgb = &mut rgb[..3 * V::LEN];
        r.bitcast::<V::Uints>().store_slice(&mut rgb[..V::LEN]);
        g.bitcast::<V::Uints>().store_slice(&mut rgb[V::LEN..2 * V::LEN]);
        b.bitcast::<V::Uints>().store_slice(&mut rgb[2 * V::LEN..]);
        match encoding {
            Encoding::Exact => encoder.encode_all::<S, V>(simd, rgb),
            Encoding::Table => encode_by_table::<S, V>(simd, rgb),
            Encoding::Polynomial => encode_by_polynomial::<S, V>(simd, rgb),
        }
        let r = V::Uints::from_slice(simd, &rgb[..V::LEN]);
        let g = V::Uints::from_slice(simd, &rgb[V::LEN..2 * V::LEN]);
        let b = V::Uints::from_slice(simd, &rgb[2 * V::LEN..]);
        let (zero, most) = (V::splat(simd, 0.0), V::splat(simd, 255.0));
        let alpha = a * 255.0;
        let alpha = alpha.simd_gt(zero).select(alpha, zero); // NaN is 0
        let alpha = alpha.simd_lt(most).select(alpha, most);
        let alpha = V::Uints::truncate_from(alpha + TO_WHOLE - TO_WHOLE);
        let all = r | g << 8 | b << 16 | alpha << 24;
        for lane in 0..len {
            codes[first + lane] = all.as_slice()[lane].to_le_bytes();
        }
        first += len;
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
                for n in [0, 1, 7, 8, 9, 15, 16, 17, 1003] {
                    let mut codes = vec![[7; 4]; 1003];
                    encode_all(simd, encoding, &colors[..n], &mut codes);
                    assert_eq!(codes[..n], plain[..n], "{name}, {n}");
                    assert!(codes[n..].iter().all(|code| *code == [7; 4]));
                }
            }
        }
    }
}
