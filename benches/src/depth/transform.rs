//! What one combined single-precision matrix does to the order of close points.
//!
//! The usual way to the screen: projection and view multiplied into one 4x4 of f32, points in f32,
//! z over w in f32. Cullet does not go that way; this measures what it avoids. Points of a pair
//! lie on one ray from the eye; the true order is that of their rounded coordinates, in f64.

use cullet::{Camera, Projection};
use glam::{DMat4, DVec3, Mat4};

/// How depth is mapped.
#[derive(Clone, Copy, Debug)]
pub struct Depth {
    /// 1 at near instead of 0.
    pub reversed: bool,
    /// May be infinite.
    pub far: f64,
}

const NEAR: f64 = 0.1;

/// Share of pairs, `codes` codes of standard f32 depth apart, at distances 1 to 1e4, that come out
/// in the wrong order, and share that comes out equal.
pub fn swapped(depth: Depth, codes: f64, n: u32) -> [f64; 2] {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let (mut n_swapped, mut n_equal, mut n_pairs) = (0, 0, 0);
    while n_pairs < n {
        let mut vector =
            |reach: f64| DVec3::from_array([0; 3].map(|_| reach * (2.0 * random.unit() - 1.0)));
        let (eye, ahead, aside) = (vector(10.0), vector(1.0), vector(0.3));
        let lens = Projection::Perspective { yfov: 1.0, near: NEAR, far: depth.far };
        let Ok(camera) = Camera::look_at(eye, eye + ahead, DVec3::Y, lens) else { continue };
        let clip_from_world = combined(&camera, depth);
        let ray = -camera.back() + aside - camera.back() * camera.back().dot(aside);
        let distance = 10_f64.powf(4.0 * random.unit());
        // One code of standard depth, d = 1 - near / z up to the far plane's share: z^2 / near.
        let code = distance * distance / NEAR * f64::from(f32::EPSILON) / 2.0;
        let points = [distance, distance + codes * code].map(|z| (eye + ray * z).as_vec3());
        let truth = points.map(|p| -(p.as_dvec3() - eye).dot(camera.back()));
        if truth[0] >= truth[1] || truth[1] >= depth.far {
            continue;
        }
        let seen = points.map(|p| {
            let clip = clip_from_world * p.extend(1.0);
            clip.z / clip.w
        });
        let [near, far] = if depth.reversed { [seen[1], seen[0]] } else { seen };
        n_pairs += 1;
        n_swapped += u32::from(near > far);
        n_equal += u32::from(near == far);
    }
    [n_swapped, n_equal].map(|count| f64::from(count) / f64::from(n))
}

/// Projection times view, each rounded to f32 and multiplied in f32.
fn combined(camera: &Camera, depth: Depth) -> Mat4 {
    let mut clip_from_view = camera.window(1.5).clip_from_view();
    if !depth.reversed {
        // 1 - depth: w is -z in view space.
        let flip = DMat4::from_cols(
            glam::DVec4::X,
            glam::DVec4::Y,
            glam::DVec4::new(0.0, 0.0, -1.0, 0.0),
            glam::DVec4::new(0.0, 0.0, 1.0, 1.0),
        );
        clip_from_view = flip * clip_from_view;
    }
    let world_from_view = DMat4::from_cols(
        camera.right().extend(0.0),
        camera.up().extend(0.0),
        camera.back().extend(0.0),
        camera.eye().extend(1.0),
    );
    clip_from_view.as_mat4() * world_from_view.inverse().as_mat4()
}

/// xorshift64* (Vigna 2016).
struct Random(u64);

impl Random {
    /// In `0.0..1.0`.
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1u64 << 53) as f64
    }
}
