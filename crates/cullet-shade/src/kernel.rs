//! Shading kernels: one function per set of needs, written once.
//!
//! A kernel shades a run of pixels of one triangle, eight at a time. `shade` is the only text;
//! its needs are a const parameter, so the compiler drops every fetch that a set does not ask for.
//! Corner attributes are gathered, and texture coordinates transformed, once per run.
//!
//! Every instruction set gives the same bits, and a pixel the same colour in whatever run it is:
//! the arithmetic is `+ - * /`, square root and compare-and-select in a fixed order. Passes and
//! alpha tests read one pixel at a time, by the same gathering; they differ from kernels by
//! rounding.
//!
//! Colours are linear RGBA, alpha straight.

use cullet_raster::{Fragment, Fragment8, Pixels};
use fearless_simd::{Level, Simd, dispatch, f32x8, prelude::*};
use glam::{Vec2, Vec3, Vec4};

use crate::light::Light;
use crate::needs::{Needs, Shading};
use crate::sampler::{Filter, sample, sample_alpha};
use crate::sampler8::{Footprint8, fits, trilinear8};
use crate::select::max;
use crate::surface::{Surface, corner_uvs, flat_normal, gather, interpolate, outward_normal};
use crate::texture::Texture;

/// A triangle of a mesh in the world.
#[derive(Clone, Copy, Debug)]
pub struct Triangle<'a> {
    /// The mesh.
    pub surface: Surface<'a>,
    /// Indices into the mesh's vertex lists.
    pub corners: [u32; 3],
    /// Which side is seen.
    pub front: bool,
}

/// How to look at it.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// The sun and the even light around it.
    pub light: Light,
    /// How textures are filtered.
    pub filter: Filter,
    /// The instruction set. Never changes a colour.
    pub simd: Level,
}

/// Shades as many of the pixels of one triangle as `out` has room for, in order: linear RGB, and
/// alpha 1 in every alpha mode until blending arrives.
pub type Kernel = fn(triangle: &Triangle<'_>, look: &Look, pixels: Pixels<'_>, out: &mut [Vec4]);

/// The kernel that reads what `needs` names and nothing else.
pub fn kernel_for(needs: Needs) -> Kernel {
    macro_rules! kernels {
        ($($needs:literal)*) => { [$(shade::<$needs>),*] };
    }
    // Every set without the mask, which is the last bit.
    const KERNELS: [Kernel; Needs::MASK.0 as usize] = kernels!(
        0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15
        16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31
    );
    KERNELS[usize::from(needs.0 % Needs::MASK.0)]
}

/// The colour that light multiplies, with its alpha: factor, texture and vertex colour.
/// The factor and vertex colours are as the file has them, so they may exceed 1.
pub fn base_color(
    surface: &Surface<'_>,
    corners: [u32; 3],
    fragment: &Fragment,
    filter: Filter,
) -> Vec4 {
    let needs = Needs::of(surface.mesh, surface.material, Shading::Unlit);
    BaseColor::gather(needs, surface, corners).at(fragment, filter)
}

/// The alpha of [`base_color`], bit for bit, without its colour.
pub fn alpha(surface: &Surface<'_>, corners: [u32; 3], fragment: &Fragment, filter: Filter) -> f32 {
    let needs = Needs::of(surface.mesh, surface.material, Shading::Unlit);
    BaseColor::gather(needs, surface, corners).alpha_at(fragment, filter)
}

fn shade<const NEEDS: u8>(
    triangle: &Triangle<'_>,
    look: &Look,
    pixels: Pixels<'_>,
    out: &mut [Vec4],
) {
    let needs = Needs(NEEDS);
    let run = Run {
        triangle,
        look,
        pixels,
        base_color: BaseColor::gather(needs, &triangle.surface, triangle.corners),
        lit: Lit::gather(needs, triangle, &look.light),
    };
    run.shade(out);
}

/// All that the colours of a run depend on; what is not needed is not there. A group of eight
/// pixels asks what is: so rarely that a copy of the wide code for each set of needs, which took
/// minutes to compile, has nothing to gain.
struct Run<'a, 'b> {
    triangle: &'b Triangle<'a>,
    look: &'b Look,
    pixels: Pixels<'b>,
    base_color: BaseColor<'a>,
    lit: Option<Lit>,
}

impl Run<'_, '_> {
    /// Here all sets of needs come together.
    #[inline(never)]
    fn shade(&self, out: &mut [Vec4]) {
        dispatch!(self.look.simd, simd => self.shade8(simd, out));
    }

