//! The planes of a frustum as eight boxes meet them.

use fearless_simd::{Simd, f32x8, prelude::*};
use glam::DVec3;

use super::{Box32, Group, Row, Space};
use crate::{Frustum, PlaneMask};

/// The index of the near plane.
const NEAR: usize = cullet_transform::Plane::Near.index();

/// 2^-24, the unit roundoff of f32.
const U: f64 = 1.0 / (1 << 24) as f64;

/// Coefficients below this become 0.
const SMALLEST: f64 = 1.0 / (1_u64 << 60) as f64;

/// No component of a unit vector is larger, whatever rounding did to it.
const LARGEST: DVec3 = DVec3::splat(2.0);

/// More than a sum of underflows loses.
const UNDERFLOW: f64 = f32::MIN_POSITIVE as f64 / (1 << 20) as f64;

/// A plane in stored units, with room for every rounding; see the module above.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plane32 {
    /// Inward, about unit length.
    pub normal: [f32; 3],
    /// The bounds that make the corner farthest along the normal.
    far: [Row; 3],
    /// The bounds that make the corner nearest.
    near: [Row; 3],
    /// Added to the farthest corner: below zero proves the box outside.
    pub outer: f32,
    /// Added to the nearest corner: at or above zero proves the box inside.
    pub inner: f32,
}

impl Plane32 {
    /// Decides nothing.
    pub const UNKNOWN: Plane32 = Plane32 {
        normal: [0.0; 3],
        far: Row::MAX,
        near: Row::MIN,
        outer: f32::INFINITY,
        inner: f32::NEG_INFINITY,
    };
    /// Everything is inside.
    const AT_INFINITY: Plane32 = Plane32 { inner: f32::INFINITY, ..Plane32::UNKNOWN };

    /// The points at `normal · p + offset >= 0`, as if nothing were ever rounded.
    #[cfg(test)]
    pub fn through(normal: [f32; 3], offset: f32) -> Plane32 {
        let (far, near) = corners(normal);
        Plane32 { normal, far, near, outer: offset, inner: offset }
    }

    /// Plane `index`, for boxes within `bounds`, unless it excludes all of them.
    #[inline(always)]
    fn reaching(frustum: &Frustum, index: usize, space: &Space, bounds: &Box32) -> Option<Plane32> {
        let plane = Plane32::new(frustum, index, space, bounds);
        let [x, y, z] = plane.normal.map(|n| n < 0.0);
        let far = |axis: usize, is_min| [bounds.max[axis], bounds.min[axis]][usize::from(is_min)];
        let may_reach =
            distance_1(plane.normal, [far(0, x), far(1, y), far(2, z)], plane.outer) >= 0.0;
        may_reach.then_some(plane)
    }

    /// Plane `index` of `frustum`, for boxes stored in `space` that all lie within `bounds`.
    #[inline(always)]
    fn new(frustum: &Frustum, index: usize, space: &Space, bounds: &Box32) -> Plane32 {
        let (plane, slack) = (&frustum.planes[index], frustum.errors[index]);
        let from_eye = (space.origin - frustum.origin) * space.scale;
        let (offset, offset_slack) = (plane.offset * space.scale, slack.offset * space.scale);
        let terms = plane.normal * from_eye;
        let rebased = terms.x + terms.y + terms.z + offset;

        // What the sum above may have lost, and what the plane never knew.
        let mut doubt = 8.0 * f64::EPSILON * (terms.abs().element_sum() + offset.abs())
            + slack.normal.dot(from_eye.abs())
            + offset_slack;
        let (mut normal, size) = (plane.normal, plane.normal.abs());
        let ordinary =
            size.cmpge(DVec3::splat(SMALLEST)) & slack.normal.cmple(U * size) & size.cmple(LARGEST);
        if !ordinary.all() {
            let lost;
            (normal, lost) = without_the_small(normal, slack.normal, bounds);
            doubt += lost;
        }
        if !(rebased + doubt).is_finite() {
            let at_infinity = plane.offset == f64::INFINITY;
            return if at_infinity { Plane32::AT_INFINITY } else { Plane32::UNKNOWN };
        }
        let normal = normal.to_array().map(|n| n as f32);
        let (greatest, least) = (rebased + doubt, rebased - doubt);
        let (far, near) = corners(normal);
        Plane32 {
            normal,
            far,
            near,
            outer: (greatest + 8.0 * U * greatest.abs() + UNDERFLOW) as f32,
            inner: (least - 8.0 * U * least.abs() - UNDERFLOW) as f32,
        }
    }
}

