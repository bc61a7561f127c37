//! Where on its triangle a pixel lies: perspective-correct barycentrics and their derivatives.
//!
//! Made anew for shading from the same clip-space corners that [`crate::set_up`] had, so nothing
//! per triangle is stored in between (Burns & Hunt 2013, "The Visibility Buffer"). Weights are
//! linear over `w`: `weight_i = (share_i / w_i) / sum(share_j / w_j)` with `share` the screen
//! barycentrics (Heckbert & Moreton 1991, "Interpolation for Polygon Texture Mapping").

use cullet_transform::{ClipPoint, PlaneMask, Viewport};
use fearless_simd::{Level, Simd, f32x8, f64x8, prelude::*};
use glam::DVec3;

use crate::clip::GuardBand;
use crate::fixed::{Fixed, snap};
use crate::fragment::Fragment;
use crate::level::dispatch_wide;
use crate::setup::doubled_area;

/// Interpolation over one source triangle.
#[derive(Clone, Copy, Debug)]
pub struct Interpolator {
    /// `share_i / w_i` at a point of the screen: `at_origin + x * ddx + y * ddy`, with x and y in
    /// pixels from `origin`; up to a factor common to the three.
    pub(crate) at_origin: DVec3,
    pub(crate) ddx: DVec3,
    pub(crate) ddy: DVec3,
    pub(crate) origin: [f64; 2],
    clockwise: bool,
}

impl Interpolator {
    /// For a triangle that [`crate::set_up`] drew, with the same viewport, corners, planes and
    /// `BITS`. Triangles that were not clipped are interpolated between their snapped corners;
    /// clipped ones between their true ones, without a divide by `w` (Olano & Greer 1997,
    /// "Triangle Scan Conversion using 2D Homogeneous Coordinates").
    pub fn new<const BITS: u32>(
        viewport: Viewport,
        corners: &[ClipPoint; 3],
        planes: PlaneMask,
    ) -> Self {
        let guard = GuardBand::new(viewport, BITS);
        let clipped = corners.iter().any(|p| !guard.cuts(p, planes).is_empty());
        if clipped {
            Interpolator::homogeneous(viewport, corners)
        } else {
            Interpolator::snapped::<BITS>(viewport, corners)
        }
    }

    fn snapped<const BITS: u32>(viewport: Viewport, corners: &[ClipPoint; 3]) -> Self {
        let units = f64::from(1u32 << BITS);
        let at = corners.map(|p| snap::<BITS>(viewport, &p));
        let area = doubled_area(at);
        let per_pixel = units / area as f64;
        let (mut ddx, mut ddy) = ([0.0; 3], [0.0; 3]);
        for i in 0..3 {
            let (from, to) = (at[(i + 1) % 3], at[(i + 2) % 3]);
            let over_w = per_pixel / corners[i].w;
            ddx[i] = (from.y - to.y) as f64 * over_w;
            ddy[i] = (to.x - from.x) as f64 * over_w;
        }
        // At corner 0 its own share is 1 and the others' are 0: exact, and near the triangle.
        let Fixed { x, y } = at[0];
        Interpolator {
            at_origin: DVec3::new(1.0 / corners[0].w, 0.0, 0.0),
            ddx: DVec3::from_array(ddx),
            ddy: DVec3::from_array(ddy),
            origin: [x as f64 / units, y as f64 / units],
            clockwise: area > 0,
        }
    }

    /// The screen point `(x, y, 1)` is a combination of the corners' `(X, Y, w)`; its
    /// coefficients, by Cramer's rule, are the wanted shares over w.
    pub(crate) fn homogeneous(viewport: Viewport, corners: &[ClipPoint; 3]) -> Self {
        let (width, height) = (f64::from(viewport.width()), f64::from(viewport.height()));
        // Pixels from the middle of the picture, times w.
        let [a, b, c] = corners.map(|p| DVec3::new(0.5 * width * p.x, -0.5 * height * p.y, p.w));
        let rows = [b.cross(c), c.cross(a), a.cross(b)];
        let determinant = a.dot(rows[0]);
        let scale = rows.iter().fold(0.0_f64, |m, r| m.max(r.abs().max_element()));
        let sign = if determinant < 0.0 { -1.0 } else { 1.0 };
        let factor = if scale > 0.0 && scale.is_finite() { sign / scale } else { sign };
        let [r0, r1, r2] = rows.map(|row| row * factor);
        Interpolator {
            at_origin: DVec3::new(r0.z, r1.z, r2.z),
            ddx: DVec3::new(r0.x, r1.x, r2.x),
            ddy: DVec3::new(r0.y, r1.y, r2.y),
            origin: [0.5 * width, 0.5 * height],
            clockwise: determinant > 0.0,
        }
    }

