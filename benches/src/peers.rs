//! What others do, or would do: flat loops, and frustum walks written by hand over trees that
//! have none. Plain f32, the p-vertex test with inherited plane masks; none of them promises
//! anything about rounding.

use bvh::aabb::{Aabb as BvhAabb, Bounded};
use bvh::bounding_hierarchy::BHShape;
use bvh::bvh::{Bvh, BvhNode};
use cullet_cull::{Aabb, Frustum};
use glam::{Vec3, Vec3A, Vec4};
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{BvhBuildParams, aabb::Aabb as ObvhsAabb};

/// Six planes in world space.
#[derive(Clone, Copy, Debug)]
pub struct Planes([Vec4; 6]);

impl Planes {
    /// The planes of `frustum`.
    pub fn new(frustum: &Frustum) -> Planes {
        Planes(frustum.planes().map(|plane| {
            let offset = plane.offset - plane.normal.dot(frustum.origin());
            plane.normal.as_vec3().extend(offset as f32)
        }))
    }

    /// Which planes among `asked` cut the box, or `None`.
    #[inline]
    fn cutting(&self, min: Vec3, max: Vec3, asked: u8) -> Option<u8> {
        let mut cutting = 0;
        let mut left = asked;
        while left != 0 {
            let index = left.trailing_zeros() as usize;
            left &= left - 1;
            let plane = self.0[index];
            let positive = plane.truncate().cmpge(Vec3::ZERO);
            let far = Vec3::select(positive, max, min);
            if plane.truncate().dot(far) + plane.w < 0.0 {
                return None;
            }
            let near = Vec3::select(positive, min, max);
            cutting |= u8::from(plane.truncate().dot(near) + plane.w < 0.0) << index;
        }
        Some(cutting)
    }
}

/// A plain loop with early exit over boxes in f32.
pub struct Flat(Vec<(Vec3, Vec3)>);

impl Flat {
    /// Keeps the boxes in order.
    pub fn new(boxes: &[Aabb]) -> Flat {
        Flat(boxes.iter().map(|b| (b.min.as_vec3(), b.max.as_vec3())).collect())
    }

    /// One `bool` per box.
    pub fn visible(&self, planes: &Planes, out: &mut [bool]) {
        for ((min, max), out) in self.0.iter().zip(out) {
            *out = planes.0.iter().all(|plane| {
                let far = Vec3::select(plane.truncate().cmpge(Vec3::ZERO), *max, *min);
                plane.truncate().dot(far) + plane.w >= 0.0
            });
        }
    }
}

/// The loop of an engine (the shape of bevy's `check_visibility`): the sphere around the box against
/// all planes, then the box against all planes, over centres and half extents.
pub struct SphereThenBox(Vec<(Vec3A, Vec3A)>);

impl SphereThenBox {
    /// Keeps the boxes in order.
    pub fn new(boxes: &[Aabb]) -> SphereThenBox {
        let convert = |b: &Aabb| (b.center().as_vec3a(), b.half_extent().as_vec3a());
        SphereThenBox(boxes.iter().map(convert).collect())
    }

    /// One `bool` per box.
    pub fn visible(&self, planes: &Planes, out: &mut [bool]) {
        for ((center, half), out) in self.0.iter().zip(out) {
            let radius = half.length();
            let at = center.extend(1.0);
            let sphere = planes.0.iter().all(|plane| plane.dot(at) + radius > 0.0);
            *out = sphere
                && planes.0.iter().all(|plane| {
                    let reach = half.dot(Vec3A::from_vec4(*plane).abs());
                    plane.dot(at) + reach > 0.0
                });
        }
    }
}

/// `obvhs`: its binary tree, medium build.
pub struct Obvhs(Bvh2);

impl Obvhs {
    /// Builds the tree.
    pub fn new(boxes: &[Aabb]) -> Obvhs {
        let boxes: Vec<_> =
            boxes.iter().map(|b| ObvhsAabb::new(b.min.as_vec3a(), b.max.as_vec3a())).collect();
        let mut time = Default::default();
        Obvhs(build_bvh2(&boxes, BvhBuildParams::medium_build(), &mut time))
    }

    /// Appends the numbers of what is visible. A leaf holds up to eight items, all taken if the
    /// leaf is, since the tree has no boxes of items: that saves it work, and it returns more.
    pub fn walk(&self, planes: &Planes, stack: &mut Vec<(u32, u8)>, out: &mut Vec<u32>) {
        stack.push((0, 0b11_1111));
        while let Some((index, asked)) = stack.pop() {
            let node = &self.0.nodes[index as usize];
            let (min, max) = (Vec3::from(node.aabb.min), Vec3::from(node.aabb.max));
            let cutting = if asked == 0 { Some(0) } else { planes.cutting(min, max, asked) };
            let Some(cutting) = cutting else { continue };
            let first = node.first_index as usize;
            if node.prim_count > 0 {
                let items = first..first + node.prim_count as usize;
                out.extend_from_slice(&self.0.primitive_indices[items]);
            } else {
                stack.push((node.first_index + 1, cutting));
                stack.push((node.first_index, cutting));
            }
        }
    }
}

/// `bvh`: its binary tree, one item per leaf.
pub struct SvenstaroBvh(Bvh<f32, 3>);

struct Shape(BvhAabb<f32, 3>, usize);

impl Bounded<f32, 3> for Shape {
    fn aabb(&self) -> BvhAabb<f32, 3> {
        self.0
    }
}

impl BHShape<f32, 3> for Shape {
    fn set_bh_node_index(&mut self, index: usize) {
        self.1 = index;
    }

    fn bh_node_index(&self) -> usize {
        self.1
    }
}

impl SvenstaroBvh {
    /// Builds the tree.
    pub fn new(boxes: &[Aabb]) -> SvenstaroBvh {
        let mut shapes: Vec<_> = boxes
            .iter()
            .map(|b| {
                let (min, max) = (b.min.as_vec3().to_array(), b.max.as_vec3().to_array());
                Shape(BvhAabb::with_bounds(min.into(), max.into()), 0)
            })
            .collect();
        SvenstaroBvh(Bvh::build(&mut shapes))
    }

    /// Appends the numbers of what is visible.
    pub fn walk(&self, planes: &Planes, stack: &mut Vec<(u32, u8)>, out: &mut Vec<u32>) {
        let test = |bounds: &BvhAabb<f32, 3>, asked| {
            let min = Vec3::new(bounds.min.x, bounds.min.y, bounds.min.z);
            let max = Vec3::new(bounds.max.x, bounds.max.y, bounds.max.z);
            if asked == 0 { Some(0) } else { planes.cutting(min, max, asked) }
        };
        stack.push((0, 0b11_1111));
        while let Some((index, asked)) = stack.pop() {
            match &self.0.nodes[index as usize] {
                BvhNode::Leaf { shape_index, .. } => out.push(*shape_index as u32),
                BvhNode::Node {
                    child_l_index, child_l_aabb, child_r_index, child_r_aabb, ..
                } => {
                    if let Some(cutting) = test(child_r_aabb, asked) {
                        stack.push((*child_r_index as u32, cutting));
                    }
                    if let Some(cutting) = test(child_l_aabb, asked) {
                        stack.push((*child_l_index as u32, cutting));
                    }
                }
            }
        }
    }
}
