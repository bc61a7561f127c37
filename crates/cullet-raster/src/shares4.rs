//! Four triangles at once made ready for interpolation in f32: [`crate::Interpolator`], wide.
//!
//! Positions, snapping, areas and the planes of the shares are f64 as there; each coefficient is
//! rounded once. What f32 can then hold depends on where a plane is anchored: the picture is cut
//! into blocks of [`BLOCK`] px, counted from its corner, and a triangle has one anchor in
//! each block that it reaches: the point nearest to its first corner, or the middle of the block
//! if it is clipped. So no distance exceeds a block, and small triangles are anchored at
//! themselves. Shares are scaled by the first corner's `w`, so they are of the order of 1.
//!
//! With every triangle comes the least sum of shares for which this is good enough
//! ([`Shares4::least`]). Where the sum is not greater (slivers far beyond their length, the last
//! row before the horizon, what is not a number), ask the [`crate::Interpolator`].

use cullet_transform::{ClipPoint, Plane, PlaneMask, Viewport};
use fearless_simd::{Simd, f32x8, f64x4, mask64x4, prelude::*};
use glam::{DMat4, DVec3};

use crate::clip::GuardBand;
use crate::interpolate::Interpolator;
use crate::precision::SubpixelBits;

/// Pixels along each side of a block.
pub const BLOCK: u32 = 64;

/// Of the terms that add up to a sum of shares, the part that the sum must exceed. Its rounding
/// errors are then at most some 1e-4 of it, and some 1e-7 for triangles that are not slivers.
const LEAST: f64 = 2e-4;

/// How the triangles of an object come onto the screen.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    clip_from_model: DMat4,
    viewport: Viewport,
    planes: PlaneMask,
    guard: GuardBand,
    axes: [Axis; 2],
    /// Units of the grid in a pixel.
    units: f64,
}

/// A side of the picture, px, and the guard band beyond it.
#[derive(Clone, Copy, Debug)]
struct Axis {
    side: f64,
    guard: f64,
}

impl Placement {
    /// With what [`crate::Placer`] was given.
    pub fn new(
        clip_from_model: DMat4,
        viewport: Viewport,
        planes: PlaneMask,
        subpixel_bits: SubpixelBits,
    ) -> Self {
        let axis = |side: u32| Axis {
            side: f64::from(side),
            guard: f64::from(subpixel_bits.guard_band(side)),
        };
        Placement {
            clip_from_model,
            viewport,
            planes,
            guard: GuardBand::new(viewport, subpixel_bits.count()),
            axes: [axis(viewport.width()), axis(viewport.height())],
            units: subpixel_bits.units(),
        }
    }
}

/// Planes of `share_i / w_i` (see [`Interpolator`]) of the corners of four triangles, up to a
/// positive factor for each triangle: first by corner, then by triangle.
#[derive(Clone, Copy, Debug, Default)]
pub struct Shares4 {
    /// At the anchor.
    pub at: [[f32; 4]; 3],
    /// Change per pixel to the right.
    pub ddx: [[f32; 4]; 3],
    /// Change per pixel down.
    pub ddy: [[f32; 4]; 3],
    /// x and y of the anchor, px from the corner of the block.
    pub anchor: [[f32; 4]; 2],
    /// The planes serve where the sum of shares is greater.
    pub least: [f32; 4],
    /// Whether the corners run clockwise as seen on the screen.
    pub clockwise: [bool; 4],
}

/// Model-space corners of four triangles: by corner, axis, triangle.
pub type Corners4 = [[[f32; 4]; 3]; 3];

/// Three f64 numbers for each triangle, one per corner.
type Each<S> = [f64x4<S>; 3];

/// Sets up four triangles for the block whose upper left pixel is `block`.
#[inline(always)]
pub fn shares4<S: Simd>(
    simd: S,
    placement: &Placement,
    corners: &Corners4,
    block: [u32; 2],
) -> Shares4 {
    let m = &placement.clip_from_model;
    let clip = [clip(simd, m, &corners[0]), clip(simd, m, &corners[1]), clip(simd, m, &corners[2])];
    let w = [clip[0][3], clip[1][3], clip[2][3]];
    let ([width, height], units) = (&placement.axes, placement.units);
    let x = [
        snap4(simd, clip[0][0] / w[0], 0.5, width, units),
        snap4(simd, clip[1][0] / w[1], 0.5, width, units),
        snap4(simd, clip[2][0] / w[2], 0.5, width, units),
    ];
    let y = [
        snap4(simd, clip[0][1] / w[0], -0.5, height, units),
        snap4(simd, clip[1][1] / w[1], -0.5, height, units),
        snap4(simd, clip[2][1] / w[2], -0.5, height, units),
    ];
    let one = f64x4::splat(simd, 1.0);
    let scale = [one, w[0] / w[1], w[0] / w[2]];
    let mut out = snapped(simd, &x, &y, &scale, block, units);
    if !placement.planes.is_empty() {
        let uncut = inside(simd, placement, &clip[0])
            & inside(simd, placement, &clip[1])
            & inside(simd, placement, &clip[2]);
        if !uncut.all_true() {
            let uncut = uncut.to_bitmask();
            for lane in (0..4).filter(|lane| uncut >> lane & 1 == 0) {
                homogeneous(placement, corners, lane, block, &mut out);
            }
        }
    }
    out
}

