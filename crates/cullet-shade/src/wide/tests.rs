//! Wide code against the plain code, and against itself in other groups.

use cullet_raster::{BLOCK, Interpolator, Placement, SubpixelBits};
use cullet_scene::{Material, Mesh, Sampler, TextureRef, Wrap};
use cullet_transform::{Camera, ClipPoint, PlaneMask, Projection, View, Viewport};
use fearless_simd::{Level, Simd, dispatch};
use glam::{DAffine3, DVec3, Vec2, Vec3, Vec4};
use proptest::prelude::*;

use super::column::{Column, ROOM};
use super::*;
use crate::reference;
use crate::testing::{Random, config, levels, noise, plain};
use crate::{
    Arithmetic, Division, Filter, Light, Look, Needs, PointLight, Shading, Surface, Texture,
    Triangle, shade,
};

const WRAPS: [Wrap; 3] = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];
const SIZE: u32 = 128;

fn look(filter: Filter, simd: Level) -> Look {
    Look { filter, simd, ..Look::new(Light::default()) }
}

fn textured(transform: Option<glam::Affine2>) -> Material {
    let base_color_texture = Some(TextureRef { texture: 0, uv_set: 0, transform });
    Material { base_color_texture, ..Material::default() }
}

/// The sampler alone: unlit, white, at a place given by its planes.
fn sampled(texture: &Texture, uv: Vec2, ddx: Vec2, ddy: Vec2, filter: Filter, simd: Level) -> Vec4 {
    sampled_by(texture, uv, [ddx, ddy], &look(filter, simd))
}

/// [`sampled`], in any arithmetic.
fn sampled_by(texture: &Texture, uv: Vec2, [ddx, ddy]: [Vec2; 2], look: &Look) -> Vec4 {
    let (mesh, material) = (Mesh::default(), textured(None));
    let surface = Surface::new(&mesh, &material, Some(texture), DAffine3::IDENTITY);
    let record = Record {
        at: [1.0, uv.x, uv.y, 0.0, 0.0, 0.0, 0.0, 0.0],
        ddx: [0.0, ddx.x, ddx.y, 0.0, 0.0, 0.0, 0.0, 0.0],
        ddy: [0.0, ddy.x, ddy.y, 0.0, 0.0, 0.0, 0.0, 0.0],
    };
    let mut out = [Vec4::NAN];
    let of = Paint::new(&surface, Needs::TEXTURE, look);
    let mut left = Vec::new();
    let run = Run::new(0, [0; 2], 1, 0);
    let scratch = &mut Scratch::default();
    let planes = Planes { records: &[record], colors: &[], points: &[] };
    paint(&of, &[run], &planes, scratch, &mut Out::Linear(&mut out), &mut left);
    assert!(left.is_empty());
    out[0]
}

/// What footprints of the same length get.
fn levels_of(sampler: &sampler::Sampler<'_>, ddx: Vec2, ddy: Vec2, level: Level) -> Vec<f32> {
    #[inline(always)]
    fn of<S: Simd>(simd: S, sampler: &sampler::Sampler<'_>, ddx: Vec2, ddy: Vec2) -> Vec<f32> {
        wide!(S, groups_of(simd, sampler, ddx, ddy))
    }
    #[inline(always)]
    fn groups_of<S: Simd, V: Lanes<S>>(
        simd: S,
        sampler: &sampler::Sampler<'_>,
        ddx: Vec2,
        ddy: Vec2,
    ) -> Vec<f32> {
        let ddx = [V::splat(simd, ddx.x), V::splat(simd, ddx.y)];
        let ddy = [V::splat(simd, ddy.x), V::splat(simd, ddy.y)];
        sampler.levels(simd, sampler.footprint::<S, V>(ddx, ddy)).as_slice().to_vec()
    }
    dispatch!(level, simd => of(simd, sampler, ddx, ddy))
}

