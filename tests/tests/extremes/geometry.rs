//! Triangles that are not numbers, have no area, go through the eye, or never end
//! (numerics 4, items 1 to 4 and 10).

use cullet::raster::{Fixed, reference};
use cullet::scene::Mesh;
use cullet::{Camera, CullTest, Projection, Settings, frame_scene};
use cullet_tests::{Random, bytes, long_mode, prepare, render};
use glam::{DAffine3, DVec3, Vec3};

use crate::ideal::check;
use crate::{
    INF, ahead, alone, cube, double_sided, draw, look, mesh, n_shown, perspective, scene, settings,
    square,
};

const SIZE: [u32; 2] = [64, 48];

/// Sides that are powers of two: ties of the 1/256 px snap stay exact on their way to the screen.
const EXACT: [u32; 2] = [64, 32];

fn n_cases() -> usize {
    if long_mode() { 10_000 } else { 300 }
}

/// A camera of which one unit is one pixel of [`EXACT`], and the point at pixel coordinates `(x, y)`.
fn pixels() -> Camera {
    ahead(Projection::Orthographic { height: f64::from(EXACT[1]), near: 0.0, far: 2.0 })
}

fn at(x: f32, y: f32) -> Vec3 {
    Vec3::new(x - EXACT[0] as f32 / 2.0, EXACT[1] as f32 / 2.0 - y, -1.0)
}

fn within(random: &mut Random, reach: f64) -> Vec3 {
    DVec3::from_array([0; 3].map(|_| random.within(-reach, reach))).as_vec3()
}

#[test]
fn a_corner_that_is_no_number_drops_its_triangle_and_nothing_else() {
    let far_out = [Vec3::new(90.0, -70.0, 20.0), Vec3::new(0.5, 80.0, -60.0)];
    let base = || prepare(scene(double_sided(), &[(cube(), DAffine3::IDENTITY)]));
    let clean = base();
    let camera = frame_scene(&clean, 4.0 / 3.0);
    let (expected, stats) = draw(&clean, &camera, SIZE);
    assert_eq!((stats.triangles.n_not_finite, stats.objects.n_empty), (0, 0));
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for axis in 0..3 {
            for own_object in [false, true] {
                let mut corner = Vec3::splat(0.25);
                corner[axis] = bad;
                let mut list = scene(double_sided(), &[(cube(), DAffine3::IDENTITY)]);
                if own_object {
                    let bad = mesh(&[corner, far_out[0], far_out[1]], &[[0, 1, 2]]);
                    let whole = [(cube(), DAffine3::IDENTITY), (bad, DAffine3::IDENTITY)];
                    list = scene(double_sided(), &whole);
                } else {
                    let mesh = &mut list.meshes[0];
                    mesh.positions.extend([corner, far_out[0], far_out[1]]);
                    mesh.triangles.push([9, 8, 10]);
                }
                let prepared = prepare(list);
                let (frame, stats) = draw(&prepared, &camera, SIZE);
                let case = format!("{corner}, own object: {own_object}");
                assert_eq!(stats.triangles.n_not_finite, 1, "{case}");
                assert!(bytes(&frame) == bytes(&expected), "{case}");
                assert_eq!(frame_scene(&prepared, 4.0 / 3.0), camera, "{case}");
            }
        }
    }
}

/// Numbers in the mesh, but not on the screen: a node takes them beyond f64.
#[test]
fn what_a_node_makes_endless_is_dropped_and_nothing_else() {
    let camera = look(DVec3::new(3.0, 4.0, 5.0), DVec3::ZERO, perspective(60.0, 0.1, INF));
    let (expected, _) = draw(&alone(cube(), DAffine3::IDENTITY), &camera, SIZE);
    assert!(n_shown(&expected) > 100);
    for scale in [1e280, 1e308, f64::MAX] {
        let huge = mesh(&[Vec3::MAX, Vec3::MIN, Vec3::new(1e30, -3e38, 2e38)], &[[0, 1, 2]]);
        let place = DAffine3::from_scale(DVec3::splat(scale));
        let objects = [(cube(), DAffine3::IDENTITY), (huge, place)];
        let prepared = prepare(scene(double_sided(), &objects));
        for threads in [1, 3] {
            let settings = Settings { threads, ..settings() };
            let frame = render(&prepared, &camera, SIZE, &settings);
            assert!(bytes(&frame) == bytes(&expected), "scale {scale}, {threads} threads");
        }
    }
}

