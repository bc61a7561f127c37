//! Counting and timing: one thread, the tests in turn, medians.

use std::collections::BTreeMap;
use std::hint::black_box;
use std::ops::AddAssign;
use std::time::Instant;

use cullet::Level;
use cullet::cull::wide::{Boxes8, Coarse8};
use cullet::cull::{
    Aabb, Counts, Fate, Frustum, Hierarchy, MAX_LEVELS, NodeBox, Sat, Sphere, Test, Verdict,
    WalkStats, planes_cutting, reverse_visible, sphere_visible,
};
use cullet::transform::{Plane, PlaneMask};
use cullet_measure::Summary;

use super::verdicts::{TESTS, keeps};

/// Boxes in every form that a test takes them in, made once for all frusta.
pub struct Boxes<'a> {
    /// In input order.
    pub boxes: &'a [Aabb],
    wide: Coarse8,
    tree: Hierarchy,
    spheres: Vec<Sphere>,
    nodes: Vec<NodeBox>,
    /// The boxes of the nodes again, by level.
    levels: Vec<Vec<Aabb>>,
    /// Time to build the tree.
    pub build_ms: f64,
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
    /// Per plane by itself: the p-vertex test with that plane alone.
    pub planes: [TestFigures; 6],
    /// Boxes by what became of them, in the order of [`Fate::ALL`].
    pub fates: [u64; Fate::ALL.len()],
    /// All boxes eight at a time, by the p-vertex test in f32.
    pub flat: FlatFigures,
    /// The same, asking bounds of 16 bits first.
    pub coarse: FlatFigures,
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
    /// Boxes it rejects that the exact test keeps: always 0, or there is a bug.
    pub n_false_culled: u64,
    /// Per box.
    pub ns: Timing,
}

