//! Flattened and mirrored nodes, odd images and coordinates, denormals (numerics 4, items 9, 11
//! and 14).

use glam::{Affine2, DAffine3, DVec3, Vec2, Vec3};

use super::super::build::{Builder, at, scaled, tilted, turned};
use super::super::shapes::{self, quad};
use super::super::textures::hash;
use super::{lens, look};
use crate::{Image, Material, Mesh, Sampler, Scene, Wrap};

const INF: f64 = f64::INFINITY;

/// A ball flattened along each axis: discs, lit like any surface; of the fourth nothing is left.
pub fn flattened(ordinary: bool) -> Scene {
    let mut builder = Builder::new("extreme");
    let clay = builder.plain("clay", [0.7, 0.45, 0.3]);
    let ball = builder.mesh("ball", shapes::sphere(32));
    let zero = if ordinary { 0.5 } else { 0.0 };
    let scales = [[zero, 1.0, 1.0], [1.0, zero, 1.0], [1.0, 1.0, zero], [zero, zero, zero]];
    for (k, [x, y, z]) in scales.into_iter().enumerate() {
        let place = at(2.0 * k as f64 - 3.0, 0.0, 0.0) * turned(35.0) * tilted(25.0);
        builder.place(&format!("ball {k}"), None, place * scaled(x, y, z), (ball, clay));
    }
    look(&mut builder, [1.0, 1.5, 6.5], [0.0; 3], lens(45.0, 0.05, INF));
    builder.finish()
}

/// A knot in mirrored nodes above; below, the same with the mirroring in its vertices.
pub fn mirrored(ordinary: bool) -> Scene {
    let mut builder = Builder::new("extreme");
    let paint = builder.plain("paint", [0.8, 0.5, 0.2]);
    let knot = shapes::torus_knot((2, 3), 0.15, (96, 10));
    let mesh = builder.mesh("knot", knot.clone());
    let signs: [[f64; 3]; 4] =
        [[-1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, -1.0], [-1.0, -1.0, -1.0]];
    for (k, sign) in signs.into_iter().enumerate() {
        let [x, y, z] = if ordinary { [1.0; 3] } else { sign };
        let turn = turned(20.0) * tilted(60.0) * scaled(0.6, 0.6, 0.6);
        let column = 2.0 * k as f64 - 3.0;
        let above = at(column, 0.95, 0.0) * turn * scaled(x, y, z);
        builder.place(&format!("node {k}"), None, above, (mesh, paint));
        let baked = baked(&knot, DVec3::new(x, y, z).as_vec3());
        builder.single(&format!("mesh {k}"), at(column, -0.95, 0.0) * turn, baked, paint);
    }
    look(&mut builder, [0.0, 0.0, 7.0], [0.0; 3], lens(40.0, 0.05, INF));
    builder.finish()
}

/// The mesh with the signs of `sign`, outside still out.
fn baked(mesh: &Mesh, sign: Vec3) -> Mesh {
    let mut mesh = mesh.clone();
    mesh.positions.iter_mut().for_each(|p| *p *= sign);
    mesh.normals.iter_mut().flatten().for_each(|n| *n *= sign);
    if sign.x * sign.y * sign.z < 0.0 {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    mesh
}

/// Eight squares: images of extreme shapes above, extreme coordinates below.
pub fn textures(ordinary: bool) -> Scene {
    let mut builder = Builder::new("extreme");
    let square = quad();
    let cases: [([u32; 2], f32); 8] = [
        ([1, 1], 1.0),
        ([1, 7], 1.0),
        ([3, 5], 1.0),
        ([16384, 1], 1.0),
        ([8, 8], -3.0),
        ([8, 8], 1e6),
        ([8, 8], 1e30),
        ([8, 8], -1e30),
    ];
    for (k, (size, repeat)) in cases.into_iter().enumerate() {
        let (size, repeat) = if ordinary { ([64, 64], 1.0) } else { (size, repeat) };
        let wrap = if k == 7 { Wrap::Clamp } else { Wrap::Repeat };
        let sampler = Sampler { wrap_u: wrap, wrap_v: wrap, ..Sampler::default() };
        let mut texture = builder.texture(noise(size, k as u32), sampler);
        // One by the coordinates themselves, one by a transform of them.
        if k == 6 && !ordinary {
            texture.transform = Some(Affine2::from_scale(Vec2::splat(repeat)));
        }
        let mut mesh = square.clone();
        if k != 6 {
            mesh.uvs[0].iter_mut().flatten().for_each(|uv| *uv *= repeat);
        }
        let name = format!("{}x{}, {repeat:e} times", size[0], size[1]);
        let material = builder.material(Material {
            name: name.clone(),
            base_color_texture: Some(texture),
            ..Material::default()
        });
        let (x, y) = (2.3 * (k % 4) as f64 - 3.45, 1.15 - 2.3 * (k / 4) as f64);
        builder.single(&name, at(x, y, 0.0), mesh, material);
    }
    look(&mut builder, [0.0, 0.0, 6.6], [0.0; 3], lens(45.0, 0.05, INF));
    builder.finish()
}

/// Texels of any colour.
fn noise([width, height]: [u32; 2], seed: u32) -> Image {
    let texel = |i: u32| {
        let (x, y) = (i % width, i / width);
        let tone = |channel: u32| (255.0 * hash(x, y, 3 * seed + channel)) as u8;
        [tone(0), tone(1), tone(2), 255]
    };
    let rgba = (0..width * height).flat_map(texel).collect();
    Image { name: format!("noise {seed}"), width, height, rgba, ..Image::default() }
}

/// A sphere of denormal numbers, which keep 9 bits and less; two nodes bring it to size.
pub fn denormals(ordinary: bool) -> Scene {
    let mut builder = Builder::new("extreme");
    let clay = builder.plain("clay", [0.7, 0.45, 0.3]);
    let tiny = if ordinary { 1.0 } else { libm::exp2(-140.0) };
    let mut sphere = shapes::sphere(64);
    sphere.positions.iter_mut().for_each(|p| *p = (p.as_dvec3() * tiny).as_vec3());
    let up = if ordinary { 1.0 } else { libm::exp2(70.0) };
    let outer = builder.node("up", None, scaled(up, up, up));
    let inner = builder.node("up again", Some(outer), scaled(up, up, up));
    let mesh = builder.mesh("sphere", shapes::flat(sphere));
    builder.place("sphere", Some(inner), DAffine3::IDENTITY, (mesh, clay));
    look(&mut builder, [0.0, 0.8, 3.2], [0.0; 3], lens(45.0, 0.05, INF));
    builder.finish()
}
