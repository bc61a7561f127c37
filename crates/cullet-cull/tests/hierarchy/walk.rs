//! The tree against the flat test: the same items, the same masks.

use crate::worlds::{Random, cameras, city, degenerate, odd_boxes, random_boxes};
use cullet_cull::wide::{Boxes8, Level, levels, reference};
use cullet_cull::{Aabb, Counts, Frustum, Hierarchy, MAX_LEVELS, PlaneMask, WalkStats};
use cullet_transform::{Camera, Projection};
use glam::DVec3;

pub fn sets() -> Vec<(String, Vec<Aabb>)> {
    let mut random = Random(11);
    let mut sets = vec![
        ("city".to_string(), city(&mut random, 5000)),
        ("odd".into(), odd_boxes(&mut random, 700)),
        ("none".into(), vec![]),
        ("all empty".into(), vec![Aabb::EMPTY; 9]),
        ("all nan".into(), vec![Aabb::NAN; 9]),
        ("large ones".into(), random_boxes(&mut random, 2000, 100.0, 150.0)),
    ];
    for n in [1, 7, 8, 9, 64, 65, 72, 511, 513, 4097] {
        sets.push((format!("{n} random"), random_boxes(&mut random, n, 500.0, 20.0)));
    }
    sets.extend(degenerate(3000).into_iter().map(|(name, boxes)| (name.to_string(), boxes)));
    sets
}

/// By item: what a walk said of it.
pub fn verdicts(
    n: usize,
    walk: impl FnOnce(&mut dyn FnMut(&[u32], PlaneMask)),
) -> Vec<Option<PlaneMask>> {
    let mut verdicts = vec![None; n];
    walk(&mut |ids, cutting| {
        for id in ids {
            let verdict = &mut verdicts[*id as usize];
            assert_eq!(*verdict, None, "{id} was returned twice");
            *verdict = Some(cutting);
        }
    });
    verdicts
}

#[test]
fn the_walk_returns_what_the_flat_test_keeps_with_its_masks() {
    let mut random = Random(12);
    for (name, boxes) in sets() {
        let (wide, tree) = (Boxes8::new(&boxes), Hierarchy::build(&boxes));
        for frustum in cameras(&mut random, &boxes, 30) {
            let expected = reference::cutting(&wide, &frustum);
            let n_expected = expected.iter().flatten().count() as u64;
            for (level_name, level) in levels() {
                let mut stats = vec![];
                for walk in [Walk::Any, Walk::Near, Walk::Asking] {
                    let found = verdicts(boxes.len(), |visit| {
                        stats.push(walk.go(&tree, &frustum, level, visit));
                    });
                    assert_eq!(found, expected, "{name} {level_name} {walk:?}");
                }
                assert!(stats.iter().all(|s| s.n_visible == n_expected), "{name} {level_name}");
                let counts = stats[0].nodes;
                assert_eq!(counts.tested, counts.outside + counts.inside + counts.straddling);
            }
        }
    }
}

#[test]
fn who_sees_nothing_or_everything_is_told_at_once() {
    let boxes = random_boxes(&mut Random(20), 3000, 100.0, 1.0);
    let tree = Hierarchy::build(&boxes);
    let level = cullet_cull::wide::Level::new();
    let lens = Projection::Perspective { yfov: 1.0, near: 1.0, far: 1e4 };
    for direction in [DVec3::X, DVec3::NEG_Z, DVec3::new(1.0, 2.0, -3.0)] {
        let eye = direction.normalize() * 500.0;
        let looking = |at| {
            let camera = Camera::look_at(eye, at, DVec3::Y, lens).expect("a camera");
            Frustum::from_camera(&camera, 1.0)
        };
        let stats = tree.walk(&looking(2.0 * eye), level, |_, _| panic!("nothing is visible"));
        let outside = Counts { tested: 1, outside: 1, ..Counts::default() };
        assert_eq!(stats, WalkStats { nodes: outside, ..WalkStats::default() });

        let mut runs = vec![];
        let stats = tree.walk(&looking(DVec3::ZERO), level, |ids, cutting| {
            runs.push((ids.len(), cutting));
        });
        assert_eq!(runs, [(3000, PlaneMask::NONE)]);
        assert_eq!((stats.nodes.inside, stats.n_groups, stats.n_untested), (1, 0, 3000));
    }
}

#[test]
fn levels_add_up() {
    let boxes = city(&mut Random(21), 5000);
    let tree = Hierarchy::build(&boxes);
    for frustum in cameras(&mut Random(22), &boxes, 10) {
        let level = cullet_cull::wide::Level::new();
        let mut levels = [Counts::default(); MAX_LEVELS];
        let stats = tree.walk_by_level(&frustum, level, &mut levels, |_, _| ());
        assert_eq!(stats, tree.walk(&frustum, level, |_, _| ()));
        let below: u64 = levels.iter().map(|counts| counts.tested).sum();
        assert_eq!(stats.nodes.tested, 1 + below);
        let used = levels.iter().take_while(|counts| counts.tested > 0).count();
        assert!(levels[used..].iter().all(|counts| counts.tested == 0));
        assert!(used <= tree.quality().depth);
    }
}

#[derive(Clone, Copy, Debug)]
enum Walk {
    Any,
    Near,
    Asking,
}

impl Walk {
    fn go(
        self,
        tree: &Hierarchy,
        frustum: &Frustum,
        level: cullet_cull::wide::Level,
        visit: &mut dyn FnMut(&[u32], PlaneMask),
    ) -> cullet_cull::WalkStats {
        match self {
            Walk::Any => tree.walk(frustum, level, visit),
            Walk::Near => tree.walk_near_to_far(frustum, level, visit),
            Walk::Asking => tree.walk_unoccluded(frustum, level, |_| false, visit),
        }
    }
}

