//! Counting and timing: one thread, the tests in turn, medians.

use std::hint::black_box;
use std::time::Instant;

use cullet::Level;
use cullet::cull::wide::levels;
use cullet::cull::{
    Aabb, CullStats, Frustum, Hierarchy, Ladder, PlaneMask, Quality, Sat, Test, WalkStats,
    planes_cutting, reverse_visible, visible,
};
use cullet_measure::Summary;

/// The tests reported, in the order of the ladder.
pub const TESTS: [Test; 6] =
    [Test::Sphere, Test::Corners, Test::PVertex, Test::Reverse, Test::Both, Test::Sat];

/// Everything measured of one set of boxes.
#[derive(Debug)]
pub struct Measured {
    /// Boxes given.
    pub n_boxes: usize,
    /// Boxes with a NaN among them.
    pub n_invalid: usize,
    /// Boxes with a min above its max.
    pub n_empty: usize,
    /// Per test.
    pub tests: Vec<TestFigures>,
    /// Boxes rejected by each plane, by the first that does.
    pub planes: [u64; 6],
    /// The walk over the tree.
    pub tree: TreeFigures,
    /// Name of the instruction set of the walk.
    pub simd: &'static str,
}

/// One test over all boxes.
#[derive(Debug)]
pub struct TestFigures {
    /// Which.
    pub test: Test,
    /// Boxes it keeps.
    pub n_in: u64,
    /// Boxes it keeps that the exact test rejects.
    pub n_false_visible: u64,
    /// Median time per box.
    pub ns_per_box: f64,
    /// Half the interquartile range over the median.
    pub spread: f64,
}

/// The tree over all boxes, asked for what [`Test::Both`] keeps.
#[derive(Debug)]
pub struct TreeFigures {
    /// Time to build it.
    pub build_ms: f64,
    /// Median time of a walk, the visible set delivered.
    pub walk_ms: f64,
    /// Boxes it keeps.
    pub n_in: u64,
    /// What the walk did.
    pub stats: WalkStats,
    /// The shape of the tree.
    pub quality: Quality,
}

impl Measured {
    /// Counts once, times `repeat` rounds after one warm-up.
    pub fn take(boxes: &[Aabb], frustum: &Frustum, level: Level, repeat: u32) -> Measured {
        let sat = Sat::new(frustum);
        let start = Instant::now();
        let tree = Hierarchy::build(boxes);
        let build_ms = start.elapsed().as_secs_f64() * 1e3;

        let (mut times, mut walks) = (vec![Vec::new(); TESTS.len()], Vec::new());
        let mut found = Vec::new();
        let mut stats = WalkStats::default();
        for round in 0..=repeat {
            for (test, times) in TESTS.iter().zip(&mut times) {
                let start = Instant::now();
                black_box(count(*test, boxes, frustum, &sat));
                times.push(start.elapsed().as_secs_f64() * 1e9 / boxes.len().max(1) as f64);
            }
            let start = Instant::now();
            stats = walk(&tree, boxes, frustum, level, &mut found);
            walks.push(start.elapsed().as_secs_f64() * 1e3);
            if round == 0 {
                times.iter_mut().for_each(Vec::clear);
                walks.clear();
            }
        }

        let tests = TESTS.iter().zip(&times).map(|(&test, times)| {
            let wasted = boxes.iter().filter(|b| keeps(test, b, frustum, &sat) && !sat.visible(b));
            let summary = Summary::of(times);
            TestFigures {
                test,
                n_in: count(test, boxes, frustum, &sat),
                n_false_visible: wasted.count() as u64,
                ns_per_box: summary.as_ref().map_or(0.0, |s| s.median),
                spread: summary.as_ref().map_or(0.0, Summary::spread),
            }
        });
        Measured {
            n_boxes: boxes.len(),
            n_invalid: boxes.iter().filter(|b| b.is_nan()).count(),
            n_empty: boxes.iter().filter(|b| b.is_empty()).count(),
            tests: tests.collect(),
            planes: planes(boxes, frustum),
            tree: TreeFigures {
                build_ms,
                walk_ms: Summary::of(&walks).map_or(0.0, |s| s.median),
                n_in: found.len() as u64,
                stats,
                quality: tree.quality(),
            },
            simd: name(level),
        }
    }
}

fn keeps(test: Test, bounds: &Aabb, frustum: &Frustum, sat: &Sat) -> bool {
    match test {
        Test::Sat => sat.visible(bounds),
        test => visible(test, frustum, bounds),
    }
}

fn count(test: Test, boxes: &[Aabb], frustum: &Frustum, sat: &Sat) -> u64 {
    boxes.iter().filter(|bounds| keeps(test, bounds, frustum, sat)).count() as u64
}

/// The visible set by [`Test::Both`]: what the tree keeps, asked once more where a plane cuts.
fn walk(
    tree: &Hierarchy,
    boxes: &[Aabb],
    frustum: &Frustum,
    level: Level,
    found: &mut Vec<u32>,
) -> WalkStats {
    found.clear();
    tree.walk(frustum, level, |ids, cutting| {
        if cutting.is_empty() {
            return found.extend(ids);
        }
        found.extend(ids.iter().filter(|&&id| {
            let bounds = &boxes[id as usize];
            planes_cutting(bounds, frustum, PlaneMask::ALL).is_some()
                && reverse_visible(bounds, frustum)
        }));
    })
}

fn planes(boxes: &[Aabb], frustum: &Frustum) -> [u64; 6] {
    let ladder = Ladder::new(frustum, &[Test::PVertex]);
    let mut stats = CullStats::default();
    for bounds in boxes {
        ladder.visible(bounds, &mut stats);
    }
    stats.planes
}

/// What the command line calls a level.
fn name(level: Level) -> &'static str {
    let levels = levels();
    let same = |known: &Level| std::mem::discriminant(known) == std::mem::discriminant(&level);
    match levels.iter().find(|(_, known)| same(known)) {
        Some(("scalar", _)) | None => "fallback",
        Some((name, _)) => name,
    }
}
