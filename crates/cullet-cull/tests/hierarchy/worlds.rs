//! Boxes and cameras to try the wide tests and the tree on; the same in every run.

use cullet_cull::{Aabb, DepthRange, Frustum, FrustumError};
use cullet_transform::{Camera, Kind, Projection, Window};
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};

/// SplitMix64 (Steele, Lea and Flood 2014).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    pub fn point(&mut self, extent: f64) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| self.within(-extent, extent)))
    }
}

/// Boxes scattered through a cube, of sizes up to `size`, small ones more often.
pub fn random_boxes(random: &mut Random, n: usize, extent: f64, size: f64) -> Vec<Aabb> {
    let mut one = || {
        let center = random.point(extent);
        let half: [f64; 3] = std::array::from_fn(|_| 0.5 * size * random.unit() * random.unit());
        let half = DVec3::from_array(half);
        Aabb { min: center - half, max: center + half }
    };
    (0..n).map(|_| one()).collect()
}

/// Towers on a grid of streets, each with its windows and doors; y is up.
pub fn city(random: &mut Random, n: usize) -> Vec<Aabb> {
    let per_block = 50;
    let side = (n.div_ceil(per_block) as f64).sqrt().ceil().max(1.0);
    let mut boxes = Vec::with_capacity(n);
    for block in 0.. {
        let (x, z) = ((f64::from(block) % side).floor(), (f64::from(block) / side).floor());
        let corner = DVec3::new((x - 0.5 * side) * 40.0, 0.0, (z - 0.5 * side) * 40.0);
        let height = 10.0 + 90.0 * random.unit() * random.unit();
        for part in 0..per_block {
            if boxes.len() == n {
                return boxes;
            }
            let (at, half) = if part == 0 {
                (DVec3::new(15.0, 0.5 * height, 15.0), DVec3::new(12.0, 0.5 * height, 12.0))
            } else {
                let at = DVec3::new(
                    random.within(0.0, 40.0),
                    random.unit() * height,
                    random.within(0.0, 40.0),
                );
                (at, DVec3::new(0.5, 1.0, 0.2) * random.within(0.2, 1.5))
            };
            boxes.push(Aabb { min: corner + at - half, max: corner + at + half });
        }
    }
    boxes
}

/// Empty, NaN, infinite, flat and huge boxes among ordinary ones.
pub fn odd_boxes(random: &mut Random, n: usize) -> Vec<Aabb> {
    let mut boxes = random_boxes(random, n, 100.0, 10.0);
    for (i, bounds) in boxes.iter_mut().enumerate() {
        match i % 13 {
            1 => *bounds = Aabb::EMPTY,
            2 => bounds.max.y = f64::NAN,
            3 => bounds.max.x = f64::INFINITY,
            4 => bounds.min.z = f64::NEG_INFINITY,
            5 => bounds.max = bounds.min,
            6 => bounds.min.y = -1e40,
            7 => bounds.max.x = bounds.min.x - 1.0,
            8 => bounds.min = DVec3::splat(-0.0),
            9 => *bounds = Aabb { min: DVec3::splat(5e-324), max: DVec3::splat(1e-310) },
            10 => *bounds = Aabb { min: DVec3::splat(3.0), max: DVec3::splat(4.0) },
            _ => {}
        }
    }
    boxes
}

