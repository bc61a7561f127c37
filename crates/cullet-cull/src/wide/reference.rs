//! The wide test one box at a time, without vectors: what every level must agree with, bit
//! for bit.

use alloc::vec::Vec;

use super::{Box32, Boxes8, Planes8};
use crate::{Frustum, PlaneMask, planes_cutting};

/// What [`Boxes8::cutting_into`] answers.
pub fn cutting(boxes: &Boxes8, frustum: &Frustum) -> Vec<Option<PlaneMask>> {
    let planes = boxes.planes(frustum);
    let mut verdicts: Vec<_> = (0..boxes.len())
        .map(|index| planes_cutting_stored(&boxes.groups[index / 8].get(index % 8), &planes))
        .collect();
    for (index, bounds) in &boxes.beside {
        verdicts[*index as usize] = planes_cutting(bounds, frustum, PlaneMask::ALL);
    }
    verdicts
}

fn planes_cutting_stored(bounds: &Box32, planes: &Planes8) -> Option<PlaneMask> {
    let mut cutting = PlaneMask::NONE;
    for index in planes.asked.iter() {
        let plane = &planes.planes[index];
        let (mut far, mut near) = (bounds.max, bounds.min);
        for axis in 0..3 {
            if plane.normal[axis] < 0.0 {
                (far[axis], near[axis]) = (near[axis], far[axis]);
            }
        }
        let may_reach = distance(plane.normal, far, plane.outer) >= 0.0; // false for NaN
        if !may_reach {
            return None;
        }
        let inside = distance(plane.normal, near, plane.inner) >= 0.0;
        if !inside {
            cutting.insert(index);
        }
    }
    Some(cutting)
}

fn distance(normal: [f32; 3], corner: [f32; 3], offset: f32) -> f32 {
    (corner[0] * normal[0] + corner[1] * normal[1]) + (corner[2] * normal[2] + offset)
}
