//! A tree of boxes, eight children to a node: what a frustum sees of a million of them
//! without asking each.
//!
//! Leaves are groups of eight boxes, nodes are groups of eight children, and both are tested in
//! one go by the arithmetic of [`wide`](crate::wide). Since that arithmetic is monotone, a walk
//! returns exactly the items, with exactly the masks, that testing every box would return:
//! [`Boxes8`](crate::wide::Boxes8) is its flat twin.
//!
//! The tree is one list of nodes and one of leaf groups, parents before children, so a walk is a
//! loop over a small stack and allocates nothing. Items in a subtree lie side by side: what is
//! wholly inside the frustum costs one call, however much it is.
//!
//! What a walk through a large tree waits for is memory, place after place, and the tables that
//! say where pages are. Large pages take a sixth off, or more (a million boxes; an allocator
//! that asks for them will do, with glibc `GLIBC_TUNABLES=glibc.malloc.hugetlb=1`; bench `walk`).
//! So a walk asks leaves in 16 bits a bound first, with the numbers of their items beside them: two
//! lines of memory in place of four, for 16 bytes a box (of 59) that other queries do not read. Eight
//! bits a bound with the numbers apart took longer.
//!
//! Boxes with a NaN or an infinity are kept beside the tree and tested one by one; empty boxes
//! are remembered and never visible.

mod build;
mod check;
mod edit;
mod many;
mod nodes;
mod ordered;
mod rays;
mod shapes;
mod stats;
mod tree;
mod walk;

use alloc::vec::Vec;

use build::{Item, Split, build_nodes, in_turn, leaves, link};
use ordered::{NearToFar, Occluded};
use tree::{Place, Tree};

pub use build::Join;
pub use check::{Fault, Quality};
pub use many::MAX_FRUSTA;
pub use nodes::NodeBox;
pub use shapes::{Cone, Overlap, overlap_box, overlap_cone, overlap_sphere};
pub use stats::{Counts, MAX_LEVELS, WalkStats};

use crate::wide::{Level, Space, Stored};
use crate::{Aabb, Frustum, PlaneMask, Ray, Sphere};

/// Boxes in a tree, known by number.
///
/// ```
/// use cullet_cull::wide::Level;
/// use cullet_cull::{Aabb, Frustum, Hierarchy};
/// # use cullet_transform::{Camera, Projection};
/// # use glam::DVec3;
/// # let lens = Projection::Perspective { yfov: 1.0, near: 0.1, far: 100.0 };
/// # let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, lens)?;
/// let cube = |z: f64| Aabb { min: DVec3::new(0.0, 0.0, z), max: DVec3::new(1.0, 1.0, z + 1.0) };
/// let mut boxes: Vec<Aabb> = (0..1000).map(|i| cube(f64::from(i))).collect();
/// let mut tree = Hierarchy::build(&boxes);
/// let frustum = Frustum::from_camera(&camera, 1.0);
/// let level = Level::new(); // once per process
/// assert!(tree.visible(&frustum, level).is_empty()); // all is behind the eye
/// boxes[7] = cube(-20.0);
/// tree.refit(&boxes);
/// tree.walk(&frustum, level, |ids, cutting| {
///     assert!(ids == [7] && cutting.is_empty()); // wholly inside: nothing to clip
/// });
/// # Ok::<(), cullet_transform::CameraError>(())
/// ```
///
/// # One origin
///
/// All boxes of a tree are stored relative to one origin, the median of their centres, and grow by
/// 2^-21 of their distance from it along each axis, plus a rounding (see
/// [`wide`](crate::wide#why-f32-can-be-trusted)). That is nothing for a world in one place. Of two
/// places 10^8 units apart it is 48 units for all boxes of the smaller one: nothing is lost there, but
/// much is kept that the camera does not see. Such a world wants a tree for each place.
#[derive(Clone, Debug)]
pub struct Hierarchy {
    tree: Tree,
}

impl Hierarchy {
    /// A tree over `boxes`; item `i` is `boxes[i]`.
    ///
    /// # Panics
    /// With more than 2^32 - 16 boxes.
    pub fn build(boxes: &[Aabb]) -> Hierarchy {
        Hierarchy::build_with(boxes, &in_turn)
    }