    #[inline(always)]
    fn shade8<S: Simd>(&self, simd: S, out: &mut [Vec4]) {
        let Run { triangle, look, pixels, ref base_color, ref lit } = *self;
        for (group, out) in out.chunks_mut(8).enumerate() {
            let first = 8 * group;
            let fragment = pixels.at8(simd, first);
            let mut colors = [base_color.factor; 8];
            if let Some((texture, uvs)) = base_color.texture {
                let mut texels = [Vec4::ONE; 8];
                if look.filter == Filter::Trilinear && fits(texture) {
                    let footprint = footprint8(uvs, &fragment);
                    trilinear8(simd, texture, &footprint, out.len(), &mut texels);
                } else {
                    one_by_one(texture, uvs, look.filter, pixels, first, &mut texels[..out.len()]);
                }
                for (color, texel) in colors.iter_mut().zip(texels) {
                    *color *= texel;
                }
            }
            if let Some([a, b, c]) = base_color.colors {
                let [wa, wb, wc]: [[f32; 8]; 3] = [
                    fragment.weights[0].into(),
                    fragment.weights[1].into(),
                    fragment.weights[2].into(),
                ];
                for lane in 0..8 {
                    colors[lane] *= a * wa[lane] + b * wb[lane] + c * wc[lane];
                }
            }
            if let Some(lit) = lit {
                let light = lit.at8(simd, triangle, &look.light, &fragment, out.len());
                for lane in 0..8 {
                    colors[lane] *= light[lane];
                }
            }
            for (out, color) in out.iter_mut().zip(colors) {
                *out = color.truncate().extend(1.0);
            }
        }
    }
}

/// Where the wide sampler does not serve: the other filters, which are for looking closely, and
/// textures too large for it.
#[cold]
fn one_by_one(
    texture: &Texture,
    uvs: [Vec2; 3],
    filter: Filter,
    pixels: Pixels<'_>,
    first: usize,
    out: &mut [Vec4],
) {
    for (i, out) in out.iter_mut().enumerate() {
        let [uv, duvdx, duvdy] = footprint(uvs, &pixels.at(first + i));
        *out = sample(texture, uv, duvdx, duvdy, filter);
    }
}

/// The places of eight pixels in the texture and their changes per pixel.
#[inline(always)]
fn footprint8<S: Simd>([a, b, c]: [Vec2; 3], fragment: &Fragment8<S>) -> Footprint8<S> {
    let (ab, ac) = (b - a, c - a);
    let [dx1, dx2] = fragment.ddx;
    let [dy1, dy2] = fragment.ddy;
    Footprint8 {
        uv: [blend8([a.x, b.x, c.x], fragment), blend8([a.y, b.y, c.y], fragment)],
        ddx: [dx1 * ab.x + dx2 * ac.x, dx1 * ab.y + dx2 * ac.y],
        ddy: [dy1 * ab.x + dy2 * ac.x, dy1 * ab.y + dy2 * ac.y],
    }
}

/// Corner values blended for eight pixels.
#[inline(always)]
fn blend8<S: Simd>([a, b, c]: [f32; 3], fragment: &Fragment8<S>) -> f32x8<S> {
    let [wa, wb, wc] = fragment.weights;
    wa * a + wb * b + wc * c
}

/// What the base colour of one triangle is made of.
struct BaseColor<'a> {
    factor: Vec4,
    texture: Option<(&'a Texture, [Vec2; 3])>,
    colors: Option<[Vec4; 3]>,
}

impl<'a> BaseColor<'a> {
    #[inline(always)]
    fn gather(needs: Needs, surface: &Surface<'a>, corners: [u32; 3]) -> Self {
        let texture = if needs.contains(Needs::TEXTURE) {
            surface.texture.map(|texture| (texture, texture_uvs(needs, surface, corners)))
        } else {
            None
        };
        let colors = if needs.contains(Needs::VERTEX_COLOR) {
            surface.mesh.colors.as_deref().map(|colors| gather(colors, corners))
        } else {
            None
        };
        BaseColor { factor: surface.material.base_color, texture, colors }
    }

    #[inline(always)]
    fn at(&self, fragment: &Fragment, filter: Filter) -> Vec4 {
        let mut color = self.factor;
        if let Some((texture, uvs)) = self.texture {
            let [uv, duvdx, duvdy] = footprint(uvs, fragment);
            color *= sample(texture, uv, duvdx, duvdy, filter);
        }
        if let Some(colors) = self.colors {
            color *= interpolate(colors, fragment.weights.as_vec3());
        }
        color
    }

