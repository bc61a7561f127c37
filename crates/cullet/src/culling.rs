//! Which objects may be in a view: the question asked before any vertex work.

use cullet_cull::{
    Aabb, Frustum, Sat, Test, planes_cutting, projected_size_px, reverse_visible, visible,
};
use cullet_raster::SetupCounters;
use cullet_transform::{PlaneMask, View};

use crate::{FrameStats, Item, Prepared, Settings};

/// Per item: the planes that may cut it, or `None` when there is nothing of it to draw.
pub(crate) fn cull(
    prepared: &Prepared,
    view: &View,
    settings: &Settings,
    planes: &mut Vec<Option<PlaneMask>>,
    stats: &mut FrameStats,
) {
    let items = prepared.items();
    planes.clear();
    if settings.hierarchy && serves(settings.cull) {
        planes.resize(items.len(), None);
        walk(prepared, view, settings, planes, stats);
    } else {
        let culler = Culler::new(view, settings.cull);
        planes.extend(items.iter().map(|item| culler.planes(item, stats)));
    }
    if let Some(other) = &settings.cull_view {
        let other = Culler::new(other, settings.cull);
        let kept = planes.iter_mut().zip(items).filter(|(planes, _)| planes.is_some());
        for (planes, item) in kept {
            *planes = planes.filter(|_| other.planes(item, stats).is_some());
        }
    }
    count(prepared, planes, stats);
    if settings.min_size_px > 0.0 {
        leave_out_small(items, view, settings.min_size_px, planes, stats);
    }
}

/// The one rejection that changes pixels, and therefore is asked for.
fn leave_out_small(
    items: &[Item],
    view: &View,
    min_size_px: f64,
    planes: &mut [Option<PlaneMask>],
    stats: &mut FrameStats,
) {
    let kept = planes.iter_mut().zip(items).filter(|(planes, _)| planes.is_some());
    for (planes, item) in kept {
        if projected_size_px(view, &item.bounds) < min_size_px {
            *planes = None;
            stats.objects.n_drawn -= 1;
            stats.objects.n_small += 1;
            stats.n_triangles_of_culled_objects += u64::from(item.n_triangles);
        }
    }
}

/// Whether the tree helps with a test: it rejects by planes, and so serves the tests that do.
fn serves(test: Test) -> bool {
    matches!(test, Test::PVertex | Test::Both | Test::Sat)
}

/// Asks the tree, and of what it keeps asks the rest of the test.
fn walk(
    prepared: &Prepared,
    view: &View,
    settings: &Settings,
    planes: &mut [Option<PlaneMask>],
    stats: &mut FrameStats,
) {
    let frustum = Frustum::from_camera(view.camera(), view.viewport().aspect());
    let culler = Culler::new(view, settings.cull);
    let mut n_asked = 0;
    let walked = prepared.hierarchy().walk(&frustum, settings.simd, |ids, cutting| {
        for &id in ids {
            let item = &prepared.items()[id as usize];
            // What lies wholly inside needs no closer look.
            let sure = settings.cull == Test::PVertex || cutting.is_empty();
            n_asked += u64::from(!sure);
            if sure || culler.keeps(item) {
                planes[id as usize] = Some(cutting);
            }
        }
    });
    stats.boxes_tested += walked.nodes.tested + walked.items.tested + n_asked;
}

/// What became of the objects, and of the triangles of those that are not drawn; those that are not are
/// not looked at, however many there are.
fn count(prepared: &Prepared, planes: &mut [Option<PlaneMask>], stats: &mut FrameStats) {
    let triangles_of = |item: u32| u64::from(prepared.items()[item as usize].n_triangles);
    let mut n_of_empty = 0;
    for &item in prepared.empty_items() {
        planes[item as usize] = None;
        n_of_empty += triangles_of(item);
    }
    let (mut n_drawn, mut n_of_drawn) = (0, 0);
    for (item, _) in (0..).zip(&*planes).filter(|(_, planes)| planes.is_some()) {
        n_drawn += 1;
        n_of_drawn += triangles_of(item);
    }
    let (n_in, n_empty) = (planes.len() as u64, prepared.empty_items().len() as u64);
    let objects = &mut stats.objects;
    objects.n_in += n_in;
    objects.n_empty += n_empty;
    objects.n_drawn += n_drawn;
    objects.n_outside += n_in - n_empty - n_drawn;
    stats.triangles +=
        SetupCounters { n_in: n_of_empty, n_not_finite: n_of_empty, ..SetupCounters::default() };
    stats.n_triangles_of_culled_objects += prepared.n_triangles() - n_of_empty - n_of_drawn;
}

/// A view, ready to be asked about objects one by one.
pub(crate) struct Culler<'a> {
    view: &'a View,
    frustum: Frustum,
    test: Test,
    /// Prepared once; of use to the exact test only.
    sat: Option<Sat>,
}

impl<'a> Culler<'a> {
    pub(crate) fn new(view: &'a View, test: Test) -> Self {
        let frustum = Frustum::from_camera(view.camera(), view.viewport().aspect());
        let frustum = frustum.relative_to_eye();
        Culler { view, frustum, test, sat: (test == Test::Sat).then(|| Sat::new(&frustum)) }
    }

    /// The planes that may cut `item`, or `None` if the test throws it out.
    pub(crate) fn planes(&self, item: &Item, stats: &mut FrameStats) -> Option<PlaneMask> {
        if self.test == Test::None {
            return Some(PlaneMask::ALL);
        }
        stats.boxes_tested += 1;
        let bounds = item.bounds_from_eye(self.view);
        let cutting = planes_cutting(&bounds, &self.frustum, PlaneMask::ALL);
        match self.test {
            Test::PVertex => cutting,
            Test::Both => cutting.filter(|_| reverse_visible(&bounds, &self.frustum)),
            // Who is thrown out is the test's affair; the mask spares the clipper work.
            _ => self.keeps_box(&bounds).then(|| cutting.unwrap_or(PlaneMask::ALL)),
        }
    }

    /// Whether the test keeps `item`.
    fn keeps(&self, item: &Item) -> bool {
        self.keeps_box(&item.bounds_from_eye(self.view))
    }

    fn keeps_box(&self, bounds: &Aabb) -> bool {
        match &self.sat {
            Some(sat) => sat.visible(bounds),
            None => visible(self.test, &self.frustum, bounds),
        }
    }
}
