//! Picture sizes, lenses and places of the camera (numerics 3 and 4, items 5 to 8).

use cullet::transform::{Kind, View};
use cullet::{
    Camera, CullTest, Frame, Pass, Passes, Prepared, Region, Settings, Viewport, ViewportError,
};
use cullet_tests::{Random, bytes, long_mode, prepare, render};
use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};

use crate::ideal::{EDGE, Ideal, check};
use crate::{
    INF, ahead, alone, assert_finite, cube, double_sided, draw, look, n_shown, perspective, scene,
    settings, square, view,
};

const SIZE: [u32; 2] = [64, 48];

fn direction(random: &mut Random) -> DVec3 {
    DVec3::from_array([0; 3].map(|_| random.within(-1.0, 1.0))).normalize()
}

/// Cubes all around the origin, `reach` far at most, on places that are multiples of
/// `reach / 1024`.
fn cubes(n: usize, reach: f64) -> Vec<DAffine3> {
    let mut random = Random::new(11);
    let mut place = || {
        let at = [0; 3].map(|_| random.integer(-1024, 1024) as f64 / 1024.0 * reach);
        let turn = DQuat::from_axis_angle(direction(&mut random), random.within(0.0, 6.0));
        let size = DVec3::splat(reach * random.within(0.02, 0.1));
        DAffine3::from_scale_rotation_translation(size, turn, at.into())
    };
    (0..n).map(|_| place()).collect()
}

fn cube_scene(places: &[DAffine3]) -> Prepared {
    let objects: Vec<_> = places.iter().map(|&place| (cube(), place)).collect();
    prepare(scene(double_sided(), &objects))
}

#[test]
fn odd_sizes_are_drawn() {
    let camera = ahead(perspective(60.0, 0.1, INF));
    let corners =
        [Vec3::new(-9.0, -0.2, -1.0), Vec3::new(8.0, -0.6, -1.0), Vec3::new(0.0, 7.0, -2.0)];
    for size in [[1, 1], [1, 7], [13, 1], [127, 31], [7919, 3], [2, 8191], [16384, 1], [1, 16384]] {
        assert!(check(&camera, size, DAffine3::IDENTITY, corners) > 0, "{size:?}");
        let (frame, _) = draw(&cube_scene(&cubes(9, 4.0)), &camera, size);
        assert_eq!(frame.rgba8.len(), size[0] as usize * size[1] as usize);
        assert_finite(&frame);
    }
}

#[test]
fn impossible_sizes_are_errors() {
    for [width, height] in [[0, 0], [0, 9], [9, 0]] {
        assert_eq!(Viewport::new(width, height), Err(ViewportError::Empty(width, height)));
    }
    for [width, height] in [[65535, 1], [1, 65535], [32769, 32769], [u32::MAX, u32::MAX]] {
        assert_eq!(Viewport::new(width, height), Err(ViewportError::TooLarge(width, height)));
    }
}

/// The corners of the largest pictures, a region at a time: coordinates as far out as they come.
#[test]
fn the_corners_of_the_largest_pictures_are_in_place() {
    let mut random = Random::new(18);
    for size in [[16384, 16384], [32768, 32768], [32768, 1], [1, 32768], [32749, 31]] {
        let [width, height] = size;
        let part = [width.min(48), height.min(32)];
        let camera = ahead(perspective(60.0, 0.1, INF));
        for (x, y) in [
            (0, 0),
            (width - part[0], 0),
            (0, height - part[1]),
            (width - part[0], height - part[1]),
        ] {
            for _ in 0..if long_mode() { 100 } else { 5 } {
                let window = camera.window(f64::from(width) / f64::from(height));
                // Corners around the region, and one far away.
                let around = |start: u32, n: u32, side: u32, r: &mut Random| {
                    (f64::from(start) + f64::from(n) * r.within(-0.5, 1.5)) / f64::from(side)
                };
                let mut corner = |far: bool| {
                    let u = around(x, part[0], width, &mut random);
                    let v = around(y, part[1], height, &mut random);
                    let [u, v] = if far { [u + 0.7, 0.3 - v] } else { [u, v] };
                    window.at(u, v, random.within(1.0, 4.0)).as_vec3()
                };
                let corners = [corner(false), corner(false), corner(true)];
                let prepared = alone(crate::mesh(&corners, &[[0, 1, 2]]), DAffine3::IDENTITY);
                let region = Region { x, y, width: part[0], height: part[1] };
                let settings = Settings { region: Some(region), ..settings() };
                let frame = render(&prepared, &camera, size, &settings);
                assert_eq!([frame.width, frame.height], part);
                let ideal = Ideal::new(&view(&camera, size), &DAffine3::IDENTITY, corners);
                for (i, &id) in frame.triangle.iter().enumerate() {
                    let (px, py) = (x + i as u32 % part[0], y + i as u32 / part[0]);
                    let expected = ideal.at(px, py);
                    assert!(
                        (id == 1) == expected.inside || expected.border <= EDGE,
                        "{size:?} at {px}, {py}: {id}, {:.5} px from the border",
                        expected.border
                    );
                }
            }
        }
    }
}