    /// Whether the corners run clockwise as seen on the screen.
    pub fn is_clockwise(&self) -> bool {
        self.clockwise
    }

    /// The weights at the centre of pixel `(x, y)` of the picture. Weights are clamped to
    /// `0..=1`, since the centre of a covered pixel may lie a rounding step outside; what is not
    /// a number becomes 0.
    pub fn fragment(&self, x: u32, y: u32) -> Fragment {
        self.fragment_at([f64::from(x) + 0.5, f64::from(y) + 0.5])
    }

    /// A number with these values at the corners, at the centres of pixels in a row from `(x, y)` on:
    /// the weights of [`Interpolator::fragment`] times the values, with one division each. The same on
    /// every instruction set.
    pub fn fill_row(&self, level: Level, values: DVec3, [x, y]: [u32; 2], out: &mut [f32]) {
        let dy = f64::from(y) + 0.5 - self.origin[1];
        let row = Row { shares: self.at_origin + self.ddy * dy, values, x };
        if level.is_fallback() {
            self.fill_plain(&row, out);
        } else {
            dispatch_wide!(level, simd => self.fill_wide(simd, &row, out));
        }
    }

    fn fill_plain(&self, row: &Row, out: &mut [f32]) {
        let Row { shares, values, x } = *row;
        for (column, out) in (x..).zip(out) {
            // From the column itself, so that no pixel depends on where its row begins.
            let dx = f64::from(column) + 0.5 - self.origin[0];
            let share = (shares + self.ddx * dx).map(at_least_zero);
            let value = share.dot(values) / (share.x + share.y + share.z);
            let value = if value.is_finite() { value } else { values.element_sum() / 3.0 };
            *out = value as f32;
        }
    }

    #[inline(always)]
    fn fill_wide<S: Simd>(&self, simd: S, row: &Row, out: &mut [f32]) {
        let columns = f64x8::simd_from(simd, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        let mut i = 0;
        while i < out.len() {
            // Columns are whole numbers: their sum is exact.
            let dx = columns + (f64::from(row.x) + i as f64 + 0.5) - self.origin[0];
            let value = self.eight(simd, row, dx);
            if i + 8 <= out.len() {
                value.store_slice(&mut out[i..i + 8]);
            } else {
                let rest = out.len() - i;
                out[i..].copy_from_slice(&value.as_slice()[..rest]);
            }
            i += 8;
        }
    }

    #[inline(always)]
    fn eight<S: Simd>(&self, simd: S, Row { shares, values, .. }: &Row, dx: f64x8<S>) -> f32x8<S> {
        let zero = f64x8::splat(simd, 0.0);
        let a = dx * self.ddx.x + shares.x;
        let b = dx * self.ddx.y + shares.y;
        let c = dx * self.ddx.z + shares.z;
        let a = a.simd_lt(zero).select(zero, a);
        let b = b.simd_lt(zero).select(zero, b);
        let c = c.simd_lt(zero).select(zero, c);
        let value = (a * values.x + b * values.y + c * values.z) / (a + b + c);
        let is_finite = value.abs().simd_lt(f64x8::splat(simd, f64::INFINITY));
        let value = is_finite.select(value, f64x8::splat(simd, values.element_sum() / 3.0));
        let (low, high) = value.split();
        low.narrow(high)
    }

    /// [`Interpolator::fragment`] at any place of the picture, in pixels from its corner.
    pub fn fragment_at(&self, [x, y]: [f64; 2]) -> Fragment {
        let (dx, dy) = (x - self.origin[0], y - self.origin[1]);
        let share = (self.at_origin + self.ddx * dx + self.ddy * dy).map(at_least_zero);
        let sum = share.x + share.y + share.z;
        let weights = share / sum;
        // Quotient rule: (s / S)' = (s' - (s / S) S') / S.
        let slope = |d: DVec3| (d - weights * (d.x + d.y + d.z)) / sum;
        Fragment {
            weights: finite(weights),
            ddx: slope(self.ddx).as_vec3(),
            ddy: slope(self.ddy).as_vec3(),
        }
    }
}

/// A row of pixels on a triangle.
struct Row {
    /// Shares over w at the origin's column.
    shares: DVec3,
    /// What to interpolate, at the corners.
    values: DVec3,
    /// First column.
    x: u32,
}

/// Compare and select, NaN stays: the same on every machine.
fn at_least_zero(share: f64) -> f64 {
    if share < 0.0 { 0.0 } else { share }
}

/// The weights; a third each if the triangle has no extent at all here.
fn finite(weights: DVec3) -> DVec3 {
    if weights.is_finite() { weights } else { DVec3::splat(1.0 / 3.0) }
}

#[cfg(test)]
mod tests {
    use fearless_simd::Fallback;

