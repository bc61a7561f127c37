//! The scenes that `cullet synth extreme:NAME` makes, so that what a user sees of the extremes is
//! what is tested: the same bytes however they are drawn, numbers everywhere, and for each what it
//! is there to show. What each must do is in `docs/extremes.md`.

use cullet::cull::wide::levels;
use cullet::scene::synth::{EXTREMES, synth};
use cullet::{CullTest, Frame, Pass, Passes, Prepared, Renderer, RendererKind, Settings, View};
use cullet_tests::{bytes, own_cameras, prepare, prepare_synth, render};

use crate::{assert_finite, n_shown, settings, view};

const SIZE: [u32; 2] = [128, 72];

fn with(prepared: &Prepared, settings: &Settings) -> Frame {
    render(prepared, &own_cameras(prepared)[0], SIZE, settings)
}

/// The scene of that name by its own camera.
fn drawn(name: &str) -> Frame {
    with(&prepare_synth(&format!("extreme:{name}")), &settings())
}

/// The scene and its ordinary twin.
fn both(name: &str) -> [Frame; 2] {
    [drawn(name), drawn(&format!("{name}:ordinary"))]
}

fn n_differing<T: PartialEq>(a: &[T], b: &[T]) -> usize {
    a.iter().zip(b).filter(|(a, b)| a != b).count()
}

fn n_pixels_of(frame: &Frame, object: u32) -> usize {
    frame.id.iter().filter(|&&id| id == object).count()
}

#[test]
fn however_an_extreme_is_drawn_its_bytes_are_the_same() {
    for (name, _) in EXTREMES {
        let prepared = prepare_synth(&format!("extreme:{name}"));
        let plain = Settings { threads: 1, cull: CullTest::None, hierarchy: false, ..settings() };
        let expected = with(&prepared, &plain);
        assert_finite(&expected);
        assert!(n_shown(&expected) > 100, "{name}: {} pixels", n_shown(&expected));
        let expected = bytes(&expected);
        let mut variants = Vec::new();
        for (i, cull) in CullTest::ALL.into_iter().enumerate() {
            let hierarchy = i % 2 == 0;
            variants.push(Settings { threads: 1 + i % 4, cull, hierarchy, ..settings() });
            variants.push(Settings { threads: 2, cull, hierarchy: !hierarchy, ..settings() });
        }
        for (_, simd) in levels() {
            variants.push(Settings { threads: 3, simd, ..settings() });
        }
        for (tile_px, occlusion) in [(8, true), (24, false), (256, true)] {
            variants.push(Settings { tile_px, occlusion, ..settings() });
        }
        for variant in variants {
            assert!(bytes(&with(&prepared, &variant)) == expected, "{name}: {variant:?}");
        }
    }
}

/// The ray caster, which knows neither clipping nor guard bands, sees the same objects, but for a
/// pixel here and there on an edge: 36 at most, in `huge`, where all edges are clipped and none is
/// snapped, so that both decide within .004 px of them.
///
/// Not where depths tie on purpose: there the rasterizer goes by codes and the lowest number, which
/// other tests hold it to, and the ray caster by what is left of a distance in f64.
#[test]
fn the_ray_caster_sees_the_same_extremes() {
    for (name, _) in EXTREMES.iter().filter(|(name, _)| !["ties", "depth"].contains(name)) {
        let prepared = prepare_synth(&format!("extreme:{name}"));
        let raster = with(&prepared, &settings());
        let renderer = RendererKind::Raycast { snapped: true };
        let cast = with(&prepared, &Settings { renderer, cull: CullTest::None, ..settings() });
        let n = n_differing(&raster.id, &cast.id);
        println!("{name}: {n} of {} pixels show another object", raster.len());
        assert!(n <= raster.len() / 250, "{name}: {n}");
    }
}

#[test]
fn bad_vertices_leave_all_other_pixels_alone() {
    let bad = synth("extreme:not-a-number").unwrap();
    let mut clean = bad.clone();
    let mesh = &mut clean.meshes[0];
    let is_sound = |t: &[u32; 3]| t.iter().all(|i| mesh.positions[*i as usize].is_finite());
    mesh.triangles.retain(is_sound);
    let n_bad = (bad.meshes[0].triangles.len() - mesh.triangles.len()) as u64;
    let [bad, clean] = [bad, clean].map(prepare);
    let passes = Pass::ALL.into_iter().filter(|pass| *pass != Pass::Triangle).collect();
    let settings = Settings { passes, ..settings() };
    assert!(bytes(&with(&bad, &settings)) == bytes(&with(&clean, &settings)));

    let mut frame = Frame::default();
    let view: View = view(&own_cameras(&bad)[0], SIZE);
    let stats = Renderer::default().render(&bad, &view, &settings, &mut frame);
    assert!(n_bad > 100);
    assert_eq!(stats.triangles.n_not_finite, n_bad);
}

/// All corners outside the depth range, and no pixel below the horizon without ground.
#[test]
fn the_ground_reaches_the_horizon() {
    let frame = drawn("ground");
    let horizon = frame.id.iter().position(|&id| id == 1).unwrap() / SIZE[0] as usize;
    assert!((30..40).contains(&horizon), "{horizon}");
    let below = &frame.id[(horizon + 1) * SIZE[0] as usize..];
    assert!(below.iter().all(|&id| id > 0));
}

#[test]
fn without_area_there_is_nothing() {
    let prepared = prepare_synth("extreme:no-area");
    let view = view(&own_cameras(&prepared)[0], SIZE);
    let mut frame = Frame::default();
    let stats = Renderer::default().render(&prepared, &view, &settings(), &mut frame);
    assert!(stats.triangles.n_zero_area > 0);
    assert!(n_pixels_of(&frame, 1) > 100, "needles");
    assert_eq!(n_pixels_of(&frame, 2), 0, "what has no area");
}

