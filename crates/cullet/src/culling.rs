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

/// What became of the objects, and of the triangles of those that are not drawn, whose items are not read.
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

#[cfg(test)]
mod tests {
    use cullet_scene::{Mesh, synth};
    use cullet_transform::{Camera, Projection, Viewport};
    use glam::{DVec3, Vec3};

    use super::*;

    /// Whether the tree is asked or not: as many objects as each kept one by one, and their triangles.
    #[test]
    fn counts_are_those_of_asking_each_object() {
        let mut scene = synth::synth("box-grid:5").unwrap();
        let mut nothing = scene.objects[7].clone();
        nothing.mesh = scene.meshes.len();
        scene.objects.insert(3, nothing);
        scene.meshes.push(Mesh {
            positions: vec![Vec3::NAN; 3],
            triangles: vec![[0, 1, 2]; 5],
            ..Mesh::default()
        });
        let prepared = Prepared::new(scene).unwrap();
        let look = |eye: DVec3, at: DVec3| {
            let lens = Projection::Perspective { yfov: 0.6, near: 0.1, far: f64::INFINITY };
            let camera = Camera::look_at(eye, at, DVec3::Y, lens).unwrap();
            View::new(&camera, Viewport::new(64, 48).unwrap())
        };
        let middle = prepared.bounds().center();
        let (view, other) =
            (look(middle, DVec3::X * 99.0), look(middle, DVec3::new(50.0, 9.0, 50.0)));
        let all: u64 = prepared.items().iter().map(|item| u64::from(item.n_triangles)).sum();
        for test in [Test::None, Test::Corners, Test::PVertex, Test::Reverse, Test::Both, Test::Sat]
        {
            for (hierarchy, cull_view) in [(false, None), (true, None), (true, Some(other))] {
                let settings = Settings { cull: test, hierarchy, cull_view, ..Settings::default() };
                let (mut planes, mut stats) = (Vec::new(), FrameStats::default());
                cull(&prepared, &view, &settings, &mut planes, &mut stats);
                let unused = &mut FrameStats::default();
                let mut drawn = (0, 0);
                for item in prepared.items().iter().filter(|item| !item.bounds.is_empty()) {
                    let kept = Culler::new(&view, test).planes(item, unused).is_some()
                        && cull_view.is_none_or(|other| {
                            Culler::new(&other, test).planes(item, unused).is_some()
                        });
                    if kept {
                        drawn = (drawn.0 + 1, drawn.1 + u64::from(item.n_triangles));
                    }
                }
                let objects = stats.objects;
                assert_eq!((objects.n_in, objects.n_empty, objects.n_drawn), (126, 1, drawn.0));
                assert_eq!(objects.n_outside, 125 - drawn.0);
                assert_eq!(stats.triangles.n_not_finite, 5);
                assert_eq!(stats.n_triangles_of_culled_objects, all - 5 - drawn.1);
                assert!(test == Test::None || (0 < drawn.0 && drawn.0 < 100), "{test:?}");
            }
        }
    }
}
