//! From f64 boxes anywhere to f32 boxes around zero, rounded outwards.

use alloc::vec::Vec;

use glam::DVec3;

use super::Box32;
use crate::Aabb;

/// Relative outward shift of every stored bound: 8 units of 2^-24.
const INFLATION: f64 = 8.0 / (1 << 24) as f64;

/// No stored coordinate is larger, so that no product or sum of a test overflows.
const LARGEST: f32 = (1_u128 << 100) as f32;

/// Boxes looked at to find the middle.
const SAMPLES: usize = 1000;

/// Where stored boxes count from, and in which unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Space {
    /// The stored zero, in the space of the boxes.
    pub origin: DVec3,
    /// Stored units per scene unit, a power of two.
    pub scale: f64,
}

/// What becomes of a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Stored {
    /// It has an f32 twin.
    Bounded(Box32),
    /// It holds no point.
    Empty,
    /// NaN, infinite, or too far away for f32: to be tested by itself, in f64.
    Beside,
}

impl Space {
    /// Zero in the midst of the finite boxes, most coordinates below 1.
    ///
    /// Medians, not means: one box that reaches far out must not take the precision of all others
    /// with it.
    pub fn around(boxes: &[Aabb]) -> Space {
        let finite = |b: &&Aabb| b.min.is_finite() && b.max.is_finite() && !b.is_empty();
        let finite: Vec<&Aabb> = boxes.iter().filter(finite).collect();
        let sample = || finite.iter().step_by(finite.len().div_ceil(SAMPLES).max(1));
        let origin = DVec3::from_array(core::array::from_fn(|axis| {
            median(sample().map(|b| b.center()[axis]).collect())
        }));
        let reach = |b: &&Aabb| (b.min - origin).abs().max((b.max - origin).abs()).max_element();
        let typical = median(sample().map(reach).collect());
        // A world in one point has no extent: its distance from zero is scale enough.
        let candidates =
            [typical, sample().map(reach).fold(0.0, f64::max), origin.abs().max_element()];
        let reach = candidates.into_iter().find(|reach| *reach > 0.0);
        let exponent = reach.map_or(0, |reach| libm::ilogb(reach.min(f64::MAX)) + 1);
        Space { origin, scale: libm::ldexp(1.0, (-exponent).clamp(-1000, 1000)) }
    }

    /// Whether boxes that this space is around would be stored noticeably larger in `other`, which
    /// counts from a place more than four times as far away as half of them reach; or its
    /// unit does not suit them at all.
    pub fn is_far_from(&self, other: &Space) -> bool {
        const UNITS: f64 = (1_u64 << 32) as f64;
        let away = (self.origin - other.origin).abs().max_element() * self.scale;
        let units = self.scale / other.scale;
        let suits = away <= 4.0 && (1.0 / UNITS..=UNITS).contains(&units);
        !suits // also where numbers do not reach
    }

    /// The f32 twin of `bounds`, which contains it.
    pub fn store(&self, bounds: &Aabb) -> Stored {
        if bounds.is_nan() {
            return Stored::Beside;
        }
        if bounds.is_empty() {
            return Stored::Empty;
        }
        let min = (bounds.min - self.origin) * self.scale;
        let max = (bounds.max - self.origin) * self.scale;
        let stored = Box32 {
            min: min.to_array().map(|x| down(x - x.abs() * INFLATION)),
            max: max.to_array().map(|x| up(x + x.abs() * INFLATION)),
        };
        let within = |x: &f32| x.abs() <= LARGEST; // false for NaN and infinities
        let fits = stored.min.iter().all(within) && stored.max.iter().all(within);
        if fits { Stored::Bounded(stored) } else { Stored::Beside }
    }

