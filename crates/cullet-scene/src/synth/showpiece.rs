//! A still life on a terrace: the picture on the cover.
//!
//! Everything a material can do so far is in it: repeated and clamped images, cut-out
//! leaves, vertex colours, flat and smooth shading, an unlit sky. Units are metres.

use glam::{DVec3, Vec2, Vec3};

use super::build::{Builder, at, scaled, tilted, turned};
use super::shapes::{
    self, colored, cuboid, cylinder, flat, height_field, joined, lathe, quad, sphere, torus_knot,
};
use super::textures;
use crate::{Material, Mesh, Sampler, Scene, Wrap};

pub(super) fn build() -> Scene {
    let mut builder = Builder::new("showpiece");
    let stones = Stones::new(&mut builder);
    background(&mut builder);
    terrace(&mut builder, &stones);
    arch(&mut builder, &stones);
    columns(&mut builder, &stones);
    statues(&mut builder, &stones);
    crates(&mut builder);
    plants(&mut builder);
    builder.look([5.4, 2.5, 7.4], [-0.35, 1.25, -0.8], 38.0);
    builder.finish()
}

/// Materials that several parts share.
struct Stones {
    brick: usize,
    marble: usize,
    paving: usize,
}

impl Stones {
    fn new(builder: &mut Builder) -> Stones {
        Stones {
            brick: builder.textured("brick", textures::brick(256)),
            marble: builder.textured("marble", textures::marble(256)),
            paving: builder.textured("paving", textures::paving(256)),
        }
    }
}

/// Sky and hills.
fn background(builder: &mut Builder) {
    let clamp_v = Sampler { wrap_v: Wrap::Clamp, ..Sampler::default() };
    let base_color_texture = Some(builder.texture(textures::sky(512), clamp_v));
    let name = "sky".to_owned();
    let sky = builder.material(Material {
        name: name.clone(),
        base_color_texture,
        unlit: true,
        ..Material::default()
    });
    builder.single(&name, scaled(90.0, 90.0, 90.0), dome(), sky);

    let ground = builder.plain("ground", [1.0, 1.0, 1.0]);
    let hills = colored(height_field(88, hill), |position| {
        let rough = textures::clouds(position.as_dvec3().truncate(), 24, 53) as f32;
        let meadow = Vec3::new(0.16, 0.26, 0.07).lerp(Vec3::new(0.30, 0.33, 0.10), rough);
        let rock = Vec3::new(0.32, 0.29, 0.26) * (0.7 + 0.5 * rough);
        let height = position.y * 12.0 + 0.8 * (rough - 0.5);
        let stony = ((height - 0.9) * 2.5).clamp(0.0, 1.0);
        let snowy = ((height - 1.75) * 5.0).clamp(0.0, 1.0);
        meadow.lerp(rock, stony).lerp(Vec3::splat(0.85), snowy)
    });
    let hills = Mesh { uvs: [None, None], ..hills };
    builder.single("hills", at(0.0, -0.6, 0.0) * scaled(70.0, 70.0, 70.0), hills, ground);
}

/// Height over the plain for x and z in -1..1: level in the middle, mountains around.
fn hill(x: f64, z: f64) -> f64 {
    let from_middle = (x * x + z * z).sqrt();
    let rise = ((from_middle - 0.18) * 1.6).clamp(0.0, 1.0);
    let rough = textures::clouds(DVec3::new(0.5 * x + 0.5, 0.5 * z + 0.5, 0.0).truncate(), 7, 47);
    0.34 * rise * rise * rough * rough + 0.004 * rough
}

/// The upper half of a unit sphere, seen from inside; a bit of it lies below the horizon.
fn dome() -> Mesh {
    shapes::surface((40, 12), Vec2::new(2.0, 1.0), |u, v| {
        let (sin_v, cos_v) = shapes::sincos(1.65 * v - 0.08);
        let (sin_u, cos_u) = shapes::sincos(u * std::f64::consts::TAU);
        let position = DVec3::new(cos_v * cos_u, sin_v, cos_v * sin_u);
        (position, -position)
    })
}

fn terrace(builder: &mut Builder, stones: &Stones) {
    let slab = cuboid([5.5, 0.15, 4.0], 0.5);
    builder.single("terrace", at(0.0, -0.15, -0.5), slab, stones.paving);
    let step = cuboid([6.0, 0.15, 4.5], 0.5);
    builder.single("step", at(0.0, -0.45, -0.5), step, stones.paving);

    let lattice = builder.texture(textures::fence(128), Sampler::default());
    let lattice = builder.cut_out("lattice", lattice);
    let mesh = shapes::surface((1, 1), Vec2::new(4.0, 1.0), |u, v| {
        (DVec3::new(2.0 * u - 1.0, v, 0.0), DVec3::Z)
    });
    let mesh = builder.mesh("lattice", mesh);
    for (name, place) in [
        ("fence left", at(-5.3, 0.0, -1.6) * turned(90.0)),
        ("fence back left", at(-3.7, 0.0, -4.3)),
        ("fence back right", at(3.7, 0.0, -4.3)),
    ] {
        builder.place(name, None, place * scaled(1.5, 0.8, 1.0), (mesh, lattice));
    }
}

