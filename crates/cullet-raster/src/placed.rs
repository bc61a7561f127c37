//! Vertices on the screen, eight at a time: [`Placer::place`](crate::Placer::place), wide.
//!
//! Clip space, outcodes, divide and snap of all vertices of a cluster, one array per answer. Every
//! operation is that of the plain code, in its order, in f64, so the bits are the same on every
//! instruction set.

use cullet_transform::{PlaneMask, Viewport};
use fearless_simd::{Simd, f32x8, f64x4, i32x8, i64x4, prelude::*};
use glam::{DMat4, Mat4};

use crate::clip::GuardBand;
use crate::fixed::{SNAP_SHIFT, guard_band};

/// Most vertices of a cluster.
pub const MAX_VERTICES: usize = 256;

/// The vertices of one cluster.
#[derive(Clone, Debug)]
pub(crate) struct Placed {
    /// Snapped; meaningless where `cuts` is not 0.
    pub x: [i32; MAX_VERTICES],
    pub y: [i32; MAX_VERTICES],
    /// Reversed depth, in `0..=1`; likewise.
    pub depth: [f64; MAX_VERTICES],
    /// Bits of the planes a vertex lies outside of.
    pub outside: [u8; MAX_VERTICES],
    /// Bits of the planes that cut its triangles; all where it is not finite.
    pub cuts: [u8; MAX_VERTICES],
    /// Whether any of `outside` or `cuts` is not 0.
    pub special: bool,
}

impl Default for Placed {
    fn default() -> Self {
        Placed {
            x: [0; MAX_VERTICES],
            y: [0; MAX_VERTICES],
            depth: [0.0; MAX_VERTICES],
            outside: [0; MAX_VERTICES],
            cuts: [0; MAX_VERTICES],
            special: false,
        }
    }
}

/// What all vertices of an object share.
pub(crate) struct Lens {
    pub clip_from_model: DMat4,
    pub viewport: Viewport,
    pub planes: PlaneMask,
    pub guard: GuardBand,
}

/// Four points of clip space.
struct Clip4<S: Simd> {
    x: f64x4<S>,
    y: f64x4<S>,
    z: f64x4<S>,
    w: f64x4<S>,
}

impl Placed {
    /// Places vertices whose coordinates come in whole groups of eight, at most [`MAX_VERTICES`].
    #[inline(always)]
    pub fn place<S: Simd, const BITS: u32>(
        &mut self,
        simd: S,
        lens: &Lens,
        [x, y, z]: [&[f32]; 3],
    ) {
        self.special = false;
        for start in (0..x.len().min(MAX_VERTICES)).step_by(8) {
            let (x_low, x_high) = f32x8::from_slice(simd, &x[start..start + 8]).widen();
            let (y_low, y_high) = f32x8::from_slice(simd, &y[start..start + 8]).widen();
            let (z_low, z_high) = f32x8::from_slice(simd, &z[start..start + 8]).widen();
            let low = clip(&lens.clip_from_model, x_low, y_low, z_low);
            let high = clip(&lens.clip_from_model, x_high, y_high, z_high);
            self.classify(simd, lens, &low, start);
            self.classify(simd, lens, &high, start + 4);
            let (x_low, y_low, depth_low) = screen::<S, BITS>(simd, lens.viewport, &low);
            let (x_high, y_high, depth_high) = screen::<S, BITS>(simd, lens.viewport, &high);
            x_low.narrow(x_high).store_slice(&mut self.x[start..start + 8]);
            y_low.narrow(y_high).store_slice(&mut self.y[start..start + 8]);
            depth_low.store_slice(&mut self.depth[start..start + 4]);
            depth_high.store_slice(&mut self.depth[start + 4..start + 8]);
        }
    }

