//! Pixels of one paint: from records to colours.

use std::ops::Range;

use cullet_raster::prefetch;
use fearless_simd::{Level, Simd, dispatch, f32x4, f32x8, mask32x8, prelude::*, u32x8};
use glam::{Vec2, Vec3, Vec4};

use super::point::{PointPlanes, light_on};
use super::record::{ColorPlanes, LEAST, NORMAL, Record};
use super::run::{Places, Rest, Run};
use super::sampler::{EIGHTS, Sampler, Taps};
use crate::division::{Division, RANGE, inverse_sqrt8, reciprocal8};
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
        paint_all::<_, POINT, SPECIAL>(
            simd, paint, encoder, runs, planes, &mut scratch.0, out, left,
        )
    });
}

#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "one call, spread by a macro")]
fn paint_all<S: Simd, const POINT: bool, const SPECIAL: bool>(
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
        let n_pixels = stage.places.take(simd, &mut rest);
        if n_pixels == 0 {
            return;
        }
        let n = n_pixels.div_ceil(8);
        // Stores that miss the caches hold up what comes after them as loads do.
        if let Out::Bytes(out) = &*out {
            for i in 0..n {
                prefetch(out, stage.places.out(i)[0] as usize);
            }
        }
        for i in 0..n {
            paint.place::<_, SPECIAL>(simd, records, colors, stage, i);
            if POINT && let Some(light) = &paint.point {
                let is_flat = matches!(paint.light, Lit::Flat);
                let values = match stage.places.is_one_triangle(simd, i) {
                    true => values_of_one(simd, &stage.places, i, records),
                    false => values(simd, &stage.places, i, records),
                };
                let (rgb, good) = light_on(
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
                stage.lights[i] = rgb;
                stage.good[i] &= good;
            }
        }
        if let Some(Sampled::Wide(sampler) | Sampled::Stretched(sampler)) = &paint.texture {
            for lod in &mut stage.lod[..n] {
                *lod = sampler.lod8(simd, f32x8::simd_from(simd, *lod)).into();
            }
            for i in 0..n {
                let uv = [f32x8::simd_from(simd, stage.u[i]), f32x8::simd_from(simd, stage.v[i])];
                let lod = f32x8::simd_from(simd, stage.lod[i]);
                if is_stretched {
                    let [u, v, n] = &stage.stretch[i];
                    let stretch = [
                        f32x8::simd_from(simd, *u),
                        f32x8::simd_from(simd, *v),
                        f32x8::simd_from(simd, *n),
                    ];
                    stage.texels[i] = sampler.mean8(simd, uv, lod, stretch, &mut stage.taps);
                } else {
                    sampler.find8(simd, uv, lod, &mut stage.taps, i);
                }
            }
            if !is_stretched {
                sampler.send_for(simd, &stage.places, &stage.taps, n);
                sampler.blend_all::<_, SPECIAL>(simd, &stage.taps, n, &mut stage.texels);
            }
        }
        for i in 0..n {
            stage.rgb[i] =
                paint.color(simd, stage, i, if POINT { Some(&stage.lights[i]) } else { None });
            if stage.good[i] != 0xff {
                leave(&stage.places, 8 * i..n_pixels.min(8 * i + 8), stage.good[i], left);
            }
        }
        match out {
            Out::Bytes(out) => {
                let values = stage.rgb[..n].as_flattened_mut();
                match paint.encoding {
                    _ if !SPECIAL => encoder.encode_all(simd, values),
                    Encoding::Exact => encoder.encode_all(simd, values),
                    Encoding::Table => encode_by_table(simd, values),
                    Encoding::Polynomial => encode_by_polynomial(simd, values),
                }
                for i in 0..n_pixels / 8 {
                    store_codes(stage.places.out(i), codes(simd, &stage.rgb[i]), out);
                }
                if !n_pixels.is_multiple_of(8) {
                    let places = &stage.places.out(n - 1)[..n_pixels % 8];
                    store_each(places, codes(simd, &stage.rgb[n - 1]), out);
                }
            }
            Out::Linear(out) => {
                for i in 0..n_pixels {
                    let [r, g, b] = &stage.rgb[i / 8];
                    let [r, g, b] = [r[i % 8], g[i % 8], b[i % 8]];
                    out[stage.places.out(i / 8)[i % 8] as usize] =
                        Vec4::new(f32::from_bits(r), f32::from_bits(g), f32::from_bits(b), 1.0);
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
    pub(super) u: [[f32; 8]; EIGHTS],
    pub(super) v: [[f32; 8]; EIGHTS],
    /// Footprints, then levels of detail.
    pub(super) lod: [[f32; 8]; EIGHTS],
    /// Longer axes of footprints, u and v, and how many samples lie along them.
    stretch: [[[f32; 8]; 3]; EIGHTS],
    light: [[f32; 8]; EIGHTS],
    /// From a light at a point, red, green and blue.
    lights: [[[f32; 8]; 3]; EIGHTS],
    /// Vertex colours, red, green and blue.
    colors: [[[f32; 8]; 3]; EIGHTS],
    /// Which pixels are to be trusted, a bit each.
    pub(super) good: [u64; EIGHTS],
    pub(super) taps: Taps,
    pub(super) texels: [[[f32; 4]; 8]; EIGHTS],
    /// Colours, red, green and blue: the bits of floats, then codes.
    rgb: [[[u32; 8]; 3]; EIGHTS],
}

#[cold]
fn leave(places: &Places, of: Range<usize>, good: u64, left: &mut Vec<Run>) {
    left.extend(of.filter(|i| good >> (i % 8) & 1 == 0).map(|i| places.pixel(i)));
}

impl Paint<'_> {
    /// Reads the attributes of eight pixels off their records, and all that follows without texels.
    #[inline(always)]
    pub(super) fn place<S: Simd, const SPECIAL: bool>(
        &self,
        simd: S,
        records: &[Record],
        colors: &[ColorPlanes],
        stage: &mut Stage,
        i: usize,
    ) {
        let zero = f32x8::splat(simd, 0.0);
        stage.good[i] = 0xff;
        let is_smooth = matches!(self.light, Lit::Smooth { .. });
        if matches!(self.light, Lit::Flat) {
            for lane in 0..8 {
                stage.light[i][lane] = records[stage.places.records(i)[lane] as usize].at[NORMAL];
            }
        }
        if self.texture.is_none() && !self.has_colors && !is_smooth {
            return; // one colour for each triangle
        }
        let is_one = stage.places.is_one_triangle(simd, i);
        let values = if is_one {
            values_of_one(simd, &stage.places, i, records)
        } else {
            values(simd, &stage.places, i, records)
        };
        let [w, u, v, least] = values.low;
        let mut good = w.simd_gt(least);
        let is_rough = SPECIAL && self.division == Division::Approximate;
        let over_w = if is_rough {
            good &= is_in_range(simd, w);
            reciprocal8(simd, w)
        } else {
            f32x8::splat(simd, 1.0) / w
        };
        if let Some(texture) = &self.texture {
            let uv = [u * over_w, v * over_w];
            let [[wx, ux, vx], [wy, uy, vy]] = if is_one {
                changes_of_one(simd, &records[stage.places.records(i)[0] as usize])
            } else {
                changes(simd, stage.places.records(i), records)
            };
            // The quotient rule: (a / w)' = (a' - (a / w) w') / w.
            let ddx = [(ux - uv[0] * wx) * over_w, (vx - uv[1] * wx) * over_w];
            let ddy = [(uy - uv[0] * wy) * over_w, (vy - uv[1] * wy) * over_w];
            match texture {
                Sampled::Wide(sampler) => {
                    (stage.u[i], stage.v[i]) = (uv[0].into(), uv[1].into());
                    stage.lod[i] = sampler.footprint8(ddx, ddy).into();
                }
                Sampled::Stretched(sampler) if SPECIAL => {
                    (stage.u[i], stage.v[i]) = (uv[0].into(), uv[1].into());
                    let (piece2, [u, v, n]) = sampler.stretch8(simd, ddx, ddy);
                    stage.lod[i] = piece2.into();
                    stage.stretch[i] = [u.into(), v.into(), n.into()];
                }
                Sampled::Stretched(_) => {} // special
                Sampled::OneByOne(texture, filter) => {
                    stage.texels[i] = one_by_one(
                        texture,
                        *filter,
                        [uv[0].into(), uv[1].into()],
                        [ddx[0].into(), ddx[1].into()],
                        [ddy[0].into(), ddy[1].into()],
                    );
                }
            }
        }
        if self.has_colors {
            let [r, g, b] = colors_over_w(simd, &stage.places, i, records, colors);
            stage.colors[i] = [(r * over_w).into(), (g * over_w).into(), (b * over_w).into()];
        }
        if let Lit::Smooth { direction, ambient } = self.light {
            // Normals over w: their length does not matter.
            let [x, y, z] = values.normal;
            let length2 = x * x + y * y + z * z;
            let cosine = x * direction.x + y * direction.y + z * direction.z;
            let cosine = if is_rough {
                cosine * inverse_sqrt8(simd, length2)
            } else {
                cosine / length2.sqrt()
            };
            let cosine = cosine.simd_gt(zero).select(cosine, zero);
            stage.light[i] = (cosine * (1.0 - ambient) + ambient).into();
            good &= is_in_range(simd, length2); // so squares are safe
        }
        stage.good[i] = good.to_bitmask();
    }

    /// The colours of eight pixels.
    #[inline(always)]
    fn color<S: Simd>(
        &self,
        simd: S,
        stage: &Stage,
        i: usize,
        point: Option<&[[f32; 8]; 3]>,
    ) -> [[u32; 8]; 3] {
        let mut rgb = [
            f32x8::splat(simd, self.factor.x),
            f32x8::splat(simd, self.factor.y),
            f32x8::splat(simd, self.factor.z),
        ];
        if self.texture.is_some() {
            // No loop over vectors: it might become a call.
            let [a, b, c, d, e, f, g, h] = &stage.texels[i];
            let [r, g, b, _] = transposed(&[
                f32x4::simd_from(simd, *a),
                f32x4::simd_from(simd, *b),
                f32x4::simd_from(simd, *c),
                f32x4::simd_from(simd, *d),
                f32x4::simd_from(simd, *e),
                f32x4::simd_from(simd, *f),
                f32x4::simd_from(simd, *g),
                f32x4::simd_from(simd, *h),
            ]);
            let step = f32x8::splat(simd, STEP);
            rgb = [rgb[0] * (r * step), rgb[1] * (g * step), rgb[2] * (b * step)];
        }
        if self.has_colors {
            let [r, g, b] = &stage.colors[i];
            rgb = [
                rgb[0] * f32x8::simd_from(simd, *r),
                rgb[1] * f32x8::simd_from(simd, *g),
                rgb[2] * f32x8::simd_from(simd, *b),
            ];
        }
        if !matches!(self.light, Lit::No) {
            let light = f32x8::simd_from(simd, stage.light[i]);
            rgb = match point {
                None => [rgb[0] * light, rgb[1] * light, rgb[2] * light],
                Some([r, g, b]) => [
                    rgb[0] * (light + f32x8::simd_from(simd, *r)),
                    rgb[1] * (light + f32x8::simd_from(simd, *g)),
                    rgb[2] * (light + f32x8::simd_from(simd, *b)),
                ],
            };
        }
        [
            rgb[0].bitcast::<u32x8<S>>().into(),
            rgb[1].bitcast::<u32x8<S>>().into(),
            rgb[2].bitcast::<u32x8<S>>().into(),
        ]
    }
}

/// Which numbers are far from the ends of what floats can be.
#[inline(always)]
pub(super) fn is_in_range<S: Simd>(simd: S, x: f32x8<S>) -> mask32x8<S> {
    x.simd_gt(f32x8::splat(simd, RANGE[0])) & x.simd_lt(f32x8::splat(simd, RANGE[1]))
}

/// Attributes over w at eight pixels.
pub(super) struct Values<S: Simd> {
    /// Sum of shares, u, v, and the least sum.
    pub low: [f32x8<S>; 4],
    pub normal: [f32x8<S>; 3],
}

/// Of pixels that may all be of different triangles: pixel by pixel, then turned.
#[inline(always)]
fn values<S: Simd>(simd: S, places: &Places, i: usize, records: &[Record]) -> Values<S> {
    let (mut low, mut high) = ([f32x4::splat(simd, 0.0); 8], [f32x4::splat(simd, 0.0); 8]);
    let (numbers, x, y) = (places.records(i), places.x(i), places.y(i));
    for lane in 0..8 {
        let record = &records[numbers[lane] as usize];
        let (dx, dy) = (x[lane] - record.anchor[0], y[lane] - record.anchor[1]);
        let at = f32x8::simd_from(simd, record.at);
        let ddx = f32x8::simd_from(simd, record.ddx);
        let ddy = f32x8::simd_from(simd, record.ddy);
        (low[lane], high[lane]) = (at + ddx * dx + ddy * dy).split();
    }
    let [x, y, z, _] = transposed(&high);
    Values { low: transposed(&low), normal: [x, y, z] }
}

/// The same, operation by operation, of pixels of one triangle.
#[inline(always)]
fn values_of_one<S: Simd>(simd: S, places: &Places, i: usize, records: &[Record]) -> Values<S> {
    let record = &records[places.records(i)[0] as usize];
    let dx = f32x8::simd_from(simd, *places.x(i)) - record.anchor[0];
    let dy = f32x8::simd_from(simd, *places.y(i)) - record.anchor[1];
    Values {
        low: [
            value(simd, record, 0, dx, dy),
            value(simd, record, 1, dx, dy),
            value(simd, record, 2, dx, dy),
            f32x8::splat(simd, record.at[LEAST]),
        ],
        normal: [
            value(simd, record, NORMAL, dx, dy),
            value(simd, record, NORMAL + 1, dx, dy),
            value(simd, record, NORMAL + 2, dx, dy),
        ],
    }
}

#[inline(always)]
fn value<S: Simd>(simd: S, record: &Record, lane: usize, dx: f32x8<S>, dy: f32x8<S>) -> f32x8<S> {
    let (at, ddx, ddy) = (record.at[lane], record.ddx[lane], record.ddy[lane]);
    f32x8::splat(simd, at) + f32x8::splat(simd, ddx) * dx + f32x8::splat(simd, ddy) * dy
}

/// Changes of w, u and v over w per pixel to the right and down.
#[inline(always)]
fn changes<S: Simd>(simd: S, numbers: &[u32; 8], records: &[Record]) -> [[f32x8<S>; 3]; 2] {
    let (mut ddx, mut ddy) = ([f32x4::splat(simd, 0.0); 8], [f32x4::splat(simd, 0.0); 8]);
    for lane in 0..8 {
        let record = &records[numbers[lane] as usize];
        ddx[lane] = f32x4::from_slice(simd, &record.ddx[..4]);
        ddy[lane] = f32x4::from_slice(simd, &record.ddy[..4]);
    }
    let [wx, ux, vx, _] = transposed(&ddx);
    let [wy, uy, vy, _] = transposed(&ddy);
    [[wx, ux, vx], [wy, uy, vy]]
}

#[inline(always)]
fn changes_of_one<S: Simd>(simd: S, record: &Record) -> [[f32x8<S>; 3]; 2] {
    let Record { ddx: x, ddy: y, .. } = record;
    [
        [f32x8::splat(simd, x[0]), f32x8::splat(simd, x[1]), f32x8::splat(simd, x[2])],
        [f32x8::splat(simd, y[0]), f32x8::splat(simd, y[1]), f32x8::splat(simd, y[2])],
    ]
}

#[inline(always)]
#[expect(clippy::needless_range_loop, reason = "iterators over vectors may become calls")]
fn colors_over_w<S: Simd>(
    simd: S,
    places: &Places,
    i: usize,
    records: &[Record],
    colors: &[ColorPlanes],
) -> [f32x8<S>; 3] {
    let mut values = [f32x4::splat(simd, 0.0); 8];
    for lane in 0..8 {
        let record = places.records(i)[lane] as usize;
        let (x, y) = (places.x(i)[lane], places.y(i)[lane]);
        let (anchor, planes) = (&records[record].anchor, &colors[record]);
        let at = f32x4::simd_from(simd, planes.at);
        let ddx = f32x4::simd_from(simd, planes.ddx);
        let ddy = f32x4::simd_from(simd, planes.ddy);
        values[lane] = at + ddx * (x - anchor[0]) + ddy * (y - anchor[1]);
    }
    let [r, g, b, _] = transposed(&values);
    [r, g, b]
}

/// From four numbers of each pixel to eight pixels of each number.
#[inline(always)]
pub(super) fn transposed<S: Simd>(rows: &[f32x4<S>; 8]) -> [f32x8<S>; 4] {
    let [a, b, c, d] = transposed4([rows[0], rows[1], rows[2], rows[3]]);
    let [e, f, g, h] = transposed4([rows[4], rows[5], rows[6], rows[7]]);
    [a.combine(e), b.combine(f), c.combine(g), d.combine(h)]
}

#[inline(always)]
fn transposed4<S: Simd>([a, b, c, d]: [f32x4<S>; 4]) -> [f32x4<S>; 4] {
    let (ac, bd) = (a.zip_low(c), b.zip_low(d));
    let (ac_high, bd_high) = (a.zip_high(c), b.zip_high(d));
    [ac.zip_low(bd), ac.zip_high(bd), ac_high.zip_low(bd_high), ac_high.zip_high(bd_high)]
}

#[cold]
fn one_by_one(
    texture: &Texture,
    filter: Filter,
    uv: [[f32; 8]; 2],
    ddx: [[f32; 8]; 2],
    ddy: [[f32; 8]; 2],
) -> [[f32; 4]; 8] {
    std::array::from_fn(|lane| {
        let [uv, ddx, ddy] = [uv, ddx, ddy].map(|[u, v]| Vec2::new(u[lane], v[lane]));
        (sample(texture, uv, ddx, ddy, filter) / STEP).to_array()
    })
}

/// Eight pixels' codes side by side, opaque.
#[inline(always)]
fn codes<S: Simd>(simd: S, [r, g, b]: &[[u32; 8]; 3]) -> [u32; 8] {
    let r = u32x8::simd_from(simd, *r);
    let g = u32x8::simd_from(simd, *g);
    let b = u32x8::simd_from(simd, *b);
    (r | g << 8 | b << 16 | 0xff00_0000).into()
}

/// Writes eight pixels: most are neighbours in a row.
#[inline(always)]
fn store_codes(places: &[u32; 8], codes: [u32; 8], out: &mut [[u8; 4]]) {
    let first = places[0] as usize;
    let is_row = places[7] == places[0] + 7;
    if is_row && let Some(row) = out.get_mut(first..first + 8) {
        for (out, code) in row.iter_mut().zip(codes) {
            *out = code.to_le_bytes();
        }
        return;
    }
    store_each(places, codes, out);
}

#[inline(always)]
fn store_each(places: &[u32], codes: [u32; 8], out: &mut [[u8; 4]]) {
    for (place, code) in places.iter().zip(codes) {
        out[*place as usize] = code.to_le_bytes();
    }
}
