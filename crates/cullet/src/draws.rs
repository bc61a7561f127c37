//! The objects that a frame shows, as its pixels meet them.

use cullet_raster::Placement;
use cullet_shade::Needs;

use crate::shading::Scene;

/// Slots of the table that remembers whose an id was.
const HINTS: usize = 1024;

/// An object as this frame draws it.
#[derive(Debug)]
pub(crate) struct Draw {
    pub item: usize,
    pub first_triangle: u32,
    n_triangles: u32,
    pub placement: Placement,
    pub needs: Needs,
    pub paint: u32,
    /// Triangles of the batch, and where the next of them goes in the list.
    pub n_wanted: u32,
    pub next: u32,
}

/// What pixels must have in common to be coloured together, and an item that has it.
#[derive(Debug)]
pub(crate) struct PaintKey {
    material: usize,
    pub needs: Needs,
    pub item: usize,
}

/// The objects met in this frame.
#[derive(Debug)]
pub(crate) struct Draws {
    pub all: Vec<Draw>,
    pub paints: Vec<PaintKey>,
    /// By item, the draw's index + 1, or 0.
    of_item: Vec<u32>,
    /// By some bits of a triangle's id, the draw that it was last found in.
    hints: Vec<u32>,
}

impl Default for Draws {
    fn default() -> Self {
        let hints = vec![0; HINTS];
        Draws { all: Vec::new(), paints: Vec::new(), of_item: Vec::new(), hints }
    }
}

impl Draws {
    /// Memory held.
    pub(crate) fn bytes(&self) -> usize {
        self.all.capacity() * size_of::<Draw>()
            + self.paints.capacity() * size_of::<PaintKey>()
            + (self.of_item.capacity() + HINTS) * 4
    }

    /// Forgets the frame before.
    pub(crate) fn forget(&mut self) {
        for draw in self.all.drain(..) {
            if let Some(of_item) = self.of_item.get_mut(draw.item) {
                *of_item = 0;
            }
        }
        self.paints.clear();
    }

    /// Makes room for a scene of so many items.
    pub(crate) fn resize(&mut self, n_items: usize) {
        self.of_item.resize(n_items, 0);
    }

    /// The draw that triangle `id` is of.
    #[inline]
    pub(crate) fn of(&mut self, scene: &Scene<'_>, id: u32) -> u32 {
        let hint = &mut self.hints[(id >> 6) as usize % HINTS];
        if let Some(draw) = self.all.get(*hint as usize)
            && id.wrapping_sub(draw.first_triangle) < draw.n_triangles
        {
            return *hint;
        }
        let item_idx = scene.prepared.item_of(id);
        if self.of_item[item_idx] == 0 {
            let item = &scene.prepared.items()[item_idx];
            let needs = scene.needs(item);
            let same = |key: &PaintKey| key.material == item.material && key.needs == needs;
            let paint = self.paints.iter().position(same).unwrap_or_else(|| {
                self.paints.push(PaintKey { material: item.material, needs, item: item_idx });
                self.paints.len() - 1
            });
            self.all.push(Draw {
                item: item_idx,
                first_triangle: item.first_triangle,
                n_triangles: item.n_triangles,
                placement: Placement::new(
                    scene.view.clip_from_model(&item.world_from_model),
                    scene.view.viewport(),
                    scene.planes[item_idx].unwrap_or_default(),
                    scene.settings.subpixel_bits,
                ),
                needs,
                paint: paint as u32,
                n_wanted: 0,
                next: 0,
            });
            self.of_item[item_idx] = self.all.len() as u32;
        }
        *hint = self.of_item[item_idx] - 1;
        *hint
    }
}
