//! Which clusters of the objects drawn may show, where, and in which order to draw them.

use std::sync::atomic::{AtomicBool, Ordering};

use cullet_cull::{Frustum, planes_cutting};
use cullet_raster::Samples;
use cullet_transform::{PlaneMask, View};

use crate::occluders::Occluders;
use crate::schedule::for_each;
use crate::screen_box::{Lens, ScreenBox};
use crate::{CullTest, Prepared, Settings};

/// Clusters tested by one job.
const JOB_CLUSTERS: usize = 1024;

/// A cluster of an object in a view.
#[derive(Debug)]
pub(crate) struct VisibleCluster {
    pub item_idx: u32,
    pub cluster_idx: u32,
    pub shown: ScreenBox,
    /// Planes that may cut it.
    pub planes: PlaneMask,
    /// Some tile has drawn it, and counted what became of its triangles.
    pub drawn: AtomicBool,
}

impl VisibleCluster {
    fn undrawn(&self) -> Self {
        let VisibleCluster { item_idx, cluster_idx, shown, planes, .. } = *self;
        VisibleCluster { item_idx, cluster_idx, shown, planes, drawn: AtomicBool::new(false) }
    }
}

/// What became of clusters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClusterCounters {
    /// Clusters of the objects drawn.
    pub n_in: u64,
    /// Thrown out: outside the view.
    pub n_outside: u64,
    /// Thrown out: too small to hold a sample.
    pub n_between_samples: u64,
    /// Thrown out: hidden by what is nearer, in every tile or with the whole object, which may reach out of the view.
    pub n_hidden: u64,
    /// Set up and rasterized in at least one tile.
    pub n_drawn: u64,
}

/// Everything that may show, nearest first. Scratch memory is kept.
#[derive(Debug, Default)]
pub(crate) struct VisibleClusters {
    /// Items drawn, and before each the number of clusters of those before it.
    drawn: Vec<(u32, u32)>,
    occluders: Occluders,
    jobs: Vec<Job>,
    /// In the order in which they are found.
    found: Vec<VisibleCluster>,
    /// Numbers in `found`, nearest first; depths take the upper halves.
    order: Vec<u64>,
    /// Nearest first.
    pub sorted: Vec<VisibleCluster>,
    pub counters: ClusterCounters,
    pub n_triangles_culled: u64,
}

#[derive(Debug, Default)]
struct Job {
    first: u32,
    end: u32,
    list: Vec<VisibleCluster>,
    counters: ClusterCounters,
    n_triangles_culled: u64,
}

impl VisibleClusters {
    /// Finds the visible clusters of the items that have `planes`.
    pub fn find(
        &mut self,
        prepared: &Prepared,
        view: &View,
        settings: &Settings,
        samples: Samples,
        planes: &[Option<PlaneMask>],
        threads: usize,
    ) {
        let mut n_clusters = 0;
        self.drawn.clear();
        for (item_idx, _) in (0..).zip(planes).filter(|(_, planes)| planes.is_some()) {
            self.drawn.push((item_idx, n_clusters));
            n_clusters += prepared.clusters(item_idx as usize).list().len() as u32;
        }
        let items = self.drawn.iter().map(|(item_idx, _)| *item_idx);
        self.occluders.find(prepared, view, settings, items, n_clusters);
        let n_jobs = (n_clusters as usize).div_ceil(JOB_CLUSTERS);
        if self.jobs.len() < n_jobs {
            self.jobs.resize_with(n_jobs, Job::default);
        }
        for (i, job) in self.jobs[..n_jobs].iter_mut().enumerate() {
            job.first = (i * JOB_CLUSTERS) as u32;
            job.end = n_clusters.min(job.first + JOB_CLUSTERS as u32);
        }
        let frustum = Frustum::from_camera(view.camera(), view.viewport().aspect());
        let tester = Tester {
            prepared,
            view,
            settings,
            samples,
            planes,
            frustum: frustum.relative_to_eye(),
            drawn: &self.drawn,
            occluders: &self.occluders,
        };
        for_each(threads, self.jobs[..n_jobs].iter_mut(), |job| tester.run(job));
        self.found.clear();
        self.counters = ClusterCounters { n_in: n_clusters.into(), ..Default::default() };
        self.n_triangles_culled = 0;
        for job in &mut self.jobs[..n_jobs] {
            self.found.append(&mut job.list);
            self.counters.n_outside += job.counters.n_outside;
            self.counters.n_between_samples += job.counters.n_between_samples;
            self.counters.n_hidden += job.counters.n_hidden;
            self.n_triangles_culled += job.n_triangles_culled;
        }
        self.order.clear();
        let key = |number: u32, cluster: &VisibleCluster| {
            u64::from(!(cluster.shown.nearest as u32)) << 32 | u64::from(number)
        };
        self.order.extend((0..).zip(&self.found).map(|(number, cluster)| key(number, cluster)));
        self.order.sort_unstable();
        // Each is looked at by every tile that it touches: what is looked at together lies together.
        self.sorted.clear();
        let sorted = self.order.iter().map(|entry| self.found[*entry as u32 as usize].undrawn());
        self.sorted.extend(sorted);
    }

