//! Which object is which number of an id picture.

use crate::{Frame, Prepared};

/// One object of a legend.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LegendEntry {
    /// Object number, in scene order; id pictures hold this plus 1.
    pub object: usize,
    /// The object's own name.
    pub name: String,
    /// Names of its nodes from the root down.
    pub path: Vec<String>,
    /// Name of its mesh.
    pub mesh: String,
    /// Name of its material.
    pub material: String,
    /// Pixels that show it.
    pub n_pixels: u64,
    /// Left, upper, right and lower border of its pixels, the last two excluded.
    pub bounds_px: [u32; 4],
}

/// Every object that `frame.id` shows, in scene order.
pub fn legend(prepared: &Prepared, frame: &Frame) -> Vec<LegendEntry> {
    let mut seen = vec![(0u64, [u32::MAX, u32::MAX, 0, 0]); prepared.items().len()];
    for (i, &id) in frame.id.iter().enumerate().filter(|(_, id)| **id > 0) {
        let (x, y) = (i as u32 % frame.width, i as u32 / frame.width);
        let (n_pixels, [left, top, right, bottom]) = &mut seen[id as usize - 1];
        *n_pixels += 1;
        (*left, *top) = (x.min(*left), y.min(*top));
        (*right, *bottom) = ((x + 1).max(*right), (y + 1).max(*bottom));
    }
    let shown = seen.into_iter().enumerate().filter(|(_, (n_pixels, _))| *n_pixels > 0);
    shown.map(|(object, (n, bounds))| entry(prepared, object, n, bounds)).collect()
}

fn entry(prepared: &Prepared, index: usize, n_pixels: u64, bounds_px: [u32; 4]) -> LegendEntry {
    let scene = prepared.scene();
    let object = &scene.objects[index];
    let mut path = Vec::new();
    let mut node = Some(object.node);
    // Parents come before children, so this ends.
    while let Some(i) = node {
        path.push(scene.nodes[i].name.clone());
        node = scene.nodes[i].parent;
    }
    path.reverse();
    LegendEntry {
        object: index,
        name: object.name.clone(),
        path,
        mesh: scene.meshes[object.mesh].name.clone(),
        material: scene.materials[object.material].name.clone(),
        n_pixels,
        bounds_px,
    }
}
