//! Trees that change stay sound and give the answers of a tree built anew.

use std::collections::HashSet;

use cullet_cull::wide::{Boxes8, Level, reference};
use cullet_cull::{Aabb, Frustum, Hierarchy, p_vertex_visible};
use cullet_transform::{Camera, Projection};
use glam::DVec3;

use crate::walk::{sets, verdicts};
use crate::worlds::{Random, cameras, city, degenerate, odd_boxes, random_boxes};

/// That `tree` holds exactly `boxes`, where there is one.
#[track_caller]
fn check(tree: &Hierarchy, boxes: &[Option<Aabb>], name: &str) {
    tree.validate().unwrap_or_else(|fault| panic!("{name}: {fault}"));
    assert_eq!(tree.len(), boxes.iter().flatten().count(), "{name}");
    let all: Vec<Aabb> = boxes.iter().map(|b| b.unwrap_or(Aabb::EMPTY)).collect();
    for frustum in cameras(&mut Random(21), &all, 4) {
        let found = verdicts(all.len(), |visit| {
            tree.walk(&frustum, Level::new(), visit);
        });
        // Another origin rounds other boxes: everything visible in f64 must be there.
        for (i, bounds) in all.iter().enumerate() {
            let exact = cullet_cull::planes_cutting(bounds, &frustum, cullet_cull::PlaneMask::ALL);
            assert!(exact.is_none() || found[i].is_some(), "{name}: {i} is lost");
        }
        let flat = reference::cutting(&Boxes8::new(&all), &frustum);
        let n_differ = found.iter().zip(&flat).filter(|(a, b)| a != b).count();
        assert!(n_differ <= 1 + all.len() / 20, "{name}: {n_differ} differ");
    }
}

#[test]
fn refit_fits_moved_boxes() {
    let mut random = Random(22);
    for (name, mut boxes) in sets() {
        let mut tree = Hierarchy::build(&boxes);
        for round in 0..3 {
            for bounds in &mut boxes {
                let step = random.point(0.3);
                *bounds = Aabb { min: bounds.min + step, max: bounds.max + step };
                if round == 2 && random.below(20) == 0 {
                    *bounds = odd_boxes(&mut random, 11)[random.below(11)];
                }
            }
            tree.refit(&boxes);
            let all: Vec<_> = boxes.iter().map(|b| Some(*b)).collect();
            check(&tree, &all, &name);
        }
    }
}

#[test]
fn insertions_and_removals_in_any_order() {
    for seed in 0..12 {
        let mut random = Random(100 + seed);
        let pool = match seed % 4 {
            0 => city(&mut random, 1500),
            1 => odd_boxes(&mut random, 1500),
            2 => random_boxes(&mut random, 1500, 100.0, 30.0),
            _ => degenerate(1500).swap_remove(random.below(7)).1,
        };
        // From a tree of some of them, or none.
        let n_first = [0, 1, 9, 700][random.below(4)];
        let mut boxes: Vec<Option<Aabb>> = vec![None; pool.len()];
        let mut tree = Hierarchy::build(&pool[..n_first]);
        for id in 0..n_first {
            boxes[id] = Some(pool[id]);
        }
        for step in 0..6000 {
            let id = random.below(pool.len());
            let grows = step / 1500 % 2 == 0;
            if random.below(4) < if grows { 3 } else { 1 } {
                let bounds = pool[random.below(pool.len())];
                tree.insert(id as u32, &bounds);
                boxes[id] = Some(bounds);
            } else {
                assert_eq!(tree.remove(id as u32), boxes[id].take().is_some());
            }
            if step % 500 == 0 || step < 20 {
                check(&tree, &boxes, &format!("seed {seed} step {step}"));
            }
        }
        for (id, bounds) in boxes.iter_mut().enumerate() {
            assert_eq!(tree.remove(id as u32), bounds.take().is_some());
        }
        check(&tree, &boxes, "emptied");
        assert!(tree.is_empty() && !tree.remove(0) && !tree.remove(u32::MAX));
    }
}

/// Every order of insertion leaves a shallow tree.
#[test]
fn a_tree_grown_by_insertion_is_shallow() {
    for (name, boxes) in degenerate(20_000) {
        let mut tree = Hierarchy::build(&[]);
        for (id, bounds) in boxes.iter().enumerate() {
            tree.insert(id as u32, bounds);
        }
        tree.validate().unwrap_or_else(|fault| panic!("{name}: {fault}"));
        let quality = tree.quality();
        assert!(quality.depth <= 14, "{name}: {quality:?}");
        assert!(quality.leaf_fill > 0.4, "{name}: {quality:?}");
    }
}

/// Unit cubes around `at`.
fn cubes(random: &mut Random, n: usize, at: DVec3) -> Vec<Aabb> {
    let cube = |center: DVec3| Aabb { min: at + center - 0.5, max: at + center + 0.5 };
    (0..n).map(|_| cube(random.point(300.0).round())).collect()
}