    /// An f64 box around a stored one.
    pub fn restore(&self, stored: &Box32) -> Aabb {
        let point = |p: [f32; 3]| DVec3::from_array(p.map(f64::from)) / self.scale;
        // Half an ulp of what the origin adds: one step outwards covers it.
        let step = |v: DVec3, f: fn(f64) -> f64| DVec3::new(f(v.x), f(v.y), f(v.z));
        Aabb {
            min: step(self.origin + point(stored.min), f64::next_down),
            max: step(self.origin + point(stored.max), f64::next_up),
        }
    }
}

/// The middle one, 0 of none.
fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

/// The greatest f32 that is not above `x`.
pub(crate) fn down(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) > x { nearest.next_down() } else { nearest }
}

/// The least f32 that is not below `x`.
pub(crate) fn up(x: f64) -> f32 {
    -down(-x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(center: f64, half: f64) -> Aabb {
        Aabb { min: DVec3::splat(center - half), max: DVec3::splat(center + half) }
    }

    #[test]
    fn the_stored_box_contains_the_box_at_every_scale() {
        for scale in [1e-300, 1e-30, 1e-3, 1.0, 1e7, 1e30, 1e300] {
            let boxes = [cube(0.3 * scale, 0.1 * scale), cube(2.0 * scale, 0.7 * scale)];
            let space = Space::around(&boxes);
            for bounds in &boxes {
                let Stored::Bounded(stored) = space.store(bounds) else { panic!("{scale}") };
                let restored = space.restore(&stored);
                assert!(restored.contains(bounds), "{restored:?} {bounds:?}");
                let slop = (restored.max - bounds.max).max_element();
                assert!(slop <= 2e-6 * scale, "{slop} at {scale}");
            }
        }
    }

    #[test]
    fn far_worlds_keep_their_precision() {
        let offset = DVec3::new(134_217_728.0, 0.0, -134_217_728.0);
        let here = [cube(0.5, 0.25), cube(3.0, 0.5)];
        let there = here.map(|b| Aabb { min: b.min + offset, max: b.max + offset });
        let (space, moved) = (Space::around(&here), Space::around(&there));
        for (a, b) in here.iter().zip(&there) {
            assert_eq!(space.store(a), moved.store(b));
        }
    }

    #[test]
    fn odd_boxes_are_set_aside() {
        let space = Space::around(&[cube(0.0, 1.0), Aabb::INFINITE, Aabb::NAN, Aabb::EMPTY]);
        assert_eq!(space, Space { origin: DVec3::ZERO, scale: 0.5 });
        assert_eq!(space.store(&Aabb::NAN), Stored::Beside);
        assert_eq!(space.store(&Aabb::INFINITE), Stored::Beside);
        assert_eq!(space.store(&cube(1e40, 1.0)), Stored::Beside);
        assert_eq!(space.store(&Aabb::EMPTY), Stored::Empty);
        assert_eq!(Space::around(&[]).scale, 1.0);
    }

    #[test]
    fn one_box_far_out_takes_nothing_from_the_others() {
        let mut boxes = vec![cube(1.0, 0.5), cube(2.0, 0.5), cube(3.0, 0.5)];
        let space = Space::around(&boxes);
        boxes.push(Aabb { min: DVec3::splat(-1e9), max: DVec3::ZERO });
        boxes.push(cube(3.0, 0.5));
        assert_eq!(Space::around(&boxes), space);
    }

    #[test]
    fn a_world_in_one_point_is_stored() {
        let boxes = [cube(5.0, 0.0); 3];
        let space = Space::around(&boxes);
        let zero = Box32 { min: [0.0; 3], max: [0.0; 3] };
        assert_eq!(space.store(&boxes[0]), Stored::Bounded(zero));
    }

    #[test]
    fn rounding_is_directed() {
        for x in [0.1, -0.1, 1e-60, -1e-60, 1e60, -1e60, 0.0, f64::INFINITY] {
            assert!(f64::from(down(x)) <= x && x <= f64::from(up(x)), "{x}");
        }
        assert_eq!((down(0.5), up(0.5)), (0.5, 0.5));
    }
}