    /// The same tree, built by as many threads as `join` cares to use.
    ///
    /// # Panics
    /// With more than 2^32 - 16 boxes.
    pub fn build_with(boxes: &[Aabb], join: &Join<'_>) -> Hierarchy {
        assert!(boxes.len() <= u32::MAX as usize - 15, "items are numbered in 32 bits");
        let space = Space::around(boxes);
        let mut items = Vec::with_capacity(boxes.len());
        let mut beside = Vec::new();
        let mut places = alloc::vec![Place::Empty; boxes.len()];
        for (id, bounds) in boxes.iter().enumerate() {
            match space.store(bounds) {
                Stored::Bounded(bounds) => items.push(Item { bounds, id: id as u32 }),
                Stored::Beside => {
                    places[id] = Place::Beside(beside.len() as u32);
                    beside.push((id as u32, *bounds));
                }
                Stored::Empty => {}
            }
        }
        let mut nodes = build_nodes(&mut items, 0, Split::Cheapest, join);
        let (groups, ids) = leaves(&items);
        for (slot, item) in items.iter().enumerate() {
            places[item.id as usize] = Place::Slot(slot as u32);
        }
        let parents = link(&mut nodes, groups.len());
        let bounds = crate::wide::around(&groups);
        let n_items = boxes.len();
        let (free_nodes, free_groups) = (Vec::new(), Vec::new());
        let mut tree = Tree {
            space,
            bounds,
            nodes,
            groups,
            packed: Vec::new(),
            ids,
            parents,
            places,
            beside,
            n_waiting: 0,
            free_nodes,
            free_groups,
            n_items,
        };
        tree.packed = (0..tree.groups.len()).map(|group| tree.pack(group)).collect();
        Hierarchy { tree }
    }

    /// How many items there are, empty boxes included.
    pub fn len(&self) -> usize {
        self.tree.n_items
    }

    /// Whether there is no item at all.
    pub fn is_empty(&self) -> bool {
        self.tree.n_items == 0
    }

    /// Calls `visit` with every item whose box `frustum` may see, once, in runs that share a
    /// mask: the planes that may cut them. Runs come in no particular order. Allocates nothing.
    ///
    /// The answer is that of [`Boxes8::cutting_into`](crate::wide::Boxes8::cutting_into): all that
    /// [`planes_cutting`](crate::planes_cutting) keeps, and what lies within the rounding of f32
    /// beside it: 16 units of 2^-24 of the sizes of the terms, and these count from the
    /// [origin](Hierarchy#one-origin) of the tree, not from the eye. Boxes far from where most are
    /// look larger than they are.
    pub fn walk(
        &self,
        frustum: &Frustum,
        level: Level,
        mut visit: impl FnMut(&[u32], PlaneMask),
    ) -> WalkStats {
        walk::walk(&self.tree, frustum, level, None, &mut visit)
    }

    /// Like [`Hierarchy::walk`], and adds what was found of the boxes of nodes to `levels`: the first
    /// holds the children of the root.
    pub fn walk_by_level(
        &self,
        frustum: &Frustum,
        level: Level,
        levels: &mut [Counts; MAX_LEVELS],
        mut visit: impl FnMut(&[u32], PlaneMask),
    ) -> WalkStats {
        walk::walk(&self.tree, frustum, level, Some(levels), &mut visit)
    }

    /// Like [`Hierarchy::walk`], with nearer nodes and leaves before farther ones, by the middles of
    /// their boxes along the view direction. Within a run there is no order.
    pub fn walk_near_to_far(
        &self,
        frustum: &Frustum,
        level: Level,
        mut visit: impl FnMut(&[u32], PlaneMask),
    ) -> WalkStats {
        ordered::walk(&self.tree, frustum, level, NearToFar, &mut visit)
    }

    /// Like [`Hierarchy::walk_near_to_far`], and before it looks into a node or a leaf that the
    /// frustum may see, asks whether `occluded` hides the whole box: if so, nothing in it is
    /// returned.
    ///
    /// `occluded` may use what `visit` drew so far. It gets boxes in the space of the items and
    /// must say `false` when in doubt; a leaf holds at most eight items.
    pub fn walk_unoccluded(
        &self,
        frustum: &Frustum,
        level: Level,
        mut occluded: impl FnMut(&Aabb) -> bool,
        mut visit: impl FnMut(&[u32], PlaneMask),
    ) -> WalkStats {
        ordered::walk(&self.tree, frustum, level, Occluded(&mut occluded), &mut visit)
    }

    /// All visible items with their masks, in no particular order.
    pub fn visible(&self, frustum: &Frustum, level: Level) -> Vec<(u32, PlaneMask)> {
        let mut visible = Vec::new();
        self.walk(frustum, level, |ids, cutting| {
            visible.extend(ids.iter().map(|id| (*id, cutting)));
        });
        visible
    }

