//! Where on the picture a box may show, and how near: bounds that hold for everything inside it.
//!
//! In front of the eye the picture of a box lies within that of its corners. Every number is widened
//! by a bound on its rounding, so that no sample that the rasterizer could cover, and no depth that
//! it could write there, lies outside. Rounding of a sum of four products, in units of the sum of
//! their sizes: Higham 2002, "Accuracy and Stability of Numerical Algorithms", 3.1.

use cullet_cull::Aabb;
use cullet_raster::{Precision, Samples, Transforms};
use cullet_transform::Viewport;
use fearless_simd::{Level, Simd, dispatch, f64x4, prelude::*};
use glam::DMat4;

/// Pixels `x[0]..x[1]`, `y[0]..y[1]` of the picture, and the nearest key in them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ScreenBox {
    pub x: [i32; 2],
    pub y: [i32; 2],
    /// No sample is nearer.
    pub nearest: i32,
}

impl ScreenBox {
    /// Everywhere and as near as can be.
    fn everywhere(viewport: Viewport, precision: Precision) -> Self {
        let nearest = precision.depth.key(1.0);
        ScreenBox { x: [0, viewport.width() as i32], y: [0, viewport.height() as i32], nearest }
    }

    /// Whether no sample can be inside.
    pub fn is_empty(&self) -> bool {
        self.x[0] >= self.x[1] || self.y[0] >= self.y[1]
    }

    /// Bounds of a finite box; everywhere where it reaches behind the eye.
    pub fn of(bounds: &Aabb, clip_from_model: &DMat4, lens: &Lens) -> Self {
        dispatch!(lens.simd, simd => ScreenBox::of_wide(simd, bounds, clip_from_model, lens))
    }

    #[inline(always)]
    fn of_wide<S: Simd>(simd: S, bounds: &Aabb, clip_from_model: &DMat4, lens: &Lens) -> Self {
        let Lens { viewport, precision, .. } = *lens;
        let ulp = lens.ulp();
        let w = Row::new(simd, clip_from_model, 3, bounds, ulp);
        let nearest_w = range(simd, w.values)[0] - w.error;
        if !(nearest_w > 0.0 && nearest_w.is_finite()) {
            return ScreenBox::everywhere(viewport, precision);
        }
        let one = f64x4::splat(simd, 1.0);
        let over_w = [one / w.values[0], one / w.values[1]];
        let [x, y, z] = [
            Row::new(simd, clip_from_model, 0, bounds, ulp),
            Row::new(simd, clip_from_model, 1, bounds, ulp),
            Row::new(simd, clip_from_model, 2, bounds, ulp),
        ];
        // What is off by no more than `error` before the division, is off by this after it.
        let error =
            |error: f64, largest: f64| (error + largest * w.error) / nearest_w + largest * ulp;
        let [left, right] = range(simd, [x.values[0] * over_w[0], x.values[1] * over_w[1]]);
        let [below, above] = range(simd, [y.values[0] * over_w[0], y.values[1] * over_w[1]]);
        let x_error = error(x.error, left.abs().max(right.abs()));
        let y_error = error(y.error, below.abs().max(above.abs()));
        let (Some(columns), Some(rows)) = (
            lens.pixels([left, right], x_error, viewport.width()),
            lens.pixels([-above, -below], y_error, viewport.height()),
        ) else {
            return ScreenBox::everywhere(viewport, precision);
        };
        // z / w over the box: both are linear, so the corners have the extremes.
        let [_, nearest] = range(simd, [z.values[0] * over_w[0], z.values[1] * over_w[1]]);
        let nearest = nearest.max(0.0);
        let nearest = nearest + error(z.error, nearest);
        let nearest = (nearest.clamp(0.0, 1.0) as f32).next_up().min(1.0);
        ScreenBox { x: columns, y: rows, nearest: precision.depth.key(nearest.into()) }
    }
}

/// What the picture of a box depends on, beside the box and where it is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lens {
    pub viewport: Viewport,
    pub samples: Samples,
    pub precision: Precision,
    pub simd: Level,
}

impl Lens {
    /// More than the relative rounding of a few operations.
    fn ulp(&self) -> f64 {
        match self.precision.transforms {
            Transforms::F64 => 16.0 * f64::EPSILON,
            Transforms::F32 => 16.0 * f64::from(f32::EPSILON),
        }
    }

    /// Pixels along an axis, `side` long, whose samples may lie between two places, -1 and 1 at the
    /// borders of the picture, each off by up to `error`. `None` where that is not finite.
    #[inline(always)]
    fn pixels(&self, [low, high]: [f64; 2], error: f64, side: u32) -> Option<[i32; 2]> {
        let reach = f64::from(self.samples.reach()) / 16.0;
        let side = f64::from(side);
        // A snap moves a corner by up to half a unit of the grid.
        let margin = 0.5 * side * (error + self.ulp()) + 1.0 / self.precision.subpixel_bits.units();
        let px = |ndc: f64| (0.5 + 0.5 * ndc) * side;
        let first = (px(low) - margin - 0.5 - reach).ceil().max(0.0);
        let last = (px(high) + margin - 0.5 + reach).floor().min(side - 1.0);
        let finite = first.is_finite() && last.is_finite();
        finite.then(|| [first.min(side) as i32, (last + 1.0).max(0.0) as i32])
    }
}

/// One clip coordinate of the eight corners.
struct Row<S: Simd> {
    values: [f64x4<S>; 2],
    /// No value, nor that of any point of the box, is farther off by rounding.
    error: f64,
}