    /// [`Placed::place`] in f32: twin of [`Transforms::F32`](crate::Transforms::F32).
    #[inline(always)]
    pub fn place_single<S: Simd, const BITS: u32>(
        &mut self,
        simd: S,
        lens: &Lens,
        [x, y, z]: [&[f32]; 3],
    ) {
        let m = lens.clip_from_model.as_mat4();
        self.special = false;
        for start in (0..x.len().min(MAX_VERTICES)).step_by(8) {
            let x = f32x8::from_slice(simd, &x[start..start + 8]);
            let y = f32x8::from_slice(simd, &y[start..start + 8]);
            let z = f32x8::from_slice(simd, &z[start..start + 8]);
            let p = clip_single(&m, x, y, z);
            let gone = p.x * 0.0 + p.y * 0.0 + p.z * 0.0 + p.w * 0.0; // NaN unless all are finite
            let finite = gone.simd_eq(f32x8::splat(simd, 0.0));
            if lens.planes.is_empty() && finite.all_true() {
                self.outside[start..start + 8].fill(0);
                self.cuts[start..start + 8].fill(0);
            } else {
                let ((x0, x1), (y0, y1)) = (p.x.widen(), p.y.widen());
                let ((z0, z1), (w0, w1)) = (p.z.widen(), p.w.widen());
                self.classify(simd, lens, &Clip4 { x: x0, y: y0, z: z0, w: w0 }, start);
                self.classify(simd, lens, &Clip4 { x: x1, y: y1, z: z1, w: w1 }, start + 4);
            }
            let half = f32x8::splat(simd, 0.5);
            let (width, height) = (lens.viewport.width(), lens.viewport.height());
            let x = (half + p.x / p.w * 0.5) * width as f32;
            let y = (half - p.y / p.w * 0.5) * height as f32;
            let depth = p.z / p.w;
            let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
            let depth = depth.simd_lt(zero).select(zero, depth);
            let depth = depth.simd_gt(one).select(one, depth);
            let (depth_low, depth_high) = depth.widen();
            let x = snap_single::<S, BITS>(simd, x, width);
            let y = snap_single::<S, BITS>(simd, y, height);
            x.store_slice(&mut self.x[start..start + 8]);
            y.store_slice(&mut self.y[start..start + 8]);
            depth_low.store_slice(&mut self.depth[start..start + 4]);
            depth_high.store_slice(&mut self.depth[start + 4..start + 8]);
        }
    }

    /// The keys of the depths of the first `n` vertices, as [`reversed_key`](crate::depth::reversed_key) makes them.
    #[inline(always)]
    pub fn find_keys<S: Simd>(&self, simd: S, n: usize, keys: &mut [i32; MAX_VERTICES]) {
        let mut start = 0;
        while start < n.min(MAX_VERTICES) {
            let low = f64x4::from_slice(simd, &self.depth[start..start + 4]);
            let high = f64x4::from_slice(simd, &self.depth[start + 4..start + 8]);
            let key: i32x8<S> = (low.narrow(high) + 0.0).bitcast(); // the sum has no negative zero
            key.store_slice(&mut keys[start..start + 8]);
            start += 8;
        }
    }