    fn alpha_at(&self, fragment: &Fragment, filter: Filter) -> f32 {
        let mut alpha = self.factor.w;
        if let Some((texture, uvs)) = self.texture {
            let [uv, duvdx, duvdy] = footprint(uvs, fragment);
            alpha *= sample_alpha(texture, uv, duvdx, duvdy, filter);
        }
        if let Some(colors) = self.colors {
            alpha *= interpolate(colors.map(|color| color.w), fragment.weights.as_vec3());
        }
        alpha
    }
}

/// Corner coordinates of the base colour texture. Transforming an affine function at the
/// corners transforms it everywhere.
#[inline(always)]
fn texture_uvs(needs: Needs, surface: &Surface<'_>, corners: [u32; 3]) -> [Vec2; 3] {
    let Some(texture) = &surface.material.base_color_texture else { return [Vec2::ZERO; 3] };
    let uvs = corner_uvs(surface, corners, texture.uv_set);
    match texture.transform {
        Some(t) if needs.contains(Needs::UV_TRANSFORM) => {
            uvs.map(|uv| t.matrix2.x_axis * uv.x + t.matrix2.y_axis * uv.y + t.translation)
        }
        _ => uvs,
    }
}

/// The place in the texture and its change per pixel along the screen axes.
#[inline(always)]
fn footprint(uvs: [Vec2; 3], fragment: &Fragment) -> [Vec2; 3] {
    [fragment.weights.as_vec3(), fragment.ddx, fragment.ddy]
        .map(|weights| interpolate(uvs, weights))
}

/// What the light on one triangle depends on.
enum Lit {
    /// Normals of the corners, to be blended.
    Smooth([Vec3; 3]),
    /// The same everywhere.
    Flat(f32),
}

impl Lit {
    #[inline(always)]
    fn gather(needs: Needs, triangle: &Triangle<'_>, light: &Light) -> Option<Self> {
        let Triangle { surface, corners, front } = triangle;
        if !needs.contains(Needs::LIT) {
            return None;
        }
        Some(match surface.mesh.normals.as_deref() {
            Some(normals) if needs.contains(Needs::SMOOTH_NORMAL) => {
                Lit::Smooth(gather(normals, *corners))
            }
            _ => {
                let outward = flat_normal(surface, *corners);
                Lit::Flat(lambert(if *front { outward } else { -outward }, light))
            }
        })
    }

    /// The light on eight pixels.
    #[inline(always)]
    fn at8<S: Simd>(
        &self,
        simd: S,
        triangle: &Triangle<'_>,
        light: &Light,
        fragment: &Fragment8<S>,
        n: usize,
    ) -> [f32; 8] {
        let normals = match self {
            Lit::Flat(light) => return [*light; 8],
            Lit::Smooth(normals) => normals,
        };
        let [a, b, c] = normals;
        let (x, y, z) = (
            blend8([a.x, b.x, c.x], fragment),
            blend8([a.y, b.y, c.y], fragment),
            blend8([a.z, b.z, c.z], fragment),
        );
        let m = triangle.surface.normal_world_from_model;
        let (i, j, k) = (m.x_axis, m.y_axis, m.z_axis);
        let (x, y, z) =
            (x * i.x + y * j.x + z * k.x, x * i.y + y * j.y + z * k.y, x * i.z + y * j.z + z * k.z);
        let towards = if triangle.front { light.direction() } else { -light.direction() };
        let length2 = x * x + y * y + z * z;
        let cosine = (x * towards.x + y * towards.y + z * towards.z) / length2.sqrt();
        let zero = f32x8::splat(simd, 0.0);
        let cosine = cosine.simd_gt(zero).select(cosine, zero);
        let ambient = light.ambient();
        let mut lit: [f32; 8] = (cosine * (1.0 - ambient) + ambient).into();
        let squares_are_safe =
            length2.simd_gt(f32x8::splat(simd, 1e-30)) & length2.simd_lt(f32x8::splat(simd, 1e30));
        if !squares_are_safe.all_true() {
            let length2: [f32; 8] = length2.into();
            let [wa, wb, wc]: [[f32; 8]; 3] = [
                fragment.weights[0].into(),
                fragment.weights[1].into(),
                fragment.weights[2].into(),
            ];
            for lane in 0..n {
                if !(length2[lane] > 1e-30 && length2[lane] < 1e30) {
                    lit[lane] = odd(triangle, light, *normals, [wa[lane], wb[lane], wc[lane]]);
                }
            }
        }
        lit
    }
}

