//! What a triangle is to its pixels: attributes over `w` as planes.
//!
//! Over the picture `attribute / w` is linear (Heckbert & Moreton 1991, "Interpolation for
//! Polygon Texture Mapping"), so a pixel costs one multiply-add per axis, a vector of attributes
//! at a time.

use cullet_raster::{Corners4, Placement, Shares4, prefetch, shares4};
use fearless_simd::{Level, Simd, dispatch, f32x4, f32x8, prelude::*};
use glam::{Affine2, Vec2, Vec3, Vec4};

use cullet_scene::Wrap;

use super::point::PointPlanes;
use crate::kernel::lambert;
use crate::light::{Light, PointLight};
use crate::needs::Needs;
use crate::surface::{Surface, flat_normal};

/// Lanes of a [`Record`]: the sum of shares, texture coordinates, the least sum for which the
/// planes serve, and the normal, or the light on a flat triangle.
pub(super) const LEAST: usize = 3;
/// Of the changes the same lane holds where the planes are counted from, px: x in `ddx`, y in `ddy`.
pub(super) const ANCHOR: usize = 3;
pub(super) const NORMAL: usize = 4;

/// Planes of the attributes of a triangle in a block of the picture.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(32))]
pub struct Record {
    pub(super) at: [f32; 8],
    pub(super) ddx: [f32; 8],
    pub(super) ddy: [f32; 8],
}

impl Record {
    /// Where the planes are counted from, px from the corner of the block.
    #[inline(always)]
    pub(super) fn anchor(&self) -> [f32; 2] {
        [self.ddx[ANCHOR], self.ddy[ANCHOR]]
    }
}

/// Planes of vertex colours, red, green and blue.
#[derive(Clone, Copy, Debug, Default)]
pub struct ColorPlanes {
    pub(super) at: [f32; 4],
    pub(super) ddx: [f32; 4],
    pub(super) ddy: [f32; 4],
}

/// Triangles of one object in one block.
#[derive(Clone, Copy, Debug)]
pub struct Group<'a> {
    /// The object.
    pub surface: Surface<'a>,
    /// Where it is on the screen.
    pub placement: &'a Placement,
    /// What its colour needs.
    pub needs: Needs,
    /// The object is mirrored: its front faces run clockwise.
    pub mirrored: bool,
    /// The light on it.
    pub light: Light,
    /// A light at a point that reaches it.
    pub point_light: Option<PointLight>,
    /// Upper left pixel of the block.
    pub block: [u32; 2],
}

/// Makes the records of `wanted`: pairs of a triangle of the mesh and its place in `records`, and
/// in `colors` if vertex colours are needed, in `points` if there is a light at a point.
pub fn set_up(
    simd: Level,
    group: &Group<'_>,
    wanted: &[(u32, u32)],
    records: &mut [Record],
    colors: &mut [ColorPlanes],
    points: &mut [PointPlanes],
) {
    dispatch!(simd, simd => set_up_all(simd, group, wanted, records, colors, points));
}

#[inline(always)]
fn set_up_all<S: Simd>(
    simd: S,
    group: &Group<'_>,
    wanted: &[(u32, u32)],
    records: &mut [Record],
    colors: &mut [ColorPlanes],
    points: &mut [PointPlanes],
) {
    let attributes = Attributes::new(simd, group);
    let mesh = group.surface.mesh;
    // In stages, each short enough to be well ahead of the memory that it waits for.
    let mut corners = [[0; 3]; CHUNK];
    let mut positions: [Corners4; CHUNK / 4] = [[[[0.0; 4]; 3]; 3]; CHUNK / 4];
    for chunk in wanted.chunks(CHUNK) {
        let n_fours = chunk.len().div_ceil(4);
        for (i, corners) in corners[..4 * n_fours].iter_mut().enumerate() {
            // Beyond the last, the last again.
            let (triangle, _) = chunk[i.min(chunk.len() - 1)];
            *corners = mesh.triangles[triangle as usize];
            for corner in *corners {
                prefetch(&mesh.positions, corner as usize);
            }
        }
        for (i, corners) in corners[..4 * n_fours].iter().enumerate() {
            attributes.send_for(*corners);
            let four = &mut positions[i / 4];
            for corner in 0..3 {
                let position = mesh.positions[corners[corner] as usize];
                four[corner][0][i % 4] = position.x;
                four[corner][1][i % 4] = position.y;
                four[corner][2][i % 4] = position.z;
            }
        }
        for (i, four) in chunk.chunks(4).enumerate() {
            let shares = shares4(simd, group.placement, &positions[i], group.block);
            for (lane, &(_, record)) in four.iter().enumerate() {
                let (place, record) = (4 * i + lane, record as usize);
                let corners = corners[place];
                let into = &mut records[record];
                attributes.set_up(simd, &shares, lane, corners, into);
                if let Some(values) = attributes.colors {
                    set_up_colors(simd, values, &shares, lane, corners, &mut colors[record]);
                }
                if let Some(light) = &group.point_light {
                    let surface = &group.surface;
                    let mut normal = Vec3::ZERO;
                    if attributes.flat.is_some() {
                        let front = shares.clockwise[lane] == group.mirrored;
                        let outward = flat_normal(surface, corners);
                        normal = if front { outward } else { -outward };
                    }
                    points[record] =
                        PointPlanes::new(simd, light, surface, &shares, lane, corners, normal);
                }
            }
        }
    }
}

