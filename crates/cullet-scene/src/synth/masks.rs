//! Cut-out leaves and fences, wrap modes and texture transforms.

use glam::{Affine2, Vec2, Vec3};

use super::build::{Builder, at, scaled, tilted, turned};
use super::shapes::{floor, joined, quad, surface};
use super::textures;
use crate::{AlphaMode, Material, Mesh, Sampler, Scene, TextureRef, Wrap};

pub(super) fn build() -> Scene {
    let mut builder = Builder::new("masks");
    wrap_modes(&mut builder);
    transforms(&mut builder);
    garden(&mut builder);
    builder.look([0.6, 2.6, 8.6], [-0.3, 2.0, 0.0], 36.0);
    builder.finish()
}

const WRAPS: [(&str, Wrap); 3] =
    [("repeat", Wrap::Repeat), ("mirror", Wrap::Mirror), ("clamp", Wrap::Clamp)];

/// A wall of three by three boards whose coordinates run from -1 to 2, one board for each
/// pair of wrap modes; those of the last column ask for nearest texels.
fn wrap_modes(builder: &mut Builder) {
    let board = builder.mesh("board", board());
    let image = builder.image(textures::mark(64));
    for (row, (name_v, wrap_v)) in WRAPS.into_iter().enumerate() {
        for (column, (name_u, wrap_u)) in WRAPS.into_iter().enumerate() {
            let nearest = column == 2;
            let sampler = Sampler { wrap_u, wrap_v, nearest_mag: nearest, nearest_min: nearest };
            let texture = builder.resample(image, sampler);
            let name = format!("{name_u} {name_v}");
            let material = covered(builder, &name, texture);
            let place = at(1.3 * column as f64 - 4.0, 3.6 - 1.3 * row as f64, -1.5);
            builder.place(&name, None, place * scaled(0.6, 0.6, 1.0), (board, material));
        }
    }
}

/// Four boards of one image: as it is, moved, turned, and turned with uneven scale.
fn transforms(builder: &mut Builder) {
    let plain = builder.mesh("plain board", quad());
    let image = builder.texture(textures::mark(64), Sampler::default());
    let turn = |degrees: f64, scale: Vec2, offset: Vec2| {
        Affine2::from_scale_angle_translation(scale, degrees.to_radians() as f32, offset)
    };
    for (k, (name, transform)) in [
        ("as it is", None),
        ("moved", Some(turn(0.0, Vec2::ONE, Vec2::new(0.25, 0.5)))),
        ("turned", Some(turn(30.0, Vec2::ONE, Vec2::ZERO))),
        ("shrunk and turned", Some(turn(-45.0, Vec2::new(2.0, 3.0), Vec2::new(0.5, 0.0)))),
    ]
    .into_iter()
    .enumerate()
    {
        let texture = TextureRef { transform, ..image.clone() };
        let material = covered(builder, name, texture);
        let (x, y) = (0.6 + 1.6 * (k % 2) as f64, 3.4 - 1.6 * (k / 2) as f64);
        builder.place(name, None, at(x, y, -1.5) * scaled(0.7, 0.7, 1.0), (plain, material));
    }
}

/// Bushes behind a fence, on grass.
fn garden(builder: &mut Builder) {
    let squares = [Vec3::new(0.40, 0.52, 0.26), Vec3::new(0.36, 0.47, 0.23)];
    let lawn = builder.textured("lawn", textures::checker(32, 4, squares));
    builder.single("lawn", scaled(9.0, 1.0, 9.0), floor(6, 6.0), lawn);

    let lattice = builder.texture(textures::fence(128), Sampler::default());
    let lattice = builder.cut_out("lattice", lattice);
    let panel = surface((1, 1), Vec2::new(6.0, 1.0), |u, v| {
        (glam::DVec3::new(3.0 * (2.0 * u - 1.0), v, 0.0), glam::DVec3::Z)
    });
    let panel = builder.mesh("fence", panel);
    builder.place("fence", None, at(-0.8, 0.0, 3.2) * turned(8.0), (panel, lattice));
    builder.place("side fence", None, at(4.4, 0.0, 0.8) * turned(-78.0), (panel, lattice));

    let clamp = Sampler { wrap_u: Wrap::Clamp, wrap_v: Wrap::Clamp, ..Sampler::default() };
    let leaves = builder.texture(textures::leaves(128), clamp);
    let solid = builder.cut_out("leaves", leaves.clone());
    let blended = builder.material(Material {
        name: "glass leaves".into(),
        base_color: glam::Vec4::new(1.0, 0.6, 0.5, 0.6),
        base_color_texture: Some(leaves),
        alpha: AlphaMode::Mask { cutoff: 0.3 },
        double_sided: true,
        unlit: true,
    });
    let sprig = quad();
    let bush = joined((0..7).map(|k| {
        let place = turned(51.0 * f64::from(k)) * tilted(26.0) * at(0.0, 0.9, 0.0);
        (&sprig, place)
    }));
    let bush = builder.mesh("bush", bush);
    for k in 0..8 {
        let place = at(1.3 * f64::from(k) - 4.8, 0.0, 1.0 + 0.5 * f64::from(k % 3));
        let size = 0.45 + 0.05 * f64::from(k % 4);
        let place = place * turned(27.0 * f64::from(k)) * scaled(size, size, size);
        let material = if k == 5 { blended } else { solid };
        builder.place(&format!("bush {k}"), None, place, (bush, material));
    }
}

/// A double-sided material of one texture.
fn covered(builder: &mut Builder, name: &str, texture: TextureRef) -> usize {
    builder.material(Material {
        name: name.into(),
        base_color_texture: Some(texture),
        double_sided: true,
        ..Material::default()
    })
}

/// A quad with texture coordinates from -1 to 2.
fn board() -> Mesh {
    let mut board = quad();
    if let Some(uvs) = &mut board.uvs[0] {
        for uv in uvs {
            *uv = *uv * 3.0 - 1.0;
        }
    }
    board
}
