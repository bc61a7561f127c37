//! How far off interpolated values are (numerics 1): attributes within 1e-5 of their range,
//! depth within 1.3e-6 of itself, for 99 of 100 pixels.

use cullet::scene::Mesh;
use cullet_tests::{Random, long_mode};
use glam::{DAffine3, DVec2, DVec3, Vec2, Vec3};

use crate::ideal::Ideal;
use crate::{INF, ahead, alone, draw, mesh, perspective, view};

const SIZE: [u32; 2] = [64, 48];

/// Errors of every pixel compared.
#[derive(Default)]
struct Errors {
    uv: Vec<f64>,
    position: Vec<f64>,
    depth: Vec<f64>,
}

/// The value that 99 of 100 do not exceed, and the largest.
fn p99(values: &mut [f64]) -> (f64, f64) {
    values.sort_by(f64::total_cmp);
    (values[values.len() * 99 / 100], values[values.len() - 1])
}

impl Errors {
    /// Draws one triangle and compares its inner pixels.
    fn add(&mut self, corners: [Vec3; 3], near: f64) {
        let uvs = [Vec2::new(0.1, 0.9), Vec2::new(1.0, 0.2), Vec2::new(0.0, 0.0)];
        let mesh = Mesh { uvs: [Some(uvs.to_vec()), None], ..mesh(&corners, &[[0, 1, 2]]) };
        let camera = ahead(perspective(60.0, near, INF));
        let (frame, stats) = draw(&alone(mesh, DAffine3::IDENTITY), &camera, SIZE);
        let mut ideal = Ideal::new(&view(&camera, SIZE), &DAffine3::IDENTITY, corners);
        if stats.triangles.n_clipped == 0 {
            // Interpolation is between the corners as they were snapped.
            for corner in &mut ideal.corners {
                let snapped = (corner.truncate() / corner.z * 256.0).map(f64::round_ties_even);
                *corner = (snapped / 256.0 * corner.z).extend(corner.z);
            }
        }
        let corners = corners.map(|p| p.as_dvec3());
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let range = corners.iter().fold(0.0_f64, |r, p| r.max((*p - middle).length()));
        for pixel in 0..frame.len() {
            let (x, y) = (pixel as u32 % SIZE[0], pixel as u32 / SIZE[0]);
            let place = ideal.at(x, y);
            if frame.id[pixel] == 0 || !place.inside {
                continue;
            }
            let blend = |values: [DVec3; 3]| {
                values[0] * place.weights.x
                    + values[1] * place.weights.y
                    + values[2] * place.weights.z
            };
            let uv: DVec2 = blend(uvs.map(|uv| uv.as_dvec2().extend(0.0))).truncate();
            self.uv.push((frame.uv[pixel].as_dvec2() - uv).abs().max_element());
            let off = frame.position[pixel].as_dvec3() - blend(corners);
            self.position.push(off.abs().max_element() / range);
            self.depth.push((f64::from(frame.depth[pixel]) / place.w - 1.0).abs());
        }
    }

    #[track_caller]
    fn assert_small(mut self, what: &str) {
        assert!(self.uv.len() > 10_000, "{what}: {} pixels", self.uv.len());
        let [uv, position, depth] =
            [&mut self.uv, &mut self.position, &mut self.depth].map(|v| p99(v));
        for (name, (p99, worst)) in [("uv", uv), ("position", position), ("depth", depth)] {
            println!("{what}: {name} p99 {p99:.1e}, worst {worst:.1e}");
        }
        assert!(uv.0 <= 1e-5, "{what}: uv {uv:?}");
        assert!(position.0 <= 1e-5, "{what}: position {position:?}");
        assert!(depth.0 <= 1.3e-6, "{what}: depth {depth:?}");
    }
}

/// Corners all over the picture and beyond it, at distances `near..far`.
fn seen(random: &mut Random, spread: f64, distances: [f64; 2]) -> [Vec3; 3] {
    let middle = [0; 2].map(|_| random.within(-0.4, 0.4));
    [0; 3].map(|_| {
        let distance = random.within(distances[0], distances[1]);
        let [x, y] = middle.map(|m| m + random.within(-spread, spread));
        DVec3::new(x * distance, y * distance, -distance).as_vec3()
    })
}

fn n_triangles() -> usize {
    if long_mode() { 4_000 } else { 400 }
}

#[test]
fn triangles_in_the_view() {
    let mut random = Random::new(31);
    let mut errors = Errors::default();
    for _ in 0..n_triangles() {
        errors.add(seen(&mut random, 0.7, [0.5, 20.0]), 0.1);
    }
    errors.assert_small("in the view");
}

#[test]
fn small_triangles() {
    let mut random = Random::new(32);
    let mut errors = Errors::default();
    for _ in 0..20 * n_triangles() {
        errors.add(seen(&mut random, 0.06, [2.0, 3.0]), 0.1);
    }
    errors.assert_small("small");
}

#[test]
fn triangles_through_the_near_plane() {
    let mut random = Random::new(33);
    let mut errors = Errors::default();
    for _ in 0..2 * n_triangles() {
        let corner = |r: &mut Random| DVec3::from_array([0; 3].map(|_| r.within(-6.0, 6.0)));
        errors.add([0; 3].map(|_| corner(&mut random).as_vec3()), 0.1);
    }
    errors.assert_small("near-clipped");
}

#[test]
fn ground_planes() {
    let mut errors = Errors::default();
    for size in [10.0, 100.0, 1e4, 1e6_f32] {
        for height in [-1.7, -0.5, 3.0] {
            let corner = |x: f32, z: f32| Vec3::new(x * size, height, z * size);
            errors.add([corner(-2.0, -1.0), corner(0.1, 3.0), corner(2.5, -1.2)], 0.1);
        }
    }
    errors.assert_small("ground");
}