/// Triangles set up in stages.
const CHUNK: usize = 64;

/// Where the attributes of a group are.
struct Attributes<'a, S: Simd> {
    surface: &'a Surface<'a>,
    /// Texture coordinates; whether they repeat in whole numbers, for u and v: 1, 2 if the
    /// picture mirrors, 0 if it does not repeat.
    uvs: Option<&'a [Vec2]>,
    periods: [f32; 2],
    transform: Option<Affine2>,
    normals: Option<&'a [Vec3]>,
    normal_world_from_model: [f32x4<S>; 3],
    colors: Option<&'a [Vec4]>,
    /// The light, on flat triangles.
    flat: Option<Light>,
    mirrored: bool,
}

impl<'a, S: Simd> Attributes<'a, S> {
    #[inline(always)]
    fn new(simd: S, group: &'a Group<'_>) -> Self {
        let Group { surface, needs, .. } = group;
        let (mut uvs, mut periods, mut transform) = (None, [0.0; 2], None);
        if let (Some(used), Some(texture)) = (&surface.material.base_color_texture, surface.texture)
        {
            uvs = surface.mesh.uvs.get(used.uv_set).and_then(|uvs| uvs.as_deref());
            periods = [period(texture.wrap[0]), period(texture.wrap[1])];
            transform = used.transform;
        }
        let normals = surface.mesh.normals.as_deref();
        let normals = normals.filter(|_| needs.contains(Needs::SMOOTH_NORMAL));
        let m = surface.normal_world_from_model;
        let flat = needs.contains(Needs::LIT) && normals.is_none();
        Attributes {
            surface,
            uvs,
            periods,
            transform,
            normals,
            normal_world_from_model: [
                f32x4::simd_from(simd, [m.x_axis.x, m.x_axis.y, m.x_axis.z, 0.0]),
                f32x4::simd_from(simd, [m.y_axis.x, m.y_axis.y, m.y_axis.z, 0.0]),
                f32x4::simd_from(simd, [m.z_axis.x, m.z_axis.y, m.z_axis.z, 0.0]),
            ],
            colors: surface.mesh.colors.as_deref().filter(|_| needs.contains(Needs::VERTEX_COLOR)),
            flat: if flat { Some(group.light) } else { None },
            mirrored: group.mirrored,
        }
    }

    /// Sends for what [`Attributes::set_up`] will read.
    #[inline(always)]
    fn send_for(&self, corners: [u32; 3]) {
        for corner in corners {
            if let Some(uvs) = self.uvs {
                prefetch(uvs, corner as usize);
            }
            if let Some(normals) = self.normals {
                prefetch(normals, corner as usize);
            }
        }
    }

    #[inline(always)]
    fn set_up(
        &self,
        simd: S,
        shares: &Shares4,
        lane: usize,
        corners: [u32; 3],
        record: &mut Record,
    ) {
        let [a, b, c] = self.uvs(simd, corners);
        let front = shares.clockwise[lane] == self.mirrored;
        let [na, nb, nc] = self.normals(simd, corners, front);
        let (a, b, c) = (a.combine(na), b.combine(nb), c.combine(nc));
        record.at = blend(a, b, c, &shares.at, lane).into();
        record.ddx = blend(a, b, c, &shares.ddx, lane).into();
        record.ddy = blend(a, b, c, &shares.ddy, lane).into();
        record.at[LEAST] = shares.least[lane];
        record.ddx[ANCHOR] = shares.anchor[0][lane];
        record.ddy[ANCHOR] = shares.anchor[1][lane];
        if let Some(light) = &self.flat {
            let outward = flat_normal(self.surface, corners);
            record.at[NORMAL] = lambert(if front { outward } else { -outward }, light);
        }
    }

