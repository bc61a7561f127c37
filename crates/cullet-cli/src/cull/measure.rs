//! Counting and timing: one thread, the tests in turn, medians.

use std::collections::BTreeMap;
use std::hint::black_box;
use std::ops::AddAssign;
use std::time::Instant;

use cullet::Level;
use cullet::cull::wide::{Boxes8, levels};
use cullet::cull::{
    Aabb, Counts, Frustum, Hierarchy, MAX_LEVELS, NodeBox, PlaneMask, Quality, Sat, Test,
    WalkStats, planes_cutting, reverse_visible,
};
use cullet::transform::Plane;
use cullet_measure::Summary;

use super::verdicts::{Fate, TESTS, Verdict, keeps};

/// Boxes in every form that a test takes them in, made once for all frusta.
pub struct Boxes<'a> {
    /// In input order.
    pub boxes: &'a [Aabb],
    wide: Boxes8,
    tree: Hierarchy,
    nodes: Vec<NodeBox>,
    /// Time to build the tree.
    pub build_ms: f64,
    /// The shape of the tree.
    pub quality: Quality,
    level: Level,
}

/// How often to look at the clock.
#[derive(Clone, Copy, Debug)]
pub struct Rounds {
    /// Timed rounds; one more comes first.
    pub warm: u32,
    /// Rounds with cold caches; 0 leaves those figures out.
    pub cold: u32,
}

/// Figures of one frustum, or of several added up.
#[derive(Clone, Debug, Default)]
pub struct Figures {
    /// Frusta.
    pub n_shots: u64,
    /// Per test, in the order of [`TESTS`].
    pub tests: [TestFigures; TESTS.len()],
    /// Boxes by what became of them, in the order of [`Fate::ALL`].
    pub fates: [u64; Fate::ALL.len()],
    /// All boxes eight at a time, by the p-vertex test in f32.
    pub flat: FlatFigures,
    /// The walk over the tree.
    pub tree: TreeFigures,
    /// Boxes by the power of two at or below their longest edge.
    pub sizes: BTreeMap<i32, SizeFigures>,
}

/// One test, one box at a time.
#[derive(Clone, Copy, Debug, Default)]
pub struct TestFigures {
    /// Boxes it keeps.
    pub n_in: u64,
    /// Boxes it keeps that the exact test rejects.
    pub n_false_visible: u64,
    /// Per box.
    pub ns: Timing,
}

/// A time: medians, added up over frusta.
#[derive(Clone, Copy, Debug, Default)]
pub struct Timing {
    /// Again and again, in turn with the others.
    warm: f64,
    /// Half the interquartile range over the median.
    spread: f64,
    n_warm: u32,
    /// After all caches were filled with something else.
    cold: f64,
    n_cold: u32,
}

/// The wide test over all boxes.
#[derive(Clone, Copy, Debug, Default)]
pub struct FlatFigures {
    /// Boxes it keeps.
    pub n_in: u64,
    /// Per box.
    pub ns: Timing,
}

/// A walk over the tree for what [`Test::Both`] keeps.
#[derive(Clone, Debug, Default)]
pub struct TreeFigures {
    /// Boxes it keeps.
    pub n_in: u64,
    /// Per walk, the visible set delivered.
    pub ms: Timing,
    /// What the walk did.
    pub stats: WalkStats,
    /// What it found of the boxes of nodes, per level, root's children first.
    pub walked: [Counts; MAX_LEVELS],
    /// Nodes that a walk tests if it asks nodes by planes, by [`Test::Both`], by [`Test::Sat`].
    pub n_tested_by: [u64; 3],
    /// Per level, root's children first.
    pub levels: Vec<LevelFigures>,
}

/// All nodes of one level.
#[derive(Clone, Copy, Debug, Default)]
pub struct LevelFigures {
    /// Nodes there are.
    pub n_nodes: u64,
    /// Kept by each of [`TESTS`].
    pub n_in: [u64; TESTS.len()],
}

/// Boxes of about one size.
#[derive(Clone, Copy, Debug, Default)]
pub struct SizeFigures {
    /// Boxes there are.
    pub n_boxes: u64,
    /// Kept by each of [`TESTS`].
    pub n_in: [u64; TESTS.len()],
}