/// Views of where the finite boxes are: inside and outside of them, all lenses.
pub fn cameras(random: &mut Random, boxes: &[Aabb], n: usize) -> Vec<Frustum> {
    let finite = |b: &&Aabb| b.min.is_finite() && b.max.is_finite() && b.min.x.abs() < 1e35;
    let all = boxes.iter().filter(finite).fold(Aabb::EMPTY, |all, b| all.union(b));
    let (center, extent) = if all.is_empty() || all.is_nan() {
        (DVec3::ZERO, 1.0)
    } else {
        (all.center(), Some(all.half_extent().max_element()).filter(|e| *e > 0.0).unwrap_or(1.0))
    };
    (0..n)
        .map(|i| {
            let near = extent * 10_f64.powf(random.within(-6.0, -1.0));
            let far = if i % 3 == 0 { f64::INFINITY } else { extent * random.within(0.2, 4.0) };
            let spread = if i % 4 == 0 { 3.0 } else { 0.9 };
            let eye = center + random.point(extent * spread);
            if i % 5 == 4 {
                let (w, h) = (extent * random.unit(), extent * random.unit());
                let rotation = DMat3::from_quat(quaternion(random));
                let window = Window {
                    kind: Kind::Orthographic,
                    left: -w,
                    right: 0.5 * w,
                    bottom: -0.2 * h,
                    top: h,
                    near: 0.0,
                    far: 2.0 * extent,
                };
                return Frustum::from_window(eye, &rotation, &window);
            }
            if i % 5 == 3 {
                // A tile of a rolled picture.
                let rotation = DMat3::from_quat(quaternion(random));
                let (left, bottom) = (random.within(-1.0, 0.9), random.within(-1.0, 0.9));
                let window = Window {
                    kind: Kind::Perspective,
                    left,
                    right: left + 0.1,
                    bottom,
                    top: bottom + 0.1,
                    near,
                    far,
                };
                return Frustum::from_window(eye, &rotation, &window);
            }
            if i % 5 == 2 {
                return near_lost(random, eye, extent);
            }
            let yfov = [1.0, 0.02, 3.12][i % 3];
            let target = eye + random.point(extent);
            let lens = Projection::Perspective { yfov, near, far: far.max(near * 2.0) };
            let camera = Camera::look_at(eye, target, DVec3::Y, lens).expect("a camera");
            Frustum::from_camera(&camera, 16.0 / 9.0)
        })
        .collect()
}

/// Of a matrix multiplied in f32, far from the origin: what is left of its near distance is
/// rounding.
fn near_lost(random: &mut Random, eye: DVec3, extent: f64) -> Frustum {
    let near = extent * 10_f64.powf(random.within(-12.0, -6.0));
    let window = Window {
        kind: Kind::Perspective,
        left: -0.7,
        right: 0.7,
        bottom: -0.5,
        top: 0.5,
        near,
        far: f64::INFINITY,
    };
    let axes = DMat3::from_quat(quaternion(random));
    let view_from_world = DAffine3::from_mat3(axes.transpose()) * DAffine3::from_translation(-eye);
    // Depth runs from 0 to 1, so that the near distance is what two large numbers differ by.
    let mut rows = window.clip_from_view().transpose();
    rows.z_axis = rows.w_axis - rows.z_axis;
    let clip_from_world = rows.transpose().as_mat4() * DMat4::from(view_from_world).as_mat4();
    match Frustum::from_matrix(&clip_from_world.as_dmat4(), DepthRange::ZeroToOne) {
        // A world too large for f32.
        Err(FrustumError::NotFinite) => Frustum::from_window(eye, &axes, &window),
        frustum => frustum.expect("a volume"),
    }
}

fn quaternion(random: &mut Random) -> DQuat {
    let p = random.point(1.0);
    DQuat::from_xyzw(p.x, p.y, p.z, random.within(0.1, 1.0)).normalize()
}

/// Boxes that are hard on a tree.
pub fn degenerate(n: usize) -> Vec<(&'static str, Vec<Aabb>)> {
    let cube = |center: DVec3, half: f64| Aabb { min: center - half, max: center + half };
    let each = |f: &dyn Fn(f64) -> Aabb| (0..n).map(|i| f(i as f64)).collect();
    vec![
        ("identical", each(&|_| cube(DVec3::ONE, 0.5))),
        ("one point", each(&|_| cube(DVec3::ONE, 0.0))),
        ("nested", each(&|i| cube(DVec3::ONE, i + 1.0))),
        ("chain", each(&|i| cube(DVec3::X * i, 0.6))),
        ("halving", each(&|i| cube(DVec3::splat(1.5_f64.powf(-i % 200.0)), 1e-3))),
        (
            "growing",
            each(&|i| cube(DVec3::splat(1.2_f64.powf(i % 300.0)), 1.2_f64.powf(i % 300.0))),
        ),
        (
            "grid of points",
            each(&|i| cube(DVec3::new(i % 31.0, i / 31.0 % 17.0, 0.0).floor(), 0.0)),
        ),
    ]
}