#[test]
fn triangles_through_the_eye_plane_end_where_they_should() {
    let mut random = Random::new(1);
    let mut shown = 0;
    for _ in 0..n_cases() {
        let near = [1e-6, 0.01, 0.1, 1.0][random.integer(0, 3) as usize];
        let far = [INF, 6.0, 1e9][random.integer(0, 2) as usize];
        let camera = look(
            within(&mut random, 3.0).as_dvec3(),
            within(&mut random, 3.0).as_dvec3(),
            perspective(random.within(20.0, 150.0), near, far),
        );
        let corners = [0; 3].map(|_| within(&mut random, 8.0));
        shown += usize::from(check(&camera, SIZE, DAffine3::IDENTITY, corners) > 0);
    }
    assert!(shown * 5 > n_cases(), "{shown} triangles were seen");
}

#[test]
fn corners_at_and_behind_the_eye() {
    let tiny = f32::from_bits(1);
    let depths = [0.0, -0.0, tiny, -tiny, 1e-30, -1e-30, 0.1, -0.1, -3.0, 5.0];
    let mut random = Random::new(2);
    for near in [1e-6, 0.1] {
        let camera = ahead(perspective(60.0, near, INF));
        for a in depths {
            for b in depths {
                let mut corners = [0; 3].map(|_| within(&mut random, 4.0));
                (corners[0].z, corners[1].z, corners[2].z) = (a, b, -2.0);
                check(&camera, SIZE, DAffine3::IDENTITY, corners);
                // The eye itself is a corner.
                corners[0] = Vec3::ZERO;
                check(&camera, SIZE, DAffine3::IDENTITY, corners);
                corners[2].z = 2.0;
                let [a, b] = [a, b].map(|z| z.max(0.0));
                (corners[0].z, corners[1].z) = (a, b);
                let n = check(&camera, SIZE, DAffine3::IDENTITY, corners);
                assert_eq!(n, 0, "behind the eye: {corners:?}");
            }
        }
    }
}

/// A ground plane of one triangle whose corners are all behind the eye or beyond `far`.
#[test]
fn the_ground_does_not_vanish_however_large() {
    for size in [1e3_f32, 1e6, 1e9, 1e12, 1e17, 1e24, 1e30, 1e38] {
        for (near, far) in [(0.1, 100.0), (0.01, 1e6), (1e-6, 500.0), (0.1, INF), (1e-6, INF)] {
            // The depth of a corner 1e10 times beyond the far plane no longer knows that plane.
            if f64::from(size) > 1e10 * far {
                continue;
            }
            let camera = ahead(perspective(60.0, near, far));
            for height in [-1.7, 0.25, 40.0] {
                let corner = |x: f32, z: f32| Vec3::new(x * size, height, z * size);
                let corners = [corner(-2.0, -1.0), corner(0.1, 3.0), corner(2.5, -1.2)];
                let n = check(&camera, SIZE, DAffine3::IDENTITY, corners);
                assert!(n > 200, "{n} pixels of a ground plane of size {size}, far {far}");
            }
        }
    }
}

#[test]
fn the_ground_under_a_turned_camera() {
    let mut random = Random::new(3);
    for size in [1e2, 1e4, 1e6, 1e8_f32] {
        for _ in 0..n_cases() / 20 {
            let corner = |x: f32, z: f32| Vec3::new(x * size, 0.0, z * size);
            let corners = [corner(-2.0, -1.0), corner(0.1, 3.0), corner(2.5, -1.2)];
            let eye = DVec3::new(0.0, random.within(1.0, 9.0), 0.0);
            let target = eye + within(&mut random, 5.0).as_dvec3();
            let camera = look(eye, target, perspective(60.0, 0.1, 300.0));
            check(&camera, SIZE, DAffine3::IDENTITY, corners);
        }
    }
}

