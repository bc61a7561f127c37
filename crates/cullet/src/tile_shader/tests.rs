//! Colours of tiles against those of the plain code and of whole pictures.

use cullet_raster::NO_TRIANGLE;
use cullet_scene::synth::synth;
use cullet_shade::{Arithmetic, Division, Encoding, Filter, PointLight};
use cullet_transform::{PlaneMask, Viewport};
use glam::{DVec3, Vec3};

use super::*;
use crate::{
    Antialias, CullTest, Frame, Pass, Prepared, Renderer, Settings, View, camera_of, frame_scene,
};

const SIZE: [u32; 2] = [150, 101];

/// Prepared scenes with their own cameras: textures, colours, masks, mirrored nodes, slivers.
fn scenes() -> Vec<(Prepared, View)> {
    let names = ["interior", "knots", "masks", "slivers:90", "city:3"];
    let scenes = names.into_iter().map(|name| {
        let prepared = Prepared::new(synth(name).unwrap()).unwrap();
        let viewport = Viewport::new(SIZE[0], SIZE[1]).unwrap();
        let camera = prepared.scene().cameras.first().and_then(|own| camera_of(own).ok());
        let camera = camera.unwrap_or_else(|| frame_scene(&prepared, viewport.aspect()));
        (prepared, View::new(&camera, viewport))
    });
    scenes.collect()
}

/// A picture of everything that colours come from, and of the colours.
fn frame(prepared: &Prepared, view: &View, settings: &Settings) -> Frame {
    let mut frame = Frame::default();
    Renderer::default().render(prepared, view, settings, &mut frame);
    frame
}

fn settings() -> Settings {
    let passes = Passes::COLOR.with(Pass::Linear).with(Pass::Triangle);
    Settings { passes, antialias: Antialias::None, threads: 1, ..Settings::default() }
}

