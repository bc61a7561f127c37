//! The plain twin: the same colours in f64, with nothing specialised and nothing shared.
//!
//! Textures keep their texels in 16 bits, so the levels of a [`Texture`] are common ground; [`mips`]
//! judges those.

use cullet_raster::Fragment;
use cullet_scene::{Image, Wrap};
use glam::{DMat2, DMat3, DVec2, DVec3, DVec4};

use crate::kernel::Look;
use crate::light::PointLight;
use crate::needs::Shading;
use crate::sampler::Filter;
use crate::srgb::decode_exact;
use crate::surface::Surface;
use crate::texture::{Level, Texture};

/// Twin of the kernels: linear RGB, alpha 1.
pub fn shade(
    surface: &Surface<'_>,
    corners: [u32; 3],
    front: bool,
    look: &Look,
    shading: Shading,
    fragment: &Fragment,
) -> DVec4 {
    let Look { light, point_light, filter, .. } = look;
    let color = base_color(surface, corners, *filter, fragment).truncate();
    if shading == Shading::Unlit {
        return color.extend(1.0);
    }
    let normal = world_normal(surface, corners, front, fragment);
    let ambient = f64::from(light.ambient());
    let cosine = normal.dot(light.direction().as_dvec3()).max(0.0);
    let mut sum = DVec3::splat(ambient + (1.0 - ambient) * cosine);
    if let Some(light) = point_light {
        let position =
            blend(corners, fragment.weights, |corner| surface.mesh.positions[corner].as_dvec3());
        sum += point(light, normal, surface.world_from_model.transform_point3(position));
    }
    (color * sum).extend(1.0)
}

/// What a light adds at a place in the world.
fn point(light: &PointLight, normal: DVec3, position: DVec3) -> DVec3 {
    let to_light = light.position() - position;
    let (distance, radius) = (to_light.length(), f64::from(light.radius()));
    if distance == 0.0 || distance >= radius {
        return DVec3::ZERO;
    }
    let cosine = normal.dot(to_light / distance).max(0.0);
    let window = (1.0 - (distance / radius).powi(4)).powi(2);
    light.color().as_dvec3() * cosine * window / (distance * distance + 1.0)
}

/// Twin of [`crate::base_color`].
pub fn base_color(
    surface: &Surface<'_>,
    corners: [u32; 3],
    filter: Filter,
    fragment: &Fragment,
) -> DVec4 {
    let mut color = surface.material.base_color.as_dvec4();
    if let (Some(used), Some(texture)) = (&surface.material.base_color_texture, surface.texture) {
        let uv = |weights: DVec3| match &surface.mesh.uvs[used.uv_set] {
            Some(uvs) => blend(corners, weights, |corner| uvs[corner].as_dvec2()),
            None => DVec2::ZERO,
        };
        let (mut place, mut ddx, mut ddy) =
            (uv(fragment.weights), uv(fragment.ddx.as_dvec3()), uv(fragment.ddy.as_dvec3()));
        if let Some(transform) = used.transform {
            let axes = transform.matrix2.to_cols_array().map(f64::from);
            let matrix = DMat2::from_cols_array(&axes);
            place = matrix * place + transform.translation.as_dvec2();
            (ddx, ddy) = (matrix * ddx, matrix * ddy);
        }
        color *= sample(texture, place, ddx, ddy, filter);
    }
    if let Some(colors) = &surface.mesh.colors {
        color *= blend(corners, fragment.weights, |corner| colors[corner].as_dvec4());
    }
    color
}

/// Twin of [`crate::world_normal`], through the inverse transpose, so for invertible
/// transforms only.
pub fn world_normal(
    surface: &Surface<'_>,
    corners: [u32; 3],
    front: bool,
    fragment: &Fragment,
) -> DVec3 {
    let [a, b, c] = corners.map(|corner| surface.mesh.positions[corner as usize].as_dvec3());
    let flat = (b - a).cross(c - a);
    let smooth = surface
        .mesh
        .normals
        .as_ref()
        .map(|normals| blend(corners, fragment.weights, |corner| normals[corner].as_dvec3()));
    let normal_model = smooth.filter(|n| n.is_finite() && *n != DVec3::ZERO).unwrap_or(flat);
    let matrix: DMat3 = surface.world_from_model.matrix3.inverse().transpose();
    let outward = (matrix * normal_model).normalize_or_zero();
    if front { outward } else { -outward }
}

/// Twin of [`crate::sample`].
pub fn sample(texture: &Texture, uv: DVec2, duvdx: DVec2, duvdy: DVec2, filter: Filter) -> DVec4 {
    let mips = &texture.mips;
    let lod = lod(texture, duvdx, duvdy, filter);
    let nearest_level = &mips.level((lod + 0.5).ceil() as usize - 1);
    match filter {
        Filter::Nearest => nearest(nearest_level, texture.wrap, uv),
        Filter::Bilinear => bilinear(nearest_level, texture.wrap, uv),
        Filter::Anisotropic => {
            let (n, axis, ddx, ddy) = stretch(texture, duvdx, duvdy);
            let piece = |i| uv + axis * ((f64::from(i) + 0.5) / f64::from(n) - 0.5);
            let color = |i| sample(texture, piece(i), ddx, ddy, Filter::Trilinear);
            (0..n).map(color).sum::<DVec4>() / f64::from(n)
        }
        Filter::Trilinear | Filter::TrilinearLog | Filter::Oversampled(_) => {
            let finer = bilinear(&mips.level(lod.floor() as usize), texture.wrap, uv);
            let coarser = bilinear(&mips.level(lod.ceil() as usize), texture.wrap, uv);
            let by_length = filter != Filter::TrilinearLog;
            let share = if by_length { libm::exp2(lod.fract()) - 1.0 } else { lod.fract() };
            finer.lerp(coarser, share)
        }
    }
}

