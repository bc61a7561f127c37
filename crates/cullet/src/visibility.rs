//! Triangles by their ids: from the visibility buffer back to corners, one by one.

use cullet_raster::{Interpolator, NO_TRIANGLE};
use cullet_transform::ClipPoint;
use glam::DMat4;

use crate::Region;
use crate::shading::{Scene, VisibleTriangle};

/// Hands out the runs of pixels of `rect` that show one triangle each, row by row: the triangle, the
/// first pixel, how many there are. `ids` begin at the upper left pixel and have `stride` of
/// them in a row.
pub(crate) fn scan(
    rect: Region,
    ids: &[u32],
    stride: usize,
    emit: &mut impl FnMut(u32, [u32; 2], usize),
) {
    for (y, ids) in (rect.y..rect.y + rect.height).zip(ids.chunks(stride)) {
        let mut left = &ids[..rect.width as usize];
        let mut x = rect.x;
        while let Some(&id) = left.first() {
            let len = run_len(left, id);
            if id != NO_TRIANGLE {
                emit(id, [x, y], len);
            }
            x += len as u32;
            left = &left[len..];
        }
    }
}

/// How many of the first of `ids` are `id`. Sixteen are looked at together, as most runs are either long, or
/// over at once.
fn run_len(ids: &[u32], id: u32) -> usize {
    let sixteens = ids.chunks_exact(16);
    let is_all = |ids: &&[u32]| ids.iter().fold(0, |differs, other| differs | (other ^ id)) == 0;
    let whole = 16 * sixteens.take_while(is_all).count();
    whole + ids[whole..].iter().take_while(|other| **other == id).count()
}

/// Triangles ready to be interpolated over: those asked for lately are kept, since most triangles
/// are met again in the next row.
pub(crate) struct Corners<'a> {
    scene: Scene<'a>,
    /// The item looked at last, and the matrix of its vertices.
    item: Option<(usize, DMat4)>,
    slots: &'a mut CornerSlots,
}

/// Memory of [`Corners`], good for one frame: triangle `id` is in slot `id % SLOTS` or nowhere.
#[derive(Debug, Default)]
pub(crate) struct CornerSlots(Vec<Ready>);

/// A triangle by its id.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ready {
    id: u32,
    item_idx: u32,
    pub corners: [u32; 3],
    front: bool,
    pub interpolator: Interpolator,
}

/// About as many triangles as a row of a picture meets.
const SLOTS: usize = 512;

impl CornerSlots {
    /// Forgets the frame before.
    pub(crate) fn forget(&mut self) {
        for slot in &mut self.0 {
            slot.id = NO_TRIANGLE;
        }
    }

    /// Memory held.
    pub(crate) fn bytes(&self) -> usize {
        self.0.capacity() * size_of::<Ready>()
    }
}

impl<'a> Corners<'a> {
    /// `slots` have forgotten all frames but this.
    pub(crate) fn new(scene: &Scene<'a>, slots: &'a mut CornerSlots) -> Self {
        Corners { scene: *scene, item: None, slots }
    }

    /// Triangle `id` of the whole scene.
    pub(crate) fn of(&mut self, id: u32) -> (VisibleTriangle<'a>, &Interpolator) {
        let prepared = self.scene.prepared;
        let Ready { item_idx, front, interpolator, .. } = self.ready(id);
        (VisibleTriangle::new(prepared, *item_idx as usize, id, *front), interpolator)
    }

    /// What is kept of it.
    pub(crate) fn ready(&mut self, id: u32) -> &Ready {
        let slot = id as usize % SLOTS;
        if self.slots.0.get(slot).is_none_or(|ready| ready.id != id) {
            let ready = self.look_up(id);
            if self.slots.0.is_empty() {
                self.slots.0.resize(SLOTS, Ready { id: NO_TRIANGLE, ..ready });
            }
            self.slots.0[slot] = ready;
        }
        &self.slots.0[slot]
    }

    fn look_up(&mut self, id: u32) -> Ready {
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
        let triangle = VisibleTriangle::new(prepared, item_idx, id, true);
        let points = triangle.positions().map(|p| ClipPoint::from_model(&clip_from_model, p));
        let planes = planes[item_idx].unwrap_or_default();
        let interpolator = settings.subpixel_bits.interpolator(view.viewport(), &points, planes);
        Ready {
            id,
            item_idx: item_idx as u32,
            corners: triangle.corners,
            front: interpolator.is_clockwise() == triangle.item.mirrored,
            interpolator,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_found_whatever_their_length() {
        // Runs of 1 to 70 that begin at every place beside a sixteen, some of them of nothing.
        let lens: Vec<usize> = (0..70).map(|i| i * 29 % 70 + 1).collect();
        let id_of = |i: usize| if i.is_multiple_of(5) { NO_TRIANGLE } else { i as u32 % 3 };
        let row = lens.iter().enumerate().flat_map(|(i, len)| vec![id_of(i); *len]);
        let mut ids: Vec<u32> = row.collect();
        let width = ids.len();
        ids.resize(width + 9, 1); // of no meaning
        ids.extend_from_within(..);
        let rect = Region { x: 3, y: 8, width: width as u32, height: 2 };
        let mut got = Vec::new();
        scan(rect, &ids, width + 9, &mut |id, place, len| got.push((id, place, len)));
        let mut want = Vec::new();
        for y in 8..10 {
            let mut x = 3;
            for (i, len) in lens.iter().enumerate() {
                if id_of(i) != NO_TRIANGLE {
                    want.push((id_of(i), [x, y], *len));
                }
                x += *len as u32;
            }
        }
        assert_eq!(got, want);
    }
}