#[test]
fn levels_of_detail_are_those_of_the_plain_code() {
    let texture = Texture::new(&noise(64, 64, 5), Sampler::default());
    let filters =
        [Filter::Bilinear, Filter::Trilinear, Filter::TrilinearLog, Filter::Oversampled(3)];
    // Lengths in texels around each level and each middle between two, and what is no length.
    let marks = (-4..9).flat_map(|i| [1.0, 1.5, 2.0_f32.sqrt()].map(|l| l * 2.0_f32.powi(i)));
    let around = marks.flat_map(|l: f32| (0..7).map(move |d| f32::from_bits(l.to_bits() - 3 + d)));
    let extremes = [0.0, 1e-45, 1e-30, 1e19, 1e38, f32::MAX, f32::INFINITY, f32::NAN];
    for (length, filter) in around.chain(extremes).flat_map(|l| filters.map(|f| (l, f))) {
        let sampler = sampler::Sampler::new(&texture, filter, Arithmetic::Float).unwrap();
        let side = length / 64.0;
        let along = [(Vec2::X, Vec2::ZERO), (Vec2::Y, Vec2::X), (Vec2::ONE, Vec2::Y)];
        for (ddx, ddy) in along.map(|(x, y)| (x * side, y * side)) {
            let plain = crate::sampler::lod(&texture, ddx, ddy, filter);
            assert!((0.0..=6.0).contains(&plain));
            for (name, level) in levels() {
                let wide = levels_of(&sampler, ddx, ddy, level);
                assert!(wide.iter().all(|wide| *wide == plain), "{name} {filter:?} {length}");
            }
        }
    }
}

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
        let lod = reference::lod(&texture, ddx64, ddy64, Filter::Trilinear);
        let level_is_clear = (lod.fract() - 0.5).abs() > 1e-5;
        let blended = [
            Filter::Trilinear,
            Filter::TrilinearLog,
            Filter::Oversampled(1),
            Filter::Oversampled(4),
        ];
        let others = [Filter::Nearest, Filter::Bilinear, Filter::Anisotropic];
        for filter in others.into_iter().chain(blended) {
            let is_clear = match filter {
                Filter::Nearest | Filter::Bilinear => level_is_clear,
                Filter::Anisotropic => reference::pieces_are_clear(&texture, ddx64, ddy64),
                _ => true,
            };
            if !is_clear {
                continue;
            }
            let exact = reference::sample(&texture, place, ddx64, ddy64, filter);
            let color = sampled(&texture, uv, ddx, ddy, filter, Level::new());
            let error = (color.as_dvec4() - exact).truncate().abs().max_element();
            // Samples along a footprint lie at f32 sums, off by a part of a texel more.
            let most = if filter == Filter::Anisotropic { 3e-5 } else { 1e-5 };
            prop_assert!(error < most, "{filter:?} {color} {exact} {error:e}");
            for (name, level) in levels() {
                let other = sampled(&texture, uv, ddx, ddy, filter, level);
                prop_assert_eq!(other, color, "{}", name);
            }
            if filter == Filter::Nearest {
                continue;
            }
            for arithmetic in [Arithmetic::Sixteen, Arithmetic::Eight] {
                let look = Look { arithmetic, ..look(filter, Level::new()) };
                let color = sampled_by(&texture, uv, [ddx, ddy], &look);
                let error = (color.as_dvec4() - exact).truncate().abs().max_element();
                let bound = f64::from(arithmetic.error()) + 1e-5;
                prop_assert!(error < bound, "{arithmetic:?} {filter:?} {color} {exact} {error:e}");
                for (name, simd) in levels() {
                    let other = sampled_by(&texture, uv, [ddx, ddy], &Look { simd, ..look });
                    prop_assert_eq!(other, color, "{}", name);
                }
            }
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
                for filter in [Filter::Bilinear, Filter::Trilinear, Filter::Anisotropic] {
                    let color = sampled(&texture, uv, ddx, ddy, filter, Level::new());
                    assert_eq!(color, Vec4::ONE);
                }
            }
        }
    }
}

/// The first and the last texel are neighbours where the picture repeats, however the place is
/// rounded.
#[test]
fn texels_meet_across_the_border() {
    let image = cullet_scene::Image {
        width: 2,
        height: 1,
        rgba: vec![0, 0, 0, 255, 255, 255, 255, 255],
        ..Default::default()
    };
    let texture = Texture::new(&image, Sampler::default());
    for (u, expected) in [(0.0, 0.5), (1.0, 0.5), (-0.125, 0.75), (0.125, 0.25), (0.25, 0.0)] {
        let uv = Vec2::new(u, 0.5);
        let color = sampled(&texture, uv, Vec2::ZERO, Vec2::ZERO, Filter::Bilinear, Level::new());
        assert!((color.x - expected).abs() < 1e-6, "{u}: {color}");
    }
    for u in [0.25_f32.next_down(), 0.25_f32.next_up(), -1e-9, 1e-9] {
        let uv = Vec2::new(u, -1e-9);
        let color = sampled(&texture, uv, Vec2::ZERO, Vec2::ZERO, Filter::Bilinear, Level::new());
        let exact = reference::sample(
            &texture,
            uv.as_dvec2(),
            glam::DVec2::ZERO,
            glam::DVec2::ZERO,
            Filter::Bilinear,
        );
        assert!((f64::from(color.x) - exact.x).abs() < 1e-6, "{u}: {color}");
    }
}