/// A time: medians, added up over frusta.
#[derive(Clone, Copy, Debug, Default)]
pub struct Timing {
    /// Again and again, in turn with the others.
    warm: f64,
    n_warm: u32,
    /// Half the interquartile range over the median, of those timed more than once.
    spread: f64,
    n_spread: u32,
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
    /// Per node, by [`Test::Both`], one at a time.
    pub ns: Timing,
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
        let nodes = tree.node_boxes();
        let mut levels: Vec<Vec<Aabb>> = Vec::new();
        for node in &nodes {
            levels.resize(levels.len().max(node.level + 1), Vec::new());
            levels[node.level].push(node.bounds);
        }
        let spheres = boxes.iter().map(Sphere::around).collect();
        let wide = Coarse8::new(Boxes8::new(boxes));
        Boxes { boxes, wide, tree, spheres, nodes, levels, build_ms, level }
    }

    /// What every test says of every box.
    pub fn verdicts(&self, frustum: &Frustum) -> Vec<Verdict> {
        let sat = Sat::new(frustum);
        self.boxes.iter().map(|bounds| Verdict::on(bounds, &sat)).collect()
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
                figures.count(verdict.keeps(*test), verdict.visible());
            }
            let cut = |plane: usize| {
                let alone = PlaneMask::from_bits(1 << plane);
                planes_cutting(bounds, frustum, alone).is_some()
            };
            for (plane, figures) in figures.planes.iter_mut().enumerate() {
                figures.count(cut(plane), verdict.visible());
            }
            figures.fates[verdict.fate.index()] += 1;
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
        let mut flat = vec![0; self.wide.boxes().n_groups()];
        let mut coarse = flat.clone();
        let mut stats = WalkStats::default();
        let mut sweep = (rounds.cold > 0).then(Sweep::new);
        let tasks = self.tasks();
        let mut times = vec![Times::default(); tasks.len()];
        for round in 0..=rounds.warm + rounds.cold {
            let cold = round > rounds.warm;
            for (task, times) in tasks.iter().zip(&mut times) {
                if let Some(sweep) = sweep.as_mut().filter(|_| cold) {
                    sweep.run();
                }
                let repeats = if cold { 1 } else { times.repeats };
                let start = Instant::now();
                for _ in 0..repeats {
                    match *task {
                        Task::Test(test) => {
                            black_box(self.run(test, frustum, &sat));
                        }
                        Task::Plane(plane) => {
                            let alone = PlaneMask::from_bits(1 << plane);
                            black_box(count(self.boxes, |bounds| {
                                planes_cutting(bounds, frustum, alone).is_some()
                            }));
                        }
                        Task::Level(level) => {
                            black_box(count(&self.levels[level], |bounds| {
                                keeps(Test::Both, bounds, frustum, &sat)
                            }));
                        }
                        Task::Flat => {
                            self.wide.boxes().visible_into(frustum, self.level, &mut flat);
                        }
                        Task::Coarse => self.wide.visible_into(frustum, self.level, &mut coarse),
                        Task::Walk => stats = self.walk(frustum, &mut found),
                    }
                }
                times.take(start.elapsed().as_secs_f64(), round, cold);
            }
        }
        for (task, times) in tasks.iter().zip(&times) {
            let per_box = |n: usize| if n == 0 { 0.0 } else { 1e9 / n as f64 };
            let all = per_box(self.boxes.len());
            match *task {
                Task::Test(test) => figures.of_mut(test).ns = times.timing(all),
                Task::Plane(plane) => figures.planes[plane].ns = times.timing(all),
                Task::Level(level) => {
                    figures.tree.levels[level].ns = times.timing(per_box(self.levels[level].len()));
                }
                Task::Flat => figures.flat.ns = times.timing(all),
                Task::Coarse => figures.coarse.ns = times.timing(all),
                Task::Walk => figures.tree.ms = times.timing(1e3),
            }
        }
        let n_in = |bits: &[u8]| bits.iter().map(|byte| u64::from(byte.count_ones())).sum();
        (figures.flat.n_in, figures.coarse.n_in) = (n_in(&flat), n_in(&coarse));
        figures.tree.n_in = found.len() as u64;
        figures.tree.stats = stats;
        figures.tree.walked = [Counts::default(); MAX_LEVELS];
        self.tree.walk_by_level(frustum, self.level, &mut figures.tree.walked, |_, _| ());
    }

    /// What takes turns on the stopwatch.
    fn tasks(&self) -> Vec<Task> {
        let tests = TESTS.into_iter().map(Task::Test);
        let levels = (0..self.levels.len()).map(Task::Level);
        let tasks = tests.chain((0..6).map(Task::Plane)).chain(levels);
        tasks.chain([Task::Flat, Task::Coarse, Task::Walk]).collect()
    }

    /// How many boxes `test` keeps. Balls are made beforehand, as one would keep them.
    fn run(&self, test: Test, frustum: &Frustum, sat: &Sat) -> u64 {
        match test {
            Test::Sphere => count(&self.spheres, |sphere| sphere_visible(sphere, frustum)),
            test => count(self.boxes, |bounds| keeps(test, bounds, frustum, sat)),
        }
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
                planes_cutting(bounds, frustum, cutting).is_some()
                    && reverse_visible(bounds, frustum)
            }));
        })
    }
}

/// One thing to time.
#[derive(Clone, Copy, Debug)]
enum Task {
    /// A test over all boxes.
    Test(Test),
    /// One plane over all boxes.
    Plane(usize),
    /// [`Test::Both`] over the nodes of one level.
    Level(usize),
    /// The wide test over all boxes.
    Flat,
    /// The wide test over all boxes, short bounds first.
    Coarse,
    /// A walk over the tree.
    Walk,
}

/// Times of one task, seconds per run.
#[derive(Clone, Debug)]
struct Times {
    warm: Vec<f64>,
    cold: Vec<f64>,
    /// Runs between two looks at a clock that takes tens of nanoseconds itself.
    repeats: u32,
}

impl Default for Times {
    fn default() -> Self {
        Times { warm: Vec::new(), cold: Vec::new(), repeats: 1 }
    }
}

impl Times {
    /// What a warm sample lasts at least, s.
    const SAMPLE: f64 = 20e-6;

    fn take(&mut self, seconds: f64, round: u32, cold: bool) {
        match (round, cold) {
            (0, _) => {
                let repeats = (Times::SAMPLE / seconds.max(1e-9)).ceil();
                self.repeats = (repeats as u32).clamp(1, 1000);
            }
            (_, false) => self.warm.push(seconds / f64::from(self.repeats)),
            (_, true) => self.cold.push(seconds),
        }
    }