    /// Calls `visit` with every item that any of `frusta` may see, once, in runs that the same of
    /// them may see: bit `i` stands for `frusta[i]`.
    ///
    /// # Panics
    /// With more than [`MAX_FRUSTA`] frusta.
    pub fn walk_many(
        &self,
        frusta: &[Frustum],
        level: Level,
        mut visit: impl FnMut(&[u32], u64),
    ) -> WalkStats {
        many::walk(&self.tree, frusta, level, &mut visit)
    }

    /// Calls `visit` with runs of items whose boxes the shape behind `overlap` may touch.
    ///
    /// `overlap` is asked about boxes of nodes and of items, which are a little larger than the
    /// items were given: by 2^-20 of their distance from the middle of the world at most. Any
    /// shape will do, as long as it is not outside of a box with a part that it touches, and
    /// inside of a box only if it contains all of it.
    pub fn overlapping(
        &self,
        mut overlap: impl FnMut(&Aabb) -> Overlap,
        mut visit: impl FnMut(&[u32]),
    ) {
        shapes::query(&self.tree, &mut overlap, &mut visit);
    }

    /// [`Hierarchy::overlapping`] for a ball.
    pub fn in_sphere(&self, sphere: &Sphere, visit: impl FnMut(&[u32])) {
        self.overlapping(|bounds| overlap_sphere(sphere, bounds), visit);
    }

    /// [`Hierarchy::overlapping`] for a cone.
    pub fn in_cone(&self, cone: &Cone, visit: impl FnMut(&[u32])) {
        self.overlapping(|bounds| overlap_cone(cone, bounds), visit);
    }

    /// [`Hierarchy::overlapping`] for a box.
    pub fn in_box(&self, range: &Aabb, visit: impl FnMut(&[u32])) {
        self.overlapping(|bounds| overlap_box(range, bounds), visit);
    }

    /// Calls `visit` with every item whose box `ray` meets, and with the parameters where it
    /// enters and leaves, of the box as stored; see [`Hierarchy::overlapping`].
    pub fn hits(&self, ray: &Ray, mut visit: impl FnMut(u32, (f64, f64))) {
        rays::hits(&self.tree, ray, &mut visit);
    }

    /// The item that `ray` meets first, and the parameter where it does.
    ///
    /// `hit` knows the items: it returns where the ray meets one, within its box, or `None`; NaN
    /// is no hit either. Of equally near items the one with the lowest number is it.
    pub fn nearest(
        &self,
        ray: &Ray,
        mut hit: impl FnMut(u32) -> Option<f64>,
    ) -> Option<(u32, f64)> {
        rays::nearest(&self.tree, ray, &mut hit)
    }

    /// Moves items: item `i` takes `boxes[i]`. Numbers that name no item are passed over, items
    /// beyond the slice stay.
    ///
    /// The tree keeps its shape, so the farther things move the worse it gets; compare
    /// [`Quality::cost`] and build anew when it has grown by half. The [origin](Hierarchy#one-origin)
    /// follows, once the median of a sample has moved by a multiple of what half of the boxes keep to;
    /// items beyond the slice are then stored anew from what was stored of them, a little larger.
    pub fn refit(&mut self, boxes: &[Aabb]) {
        self.tree.refit(boxes);
    }

    /// Adds item `id`, or gives it another box if there is one of that number.
    ///
    /// Numbers should be small: the tree remembers a place for each up to the largest.
    ///
    /// What is inserted more than a thousand times as far out as half of the boxes at the time is
    /// tested by itself at first, in f64. When an eighth of the tree waits like this, or 1024 items,
    /// the [origin](Hierarchy#one-origin) moves to the median of a sample, if that suits most of them,
    /// and all join the tree. So the first insertions do not decide where it is precise; but boxes
    /// that were stored when it was precise elsewhere stay as large as they were stored.
    ///
    /// # Panics
    /// With an `id` of 2^32 - 16 or more.
    pub fn insert(&mut self, id: u32, bounds: &Aabb) {
        assert!(id < u32::MAX - 15, "items are numbered in 32 bits");
        self.tree.remove(id);
        self.tree.insert(id, bounds);
    }

    /// Takes item `id` away; `false` if there is none.
    pub fn remove(&mut self, id: u32) -> bool {
        self.tree.remove(id)
    }

    /// Whether all the tree promises is so. Takes time for every item: for tests.
    pub fn validate(&self) -> Result<(), Fault> {
        self.tree.validate()
    }

    /// How good the tree is.
    pub fn quality(&self) -> Quality {
        self.tree.quality()
    }
}
