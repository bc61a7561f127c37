//! Trees that change stay sound and give the answers of a tree built anew.

use cullet_cull::wide::{Boxes8, Level, reference};
use cullet_cull::{Aabb, Hierarchy};
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
