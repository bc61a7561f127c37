//! Data that a tile has by itself, without asking any triangle: distances from depth keys, numbers
//! from ids.

use cullet_raster::{NO_TRIANGLE, Precision, TileBuffer, prefetch};
use cullet_transform::{Kind, View};
use fearless_simd::{Level, Simd, dispatch, prelude::*};

use crate::frame::{ROWS_AHEAD, Target};
use crate::{Pass, Passes, Prepared, Region};

/// Distance along the view axis from reversed depth in perspective: `shift / (depth + scale)`,
/// the inverse of [`Window::clip_from_view`](cullet_transform::Window::clip_from_view).
///
/// Within 3e-7 of the distance: the depth is rounded to f32 once, and so are the sum, the quotient
/// and both constants.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Distance {
    scale: f32,
    shift: f32,
}

impl Distance {
    /// `None` where depth in f32 does not tell: parallel views, whose depth has the same step
    /// everywhere, and near distances that f32 cannot hold; and every precision but the
    /// default.
    pub fn new(view: &View, precision: Precision) -> Option<Self> {
        let clip_from_view = view.clip_from_view();
        let (scale, shift) = (clip_from_view.z_axis.z, clip_from_view.w_axis.z);
        let is_safe = precision == Precision::default()
            && view.window().kind == Kind::Perspective
            && (1e-30..1e30).contains(&shift);
        is_safe.then_some(Distance { scale: scale as f32, shift: shift as f32 })
    }

    /// Of one key.
    #[cfg(test)]
    fn of(self, key: i32) -> f32 {
        self.shift / (f32::from_bits(key as u32) + self.scale)
    }

    /// Of rows, infinite where there is no triangle. Returns how many show one.
    #[inline(always)]
    fn of_rows<S: Simd>(self, simd: S, rows: &Rows<'_>, out: &mut [f32], out_stride: usize) -> u64 {
        let Rows { keys, ids, stride, width, height } = *rows;
        let n = S::f32s::LEN;
        let mut shown = S::i32s::splat(simd, 0);
        let mut n_shown = 0;
        for row in 0..height {
            let (keys, ids) = (&keys[row * stride..], &ids[row * stride..]);
            let mut ahead = 0;
            while ahead < width {
                prefetch(out, (row + ROWS_AHEAD) * out_stride + ahead);
                ahead += 16;
            }
            let out = &mut out[row * out_stride..][..width];
            // By index: iterators side by side are a call each, and slow, in code for wide registers.
            let mut i = 0;
            while i + n <= width {
                let (distance, is_there) = self.of_vector(simd, keys, ids, i);
                distance.store_slice(&mut out[i..i + n]);
                shown -= is_there.to_vector();
                i += n;
            }
            if i < width {
                let (distance, is_there) = self.of_vector(simd, keys, ids, i);
                out[i..].copy_from_slice(&distance.as_slice()[..width - i]);
                let rest = is_there.to_bitmask() & ((1 << (width - i)) - 1);
                n_shown += u64::from(rest.count_ones());
            }
        }
        n_shown + shown.reduce_sum() as u64
    }

    /// Of as many as a register holds from the `first` on, and which show a triangle.
    #[inline(always)]
    fn of_vector<S: Simd>(
        self,
        simd: S,
        keys: &[i32],
        ids: &[u32],
        first: usize,
    ) -> (S::f32s, S::mask32s) {
        let n = S::f32s::LEN;
        let key = S::i32s::from_slice(simd, &keys[first..first + n]);
        let id = S::u32s::from_slice(simd, &ids[first..first + n]);
        let depth: S::f32s = key.bitcast();
        let distance = S::f32s::splat(simd, self.shift) / (depth + self.scale);
        let is_there = !id.simd_eq(S::u32s::splat(simd, NO_TRIANGLE));
        (is_there.select(distance, S::f32s::splat(simd, f32::INFINITY)), is_there)
    }
}

/// A rectangle of a tile: rows of `width`, `stride` values from each to the next, and at least sixteen that
/// mean nothing after the last.
struct Rows<'r> {
    keys: &'r [i32],
    ids: &'r [u32],
    stride: usize,
    width: usize,
    height: usize,
}

impl Rows<'_> {
    /// How many pixels show something.
    fn n_shown(&self) -> u64 {
        let rows = self.ids.chunks(self.stride).take(self.height);
        rows.flat_map(|ids| &ids[..self.width]).filter(|id| **id != NO_TRIANGLE).count() as u64
    }
}