impl<'a> Boxes<'a> {
    /// Builds the tree.
    pub fn new(boxes: &'a [Aabb], level: Level) -> Boxes<'a> {
        let start = Instant::now();
        let tree = Hierarchy::build(boxes);
        let build_ms = start.elapsed().as_secs_f64() * 1e3;
        let (nodes, quality) = (tree.node_boxes(), tree.quality());
        Boxes { boxes, wide: Boxes8::new(boxes), tree, nodes, build_ms, quality, level }
    }

    /// What every test says of every box.
    pub fn verdicts(&self, frustum: &Frustum) -> Vec<Verdict> {
        let sat = Sat::new(frustum);
        self.boxes.iter().map(|bounds| Verdict::on(bounds, frustum, &sat)).collect()
    }

    /// Counts and times one frustum; `verdicts` are those of it.
    pub fn measure(&self, frustum: &Frustum, verdicts: &[Verdict], rounds: Rounds) -> Figures {
        let mut figures = self.count(frustum, verdicts);
        self.time(frustum, rounds, &mut figures);
        figures
    }

    fn count(&self, frustum: &Frustum, verdicts: &[Verdict]) -> Figures {
        let mut figures = Figures { n_shots: 1, ..Figures::default() };
        for (bounds, verdict) in self.boxes.iter().zip(verdicts) {
            for (test, figures) in TESTS.iter().zip(&mut figures.tests) {
                figures.n_in += u64::from(verdict.keeps(*test));
                figures.n_false_visible += u64::from(verdict.keeps(*test) && !verdict.visible());
            }
            if let Some(i) = Fate::ALL.iter().position(|fate| *fate == verdict.fate) {
                figures.fates[i] += 1;
            }
            if let Some(size) = size(bounds) {
                let size = figures.sizes.entry(size).or_default();
                size.n_boxes += 1;
                for (test, n) in TESTS.iter().zip(&mut size.n_in) {
                    *n += u64::from(verdict.keeps(*test));
                }
            }
        }
        self.count_nodes(frustum, &mut figures.tree);
        figures
    }

    fn count_nodes(&self, frustum: &Frustum, tree: &mut TreeFigures) {
        let sat = Sat::new(frustum);
        // Per node: whether a walk by each of three tests looks below it.
        let mut open: Vec<[bool; 3]> = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            if tree.levels.len() <= node.level {
                tree.levels.resize(node.level + 1, LevelFigures::default());
            }
            let level = &mut tree.levels[node.level];
            level.n_nodes += 1;
            let kept = TESTS.map(|test| keeps(test, &node.bounds, frustum, &sat));
            for (n, kept) in level.n_in.iter_mut().zip(kept) {
                *n += u64::from(kept);
            }
            let tested = node.parent.map_or([true; 3], |parent| open[parent]);
            for (n, tested) in tree.n_tested_by.iter_mut().zip(tested) {
                *n += u64::from(tested);
            }
            let cut = planes_cutting(&node.bounds, frustum, PlaneMask::ALL);
            let crossing = cut.is_some_and(|cutting| !cutting.is_empty());
            let [_, _, planes, _, both, exact] = kept;
            let kept = [planes, both, exact];
            open.push(std::array::from_fn(|i| tested[i] && crossing && kept[i]));
        }
    }

    fn time(&self, frustum: &Frustum, rounds: Rounds, figures: &mut Figures) {
        let sat = Sat::new(frustum);
        let mut found = Vec::new();
        let mut flat = vec![0; self.wide.n_groups()];
        let mut stats = WalkStats::default();
        let mut sweep = (rounds.cold > 0).then(Sweep::new);
        // One row per test, then the flat wide one, then the walk; in seconds.
        let mut times = vec![(Vec::new(), Vec::new()); TESTS.len() + 2];
        for round in 0..=rounds.warm + rounds.cold {
            let cold = round > rounds.warm;
            for (row, (warm_times, cold_times)) in times.iter_mut().enumerate() {
                if let Some(sweep) = sweep.as_mut().filter(|_| cold) {
                    sweep.run();
                }
                let start = Instant::now();
                match row.checked_sub(TESTS.len()) {
                    None => {
                        black_box(count(TESTS[row], self.boxes, frustum, &sat));
                    }
                    Some(0) => self.wide.visible_into(frustum, self.level, &mut flat),
                    Some(_) => stats = self.walk(frustum, &mut found),
                }
                let time = start.elapsed().as_secs_f64();
                if round > 0 {
                    if cold { cold_times } else { &mut *warm_times }.push(time);
                }
            }
        }
        let per_box = 1e9 / self.boxes.len().max(1) as f64;
        let timing = |row: usize, unit: f64| Timing::of(&times[row].0, &times[row].1, unit);
        for (row, figures) in figures.tests.iter_mut().enumerate() {
            figures.ns = timing(row, per_box);
        }
        let n_in = flat.iter().map(|byte| u64::from(byte.count_ones())).sum();
        figures.flat = FlatFigures { n_in, ns: timing(TESTS.len(), per_box) };
        figures.tree.n_in = found.len() as u64;
        figures.tree.ms = timing(TESTS.len() + 1, 1e3);
        figures.tree.stats = stats;
        figures.tree.walked = [Counts::default(); MAX_LEVELS];
        self.tree.walk_by_level(frustum, self.level, &mut figures.tree.walked, |_, _| ());
    }

    /// The visible set by [`Test::Both`]: what the tree keeps, asked once more where a plane cuts.
    fn walk(&self, frustum: &Frustum, found: &mut Vec<u32>) -> WalkStats {
        found.clear();
        self.tree.walk(frustum, self.level, |ids, cutting| {
            if cutting.is_empty() {
                return found.extend(ids);
            }
            found.extend(ids.iter().filter(|&&id| {
                let bounds = &self.boxes[id as usize];
                planes_cutting(bounds, frustum, PlaneMask::ALL).is_some()
                    && reverse_visible(bounds, frustum)
            }));
        })
    }
}

