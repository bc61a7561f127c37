//! Where materials with holes have matter, asked while a tile is drawn.
//!
//! Eight samples at a time from the record of their triangle, one by one where records do not serve. A
//! sample's answer depends on nothing but its place, its triangle and the block of the picture that it
//! lies in.

use cullet_raster::{BLOCK, NO_TRIANGLE, Placement};
use cullet_shade::Surface;
use cullet_shade::wide::{Cutout, Group, Record, Scratch, set_up};

use crate::Item;
use crate::shading::{Scene, keeps};
use crate::visibility::{CornerSlots, Corners, Ready};

/// Records kept.
const SLOTS: usize = 512;

/// Sixteenths of a pixel along a block.
const SIXTEENTHS: i32 = 16 * BLOCK as i32;

/// Memory for alpha tests, good for one frame.
#[derive(Debug, Default)]
pub(crate) struct CutoutSlots {
    corners: CornerSlots,
    /// By slot, the triangle and the block of the record.
    known: Vec<(u32, [u32; 2])>,
    records: Vec<Record>,
    wide: Option<Box<Scratch>>,
}

impl CutoutSlots {
    /// Forgets the frame before.
    pub fn forget(&mut self) {
        self.corners.forget();
        self.known.fill((NO_TRIANGLE, [0; 2]));
    }

    /// Memory held.
    pub fn bytes(&self) -> usize {
        self.corners.bytes()
            + self.known.capacity() * (size_of::<(u32, [u32; 2])>() + size_of::<Record>())
            + self.wide.iter().map(|wide| size_of_val(&**wide)).sum::<usize>()
    }
}

/// Alpha tests of an object.
pub(crate) struct Cutouts<'a> {
    scene: Scene<'a>,
    item: &'a Item,
    surface: Surface<'a>,
    /// Where wide code serves.
    wide: Option<(Cutout<'a>, Placement)>,
    slots: &'a mut CutoutSlots,
}

impl<'a> Cutouts<'a> {
    pub fn new(scene: Scene<'a>, item_idx: usize, slots: &'a mut CutoutSlots) -> Self {
        let Scene { prepared, view, settings, planes } = scene;
        let item = &prepared.items()[item_idx];
        let surface = prepared.surface(item);
        let wide = Cutout::new(&surface, &scene.look()).map(|cutout| {
            let clip_from_model = view.clip_from_model(&item.world_from_model);
            let planes = planes[item_idx].unwrap_or_default();
            let bits = settings.subpixel_bits;
            (cutout, Placement::new(clip_from_model, view.viewport(), planes, bits))
        });
        if wide.is_some() && slots.records.is_empty() {
            slots.known.resize(SLOTS, (NO_TRIANGLE, [0; 2]));
            slots.records.resize(SLOTS, Record::default());
            slots.wide = Some(Box::default());
        }
        Cutouts { scene, item, surface, wide, slots }
    }

    /// [`KeepSample`](cullet_raster::KeepSample).
    pub fn keep(&mut self, id: u32, [x, y]: [i32; 2], wanted: u64) -> u64 {
        let (mut kept, mut left) = (0, wanted);
        if self.wide.is_some() && x >= 0 && y >= 0 {
            // Eight may lie in two blocks.
            let first = x / SIXTEENTHS;
            let in_first = ((first + 1) * SIXTEENTHS - x + 15) / 16;
            let in_first = wanted & ((1u64 << in_first.min(8)) - 1);
            for (column, wanted) in [(first, in_first), (first + 1, wanted & !in_first)] {
                if wanted != 0 {
                    let [wide, good] = self.keep_wide(id, [x, y], column);
                    kept |= wide & good & wanted;
                    left &= !(good & wanted);
                }
            }
        }
        for lane in (0..8).filter(|lane| left >> lane & 1 == 1) {
            kept |= u64::from(self.keep_one(id, [x + 16 * lane, y])) << lane;
        }
        kept
    }

