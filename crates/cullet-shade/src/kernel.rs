//! The colour of one fragment, plainly.
//!
//! This is what [`crate::wide`] computes many pixels at a time, from f64 weights and by the code
//! that passes and alpha tests read: its twin, and the way for the few pixels that f32 planes do
//! not serve.
//!
//! Colours are linear RGBA, alpha straight.

use cullet_raster::Fragment;
use fearless_simd::Level;
use glam::{Vec2, Vec3, Vec4};

use crate::division::Division;
use crate::encoding::Encoding;
use crate::light::{Light, PointLight};
use crate::needs::{Needs, Shading};
use crate::sampler::{Arithmetic, Filter, sample, sample_alpha};
use crate::select::max;
use crate::surface::{Surface, corner_uvs, gather, interpolate, outward_normal};
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
    /// A light at a point.
    pub point_light: Option<PointLight>,
    /// How textures are filtered.
    pub filter: Filter,
    /// What numbers they are blended in.
    pub arithmetic: Arithmetic,
    /// How [`crate::wide`] divides and normalises; plain code is always exact.
    pub division: Division,
    /// How bytes are made of colours.
    pub encoding: Encoding,
    /// The instruction set. Never changes a colour.
    pub simd: Level,
}

impl Look {
    /// Exact and trilinear, by the best instruction set there is.
    pub fn new(light: Light) -> Look {
        Look {
            light,
            point_light: None,
            filter: Filter::Trilinear,
            arithmetic: Arithmetic::Float,
            division: Division::Exact,
            encoding: Encoding::Exact,
            simd: Level::new(),
        }
    }
}

/// The colour of a fragment: linear RGB, and alpha 1 in every alpha mode until blending arrives.
/// It reads what `needs` names and nothing else.
pub fn shade(needs: Needs, triangle: &Triangle<'_>, look: &Look, fragment: &Fragment) -> Vec4 {
    let Triangle { surface, corners, front } = triangle;
    let color = BaseColor::gather(needs, surface, *corners).at(fragment, look.filter);
    let mut color = color.truncate();
    if needs.contains(Needs::LIT) {
        let normals = surface.mesh.normals.as_deref();
        let normals = normals.filter(|_| needs.contains(Needs::SMOOTH_NORMAL));
        let normals = normals.map(|normals| gather(normals, *corners));
        let outward = outward_normal(surface, *corners, normals, fragment.weights.as_vec3());
        let normal = if *front { outward } else { -outward };
        let light = lambert(normal, &look.light);
        match look.point_light.filter(|_| needs.contains(Needs::POINT_LIGHT)) {
            None => color *= light,
            Some(point) => {
                let to_light = to_light(&point, surface, *corners, fragment);
                color *= Vec3::splat(light) + point.on(normal, to_light);
            }
        }
    }
    color.extend(1.0)
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

/// The vector to a light from a fragment: in f64, rounded once.
fn to_light(
    light: &PointLight,
    surface: &Surface<'_>,
    corners: [u32; 3],
    fragment: &Fragment,
) -> Vec3 {
    let [a, b, c] = gather(&surface.mesh.positions, corners).map(|corner| corner.as_dvec3());
    let weights = fragment.weights;
    let position = a * weights.x + b * weights.y + c * weights.z;
    light.seen_from(surface.world_from_model.transform_point3(position))
}

/// Ambient, and the rest by the cosine between normal and light.
pub(crate) fn lambert(normal: Vec3, light: &Light) -> f32 {
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
    use crate::testing::{Random, config, noise, plain};

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
            for needs in (0..128).map(Needs) {
                let (mesh, material) = triangle(needs, random);
                let surface = Surface::new(&mesh, &material, Some(&texture), transform(random));
                let light = Light::new(vec3(random, -1.0, 1.0), random.unit()).unwrap();
                let front = random.unit() < 0.5;
                let fragments = [fragment(random), fragment(random), fragment(random)];
                let filter = Filter::Trilinear;
                let seen = Triangle { surface, corners: CORNERS, front };
                let place = DVec3::splat(7.0) + vec3(random, -2.0, 2.0).as_dvec3();
                let radius = [0.0, 1.0, 5.0, f32::INFINITY][(seed % 4) as usize];
                let point = PointLight::new(place, vec3(random, 0.0, 3.0), radius).unwrap();
                let has_point = needs.contains(Needs::LIT.with(Needs::POINT_LIGHT));
                let point_light = has_point.then_some(point);
                let look = Look { point_light, filter, ..Look::new(light) };
                for fragment in &fragments {
                    let color = shade(needs, &seen, &look, fragment);
                    let lit = needs.contains(Needs::LIT);
                    let shading = if lit { Shading::Lambert } else { Shading::Unlit };
                    let exact =
                        reference::shade(&surface, CORNERS, front, &look, shading, fragment);
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

    #[track_caller]
    fn check(mesh: &Mesh, material: &Material, texture: Option<&Texture>, expected: Vec4) {
        let surface = Surface::new(mesh, material, texture, DAffine3::IDENTITY);
        let weights = DVec3::new(0.25, 0.25, 0.5);
        let fragment = Fragment { weights, ddx: Vec3::ZERO, ddy: Vec3::ZERO };
        let needs = Needs::of(mesh, material, Shading::Lambert);
        let light = Light::new(Vec3::Z, 0.25).unwrap();
        let (point_light, filter) = (None, Filter::Trilinear);
        let look = Look { point_light, filter, ..Look::new(light) };
        let seen = Triangle { surface, corners: CORNERS, front: true };
        assert_eq!(shade(needs, &seen, &look, &fragment), expected);
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
}
