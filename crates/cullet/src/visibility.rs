//! What the rasterizer found, read back: from triangle ids to runs of pixels.

use cullet_raster::{Interpolator, NO_TRIANGLE, Pixels};
use cullet_transform::{ClipPoint, PlaneMask, View};
use glam::DMat4;

use crate::settings::SUBPIXEL_BITS;
use crate::shading::{Emit, Run, Visible, VisibleTriangle};
use crate::{Prepared, Region};

/// The visibility buffer of a region, read back run by run.
pub(crate) struct VisibilityBuffer<'a> {
    pub prepared: &'a Prepared,
    pub view: &'a View,
    pub planes: &'a [Option<PlaneMask>],
    pub region: Region,
    pub ids: &'a [u32],
}

impl Visible for VisibilityBuffer<'_> {
    fn scan<'a>(&'a self, region: Region, emit: &mut Emit<'_, 'a>) {
        let mut corners = Corners::new(self.prepared, self.view, self.planes);
        for y in region.y..region.y + region.height {
            let start = (y - self.region.y) as usize * self.region.width as usize;
            let ids = &self.ids[start..start + self.region.width as usize];
            let mut x = region.x;
            for run in ids.chunk_by(|a, b| a == b) {
                if run[0] != NO_TRIANGLE {
                    let (triangle, interpolator) = corners.of(run[0]);
                    let pixels = Pixels::Row { interpolator, x, y };
                    emit(Run { x, y, len: run.len(), pixels }, triangle);
                }
                x += run.len() as u32;
            }
        }
    }
}

/// The last triangle asked for, ready to be interpolated over.
pub(crate) struct Corners<'a> {
    prepared: &'a Prepared,
    view: &'a View,
    planes: &'a [Option<PlaneMask>],
    clip_from_model: Option<(usize, DMat4)>,
    last: Option<(u32, VisibleTriangle<'a>, Interpolator)>,
}

impl<'a> Corners<'a> {
    pub(crate) fn new(
        prepared: &'a Prepared,
        view: &'a View,
        planes: &'a [Option<PlaneMask>],
    ) -> Self {
        Corners { prepared, view, planes, clip_from_model: None, last: None }
    }

    /// Triangle `id` of the whole scene.
    pub(crate) fn of(&mut self, id: u32) -> (&VisibleTriangle<'a>, &Interpolator) {
        if self.last.as_ref().is_none_or(|(last, ..)| *last != id) {
            self.last = None;
        }
        let last = match self.last.take() {
            Some(last) => last,
            None => self.look_up(id),
        };
        let (_, triangle, interpolator) = self.last.insert(last);
        (triangle, interpolator)
    }

    fn look_up(&mut self, id: u32) -> (u32, VisibleTriangle<'a>, Interpolator) {
        let mut triangle = VisibleTriangle::new(self.prepared, id, true);
        let item_idx = triangle.item_idx;
        let clip_from_model = match self.clip_from_model {
            Some((last, matrix)) if last == item_idx => matrix,
            _ => self.view.clip_from_model(&triangle.item.world_from_model),
        };
        self.clip_from_model = Some((item_idx, clip_from_model));
        let corners = triangle.positions().map(|p| ClipPoint::from_model(&clip_from_model, p));
        let planes = self.planes[item_idx].unwrap_or_default();
        let interpolator =
            Interpolator::new::<SUBPIXEL_BITS>(self.view.viewport(), &corners, planes);
        triangle.front = interpolator.is_clockwise() == triangle.item.mirrored;
        (id, triangle, interpolator)
    }
}