/// Fills those of `passes` that need nothing but `tile`, whose pixel `place` is the upper left one of
/// `rect`. Returns which it has filled, and how many pixels show something.
#[expect(clippy::too_many_arguments, reason = "what it reads and what it writes")]
pub(crate) fn fill_data(
    level: Level,
    prepared: &Prepared,
    distance: Option<Distance>,
    rect: Region,
    tile: &TileBuffer,
    place: [u32; 2],
    passes: Passes,
    out: &mut Target<'_>,
) -> (Passes, u64) {
    let (width, height) = (rect.width as usize, rect.height as usize);
    let (ids, stride) = tile.ids_from(place);
    let keys = tile.keys_from(place);
    let distance = distance.filter(|_| passes.contains(Pass::Depth));
    let (with_id, with_triangle) = (passes.contains(Pass::Id), passes.contains(Pass::Triangle));
    let rows = Rows { keys, ids, stride, width, height };
    let n_shown = match distance {
        Some(distance) => {
            dispatch!(level, simd => distance.of_rows(simd, &rows, out.depth, out.stride))
        }
        None => rows.n_shown(),
    };
    for row in 0..height {
        let ids = &ids[row * stride..][..width];
        let to = row * out.stride..row * out.stride + width;
        if with_triangle {
            for (out, id) in out.triangle[to.clone()].iter_mut().zip(ids) {
                *out = id.wrapping_add(1); // the number of none is the greatest
            }
        }
        if with_id {
            let mut left = &mut out.id[to];
            for run in ids.chunk_by(|a, b| a == b) {
                let (out, rest) = left.split_at_mut(run.len());
                left = rest;
                let is_there = run[0] != NO_TRIANGLE;
                out.fill(if is_there { prepared.item_of(run[0]) as u32 + 1 } else { 0 });
            }
        }
    }
    let mut filled = Passes::NONE.with(Pass::Id).with(Pass::Triangle);
    if distance.is_some() {
        filled = filled.with(Pass::Depth);
    }
    (filled, n_shown)
}

#[cfg(test)]
mod tests {
    use cullet_transform::{Camera, Projection, Viewport};
    use glam::DVec3;

    use super::*;

    #[test]
    fn distances_come_back_from_depths() {
        let viewport = Viewport::new(4, 4).unwrap();
        for (near, far) in [(0.1, f64::INFINITY), (0.1, 100.0), (1e-6, 1e9), (5.0, 5.1)] {
            let lens = Projection::Perspective { yfov: 1.0, near, far };
            let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, lens).unwrap();
            let view = View::new(&camera, viewport);
            let distance = Distance::new(&view, Precision::default()).unwrap();
            for i in 0..=1000 {
                let exact = near * (far.min(near * 1e15) / near).powf(f64::from(i) / 1000.0);
                let clip = *view.clip_from_view() * DVec3::new(0.0, 0.0, -exact).extend(1.0);
                let key = ((clip.z / clip.w) as f32 + 0.0).to_bits() as i32;
                let error = f64::from(distance.of(key)) / exact - 1.0;
                assert!(error.abs() < 3e-7, "{error:e} at {exact} of {near}..{far}");
            }
        }
    }

    #[test]
    fn rows_of_every_width_are_those_of_single_keys() {
        let distance = Distance { scale: 0.1, shift: 0.3 };
        let stride = 40;
        let keys: Vec<i32> =
            (0..4 * stride as i32).map(|i| (1.0 / (i + 1) as f32).to_bits() as i32).collect();
        let ids: Vec<u32> = (0..4 * stride as u32)
            .map(|i| if i % 3 == 1 || i % 7 == 2 { NO_TRIANGLE } else { i })
            .collect();
        let levels = cullet_cull::wide::levels().into_iter();
        for ((name, level), width) in levels.flat_map(|level| (1..=24).map(move |n| (level, n))) {
            let rows = Rows { keys: &keys, ids: &ids, stride, width, height: 3 };
            let mut out = vec![-1.0; 3 * 30];
            let shown = dispatch!(level, simd => distance.of_rows(simd, &rows, &mut out, 30));
            let mut n = 0;
            for (row, column) in (0..3).flat_map(|row| (0..30).map(move |column| (row, column))) {
                let at = row * stride + column;
                let want = match column < width {
                    true if ids[at] == NO_TRIANGLE => f32::INFINITY,
                    true => distance.of(keys[at]),
                    false => -1.0,
                };
                n += u64::from((0.0..f32::INFINITY).contains(&want));
                assert_eq!(out[row * 30 + column], want, "{name} {width} {row} {column}");
            }
            assert_eq!((shown, rows.n_shown()), (n, n), "{name} {width}");
        }
    }

    #[test]
    fn parallel_views_and_lenses_beyond_f32_have_none() {
        let viewport = Viewport::new(4, 4).unwrap();
        let lenses = [
            Projection::Orthographic { height: 2.0, near: 0.0, far: 10.0 },
            Projection::Perspective { yfov: 1.0, near: 1e-40, far: f64::INFINITY },
        ];
        for lens in lenses {
            let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, lens).unwrap();
            assert!(Distance::new(&View::new(&camera, viewport), Precision::default()).is_none());
        }
    }
}
