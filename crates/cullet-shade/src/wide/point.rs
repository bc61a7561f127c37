//! A light at a point, on many pixels: [`PointLight`]'s formula, wide.
//!
//! The vector to the light is an attribute like others, a plane over the picture after a divide by `w`.
//! It is taken from the light in f64 and only then rounded, so a scene far from the origin loses nothing.

use cullet_raster::Shares4;
use fearless_simd::{Simd, f32x4, prelude::*};
use glam::Vec3;

use super::column::{Lanes, WIDEST};
use super::paint::{Values, is_in_range};
use super::record::Record;
use super::run::Places;
use super::turn::{fours, turned4};
use crate::division::{inverse_sqrts, reciprocals};
use crate::light::PointLight;
use crate::surface::Surface;

/// Planes of the vector to a light over `w`, and the unit normal of a flat triangle.
#[derive(Clone, Copy, Debug, Default)]
pub struct PointPlanes {
    at: [f32; 4],
    ddx: [f32; 4],
    ddy: [f32; 4],
    normal: [f32; 4],
}

impl PointPlanes {
    /// Of the triangle in `lane`; `normal` on the side seen, if it is flat.
    #[inline(always)]
    pub(super) fn new<S: Simd>(
        simd: S,
        light: &PointLight,
        surface: &Surface<'_>,
        shares: &Shares4,
        lane: usize,
        corners: [u32; 3],
        normal: Vec3,
    ) -> Self {
        let a = f32x4::simd_from(simd, to_light(light, surface, corners[0]));
        let b = f32x4::simd_from(simd, to_light(light, surface, corners[1]));
        let c = f32x4::simd_from(simd, to_light(light, surface, corners[2]));
        let [at, ddx, ddy] = [&shares.at, &shares.ddx, &shares.ddy];
        PointPlanes {
            at: (a * at[0][lane] + b * at[1][lane] + c * at[2][lane]).into(),
            ddx: (a * ddx[0][lane] + b * ddx[1][lane] + c * ddx[2][lane]).into(),
            ddy: (a * ddy[0][lane] + b * ddy[1][lane] + c * ddy[2][lane]).into(),
            normal: [normal.x, normal.y, normal.z, 0.0],
        }
    }
}

fn to_light(light: &PointLight, surface: &Surface<'_>, corner: u32) -> [f32; 4] {
    let position = surface.mesh.positions[corner as usize].as_dvec3();
    let [x, y, z] = light.seen_from(surface.world_from_model.transform_point3(position)).to_array();
    [x, y, z, 0.0]
}

/// What `light` adds at a group of pixels, red, green and blue; and for which of them f32 serves.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "one call, in two ways")]
pub(super) fn light_on<S: Simd, V: Lanes<S>>(
    simd: S,
    light: &PointLight,
    places: &Places,
    i: usize,
    records: &[Record],
    points: &[PointPlanes],
    values: &Values<V>,
    is_flat: bool,
    is_rough: bool,
) -> ([V; 3], u64) {
    let [mut rows, mut normals] = [[[0.0; 4]; WIDEST]; 2];
    let (numbers, x, y) =
        (places.records(i, V::LEN), places.x().of(i, V::LEN), places.y().of(i, V::LEN));
    for lane in 0..V::LEN {
        let record = &records[numbers[lane] as usize];
        let planes = &points[numbers[lane] as usize];
        let [anchor_x, anchor_y] = record.anchor();
        let at = f32x4::simd_from(simd, planes.at);
        let ddx = f32x4::simd_from(simd, planes.ddx);
        let ddy = f32x4::simd_from(simd, planes.ddy);
        rows[lane] = (at + ddx * (x[lane] - anchor_x) + ddy * (y[lane] - anchor_y)).into();
        normals[lane] = planes.normal;
    }
    let (rows, normals) = (&rows[..V::LEN], &normals[..V::LEN]);
    let [w, _, _, least] = values.low;
    let zero = V::splat(simd, 0.0);
    let one = V::splat(simd, 1.0);
    let over_w = if is_rough { reciprocals(simd, w) } else { one / w };
    let [x, y, z, _] = turned4::<S, V>(&fours(simd, rows));
    let (x, y, z) = (x * over_w, y * over_w, z * over_w);
    let [nx, ny, nz] = if is_flat {
        let [nx, ny, nz, _] = turned4::<S, V>(&fours(simd, normals));
        [nx, ny, nz]
    } else {
        // Over w, of any length; what is too short or too long is left to the plain code.
        let [nx, ny, nz] = values.normal;
        let length2 = nx * nx + ny * ny + nz * nz;
        if is_rough {
            let over = inverse_sqrts(simd, length2);
            [nx * over, ny * over, nz * over]
        } else {
            let length = length2.sqrt();
            [nx / length, ny / length, nz / length]
        }
    };
    let [radius2, inverse_radius2] = light.radius2();
    let distance2 = x * x + y * y + z * z;
    let reached = distance2.simd_gt(zero) & distance2.simd_lt(V::splat(simd, radius2));
    let cosine = nx * x + ny * y + nz * z;
    let cosine = cosine.simd_gt(zero).select(cosine, zero);
    let cosine =
        if is_rough { cosine * inverse_sqrts(simd, distance2) } else { cosine / distance2.sqrt() };
    let share = distance2 * inverse_radius2;
    let window = one - share * share;
    let window = window.simd_gt(zero).select(window, zero);
    let falloff = if is_rough {
        window * window * reciprocals(simd, distance2 + one)
    } else {
        window * window / (distance2 + one)
    };
    let strength = cosine * falloff;
    let strength = reached.select(strength, zero);
    let color = light.color();
    let rgb = [strength * color.x, strength * color.y, strength * color.z];
    let good = w.simd_gt(least);
    let good = if is_rough { good & (is_in_range(simd, distance2) | !reached) } else { good };
    (rgb, good.to_bitmask())
}