/// The light on a pixel whose normal is too long or too short to be squared, or none.
#[cold]
fn odd(triangle: &Triangle<'_>, light: &Light, normals: [Vec3; 3], weights: [f32; 3]) -> f32 {
    let outward =
        outward_normal(&triangle.surface, triangle.corners, Some(normals), weights.into());
    lambert(if triangle.front { outward } else { -outward }, light)
}

/// Ambient, and the rest by the cosine between normal and light.
fn lambert(normal: Vec3, light: &Light) -> f32 {
    let cosine = max(normal.dot(light.direction()), 0.0);
    light.ambient() + (1.0 - light.ambient()) * cosine
}

#[cfg(test)]
mod tests {
    use cullet_scene::{AlphaMode, Material, Mesh, Sampler, TextureRef, Wrap};
    use glam::{Affine2, DAffine3, DMat3, DVec3};
    use proptest::prelude::*;

    use super::*;
    use crate::reference;
    use crate::testing::{Random, config, levels, noise, plain};

    const CORNERS: [u32; 3] = [0, 1, 2];

    fn fragment(random: &mut Random) -> Fragment {
        let weights = Vec3::new(random.unit(), random.unit(), random.unit()) + 1e-3;
        let weights = weights / (weights.x + weights.y + weights.z);
        let mut derivative = || {
            let (b, c) = (random.within(-0.2, 0.2), random.within(-0.2, 0.2));
            Vec3::new(-b - c, b, c)
        };
        let weights = weights.as_dvec3();
        Fragment { weights, ddx: derivative(), ddy: derivative() }
    }

    fn list<T>(random: &mut Random, value: impl Fn(&mut Random) -> T) -> Vec<T> {
        (0..3).map(|_| value(random)).collect()
    }

    fn vec3(random: &mut Random, low: f32, high: f32) -> Vec3 {
        Vec3::new(random.within(low, high), random.within(low, high), random.within(low, high))
    }

    fn vec4(random: &mut Random) -> Vec4 {
        vec3(random, 0.0, 1.0).extend(random.unit())
    }

    /// A triangle that needs exactly `needs`.
    fn triangle(needs: Needs, random: &mut Random) -> (Mesh, Material) {
        let uv = |random: &mut Random| Vec2::new(random.within(-1.0, 1.0), random.unit());
        let mut mesh = Mesh {
            positions: list(random, |random| vec3(random, -1.0, 1.0)),
            normals: Some(list(random, |random| vec3(random, -1.0, 1.0) + Vec3::Y * 1.5)),
            uvs: [Some(list(random, uv)), Some(list(random, uv))],
            colors: Some(list(random, vec4)),
            ..Mesh::default()
        };
        let mut material = Material {
            base_color: vec4(random),
            base_color_texture: Some(TextureRef {
                texture: 0,
                uv_set: usize::from(random.unit() < 0.5),
                transform: Some(Affine2::from_cols_array(&std::array::from_fn(|_| {
                    random.within(-1.0, 1.0)
                }))),
            }),
            unlit: !needs.contains(Needs::LIT),
            ..Material::default()
        };
        if !needs.contains(Needs::SMOOTH_NORMAL) {
            mesh.normals = None;
        }
        if !needs.contains(Needs::VERTEX_COLOR) {
            mesh.colors = None;
        }
        if !needs.contains(Needs::UV_TRANSFORM) {
            material.base_color_texture.as_mut().unwrap().transform = None;
        }
        if !needs.contains(Needs::TEXTURE) {
            material.base_color_texture = None;
        }
        if needs.contains(Needs::MASK) {
            material.alpha = AlphaMode::Mask { cutoff: 0.5 };
        }
        (mesh, material)
    }

    fn transform(random: &mut Random) -> DAffine3 {
        let mut axis = || vec3(random, -1.0, 1.0).as_dvec3();
        let matrix = DMat3::from_cols(axis(), axis(), axis()) + DMat3::IDENTITY;
        DAffine3::from_mat3_translation(matrix, DVec3::splat(7.0))
    }