/// Clip coordinates of a corner of each triangle, summed in the order of
/// [`ClipPoint::from_model`].
#[inline(always)]
fn clip<S: Simd>(simd: S, m: &DMat4, corner: &[[f32; 4]; 3]) -> [f64x4<S>; 4] {
    let [x, y, z] = corner;
    let (x, y) = f32x8::simd_from(simd, [x[0], x[1], x[2], x[3], y[0], y[1], y[2], y[3]]).widen();
    let (z, _) = f32x8::simd_from(simd, [z[0], z[1], z[2], z[3], z[0], z[1], z[2], z[3]]).widen();
    [
        x * m.x_axis.x + y * m.y_axis.x + z * m.z_axis.x + m.w_axis.x,
        x * m.x_axis.y + y * m.y_axis.y + z * m.z_axis.y + m.w_axis.y,
        x * m.x_axis.z + y * m.y_axis.z + z * m.z_axis.z + m.w_axis.z,
        x * m.x_axis.w + y * m.y_axis.w + z * m.z_axis.w + m.w_axis.w,
    ]
}

/// [`crate::snap`] of one coordinate, in units as f64; `half` is 0.5, negative if the axis turns.
#[inline(always)]
fn snap4<S: Simd>(simd: S, ndc: f64x4<S>, half: f64, axis: &Axis, units: f64) -> f64x4<S> {
    const SHIFT: f64 = 6_755_399_441_055_744.0; // rounds to an integer, halves to even
    let low = f64x4::splat(simd, -axis.guard);
    let high = f64x4::splat(simd, axis.side + axis.guard);
    let px = (ndc * half + 0.5) * axis.side;
    let px = px.simd_gt(low).select(px, low);
    let px = px.simd_lt(high).select(px, high);
    px * units + SHIFT - SHIFT
}

#[inline(always)]
fn snapped<S: Simd>(
    simd: S,
    x: &Each<S>,
    y: &Each<S>,
    scale: &Each<S>,
    block: [u32; 2],
    units: f64,
) -> Shares4 {
    let per_unit = 1.0 / units; // a power of two: exact
    let (x1, y1, x2, y2) = (x[1] - x[0], y[1] - y[0], x[2] - x[0], y[2] - y[0]);
    let area = x1 * y2 - y1 * x2;
    let per_pixel = f64x4::splat(simd, units) / area;
    let ddx = [(y[1] - y[2]) * per_pixel, y2 * per_pixel, y1 * -per_pixel];
    let ddy = [(x[2] - x[1]) * per_pixel, x2 * -per_pixel, x1 * per_pixel];
    // The anchor, and how far from it pixels of the triangle can be.
    let (anchor_x, step_x) = nearest(simd, x[0] * per_unit, block[0]);
    let (anchor_y, step_y) = nearest(simd, y[0] * per_unit, block[1]);
    let reach_x = reach(simd, x1 * per_unit, x2 * per_unit);
    let reach_y = reach(simd, y1 * per_unit, y2 * per_unit);
    let one = f64x4::splat(simd, 1.0);
    let at = [
        ddx[0] * step_x + ddy[0] * step_y + one,
        ddx[1] * step_x + ddy[1] * step_y,
        ddx[2] * step_x + ddy[2] * step_y,
    ];
    let at = [at[0], at[1] * scale[1], at[2] * scale[2]];
    let ddx = [ddx[0], ddx[1] * scale[1], ddx[2] * scale[2]];
    let ddy = [ddy[0], ddy[1] * scale[1], ddy[2] * scale[2]];
    let terms = at[0].abs() + at[1].abs() + at[2].abs();
    let terms = terms + (ddx[0].abs() + ddx[1].abs() + ddx[2].abs()) * reach_x;
    let terms = terms + (ddy[0].abs() + ddy[1].abs() + ddy[2].abs()) * reach_y;
    let clockwise = area.simd_gt(f64x4::splat(simd, 0.0)).to_bitmask();
    let (at0, at1) = halves(at[0].narrow(at[1]));
    let (at2, ddx0) = halves(at[2].narrow(ddx[0]));
    let (ddx1, ddx2) = halves(ddx[1].narrow(ddx[2]));
    let (ddy0, ddy1) = halves(ddy[0].narrow(ddy[1]));
    let (ddy2, least) = halves(ddy[2].narrow(terms * LEAST));
    let (anchor_x, anchor_y) = halves(anchor_x.narrow(anchor_y));
    Shares4 {
        at: [at0, at1, at2],
        ddx: [ddx0, ddx1, ddx2],
        ddy: [ddy0, ddy1, ddy2],
        anchor: [anchor_x, anchor_y],
        least,
        clockwise: [clockwise & 1 != 0, clockwise & 2 != 0, clockwise & 4 != 0, clockwise & 8 != 0],
    }
}