    /// Counts which were drawn, once all tiles are.
    pub fn count(&mut self, prepared: &Prepared) {
        for cluster in &self.sorted {
            if cluster.drawn.load(Ordering::Relaxed) {
                self.counters.n_drawn += 1;
            } else {
                let clusters = prepared.clusters(cluster.item_idx as usize);
                self.counters.n_hidden += 1;
                self.n_triangles_culled +=
                    u64::from(clusters.list()[cluster.cluster_idx as usize].n_triangles);
            }
        }
    }

    /// Memory held.
    pub fn bytes(&self) -> usize {
        let jobs: usize = self.jobs.iter().map(|job| job.list.capacity()).sum();
        (self.found.capacity() + self.sorted.capacity() + jobs) * size_of::<VisibleCluster>()
            + 8 * (self.order.capacity() + self.drawn.capacity())
            + self.jobs.capacity() * size_of::<Job>()
            + self.occluders.bytes()
    }
}

struct Tester<'a> {
    prepared: &'a Prepared,
    view: &'a View,
    settings: &'a Settings,
    samples: Samples,
    planes: &'a [Option<PlaneMask>],
    frustum: Frustum,
    drawn: &'a [(u32, u32)],
    occluders: &'a Occluders,
}

impl Tester<'_> {
    fn run(&self, job: &mut Job) {
        job.list.clear();
        (job.counters, job.n_triangles_culled) = Default::default();
        let mut next = job.first;
        let mut place = self.drawn.partition_point(|(_, before)| *before <= next) - 1;
        while next < job.end {
            let (item_idx, before) = self.drawn[place];
            place += 1;
            let n = self.prepared.clusters(item_idx as usize).list().len() as u32;
            let range = next - before..n.min(job.end - before);
            next = before + range.end;
            self.item(job, item_idx, range);
        }
    }

    /// Some clusters of an item.
    fn item(&self, job: &mut Job, item_idx: u32, range: std::ops::Range<u32>) {
        let item = &self.prepared.items()[item_idx as usize];
        let clusters = self.prepared.clusters(item_idx as usize);
        let asked = self.planes[item_idx as usize].unwrap_or_default();
        let clip_from_model = self.view.clip_from_model(&item.world_from_model);
        let lens = Lens {
            viewport: self.view.viewport(),
            samples: self.samples,
            precision: self.settings.precision(),
            simd: self.settings.simd,
        };
        if range.len() > 1 && self.occluders.are_known() {
            let shown = ScreenBox::of(&item.bounds_model, &clip_from_model, &lens);
            if !shown.is_empty() && self.occluders.hide(&shown) {
                job.counters.n_hidden += range.len() as u64;
                job.n_triangles_culled += clusters.n_triangles(range);
                return;
            }
        }
        let clusters = clusters.list();
        let relative_from_model = self.view.relative_from_model(&item.world_from_model);
        // A single cluster has the box that was tested already.
        let test = self.settings.cull != CullTest::None && clusters.len() > 1 && !asked.is_empty();
        for cluster_idx in range {
            let cluster = &clusters[cluster_idx as usize];
            let planes = match test {
                true => {
                    let bounds = cluster.bounds.transformed(&relative_from_model);
                    planes_cutting(&bounds, &self.frustum, asked)
                }
                false => Some(asked),
            };
            let Some(planes) = planes else {
                job.counters.n_outside += 1;
                job.n_triangles_culled += u64::from(cluster.n_triangles);
                continue;
            };
            let shown = ScreenBox::of(&cluster.bounds, &clip_from_model, &lens);
            if shown.is_empty() {
                job.counters.n_between_samples += 1;
                job.n_triangles_culled += u64::from(cluster.n_triangles);
                continue;
            }
            if self.occluders.hide(&shown) {
                job.counters.n_hidden += 1;
                job.n_triangles_culled += u64::from(cluster.n_triangles);
                continue;
            }
            let drawn = AtomicBool::new(false);
            job.list.push(VisibleCluster { item_idx, cluster_idx, shown, planes, drawn });
        }
    }
}
