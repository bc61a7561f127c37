//! Worlds of boxes to cull, and views that see a given part of them. Seeded.

use cullet_cull::wide::{Boxes8, Level};
use cullet_cull::{Aabb, Frustum};
use cullet_transform::{Camera, Projection};
use glam::DVec3;

/// SplitMix64 (Steele, Lea and Flood 2014).
pub struct Random(pub u64);

impl Random {
    /// In [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// In `-extent..extent` along each axis.
    pub fn point(&mut self, extent: f64) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| extent * (2.0 * self.unit() - 1.0)))
    }
}

/// How boxes are strewn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum World {
    /// Evenly through a cube, in no order, edges up to twice the mean distance.
    Random,
    /// Streets: towers with many small parts each, one after the other.
    City,
}

impl World {
    /// For tables.
    pub fn name(self) -> &'static str {
        match self {
            World::Random => "random",
            World::City => "city",
        }
    }

    /// `n` boxes around zero.
    pub fn boxes(self, n: usize) -> Vec<Aabb> {
        let mut random = Random(n as u64);
        match self {
            World::Random => {
                let extent = 0.5 * (n as f64).cbrt();
                let mut one = || {
                    let center = random.point(extent);
                    let half = (random.point(0.5) + 0.5) * (random.unit() + 0.1);
                    Aabb { min: center - half, max: center + half }
                };
                (0..n).map(|_| one()).collect()
            }
            World::City => city(n, &mut random),
        }
    }
}

fn city(n: usize, random: &mut Random) -> Vec<Aabb> {
    const PARTS: usize = 100;
    let n_towers = n.div_ceil(PARTS);
    let side = (n_towers as f64).sqrt().ceil() as usize;
    let mut boxes = Vec::with_capacity(n + PARTS);
    for tower in 0..n_towers {
        let street = DVec3::new((tower % side) as f64, 0.0, (tower / side) as f64);
        let corner = (street - DVec3::new(0.5, 0.0, 0.5) * side as f64) * 40.0;
        let height = 10.0 + 90.0 * random.unit() * random.unit();
        let body = DVec3::new(24.0, height, 24.0);
        boxes.push(Aabb { min: corner, max: corner + body });
        for _ in 1..PARTS {
            let at = corner + DVec3::new(random.unit(), random.unit(), random.unit()) * body;
            let half = DVec3::new(0.5, 1.0, 0.2) * (0.2 + 1.3 * random.unit());
            boxes.push(Aabb { min: at - half, max: at + half });
        }
    }
    boxes.truncate(n);
    boxes
}

/// How much of a world a view has in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sees {
    /// About this fraction, from a place inside.
    Part(f64),
    /// All of it, from far outside.
    All,
    /// Nothing: from the border, outwards.
    Nothing,
}

impl Sees {
    /// For tables.
    pub fn name(self) -> String {
        match self {
            Sees::Part(part) => format!("{:.0}%", 100.0 * part),
            Sees::All => "100%".into(),
            Sees::Nothing => "away".into(),
        }
    }

    /// `n` views in all directions.
    pub fn views(self, boxes: &[Aabb], n: usize) -> Vec<Frustum> {
        let all = boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(b));
        let wide = Boxes8::new(boxes);
        let mut random = Random(99);
        let mut one = || {
            let mut direction = random.point(1.0);
            direction.y *= 0.1;
            let direction = direction.normalize();
            let half = all.half_extent();
            let size = half.length();
            match self {
                Sees::All => {
                    let eye = all.center() - direction * 4.0 * size;
                    look(eye, direction, 0.8, size)
                }
                Sees::Nothing => {
                    let eye = all.center() + direction * 1.1 * size;
                    look(eye, direction, 1.0, size)
                }
                Sees::Part(part) => {
                    // Somewhere in the middle; the field of view that sees that much.
                    let eye = all.center() + (random.point(0.3)) * half;
                    let (mut low, mut high) = (1e-3, 3.1);
                    for _ in 0..14 {
                        let middle = 0.5 * (low + high);
                        let seen = seen(&wide, &look(eye, direction, middle, size));
                        if seen < part { low = middle } else { high = middle }
                    }
                    look(eye, direction, low, size)
                }
            }
        };
        (0..n).map(|_| one()).collect()
    }
}

fn look(eye: DVec3, direction: DVec3, yfov: f64, size: f64) -> Frustum {
    let lens = Projection::Perspective { yfov, near: 1e-3 * size, far: 10.0 * size };
    let camera = Camera::look_at(eye, eye + direction, DVec3::Y, lens).expect("a camera");
    Frustum::from_camera(&camera, 16.0 / 9.0)
}

/// The fraction of the boxes that a view has in it.
pub fn seen(boxes: &Boxes8, view: &Frustum) -> f64 {
    let mut bits = vec![0; boxes.n_groups()];
    boxes.visible_into(view, Level::new(), &mut bits);
    let n: u32 = bits.iter().map(|byte| byte.count_ones()).sum();
    f64::from(n) / boxes.len() as f64
}
