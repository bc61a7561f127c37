//! Triangles by their ids: from the visibility buffer back to corners, one by one.

use cullet_raster::{Interpolator, NO_TRIANGLE};
use cullet_transform::ClipPoint;
use glam::DMat4;

use crate::Region;
use crate::shading::{Emit, Places, Run, Scene, VisibleTriangle};

/// Hands out the runs of pixels of `rect` that show one triangle each, row by row. `ids` begin at
/// its upper left pixel and have `stride` of them in a row.
pub(crate) fn scan<'a>(
    corners: &mut Corners<'a>,
    rect: Region,
    ids: &[u32],
    stride: usize,
    emit: &mut Emit<'_, 'a>,
) {
    for (y, ids) in (rect.y..rect.y + rect.height).zip(ids.chunks(stride)) {
        let mut x = rect.x;
        for run in ids[..rect.width as usize].chunk_by(|a, b| a == b) {
            if run[0] != NO_TRIANGLE {
                let (triangle, interpolator) = corners.of(run[0]);
                let places = Places::Planes(interpolator);
                emit(Run { x, y, len: run.len(), places }, triangle);
            }
            x += run.len() as u32;
        }
    }
}

/// Triangles ready to be interpolated over: those asked for lately are kept, since most triangles
/// are met again in the next row.
pub(crate) struct Corners<'a> {
    scene: Scene<'a>,
    /// The item looked at last, and the matrix of its vertices.
    item: Option<(usize, DMat4)>,
    /// Triangle `id` is in slot `id % SLOTS` or nowhere.
    slots: Vec<Option<Ready<'a>>>,
}

/// A triangle by its id.
pub(crate) type Ready<'a> = (u32, VisibleTriangle<'a>, Interpolator);

/// About as many triangles as a row of a picture meets.
const SLOTS: usize = 512;

impl<'a> Corners<'a> {
    pub(crate) fn new(scene: &Scene<'a>) -> Self {
        Corners { scene: *scene, item: None, slots: Vec::new() }
    }

    /// Triangle `id` of the whole scene.
    pub(crate) fn of(&mut self, id: u32) -> (&VisibleTriangle<'a>, &Interpolator) {
        if self.slots.is_empty() {
            self.slots.resize_with(SLOTS, || None);
        }
        let slot = id as usize % SLOTS;
        if self.slots[slot].as_ref().is_none_or(|(known, ..)| *known != id) {
            self.slots[slot] = Some(self.look_up(id));
        }
        match &self.slots[slot] {
            Some((_, triangle, interpolator)) => (triangle, interpolator),
            None => unreachable!("it was just put there"),
        }
    }

    /// Triangle `id`, not kept.
    pub(crate) fn look_up(&mut self, id: u32) -> Ready<'a> {
        let Scene { prepared, view, settings, planes } = self.scene;
        let (item_idx, clip_from_model) = match self.item {
            Some(last) if prepared.items()[last.0].holds(id) => last,
            _ => {
                let item_idx = prepared.item_of(id);
                let item = &prepared.items()[item_idx];
                (item_idx, view.clip_from_model(&item.world_from_model))
            }
        };
        self.item = Some((item_idx, clip_from_model));
        let mut triangle = VisibleTriangle::new(prepared, item_idx, id, true);
        let corners = triangle.positions().map(|p| ClipPoint::from_model(&clip_from_model, p));
        let planes = planes[item_idx].unwrap_or_default();
        let interpolator = settings.subpixel_bits.interpolator(view.viewport(), &corners, planes);
        triangle.front = interpolator.is_clockwise() == triangle.item.mirrored;
        (id, triangle, interpolator)
    }
}