    /// Of the places in a column of blocks: which have matter, and which of these answers are good.
    fn keep_wide(&mut self, id: u32, [x, y]: [i32; 2], column: i32) -> [u64; 2] {
        let Some((cutout, placement)) = &self.wide else { return [0; 2] };
        let row = y / SIXTEENTHS;
        let block = [column as u32 * BLOCK, row as u32 * BLOCK];
        let slot = id as usize % SLOTS;
        let CutoutSlots { known, records, wide, .. } = &mut *self.slots;
        let Some(scratch) = wide else { return [0; 2] };
        if known[slot] != (id, block) {
            known[slot] = (id, block);
            let group = Group {
                surface: self.surface,
                placement,
                needs: cutout.needs(),
                mirrored: self.item.mirrored,
                light: self.scene.settings.light,
                point_light: None,
                block,
            };
            let wanted = [(id - self.item.first_triangle, slot as u32)];
            set_up(self.scene.settings.simd, &group, &wanted, records, &mut [], &mut []);
        }
        let (mut px, mut py) = ([0.0; 8], [0.0; 8]);
        for lane in 0..8 {
            px[lane] = (x + 16 * lane as i32 - column * SIXTEENTHS) as f32 * 0.0625;
            py[lane] = (y - row * SIXTEENTHS) as f32 * 0.0625;
        }
        cutout.kept(&records[slot], [px, py], scratch)
    }

    /// The plain way.
    fn keep_one(&mut self, id: u32, place: [i32; 2]) -> bool {
        let mut slots = Corners::new(&self.scene, &mut self.slots.corners);
        let Ready { corners, interpolator, .. } = slots.ready(id);
        let fragment = interpolator.fragment_at(place.map(|at| f64::from(at) / 16.0));
        keeps(&self.surface, *corners, &fragment, self.scene.settings)
    }
}

#[cfg(test)]
mod tests {
    use cullet_scene::AlphaMode;
    use cullet_scene::synth::synth;
    use cullet_transform::{PlaneMask, Viewport};

    use super::*;
    use crate::{Prepared, Settings, View, camera_of};

    /// Eight answers are those of the plain code, but where alpha is the cutoff within what f32
    /// tells, across borders of blocks too.
    #[test]
    fn eight_answers_are_the_plain_ones() {
        let prepared = Prepared::new(synth("masks").unwrap()).unwrap();
        let camera = camera_of(&prepared.scene().cameras[0]).unwrap();
        let view = View::new(&camera, Viewport::new(640, 360).unwrap());
        let settings = Settings::default();
        let planes = vec![Some(PlaneMask::ALL); prepared.items().len()];
        let scene =
            Scene { prepared: &prepared, view: &view, settings: &settings, planes: &planes };
        let masked = (0..).zip(prepared.items()).filter(|(_, item)| item.masked);
        let (mut n_kept, mut n_gone, mut n_wide) = (0, 0, 0);
        for (item_idx, item) in masked {
            let surface = prepared.surface(item);
            let AlphaMode::Mask { cutoff } = surface.material.alpha else { unreachable!() };
            let (mut slots, mut corner_slots) = (CutoutSlots::default(), CornerSlots::default());
            let mut cutouts = Cutouts::new(scene, item_idx, &mut slots);
            n_wide += u32::from(cutouts.wide.is_some());
            let mut corners = Corners::new(&scene, &mut corner_slots);
            let step = item.n_triangles.div_ceil(300) as usize;
            for id in (item.first_triangle..item.first_triangle + item.n_triangles).step_by(step) {
                let Ready { corners, interpolator, .. } = *corners.ready(id);
                let points = corners.map(|i| {
                    let position = surface.mesh.positions[i as usize].as_dvec3();
                    view.project(item.world_from_model.transform_point3(position))
                });
                let middle = |axis: fn(&cullet_transform::ScreenPoint) -> f64| {
                    points.iter().map(axis).sum::<f64>() / 3.0
                };
                let [x, y] = [middle(|p| p.x), middle(|p| p.y)].map(|at| (at * 16.0) as i32 - 56);
                if !(0..16 * 632).contains(&x) || !(0..16 * 360).contains(&y) {
                    continue;
                }
                let bits = cutouts.keep(id, [x, y], 0xff);
                for lane in 0..8 {
                    let place = [x + 16 * lane, y].map(|at| f64::from(at) / 16.0);
                    let fragment = interpolator.fragment_at(place);
                    let alpha = cullet_shade::alpha(&surface, corners, &fragment, settings.filter);
                    let kept = bits >> lane & 1 == 1;
                    // Weights are clamped: outside, there is nothing to compare.
                    if fragment.weights.min_element() <= 0.0 || (alpha - cutoff).abs() < 2e-3 {
                        continue;
                    }
                    assert_eq!(kept, alpha >= cutoff, "{id} at {place:?}: {alpha}");
                    *(if kept { &mut n_kept } else { &mut n_gone }) += 1;
                }
            }
        }
        assert!(n_wide > 0 && n_kept > 200 && n_gone > 100, "{n_wide} {n_kept} {n_gone}");
    }
}
