//! The tree against the flat test: the same items, the same masks.

mod hierarchy_common;

use cullet_cull::wide::{Boxes8, levels, reference};
use cullet_cull::{Aabb, Frustum, Hierarchy, PlaneMask};
use glam::DVec3;
use hierarchy_common::{Random, cameras, city, odd_boxes, random_boxes};

/// Boxes that are hard on a tree.
fn degenerate(n: usize) -> Vec<(&'static str, Vec<Aabb>)> {
    let cube = |center: DVec3, half: f64| Aabb { min: center - half, max: center + half };
    let each = |f: &dyn Fn(f64) -> Aabb| (0..n).map(|i| f(i as f64)).collect();
    vec![
        ("identical", each(&|_| cube(DVec3::ONE, 0.5))),
        ("one point", each(&|_| cube(DVec3::ONE, 0.0))),
        ("nested", each(&|i| cube(DVec3::ONE, i + 1.0))),
        ("chain", each(&|i| cube(DVec3::X * i, 0.6))),
        ("halving", each(&|i| cube(DVec3::splat(1.5_f64.powf(-i % 200.0)), 1e-3))),
        (
            "growing",
            each(&|i| cube(DVec3::splat(1.2_f64.powf(i % 300.0)), 1.2_f64.powf(i % 300.0))),
        ),
        (
            "grid of points",
            each(&|i| cube(DVec3::new(i % 31.0, i / 31.0 % 17.0, 0.0).floor(), 0.0)),
        ),
    ]
}

fn sets() -> Vec<(String, Vec<Aabb>)> {
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
fn verdicts(
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
                let counts = stats[0].nodes();
                assert_eq!(counts.tested, counts.outside + counts.inside + counts.straddling);
            }
        }
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