/// Everything a triangle can ask for.
fn mesh(random: &mut Random, corners: [Vec3; 3]) -> Mesh {
    let list = |random: &mut Random, low, high| -> Vec<Vec4> {
        (0..3).map(|_| Vec4::from_array([0; 4].map(|_| random.within(low, high)))).collect()
    };
    let offset = Vec2::new(random.within(-50.0, 50.0), random.within(-50.0, 50.0));
    let uvs = list(random, -1.0, 1.0);
    let normals = list(random, -1.0, 1.0);
    Mesh {
        positions: corners.to_vec(),
        triangles: vec![[0, 1, 2]],
        normals: Some(normals.iter().map(|n| n.truncate() + Vec3::Y * 1.5).collect()),
        uvs: [Some(uvs.iter().map(|uv| uv.truncate().truncate() + offset).collect()), None],
        colors: Some(list(random, 0.0, 1.0)),
        ..Mesh::default()
    }
}

fn view() -> View {
    let lens = Projection::Perspective { yfov: 1.0, near: 0.1, far: f64::INFINITY };
    let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, lens).unwrap();
    View::new(&camera, Viewport::new(SIZE, SIZE).unwrap())
}

/// One triangle as wide code and plain code see it at `places`, px of the whole picture.
struct Seen<'a> {
    surface: Surface<'a>,
    needs: Needs,
    view: View,
    planes: PlaneMask,
    bits: SubpixelBits,
}

impl Seen<'_> {
    fn wide(&self, places: &[[f32; 2]], look: &Look) -> (Vec<Vec4>, Vec<u32>) {
        self.wide_in_runs(1, places, look)
    }

    /// With neighbours in runs of up to so many.
    fn wide_in_runs(&self, most: u32, places: &[[f32; 2]], look: &Look) -> (Vec<Vec4>, Vec<u32>) {
        let mut out = vec![Vec4::NAN; places.len()];
        let mut all_left = Vec::new();
        let clip_from_model = self.view.clip_from_model(&self.surface.world_from_model);
        let placement =
            Placement::new(clip_from_model, self.view.viewport(), self.planes, self.bits);
        let block_of = |place: &[f32; 2]| place.map(|at| at as u32 / BLOCK * BLOCK);
        let mut blocks: Vec<[u32; 2]> = places.iter().map(block_of).collect();
        blocks.sort();
        blocks.dedup();
        for block in blocks {
            let group = Group {
                surface: self.surface,
                placement: &placement,
                needs: self.needs,
                mirrored: false,
                light: look.light,
                point_light: look.point_light.filter(|_| self.needs.contains(Needs::POINT_LIGHT)),
                block,
            };
            let (mut record, mut colors) = ([Record::default()], [ColorPlanes::default()]);
            let mut points = [PointPlanes::default()];
            set_up(look.simd, &group, &[(0, 0)], &mut record, &mut colors, &mut points);
            let mut runs: Vec<Run> = Vec::new();
            for (out, place) in (0..).zip(places).filter(|(_, place)| block_of(place) == block) {
                let [x, y] = [0, 1].map(|axis| place[axis] - block[axis] as f32);
                let next = Run::new(0, [x, y].map(|at| (16.0 * at) as u32), 1, out);
                match runs.last_mut() {
                    Some(run) if run.len < most && is_next(run, &next) => run.len += 1,
                    _ => runs.push(next),
                }
            }
            let of = Paint::new(&self.surface, self.needs, look);
            let mut left = Vec::new();
            let (scratch, out) = (&mut Scratch::default(), &mut Out::Linear(&mut out));
            let planes = Planes { records: &record, colors: &colors, points: &points };
            paint(&of, &runs, &planes, scratch, out, &mut left);
            all_left.extend(left.iter().map(|run| run.out));
        }
        (out, all_left)
    }

    fn interpolator(&self) -> Interpolator {
        let clip_from_model = self.view.clip_from_model(&self.surface.world_from_model);
        let corners = [0, 1, 2].map(|i| {
            let position = self.surface.mesh.positions[i].as_dvec3();
            ClipPoint::from_model(&clip_from_model, position)
        });
        self.bits.interpolator(self.view.viewport(), &corners, self.planes)
    }

    fn plain(&self, place: [f32; 2], look: &Look) -> Vec4 {
        let interpolator = self.interpolator();
        let front = !interpolator.is_clockwise();
        let triangle = Triangle { surface: self.surface, corners: [0, 1, 2], front };
        shade(self.needs, &triangle, look, &interpolator.fragment_at(place.map(f64::from)))
    }

    /// Pixel centres well inside the triangle, in front of the eye.
    fn inside(&self) -> Vec<[f32; 2]> {
        let interpolator = self.interpolator();
        let centres = (0..SIZE * SIZE).map(|i| [i % SIZE, i / SIZE].map(|at| at as f32 + 0.5));
        centres
            .filter(|place| {
                let fragment = interpolator.fragment_at(place.map(f64::from));
                let [a, b, c] = [0, 1, 2].map(|i| {
                    let position = self.surface.mesh.positions[i].as_dvec3();
                    fragment.weights[i] * position.z
                });
                // Where all shares are negative, behind the eye, weights are a third each.
                let is_there = fragment.weights != DVec3::splat(1.0 / 3.0);
                is_there && fragment.weights.min_element() > 0.0 && a + b + c < -0.1
            })
            .collect()
    }
}