/// The bounds that make the corners farthest along `normal` and nearest.
#[inline(always)]
pub fn corners(normal: [f32; 3]) -> ([Row; 3], [Row; 3]) {
    let (mut far, mut near) = (Row::MAX, Row::MIN);
    for axis in 0..3 {
        if normal[axis] < 0.0 {
            (far[axis], near[axis]) = (near[axis], far[axis]);
        }
    }
    (far, near)
}

/// The normal with 0 for coefficients next to it, and how far that, and slack above u of a
/// coefficient, can move a corner of `bounds`. NaN for no normal at all.
#[cold]
fn without_the_small(normal: DVec3, slack: DVec3, bounds: &Box32) -> (DVec3, f64) {
    let size = normal.abs();
    if !size.cmple(LARGEST).all() {
        return (normal, f64::NAN);
    }
    let small = size.cmplt(DVec3::splat(SMALLEST));
    let lost = DVec3::select(slack.cmpgt(U * size), slack, DVec3::ZERO)
        + DVec3::select(small, size, DVec3::ZERO);
    let reach = DVec3::from_array(bounds.reach().map(f64::from));
    (DVec3::select(small, DVec3::ZERO, normal), lost.dot(reach))
}

/// Six planes in stored units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Planes8 {
    pub planes: [Plane32; 6],
    /// The planes that may cut anything: all but those at infinity, and at least one.
    pub asked: PlaneMask,
}

/// What the planes asked say about eight boxes. Absent boxes are not visible.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Verdict {
    /// One bit per box that no plane excludes.
    pub visible: u8,
    /// Byte `p`: one bit per box that plane `p` may cut, meaningful for visible boxes.
    cutting: u64,
}

impl Verdict {
    /// By box, one bit per plane that may cut it; meaningful for visible boxes.
    #[inline(always)]
    pub fn masks(self) -> [u8; 8] {
        transposed(self.cutting).to_le_bytes()
    }

    /// What there is to say of boxes of which nothing is asked: those present are inside.
    #[inline(always)]
    pub fn inside_all(present: u8) -> Verdict {
        Verdict { visible: present, cutting: 0 }
    }

    /// One bit per visible box that no plane cuts.
    #[inline(always)]
    pub fn inside(self) -> u8 {
        let folded = self.cutting | self.cutting >> 32;
        let folded = folded | folded >> 16;
        self.visible & !((folded | folded >> 8) as u8)
    }
}

impl Planes8 {
    /// The planes of `frustum` for boxes stored in `space` that all lie within `bounds`.
    pub fn new(frustum: &Frustum, space: &Space, bounds: &Box32) -> Planes8 {
        let planes: [Plane32; 6] =
            core::array::from_fn(|index| Plane32::new(frustum, index, space, bounds));
        let mut asked = PlaneMask::NONE;
        for (index, plane) in planes.iter().enumerate() {
            if plane.inner < f32::INFINITY {
                asked.insert(index);
            }
        }
        // Absent boxes fall to a comparison: make sure there is one.
        let asked = if asked.is_empty() { PlaneMask::from_bits(1) } else { asked };
        Planes8 { planes, asked }
    }

    /// The planes of `frustum` for boxes stored in `space` that all lie within `bounds`, or `None` if
    /// one plane excludes `bounds`. The planes asked are those that cut `bounds`, maybe none.
    ///
    /// Planes are made ready one by one, the near plane first, which alone excludes all that lies
    /// behind the eye.
    #[inline]
    pub fn cutting(frustum: &Frustum, space: &Space, bounds: &Box32) -> Option<Planes8> {
        let near = Plane32::reaching(frustum, NEAR, space, bounds)?;
        Planes8::with_near(near, frustum, space, bounds)
    }

    /// Out of line, so that who looks away passes over little code.
    #[inline(never)]
    fn with_near(
        near: Plane32,
        frustum: &Frustum,
        space: &Space,
        bounds: &Box32,
    ) -> Option<Planes8> {
        let mut planes = [near; 6];
        let mut asked = PlaneMask::NONE;
        for (index, plane) in planes.iter_mut().enumerate() {
            if index != NEAR {
                *plane = Plane32::reaching(frustum, index, space, bounds)?;
            }
            let corner = plane.near.map(|row| bounds.at(row));
            let inside = distance_1(plane.normal, corner, plane.inner) >= 0.0;
            if !inside {
                asked.insert(index);
            }
        }
        Some(Planes8 { planes, asked })
    }

