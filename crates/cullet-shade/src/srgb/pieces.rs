//! The exact encoder of [`super`] for vectors of 512 bits, which hold tables of their own.
//!
//! A quarter of an octave at a time, the curve is a cubic within [`DOUBT`] of a code. Its coefficients
//! are looked up in registers. Where a value is that close to the border of two codes, its group takes the table:
//! one group of sixteen in sixty does. So the codes are those of the table for every float.

use std::arch::x86_64::*;

use fearless_simd::{f32x16, kernel, prelude::*, u32x16};

use super::{Encoder, SMALLEST, encode_exact};
use crate::encoding::LINEAR_END;

/// How far a cubic may be from the curve, codes. They are off by 3.9e-4 at most.
const DOUBT: f32 = 5e-4;

/// Pieces, from 2^-8 to 1.
const PIECES: usize = 32;
/// What is left of a float's bits to tell pieces apart.
const PIECE_SHIFT: u32 = 21;
/// The bits of 2^-8. The piece that begins here serves what lies before it as well.
const FIRST: u32 = (127 - 8) << 23;
/// The middle of a piece from its first float.
const MIDDLE: u32 = 1 << (PIECE_SHIFT - 1);

/// Of the line, codes.
const SLOPE: f32 = 12.92 * 255.0;

/// Coefficients of all pieces, by the power of the way from the middle of the piece.
#[derive(Debug)]
pub(super) struct Pieces([[f32; PIECES]; 4]);

impl Pieces {
    pub fn new() -> Self {
        let mut pieces = Pieces([[0.0; PIECES]; 4]);
        for piece in 0..PIECES as u32 {
            let first = FIRST + (piece << PIECE_SHIFT);
            let middle = f64::from(f32::from_bits(first + MIDDLE));
            let begin = if piece == 0 { LINEAR_END } else { f32::from_bits(first) };
            let end = f32::from_bits(first + (1 << PIECE_SHIFT));
            let coefficients = cubic([begin, end].map(|x| f64::from(x) - middle), |way| {
                255.0 * encode_exact(middle + way)
            });
            for (power, coefficient) in coefficients.into_iter().enumerate() {
                pieces.0[power][(first >> PIECE_SHIFT) as usize % PIECES] = coefficient as f32;
            }
        }
        pieces
    }
}

/// The cubic that meets `of` where the fourth Chebyshev polynomial of an interval is zero, which makes the
/// largest error nearly the least possible: its coefficients by power.
fn cubic([begin, end]: [f64; 2], of: impl Fn(f64) -> f64) -> [f64; 4] {
    let nodes: [f64; 4] = std::array::from_fn(|i| {
        let cosine = libm::cos((2 * i + 1) as f64 * std::f64::consts::PI / 8.0);
        0.5 * (begin + end) + 0.5 * (end - begin) * cosine
    });
    // Newton's divided differences.
    let mut differences = nodes.map(of);
    for order in 1..4 {
        for i in (order..4).rev() {
            let way = nodes[i] - nodes[i - order];
            differences[i] = (differences[i] - differences[i - 1]) / way;
        }
    }
    // Multiplied out from the innermost bracket.
    let mut by_power = [differences[3], 0.0, 0.0, 0.0];
    for i in (0..3).rev() {
        let before = by_power;
        by_power[0] = differences[i] - nodes[i] * before[0];
        for power in 1..4 {
            by_power[power] = before[power - 1] - nodes[i] * before[power];
        }
    }
    by_power
}