    /// Which planes the four vertices from `start` on lie outside of, and which cut them.
    #[inline(always)]
    fn classify<S: Simd>(&mut self, simd: S, lens: &Lens, p: &Clip4<S>, start: usize) {
        let zero = f64x4::splat(simd, 0.0);
        let gone = p.x * 0.0 + p.y * 0.0 + p.z * 0.0 + p.w * 0.0; // NaN unless all are finite
        let finite = gone.simd_eq(zero);
        if lens.planes.is_empty() && finite.all_true() {
            self.outside[start..start + 4].fill(0);
            self.cuts[start..start + 4].fill(0);
            return;
        }
        let (guard_x, guard_y) = (p.w * lens.guard.x, p.w * lens.guard.y);
        let minus_w = -p.w;
        let outside = [
            p.x.simd_lt(minus_w).to_bitmask(),
            p.x.simd_gt(p.w).to_bitmask(),
            p.y.simd_lt(minus_w).to_bitmask(),
            p.y.simd_gt(p.w).to_bitmask(),
            p.z.simd_gt(p.w).to_bitmask(),
            p.z.simd_lt(zero).to_bitmask(),
        ];
        let inside = [
            (p.x + guard_x).simd_ge(zero).to_bitmask(),
            (guard_x - p.x).simd_ge(zero).to_bitmask(),
            (p.y + guard_y).simd_ge(zero).to_bitmask(),
            (guard_y - p.y).simd_ge(zero).to_bitmask(),
            (p.w - p.z).simd_ge(zero).to_bitmask(),
            p.z.simd_ge(zero).to_bitmask(),
        ];
        let finite = finite.to_bitmask();
        for lane in 0..4 {
            let bit = |bits: u64| (bits >> lane) as u8 & 1;
            let (mut out, mut cut) = (0, 0);
            if bit(finite) == 1 {
                for plane in 0..6 {
                    out |= bit(outside[plane]) << plane;
                    cut |= (1 - bit(inside[plane])) << plane;
                }
                out &= lens.planes.bits();
                cut &= lens.planes.bits();
            } else {
                cut = PlaneMask::ALL.bits();
            }
            self.outside[start + lane] = out;
            self.cuts[start + lane] = cut;
            self.special |= out | cut != 0;
        }
    }
}

/// Twin of [`ClipPoint::from_model`](cullet_transform::ClipPoint::from_model).
#[inline(always)]
fn clip<S: Simd>(m: &DMat4, x: f64x4<S>, y: f64x4<S>, z: f64x4<S>) -> Clip4<S> {
    let (i, j, k, t) = (m.x_axis, m.y_axis, m.z_axis, m.w_axis);
    Clip4 {
        x: x * i.x + y * j.x + z * k.x + t.x,
        y: x * i.y + y * j.y + z * k.y + t.y,
        z: x * i.z + y * j.z + z * k.z + t.z,
        w: x * i.w + y * j.w + z * k.w + t.w,
    }
}

/// Eight points of clip space.
struct Clip8<S: Simd> {
    x: f32x8<S>,
    y: f32x8<S>,
    z: f32x8<S>,
    w: f32x8<S>,
}

#[inline(always)]
fn clip_single<S: Simd>(m: &Mat4, x: f32x8<S>, y: f32x8<S>, z: f32x8<S>) -> Clip8<S> {
    let (i, j, k, t) = (m.x_axis, m.y_axis, m.z_axis, m.w_axis);
    Clip8 {
        x: x * i.x + y * j.x + z * k.x + t.x,
        y: x * i.y + y * j.y + z * k.y + t.y,
        z: x * i.z + y * j.z + z * k.z + t.z,
        w: x * i.w + y * j.w + z * k.w + t.w,
    }
}

#[inline(always)]
fn snap_single<S: Simd, const BITS: u32>(simd: S, px: f32x8<S>, side: u32) -> i32x8<S> {
    let guard = guard_band(side, BITS) as f32;
    let low = f32x8::splat(simd, -guard);
    let high = f32x8::splat(simd, side as f32 + guard);
    let px = px.simd_gt(low).select(px, low);
    let px = px.simd_lt(high).select(px, high);
    // At 24.8 no position reaches 2^24, so the nearest integer fits.
    i32x8::truncate_from((px * (1u32 << BITS) as f32).round_ties_even())
}

/// Snapped x and y, in the low halves, and depth in `0..=1`.
#[inline(always)]
fn screen<S: Simd, const BITS: u32>(
    simd: S,
    viewport: Viewport,
    p: &Clip4<S>,
) -> (i64x4<S>, i64x4<S>, f64x4<S>) {
    let half = f64x4::splat(simd, 0.5);
    let (width, height) = (f64::from(viewport.width()), f64::from(viewport.height()));
    let x = (half + p.x / p.w * 0.5) * width;
    let y = (half - p.y / p.w * 0.5) * height;
    let depth = p.z / p.w;
    let (zero, one) = (f64x4::splat(simd, 0.0), f64x4::splat(simd, 1.0));
    let depth = depth.simd_lt(zero).select(zero, depth);
    let depth = depth.simd_gt(one).select(one, depth);
    (snap::<S, BITS>(simd, x, viewport.width()), snap::<S, BITS>(simd, y, viewport.height()), depth)
}

