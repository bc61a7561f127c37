//! A room with two rows of columns, seen from inside: geometry behind and beside the eye,
//! and a column so close that the near plane cuts it. Units are metres.

use glam::{DAffine3, DVec3, Vec2, Vec3};

use super::build::{Builder, at, scaled, turned};
use super::shapes::{cuboid, cylinder, floor, joined, lathe, sphere};
use super::textures;
use crate::{Lens, Mesh, Scene};

pub(super) fn build() -> Scene {
    let mut builder = Builder::new("interior");
    shell(&mut builder);
    columns(&mut builder);
    furniture(&mut builder);
    let eye = DVec3::new(-1.9, 1.65, 6.2);
    let lens = Lens::Perspective { yfov: 1.1, aspect: None, near: 0.1, far: 60.0 };
    builder.camera(None, super::build::looking(eye, DVec3::new(0.4, 1.5, -2.0)), lens);
    builder.finish()
}

/// Floor, walls and ceiling of a room of 8 by 4 by 16, and light behind three windows.
fn shell(builder: &mut Builder) {
    let squares = [Vec3::new(0.80, 0.77, 0.70), Vec3::new(0.34, 0.24, 0.20)];
    let tiles = builder.textured("tiles", textures::checker(64, 4, squares));
    builder.single("floor", scaled(4.0, 1.0, 8.0), floor(8, 4.0), tiles);
    let plaster = builder.plain("plaster", [0.72, 0.68, 0.60]);
    let upside_down = at(0.0, 4.0, 0.0) * scaled(4.0, -1.0, 8.0);
    builder.single("ceiling", upside_down, floor(4, 1.0), plaster);

    let brick = builder.textured("brick", textures::brick(256));
    let wall = builder.mesh("wall", cuboid([4.0, 2.0, 0.1], 0.6));
    let long_wall = builder.mesh("long wall", cuboid([8.0, 2.0, 0.1], 0.6));
    builder.place("far wall", None, at(0.0, 2.0, -8.1), (wall, brick));
    builder.place("near wall", None, at(0.0, 2.0, 8.1), (wall, brick));
    builder.place("left wall", None, at(-4.1, 2.0, 0.0) * turned(90.0), (long_wall, plaster));
    builder.place("right wall", None, at(4.1, 2.0, 0.0) * turned(90.0), (long_wall, plaster));

    let window = builder.material(crate::Material {
        name: "daylight".into(),
        base_color: glam::Vec4::new(0.80, 0.88, 0.95, 1.0),
        unlit: true,
        ..crate::Material::default()
    });
    let pane = builder.mesh("window", cuboid([0.02, 0.8, 0.6], 0.0));
    for (k, z) in [-5.0, -1.0, 3.0].into_iter().enumerate() {
        builder.place(&format!("window {k}"), None, at(3.99, 2.2, z), (pane, window));
    }
}

fn columns(builder: &mut Builder) {
    let marble = builder.textured("marble", textures::marble(256));
    let column = builder.mesh("column", column());
    for k in 0..10 {
        let (x, z) = (if k % 2 == 0 { -2.3 } else { 2.3 }, 6.0 - 3.0 * f64::from(k / 2));
        let place = at(x, 0.0, z) * turned(41.0 * f64::from(k));
        builder.place(&format!("column {k}"), None, place, (column, marble));
    }
}

/// A column 4 high with a square foot and head.
fn column() -> Mesh {
    let block = cuboid([0.36, 0.12, 0.36], 0.7);
    let shaft = cylinder(0.26, 3.76, 32, Vec2::new(2.0, 3.0));
    joined([
        (&block, at(0.0, 0.12, 0.0)),
        (&shaft, at(0.0, 2.0, 0.0)),
        (&block, at(0.0, 3.88, 0.0)),
    ])
}

/// A table with a bowl and two balls, and a bench.
fn furniture(builder: &mut Builder) {
    let wood = builder.textured("wood", textures::wood(256));
    let leg = cuboid([0.06, 0.42, 0.06], 1.0);
    let mut parts = vec![(cuboid([1.1, 0.05, 0.6], 0.8), at(0.0, 0.88, 0.0))];
    for (x, z) in [(-1.0, -0.5), (1.0, -0.5), (-1.0, 0.5), (1.0, 0.5)] {
        parts.push((leg.clone(), at(x, 0.42, z)));
    }
    let table = joined(parts.iter().map(|(part, place)| (part, *place)));
    let table = builder.mesh("table", table);
    builder.place(
        "bench",
        None,
        at(-3.2, 0.0, -2.0) * turned(90.0) * scaled(1.0, 0.5, 0.5),
        (table, wood),
    );
    let root = builder.node("table", None, at(0.35, 0.0, -0.5) * turned(15.0));
    builder.place("table top", Some(root), DAffine3::IDENTITY, (table, wood));

    let clay = builder.material(crate::Material {
        name: "clay".into(),
        base_color: glam::Vec4::new(0.55, 0.22, 0.10, 1.0),
        double_sided: true,
        ..crate::Material::default()
    });
    let profile = [[0.0, 0.0], [0.12, 0.0], [0.24, 0.08], [0.3, 0.18], [0.32, 0.2]];
    let bowl = builder.mesh("bowl", lathe(&profile, 32, Vec2::ONE));
    builder.place("bowl", Some(root), at(-0.3, 0.93, 0.0), (bowl, clay));
    let apple = builder.plain("apple", [0.55, 0.10, 0.04]);
    let ball = builder.mesh("ball", sphere(24));
    for (name, x, y, z) in [("apple", -0.36, 1.08, 0.02), ("fallen apple", 0.45, 1.03, 0.2)] {
        let place = at(x, y, z) * scaled(0.1, 0.1, 0.1);
        builder.place(name, Some(root), place, (ball, apple));
    }
}