/// Two piers and fifteen stones between them.
fn arch(builder: &mut Builder, stones: &Stones) {
    let root = builder.node("arch", None, at(0.0, 0.0, -2.9));
    let pier = builder.mesh("pier", cuboid([0.4, 0.9, 0.4], 0.9));
    let impost = builder.mesh("impost", cuboid([0.48, 0.08, 0.48], 0.5));
    for (side, x) in [("left", -1.5), ("right", 1.5)] {
        let name = format!("pier {side}");
        builder.place(&name, Some(root), at(x, 0.9, 0.0), (pier, stones.brick));
        let name = format!("impost {side}");
        builder.place(&name, Some(root), at(x, 1.88, 0.0), (impost, stones.marble));
    }
    let wedge = builder.mesh("wedge", wedge(15));
    for k in 0..15 {
        let degrees = 180.0 / 15.0 * (f64::from(k) + 0.5) - 90.0;
        let turn = glam::DAffine3::from_axis_angle(DVec3::Z, degrees.to_radians());
        let material = if k == 7 { stones.marble } else { stones.brick };
        builder.place(
            &format!("wedge {k}"),
            Some(root),
            at(0.0, 1.96, 0.0) * turn,
            (wedge, material),
        );
    }
}

/// One of `n` stones of a half ring of radii 1.1 and 1.9 around z; this one is on top.
fn wedge(n: u32) -> Mesh {
    let mut mesh = cuboid([1.0, 1.0, 0.4], 0.0);
    let half = 0.5 * std::f64::consts::PI / f64::from(n);
    let (sin, cos) = shapes::sincos(half * 0.97);
    for position in &mut mesh.positions {
        let radius = if position.y > 0.0 { 1.9 } else { 1.1 };
        position.x *= (radius * sin) as f32;
        position.y = (radius * cos) as f32;
    }
    if let Some(uvs) = &mut mesh.uvs[0] {
        for uv in uvs {
            *uv = *uv * Vec2::new(0.25, 0.75) + Vec2::new(0.0, 0.1);
        }
    }
    flat(mesh)
}

fn columns(builder: &mut Builder, stones: &Stones) {
    let shaft = builder.mesh("shaft", cylinder(0.3, 2.4, 32, Vec2::new(2.0, 2.2)));
    let base = builder.mesh(
        "base",
        joined([
            (&cuboid([0.45, 0.1, 0.45], 0.5), at(0.0, 0.1, 0.0)),
            (&lathe(&TORUS, 32, Vec2::new(2.0, 0.2)), at(0.0, 0.2, 0.0)),
        ]),
    );
    let ball = builder.mesh("ball", sphere(28));
    for (k, (x, z)) in
        [(-4.4, -3.4), (-4.4, 0.6), (4.4, -3.4), (-2.9, -3.4)].into_iter().enumerate()
    {
        let root = builder.node(&format!("column {k}"), None, at(x, 0.0, z));
        builder.place("base", Some(root), at(0.0, 0.0, 0.0), (base, stones.marble));
        builder.place("shaft", Some(root), at(0.0, 1.5, 0.0), (shaft, stones.brick));
        let upside_down = at(0.0, 3.0, 0.0) * tilted(180.0);
        builder.place("capital", Some(root), upside_down, (base, stones.marble));
        let on_top = at(0.0, 3.28, 0.0) * turned(50.0 * k as f64) * scaled(0.28, 0.28, 0.28);
        builder.place("ball", Some(root), on_top, (ball, stones.marble));
    }
}

/// A round moulding, 0.1 high, for the foot of a column of radius 0.3.
const TORUS: [[f64; 2]; 7] = [
    [0.41, 0.0],
    [0.43, 0.02],
    [0.44, 0.05],
    [0.42, 0.08],
    [0.38, 0.095],
    [0.33, 0.1],
    [0.29, 0.16],
];