#[inline(always)]
fn halves<S: Simd>(v: f32x8<S>) -> ([f32; 4], [f32; 4]) {
    let (low, high) = v.split();
    (low.into(), high.into())
}

/// The place in a block that is nearest to `at`, from the block's corner and from `at`.
#[inline(always)]
fn nearest<S: Simd>(simd: S, at: f64x4<S>, block: u32) -> (f64x4<S>, f64x4<S>) {
    let low = f64x4::splat(simd, 0.0);
    let high = f64x4::splat(simd, f64::from(BLOCK));
    let at = at - f64::from(block);
    let inside = at.simd_gt(low).select(at, low);
    let inside = inside.simd_lt(high).select(inside, high);
    (inside, inside - at)
}

/// The larger of two distances, at most a block.
#[inline(always)]
fn reach<S: Simd>(simd: S, a: f64x4<S>, b: f64x4<S>) -> f64x4<S> {
    let (a, b, block) = (a.abs(), b.abs(), f64x4::splat(simd, f64::from(BLOCK)));
    let larger = a.simd_gt(b).select(a, b);
    larger.simd_lt(block).select(larger, block)
}

/// Which corners no plane cuts; see [`GuardBand::cuts`].
#[inline(always)]
fn inside<S: Simd>(simd: S, placement: &Placement, [x, y, z, w]: &[f64x4<S>; 4]) -> mask64x4<S> {
    let asked = |plane: Plane| placement.planes.contains(plane.index());
    let zero = f64x4::splat(simd, 0.0);
    let (reach_x, reach_y) = (*w * placement.guard.x, *w * placement.guard.y);
    let mut inside = zero.simd_ge(zero);
    if asked(Plane::Near) {
        inside &= (*w - *z).simd_ge(zero);
    }
    if asked(Plane::Far) {
        inside &= z.simd_ge(zero);
    }
    if asked(Plane::Left) {
        inside &= (*x + reach_x).simd_ge(zero);
    }
    if asked(Plane::Right) {
        inside &= (reach_x - *x).simd_ge(zero);
    }
    if asked(Plane::Bottom) {
        inside &= (*y + reach_y).simd_ge(zero);
    }
    if asked(Plane::Top) {
        inside &= (reach_y - *y).simd_ge(zero);
    }
    inside
}

/// A triangle that is clipped: between its true corners, anchored in the middle of the block.
#[cold]
fn homogeneous(
    placement: &Placement,
    corners: &Corners4,
    lane: usize,
    block: [u32; 2],
    out: &mut Shares4,
) {
    let model =
        |corner: usize| DVec3::from_array(corners[corner].map(|axis| f64::from(axis[lane])));
    let clip = [0, 1, 2].map(|i| ClipPoint::from_model(&placement.clip_from_model, model(i)));
    let planes = Interpolator::homogeneous(placement.viewport, &clip);
    let middle = 0.5 * f64::from(BLOCK);
    let [x, y] = block.map(|side| f64::from(side) + middle);
    let at = planes.at_origin
        + planes.ddx * (x - planes.origin[0])
        + planes.ddy * (y - planes.origin[1]);
    let terms = at.abs() + (planes.ddx.abs() + planes.ddy.abs()) * middle;
    for corner in 0..3 {
        out.at[corner][lane] = at[corner] as f32;
        out.ddx[corner][lane] = planes.ddx[corner] as f32;
        out.ddy[corner][lane] = planes.ddy[corner] as f32;
    }
    out.anchor[0][lane] = middle as f32;
    out.anchor[1][lane] = middle as f32;
    out.least[lane] = ((terms.x + terms.y + terms.z) * LEAST) as f32;
    out.clockwise[lane] = planes.is_clockwise();
}