/// Pieces of a footprint along its longer axis, that axis, and the footprint of a piece's length.
pub fn stretch(texture: &Texture, duvdx: DVec2, duvdy: DVec2) -> (u32, DVec2, DVec2, DVec2) {
    let base = texture.mips.level(0);
    let size = DVec2::new(f64::from(base.width()), f64::from(base.height()));
    let (x, y) = ((duvdx * size).length(), (duvdy * size).length());
    let n = (x.max(y) / x.min(y).max(1.0)).round().clamp(1.0, 16.0);
    (n as u32, if x > y { duvdx } else { duvdy }, duvdx / n, duvdy / n)
}

/// Whether rounding cannot change the number of pieces.
#[cfg(test)]
pub(crate) fn pieces_are_clear(texture: &Texture, duvdx: DVec2, duvdy: DVec2) -> bool {
    let pieces = |factor: f64| {
        let of = |x: f64, y: f64| stretch(texture, duvdx * x, duvdy * y).0;
        (of(factor, 1.0), of(1.0, factor))
    };
    pieces(1.0 - 1e-5) == pieces(1.0 + 1e-5)
}

/// Level of detail as its logarithm, clamped to the levels there are.
pub fn lod(texture: &Texture, duvdx: DVec2, duvdy: DVec2, filter: Filter) -> f64 {
    let base = texture.mips.level(0);
    let size = DVec2::new(f64::from(base.width()), f64::from(base.height()));
    let longer = (duvdx * size).length().max((duvdy * size).length());
    let side = f64::from(filter.area()).sqrt();
    libm::log2(longer * side).clamp(0.0, (texture.mips.n_levels() - 1) as f64)
}

/// All levels of an image, linear RGBA, from the areas that their texels cover.
pub fn mips(image: &Image) -> Vec<Vec<[f64; 4]>> {
    let (mut width, mut height) = (image.width as usize, image.height as usize);
    let texel = |bytes: &[u8; 4]| decode_bytes(*bytes).to_array();
    let mut levels = vec![image.rgba.as_chunks().0.iter().map(texel).collect::<Vec<_>>()];
    while width > 1 || height > 1 {
        let (w, h) = ((width / 2).max(1), (height / 2).max(1));
        let larger = &levels[levels.len() - 1];
        let mut level = Vec::new();
        for (x, y) in (0..w * h).map(|i| (i % w, i / w)) {
            let mut sum = [0.0; 4];
            for (source_x, source_y) in (0..width * height).map(|i| (i % width, i / width)) {
                let area = overlap(x, w, source_x, width) * overlap(y, h, source_y, height);
                for (sum, channel) in sum.iter_mut().zip(larger[source_y * width + source_x]) {
                    *sum += area * channel;
                }
            }
            level.push(sum.map(|channel| channel * (w * h) as f64));
        }
        (width, height) = (w, h);
        levels.push(level);
    }
    levels
}

/// Common length of interval `i` of `n` and interval `j` of `m` of the unit interval.
fn overlap(i: usize, n: usize, j: usize, m: usize) -> f64 {
    let low = (i as f64 / n as f64).max(j as f64 / m as f64);
    let high = ((i + 1) as f64 / n as f64).min((j + 1) as f64 / m as f64);
    (high - low).max(0.0)
}

fn nearest(level: &Level<'_>, wrap: [Wrap; 2], uv: DVec2) -> DVec4 {
    let x = (uv.x * f64::from(level.width())).floor();
    let y = (uv.y * f64::from(level.height())).floor();
    texel(level, wrap, x, y)
}

fn bilinear(level: &Level<'_>, wrap: [Wrap; 2], uv: DVec2) -> DVec4 {
    let x = uv.x * f64::from(level.width()) - 0.5;
    let y = uv.y * f64::from(level.height()) - 0.5;
    let (left, top) = (x.floor(), y.floor());
    let row = |y| texel(level, wrap, left, y).lerp(texel(level, wrap, left + 1.0, y), x - left);
    row(top).lerp(row(top + 1.0), y - top)
}

/// The texel that texel `x`, `y` of the endless plane shows.
fn texel(level: &Level<'_>, wrap: [Wrap; 2], x: f64, y: f64) -> DVec4 {
    let (x, y) = (wrapped(x, level.width(), wrap[0]), wrapped(y, level.height(), wrap[1]));
    DVec4::from_array(level.texel(x, y).map(|steps| f64::from(steps) / 65535.0))
}

fn wrapped(i: f64, n: u32, wrap: Wrap) -> u32 {
    let n = f64::from(n);
    let wrapped = match wrap {
        Wrap::Repeat => i.rem_euclid(n),
        Wrap::Mirror => {
            let i = i.rem_euclid(2.0 * n);
            if i < n { i } else { 2.0 * n - 1.0 - i }
        }
        Wrap::Clamp => i.clamp(0.0, n - 1.0),
    };
    wrapped as u32
}

fn decode_bytes([r, g, b, a]: [u8; 4]) -> DVec4 {
    let [r, g, b, a] = [r, g, b, a].map(|byte| f64::from(byte) / 255.0);
    DVec4::new(decode_exact(r), decode_exact(g), decode_exact(b), a)
}

fn blend<T>(corners: [u32; 3], weights: DVec3, value: impl Fn(usize) -> T) -> T
where
    T: std::ops::Mul<f64, Output = T> + std::ops::Add<Output = T>,
{
    let [a, b, c] = corners.map(|corner| value(corner as usize));
    a * weights.x + b * weights.y + c * weights.z
}