/// The knot in the middle and the balls beside it, on pedestals.
fn statues(builder: &mut Builder, stones: &Stones) {
    let pedestal = builder.mesh("pedestal", lathe(&PEDESTAL, 36, Vec2::new(2.0, 1.0)));
    let ball = builder.mesh("statue ball", sphere(48));
    let squares = [Vec3::new(0.93, 0.92, 0.88), Vec3::new(0.12, 0.23, 0.42)];
    let checker = builder.textured("checker", textures::checker(64, 8, squares));
    for (name, x, z, radius, material) in [
        ("marble ball", 1.75, -0.6, 0.46, stones.marble),
        ("checker ball", -2.2, 0.9, 0.42, checker),
    ] {
        let root = builder.node(name, None, at(x, 0.0, z));
        builder.place("pedestal", Some(root), scaled(0.8, 0.8, 0.8), (pedestal, stones.marble));
        let place = at(0.0, 0.8 + radius, 0.0) * turned(35.0) * scaled(radius, radius, radius);
        builder.place("ball", Some(root), place, (ball, material));
    }

    let bronze = builder.plain("bronze", [1.0, 1.0, 1.0]);
    let knot = colored(torus_knot((2, 3), 0.19, (180, 18)), |position| {
        let t = 0.5 + 0.9 * position.y;
        Vec3::new(0.42, 0.11, 0.03).lerp(Vec3::new(0.80, 0.42, 0.10), t.clamp(0.0, 1.0))
    });
    let knot = Mesh { uvs: [None, None], ..knot };
    let root = builder.node("knot", None, at(-0.25, 0.0, -0.9));
    builder.place("pedestal", Some(root), at(0.0, 0.0, 0.0), (pedestal, stones.marble));
    let mesh = builder.mesh("knot", knot);
    let upright = at(0.0, 1.72, 0.0) * turned(25.0) * tilted(78.0) * scaled(0.52, 0.52, 0.52);
    builder.place("bronze knot", Some(root), upright, (mesh, bronze));
}

/// A turned pedestal, 1 high.
const PEDESTAL: [[f64; 2]; 12] = [
    [0.0, 0.0],
    [0.5, 0.0],
    [0.5, 0.1],
    [0.42, 0.16],
    [0.38, 0.18],
    [0.34, 0.3],
    [0.34, 0.7],
    [0.38, 0.82],
    [0.46, 0.88],
    [0.5, 0.92],
    [0.5, 1.0],
    [0.0, 1.0],
];

fn crates(builder: &mut Builder) {
    let wood = builder.textured("wood", textures::wood(256));
    let mut parts = vec![(cuboid([0.47, 0.47, 0.47], 0.9), at(0.0, 0.0, 0.0))];
    let bar = cuboid([0.5, 0.06, 0.06], 0.9);
    for (y, z) in [(-0.44, -0.44), (-0.44, 0.44), (0.44, -0.44), (0.44, 0.44)] {
        parts.push((bar.clone(), at(0.0, y, z)));
        parts.push((bar.clone(), turned(90.0) * at(0.0, y, z)));
        let upright = glam::DAffine3::from_axis_angle(DVec3::Z, std::f64::consts::FRAC_PI_2);
        parts.push((bar.clone(), upright * at(0.0, y, z)));
    }
    let mesh = joined(parts.iter().map(|(part, place)| (part, *place)));
    let mesh = builder.mesh("crate", mesh);
    for (name, place) in [
        ("crate", at(0.55, 0.5, 1.55) * turned(24.0)),
        ("small crate", at(0.5, 1.3, 1.5) * turned(-12.0) * scaled(0.6, 0.6, 0.6)),
        ("crate at the wall", at(3.4, 0.5, -2.6) * turned(-8.0)),
    ] {
        builder.place(name, None, place, (mesh, wood));
    }
}

fn plants(builder: &mut Builder) {
    let clay = builder.plain("clay", [0.52, 0.20, 0.10]);
    let pot = builder.mesh("pot", lathe(&POT, 28, Vec2::ONE));
    let earth = builder.plain("earth", [0.05, 0.035, 0.02]);
    let soil = builder.mesh("soil", lathe(&[[0.3, 0.0], [0.0, 0.03]], 28, Vec2::ONE));
    let clamp = Sampler { wrap_u: Wrap::Clamp, wrap_v: Wrap::Clamp, ..Sampler::default() };
    let leaves = builder.texture(textures::leaves(128), clamp);
    let leaves = builder.cut_out("leaves", leaves);
    let sprig = quad();
    let bush = joined((0..9).map(|k| {
        let lean = if k % 3 == 0 { 8.0 } else { 34.0 };
        let place = turned(40.0 * f64::from(k)) * tilted(lean) * at(0.0, 0.46, 0.0);
        (&sprig, place * scaled(0.5, 0.5, 0.5))
    }));
    let bush = builder.mesh("bush", bush);
    for (k, (x, z, size)) in
        [(-1.35, 2.2, 0.9), (-4.2, 2.3, 1.25), (3.1, 0.9, 1.0), (2.6, -3.1, 1.3), (-2.4, -2.2, 1.1)]
            .into_iter()
            .enumerate()
    {
        let place = at(x, 0.0, z) * turned(31.0 * k as f64) * scaled(size, size, size);
        let root = builder.node(&format!("plant {k}"), None, place);
        builder.place("pot", Some(root), at(0.0, 0.0, 0.0), (pot, clay));
        builder.place("soil", Some(root), at(0.0, 0.42, 0.0), (soil, earth));
        builder.place("bush", Some(root), at(0.0, 0.40, 0.0), (bush, leaves));
    }
}

/// A pot, 0.5 high, open at the top.
const POT: [[f64; 2]; 7] =
    [[0.0, 0.0], [0.22, 0.0], [0.31, 0.4], [0.36, 0.4], [0.36, 0.5], [0.31, 0.5], [0.29, 0.4]];