    /// Asks one plane about eight boxes: which it does not exclude, and which it certainly does not
    /// cut.
    #[inline(always)]
    pub fn ask<S: Simd>(&self, simd: S, index: usize, group: &Group) -> (u8, u8) {
        let plane = &self.planes[index.min(5)];
        let zero = f32x8::splat(simd, 0.0);
        // Of both ends of an axis, the farthest along the normal makes the greater product: no choice
        // by sign, and the same number.
        let (mut far, mut near) = ([zero; 3], [zero; 3]);
        for axis in 0..3 {
            let min = f32x8::simd_from(simd, *group.row(Row::MIN[axis])) * plane.normal[axis];
            let max = f32x8::simd_from(simd, *group.row(Row::MAX[axis])) * plane.normal[axis];
            far[axis] = min.max(max);
            near[axis] = min.min(max);
        }
        let far = (far[0] + far[1]) + (far[2] + plane.outer);
        let near = (near[0] + near[1]) + (near[2] + plane.inner);
        let reached = far.simd_ge(zero).to_bitmask() as u8;
        let inside = near.simd_ge(zero).to_bitmask() as u8;
        (reached, inside)
    }

    /// Asks the planes in `asked`, not none, about eight boxes.
    #[inline(always)]
    pub fn test<S: Simd>(&self, simd: S, group: &Group, asked: PlaneMask) -> Verdict {
        let mut visible = 0xff;
        let mut cutting = 0;
        let mut left = asked.bits();
        while left != 0 {
            let index = left.trailing_zeros() as usize;
            left &= left - 1;
            let (reached, inside) = self.ask(simd, index, group);
            visible &= reached;
            cutting |= u64::from(!inside) << (8 * index);
        }
        Verdict { visible, cutting }
    }

    /// One bit per present box that none of the six planes excludes, for `N` groups: more than one
    /// share the work of fetching the planes.
    #[inline(always)]
    pub fn visible<S: Simd, const N: usize>(&self, simd: S, groups: &[Group; N]) -> [u8; N] {
        let [first, others @ ..] = &self.planes;
        let mut least = [f32x8::splat(simd, 0.0); N];
        for i in 0..N {
            least[i] = upper_end(simd, first, &groups[i]);
        }
        for plane in others {
            for i in 0..N {
                // Either all distances of a box are NaN, or none, and zeros are alike: which of two `min`
                // prefers there does not matter.
                least[i] = least[i].min(upper_end(simd, plane, &groups[i]));
            }
        }
        let mut bits = [0; N];
        for i in 0..N {
            bits[i] = least[i].simd_ge(f32x8::splat(simd, 0.0)).to_bitmask() as u8;
        }
        bits
    }
}

/// Of each box, the computed distance of the corner farthest along the normal. The order of these
/// operations is part of the result; `reference` repeats it.
#[inline(always)]
fn upper_end<S: Simd>(simd: S, plane: &Plane32, group: &Group) -> f32x8<S> {
    let Plane32 { normal, far, outer, .. } = plane;
    let x = f32x8::simd_from(simd, *group.row(far[0])) * normal[0];
    let y = f32x8::simd_from(simd, *group.row(far[1])) * normal[1];
    let z = f32x8::simd_from(simd, *group.row(far[2])) * normal[2];
    (x + y) + (z + *outer)
}

/// The same of one corner.
#[inline(always)]
fn distance_1(normal: [f32; 3], corner: [f32; 3], offset: f32) -> f32 {
    let [x, y, z] = [corner[0] * normal[0], corner[1] * normal[1], corner[2] * normal[2]];
    (x + y) + (z + offset)
}

/// The transpose of an 8x8 matrix of bits: bit `i` of byte `j` becomes bit `j` of byte `i`
/// (Warren, "Hacker's Delight", 2012, section 7-3).
#[inline(always)]
const fn transposed(mut x: u64) -> u64 {
    let t = (x ^ (x >> 7)) & 0x00aa_00aa_00aa_00aa;
    x ^= t ^ (t << 7);
    let t = (x ^ (x >> 14)) & 0x0000_cccc_0000_cccc;
    x ^= t ^ (t << 14);
    let t = (x ^ (x >> 28)) & 0x0000_0000_f0f0_f0f0;
    x ^ t ^ (t << 28)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transposing_moves_each_bit() {
        for (i, j) in (0..8).flat_map(|i| (0..8).map(move |j| (i, j))) {
            assert_eq!(transposed(1 << (8 * j + i)), 1 << (8 * i + j));
        }
    }

    #[test]
    fn verdicts_by_box() {
        // Plane 0 cuts boxes 0 and 2, plane 5 boxes 2 and 3; box 3 is not visible.
        let verdict = Verdict { visible: 0b0111, cutting: 0b101 | 0b1100 << 40 };
        assert_eq!(verdict.inside(), 0b0010);
        assert_eq!(verdict.masks()[..3], [1, 0, 0b10_0001]);
    }
}