    /// 1, texture coordinates of the corners, less whole periods, so that little is lost to f32, and 0.
    #[inline(always)]
    fn uvs(&self, simd: S, [a, b, c]: [u32; 3]) -> [f32x4<S>; 3] {
        let Some(uvs) = self.uvs else { return [f32x4::simd_from(simd, [1.0, 0.0, 0.0, 0.0]); 3] };
        let (mut a, mut b, mut c) = (uvs[a as usize], uvs[b as usize], uvs[c as usize]);
        if let Some(t) = &self.transform {
            [a, b, c] = [transformed(t, a), transformed(t, b), transformed(t, c)];
        }
        let a = f32x4::simd_from(simd, [1.0, a.x, a.y, 0.0]);
        let b = f32x4::simd_from(simd, [1.0, b.x, b.y, 0.0]);
        let c = f32x4::simd_from(simd, [1.0, c.x, c.y, 0.0]);
        let whole = whole(simd, a, self.periods);
        [a - whole, b - whole, c - whole]
    }

    /// Normals of the corners in world space on the side seen, of any length.
    #[inline(always)]
    fn normals(&self, simd: S, [a, b, c]: [u32; 3], front: bool) -> [f32x4<S>; 3] {
        let Some(normals) = self.normals else { return [f32x4::splat(simd, 0.0); 3] };
        let side = if front { 1.0 } else { -1.0 };
        let [x, y, z] = self.normal_world_from_model;
        let m = [x * side, y * side, z * side];
        [
            world(m, normals[a as usize]),
            world(m, normals[b as usize]),
            world(m, normals[c as usize]),
        ]
    }
}

#[inline(always)]
fn set_up_colors<S: Simd>(
    simd: S,
    values: &[Vec4],
    shares: &Shares4,
    lane: usize,
    corners: [u32; 3],
    planes: &mut ColorPlanes,
) {
    let [a, b, c] = [
        f32x4::simd_from(simd, values[corners[0] as usize].to_array()),
        f32x4::simd_from(simd, values[corners[1] as usize].to_array()),
        f32x4::simd_from(simd, values[corners[2] as usize].to_array()),
    ];
    let [at, ddx, ddy] = [&shares.at, &shares.ddx, &shares.ddy];
    planes.at = (a * at[0][lane] + b * at[1][lane] + c * at[2][lane]).into();
    planes.ddx = (a * ddx[0][lane] + b * ddx[1][lane] + c * ddx[2][lane]).into();
    planes.ddy = (a * ddy[0][lane] + b * ddy[1][lane] + c * ddy[2][lane]).into();
}

#[inline(always)]
fn blend<S: Simd>(
    a: f32x8<S>,
    b: f32x8<S>,
    c: f32x8<S>,
    shares: &[[f32; 4]; 3],
    lane: usize,
) -> f32x8<S> {
    a * shares[0][lane] + b * shares[1][lane] + c * shares[2][lane]
}

#[inline(always)]
fn world<S: Simd>([x, y, z]: [f32x4<S>; 3], normal: Vec3) -> f32x4<S> {
    x * normal.x + y * normal.y + z * normal.z
}

#[inline(always)]
fn transformed(t: &Affine2, uv: Vec2) -> Vec2 {
    t.matrix2.x_axis * uv.x + t.matrix2.y_axis * uv.y + t.translation
}

fn period(wrap: Wrap) -> f32 {
    match wrap {
        Wrap::Repeat => 1.0,
        Wrap::Mirror => 2.0,
        Wrap::Clamp => 0.0,
    }
}

/// Whole `periods` up to the second and third of `x`; none of what is too large to have a fraction, or
/// not a number, and none of what has no period.
#[inline(always)]
fn whole<S: Simd>(simd: S, x: f32x4<S>, [u, v]: [f32; 2]) -> f32x4<S> {
    // Periods are 0, 1 or 2: exact.
    let (pu, pv) = (if u == 2.0 { 0.5 } else { u }, if v == 2.0 { 0.5 } else { v });
    // Towards zero; any whole period does.
    let whole = (x * f32x4::simd_from(simd, [0.0, pu, pv, 0.0])).trunc();
    let whole = whole * f32x4::simd_from(simd, [0.0, u, v, 0.0]);
    let zero = f32x4::splat(simd, 0.0);
    x.abs().simd_lt(f32x4::splat(simd, 8_388_608.0)).select(whole, zero)
}