/// Whether a pixel is the one after a run.
fn is_next(run: &Run, pixel: &Run) -> bool {
    let ([x, y], len) = (run.place(), run.len);
    [x + 16 * len, y] == pixel.place() && run.out + len == pixel.out
}

/// Errors of colours, of the order of those of attributes relative to their range.
fn errors(name: &str, n: usize, corners: impl Fn(&mut Random) -> [Vec3; 3]) -> Vec<f32> {
    let random = &mut Random::new(7);
    let (mut errors, mut n_left) = (Vec::new(), 0);
    for i in 0..n {
        let corners = corners(random);
        let mesh = mesh(random, corners);
        // Smooth textures, so that a colour tells where it was sampled and not more.
        let texture = Texture::new(&noise(2, 2, i as u64), Sampler::default());
        let material = textured(None);
        let surface = Surface::new(&mesh, &material, Some(&texture), DAffine3::IDENTITY);
        let all = Needs::of(&mesh, &material, Shading::Lambert);
        let unlit = Needs::of(&mesh, &material, Shading::Unlit);
        let lit = [all, Needs::LIT].map(|needs| needs.with(Needs::POINT_LIGHT));
        let some = [all, unlit, Needs::TEXTURE, Needs::LIT, Needs::VERTEX_COLOR, lit[0], lit[1]];
        for needs in some {
            let bits = SubpixelBits::ALL[(i + 1) % 4];
            let seen = Seen { surface, needs, view: view(), planes: PlaneMask::ALL, bits };
            let mut places = seen.inside();
            places.truncate(200);
            // So weak that colours are off by no more than places are.
            let place = corners[0].as_dvec3() + DVec3::new(0.0, 1.0, 3.0);
            let radius = [4.0, f32::INFINITY][i % 2];
            let light = PointLight::new(place, Vec3::new(0.1, 0.05, 0.02), radius).unwrap();
            let point_light = needs.contains(Needs::POINT_LIGHT).then_some(light);
            let look = Look { point_light, ..look(Filter::Trilinear, Level::new()) };
            let (colors, left) = seen.wide(&places, &look);
            n_left += left.len();
            for (i, (place, color)) in places.iter().zip(&colors).enumerate() {
                if !left.contains(&(i as u32)) {
                    errors.push((*color - seen.plain(*place, &look)).abs().max_element());
                }
            }
        }
    }
    errors.sort_by(f32::total_cmp);
    let len = errors.len();
    assert!(n_left * 50 < len, "{name}: {n_left} of {len} left");
    errors
}

#[track_caller]
fn check_errors(errors: &[f32], p99: f32, worst: f32) {
    assert!(errors.len() > 10_000);
    let found = (errors[errors.len() * 99 / 100], errors[errors.len() - 1]);
    assert!(found.0 <= p99 && found.1 <= worst, "{found:?}");
}

/// Corners around one place of the picture, `spread` apart, at distances `near..far`.
fn seen_corners(random: &mut Random, spread: f32, near: f32, far: f32) -> [Vec3; 3] {
    let middle = [random.within(-0.4, 0.4), random.within(-0.4, 0.4)];
    [0; 3].map(|_| {
        let distance = random.within(near, far);
        let [x, y] = middle.map(|m| (m + random.within(-spread, spread)) * distance);
        Vec3::new(x, y, -distance)
    })
}