#[test]
fn the_largest_square_is_drawn() {
    if !long_mode() {
        return;
    }
    let size = [16384, 16384];
    let settings = Settings { passes: Passes::COLOR.with(Pass::Id), ..Settings::default() };
    let camera = ahead(perspective(60.0, 0.1, INF));
    let place = DAffine3::from_translation(DVec3::new(0.0, 0.0, -1.0));
    let frame = render(&alone(square(), place), &camera, size, &settings);
    assert_eq!(n_shown(&frame), 16384 * 16384);
}

#[test]
fn every_field_of_view_sees_triangles_where_they_are() {
    let mut random = Random::new(12);
    for degrees in [1e-3, 0.1, 1.0, 60.0, 179.0, 179.99] {
        for _ in 0..if long_mode() { 1000 } else { 40 } {
            let eye = direction(&mut random) * 5.0;
            let camera = look(eye, eye + direction(&mut random), perspective(degrees, 0.1, INF));
            let window = camera.window(4.0 / 3.0);
            let axes = DMat3::from_cols(camera.right(), camera.up(), camera.back());
            let corners = [0; 3].map(|_| {
                let [u, v] = [0; 2].map(|_| random.within(-0.3, 1.3));
                (eye + axes * window.at(u, v, random.within(0.5, 60.0))).as_vec3()
            });
            check(&camera, SIZE, DAffine3::IDENTITY, corners);
        }
    }
}

#[test]
fn every_lens_gives_finite_pictures_that_culling_does_not_change() {
    let mut random = Random::new(13);
    let prepared = cube_scene(&cubes(60, 50.0));
    let mut shown = 0;
    for degrees in [1e-3, 1.0, 90.0, 179.0, 179.99] {
        for (near, far) in [(0.1, INF), (1e-6, 1e9), (1e-6, 1e12), (1e-6, INF), (1.0, 30.0)] {
            // Where the lens is narrow, something is in the middle.
            let target = prepared.items()[random.integer(0, 59) as usize].bounds.center();
            let camera = look(DVec3::new(60.0, 5.0, 9.0), target, perspective(degrees, near, far));
            let (frame, _) = draw(&prepared, &camera, SIZE);
            assert_finite(&frame);
            shown += n_shown(&frame);
            let settings = Settings { cull: CullTest::None, threads: 1, ..settings() };
            let whole = render(&prepared, &camera, SIZE, &settings);
            assert!(bytes(&frame) == bytes(&whole), "{degrees} degrees, near {near}, far {far}");
        }
    }
    assert!(shown > 5000, "{shown}");
}

#[test]
fn without_a_far_plane_boxes_are_seen_at_any_distance() {
    let mut random = Random::new(14);
    let camera =
        look(DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 1.0, -9.0), perspective(60.0, 0.01, INF));
    let view = view(&camera, SIZE);
    let axes = DMat3::from_cols(camera.right(), camera.up(), camera.back());
    for distance in [1e3, 1e9, 1e20, 1e30, 1e36] {
        for _ in 0..20 {
            let ([u, v], size) = ([0; 2].map(|_| random.within(0.05, 0.95)), 0.03 * distance);
            let middle = camera.eye() + axes * view.window().at(u, v, distance);
            let place = DAffine3::from_scale_rotation_translation(
                DVec3::splat(size),
                DQuat::IDENTITY,
                middle,
            );
            let (frame, stats) = draw(&alone(cube(), place), &camera, SIZE);
            assert_eq!(stats.objects.n_outside, 0, "{distance}");
            let (x, y) = (u * f64::from(SIZE[0]), v * f64::from(SIZE[1]));
            assert_eq!(frame.id[y as usize * SIZE[0] as usize + x as usize], 1, "{distance}");
            let depth = f64::from(frame.depth[y as usize * SIZE[0] as usize + x as usize]);
            assert!((depth / distance - 1.0).abs() < 0.1, "{depth} at {distance}");
        }
    }
}