/// Numbers beyond all bounds, and ordinary ones that draw the same lines.
#[test]
fn distance_size_and_lens_do_not_show() {
    for name in ["huge", "wide", "far", "depth", "offset", "nested-scales"] {
        let [extreme, ordinary] = both(name);
        let n = n_differing(&extreme.id, &ordinary.id);
        println!("{name}: {n} pixels differ from the ordinary twin");
        assert!(n <= 4, "{name}: {n} pixels");
    }
    // Sums that are exact leave no trace at all.
    for name in ["offset", "nested-scales"] {
        let [extreme, ordinary] = both(name).map(|frame| Frame { position: Vec::new(), ..frame });
        assert!(bytes(&extreme) == bytes(&ordinary), "{name}");
    }
}

#[test]
fn every_distance_is_seen() {
    let frame = drawn("far");
    for object in 1..=8 {
        assert!(n_pixels_of(&frame, object) > 200, "sphere {object}");
    }
    let depths = frame.depth.iter().filter(|depth| depth.is_finite());
    let farthest = depths.fold(0.0_f32, |a, b| a.max(*b));
    assert!(farthest > 0.8e30, "{farthest}");
}

/// Green squares hide the red ones behind them, 3e-7 of the distance farther.
#[test]
fn the_nearer_of_a_pair_is_seen() {
    let [extreme, ordinary] = both("depth");
    for pair in 0..8 {
        let (red, green) = (2 * pair + 1, 2 * pair + 2);
        assert!(n_pixels_of(&extreme, green) > 100, "pair {pair}");
        let [a, b] = [&extreme, &ordinary].map(|frame| n_pixels_of(frame, red));
        assert!(a.abs_diff(b) <= 2, "pair {pair}: {a} red pixels, {b} expected");
    }
}

/// Each square alone says where it is; where several are, the first in the scene is seen.
#[test]
fn in_one_plane_the_first_is_seen() {
    let scene = synth("extreme:ties").unwrap();
    let alone = |object: usize| {
        let mut scene = scene.clone();
        scene.objects = vec![scene.objects[object].clone()];
        with(&prepare(scene), &settings())
    };
    let alone = [0, 1, 2].map(alone);
    let frame = drawn("ties");
    let mut n_overlaps = 0;
    for (pixel, &id) in frame.id.iter().enumerate() {
        let there = [0, 1, 2].map(|k: usize| alone[k].id[pixel] > 0);
        let first = there.iter().position(|&there| there);
        assert_eq!(id, first.map_or(4, |k| k as u32 + 1), "pixel {pixel}");
        n_overlaps += usize::from(there.iter().filter(|&&there| there).count() > 1);
    }
    assert!(n_overlaps > 100, "{n_overlaps}");
}

#[test]
fn flat_balls_are_discs_and_points_are_nothing() {
    let frame = drawn("flattened");
    let shown = [1, 2, 3, 4].map(|object| n_pixels_of(&frame, object));
    assert!(shown[..3].iter().all(|&n| n > 10) && shown[3] == 0, "{shown:?}");
    let lengths = frame.normal.iter().zip(&frame.id).filter(|(_, id)| **id > 0);
    assert!(lengths.into_iter().all(|(normal, _)| (normal.length() - 1.0).abs() < 1e-5));
}

/// Above and below, the same knot is seen from one side and the other of its middle: as large.
#[test]
fn mirrored_nodes_have_the_faces_of_mirrored_meshes() {
    let [extreme, ordinary] = both("mirrored");
    for k in 0..4 {
        let [node, mesh] = [2 * k + 1, 2 * k + 2].map(|object| n_pixels_of(&extreme, object));
        let [plain_node, plain_mesh] =
            [2 * k + 1, 2 * k + 2].map(|object| n_pixels_of(&ordinary, object));
        assert!(node > 100 && mesh > 100, "{k}: {node} and {mesh} pixels");
        // Faces drawn inside out would leave holes or show the far side.
        let (extreme, ordinary) = (node.abs_diff(mesh), plain_node.abs_diff(plain_mesh));
        assert!(extreme <= ordinary + 40, "{k}: {node} and {mesh}, {plain_node} and {plain_mesh}");
    }
}

/// Where coordinates run faster than any texel, the coarsest level answers: one colour.
#[test]
fn endless_coordinates_show_the_coarsest_level() {
    let prepared = prepare_synth("extreme:textures");
    let passes = Passes::COLOR.with(Pass::Albedo).with(Pass::Id);
    let frame = with(&prepared, &Settings { passes, ..settings() });
    for object in [6, 7] {
        let of = |(albedo, id): (&glam::Vec4, &u32)| (*id == object).then_some(*albedo);
        let colors: Vec<_> = frame.albedo.iter().zip(&frame.id).filter_map(of).collect();
        assert!(colors.len() > 100);
        assert!(colors.iter().all(|color| *color == colors[0]), "object {object}");
        let average = (colors[0].truncate() - glam::Vec3::splat(0.25)).abs().max_element();
        assert!(average < 0.25, "no average of many colours: {}", colors[0]);
    }
}

#[test]
fn denormals_are_as_large_as_their_twin() {
    let [extreme, ordinary] = both("denormals").map(|frame| n_shown(&frame));
    assert!(extreme > 1000 && extreme.abs_diff(ordinary) < ordinary / 50, "{extreme} {ordinary}");
}
