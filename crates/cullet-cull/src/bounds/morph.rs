//! Boxes of morphed meshes.
//!
//! A morphed vertex is its base position plus weighted offsets, one per target. With each weight
//! known to within a range, interval arithmetic gives a box around every position the vertex
//! can take (Moore 1966).
//!
//! [`morphed_bounds`] does this per vertex and is tight: every face is reached by some choice
//! of weights. [`MorphBounds`] keeps one box per target instead and costs a handful of
//! operations per pose; it is larger, since it lets one vertex have the base of another.

use alloc::vec::Vec;

use glam::DVec3;

use super::{scaled, sum};
use crate::Aabb;

/// A box around all vertices for all weights within `weights`, the least and the greatest per
/// target.
///
/// Targets shorter than `base` move the rest by nothing; targets without weights, and weights
/// without targets, count for nothing. Vertices with a NaN are passed over; a NaN in a
/// range makes the box invalid.
pub fn morphed_bounds(base: &[DVec3], targets: &[&[DVec3]], weights: &[(f64, f64)]) -> Aabb {
    if weights.iter().any(|(least, most)| least.is_nan() || most.is_nan()) {
        return Aabb::NAN;
    }
    let vertex = |(i, &position): (usize, &DVec3)| {
        let point = |p: DVec3| Aabb { min: p, max: p };
        let offsets = targets.iter().map(|target| target.get(i).copied().unwrap_or_default());
        offsets
            .zip(weights)
            .fold(point(position), |all, (offset, &range)| moved(&all, &point(offset), range))
    };
    let vertices = base.iter().enumerate().map(vertex);
    vertices.filter(|bounds| !bounds.is_nan()).fold(Aabb::EMPTY, |all, one| all.union(&one))
}

/// The boxes of a mesh and of the offsets of its targets.
#[derive(Clone, Debug, PartialEq)]
pub struct MorphBounds {
    /// Around the unmorphed vertices.
    pub base: Aabb,
    /// Per target, around its offsets.
    pub offsets: Vec<Aabb>,
}

impl MorphBounds {
    /// Boxes each target once. Points with a NaN are passed over; a target shorter than
    /// `base` moves the rest by nothing.
    pub fn new(base: &[DVec3], targets: &[&[DVec3]]) -> MorphBounds {
        let offsets = targets.iter().map(|target| {
            let rest = (target.len() < base.len()).then_some(DVec3::ZERO);
            Aabb::from_points(target.iter().take(base.len()).copied().chain(rest))
        });
        MorphBounds { base: Aabb::from_points(base.iter().copied()), offsets: offsets.collect() }
    }

    /// A box around all vertices for all weights within `weights`; as [`morphed_bounds`].
    pub fn posed(&self, weights: &[(f64, f64)]) -> Aabb {
        if self.base.is_empty() {
            return self.base;
        }
        if weights.iter().any(|(least, most)| least.is_nan() || most.is_nan()) {
            return Aabb::NAN;
        }
        let moving = self.offsets.iter().zip(weights).filter(|(offset, _)| !offset.is_empty());
        moving.fold(self.base, |all, (offset, &range)| moved(&all, offset, range))
    }
}

fn moved(bounds: &Aabb, offset: &Aabb, range: (f64, f64)) -> Aabb {
    let still = range == (0.0, 0.0) || *offset == Aabb { min: DVec3::ZERO, max: DVec3::ZERO };
    if still { *bounds } else { sum(bounds, &scaled(offset, range)) }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_range_of_weights_sweeps_its_offsets() {
        let (base, target) = ([DVec3::ZERO, DVec3::X], [DVec3::Y, -DVec3::Z]);
        let bounds = morphed_bounds(&base, &[&target], &[(0.0, 2.0)]);
        let expected = Aabb { min: DVec3::new(0.0, 0.0, -2.0), max: DVec3::new(1.0, 2.0, 0.0) };
        assert!(bounds.contains(&expected) && expected.grown(1e-12).contains(&bounds));
        assert_eq!(morphed_bounds(&base, &[&target], &[(0.0, 0.0)]), Aabb::from_points(base));
        assert_eq!(morphed_bounds(&base, &[], &[(0.0, 1.0)]), Aabb::from_points(base));
        assert!(morphed_bounds(&base, &[&target], &[(f64::NAN, 1.0)]).is_nan());
        assert!(morphed_bounds(&[], &[&target], &[(0.0, 1.0)]).is_empty());
        assert!(MorphBounds::new(&[], &[&target]).posed(&[(0.0, 1.0)]).is_empty());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(1000))]

        #[test]
        fn no_vertex_leaves_its_box(
            base in prop::collection::vec(prop::array::uniform3(-5.0_f64..5.0), 1..20),
            targets in prop::collection::vec(
                (prop::collection::vec(prop::array::uniform3(-1.0_f64..1.0), 0..20),
                 prop::array::uniform3(-2.0_f64..2.0)),
                0..5,
            ),
        ) {
            let points = |v: &[[f64; 3]]| v.iter().map(|&p| p.into()).collect::<Vec<DVec3>>();
            let base = points(&base);
            let offsets: Vec<Vec<DVec3>> = targets.iter().map(|t| points(&t.0)).collect();
            let offsets: Vec<&[DVec3]> = offsets.iter().map(Vec::as_slice).collect();
            let (weights, ranges): (Vec<f64>, Vec<(f64, f64)>) = targets.iter().map(|(_, three)| {
                let mut three = *three;
                three.sort_by(f64::total_cmp);
                (three[1], (three[0], three[2]))
            }).unzip();
            let tight = morphed_bounds(&base, &offsets, &ranges);
            let quick = MorphBounds::new(&base, &offsets).posed(&ranges);
            prop_assert!(quick.grown(1e-12).contains(&tight));
            for (i, &position) in base.iter().enumerate() {
                let morphed = offsets.iter().zip(&weights).fold(position, |p, (target, weight)| {
                    p + *weight * target.get(i).copied().unwrap_or_default()
                });
                prop_assert!(tight.contains_point(morphed) && quick.contains_point(morphed));
            }
        }
    }
}