impl<S: Simd> Row<S> {
    /// `ulp` is more than the relative rounding of a few operations.
    #[inline(always)]
    fn new(simd: S, clip_from_model: &DMat4, row: usize, bounds: &Aabb, ulp: f64) -> Self {
        let m = clip_from_model.row(row);
        let [min, max] = [bounds.min, bounds.max];
        let [x, other_x] = [m.x * min.x, m.x * max.x];
        let [y, other_y] = [m.y * min.y, m.y * max.y];
        let [z, other_z] = [m.z * min.z, m.z * max.z];
        let in_plane = f64x4::simd_from(simd, [x, other_x, x, other_x])
            + f64x4::simd_from(simd, [y, y, other_y, other_y]);
        let size = |one: f64, other: f64| one.abs().max(other.abs());
        let error = (size(x, other_x) + size(y, other_y) + size(z, other_z) + m.w.abs()) * ulp;
        Row { values: [in_plane + z + m.w, in_plane + other_z + m.w], error }
    }
}

/// The least and the greatest of eight numbers; NaN is none.
#[inline(always)]
fn range<S: Simd>(simd: S, [a, b]: [f64x4<S>; 2]) -> [f64; 2] {
    let (none, most) = (f64x4::splat(simd, f64::INFINITY), f64x4::splat(simd, f64::NEG_INFINITY));
    let low = a.simd_lt(none).select(a, none);
    let high = a.simd_gt(most).select(a, most);
    let low: [f64; 4] = b.simd_lt(low).select(b, low).into();
    let high: [f64; 4] = b.simd_gt(high).select(b, high).into();
    let (mut least, mut greatest) = (low[0], high[0]);
    for lane in 1..4 {
        least = if low[lane] < least { low[lane] } else { least };
        greatest = if high[lane] > greatest { high[lane] } else { greatest };
    }
    [least, greatest]
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet_raster::{DepthKind, SubpixelBits};
    use cullet_transform::{Camera, Projection, View};
    use glam::{DAffine3, DVec3};

    #[test]
    fn nothing_in_a_box_shows_outside_its_bounds() {
        let mut state = 7u64;
        let mut random = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 11) as f64 / (1u64 << 53) as f64 * 2.0 - 1.0
        };
        let mut vector = move || DVec3::new(random(), random(), random());
        let viewport = Viewport::new(640, 360).unwrap();
        let lenses = [
            Projection::Perspective { yfov: 1.0, near: 0.1, far: f64::INFINITY },
            Projection::Perspective { yfov: 0.01, near: 1e-3, far: 300.0 },
            Projection::Orthographic { height: 5.0, near: 0.0, far: 50.0 },
        ];
        let mut n_bounded = 0;
        for round in 0..3000 {
            let scale = [1e-3, 1.0, 30.0][round % 3];
            let eye = vector() * 5.0;
            let camera =
                Camera::look_at(eye, vector(), DVec3::new(0.1, 1.0, 0.05), lenses[round / 3 % 3]);
            let Ok(camera) = camera else { continue };
            let view = View::new(&camera, viewport);
            let offset = if round % 5 == 0 { DVec3::splat(1e7) } else { DVec3::ZERO };
            let model = DAffine3::from_translation(-offset + vector());
            let corners = [vector() * scale + offset, vector() * scale + offset];
            let corners = corners.map(|c| c.as_vec3().as_dvec3());
            let bounds = Aabb::from_points(corners);
            let clip_from_model = view.clip_from_model(&model);
            let samples = Samples::ALL[round / 9 % 4];
            let precision = Precision {
                transforms: [Transforms::F64, Transforms::F32][round / 64 % 2],
                subpixel_bits: SubpixelBits::ALL[round / 4 % 4],
                depth: DepthKind::ALL[round / 16 % 4],
            };
            let simd = [Level::new(), Level::fallback()][round % 2];
            let lens = Lens { viewport, samples, precision, simd };
            let shown = ScreenBox::of(&bounds, &clip_from_model, &lens);
            n_bounded += u32::from(shown != ScreenBox::everywhere(viewport, precision));
            for _ in 0..20 {
                let t = vector() * 0.5 + 0.5;
                let p = bounds.min + (bounds.max - bounds.min) * t;
                let p = p.as_vec3().clamp(bounds.min.as_vec3(), bounds.max.as_vec3());
                let clip = precision.transforms.clip(&clip_from_model, p);
                let in_front = clip.w > 0.0; // false for NaN
                if !in_front {
                    assert_eq!(shown, ScreenBox::everywhere(viewport, precision));
                    continue;
                }
                let (at, bits) = (
                    precision.subpixel_bits.snap(viewport, &clip),
                    precision.subpixel_bits.count(),
                );
                // A sample exactly there.
                for offset in samples.offsets() {
                    let pixel = |units: i64, axis: usize| {
                        let offset = (i64::from(offset[axis]) << bits) / 16;
                        (units - (1 << (bits - 1)) - offset).div_euclid(1 << bits)
                    };
                    let (x, y) = (pixel(at.x, 0), pixel(at.y, 1));
                    let inside = (0..640).contains(&x) && (0..360).contains(&y);
                    // The sample lies up to a pixel left of the point.
                    let near = |range: [i32; 2], v: i64| {
                        (i64::from(range[0]) - 1..=i64::from(range[1])).contains(&v)
                    };
                    assert!(!inside || (near(shown.x, x) && near(shown.y, y)), "{round}");
                }
                let depth = clip.ndc().depth.clamp(0.0, 1.0);
                assert!(precision.depth.key(depth) <= shown.nearest, "{round}");
            }
        }
        assert!(n_bounded > 500, "{n_bounded}");
    }
}