/// Twin of [`crate::snap`] along one axis.
#[inline(always)]
fn snap<S: Simd, const BITS: u32>(simd: S, px: f64x4<S>, side: u32) -> i64x4<S> {
    let guard = f64::from(guard_band(side, BITS));
    let low = f64x4::splat(simd, -guard);
    let high = f64x4::splat(simd, f64::from(side) + guard);
    let px = px.simd_gt(low).select(px, low);
    let px = px.simd_lt(high).select(px, high);
    // The last 32 bits of the sum are the integer's: those of the shift are 0.
    (px * f64::from(1u32 << BITS) + SNAP_SHIFT).bitcast()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::depth::reversed_key;
    use crate::precision::Transforms;
    use crate::setup::Placer;
    use fearless_simd::dispatch;
    use glam::Vec3;

    #[inline(always)]
    fn place<S: Simd>(
        simd: S,
        placed: &mut Placed,
        lens: &Lens,
        positions: [&[f32]; 3],
        transforms: Transforms,
    ) {
        match transforms {
            Transforms::F64 => placed.place::<S, 8>(simd, lens, positions),
            Transforms::F32 => placed.place_single::<S, 8>(simd, lens, positions),
        }
    }

    #[test]
    fn eight_are_placed_as_one() {
        let viewport = Viewport::new(640, 480).unwrap();
        let mut odd = vec![f32::NAN, f32::INFINITY, 3e38, -3e38, 1e-40, 0.0, -0.0, 1.0];
        let mut state = 1u32;
        odd.extend((0..240).map(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 20) as f32 - 8.0
        }));
        let turned: Vec<f32> = odd.iter().rev().copied().collect();
        let ones: Vec<f32> = odd.iter().map(|x| 0.7 * x - 1.0).collect();
        let projection = DMat4::from_cols_array(&[
            1.1, 0.0, 0.1, 0.0, 0.2, 1.9, 0.0, 0.0, 0.0, 0.1, 0.01, -1.0, 0.3, 0.0, 0.1, 0.5,
        ]);
        for planes in [PlaneMask::ALL, PlaneMask::NONE, PlaneMask::from_bits(0b01_0010)] {
            let lens = Lens {
                clip_from_model: projection,
                viewport,
                planes,
                guard: GuardBand::new(viewport, 8),
            };
            let ways = [Transforms::F64, Transforms::F32];
            let levels = crate::testing::levels().into_iter();
            for (level, transforms) in levels.flat_map(|level| ways.map(|way| (level, way))) {
                let placer = Placer::<8>::with(transforms, viewport, planes);
                let mut placed = Placed::default();
                let positions = [&odd[..], &turned[..], &ones[..]];
                dispatch!(level, simd => place(simd, &mut placed, &lens, positions, transforms));
                let mut keys = [0; MAX_VERTICES];
                dispatch!(level, simd => placed.find_keys(simd, odd.len(), &mut keys));
                let mut special = false;
                for i in 0..odd.len() {
                    let point = Vec3::new(odd[i], turned[i], ones[i]);
                    let plain = placer.place(transforms.clip(&projection, point));
                    assert_eq!(placed.cuts[i], plain.cuts.bits());
                    assert_eq!(placed.outside[i], plain.outside.bits());
                    special |= !plain.cuts.or(plain.outside).is_empty();
                    if plain.cuts.is_empty() {
                        let at = [i64::from(placed.x[i]), i64::from(placed.y[i])];
                        assert_eq!(at, [plain.at.x, plain.at.y]);
                        assert_eq!(placed.depth[i].to_bits(), plain.depth.to_bits());
                        assert_eq!(keys[i], reversed_key(plain.depth as f32));
                    }
                }
                assert_eq!(placed.special, special);
            }
        }
    }
}