/// Two image-parallel squares that fill the picture, at the distances whose reversed depths are
/// `codes[0]` and `codes[1]` steps of f32 farther than that of `distance`.
fn pair(camera: &Camera, distance: f64, codes: [f64; 2]) -> Prepared {
    let window = camera.window(4.0 / 3.0);
    let inverse_far = 1.0 / window.far;
    let reversed = |d: f64| (1.0 / d - inverse_far) / (1.0 / window.near - inverse_far);
    let code = reversed(distance) as f32;
    let step = f64::from(code) - f64::from(code.next_down());
    let squares = codes.map(|n| {
        let depth = f64::from(code) - n * step;
        let d = 1.0 / (depth * (1.0 / window.near - inverse_far) + inverse_far);
        let turn = DMat3::from_cols(camera.right(), camera.up(), camera.back());
        let middle = camera.eye() - camera.back() * d;
        let size = DMat3::from_diagonal(DVec3::splat(9.0 * d));
        (square(), DAffine3 { matrix3: turn * size, translation: middle })
    });
    prepare(scene(double_sided(), &squares))
}

#[test]
fn planes_two_depth_codes_apart_are_told_apart_everywhere() {
    let turned = |lens| look(DVec3::ZERO, DVec3::new(0.3, -0.8, 0.6), lens);
    for (near, far) in [(1e-6, 1e9), (1e-6, 1e12), (1e-6, INF), (0.1, INF), (0.1, 1e4)] {
        let lens = perspective(70.0, near, far);
        for camera in [ahead(lens), turned(lens)] {
            for distance in [2.0 * near, 1.0, 77.7, 9e3, 1e6, 5e8, 1e11, 1e20] {
                if distance >= 0.99 * far {
                    continue;
                }
                let shows = |codes, expected: u32| {
                    for threads in [1, 3] {
                        let settings =
                            Settings { threads, passes: Passes::NONE.with(Pass::Id), ..settings() };
                        let frame =
                            render(&pair(&camera, distance, codes), &camera, SIZE, &settings);
                        let n = frame.id.iter().filter(|&&id| id != expected).count();
                        assert_eq!(n, 0, "near {near}, far {far}, at {distance}, codes {codes:?}");
                    }
                };
                for start in [0.0, 0.25, 0.5] {
                    shows([start, start + 2.0], 1);
                    shows([start + 2.0, start], 2);
                }
                // Inside one code the first drawn is seen, whichever is nearer.
                shows([-0.2, 0.2], 1);
                shows([0.2, -0.2], 1);
            }
        }
    }
}

/// `frame` without what world space itself changes.
fn without_place(frame: &Frame) -> Frame {
    Frame { position: Vec::new(), ..frame.clone() }
}

#[test]
fn a_world_moved_together_with_its_camera_shows_the_same_bytes() {
    let offset = DVec3::new(134217728.0, 0.0, -134217728.0);
    let places = cubes(40, 8.0);
    let moved = |place: &DAffine3| DAffine3 { translation: place.translation + offset, ..*place };
    let there: Vec<_> = places.iter().map(moved).collect();
    let (here, there) = (cube_scene(&places), cube_scene(&there));
    let mut shown = 0;
    for eye in [DVec3::new(9.5, 3.25, 7.125), DVec3::ZERO, DVec3::new(-0.5, 6.0, 0.0)] {
        let target = DVec3::new(0.75, -0.5, -1.0);
        for lens in [perspective(60.0, 0.1, INF), perspective(1.0, 0.5, 99.0)] {
            let (a, _) = draw(&here, &look(eye, target, lens), SIZE);
            let (b, _) = draw(&there, &look(eye + offset, target + offset, lens), SIZE);
            shown += n_shown(&a);
            assert!(bytes(&without_place(&a)) == bytes(&without_place(&b)), "{eye} {lens:?}");
            for ((a, b), id) in a.position.iter().zip(&b.position).zip(&a.id) {
                let expected =
                    if *id == 0 { Vec3::ZERO } else { (a.as_dvec3() + offset).as_vec3() };
                assert!((*b - expected).abs().max_element() <= 16.0, "{b} {expected}");
            }
        }
    }
    assert!(shown > 500, "{shown}");
}

#[test]
fn a_world_moved_anywhere_keeps_its_edges() {
    let mut random = Random::new(15);
    for reach in [1e3, 1e6, 1e7, 1e9] {
        for _ in 0..40 {
            let offset = direction(&mut random) * reach;
            let camera =
                look(offset + DVec3::new(0.3, 0.2, 7.0), offset, perspective(50.0, 0.1, INF));
            let corners = [0; 3].map(|_| (direction(&mut random) * 3.0).as_vec3());
            check(&camera, SIZE, DAffine3::from_translation(offset), corners);
        }
    }
}