fn count(test: Test, boxes: &[Aabb], frustum: &Frustum, sat: &Sat) -> u64 {
    boxes.iter().filter(|bounds| keeps(test, bounds, frustum, sat)).count() as u64
}

/// The exponent of the power of two at or below the longest edge; `None` for boxes without one.
fn size(bounds: &Aabb) -> Option<i32> {
    if bounds.is_nan() || bounds.is_empty() {
        return None;
    }
    let edge = 2.0 * bounds.half_extent().max_element();
    (edge > 0.0 && edge.is_finite()).then(|| edge.log2().floor() as i32)
}

impl Timing {
    fn of(warm: &[f64], cold: &[f64], unit: f64) -> Timing {
        let (warm, cold) = (Summary::of(warm), Summary::of(cold));
        Timing {
            warm: warm.map_or(0.0, |summary| summary.median * unit),
            spread: warm.map_or(0.0, |summary| summary.spread()),
            n_warm: warm.iter().len() as u32,
            cold: cold.map_or(0.0, |summary| summary.median * unit),
            n_cold: cold.iter().len() as u32,
        }
    }

    /// The median, or the mean of the medians of several frusta; 0 without any.
    pub fn warm(&self) -> f64 {
        self.warm / f64::from(self.n_warm.max(1))
    }

    /// The mean spread.
    pub fn spread(&self) -> f64 {
        self.spread / f64::from(self.n_warm.max(1))
    }

    /// Like [`Timing::warm`]; `None` where it was not measured.
    pub fn cold(&self) -> Option<f64> {
        (self.n_cold > 0).then(|| self.cold / f64::from(self.n_cold))
    }
}

impl Figures {
    /// Boxes that each of the six planes rejected, the first in order that does.
    pub fn planes(&self) -> [u64; 6] {
        let n = |plane: Plane| {
            let at = Fate::ALL.iter().position(|fate| *fate == Fate::Plane(plane));
            at.map_or(0, |i| self.fates[i])
        };
        Plane::ALL.map(n)
    }

    /// Figures of one of [`TESTS`].
    pub fn of(&self, test: Test) -> &TestFigures {
        let at = TESTS.iter().position(|known| *known == test);
        &self.tests[at.unwrap_or(TESTS.len() - 1)]
    }
}

impl AddAssign for Timing {
    fn add_assign(&mut self, other: Timing) {
        self.warm += other.warm;
        self.spread += other.spread;
        self.n_warm += other.n_warm;
        self.cold += other.cold;
        self.n_cold += other.n_cold;
    }
}

impl AddAssign<&Figures> for Figures {
    fn add_assign(&mut self, other: &Figures) {
        fn add<const N: usize>(sums: &mut [u64; N], others: &[u64; N]) {
            sums.iter_mut().zip(others).for_each(|(sum, other)| *sum += other);
        }
        self.n_shots += other.n_shots;
        for (sum, other) in self.tests.iter_mut().zip(&other.tests) {
            sum.n_in += other.n_in;
            sum.n_false_visible += other.n_false_visible;
            sum.ns += other.ns;
        }
        add(&mut self.fates, &other.fates);
        self.flat.n_in += other.flat.n_in;
        self.flat.ns += other.flat.ns;
        for (size, other) in &other.sizes {
            let sum = self.sizes.entry(*size).or_default();
            sum.n_boxes += other.n_boxes;
            add(&mut sum.n_in, &other.n_in);
        }
        let (tree, other) = (&mut self.tree, &other.tree);
        tree.n_in += other.n_in;
        tree.ms += other.ms;
        tree.stats += &other.stats;
        add(&mut tree.n_tested_by, &other.n_tested_by);
        tree.levels.resize(tree.levels.len().max(other.levels.len()), LevelFigures::default());
        for (sum, other) in tree.levels.iter_mut().zip(&other.levels) {
            sum.n_nodes += other.n_nodes;
            add(&mut sum.n_in, &other.n_in);
        }
    }
}

/// Fills the caches with something else.
struct Sweep(Vec<u64>);

impl Sweep {
    /// More than the last cache of most machines holds.
    const BYTES: usize = 64 << 20;

    fn new() -> Sweep {
        Sweep(vec![1; Sweep::BYTES / 8])
    }

    fn run(&mut self) {
        // One word per cache line, written so that no copy elsewhere stays valid.
        self.0.iter_mut().step_by(8).for_each(|word| *word = word.wrapping_mul(3));
        black_box(&self.0);
    }
}

/// What the command line calls a level.
pub fn level_name(level: Level) -> &'static str {
    let levels = levels();
    let same = |known: &Level| std::mem::discriminant(known) == std::mem::discriminant(&level);
    match levels.iter().find(|(_, known)| same(known)) {
        Some(("scalar", _)) | None => "fallback",
        Some((name, _)) => name,
    }
}
