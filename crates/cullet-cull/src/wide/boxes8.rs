//! A list of boxes, tested eight at a time, all of them.

use alloc::vec::Vec;

use fearless_simd::{Simd, dispatch};

use super::{Box32, Group, Level, Planes8, Space, Stored};
use crate::{Aabb, Frustum, PlaneMask, planes_cutting};

/// Boxes as a frustum likes them: f32, groups of eight, 24 bytes a box.
///
/// ```
/// use cullet_cull::wide::{Boxes8, Level};
/// use cullet_cull::{Aabb, Frustum};
/// # use cullet_transform::{Camera, Projection};
/// # use glam::DVec3;
/// # let lens = Projection::Perspective { yfov: 1.0, near: 0.1, far: 100.0 };
/// # let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, lens)?;
/// let cube = |z: f64| Aabb { min: DVec3::new(0.0, 0.0, z), max: DVec3::new(1.0, 1.0, z + 1.0) };
/// let boxes = Boxes8::new(&[cube(-9.0), cube(9.0), cube(-99.0)]);
/// let level = Level::new(); // once per process
/// let mut visible = vec![0; boxes.n_groups()];
/// boxes.visible_into(&Frustum::from_camera(&camera, 1.0), level, &mut visible);
/// assert_eq!(visible, [0b101]);
/// # Ok::<(), cullet_transform::CameraError>(())
/// ```
///
/// All boxes are stored relative to one origin, the median of their centres, and grow by 2^-21 of
/// their distance from it along each axis: boxes 10^8 units away from most are kept although they are
/// 48 units beside the view. A list per place, or one relative to the eye, is precise in each.
///
/// A box with a NaN or an infinity, or too far from the others for f32 (2^100 times their
/// extent), is kept beside and tested by [`planes_cutting`]; there should be few of those.
#[derive(Clone, Debug)]
pub struct Boxes8 {
    pub(crate) space: Space,
    pub(crate) groups: Vec<Group>,
    /// Around all stored boxes.
    pub(crate) bounds: Box32,
    pub(crate) beside: Vec<(u32, Aabb)>,
    n_boxes: usize,
}

impl Boxes8 {
    /// The boxes in the order given. Empty ones keep their place and are never visible.
    pub fn new(boxes: &[Aabb]) -> Boxes8 {
        let space = Space::around(boxes);
        let mut groups = alloc::vec![Group::ABSENT; boxes.len().div_ceil(8)];
        let mut beside = Vec::new();
        for (index, bounds) in boxes.iter().enumerate() {
            match space.store(bounds) {
                Stored::Bounded(stored) => groups[index / 8].set(index % 8, &stored),
                Stored::Beside => beside.push((index as u32, *bounds)),
                Stored::Empty => {}
            }
        }
        let bounds = around(&groups);
        Boxes8 { space, groups, bounds, beside, n_boxes: boxes.len() }
    }

    /// How many boxes, empty ones included.
    pub fn len(&self) -> usize {
        self.n_boxes
    }

    /// Whether there is no box at all.
    pub fn is_empty(&self) -> bool {
        self.n_boxes == 0
    }

    /// Bytes that [`Boxes8::visible_into`] fills.
    pub fn n_groups(&self) -> usize {
        self.groups.len()
    }

    /// Sets bit `i % 8` of `out[i / 8]` if `frustum` may see box `i`, and clears it if not.
    ///
    /// # Panics
    /// If `out` has not [`Boxes8::n_groups`] bytes.
    pub fn visible_into(&self, frustum: &Frustum, level: Level, out: &mut [u8]) {
        assert_eq!(out.len(), self.n_groups(), "one byte per group of eight boxes");
        let planes = self.planes(frustum);
        dispatch!(level, simd => visible(simd, &planes, &self.groups, out));
        self.ask_beside(frustum, out);
    }

    /// Sets the bits of visible boxes that are kept beside.
    pub(super) fn ask_beside(&self, frustum: &Frustum, out: &mut [u8]) {
        for (index, bounds) in &self.beside {
            if planes_cutting(bounds, frustum, PlaneMask::ALL).is_some() {
                out[*index as usize / 8] |= 1 << (index % 8);
            }
        }
    }

    /// For each box the planes that may cut it, or `None` if one of them excludes it.
    ///
    /// # Panics
    /// If `out` has not [`Boxes8::len`] elements.
    pub fn cutting_into(&self, frustum: &Frustum, level: Level, out: &mut [Option<PlaneMask>]) {
        assert_eq!(out.len(), self.len(), "one verdict per box");
        let planes = self.planes(frustum);
        dispatch!(level, simd => cutting(simd, &planes, &self.groups, out));
        for (index, bounds) in &self.beside {
            out[*index as usize] = planes_cutting(bounds, frustum, PlaneMask::ALL);
        }
    }

    pub(crate) fn planes(&self, frustum: &Frustum) -> Planes8 {
        Planes8::new(frustum, &self.space, &self.bounds)
    }
}

/// The least box around all boxes in `groups`.
pub(crate) fn around(groups: &[Group]) -> Box32 {
    groups.iter().fold(Box32::EMPTY, |all, group| all.union(&group.union()))
}

#[inline(always)]
fn visible<S: Simd>(simd: S, planes: &Planes8, groups: &[Group], out: &mut [u8]) {
    let (fours, rest) = groups.as_chunks::<4>();
    let (out_fours, out_rest) = out.as_chunks_mut::<4>();
    for (four, out) in fours.iter().zip(out_fours) {
        *out = planes.visible(simd, four);
    }
    for (one, out) in rest.iter().zip(out_rest) {
        [*out] = planes.visible(simd, core::array::from_ref(one));
    }
}

#[inline(always)]
fn cutting<S: Simd>(simd: S, planes: &Planes8, groups: &[Group], out: &mut [Option<PlaneMask>]) {
    for (group, out) in groups.iter().zip(out.chunks_mut(8)) {
        let verdict = planes.test(simd, group, planes.asked);
        let masks = verdict.masks();
        for (lane, out) in out.iter_mut().enumerate() {
            let visible = verdict.visible >> lane & 1 != 0;
            *out = if visible { Some(PlaneMask::from_bits(masks[lane])) } else { None };
        }
    }
}
