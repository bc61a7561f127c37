//! A city of towers: hundreds of nodes that share a dozen meshes. Units are metres.

use glam::{DAffine3, Vec2, Vec3};

use super::build::{Builder, at, scaled, turned};
use super::shapes::{append, cuboid, cylinder, floor, joined, lathe, sphere};
use super::textures::{self, hash};
use crate::{Mesh, Scene};

/// From the middle of one block to the middle of the next.
const PITCH: f64 = 30.0;

/// `n` by `n` blocks; about one in seven is a park.
pub(super) fn build(n: u32) -> Scene {
    let mut builder = Builder::new("city");
    let kit = Kit::new(&mut builder);
    let half = 0.5 * PITCH * f64::from(n);
    let asphalt = builder.plain("asphalt", [0.07, 0.07, 0.08]);
    builder.single("streets", scaled(half + 40.0, 1.0, half + 40.0), floor(8, 1.0), asphalt);
    for z in 0..n {
        for x in 0..n {
            let middle = |k: u32| PITCH * (f64::from(k) + 0.5) - half;
            let local = at(middle(x), 0.0, middle(z));
            let block = builder.node(&format!("block {x} {z}"), None, local);
            builder.place("pavement", Some(block), at(0.0, 0.1, 0.0), kit.pavement);
            if hash(x, z, 61) < 0.14 {
                kit.park(&mut builder, block, (x, z));
            } else {
                kit.towers(&mut builder, block, (x, z));
            }
        }
    }
    builder.look([half * 0.8, 70.0, half + 60.0], [-0.1 * half, 0.0, 0.2 * half], 42.0);
    builder.finish()
}

/// A mesh and the material it is drawn with.
type Drawn = (usize, usize);

/// The meshes that all blocks share.
struct Kit {
    pavement: Drawn,
    towers: Vec<Drawn>,
    lawn: Drawn,
    trunk: Drawn,
    crown: Drawn,
}

impl Kit {
    fn new(builder: &mut Builder) -> Kit {
        let concrete = builder.plain("concrete", [0.42, 0.40, 0.37]);
        let pavement = builder.mesh("pavement", cuboid([12.5, 0.1, 12.5], 0.0));
        let walls =
            [[0.78, 0.72, 0.62], [0.52, 0.56, 0.62], [0.70, 0.46, 0.36], [0.86, 0.85, 0.82]];
        let shapes = [
            ("low block", slab(LOW)),
            ("high block", slab(HIGH)),
            ("low steps", stepped(LOW)),
            ("high steps", stepped(HIGH)),
            ("low round", round(LOW)),
            ("high round", round(HIGH)),
            ("low twins", twins(LOW)),
            ("high twins", twins(HIGH)),
        ];
        let mut towers = Vec::new();
        let meshes = shapes.map(|(name, mesh)| builder.mesh(name, mesh));
        for (seed, wall) in (0..).zip(walls) {
            let image = textures::windows(128, Vec3::from(wall), seed);
            let material = builder.textured(&format!("windows {seed}"), image);
            towers.extend(meshes.map(|mesh| (mesh, material)));
        }
        let grass = builder.plain("grass", [0.12, 0.24, 0.06]);
        let bark = builder.plain("bark", [0.10, 0.06, 0.03]);
        let green = builder.plain("leaves", [0.07, 0.20, 0.05]);
        let lawn = builder.mesh("lawn", cuboid([12.0, 0.05, 12.0], 0.0));
        let trunk = builder.mesh("trunk", cylinder(0.3, 2.4, 8, Vec2::ONE));
        let crown = builder.mesh("crown", sphere(12));
        Kit {
            pavement: (pavement, concrete),
            towers,
            lawn: (lawn, grass),
            trunk: (trunk, bark),
            crown: (crown, green),
        }
    }

