//! Properties over random scenes, against brute force. Seeded, so that every run is the same.

use cullet::cull::{Aabb, PlaneMask};
use cullet::scene::{Mesh, Node, Object, Scene};
use cullet::transform::ClipPoint;
use cullet::{Camera, CullTest, Frame, Projection, Renderer, Settings, View, Viewport};
use cullet_tests::{all_passes, bytes, prepare, render};
use glam::{DAffine3, DQuat, DVec3, Vec3};
use proptest::prelude::*;
use proptest::test_runner::{RngAlgorithm, TestRng, TestRunner};

const SIZE: [u32; 2] = [48, 32];

/// The same cases in every run, and no file of past failures.
fn runner(cases: u32) -> TestRunner {
    let config = ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() };
    TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha))
}

/// A cube of side 2 around the origin.
fn cube() -> Mesh {
    let corner =
        |i: u32| Vec3::from_array([0, 1, 2].map(|b| if i >> b & 1 == 1 { 1.0 } else { -1.0 }));
    let quads =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
    Mesh {
        name: "cube".into(),
        positions: (0..8).map(corner).collect(),
        triangles: quads.into_iter().flat_map(halves).collect(),
        ..Mesh::default()
    }
}

fn scene(placements: &[DAffine3]) -> Scene {
    let node = Node { name: "root".into(), parent: None, world_from_node: DAffine3::IDENTITY };
    let object = |(i, placement): (usize, &DAffine3)| Object {
        name: format!("cube {i}"),
        node: 0,
        mesh: 0,
        material: 0,
        world_from_model: *placement,
    };
    Scene {
        name: "cubes".into(),
        objects: placements.iter().enumerate().map(object).collect(),
        meshes: vec![cube()],
        materials: vec![Default::default()],
        nodes: vec![node],
        ..Scene::default()
    }
}

fn vector(reach: f64) -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(-reach..reach).prop_map(DVec3::from_array)
}

fn placement() -> impl Strategy<Value = DAffine3> {
    (vector(6.0), vector(3.0), prop::array::uniform3(-1.5..1.5f64)).prop_map(|(at, turn, scale)| {
        let turn = DQuat::from_scaled_axis(turn);
        DAffine3::from_scale_rotation_translation(DVec3::from_array(scale), turn, at)
    })
}

fn camera() -> impl Strategy<Value = Camera> {
    (vector(7.0), vector(4.0), 0.1..3.0f64, 0.01..1.0f64, prop::bool::ANY).prop_filter_map(
        "a possible camera",
        |(eye, target, yfov, near, finite)| {
            let far = if finite { 8.0 } else { f64::INFINITY };
            let lens = Projection::Perspective { yfov, near, far };
            Camera::look_at(eye, target, DVec3::Y, lens).ok()
        },
    )
}

#[test]
fn no_test_throws_out_what_would_be_seen_and_none_changes_a_byte() {
    let cases = (prop::collection::vec(placement(), 1..12), camera());
    runner(96)
        .run(&cases, |(placements, camera)| {
            let prepared = prepare(scene(&placements));
            let draw = |cull, hierarchy| {
                let settings =
                    Settings { cull, hierarchy, passes: all_passes(), ..Settings::default() };
                render(&prepared, &camera, SIZE, &settings)
            };
            let whole = bytes(&draw(CullTest::None, false));
            for cull in CullTest::ALL {
                for hierarchy in [false, true] {
                    prop_assert!(bytes(&draw(cull, hierarchy)) == whole, "{cull:?} {hierarchy}");
                }
            }
            Ok(())
        })
        .unwrap();
}

#[test]
fn what_is_called_inside_has_every_corner_inside_in_clip_space() {
    let viewport = Viewport::new(SIZE[0], SIZE[1]).unwrap();
    runner(2000)
        .run(&(placement(), camera()), |(placement, camera)| {
            let prepared = prepare(scene(&[placement]));
            let view = View::new(&camera, viewport);
            let frustum = cullet::cull::Frustum::from_camera(&camera, viewport.aspect());
            let bounds: Aabb = prepared.items()[0].bounds;
            let asked = PlaneMask::ALL;
            let Some(cutting) = cullet::cull::planes_cutting(&bounds, &frustum, asked) else {
                return Ok(());
            };
            let clip_from_model = view.clip_from_model(&placement);
            for position in cube().positions {
                let corner = ClipPoint::from_model(&clip_from_model, position.as_dvec3());
                for plane in corner.outcode().iter() {
                    prop_assert!(cutting.contains(plane), "{corner:?} is outside of {plane}");
                }
            }
            Ok(())
        })
        .unwrap();
}

/// A closed surface seen from outside covers each of its pixels by exactly one front face: with
/// only front faces drawn, and again with only back faces, the same pixels are covered.
#[test]
fn front_and_back_of_a_closed_surface_cover_the_same_pixels() {
    let covered = |frame: &Frame| -> Vec<bool> { frame.id.iter().map(|&id| id > 0).collect() };
    runner(300)
        .run(&(vector(3.0), 1.0..40.0f64), |(turn, distance)| {
            let turned = DAffine3::from_quat(DQuat::from_scaled_axis(turn));
            let front = prepare(scene(&[turned]));
            let mut back = scene(&[turned]);
            back.meshes[0].triangles.iter_mut().for_each(|t| t.swap(1, 2));
            let back = prepare(back);
            let lens = Projection::Perspective { yfov: 0.9, near: 0.01, far: f64::INFINITY };
            let eye = DVec3::Z * (2.0 + distance);
            let camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Y, lens).unwrap();
            let view = View::new(&camera, Viewport::new(SIZE[0], SIZE[1]).unwrap());
            let settings = Settings { passes: all_passes(), ..Settings::default() };
            let [front, back] = [&front, &back].map(|prepared| {
                let mut frame = Frame::default();
                Renderer::default().render(prepared, &view, &settings, &mut frame);
                covered(&frame)
            });
            prop_assert_eq!(front, back);
            Ok(())
        })
        .unwrap();
}
