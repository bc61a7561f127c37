//! Boxes of skinned meshes.
//!
//! A skinned vertex is a weighted mean of where each of its joints would take it. So it lies among
//! these places, and all vertices lie in the union of one box per joint: that of the
//! vertices it influences, taken where the joint goes. The boxes are made once; a pose costs one
//! transformed box per joint, and no vertex is touched.
//!
//! A mean it is only if the weights of a vertex add up to one, and files round them. The
//! greatest and the least sum are kept, and the union is scaled by them: a sum of 1.001
//! takes a vertex that much away from the origin. Whoever divides by the sum first, as
//! glTF 2.0 recommends and the loader of Cullet does, pays nothing. Weights below zero,
//! which nobody should have, are counted apart: then a vertex leaves the hull of its places.
//!
//! Source: Akenine-Möller et al., "Real-Time Rendering", 2018, section 19.4 has the idea for
//! single joints; the sum of the weights is our own care.

use alloc::vec;
use alloc::vec::Vec;

use glam::{DAffine3, DVec3};

use super::{scaled, sum};
use crate::Aabb;

/// How much one joint moves one vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Influence {
    /// Which vertex, as an index into the positions.
    pub vertex: u32,
    /// Which joint of the skin.
    pub joint: u32,
    /// What share; zero is no influence.
    pub weight: f64,
}

/// What there is to know of a skin and its mesh before any pose.
#[derive(Clone, Debug, PartialEq)]
pub struct SkinBounds {
    /// Per joint, the box of the vertices it influences, in mesh space; empty for none.
    pub joints: Vec<Aabb>,
    /// Per vertex, the weights above zero add up to between these.
    pub weight_sum: (f64, f64),
    /// Per vertex, the weights below zero add up to no less than minus this.
    pub counterweight: f64,
    /// Vertices without any influence, which a skin takes to its zero.
    has_loose: bool,
}

impl SkinBounds {
    /// Boxes the vertices of each of `n_joints` joints.
    ///
    /// Influences of vertices or joints that do not exist, and those with NaN, are passed
    /// over, as are vertices with a NaN, which are never drawn. The order does not matter.
    pub fn new(
        positions: &[DVec3],
        influences: impl IntoIterator<Item = Influence>,
        n_joints: usize,
    ) -> SkinBounds {
        let mut joints = vec![Aabb::EMPTY; n_joints];
        let mut sums = vec![(0.0, 0.0); positions.len()];
        for Influence { vertex, joint, weight } in influences {
            let (Some(&position), Some(sum), Some(bounds)) = (
                positions.get(vertex as usize),
                sums.get_mut(vertex as usize),
                joints.get_mut(joint as usize),
            ) else {
                continue;
            };
            if weight > 0.0 {
                sum.0 += weight;
            } else if weight < 0.0 {
                sum.1 -= weight;
            } else {
                continue;
            }
            *bounds = bounds.union(&Aabb::from_points([position]));
        }
        let mut all = SkinBounds {
            joints,
            weight_sum: (f64::INFINITY, 0.0),
            counterweight: 0.0,
            has_loose: false,
        };
        for (weight, counterweight) in sums {
            if weight == 0.0 && counterweight == 0.0 {
                all.has_loose = true;
                continue;
            }
            all.weight_sum = (all.weight_sum.0.min(weight), all.weight_sum.1.max(weight));
            all.counterweight = all.counterweight.max(counterweight);
        }
        if all.weight_sum.0 > all.weight_sum.1 {
            all.weight_sum = (0.0, 0.0);
        }
        all
    }

    /// A box around all vertices in a pose: `target_from_mesh` is, per joint, what the skin
    /// takes a vertex by (the joint's matrix times its inverse bind matrix).
    ///
    /// Missing matrices count as NaN, and a NaN in the matrix of a joint that moves something
    /// makes the box invalid, so that it is kept. Vertices that no joint moves end up in the
    /// zero of the target, and the box holds it then.
    ///
    /// Covers vertices blended in f64 up to rounding of [`ROUNDING`](crate::ROUNDING); for
    /// those blended in f32 grow it by `16 * 2^-24` of the largest coordinate.
    pub fn posed(&self, target_from_mesh: &[DAffine3]) -> Aabb {
        let mut hull = Aabb::EMPTY;
        for (i, bounds) in self.joints.iter().enumerate().filter(|(_, b)| !b.is_empty()) {
            let matrix = target_from_mesh.get(i).filter(|matrix| !matrix.is_nan());
            let Some(matrix) = matrix else { return Aabb::NAN };
            hull = hull.union(&bounds.transformed(matrix));
        }
        if hull.is_empty() {
            return if self.has_loose { Aabb::from_points([DVec3::ZERO]) } else { hull };
        }
        // Sums near one are one in exact arithmetic or not; their own rounding counts.
        let (least, most) = self.weight_sum;
        let slack = 8.0 * f64::EPSILON;
        let mut all = match self.weight_sum {
            (1.0, 1.0) => hull,
            _ => scaled(&hull, (least * (1.0 - slack), most * (1.0 + slack))),
        };
        if self.counterweight > 0.0 {
            all = sum(&all, &scaled(&hull, (-self.counterweight * (1.0 + slack), 0.0)));
        }
        if self.has_loose { all.union(&Aabb::from_points([DVec3::ZERO])) } else { all }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3};
    use proptest::prelude::*;