#[test]
fn colours_are_those_of_the_plain_code() {
    let large = errors("large", 60, |r| seen_corners(r, 0.7, 0.5, 20.0));
    check_errors(&large, 1e-5, 1e-4);
    let small = errors("small", 4000, |r| seen_corners(r, 0.02, 2.0, 3.0));
    check_errors(&small, 1e-5, 1e-4);
    let cut = errors("cut", 150, |r| {
        [0; 3].map(|_| Vec3::from_array([0; 3].map(|_| r.within(-6.0, 6.0))))
    });
    check_errors(&cut, 1e-5, 1e-4);
}

#[test]
fn groups_and_instruction_sets_change_nothing() {
    let random = &mut Random::new(3);
    let corners =
        [Vec3::new(-3.0, -1.0, -2.0), Vec3::new(4.0, -2.0, -5.0), Vec3::new(0.0, 3.0, -4.0)];
    let mesh = mesh(random, corners);
    let texture = Texture::new(&noise(13, 9, 5), Sampler::default());
    let material = textured(Some(glam::Affine2::from_angle(0.3)));
    let surface = Surface::new(&mesh, &material, Some(&texture), DAffine3::IDENTITY);
    let needs = Needs::of(&mesh, &material, Shading::Lambert).with(Needs::POINT_LIGHT);
    let bits = SubpixelBits::Eight;
    let seen = Seen { surface, needs, view: view(), planes: PlaneMask::ALL, bits };
    let mut places = seen.inside();
    places.truncate(1003);
    let light = PointLight::new(DVec3::new(0.0, 0.0, -1.0), Vec3::ONE, 5.0).unwrap();
    let look = Look { point_light: Some(light), ..look(Filter::Trilinear, Level::new()) };
    let (all, _) = seen.wide(&places, &look);
    for (name, simd) in levels() {
        assert_eq!(seen.wide(&places, &Look { simd, ..look }).0, all, "{name}");
    }
    for (place, color) in places.iter().zip(&all) {
        assert_eq!(seen.wide(&[*place], &look).0[0], *color);
    }
    for (name, simd) in levels() {
        let look = Look { simd, ..look };
        for most in [2, 7, 8, 13, 15, 16, 17, 64] {
            let runs = seen.wide_in_runs(most, &places, &look);
            assert_eq!(runs, seen.wide(&places, &look), "{name} {most}");
        }
        for n in [1, 15, 16, 17, 255, 256, 257] {
            assert_eq!(seen.wide(&places[..n], &look).0, all[..n], "{name} {n}");
        }
    }
    let mut backwards = places.clone();
    backwards.reverse();
    let (mut colors, _) = seen.wide(&backwards, &look);
    colors.reverse();
    assert_eq!(colors, all);
}

#[test]
fn approximate_divisions_are_near_and_the_same_on_every_instruction_set() {
    let random = &mut Random::new(4);
    let corners =
        [Vec3::new(-3.0, -1.0, -2.0), Vec3::new(4.0, -2.0, -5.0), Vec3::new(0.0, 3.0, -4.0)];
    let mesh = mesh(random, corners);
    let texture = Texture::new(&noise(2, 2, 5), Sampler::default());
    let material = textured(None);
    let surface = Surface::new(&mesh, &material, Some(&texture), DAffine3::IDENTITY);
    let all = Needs::of(&mesh, &material, Shading::Lambert).with(Needs::POINT_LIGHT);
    let bits = SubpixelBits::Eight;
    let light = PointLight::new(DVec3::new(0.0, 0.0, -1.0), Vec3::ONE, 5.0).unwrap();
    for needs in [all, Needs::LIT.with(Needs::POINT_LIGHT), Needs::TEXTURE] {
        let seen = Seen { surface, needs, view: view(), planes: PlaneMask::ALL, bits };
        let places = seen.inside();
        let point_light = needs.contains(Needs::POINT_LIGHT).then_some(light);
        let exact = Look { point_light, ..look(Filter::Trilinear, Level::new()) };
        let rough = Look { division: Division::Approximate, ..exact };
        let (colors, left) = seen.wide(&places, &rough);
        assert!(left.len() * 50 < places.len());
        let mut worst: f32 = 0.0;
        for (color, exact) in colors.iter().zip(seen.wide(&places, &exact).0) {
            worst = worst.max((*color - exact).abs().max_element());
        }
        assert!(worst > 0.0 && worst < 1e-4, "{needs:?}: {worst:e}");
        for (name, simd) in levels() {
            assert_eq!(seen.wide(&places, &Look { simd, ..rough }).0, colors, "{name}");
        }
    }
}