/// The numbers of visible boxes: by the tree, and by f64.
fn n_visible(tree: &Hierarchy, boxes: &[Aabb], at: DVec3) -> (usize, usize) {
    let lens = Projection::Perspective { yfov: 1.0, near: 0.1, far: 1000.0 };
    let eye = at + DVec3::new(0.0, 0.0, 100.0);
    let camera = Camera::look_at(eye, at, DVec3::Y, lens).expect("a camera");
    let frustum = Frustum::from_camera(&camera, 1.0);
    let found: HashSet<u32> =
        tree.visible(&frustum, Level::new()).into_iter().map(|(id, _)| id).collect();
    let exact = (0..).zip(boxes).filter(|(_, b)| p_vertex_visible(b, &frustum));
    let exact: HashSet<u32> = exact.map(|(id, _)| id).collect();
    assert!(exact.is_subset(&found));
    (found.len(), exact.len())
}

#[test]
fn a_world_that_moves_away_takes_its_origin_along() {
    let mut random = Random(41);
    let far = DVec3::new(1e8, -1e8, 1e8);
    let mut boxes = cubes(&mut random, 5000, DVec3::ZERO);
    let mut tree = Hierarchy::build(&boxes);
    boxes.iter_mut().for_each(|b| *b = b.relative_to(-far));
    tree.refit(&boxes);
    tree.validate().unwrap();
    let (found, exact) = n_visible(&tree, &boxes, far);
    assert!(exact > 300 && found <= exact + exact / 100, "{found} {exact}");
    // Three quarters move back, the rest stays as it was stored.
    boxes.iter_mut().for_each(|b| *b = b.relative_to(far));
    tree.refit(&boxes[..3750]);
    tree.validate().unwrap();
    let (found, exact) = n_visible(&tree, &boxes[..3750], DVec3::ZERO);
    assert!(exact > 300 && found <= exact + exact / 100, "{found} {exact}");
    // A world that stays keeps its bits.
    let before = tree.quality();
    tree.refit(&boxes[..3750]);
    assert_eq!(tree.quality(), before);
}

#[test]
fn the_first_insertions_do_not_decide_where_the_tree_is_precise() {
    let mut random = Random(42);
    let far = DVec3::splat(1e8);
    for n_far in [1, 5, 30] {
        let mut boxes = cubes(&mut random, n_far, far);
        boxes.extend(cubes(&mut random, 5000, DVec3::ZERO));
        let mut tree = Hierarchy::build(&[]);
        for (id, bounds) in boxes.iter().enumerate() {
            tree.insert(id as u32, bounds);
        }
        tree.validate().unwrap();
        assert_eq!(tree.len(), boxes.len());
        assert!(tree.quality().n_items + 1024 > boxes.len());
        let (found, exact) = n_visible(&tree, &boxes, DVec3::ZERO);
        // Some joined the tree while it was precise elsewhere.
        assert!(exact > 300 && found <= exact + exact / 100 + 4 * n_far, "{found} {exact}");
    }
}

#[test]
fn two_places_share_a_tree_without_a_long_list_beside_it() {
    let mut random = Random(43);
    let far = DVec3::splat(1e8);
    let (here, there) = (cubes(&mut random, 3000, DVec3::ZERO), cubes(&mut random, 9000, far));
    let mut tree = Hierarchy::build(&here);
    for (id, bounds) in (3000..).zip(&there) {
        tree.insert(id, bounds);
        if id % 500 == 0 {
            assert!(tree.len() - tree.quality().n_items <= 1024);
        }
    }
    tree.validate().unwrap();
    let (boxes, n_all) = ([here, there].concat(), 12_000);
    assert_eq!(tree.len(), n_all);
    n_visible(&tree, &boxes, DVec3::ZERO);
    let (found, exact) = n_visible(&tree, &boxes, far);
    // The origin has followed most boxes: what came after is precise.
    assert!(found < exact + 6000, "{found} {exact}");
    for id in 0..n_all as u32 {
        assert!(tree.remove(id));
    }
    tree.validate().unwrap();
    assert!(tree.is_empty());
}

#[test]
fn insertion_far_away_and_odd_numbers() {
    let mut tree = Hierarchy::build(&[]);
    let cube = |at: f64| Aabb { min: DVec3::splat(at), max: DVec3::splat(at + at * 0.5) };
    for (i, at) in [1.0, 1e7, 1e-20, 1e30, 1e100].into_iter().enumerate() {
        tree.insert(1000 * i as u32, &cube(at));
        tree.validate().unwrap();
    }
    tree.insert(7, &Aabb::NAN);
    tree.insert(8, &Aabb::INFINITE);
    tree.insert(9, &Aabb::EMPTY);
    tree.validate().unwrap();
    assert_eq!(tree.len(), 8);
    for id in [7, 8, 9, 0, 1000, 2000, 3000, 4000] {
        assert!(tree.remove(id), "{id}");
        tree.validate().unwrap();
    }
    assert!(tree.is_empty());
}