    use super::*;

    fn unit_influence(vertex: u32, joint: u32) -> Influence {
        Influence { vertex, joint, weight: 1.0 }
    }

    #[test]
    fn each_joint_has_the_box_of_its_vertices() {
        let positions = [DVec3::ZERO, DVec3::ONE, DVec3::X, DVec3::NAN];
        let influences = [(0, 0), (1, 0), (2, 1), (3, 1), (9, 0), (0, 9)];
        let influences = influences.map(|(vertex, joint)| unit_influence(vertex, joint));
        let skin = SkinBounds::new(&positions, influences, 3);
        assert_eq!(skin.joints[0], Aabb { min: DVec3::ZERO, max: DVec3::ONE });
        assert_eq!(skin.joints[1], Aabb::from_points([DVec3::X]));
        assert!(skin.joints[2].is_empty());
        let moved = DAffine3::from_translation(DVec3::Y);
        let posed = skin.posed(&[DAffine3::IDENTITY, moved]);
        assert!(posed.contains(&Aabb { min: DVec3::ZERO, max: DVec3::ONE }));
        assert!(
            posed.max.abs_diff_eq(DVec3::ONE, 1e-13) && posed.contains_point(DVec3::X + DVec3::Y)
        );
    }

    #[test]
    fn what_is_missing_is_kept_or_left_out() {
        let skin = SkinBounds::new(&[DVec3::ONE], [unit_influence(0, 1)], 2);
        assert!(skin.posed(&[]).is_nan());
        assert!(skin.posed(&[DAffine3::NAN, DAffine3::IDENTITY]).contains_point(DVec3::ONE));
        assert!(skin.posed(&[DAffine3::IDENTITY, DAffine3::NAN]).is_nan());
        assert!(SkinBounds::new(&[], [], 2).posed(&[]).is_empty());
        let loose = SkinBounds::new(&[DVec3::ONE], [], 2);
        assert!(loose.posed(&[]).contains_point(DVec3::ZERO));
    }

    fn pose() -> impl Strategy<Value = DAffine3> {
        (
            prop::array::uniform3(-3.0_f64..3.0),
            prop::array::uniform3(-3.0_f64..3.0),
            prop::array::uniform3(-9.0_f64..9.0),
        )
            .prop_map(|(scale, turn, offset)| {
                let turn = DQuat::from_scaled_axis(turn.into());
                DAffine3::from_scale_rotation_translation(scale.into(), turn, offset.into())
            })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(1000))]

        /// Weights that add up to one, or only nearly, or that fall below zero.
        #[test]
        fn no_vertex_leaves_its_box(
            poses in prop::collection::vec(pose(), 6),
            vertices in prop::collection::vec(
                (
                    prop::array::uniform3(-5.0_f64..5.0),
                    prop::array::uniform4((0..6_u32, 0.0_f64..1.0)),
                ),
                24,
            ),
            care in 0..3,
        ) {
            let positions: Vec<DVec3> = vertices.iter().map(|v| v.0.into()).collect();
            let influences: Vec<Influence> = vertices.iter().enumerate().flat_map(|(i, v)| {
                let sum: f64 = v.1.iter().map(|(_, weight)| weight).sum();
                v.1.map(|(joint, weight)| {
                    let weight = match care {
                        0 => weight / sum,
                        1 => f64::from((weight / sum) as f32),
                        _ => weight - 0.25,
                    };
                    Influence { vertex: i as u32, joint, weight }
                })
            }).collect();
            let skin = SkinBounds::new(&positions, influences.iter().copied(), poses.len());
            let bounds = skin.posed(&poses);
            for (i, &position) in positions.iter().enumerate() {
                let of_vertex = influences.iter().filter(|influence| influence.vertex == i as u32);
                let blended: DVec3 = of_vertex
                    .map(|i| i.weight * poses[i.joint as usize].transform_point3(position))
                    .sum();
                prop_assert!(bounds.contains_point(blended), "{blended} {bounds:?}");
            }
            if care == 0 {
                // And not much larger than the places that joints take their vertices to.
                let places = influences.iter().filter(|i| i.weight != 0.0).map(|i| {
                    skin.joints[i.joint as usize].transformed(&poses[i.joint as usize])
                });
                let all = places.fold(Aabb::EMPTY, |all, place| all.union(&place));
                prop_assert!(all.grown(1e-9).contains(&bounds));
            }
        }
    }
}