kernel!(
    /// [`Encoder::encode_all`], sixteen values at a time.
    #[inline]
    pub(super) fn encode(token: Avx512, pieces: &Pieces, encoder: &Encoder, values: &mut [u32]) {
        let [constant, first, second, third] = &pieces.0;
        let both = |of: &[f32; PIECES]| -> [__m512; 2] {
            let [low, high] = of.as_chunks::<16>().0 else { unreachable!("two of sixteen") };
            [f32x16::simd_from(token, *low).into(), f32x16::simd_from(token, *high).into()]
        };
        let [constant, first, second, third] =
            [both(constant), both(first), both(second), both(third)];
        let (smallest, largest) = (_mm512_set1_ps(SMALLEST), _mm512_set1_ps(1.0_f32.next_down()));
        let mut at = 0;
        while at + 16 <= values.len() {
            let group = &mut values[at..at + 16];
            let linear = _mm512_castsi512_ps(u32x16::from_slice(token, group).into());
            // Of what is not a number the second is taken.
            let x = _mm512_min_ps(_mm512_max_ps(linear, smallest), largest);
            let bits = _mm512_max_epu32(_mm512_castps_si512(x), _mm512_set1_epi32(FIRST as i32));
            let piece = _mm512_srli_epi32::<PIECE_SHIFT>(bits); // the lowest five bits count
            let middle = _mm512_or_si512(
                _mm512_slli_epi32::<PIECE_SHIFT>(piece),
                _mm512_set1_epi32(MIDDLE as i32),
            );
            let way = _mm512_sub_ps(x, _mm512_castsi512_ps(middle));
            let code = _mm512_permutex2var_ps(third[0], piece, third[1]);
            let next = _mm512_permutex2var_ps(second[0], piece, second[1]);
            let code = _mm512_fmadd_ps(code, way, next);
            let next = _mm512_permutex2var_ps(first[0], piece, first[1]);
            let code = _mm512_fmadd_ps(code, way, next);
            let next = _mm512_permutex2var_ps(constant[0], piece, constant[1]);
            let code = _mm512_fmadd_ps(code, way, next);
            let is_line = _mm512_cmp_ps_mask::<_CMP_LE_OQ>(x, _mm512_set1_ps(LINEAR_END));
            let code = _mm512_mask_mul_ps(code, is_line, x, _mm512_set1_ps(SLOPE));
            const NEAREST: i32 = _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC;
            let whole = _mm512_cvt_roundps_epi32::<NEAREST>(code);
            let off = _mm512_abs_ps(_mm512_sub_ps(code, _mm512_cvtepi32_ps(whole)));
            let doubtful = _mm512_cmp_ps_mask::<_CMP_GT_OQ>(off, _mm512_set1_ps(0.5 - DOUBT));
            let whole: u32x16<_> = whole.simd_into(token);
            whole.store_slice(group);
            if doubtful != 0 {
                let bits: u32x16<_> = _mm512_castps_si512(x).simd_into(token);
                let bits = bits.as_slice();
                let mut left = u32::from(doubtful);
                while left != 0 {
                    let lane = left.trailing_zeros() as usize % 16;
                    left &= left - 1;
                    group[lane] = encoder.code(bits[lane]);
                }
            }
            at += 16;
        }
    }
);

#[cfg(test)]
mod tests {
    use super::*;

    /// [`encode`] without rounding, in f64 but for the coefficients.
    fn code(pieces: &Pieces, x: f32) -> f64 {
        if x <= LINEAR_END {
            return f64::from(x) * f64::from(SLOPE);
        }
        let bits = x.to_bits().max(FIRST);
        let piece = (bits >> PIECE_SHIFT) as usize % PIECES;
        let middle = f32::from_bits(bits >> PIECE_SHIFT << PIECE_SHIFT | MIDDLE);
        let way = f64::from(x - middle);
        pieces.0.iter().rev().fold(0.0, |sum, by_power| sum * way + f64::from(by_power[piece]))
    }

    #[test]
    fn pieces_are_within_their_stated_error() {
        // Roundings of f32 besides: three sums and products of up to 256, each half of 2^-16.
        let rounded = 4.0 * 0.5_f64.powi(17);
        let pieces = Pieces::new();
        let mut worst: f64 = 0.0;
        for bits in (SMALLEST.to_bits()..1.0_f32.to_bits()).step_by(61) {
            let x = f32::from_bits(bits);
            let off = (code(&pieces, x) - 255.0 * encode_exact(f64::from(x))).abs();
            assert!(off + rounded < f64::from(DOUBT), "{x:e}: {off:e}");
            worst = worst.max(off);
        }
        assert!((3.8e-4..4.0e-4).contains(&worst), "{worst:e}");
    }
}