    fn timing(&self, unit: f64) -> Timing {
        Timing::of(&self.warm, &self.cold, unit)
    }
}

fn count<T>(all: &[T], keeps: impl Fn(&T) -> bool) -> u64 {
    all.iter().filter(|one| keeps(one)).count() as u64
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
        let spread = warm.filter(|summary| summary.n > 1).map(|summary| summary.spread());
        Timing {
            warm: warm.map_or(0.0, |summary| summary.median * unit),
            n_warm: warm.iter().len() as u32,
            spread: spread.unwrap_or(0.0),
            n_spread: spread.iter().len() as u32,
            cold: cold.map_or(0.0, |summary| summary.median * unit),
            n_cold: cold.iter().len() as u32,
        }
    }

    /// The median, or the mean of the medians of several frusta; 0 without any.
    pub fn warm(&self) -> f64 {
        self.warm / f64::from(self.n_warm.max(1))
    }

    /// The mean spread; `None` where nothing was timed more than once.
    pub fn spread(&self) -> Option<f64> {
        (self.n_spread > 0).then(|| self.spread / f64::from(self.n_spread))
    }

    /// Like [`Timing::warm`]; `None` where it was not measured.
    pub fn cold(&self) -> Option<f64> {
        (self.n_cold > 0).then(|| self.cold / f64::from(self.n_cold))
    }
}

impl Figures {
    /// Boxes that each of the six planes rejected, the first in order that does.
    pub fn rejected(&self) -> [u64; 6] {
        Plane::ALL.map(|plane| self.fates[Fate::Plane(plane).index()])
    }

    /// Boxes of a fate that no frustum changes: each counted once, however many frusta there are.
    pub fn n_of(&self, fate: Fate) -> u64 {
        self.fates[fate.index()] / self.n_shots.max(1)
    }

    fn of_mut(&mut self, test: Test) -> &mut TestFigures {
        let at = TESTS.iter().position(|known| *known == test);
        &mut self.tests[at.unwrap_or(TESTS.len() - 1)]
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
        self.n_warm += other.n_warm;
        self.spread += other.spread;
        self.n_spread += other.n_spread;
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
        let tests = self.tests.iter_mut().zip(&other.tests);
        for (sum, other) in tests.chain(self.planes.iter_mut().zip(&other.planes)) {
            sum.n_in += other.n_in;
            sum.n_false_visible += other.n_false_visible;
            sum.n_false_culled += other.n_false_culled;
            sum.ns += other.ns;
        }
        add(&mut self.fates, &other.fates);
        for (sum, other) in [(&mut self.flat, &other.flat), (&mut self.coarse, &other.coarse)] {
            sum.n_in += other.n_in;
            sum.ns += other.ns;
        }
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
        for (sum, other) in tree.walked.iter_mut().zip(&other.walked) {
            *sum += *other;
        }
        tree.levels.resize(tree.levels.len().max(other.levels.len()), LevelFigures::default());
        for (sum, other) in tree.levels.iter_mut().zip(&other.levels) {
            sum.n_nodes += other.n_nodes;
            sum.ns += other.ns;
            add(&mut sum.n_in, &other.n_in);
        }
    }
}

impl TreeFigures {
    /// Nodes there are, without the box around everything.
    pub fn n_nodes(&self) -> u64 {
        self.levels.iter().map(|level| level.n_nodes).sum()
    }

    /// Nodes that the walk tested, likewise.
    pub fn n_nodes_tested(&self) -> u64 {
        self.walked.iter().map(|counts| counts.tested).sum()
    }

    /// Boxes that the walk tested, those of nodes and those of the input.
    pub fn n_boxes_tested(&self) -> u64 {
        self.n_nodes_tested() + self.stats.items.tested
    }
}

impl TestFigures {
    fn count(&mut self, kept: bool, visible: bool) {
        self.n_in += u64::from(kept);
        self.n_false_visible += u64::from(kept && !visible);
        self.n_false_culled += u64::from(!kept && visible);
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
