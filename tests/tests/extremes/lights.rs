//! Lights at the ends of their ranges (numerics 4, item 12), as far as culling knows them: a light
//! with a radius changes nothing beyond it, so culling by that radius may never lose a lit point.

use cullet::cull::{Frustum, LightRange, Sphere, light_visible};
use cullet::transform::{Camera, Projection};
use cullet_tests::{Random, long_mode};
use glam::DVec3;

use crate::{INF, perspective};

/// The window of Karis 2013: 1 at the light, exactly 0 from its radius on. As the text has it,
/// for a distance and a radius in scene units.
fn karis(distance: f64, radius: f64) -> f64 {
    let ratio = distance / radius;
    let rest = 1.0 - ratio * ratio * (ratio * ratio);
    let window = if rest > 0.0 { rest } else { 0.0 }; // NaN, which 0 / 0 gives, is dark
    window * window / (distance * distance + 1.0)
}

fn camera(lens: Projection) -> (Camera, Frustum) {
    let eye = DVec3::new(3.0, -1.0, 2.0);
    let camera = Camera::look_at(eye, DVec3::new(-4.0, 2.0, -9.0), DVec3::Y, lens).unwrap();
    let frustum = Frustum::from_camera(&camera, 1.5);
    (camera, frustum)
}

/// Which lights `light_visible` keeps is seen from the lit points: none may go dark.
#[test]
fn no_point_that_a_kept_or_dropped_light_reaches_changes() {
    let mut random = Random::new(51);
    let (mut n_dropped, mut n_lit) = (0, 0);
    for lens in
        [perspective(60.0, 0.1, INF), perspective(1e-3, 0.1, 1e4), perspective(179.99, 1e-6, 1e9)]
    {
        let (camera, frustum) = camera(lens);
        let window = camera.window(1.5);
        for _ in 0..if long_mode() { 200_000 } else { 5_000 } {
            let radius = [0.0, 1e-30, 1.0, 10.0, 1e6][random.integer(0, 4) as usize];
            let distance = 10_f64.powf(random.within(-1.0, 3.9));
            let [u, v] = [0; 2].map(|_| random.within(0.0, 1.0));
            let seen = window.at(u, v, distance);
            let seen = camera.eye()
                + camera.right() * seen.x
                + camera.up() * seen.y
                + camera.back() * seen.z;
            // The light: somewhere about a radius from the seen point, and on it now and then.
            let aside = DVec3::from_array([0; 3].map(|_| random.within(-1.0, 1.0)));
            let center = seen + aside * (1.2 * radius);
            let light = LightRange::Ball(Sphere { center, radius });
            let brightness = karis((center - seen).length(), radius);
            assert!(brightness.is_finite() && brightness >= 0.0);
            let kept = light_visible(&light, &frustum);
            assert!(kept || brightness == 0.0, "{light:?} lights {seen} by {brightness}");
            n_dropped += u32::from(!kept);
            n_lit += u32::from(brightness > 0.0);
        }
    }
    assert!(n_dropped > 100 && n_lit > 1000, "{n_dropped} dropped, {n_lit} lit");
}

#[test]
fn lights_at_the_ends_of_their_ranges() {
    let (camera, frustum) = camera(perspective(60.0, 0.1, INF));
    let ball =
        |center, radius| light_visible(&LightRange::Ball(Sphere { center, radius }), &frustum);
    let ahead = camera.eye() - camera.back() * 5.0;
    let behind = camera.eye() + camera.back() * 5.0;
    // Dark, but sets are closed: a point in the view touches it.
    assert!(ball(ahead, 0.0) && !ball(behind, 0.0));
    assert!(ball(behind, f64::INFINITY) && ball(behind, 1e308) && ball(behind, 5.2));
    assert!(!ball(behind, 4.0) && !ball(ahead, -1.0));
    assert!(ball(behind, f64::NAN) && ball(DVec3::NAN, 1.0));
    for radius in [0.0, 1.0, f64::INFINITY] {
        for distance in [0.0, 1.0, 1e30, 1e200, f64::INFINITY] {
            let brightness = karis(distance, radius);
            assert!((0.0..=1.0).contains(&brightness), "{distance} of {radius}: {brightness}");
            assert!(distance < radius || brightness == 0.0 || radius == f64::INFINITY);
        }
    }
}