#[test]
fn what_has_no_area_shows_nothing() {
    let (a, b, c) = (at(8.5, 8.5), at(40.5, 24.5), at(24.5, 16.5));
    let flat = [[a, a, a], [a, b, a], [b, a, a], [a, b, c], [c, b, a]];
    let level = [[at(8.5, 8.5), at(30.5, 8.5), at(20.5, 8.5)], [at(8.5, 8.5), at(8.5, 30.5), a]];
    // Thinner than the grid of 1/256 px: the corners snap onto one line.
    let thin = [[at(8.5, 8.5), at(40.5, 8.5), at(20.5, 8.5 + 1.0 / 1024.0)]];
    for corners in flat.iter().chain(&level).chain(&thin) {
        let prepared = alone(mesh(corners, &[[0, 1, 2]]), DAffine3::IDENTITY);
        let (frame, stats) = draw(&prepared, &pixels(), EXACT);
        assert_eq!(n_shown(&frame), 0, "{corners:?}");
        assert_eq!(stats.triangles.n_zero_area, 1, "{corners:?}");
    }
}

/// The rule of coverage for a triangle given in pixels, as long as it stays in the guard band.
#[track_caller]
fn check_rule(corners: [[f32; 2]; 3]) -> usize {
    let fixed = corners.map(|[x, y]| {
        let units = |px: f32| (f64::from(px) * 256.0).round_ties_even() as i64;
        Fixed { x: units(x), y: units(y) }
    });
    let prepared = alone(mesh(&corners.map(|[x, y]| at(x, y)), &[[0, 1, 2]]), DAffine3::IDENTITY);
    let (frame, _) = draw(&prepared, &pixels(), EXACT);
    for (i, &id) in frame.triangle.iter().enumerate() {
        let (x, y) = (i as i64 % i64::from(EXACT[0]), i as i64 / i64::from(EXACT[0]));
        assert_eq!(id == 1, reference::covers::<8>(fixed, x, y), "{corners:?} at {x}, {y}");
    }
    n_shown(&frame)
}

#[test]
fn slivers_are_drawn_by_the_rule() {
    let mut random = Random::new(4);
    let mut shown = 0;
    for _ in 0..n_cases() {
        // Exact in f32 also after the shift to the middle of the picture.
        let units =
            |r: &mut Random, side: u32| r.integer(-999, i64::from(side) * 512) as f32 / 512.0;
        let end = |r: &mut Random| [units(r, EXACT[0]), units(r, EXACT[1])];
        let (a, b) = (end(&mut random), end(&mut random));
        let step = |r: &mut Random| r.integer(-2, 2) as f32 / 512.0;
        let c = [b[0] + step(&mut random), b[1] + step(&mut random)];
        shown += check_rule([a, b, c]);
    }
    assert!(shown > 0);
}

#[test]
fn inside_the_guard_band_the_rule_holds() {
    let mut random = Random::new(5);
    for reach in [1e4, 16_000.0] {
        for _ in 0..n_cases() / 3 {
            // Even halves of a pixel: exact, and often on centres.
            let corner = |r: &mut Random| {
                [0; 2].map(|_| (r.within(-reach, reach) as f32 * 2.0).round() / 2.0)
            };
            check_rule([0; 3].map(|_| corner(&mut random)));
        }
    }
}

#[test]
fn beyond_the_guard_band_edges_stay_in_place() {
    let mut random = Random::new(6);
    let mut shown = 0;
    for exponent in [4.0, 4.5, 5.0, 6.0, 7.0, 8.0, 9.0, 15.0, 30.0, 38.4] {
        for _ in 0..n_cases() / 10 {
            let reach = 10_f64.powf(exponent);
            let corners = [0; 3].map(|_| {
                let corner = within(&mut random, 1.0).as_dvec3() * reach;
                Vec3::new(corner.x as f32, corner.y as f32, -1.0)
            });
            shown += usize::from(check(&pixels(), EXACT, DAffine3::IDENTITY, corners) > 0);
            let camera = ahead(perspective(90.0, 0.5, INF));
            shown += usize::from(check(&camera, SIZE, DAffine3::IDENTITY, corners) > 0);
            // One corner at home, two far out.
            let mut long = corners;
            long[0] = Vec3::new(random.within(-0.5, 0.5) as f32, 0.1, -1.0);
            check(&camera, SIZE, DAffine3::IDENTITY, long);
        }
    }
    assert!(shown > n_cases() / 5, "{shown}");
}

