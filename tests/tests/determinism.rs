//! One picture, whoever draws it: every number of threads, instruction set and way of culling, in
//! all combinations (`invariance.rs` tries more scenes and cameras, one setting at a time).

use std::hash::{DefaultHasher, Hash, Hasher};

use cullet::cull::wide::levels;
use cullet::{
    Antialias, Arithmetic, Camera, CullTest, Division, EdgeShading, Encoding, Filter, PointLight,
    Prepared, Settings,
};
use cullet_tests::{all_passes, bytes, own_cameras, prepare_synth, render};
use glam::Vec3;

/// Several tiles each way, the last ones cut.
const SIZE: [u32; 2] = [200, 137];

fn hash(prepared: &Prepared, camera: &Camera, settings: &Settings) -> u64 {
    let mut hasher = DefaultHasher::new();
    bytes(&render(prepared, camera, SIZE, settings)).hash(&mut hasher);
    hasher.finish()
}

/// Ways to go about it: what is culled, how, and in tiles of which size. The plainest first.
fn ways(what: &Settings) -> Vec<Settings> {
    let mut ways = Vec::new();
    for (cull, hierarchy) in [
        (CullTest::None, false),
        (CullTest::Both, false),
        (CullTest::Both, true),
        (CullTest::Sat, true),
    ] {
        for occlusion in [false, true] {
            for tile_px in [256, 64, 24] {
                ways.push(Settings { cull, hierarchy, occlusion, tile_px, ..*what });
            }
        }
    }
    ways
}

#[track_caller]
fn check(spec: &str) {
    let prepared = prepare_synth(spec);
    for antialias in [Antialias::None, Antialias::Msaa4] {
        let passes = all_passes();
        check_with(spec, &prepared, &Settings { antialias, passes, ..Settings::default() });
    }
}

/// Everything about shading that is otherwise by default, and a light that reaches some of the scene.
#[track_caller]
fn check_other_shading(spec: &str) {
    let prepared = prepare_synth(spec);
    let bounds = prepared.bounds();
    let size = bounds.half_extent().length();
    let place = bounds.center() + 0.2 * size;
    let light = PointLight::new(place, Vec3::new(9.0, 5.0, 2.0), (0.3 * size) as f32).unwrap();
    let other = Settings {
        point_light: Some(light),
        filter: Filter::TrilinearLog,
        arithmetic: Arithmetic::Sixteen,
        division: Division::Approximate,
        encoding: Encoding::Polynomial,
        antialias: Antialias::Msaa4,
        edge_shading: EdgeShading::Centre,
        ..Settings::default()
    };
    check_with(spec, &prepared, &other);
}

#[track_caller]
fn check_with(spec: &str, prepared: &Prepared, what: &Settings) {
    let camera = own_cameras(prepared).swap_remove(0);
    let ways = ways(what);
    let plain = Settings { threads: 1, ..ways[0] };
    let expected = hash(prepared, &camera, &plain);
    let empty = Settings { min_size_px: 1e9, ..plain };
    assert_ne!(hash(prepared, &camera, &empty), expected, "{spec}: nothing to see");
    // Every number of threads with the defaults; with each other way a quarter of them, in turn.
    let threads = |i: usize| (1..=16).filter(move |threads| threads % 4 == i % 4);
    let ways = ways.into_iter().enumerate().map(|(i, way)| (way, threads(i).collect::<Vec<_>>()));
    for (way, threads) in ways.chain([(*what, (1..=16).collect())]) {
        for (level, simd) in levels() {
            for &threads in &threads {
                let settings = Settings { threads, simd, ..way };
                let same = hash(prepared, &camera, &settings) == expected;
                assert!(same, "{spec}: {level}, {settings:?}");
            }
        }
    }
}

#[test]
fn a_city_is_the_same_all_over_the_grid() {
    check("city:2");
}

#[test]
fn cut_out_leaves_are_the_same_all_over_the_grid() {
    check("masks");
}

#[test]
fn tiny_triangles_are_the_same_all_over_the_grid() {
    check("sphere:96");
}

#[test]
fn every_other_choice_of_shading_is_the_same_all_over_the_grid() {
    check_other_shading("city:2");
    check_other_shading("knots");
}
