//! Pixels of one paint: from records to colours.

use std::ops::Range;

use cullet_raster::prefetch;
use fearless_simd::{Level, Simd, dispatch, f32x4, prelude::*};
use glam::{Vec2, Vec3, Vec4};

use super::column::{Column, Lanes, MOST_GROUPS, NUMBERS, WIDEST, wide};
use super::point::{PointPlanes, light_on};
use super::record::{ANCHOR, ColorPlanes, LEAST, NORMAL, Record};
use super::run::{Places, Rest, Run};
use super::sampler::{Sampler, Taps, set_colors};
use super::turn::{fours, turned, turned4};
use crate::division::{Division, RANGE, inverse_sqrts, reciprocals};
use crate::encoding::{Encoding, encode_by_polynomial, encode_by_table};
use crate::kernel::Look;
use crate::light::PointLight;
use crate::needs::Needs;
use crate::sampler::{Filter, sample};
use crate::srgb::{Encoder, encoder};
use crate::surface::Surface;
use crate::texture::{STEP, Texture};

/// A material as wide code sees it: what its pixels have in common, whatever object they are of.
#[derive(Clone, Copy, Debug)]
pub struct Paint<'a> {
    /// Base colour factor.
    factor: Vec3,
    pub(super) texture: Option<Sampled<'a>>,
    has_colors: bool,
    light: Lit,
    point: Option<PointLight>,
    division: Division,
    encoding: Encoding,
    pub(super) simd: Level,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Sampled<'a> {
    Wide(Sampler<'a>),
    /// By several samples along the footprint.
    Stretched(Sampler<'a>),
    OneByOne(&'a Texture, Filter),
}

#[derive(Clone, Copy, Debug)]
enum Lit {
    No,
    Flat,
    Smooth { direction: Vec3, ambient: f32 },
}

impl<'a> Paint<'a> {
    /// For surfaces with this one's material, and with the same needs.
    pub fn new(surface: &Surface<'a>, needs: Needs, look: &Look) -> Self {
        let texture = surface.texture.filter(|_| needs.contains(Needs::TEXTURE));
        let texture =
            texture.map(|texture| match Sampler::new(texture, look.filter, look.arithmetic) {
                Some(sampler) if look.filter == Filter::Anisotropic => Sampled::Stretched(sampler),
                Some(sampler) => Sampled::Wide(sampler),
                None => Sampled::OneByOne(texture, look.filter),
            });
        let light = if !needs.contains(Needs::LIT) {
            Lit::No
        } else if !needs.contains(Needs::SMOOTH_NORMAL) {
            Lit::Flat
        } else {
            Lit::Smooth { direction: look.light.direction(), ambient: look.light.ambient() }
        };
        Paint {
            factor: surface.material.base_color.truncate(),
            texture,
            has_colors: needs.contains(Needs::VERTEX_COLOR),
            light,
            point: look.point_light.filter(|_| needs.contains(Needs::POINT_LIGHT)),
            division: look.division,
            encoding: look.encoding,
            simd: look.simd,
        }
    }
}

/// What triangles are to their pixels, by the numbers of their records.
#[derive(Clone, Copy, Debug)]
pub struct Planes<'a> {
    /// Planes that all have.
    pub records: &'a [Record],
    /// Of vertex colours; empty where no paint needs them.
    pub colors: &'a [ColorPlanes],
    /// For a light at a point; empty where there is none.
    pub points: &'a [PointPlanes],
}

/// Where colours go. Pixels index it; alpha is 1.
#[derive(Debug)]
pub enum Out<'a> {
    /// Linear.
    Linear(&'a mut [Vec4]),
    /// 8-bit sRGB.
    Bytes(&'a mut [[u8; 4]]),
}

/// Colours the pixels of `runs`, all of one paint, from the records of their triangles. Pixels for
/// which f32 is not good enough are added to `left`, each by itself; their colours are not meaningful.
pub fn paint(
    paint: &Paint<'_>,
    runs: &[Run],
    planes: &Planes<'_>,
    scratch: &mut Scratch,
    out: &mut Out<'_>,
    left: &mut Vec<Run>,
) {
    // Who asks for nothing special has code that knows of nothing special, and pays nothing.
    let is_special = paint.division != Division::Exact
        || paint.encoding != Encoding::Exact
        || match &paint.texture {
            Some(Sampled::Wide(sampler)) => sampler.is_fixed(),
            Some(Sampled::Stretched(_)) => true,
            _ => false,
        };
    let copy = match (is_special, paint.point) {
        (false, None) => paint_as::<false, false>,
        (false, Some(_)) => paint_as::<true, false>,
        (true, _) => paint_as::<true, true>,
    };
    copy(paint, runs, planes, scratch, out, left);
}

fn paint_as<const POINT: bool, const SPECIAL: bool>(
    paint: &Paint<'_>,
    runs: &[Run],
    planes: &Planes<'_>,
    scratch: &mut Scratch,
    out: &mut Out<'_>,
    left: &mut Vec<Run>,
) {
    let encoder = encoder();
    dispatch!(paint.simd, simd => {
        paint_wide::<_, POINT, SPECIAL>(
            simd, paint, encoder, runs, planes, &mut scratch.0, out, left,
        )
    });
}

#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "one call, spread by a macro")]
fn paint_wide<S: Simd, const POINT: bool, const SPECIAL: bool>(
    simd: S,
    paint: &Paint<'_>,
    encoder: &Encoder,
    runs: &[Run],
    planes: &Planes<'_>,
    stage: &mut Stage,
    out: &mut Out<'_>,
    left: &mut Vec<Run>,
) {
    wide!(S, paint_all::<POINT, SPECIAL>(simd, paint, encoder, runs, planes, stage, out, left));
}

#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "one call, spread by a macro")]
fn paint_all<S: Simd, V: Lanes<S>, const POINT: bool, const SPECIAL: bool>(
    simd: S,
    paint: &Paint<'_>,
    encoder: &Encoder,
    runs: &[Run],
    planes: &Planes<'_>,
    stage: &mut Stage,
    out: &mut Out<'_>,
    left: &mut Vec<Run>,
) {
    let Planes { records, colors, points } = *planes;
    let is_rough = SPECIAL && paint.division == Division::Approximate;
    let is_stretched = SPECIAL && matches!(paint.texture, Some(Sampled::Stretched(_)));
    let mut rest = Rest { runs, taken: 0 };
    loop {
        let n_pixels = stage.places.take::<S, V>(simd, &mut rest);
        if n_pixels == 0 {
            return;
        }
        let n = n_pixels.div_ceil(V::LEN);
        // Stores that miss the caches hold up what comes after them as loads do.
        if let Out::Bytes(out) = &*out {
            for i in (0..n_pixels).step_by(8) {
                prefetch(out, stage.places.out()[i] as usize);
            }
        }
        for i in 0..n {
            paint.place::<S, V, SPECIAL>(simd, records, colors, stage, i);
            if POINT && let Some(light) = &paint.point {
                let is_flat = matches!(paint.light, Lit::Flat);
                let values = match stage.places.is_one_triangle::<S, V>(simd, i) {
                    true => values_of_one::<S, V>(simd, &stage.places, i, records),
                    false => values::<S, V>(simd, &stage.places, i, records),
                };
                let (rgb, good) = light_on::<S, V>(
                    simd,
                    light,
                    &stage.places,
                    i,
                    records,
                    points,
                    &values,
                    is_flat,
                    is_rough,
                );
                stage.lights[0].set(i, rgb[0]);
                stage.lights[1].set(i, rgb[1]);
                stage.lights[2].set(i, rgb[2]);
                stage.good[i] &= good;
            }
        }
        if let Some(Sampled::Wide(sampler) | Sampled::Stretched(sampler)) = &paint.texture {
            for i in 0..n {
                let lod = sampler.levels::<S, V>(simd, stage.lod.get(simd, i));
                stage.lod.set(i, lod);
            }
            for i in 0..n {
                let uv = [stage.u.get(simd, i), stage.v.get(simd, i)];
                let lod: V = stage.lod.get(simd, i);
                if is_stretched {
                    let [u, v, n] = &stage.stretch;
                    let stretch = [u.get(simd, i), v.get(simd, i), n.get(simd, i)];
                    let means = &mut stage.texels.0[i * V::LEN..][..V::LEN];
                    let (taps, samples) = (&mut stage.taps, &mut stage.samples.0);
                    sampler.means(simd, uv, lod, stretch, taps, samples, means);
                    set_colors::<S, V>(simd, &stage.texels.0, i, &mut stage.sampled);
                } else {
                    sampler.find(simd, uv, lod, &mut stage.taps, i);
                }
            }
            if !is_stretched {
                sampler.send_for::<S, V>(simd, &stage.places, &stage.taps, n);
                let (texels, out) = (&mut stage.texels.0, &mut stage.sampled);
                sampler.blend_colors::<S, V, SPECIAL>(simd, &stage.taps, n_pixels, texels, out);
            }
        }
        for i in 0..n {
            paint.color::<S, V, POINT>(simd, stage, i);
            if stage.good[i] != all(V::LEN) {
                let first = i * V::LEN;
                let end = n_pixels.min(first + V::LEN);
                leave(&stage.places, first..end, stage.good[i], left);
            }
        }
        match out {
            Out::Bytes(out) => {
                for channel in &mut stage.rgb {
                    let values = &mut channel.0[..n * V::LEN];
                    match paint.encoding {
                        _ if !SPECIAL => encoder.encode_all::<S, V>(simd, values),
                        Encoding::Exact => encoder.encode_all::<S, V>(simd, values),
                        Encoding::Table => encode_by_table::<S, V>(simd, values),
                        Encoding::Polynomial => encode_by_polynomial::<S, V>(simd, values),
                    }
                }
                for i in 0..n {
                    let first = i * V::LEN;
                    let places = &stage.places.out()[first..first + V::LEN];
                    let codes = codes::<S, V>(simd, &stage.rgb, i);
                    if first + V::LEN > n_pixels {
                        store_each(&places[..n_pixels - first], codes.as_slice(), out);
                    } else if is_row::<S, V>(simd, places) {
                        store_row(places[0] as usize, codes.as_slice(), out);
                    } else {
                        store_each(places, codes.as_slice(), out);
                    }
                }
            }
            Out::Linear(out) => {
                let [r, g, b] = &stage.rgb;
                for i in 0..n_pixels {
                    // No `map`: its closures would not be compiled for the instruction set.
                    let (r, g) = (f32::from_bits(r.0[i]), f32::from_bits(g.0[i]));
                    let b = f32::from_bits(b.0[i]);
                    out[stage.places.out()[i] as usize] = Vec4::new(r, g, b, 1.0);
                }
            }
        }
    }
}

/// Memory for [`paint()`] and for alpha tests; it carries nothing from one call to the next.
#[derive(Debug, Default)]
pub struct Scratch(pub(super) Stage);

/// What one stage leaves to the next, for a chunk of pixels.
#[derive(Debug, Default)]
pub(super) struct Stage {
    pub(super) places: Places,
    pub(super) u: Column<f32>,
    pub(super) v: Column<f32>,
    /// Footprints, then levels of detail.
    pub(super) lod: Column<f32>,
    /// Longer axes of footprints, u and v, and how many samples lie along them.
    stretch: [Column<f32>; 3],
    light: Column<f32>,
    /// From a light at a point, red, green and blue.
    lights: [Column<f32>; 3],
    /// Vertex colours, red, green and blue.
    colors: [Column<f32>; 3],
    /// Which pixels are to be trusted, a bit each, by group.
    pub(super) good: [u64; MOST_GROUPS],
    pub(super) taps: Taps,
    pub(super) texels: Column<[f32; 4]>,
    /// The same without alpha, red, green and blue.
    sampled: [Column<f32>; 3],
    /// Samples along footprints.
    samples: Column<[f32; 4]>,
    /// Colours, red, green and blue: the bits of floats, then codes.
    rgb: [Column<u32>; 3],
}

/// All pixels of a group are good.
#[inline(always)]
const fn all(lanes: usize) -> u64 {
    (1 << lanes) - 1
}

#[cold]
fn leave(places: &Places, of: Range<usize>, good: u64, left: &mut Vec<Run>) {
    let first = of.start;
    left.extend(of.filter(|i| good >> (i - first) & 1 == 0).map(|i| places.pixel(i)));
}

impl Paint<'_> {
    /// Reads the attributes of a group off their records, and all that follows without texels.
    #[inline(always)]
    pub(super) fn place<S: Simd, V: Lanes<S>, const SPECIAL: bool>(
        &self,
        simd: S,
        records: &[Record],
        colors: &[ColorPlanes],
        stage: &mut Stage,
        i: usize,
    ) {
        let zero = V::splat(simd, 0.0);
        stage.good[i] = all(V::LEN);
        let is_smooth = matches!(self.light, Lit::Smooth { .. });
        if matches!(self.light, Lit::Flat) {
            let numbers = stage.places.records(i, V::LEN);
            let light = stage.light.of_mut(i, V::LEN);
            for lane in 0..V::LEN {
                light[lane] = records[numbers[lane] as usize].at[NORMAL];
            }
        }
        if self.texture.is_none() && !self.has_colors && !is_smooth {
            return; // one colour for each triangle
        }
        let is_one = stage.places.is_one_triangle::<S, V>(simd, i);
        let values = if is_one {
            values_of_one::<S, V>(simd, &stage.places, i, records)
        } else {
            values::<S, V>(simd, &stage.places, i, records)
        };
        let [w, u, v, least] = values.low;
        let mut good = w.simd_gt(least);
        let is_rough = SPECIAL && self.division == Division::Approximate;
        let over_w = if is_rough {
            good &= is_in_range(simd, w);
            reciprocals(simd, w)
        } else {
            V::splat(simd, 1.0) / w
        };
        if let Some(texture) = &self.texture {
            let uv = [u * over_w, v * over_w];
            let [[wx, ux, vx], [wy, uy, vy]] = values.changes;
            // The quotient rule: (a / w)' = (a' - (a / w) w') / w.
            let ddx = [(ux - uv[0] * wx) * over_w, (vx - uv[1] * wx) * over_w];
            let ddy = [(uy - uv[0] * wy) * over_w, (vy - uv[1] * wy) * over_w];
            match texture {
                Sampled::Wide(sampler) => {
                    stage.u.set(i, uv[0]);
                    stage.v.set(i, uv[1]);
                    stage.lod.set(i, sampler.footprint::<S, V>(ddx, ddy));
                }
                Sampled::Stretched(sampler) if SPECIAL => {
                    stage.u.set(i, uv[0]);
                    stage.v.set(i, uv[1]);
                    let (piece2, [u, v, n]) = sampler.stretch(simd, ddx, ddy);
                    stage.lod.set(i, piece2);
                    stage.stretch[0].set(i, u);
                    stage.stretch[1].set(i, v);
                    stage.stretch[2].set(i, n);
                }
                Sampled::Stretched(_) => {} // special
                Sampled::OneByOne(texture, filter) => {
                    let mut numbers = [[0.0; WIDEST]; 6];
                    uv[0].store_slice(&mut numbers[0][..V::LEN]);
                    uv[1].store_slice(&mut numbers[1][..V::LEN]);
                    ddx[0].store_slice(&mut numbers[2][..V::LEN]);
                    ddx[1].store_slice(&mut numbers[3][..V::LEN]);
                    ddy[0].store_slice(&mut numbers[4][..V::LEN]);
                    ddy[1].store_slice(&mut numbers[5][..V::LEN]);
                    let out = &mut stage.texels.0[i * V::LEN..][..V::LEN];
                    one_by_one(texture, *filter, &numbers, out);
                    set_colors::<S, V>(simd, &stage.texels.0, i, &mut stage.sampled);
                }
            }
        }
        if self.has_colors {
            let [r, g, b] = colors_over_w::<S, V>(simd, &stage.places, i, records, colors);
            stage.colors[0].set(i, r * over_w);
            stage.colors[1].set(i, g * over_w);
            stage.colors[2].set(i, b * over_w);
        }
        if let Lit::Smooth { direction, ambient } = self.light {
            // Normals over w: their length does not matter.
            let [x, y, z] = values.normal;
            let length2 = x * x + y * y + z * z;
            let cosine = x * direction.x + y * direction.y + z * direction.z;
            let cosine = if is_rough {
                cosine * inverse_sqrts(simd, length2)
            } else {
                cosine / length2.sqrt()
            };
            let cosine = cosine.simd_gt(zero).select(cosine, zero);
            stage.light.set(i, cosine * (1.0 - ambient) + ambient);
            good &= is_in_range(simd, length2); // so squares are safe
        }
        stage.good[i] = good.to_bitmask();
    }

    /// The colours of a group.
    #[inline(always)]
    fn color<S: Simd, V: Lanes<S>, const POINT: bool>(&self, simd: S, stage: &mut Stage, i: usize) {
        let mut rgb = [
            V::splat(simd, self.factor.x),
            V::splat(simd, self.factor.y),
            V::splat(simd, self.factor.z),
        ];
        if self.texture.is_some() {
            let [r, g, b] = &stage.sampled;
            let [r, g, b]: [V; 3] = [r.get(simd, i), g.get(simd, i), b.get(simd, i)];
            let step = V::splat(simd, STEP);
            rgb = [rgb[0] * (r * step), rgb[1] * (g * step), rgb[2] * (b * step)];
        }
        if self.has_colors {
            let [r, g, b] = &stage.colors;
            rgb = [
                rgb[0] * r.get::<S, V>(simd, i),
                rgb[1] * g.get::<S, V>(simd, i),
                rgb[2] * b.get::<S, V>(simd, i),
            ];
        }
        if !matches!(self.light, Lit::No) {
            let light: V = stage.light.get(simd, i);
            // The special copy serves paints with a light and without.
            rgb = if POINT && self.point.is_some() {
                let [r, g, b] = &stage.lights;
                [
                    rgb[0] * (light + r.get::<S, V>(simd, i)),
                    rgb[1] * (light + g.get::<S, V>(simd, i)),
                    rgb[2] * (light + b.get::<S, V>(simd, i)),
                ]
            } else {
                [rgb[0] * light, rgb[1] * light, rgb[2] * light]
            };
        }
        stage.rgb[0].set(i, rgb[0].bitcast::<V::Uints>());
        stage.rgb[1].set(i, rgb[1].bitcast::<V::Uints>());
        stage.rgb[2].set(i, rgb[2].bitcast::<V::Uints>());
    }
}

/// Which numbers are far from the ends of what floats can be.
#[inline(always)]
pub(super) fn is_in_range<S: Simd, V: Lanes<S>>(simd: S, x: V) -> V::Mask {
    x.simd_gt(V::splat(simd, RANGE[0])) & x.simd_lt(V::splat(simd, RANGE[1]))
}

/// Attributes over w at the pixels of a group.
pub(super) struct Values<V> {
    /// Sum of shares, u, v, and the least sum.
    pub low: [V; 4],
    pub normal: [V; 3],
    /// Changes of w, u and v over w per pixel to the right and down.
    pub changes: [[V; 3]; 2],
}

/// Of pixels that may all be of different triangles.
#[inline(always)]
pub(super) fn values<S: Simd, V: Lanes<S>>(
    simd: S,
    places: &Places,
    i: usize,
    records: &[Record],
) -> Values<V> {
    let numbers = places.records(i, V::LEN);
    let [mut at, mut ddx, mut ddy] = [[V::splat(simd, 0.0); 8]; 3];
    let rows = V::LEN / 8;
    for vector in 0..8 {
        // Of one record, or of two.
        let first = vector * rows;
        let a = &records[numbers[first] as usize];
        let b = &records[numbers[first + rows - 1] as usize];
        at[vector] = V::of_rows(simd, [&a.at, &b.at]);
        ddx[vector] = V::of_rows(simd, [&a.ddx, &b.ddx]);
        ddy[vector] = V::of_rows(simd, [&a.ddy, &b.ddy]);
    }
    values_of(simd, places, i, [turned::<S, V>(&at), turned::<S, V>(&ddx), turned::<S, V>(&ddy)])
}

/// Of pixels of one triangle.
#[inline(always)]
pub(super) fn values_of_one<S: Simd, V: Lanes<S>>(
    simd: S,
    places: &Places,
    i: usize,
    records: &[Record],
) -> Values<V> {
    let record = &records[places.records(i, V::LEN)[0] as usize];
    let [at, ddx, ddy] = [&record.at, &record.ddx, &record.ddy];
    values_of(simd, places, i, [splats(simd, at), splats(simd, ddx), splats(simd, ddy)])
}

/// From the numbers of the records, each of all pixels.
#[inline(always)]
fn values_of<S: Simd, V: Lanes<S>>(
    simd: S,
    places: &Places,
    i: usize,
    [at, ddx, ddy]: [[V; 8]; 3],
) -> Values<V> {
    let dx = places.x().get::<S, V>(simd, i) - ddx[ANCHOR];
    let dy = places.y().get::<S, V>(simd, i) - ddy[ANCHOR];
    Values {
        low: [
            at[0] + ddx[0] * dx + ddy[0] * dy,
            at[1] + ddx[1] * dx + ddy[1] * dy,
            at[2] + ddx[2] * dx + ddy[2] * dy,
            at[LEAST],
        ],
        normal: [
            at[NORMAL] + ddx[NORMAL] * dx + ddy[NORMAL] * dy,
            at[NORMAL + 1] + ddx[NORMAL + 1] * dx + ddy[NORMAL + 1] * dy,
            at[NORMAL + 2] + ddx[NORMAL + 2] * dx + ddy[NORMAL + 2] * dy,
        ],
        changes: [[ddx[0], ddx[1], ddx[2]], [ddy[0], ddy[1], ddy[2]]],
    }
}

#[inline(always)]
fn splats<S: Simd, V: Lanes<S>>(simd: S, x: &[f32; 8]) -> [V; 8] {
    [
        V::splat(simd, x[0]),
        V::splat(simd, x[1]),
        V::splat(simd, x[2]),
        V::splat(simd, x[3]),
        V::splat(simd, x[4]),
        V::splat(simd, x[5]),
        V::splat(simd, x[6]),
        V::splat(simd, x[7]),
    ]
}

#[inline(always)]
fn colors_over_w<S: Simd, V: Lanes<S>>(
    simd: S,
    places: &Places,
    i: usize,
    records: &[Record],
    colors: &[ColorPlanes],
) -> [V; 3] {
    let mut values = [[0.0; 4]; WIDEST];
    let (numbers, x, y) =
        (places.records(i, V::LEN), places.x().of(i, V::LEN), places.y().of(i, V::LEN));
    for lane in 0..V::LEN {
        let record = &records[numbers[lane] as usize];
        let planes = &colors[numbers[lane] as usize];
        let [anchor_x, anchor_y] = record.anchor();
        let at = f32x4::simd_from(simd, planes.at);
        let ddx = f32x4::simd_from(simd, planes.ddx);
        let ddy = f32x4::simd_from(simd, planes.ddy);
        values[lane] = (at + ddx * (x[lane] - anchor_x) + ddy * (y[lane] - anchor_y)).into();
    }
    let [r, g, b, _] = turned4::<S, V>(&fours(simd, &values[..V::LEN]));
    [r, g, b]
}

#[cold]
fn one_by_one(
    texture: &Texture,
    filter: Filter,
    [u, v, u_ddx, v_ddx, u_ddy, v_ddy]: &[[f32; WIDEST]; 6],
    out: &mut [[f32; 4]],
) {
    for (i, out) in out.iter_mut().enumerate() {
        let [uv, ddx, ddy] =
            [[u, v], [u_ddx, v_ddx], [u_ddy, v_ddy]].map(|[u, v]| Vec2::new(u[i], v[i]));
        *out = (sample(texture, uv, ddx, ddy, filter) / STEP).to_array();
    }
}

/// The codes of a group side by side, opaque.
#[inline(always)]
fn codes<S: Simd, V: Lanes<S>>(simd: S, [r, g, b]: &[Column<u32>; 3], i: usize) -> V::Uints {
    let [r, g, b]: [V::Uints; 3] = [r.get(simd, i), g.get(simd, i), b.get(simd, i)];
    r | g << 8 | b << 16 | V::Uints::splat(simd, 0xff00_0000)
}

/// Whether each place of a group is the one after the place before, as most are.
#[inline(always)]
fn is_row<S: Simd, V: Lanes<S>>(simd: S, places: &[u32]) -> bool {
    let steps = V::Uints::from_slice(simd, &NUMBERS[..V::LEN]);
    let starts = V::Uints::from_slice(simd, places) - steps;
    starts.simd_eq(V::Uints::splat(simd, places[0])).all_true()
}

#[inline(always)]
fn store_row(first: usize, codes: &[u32], out: &mut [[u8; 4]]) {
    let row = &mut out[first..first + codes.len()];
    for i in 0..codes.len() {
        row[i] = codes[i].to_le_bytes();
    }
}

#[inline(always)]
fn store_each(places: &[u32], codes: &[u32], out: &mut [[u8; 4]]) {
    for i in 0..places.len() {
        out[places[i] as usize] = codes[i].to_le_bytes();
    }
}