#[test]
fn trees_are_sound_and_full() {
    for (name, boxes) in sets() {
        let tree = Hierarchy::build(&boxes);
        tree.validate().unwrap_or_else(|fault| panic!("{name}: {fault}"));
        let quality = tree.quality();
        let full = quality.n_items as f64 / (8.0 * quality.n_items.div_ceil(8) as f64);
        assert!(quality.n_items == 0 || quality.leaf_fill == full, "{name}: {quality:?}");
    }
}

#[test]
fn threads_do_not_change_the_tree() {
    let boxes = city(&mut Random(13), 50_000);
    let tree = Hierarchy::build(&boxes);
    let threaded = Hierarchy::build_with(&boxes, &|a, b| {
        std::thread::scope(|scope| {
            scope.spawn(b);
            a();
        });
    });
    threaded.validate().unwrap();
    assert_eq!(tree.quality(), threaded.quality());
    for frustum in cameras(&mut Random(14), &boxes, 5) {
        let level = cullet_cull::wide::Level::new();
        assert_eq!(tree.visible(&frustum, level), threaded.visible(&frustum, level));
    }
}

#[test]
fn near_comes_before_far() {
    let boxes = random_boxes(&mut Random(15), 3000, 100.0, 1.0);
    let tree = Hierarchy::build(&boxes);
    for frustum in cameras(&mut Random(16), &boxes, 10) {
        let along = |id: u32| frustum.planes()[4].normal.dot(boxes[id as usize].center());
        let order = |near: bool| {
            let mut depths = vec![];
            let visit = |ids: &[u32], _| depths.extend(ids.iter().map(|id| along(*id)));
            let level = cullet_cull::wide::Level::new();
            match near {
                true => tree.walk_near_to_far(&frustum, level, visit),
                false => tree.walk(&frustum, level, visit),
            };
            // How far, on average, an item lies before the farthest already returned.
            let mut farthest = f64::NEG_INFINITY;
            let mut sum = 0.0;
            for depth in &depths {
                farthest = farthest.max(*depth);
                sum += farthest - depth;
            }
            sum / depths.len().max(1) as f64
        };
        assert!(order(true) <= 0.8 * order(false) + 5.0, "{} {}", order(true), order(false));
    }
}

#[test]
fn what_is_occluded_is_not_entered() {
    let boxes = random_boxes(&mut Random(17), 3000, 100.0, 1.0);
    let tree = Hierarchy::build(&boxes);
    let level = cullet_cull::wide::Level::new();
    for frustum in cameras(&mut Random(18), &boxes, 10) {
        // Everything with x > 0 is hidden.
        let hidden = |bounds: &Aabb| bounds.min.x > 0.0;
        let mut seen = vec![];
        let stats = tree.walk_unoccluded(&frustum, level, hidden, |ids, _| {
            seen.extend_from_slice(ids);
        });
        assert_eq!(stats.n_visible, seen.len() as u64);
        seen.sort_unstable();
        let mut all: Vec<u32> = tree.visible(&frustum, level).iter().map(|(id, _)| *id).collect();
        all.sort_unstable();
        assert!(seen.iter().all(|id| all.binary_search(id).is_ok()));
        for id in all {
            let bounds = &boxes[id as usize];
            assert!(bounds.max.x > 0.0 || seen.binary_search(&id).is_ok(), "{id} is lost");
        }
        assert!(tree.walk_unoccluded(&frustum, level, |_| true, |_, _| ()).n_visible == 0);
    }
}

/// A million boxes in one place, and a million around each other: built and walked in no time.
#[test]
fn a_million_on_top_of_each_other() {
    for (name, boxes) in degenerate(1_000_000) {
        if !["identical", "nested", "chain"].contains(&name) {
            continue;
        }
        let tree = Hierarchy::build(&boxes);
        let quality = tree.quality();
        assert_eq!((quality.n_items, quality.leaf_fill), (1_000_000, 1.0), "{name}");
        assert!(quality.depth <= 20, "{name}: {quality:?}");
        for frustum in cameras(&mut Random(19), &boxes[..100], 4) {
            let level = cullet_cull::wide::Level::new();
            let stats = tree.walk(&frustum, level, |_, _| ());
            let mut bits = vec![0; boxes.len().div_ceil(8)];
            Boxes8::new(&boxes).visible_into(&frustum, level, &mut bits);
            let n: u32 = bits.iter().map(|byte| byte.count_ones()).sum();
            assert_eq!(stats.n_visible, u64::from(n), "{name}");
        }
    }
}

/// One box without measure must not spoil the tree of all others.
#[test]
fn a_huge_box_leaves_the_tree_as_good_as_it_was() {
    let mut random = Random(6);
    let mut boxes = random_boxes(&mut random, 20_000, 500.0, 4.0);
    let frusta = cameras(&mut random, &boxes, 10);
    let n_tested = |boxes: &[Aabb]| {
        let tree = Hierarchy::build(boxes);
        let mut n_tested = 0;
        for frustum in &frusta {
            n_tested += tree.walk(frustum, Level::new(), |_, _| {}).nodes.tested;
        }
        (n_tested, tree.quality().depth)
    };
    let (plain, depth) = n_tested(&boxes);
    for size in [1e6, 1e18, 1e24, 1e30] {
        boxes.push(Aabb { min: DVec3::splat(-size), max: DVec3::splat(size) });
        let (with_one, deeper) = n_tested(&boxes);
        boxes.pop();
        assert!(with_one < plain + plain / 3 && deeper <= depth + 1, "{size}: {with_one} {plain}");
    }
}