    proptest! {
        #![proptest_config(config(300))]

        #[test]
        fn every_kernel_agrees_with_the_reference(seed: u64) {
            let random = &mut Random::new(seed);
            let sampler = Sampler { wrap_u: Wrap::Mirror, ..Sampler::default() };
            let texture = Texture::new(&noise(6, 5, seed), sampler);
            for needs in (0..64).map(Needs) {
                let (mesh, material) = triangle(needs, random);
                let surface = Surface::new(&mesh, &material, Some(&texture), transform(random));
                let light = Light::new(vec3(random, -1.0, 1.0), random.unit()).unwrap();
                let front = random.unit() < 0.5;
                let fragments = [fragment(random), fragment(random), fragment(random)];
                let mut out = [Vec4::NAN; 3];
                let filter = Filter::Trilinear;
                let seen = Triangle { surface, corners: CORNERS, front };
                let look = Look { light, filter, simd: Level::new() };
                kernel_for(needs)(&seen, &look, Pixels::Each(&fragments), &mut out);
                for (fragment, color) in fragments.iter().zip(out) {
                    let lit = needs.contains(Needs::LIT);
                    let shading = if lit { Shading::Lambert } else { Shading::Unlit };
                    let exact = reference::shade(
                        &surface, CORNERS, front, &light, filter, shading, fragment,
                    );
                    let error = (color.as_dvec4() - exact).abs().max_element();
                    prop_assert!(error <= 1e-5, "{needs:?}: {color} {exact} {error:e}");
                    let exact = reference::base_color(&surface, CORNERS, filter, fragment);
                    let color = base_color(&surface, CORNERS, fragment, filter);
                    let error = (color.as_dvec4() - exact).abs().max_element();
                    prop_assert!(error <= 1e-5, "{needs:?}: {color} {exact} {error:e}");
                    let alpha = alpha(&surface, CORNERS, fragment, filter);
                    prop_assert_eq!(alpha.to_bits(), color.w.to_bits());
                }
            }
        }
    }

    #[test]
    fn a_run_is_its_pixels_one_by_one() {
        let random = &mut Random::new(4);
        let texture = Texture::new(&noise(6, 5, 1), Sampler::default());
        let all = Needs(31);
        let (mesh, material) = triangle(all, random);
        let surface = Surface::new(&mesh, &material, Some(&texture), transform(random));
        let fragments: Vec<_> = (0..50).map(|_| fragment(random)).collect();
        let kernel = kernel_for(all);
        let seen = Triangle { surface, corners: CORNERS, front: true };
        let (light, filter) = (Light::default(), Filter::Trilinear);
        let look = Look { light, filter, simd: Level::new() };
        let mut run = vec![Vec4::ZERO; 50];
        kernel(&seen, &look, Pixels::Each(&fragments), &mut run);
        for (fragment, expected) in fragments.iter().zip(&run) {
            let mut out = [Vec4::ZERO];
            kernel(&seen, &look, Pixels::Each(&[*fragment]), &mut out);
            assert_eq!(out[0], *expected);
        }
        for (name, simd) in levels() {
            let mut other = vec![Vec4::ZERO; 50];
            let look = Look { simd, ..look };
            kernel(&seen, &look, Pixels::Each(&fragments), &mut other);
            assert_eq!(other, run, "{name}");
        }
    }

    #[track_caller]
    fn check(mesh: &Mesh, material: &Material, texture: Option<&Texture>, expected: Vec4) {
        let surface = Surface::new(mesh, material, texture, DAffine3::IDENTITY);
        let weights = DVec3::new(0.25, 0.25, 0.5);
        let fragment = Fragment { weights, ddx: Vec3::ZERO, ddy: Vec3::ZERO };
        let needs = Needs::of(mesh, material, Shading::Lambert);
        let light = Light::new(Vec3::Z, 0.25).unwrap();
        let look = Look { light, filter: Filter::Trilinear, simd: Level::new() };
        let seen = Triangle { surface, corners: CORNERS, front: true };
        let mut out = [Vec4::NAN];
        kernel_for(needs)(&seen, &look, Pixels::Each(&[fragment]), &mut out);
        assert_eq!(out[0], expected);
    }