/// Calls `check` with a shader for each scene, its picture and the ids of that.
fn for_each_scene(check: impl Fn(&mut TileShader<'_>, &Frame, &[u32])) {
    let settings = settings();
    for (prepared, view) in &scenes() {
        let frame = frame(prepared, view, &settings);
        let ids: Vec<u32> = frame.triangle.iter().map(|id| id.wrapping_sub(1)).collect();
        assert!(ids.iter().any(|id| *id != NO_TRIANGLE));
        // Which planes cut what: with all of them asked about nothing is missed.
        let planes = vec![Some(PlaneMask::ALL); prepared.items().len()];
        let scene = Scene { prepared, view, settings: &settings, planes: &planes };
        check(&mut TileShader::new(scene, &mut ShadeScratch::default()), &frame, &ids);
    }
}

#[test]
fn any_places_in_any_order_have_the_colours_of_the_picture() {
    for_each_scene(|shader, frame, ids| {
        let seen = (0..).zip(ids).filter(|(_, id)| **id != NO_TRIANGLE);
        let seen: Vec<(usize, u32)> = seen.map(|(i, id)| (i, *id)).collect();
        let wanted = |&(i, id): &(usize, u32)| {
            let [x, y] = [i as i32 % SIZE[0] as i32, i as i32 / SIZE[0] as i32];
            Wanted { id, x: 16 * x + 8, y: 16 * y + 8 }
        };
        for step in [1, 7, 64] {
            let part: Vec<_> = seen.iter().rev().step_by(step).collect();
            let wanted: Vec<Wanted> = part.iter().map(|seen| wanted(seen)).collect();
            let mut colors = vec![Vec4::NAN; wanted.len()];
            shader.colors(&wanted, &mut colors);
            for ((i, _), color) in part.iter().zip(&colors) {
                assert_eq!(*color, frame.linear[*i], "pixel {i}, every {step}");
            }
        }
    });
}

#[test]
fn squares_of_pixels_have_the_colour_of_their_middle() {
    for_each_scene(|shader, _, ids| {
        let Scene { prepared, view, .. } = shader.scene;
        let coarse = Settings { shading_rate: ShadingRate::Two, ..settings() };
        let coarse = frame(prepared, view, &coarse);
        let seen = (0..).zip(ids).filter(|(_, id)| **id != NO_TRIANGLE);
        let seen: Vec<(usize, u32)> = seen.map(|(i, id)| (i, *id)).collect();
        let wanted = |&(i, id): &(usize, u32)| {
            let [x, y] = [i as i32 % SIZE[0] as i32, i as i32 / SIZE[0] as i32];
            let [x, y] = [x & !1, y & !1];
            Wanted { id, x: 16 * x + 16, y: 16 * y + 16 }
        };
        let wanted: Vec<Wanted> = seen.iter().map(wanted).collect();
        let mut colors = vec![Vec4::NAN; wanted.len()];
        shader.colors(&wanted, &mut colors);
        for ((i, _), color) in seen.iter().zip(&colors) {
            assert_eq!(*color, coarse.linear[*i], "pixel {i}");
        }
        let ids_too: Vec<u32> = coarse.triangle.iter().map(|id| id.wrapping_sub(1)).collect();
        assert!(ids_too == ids);
        for antialias in [Antialias::None, Antialias::Msaa4] {
            let passes = Passes::COLOR;
            let shading_rate = ShadingRate::Two;
            let whole = Settings { passes, shading_rate, antialias, ..settings() };
            let region = Region { x: 33, y: 21, width: 71, height: 55 };
            let part = Settings { region: Some(region), tile_px: 24, ..whole };
            let (whole, part) = (frame(prepared, view, &whole), frame(prepared, view, &part));
            for (y, row) in part.rgba8.chunks(71).enumerate() {
                let start = (21 + y) * SIZE[0] as usize + 33;
                assert!(row == &whole.rgba8[start..start + 71], "row {y}");
            }
        }
    });
}

/// A sample that the triangle covers is asked of the plain code, at the same place.
#[test]
fn off_centre_colours_are_those_of_the_plain_code() {
    for_each_scene(|shader, _, ids| {
        let scene = shader.scene;
        let mut slots = CornerSlots::default();
        let mut corners = Corners::new(&scene, &mut slots);
        let mut wanted = Vec::new();
        for (i, &id) in ids.iter().enumerate().filter(|(_, id)| **id != NO_TRIANGLE) {
            let [x, y] = [i as i32 % SIZE[0] as i32, i as i32 / SIZE[0] as i32];
            let place = Wanted { id, x: 16 * x + 3, y: 16 * y + 11 };
            let (_, interpolator) = corners.of(id);
            let at = [place.x, place.y].map(|at| f64::from(at) / 16.0);
            let weights = interpolator.fragment_at(at).weights;
            if weights.min_element() > 0.0 && weights != glam::DVec3::splat(1.0 / 3.0) {
                wanted.push(place);
            }
        }
        assert!(wanted.len() > 500);
        let mut colors = vec![Vec4::NAN; wanted.len()];
        shader.colors(&wanted, &mut colors);
        let mut errors: Vec<f32> = Vec::new();
        for (place, color) in wanted.iter().zip(&colors) {
            let (triangle, interpolator) = corners.of(place.id);
            let at = [place.x, place.y].map(|at| f64::from(at) / 16.0);
            let plain = triangle.color(&scene, &interpolator.fragment_at(at));
            errors.push((*color - plain).abs().max_element());
        }
        errors.sort_by(f32::total_cmp);
        let (len, worst) = (errors.len(), errors[errors.len() - 1]);
        // Textures of 512 texels: a place 1e-7 off is 5e-5 of a texel off.
        let (p99, name) = (errors[len * 99 / 100], &scene.prepared.scene().name);
        assert!(p99 < 1e-4 && worst < 2e-3, "{name}: p99 {p99:.1e}, worst {worst:.1e}");
    });
}

/// Outside of its triangle, before and behind the eye, a colour is still a colour.
#[test]
fn places_that_are_not_covered_are_harmless() {
    for_each_scene(|shader, _, ids| {
        let known = ids.iter().filter(|id| **id != NO_TRIANGLE).step_by(11);
        let wanted: Vec<Wanted> = (0..)
            .zip(known)
            .map(|(i, &id)| Wanted {
                id,
                x: i * 7919 % (16 * SIZE[0] as i32),
                y: i * 6367 % (16 * SIZE[1] as i32),
            })
            .collect();
        let mut colors = vec![Vec4::NAN; wanted.len()];
        shader.colors(&wanted, &mut colors);
        assert!(colors.iter().all(|color| color.is_finite()));
    });
}

/// A light that reaches some objects of a scene, and part of some of those.
#[test]
fn a_light_at_a_point_is_that_of_the_plain_code_and_skipped_where_it_ends() {
    for (prepared, view) in &scenes() {
        let bounds = prepared.bounds();
        let size = bounds.half_extent().length();
        let place = bounds.center() + DVec3::new(0.2, 0.2, 0.3) * size;
        let mut pictures = Vec::new();
        for radius in [0.0, 0.3, 1.0, f64::INFINITY] {
            let radius = (radius * size) as f32;
            let light = PointLight::new(place, Vec3::new(9.0, 5.0, 2.0), radius).unwrap();
            let settings = Settings { point_light: Some(light), ..settings() };
            let lit = frame(prepared, view, &settings);
            let all = Settings { cull: CullTest::None, ..settings };
            assert!(frame(prepared, view, &all).linear == lit.linear, "{radius}");
            let planes = vec![Some(PlaneMask::ALL); prepared.items().len()];
            let scene = Scene { prepared, view, settings: &all, planes: &planes };
            let mut slots = CornerSlots::default();
            let mut corners = Corners::new(&scene, &mut slots);
            let mut errors = Vec::new();
            for (i, id) in lit.triangle.iter().enumerate().filter(|(_, id)| **id != 0) {
                let (triangle, interpolator) = corners.of(id - 1);
                let [x, y] = [i as u32 % SIZE[0], i as u32 / SIZE[0]];
                let plain = triangle.color(&scene, &interpolator.fragment(x, y));
                assert!(plain.is_finite());
                errors.push((lit.linear[i] - plain).abs().max_element());
            }
            errors.sort_by(f32::total_cmp);
            assert!(errors[errors.len() * 99 / 100] < 1e-3, "{radius}");
            pictures.push(lit.linear);
        }
        assert!(pictures[0] == frame(prepared, view, &settings()).linear);
        assert!(pictures[3] != pictures[0]);
    }
}

/// Whatever else is asked of shading, what a light does not reach is as without it.
#[test]
fn a_light_that_ends_is_skipped_beside_every_other_choice() {
    let plain = settings();
    let choices = [
        Settings { division: Division::Approximate, ..plain },
        Settings { encoding: Encoding::Table, ..plain },
        Settings { filter: Filter::Anisotropic, ..plain },
        Settings { arithmetic: Arithmetic::Sixteen, ..plain },
    ];
    let mut n_lit = [0; 4];
    for (prepared, view) in &scenes() {
        let bounds = prepared.bounds();
        let size = bounds.half_extent().length();
        for (i, choice) in choices.iter().enumerate() {
            let place = bounds.center() + DVec3::new(0.2, 0.2, 0.3) * size;
            let color = Vec3::new(9.0, 5.0, 2.0);
            let light = PointLight::new(place, color, (0.3 * size) as f32).unwrap();
            let lit = Settings { point_light: Some(light), ..*choice };
            let all = Settings { cull: CullTest::None, ..lit };
            let lit = frame(prepared, view, &lit);
            assert!(frame(prepared, view, &all).linear == lit.linear, "choice {i}");
            n_lit[i] += usize::from(frame(prepared, view, choice).linear != lit.linear);
        }
    }
    assert!(n_lit.iter().all(|n| *n >= 2), "{n_lit:?}");
}

#[test]
fn a_picture_in_parts_is_the_picture() {
    let settings = Settings { passes: Passes::COLOR, ..settings() };
    for (prepared, view) in &scenes() {
        let whole = frame(prepared, view, &settings);
        for region in [
            Region { x: 0, y: 0, width: 150, height: 1 },
            Region { x: 63, y: 62, width: 3, height: 37 },
            Region { x: 149, y: 0, width: 1, height: 101 },
            Region { x: 17, y: 5, width: 100, height: 90 },
        ] {
            let part = Settings { region: Some(region), ..settings };
            let part = frame(prepared, view, &part);
            for y in 0..region.height {
                let start = ((region.y + y) * SIZE[0] + region.x) as usize;
                let width = region.width as usize;
                let row = &part.rgba8[y as usize * width..][..width];
                assert!(row == &whole.rgba8[start..start + width], "{region:?}, row {y}");
            }
        }
    }
}