    use super::*;
    use crate::testing::levels;

    fn viewport() -> Viewport {
        Viewport::new(64, 48).unwrap()
    }

    const CORNERS: [ClipPoint; 3] = [
        ClipPoint { x: -0.8, y: -0.7, z: 0.1, w: 1.0 },
        ClipPoint { x: 2.5, y: -2.0, z: 0.1, w: 3.0 },
        ClipPoint { x: 0.3, y: 1.6, z: 0.1, w: 2.0 },
    ];

    #[test]
    fn both_ways_agree_where_both_apply() {
        let snapped = Interpolator::snapped::<16>(viewport(), &CORNERS);
        let homogeneous = Interpolator::homogeneous(viewport(), &CORNERS);
        for (x, y) in [(20, 20), (30, 25), (36, 30), (33, 12)] {
            let (a, b) = (snapped.fragment(x, y), homogeneous.fragment(x, y));
            assert!((a.weights - b.weights).abs().max_element() < 1e-5, "{a:?} {b:?}");
            assert!((a.ddx - b.ddx).abs().max_element() < 1e-5, "{a:?} {b:?}");
            assert!((a.ddy - b.ddy).abs().max_element() < 1e-5, "{a:?} {b:?}");
        }
        assert_eq!(snapped.is_clockwise(), homogeneous.is_clockwise());
    }

    #[test]
    fn rows_are_their_fragments_on_every_instruction_set() {
        let values = DVec3::new(1.0, -3.0, 2.5);
        let nowhere = Interpolator {
            at_origin: DVec3::ZERO,
            ddx: DVec3::ZERO,
            ddy: DVec3::ZERO,
            ..Interpolator::snapped::<16>(viewport(), &CORNERS)
        };
        for (level, interpolator) in levels().into_iter().flat_map(|level| {
            let snapped = Interpolator::snapped::<16>(viewport(), &CORNERS);
            let homogeneous = Interpolator::homogeneous(viewport(), &CORNERS);
            [snapped, homogeneous, nowhere].map(|interpolator| (level, interpolator))
        }) {
            let mut row = [0.0; 64];
            interpolator.fill_row(level, values, [0, 25], &mut row);
            if interpolator.ddy == DVec3::ZERO {
                assert_eq!(row, [(values.element_sum() / 3.0) as f32; 64], "{level:?}");
            }
            let mut plain = [0.0; 64];
            interpolator.fill_row(Level::Fallback(Fallback::new()), values, [0, 25], &mut plain);
            assert_eq!(row, plain, "{level:?}");
            for (start, len) in (0..9).flat_map(|start| (0..20).map(move |len| (start, len))) {
                let mut part = vec![0.0; len];
                interpolator.fill_row(level, values, [start, 25], &mut part);
                assert_eq!(part, row[start as usize..][..len], "{level:?} {start} {len}");
            }
            for (x, value) in (0..).zip(row) {
                let plain = interpolator.fragment(x, 25).weights.dot(values);
                assert!((f64::from(value) - plain).abs() < 1e-6, "{x}: {value} {plain}");
            }
        }
    }

    #[test]
    fn weights_rebuild_the_position() {
        let interpolator = Interpolator::snapped::<16>(viewport(), &CORNERS);
        let f = interpolator.fragment(30, 25);
        let sum = |get: fn(&ClipPoint) -> f64| {
            let [a, b, c] = f.weights.to_array();
            a * get(&CORNERS[0]) + b * get(&CORNERS[1]) + c * get(&CORNERS[2])
        };
        let p = ClipPoint { x: sum(|p| p.x), y: sum(|p| p.y), z: 0.0, w: sum(|p| p.w) };
        let screen = viewport().screen_from_ndc(p.ndc());
        assert!((screen.x - 30.5).abs() < 1e-3 && (screen.y - 25.5).abs() < 1e-3, "{screen:?}");
    }

    #[test]
    fn derivatives_are_differences() {
        let interpolator = Interpolator::snapped::<8>(viewport(), &CORNERS);
        let (f, right, down) = (
            interpolator.fragment(30, 25),
            interpolator.fragment(31, 25),
            interpolator.fragment(30, 26),
        );
        assert!((right.weights - f.weights - f.ddx.as_dvec3()).abs().max_element() < 2e-3);
        assert!((down.weights - f.weights - f.ddy.as_dvec3()).abs().max_element() < 2e-3);
        assert!((f.weights.element_sum() - 1.0).abs() < 1e-6);
    }
}
