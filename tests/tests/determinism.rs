//! One picture, whoever draws it: every number of threads, instruction set and way of culling, in
//! all combinations (`invariance.rs` tries more scenes and cameras, one setting at a time).

use std::hash::{DefaultHasher, Hash, Hasher};

use cullet::cull::wide::levels;
use cullet::{Camera, CullTest, Prepared, Settings};
use cullet_tests::{all_passes, bytes, own_cameras, prepare_synth, render};

/// Several tiles each way, the last ones cut.
const SIZE: [u32; 2] = [200, 137];

fn hash(prepared: &Prepared, camera: &Camera, settings: &Settings) -> u64 {
    let mut hasher = DefaultHasher::new();
    bytes(&render(prepared, camera, SIZE, settings)).hash(&mut hasher);
    hasher.finish()
}

/// Ways of culling: with and without the tree.
fn ways() -> Vec<Settings> {
    let mut ways = Vec::new();
    for cull in [CullTest::None, CullTest::Both, CullTest::Sat] {
        for hierarchy in [false, true] {
            ways.push(Settings { cull, hierarchy, passes: all_passes(), ..Settings::default() });
        }
    }
    ways
}

#[track_caller]
fn check(spec: &str) {
    let prepared = prepare_synth(spec);
    let camera = own_cameras(&prepared).swap_remove(0);
    let ways = ways();
    let plain = Settings { threads: 1, ..ways[0] };
    let expected = hash(&prepared, &camera, &plain);
    let empty = Settings { min_size_px: 1e9, ..plain };
    assert_ne!(hash(&prepared, &camera, &empty), expected, "{spec}: nothing to see");
    for way in ways {
        for (level, simd) in levels() {
            for threads in 1..=16 {
                let settings = Settings { threads, simd, ..way };
                let same = hash(&prepared, &camera, &settings) == expected;
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