    /// Up to four towers, high ones in some groups of blocks and low ones in others.
    fn towers(&self, builder: &mut Builder, block: usize, (x, z): (u32, u32)) {
        for k in 0..4 {
            if hash(x, z, 67 + k) < 0.12 {
                continue;
            }
            let n_looks = self.towers.len() / 2;
            let look = (hash(x, z, 71 + k) * n_looks as f64) as usize;
            let high = hash(x / 3, z / 3, 73) * hash(x, z, 79 + k) > 0.3;
            let drawn = self.towers[2 * look + usize::from(high)];
            let corner = turned(90.0 * f64::from(k)) * at(6.2, 0.2, 6.2);
            // Little enough that windows do not look stretched.
            let local = corner * scaled(1.0, 0.7 + 0.5 * hash(x, z, 83 + k), 1.0);
            builder.place(&format!("tower {k}"), Some(block), local, drawn);
        }
    }

    fn park(&self, builder: &mut Builder, block: usize, (x, z): (u32, u32)) {
        builder.place("lawn", Some(block), at(0.0, 0.22, 0.0), self.lawn);
        for k in 0..9 {
            let jitter = |seed| 2.0 * hash(x * 16 + k, z, seed) - 1.0;
            let cell = |k: u32| 7.5 * (f64::from(k) - 1.0);
            let size = 1.0 + 0.4 * jitter(89);
            let local = at(cell(k % 3) + jitter(97), 0.25, cell(k / 3) + jitter(101));
            let tree =
                builder.node(&format!("tree {k}"), Some(block), local * scaled(size, size, size));
            builder.place("trunk", Some(tree), at(0.0, 1.2, 0.0), self.trunk);
            let crown = at(0.0, 3.8, 0.0) * scaled(1.7, 2.1, 1.7);
            builder.place("crown", Some(tree), crown, self.crown);
        }
    }
}

// Towers stand on the ground and are at most 10 wide.

const LOW: f32 = 15.0;
const HIGH: f32 = 36.0;

fn slab(height: f32) -> Mesh {
    storey(4.6, 3.4, 0.0, height)
}

fn stepped(height: f32) -> Mesh {
    let mut mesh = storey(4.8, 4.8, 0.0, 0.5 * height);
    append(&mut mesh, &storey(3.7, 3.7, 0.5 * height, 0.8 * height), DAffine3::IDENTITY);
    append(&mut mesh, &storey(2.4, 2.4, 0.8 * height, height), DAffine3::IDENTITY);
    mesh
}

fn round(height: f32) -> Mesh {
    let top = f64::from(height);
    let wall = lathe(&[[4.4, 0.0], [4.4, top]], 20, Vec2::new(3.0, height / PICTURE.y));
    let roof = lathe(&[[4.4, top], [0.0, top]], 20, Vec2::ZERO);
    joined([(&wall, DAffine3::IDENTITY), (&roof, DAffine3::IDENTITY)])
}

fn twins(height: f32) -> Mesh {
    let tower = storey(1.9, 4.2, 0.0, height);
    let bridge = storey(1.2, 1.4, 0.7 * height, 0.8 * height);
    joined([
        (&tower, at(-2.7, 0.0, 0.0)),
        (&tower, at(2.7, 0.0, 0.0)),
        (&bridge, DAffine3::IDENTITY),
    ])
}

/// What one picture of four floors of eight windows covers.
const PICTURE: Vec2 = Vec2::new(9.6, 12.0);

/// A box with windows around and a plain roof.
fn storey(half_x: f32, half_z: f32, bottom: f32, top: f32) -> Mesh {
    let half_height = 0.5 * (top - bottom);
    let mut mesh = cuboid([half_x, half_height, half_z], 1.0);
    if let (Some(uvs), Some(normals)) = (&mut mesh.uvs[0], &mesh.normals) {
        for (uv, normal) in uvs.iter_mut().zip(normals) {
            // Roofs show one spot of wall between the windows.
            *uv = if normal.y != 0.0 { Vec2::ZERO } else { *uv / PICTURE };
        }
    }
    joined([(&mesh, at(0.0, f64::from(bottom + half_height), 0.0))])
}
