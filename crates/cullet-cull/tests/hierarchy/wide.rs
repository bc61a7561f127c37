//! The wide test against its scalar twin, at every level, and against the f64 test.

use crate::worlds::{Random, cameras, city, odd_boxes, random_boxes};
use cullet_cull::wide::{Boxes8, Coarse8, Level, levels, reference};
use cullet_cull::{Aabb, Frustum, PlaneMask, planes_cutting};
use cullet_transform::{Camera, Projection};
use glam::DVec3;

/// One list of boxes from every corner of the trade.
fn sets() -> Vec<(String, Vec<Aabb>)> {
    let mut random = Random(1);
    let mut sets = vec![
        ("random".into(), random_boxes(&mut random, 4000, 500.0, 20.0)),
        ("city".into(), city(&mut random, 4000)),
        ("odd".into(), odd_boxes(&mut random, 500)),
        ("none".into(), vec![]),
        ("all empty".into(), vec![Aabb::EMPTY; 9]),
        ("all nan".into(), vec![Aabb::NAN; 9]),
    ];
    for scale in [1e-30, 1e30] {
        let boxes = random_boxes(&mut random, 500, 500.0 * scale, 20.0 * scale);
        sets.push((format!("scaled by {scale}"), boxes));
    }
    for offset in [1e7, f64::from(1 << 27)] {
        let mut boxes = random_boxes(&mut random, 500, 500.0, 20.0);
        let offset = DVec3::new(offset, 0.0, -offset);
        boxes.iter_mut().for_each(|b| *b = Aabb { min: b.min + offset, max: b.max + offset });
        sets.push((format!("moved by {offset}"), boxes));
    }
    sets
}

#[test]
fn every_level_gives_the_bits_of_the_twin() {
    let mut random = Random(2);
    for (name, boxes) in sets() {
        let wide = Boxes8::new(&boxes);
        let coarse = Coarse8::new(wide.clone());
        for frustum in cameras(&mut random, &boxes, 20) {
            let expected = reference::cutting(&wide, &frustum);
            for (level_name, level) in levels() {
                let mut verdicts = vec![None; wide.len()];
                wide.cutting_into(&frustum, level, &mut verdicts);
                assert_eq!(verdicts, expected, "{name} {level_name}");
                let mut bits = vec![0; wide.n_groups()];
                wide.visible_into(&frustum, level, &mut bits);
                for (i, verdict) in expected.iter().enumerate() {
                    let bit = bits[i / 8] >> (i % 8) & 1 != 0;
                    assert_eq!(bit, verdict.is_some(), "{name} {level_name} {i}");
                }
                let mut again = vec![0xaa; wide.n_groups()];
                coarse.visible_into(&frustum, level, &mut again);
                assert_eq!(again, bits, "{name} {level_name}");
            }
        }
    }
}

#[test]
fn what_f64_keeps_is_kept_and_what_is_called_inside_is_inside() {
    let mut random = Random(3);
    let (mut n_kept, mut n_kept_f64) = (0, 0);
    for (name, boxes) in sets() {
        let wide = Boxes8::new(&boxes);
        for frustum in cameras(&mut random, &boxes, 50) {
            for (i, verdict) in reference::cutting(&wide, &frustum).into_iter().enumerate() {
                let exact = planes_cutting(&boxes[i], &frustum, PlaneMask::ALL);
                n_kept += usize::from(verdict.is_some());
                n_kept_f64 += usize::from(exact.is_some());
                let Some(exact) = exact else { continue };
                let verdict = verdict.unwrap_or_else(|| panic!("{name}: {i} is lost"));
                assert_eq!(exact.and(verdict), exact, "{name}: {i} is not inside");
            }
        }
    }
    // f32 keeps more, but not noticeably.
    assert!(n_kept - n_kept_f64 <= n_kept_f64 / 10_000, "{n_kept} {n_kept_f64}");
}

/// Corners a few ulps of f32 beside a plane.
#[test]
fn knife_edges_are_never_lost() {
    let mut random = Random(4);
    let mut n_close = 0;
    for round in 0..200 {
        let extent = [1e-20, 1.0, 1e5, 1e20][round % 4];
        let around = random_boxes(&mut random, 8, extent, extent * 0.01);
        let frustum = cameras(&mut random, &around, 1).remove(0);
        let mut boxes = around.clone();
        for _ in 0..64 {
            // A point on a plane of the frustum, between two corners, pushed off a little.
            let index = random.below(5);
            let pick = |random: &mut Random| random.within(-1.0, 1.0) * extent;
            let p = DVec3::from_array(std::array::from_fn(|_| pick(&mut random)));
            let plane = frustum.planes()[index];
            let distance = plane.distance(p - frustum.origin());
            let off = random.within(-1.0, 1.0) * 4e-7 * extent;
            let corner = p - plane.normal * (distance - off);
            let size = DVec3::from_array(std::array::from_fn(|_| random.unit())) * extent * 0.1;
            let outwards = -plane.normal.signum() * size;
            boxes.push(Aabb::from_points([corner, corner + outwards]));
            n_close += 1;
        }
        let wide = Boxes8::new(&boxes);
        for (i, verdict) in reference::cutting(&wide, &frustum).into_iter().enumerate() {
            if planes_cutting(&boxes[i], &frustum, PlaneMask::ALL).is_some() {
                assert!(verdict.is_some(), "{round}: {i} of {n_close} is lost");
            }
        }
        // Closer to the plane than the grid can tell.
        let (mut plain, mut coarse) = (vec![0; wide.n_groups()], vec![0xaa; wide.n_groups()]);
        wide.visible_into(&frustum, Level::new(), &mut plain);
        Coarse8::new(wide).visible_into(&frustum, Level::new(), &mut coarse);
        assert_eq!(coarse, plain, "{round}");
    }
}

/// An eye so far away that a plane's distance in stored units is beyond f32.
#[test]
fn the_grid_follows_planes_beyond_the_range_of_f32() {
    let cube = |i: i32| {
        let min = DVec3::splat(f64::from(i) * 1e-10);
        Aabb { min, max: min + 1e-10 }
    };
    let boxes: Vec<Aabb> = (0..16).map(cube).collect();
    let wide = Boxes8::new(&boxes);
    let coarse = Coarse8::new(wide.clone());
    for distance in [1e20, 1e28, 1e30, 1e200] {
        for (eye, forward) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
            let lens = Projection::Perspective { yfov: 1.0, near: 0.1, far: f64::INFINITY };
            let eye = DVec3::Z * eye * distance;
            let target = eye + DVec3::Z * forward * distance;
            let camera = Camera::look_at(eye, target, DVec3::Y, lens).expect("a camera");
            let frustum = Frustum::from_camera(&camera, 1.0);
            for (name, level) in levels() {
                let (mut plain, mut again) = ([0xaa; 2], [0xaa; 2]);
                wide.visible_into(&frustum, level, &mut plain);
                coarse.visible_into(&frustum, level, &mut again);
                assert_eq!(again, plain, "{name} {eye} {forward}");
                let is_before = eye.z * forward < 0.0;
                assert_eq!(plain, if is_before { [0xff; 2] } else { [0; 2] }, "{name} {eye}");
            }
        }
    }
}
