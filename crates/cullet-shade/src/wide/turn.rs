//! Numbers of pixels, pixel by pixel, turned to pixels number by number.

use fearless_simd::Simd;

use super::column::Lanes;

/// Four numbers of each pixel of a group, one pixel after the other.
#[inline(always)]
pub(super) fn fours<S: Simd, V: Lanes<S>>(simd: S, rows: &[[f32; 4]]) -> [V; 4] {
    let numbers = rows.as_flattened();
    let len = V::LEN;
    [
        V::from_slice(simd, &numbers[..len]),
        V::from_slice(simd, &numbers[len..2 * len]),
        V::from_slice(simd, &numbers[2 * len..3 * len]),
        V::from_slice(simd, &numbers[3 * len..4 * len]),
    ]
}

/// From four numbers of each pixel, one pixel after the other, to all pixels of each number.
#[inline(always)]
pub(super) fn turned4<S: Simd, V: Lanes<S>>([a, b, c, d]: &[V; 4]) -> [V; 4] {
    let (ab_even, ab_odd) = a.deinterleave(*b);
    let (cd_even, cd_odd) = c.deinterleave(*d);
    let (x, z) = ab_even.deinterleave(cd_even);
    let (y, w) = ab_odd.deinterleave(cd_odd);
    [x, y, z, w]
}

/// From eight numbers of each pixel, one pixel after the other, to all pixels of each number.
#[inline(always)]
pub(super) fn turned<S: Simd, V: Lanes<S>>([a, b, c, d, e, f, g, h]: &[V; 8]) -> [V; 8] {
    // Numbers 0, 2, 4, 6 and 1, 3, 5, 7 of four pixels each.
    let (ab_even, ab_odd) = a.deinterleave(*b);
    let (cd_even, cd_odd) = c.deinterleave(*d);
    let (ef_even, ef_odd) = e.deinterleave(*f);
    let (gh_even, gh_odd) = g.deinterleave(*h);
    let [n0, n2, n4, n6] = turned4::<S, V>(&[ab_even, cd_even, ef_even, gh_even]);
    let [n1, n3, n5, n7] = turned4::<S, V>(&[ab_odd, cd_odd, ef_odd, gh_odd]);
    [n0, n1, n2, n3, n4, n5, n6, n7]
}