/// Red, green and blue of `n` places as [`paint`] has them blended, and as [`sampler::Sampler::blend_all`]
/// has them.
fn blended(
    sampler: &sampler::Sampler<'_>,
    places: &[[f32; 3]; ROOM],
    n: usize,
    level: Level,
) -> [Vec<[f32; 3]>; 2] {
    #[inline(always)]
    fn of<S: Simd>(
        simd: S,
        sampler: &sampler::Sampler<'_>,
        places: &[[f32; 3]; ROOM],
        n: usize,
    ) -> [Vec<[f32; 3]>; 2] {
        wide!(S, groups_of(simd, sampler, places, n))
    }
    #[inline(always)]
    fn groups_of<S: Simd, V: Lanes<S>>(
        simd: S,
        sampler: &sampler::Sampler<'_>,
        places: &[[f32; 3]; ROOM],
        n: usize,
    ) -> [Vec<[f32; 3]>; 2] {
        let [u, v, lod] = [0, 1, 2].map(|number| Column(places.map(|place| place[number])));
        let mut taps = sampler::Taps::default();
        for group in 0..n.div_ceil(V::LEN) {
            let uv: [V; 2] = [u.get(simd, group), v.get(simd, group)];
            sampler.find(simd, uv, lod.get(simd, group), &mut taps, group);
        }
        let mut texels = [[0.0; 4]; ROOM];
        let mut out = [Column::default(); 3];
        sampler.blend_colors::<S, V, false>(simd, &taps, n, &mut texels, &mut out);
        let fast = (0..n).map(|i| [out[0].0[i], out[1].0[i], out[2].0[i]]).collect();
        sampler.blend_all::<S, V, false>(simd, &taps, n, &mut texels);
        [fast, texels[..n].iter().map(|texel| [texel[0], texel[1], texel[2]]).collect()]
    }
    dispatch!(level, simd => of(simd, sampler, places, n))
}

#[test]
fn colours_of_many_are_blended_as_one_by_one() {
    let random = &mut Random::new(7);
    for wrap in WRAPS {
        let wraps = Sampler { wrap_u: wrap, wrap_v: wrap, ..Sampler::default() };
        let texture = Texture::new(&noise(57, 41, 5), wraps);
        let sampler =
            sampler::Sampler::new(&texture, Filter::Trilinear, Arithmetic::Float).unwrap();
        // Whole levels for all, for none, and for some of a group.
        for whole in [1.0, 0.0, 0.5, 0.95] {
            let places: [[f32; 3]; ROOM] = std::array::from_fn(|_| {
                let lod = random.within(0.0, 5.0);
                let lod = if random.unit() < whole { lod.floor() } else { lod };
                [random.within(-2.0, 2.0), random.within(-2.0, 2.0), lod]
            });
            for (name, level) in levels() {
                for n in (1..=33).chain([255, 256]) {
                    let [fast, plain] = blended(&sampler, &places, n, level);
                    assert_eq!(fast, plain, "{name} {wrap:?} {whole} {n}");
                }
            }
        }
    }
}

/// Rows are stored at once; what only begins and ends like one is not.
#[test]
fn bytes_go_where_they_belong() {
    let (mesh, material) = (Mesh::default(), Material::default());
    let surface = Surface::new(&mesh, &material, None, DAffine3::IDENTITY);
    let planes = Planes { records: &[Record::default()], colors: &[], points: &[] };
    for (name, level) in levels() {
        let of = Paint::new(&surface, Needs::NONE, &look(Filter::Trilinear, level));
        for lanes in [8, 16] {
            // From 100 on; places in between are elsewhere, by fives.
            let out = |i: u32| if i.is_multiple_of(lanes - 1) { 100 + i } else { 200 + 5 * i };
            let runs: Vec<Run> = (0..lanes).map(|i| Run::new(0, [8, 8], 1, out(i))).collect();
            let mut bytes = vec![[7; 4]; 400];
            let (scratch, left) = (&mut Scratch::default(), &mut Vec::new());
            paint(&of, &runs, &planes, scratch, &mut Out::Bytes(&mut bytes), left);
            for (place, byte) in (0..).zip(&bytes) {
                let is_written = (0..lanes).any(|i| out(i) == place);
                assert_eq!(*byte, if is_written { [255; 4] } else { [7; 4] }, "{name} {place}");
            }
        }
    }
}