#[test]
fn nested_scales_that_cancel_change_no_byte() {
    let (tiny, huge) = (2_f64.powi(-20), 2_f64.powi(20));
    let camera = look(DVec3::new(9.0, 3.0, 7.0), DVec3::ZERO, perspective(60.0, 0.1, INF));
    let places = cubes(30, 6.0);
    let (expected, _) = draw(&cube_scene(&places), &camera, SIZE);
    for (outer, inner) in [(tiny, huge), (huge, tiny), (tiny, 1.0), (huge, 1.0)] {
        let [outer_node, inner_node] =
            [outer, inner].map(|s| DAffine3::from_scale(DVec3::splat(s)));
        let objects: Vec<_> = places
            .iter()
            .map(|place| {
                // What the nodes leave over, the mesh brings.
                let mut mesh = cube();
                mesh.positions.iter_mut().for_each(|p| *p /= (outer * inner) as f32);
                let mut place = *place;
                place.translation /= outer;
                (mesh, outer_node * place * inner_node)
            })
            .collect();
        let (frame, _) = draw(&prepare(scene(double_sided(), &objects)), &camera, SIZE);
        assert!(n_shown(&frame) > 100, "{}", n_shown(&frame));
        assert!(bytes(&frame) == bytes(&expected), "{outer} {inner}");
    }
}

#[test]
fn every_scale_keeps_its_edges() {
    let mut random = Random::new(16);
    for exponent in -6..=6 {
        let scale = 10_f64.powi(exponent);
        for _ in 0..20 {
            let eye = direction(&mut random) * 6.0 * scale;
            let lens = perspective(50.0, 0.01 * scale, INF);
            let corners = [0; 3].map(|_| (direction(&mut random) * 3.0).as_vec3());
            let camera = look(eye, DVec3::ZERO, lens);
            let node = DAffine3::from_scale(DVec3::splat(scale));
            assert!(check(&camera, SIZE, node, corners) > 0);
            // Through the node or in the mesh.
            let baked = corners.map(|p| (p.as_dvec3() * scale).as_vec3());
            assert!(check(&camera, SIZE, DAffine3::IDENTITY, baked) > 0);
        }
    }
}

/// The scene, the camera and its lens a power of two smaller: nothing in the picture knows.
#[test]
fn tiny_worlds_look_like_large_ones() {
    let at = |scale: f64| {
        let mut mesh = cube();
        mesh.positions.iter_mut().for_each(|p| *p = (p.as_dvec3() * scale).as_vec3());
        let camera = look(
            DVec3::new(3.0, 1.5, 4.0) * scale,
            DVec3::ZERO,
            perspective(60.0, 0.1 * scale, INF),
        );
        let (frame, _) = draw(&alone(mesh, DAffine3::IDENTITY), &camera, SIZE);
        assert_finite(&frame);
        Frame { depth: Vec::new(), ..without_place(&frame) }
    };
    let expected = at(1.0);
    assert!(n_shown(&expected) > 300);
    for exponent in [-149, -140, -126, -60, 60, 120] {
        assert!(bytes(&at(2_f64.powi(exponent))) == bytes(&expected), "2^{exponent}");
    }
}

/// Section 1: a position on the screen is within 2^-10 px of the ideal one.
#[test]
fn corners_are_where_they_should_be() {
    let mut random = Random::new(17);
    let mut worst = 0.0_f64;
    for degrees in [1e-3, 1.0, 60.0, 179.0, 179.99] {
        for offset in [0.0, 1e4, 1e8] {
            for _ in 0..200 {
                let [at, shift, ahead] = [0; 3].map(|_| direction(&mut random));
                let eye = at * offset;
                let camera =
                    look(eye, eye + ahead * (1.0 + offset), perspective(degrees, 0.1, INF));
                let view: View = view(&camera, [1920, 1080]);
                let window = view.window();
                assert_eq!(window.kind, Kind::Perspective);
                let [u, v] = [0; 2].map(|_| random.within(0.0, 1.0));
                let distance = random.within(1.0, 1e3);
                let axes = DMat3::from_cols(camera.right(), camera.up(), camera.back());
                let point = (axes * window.at(u, v, distance) - shift).as_vec3();
                let node = DAffine3::from_translation(eye + shift);
                // Relative to the eye, then along its axes, in the order the text says.
                let relative = (node.translation - eye) + point.as_dvec3();
                let depth = -relative.dot(camera.back());
                let half = 540.0 / (0.5 * degrees.to_radians()).tan();
                let expected = [
                    960.0 + half * (relative.dot(camera.right()) / depth),
                    540.0 - half * (relative.dot(camera.up()) / depth),
                ];
                let clip = cullet::transform::ClipPoint::from_model(
                    &view.clip_from_model(&node),
                    point.as_dvec3(),
                );
                let screen = view.viewport().screen_from_ndc(clip.ndc());
                worst =
                    worst.max((screen.x - expected[0]).abs()).max((screen.y - expected[1]).abs());
            }
        }
    }
    println!("worst screen position: {worst:.2e} px");
    assert!(worst <= 1.0 / 1024.0, "{worst} px");
}