#[test]
fn coordinates_up_to_the_largest_number() {
    let mut random = Random::new(7);
    for exponent in [10.0, 20.0, 30.0, 38.4] {
        for _ in 0..n_cases() / 4 {
            let corner =
                |r: &mut Random| (within(r, 1.0).as_dvec3() * 10_f64.powf(exponent)).as_vec3();
            let corners = [0; 3].map(|_| corner(&mut random));
            let (near, far) = [(0.1, INF), (1e-6, 1e30), (0.1, 1e3)][random.integer(0, 2) as usize];
            check(&ahead(perspective(75.0, near, far)), SIZE, DAffine3::IDENTITY, corners);
        }
    }
}

/// Objects that lie in one another at the same depth, `n` in all.
fn pile(n: usize, reversed: bool) -> Vec<(Mesh, DAffine3)> {
    let mut turned = square();
    turned.triangles.iter_mut().for_each(|t| t.rotate_left(1));
    let kinds = [
        (square(), DAffine3::IDENTITY),
        (turned, DAffine3::IDENTITY),
        (square(), DAffine3::from_scale(DVec3::new(1.5, 0.5, 1.0))),
        (square(), DAffine3::from_rotation_z(std::f64::consts::FRAC_PI_2)),
    ];
    let back = DAffine3::from_translation(DVec3::new(0.0, 0.0, -4.0));
    let place = |i: usize| {
        let (mesh, place) = &kinds[i % kinds.len()];
        (mesh.clone(), back * *place)
    };
    if reversed { (0..n).rev().map(place).collect() } else { (0..n).map(place).collect() }
}

#[test]
fn of_equally_near_things_the_first_is_seen() {
    let camera = ahead(perspective(45.0, 0.1, INF));
    for (n, reversed) in [(2, false), (2, true), (4, false), (4, true), (3000, false)] {
        let objects = pile(n, reversed);
        let [all, first] =
            [&objects[..], &objects[..1]].map(|list| prepare(scene(double_sided(), list)));
        let drawn = |prepared, threads| {
            render(prepared, &camera, SIZE, &Settings { threads, ..settings() })
        };
        let (one, first) = (drawn(&all, 1), drawn(&first, 1));
        assert!(n_shown(&first) > 300);
        for (id, first) in one.id.iter().zip(&first.id) {
            assert!(*first == 0 || *id == 1, "{n} objects, reversed: {reversed}: {id}");
        }
        for threads in [2, 3, 8] {
            assert!(bytes(&drawn(&all, threads)) == bytes(&one), "{threads} threads, {n} objects");
        }
        for cull in CullTest::ALL {
            for hierarchy in [false, true] {
                let settings = Settings { cull, hierarchy, threads: 2, ..settings() };
                let culled = render(&all, &camera, SIZE, &settings);
                assert!(bytes(&culled) == bytes(&one), "{cull:?}, {hierarchy}, {n} objects");
            }
        }
    }
}

#[test]
fn of_equal_triangles_of_one_mesh_the_first_is_seen() {
    // Long enough for several jobs.
    let n = 10_000;
    let mesh = mesh(&square().positions, &vec![[0, 1, 2]; n]);
    let back = DAffine3::from_translation(DVec3::new(0.0, 0.0, -3.0));
    let prepared = alone(mesh, back);
    for threads in [1, 2, 8] {
        let settings = Settings { threads, ..settings() };
        let frame = render(&prepared, &ahead(perspective(45.0, 0.1, INF)), [24, 18], &settings);
        assert!(n_shown(&frame) > 50 && frame.triangle.iter().all(|&t| t <= 1));
    }
}