    fn facing() -> Mesh {
        Mesh { positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y], ..Mesh::default() }
    }

    #[test]
    fn facing_the_light_is_the_base_colour() {
        let base_color = Vec4::new(0.5, 0.25, 1.0, 0.5);
        let material = Material { base_color, ..Material::default() };
        check(&facing(), &material, None, Vec4::new(0.5, 0.25, 1.0, 1.0));
    }

    #[test]
    fn away_from_the_light_and_without_a_normal_is_ambient() {
        let ambient = Vec4::new(0.25, 0.25, 0.25, 1.0);
        let away = Mesh { positions: vec![Vec3::ZERO, Vec3::Y, Vec3::X], ..Mesh::default() };
        check(&away, &Material::default(), None, ambient);
        let point = Mesh { positions: vec![Vec3::ONE; 3], ..Mesh::default() };
        check(&point, &Material::default(), None, ambient);
    }

    #[test]
    fn texture_and_vertex_colours_multiply() {
        let texture = Texture::new(&plain(2, 2, [255, 0, 255, 255]), Sampler::default());
        let material = Material {
            base_color_texture: Some(TextureRef { texture: 0, uv_set: 7, transform: None }),
            ..Material::default()
        };
        let mesh = Mesh { colors: Some(vec![Vec4::splat(0.5); 3]), ..facing() };
        check(&mesh, &material, Some(&texture), Vec4::new(0.5, 0.0, 0.5, 1.0));
        check(&mesh, &material, None, Vec4::new(0.5, 0.5, 0.5, 1.0));
    }

    /// The wide sampler alone: unlit, white, the place at the first corner.
    fn sampled(texture: &Texture, uv: Vec2, ddx: Vec2, ddy: Vec2, simd: Level) -> Vec4 {
        let mesh = Mesh { uvs: [Some(vec![uv, uv + Vec2::X, uv + Vec2::Y]), None], ..facing() };
        let material = Material {
            base_color_texture: Some(TextureRef { texture: 0, uv_set: 0, transform: None }),
            ..Material::default()
        };
        let surface = Surface::new(&mesh, &material, Some(texture), DAffine3::IDENTITY);
        let seen = Triangle { surface, corners: CORNERS, front: true };
        let derivative = |d: Vec2| Vec3::new(-d.x - d.y, d.x, d.y);
        let (ddx, ddy) = (derivative(ddx), derivative(ddy));
        let fragment = Fragment { weights: DVec3::X, ddx, ddy };
        let look = Look { light: Light::default(), filter: Filter::Trilinear, simd };
        let mut out = [Vec4::NAN];
        let kernel = kernel_for(Needs::of(&mesh, &material, Shading::Unlit));
        kernel(&seen, &look, Pixels::Each(&[fragment]), &mut out);
        out[0]
    }

    const WRAPS: [Wrap; 3] = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];

    proptest! {
        #![proptest_config(config(2000))]

        #[test]
        fn every_instruction_set_samples_as_the_reference(
            size in (1..40_u32, 1..40_u32),
            uv in (-3.0..3.0_f32, -3.0..3.0_f32),
            derivatives in prop::array::uniform4(-0.3..0.3_f32),
            scale in 0..12,
            wraps in (0..3_usize, 0..3_usize),
        ) {
            let (wrap_u, wrap_v) = (WRAPS[wraps.0], WRAPS[wraps.1]);
            let sampler = Sampler { wrap_u, wrap_v, ..Sampler::default() };
            let texture = Texture::new(&noise(size.0, size.1, 3), sampler);
            let [a, b, c, d] = derivatives.map(|d| d / (1 << scale) as f32);
            let (uv, ddx, ddy) = (Vec2::from(uv), Vec2::new(a, b), Vec2::new(c, d));
            let [place, ddx64, ddy64] = [uv, ddx, ddy].map(|v| v.as_dvec2());
            let exact = reference::sample(&texture, place, ddx64, ddy64, Filter::Trilinear);
            let color = sampled(&texture, uv, ddx, ddy, Level::new());
            let error = (color.as_dvec4() - exact).truncate().abs().max_element();
            prop_assert!(error < 1e-5, "{color} {exact} {error:e}");
            for (name, level) in levels() {
                prop_assert_eq!(sampled(&texture, uv, ddx, ddy, level), color, "{}", name);
            }
        }
    }

    #[test]
    fn extreme_places_and_sizes_stay_inside() {
        let extremes = [0.0, 1.0, -1e-45, 0.1, 1e9, -1e30, f32::MAX, f32::NEG_INFINITY, f32::NAN];
        for (width, height) in [(1, 1), (1, 5), (16384, 1), (3, 7)] {
            for wrap in WRAPS {
                let sampler = Sampler { wrap_u: wrap, wrap_v: wrap, ..Sampler::default() };
                let texture = Texture::new(&plain(width, height, [255; 4]), sampler);
                for (&u, &d) in extremes.iter().flat_map(|u| extremes.iter().map(move |d| (u, d))) {
                    let (uv, ddx, ddy) = (Vec2::new(u, d), Vec2::new(d, u), Vec2::splat(d));
                    assert_eq!(sampled(&texture, uv, ddx, ddy, Level::new()), Vec4::ONE);
                }
            }
        }
    }
}
