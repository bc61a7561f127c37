//! Eight boxes and their numbers in two lines of memory, asked before the boxes as they are.
//!
//! A walk through a large tree waits for memory, so what it asks most should take few lines of it.
//! Here a bound is a whole number of 16 bits on a grid over the box around the eight, rounded
//! outwards: 12 bytes a box and 4 for its number. A plane then knows a distance only up to the steps
//! of the grid, and says of a box that it is outside, or certainly not, or neither; the few in doubt
//! are looked up among the bounds as they are ([`Planes8::ask`], the plain twin of this). So the
//! answer is the same, bit by bit.
//!
//! # The doubt
//!
//! Write u for 2^-24. Let `V` be the sum of the three steps, each times the plane's coefficient, and `S`
//! the sum of the plane's offset, of the grid's middle along each axis times the coefficient (all of
//! them without sign), and of `32002 V`, which is more than the box is large. `R` is the exact
//! distance of a corner, and `F` what the f32 arithmetic of [`Planes8`] gives for it, with three roundings
//! of a term at most: `|F - R| <= 3.01u S`. The same corner on the grid is at `G`. Whole numbers are
//! found in f32 and looked for a little outwards ([`SLOP`]), so with `W` a thirty-second more than `V`,
//! `R <= G <= R + W` for the farthest corner and `R - W <= G <= R` for the nearest. What is computed is
//! `C`, with seven roundings of a term at most: `|C - G| <= 7.01u S`. With `E = 16u S`, which is more
//! than both together and its own roundings,
//!
//! - `C < -E` means `F < 0` for the farthest corner, and `C > W + E` that `F >= 0`;
//! - `C > E` means `F >= 0` for the nearest corner, and `C < -(W + E)` that `F < 0`.
//!
//! Half of `W` is added to the offsets beforehand, so that both ask whether a distance is larger than
//! `W / 2 + E`, on either side of 0.
//!
//! Stored coordinates end at 2^100, so only the offset can make anything infinite: then `E` is, and
//! nothing is settled, or `C` and `F` are, with one sign. What underflows is far less than the least
//! normal number, which `E` has in it.
//!
//! Source: for bounds relative to the box around them, Mahovsky, "Ray Tracing with
//! Reduced-Precision Bounding Volume Hierarchies", 2005.

use fearless_simd::{Simd, f32x8, i16x16, prelude::*};

use super::planes8::Plane32;
use super::{Group, Planes8, Row};

/// Steps from one end of a box to the other. Its middle is one of its ends when it is an ulp wide, so
/// whole numbers reach this far, and one more by rounding outwards.
const STEPS: f32 = 32_000.0;

/// No step is shorter, so that none is 0; far below what f32 tells apart at 1.
const SHORTEST: f32 = 1e-30;

/// `W` in terms of `V`: room for [`SLOP`] on both sides of a step, and for its own roundings.
const WIDER: f32 = 1.04;

/// 16u.
const E: f32 = 16.0 / (1 << 24) as f32;

/// In steps: more than four roundings make of [`STEPS`].
const SLOP: f32 = 1.0 / 64.0;

/// Eight boxes on a grid over the box around them, and the items they belong to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C, align(128))]
pub(crate) struct Leaf16 {
    /// Per axis eight lesser bounds, then eight greater ones.
    rows: [[i16; 16]; 3],
    pub ids: [u32; 8],
}

impl Leaf16 {
    /// Of no items.
    pub const EMPTY: Leaf16 = Leaf16 { rows: [[0; 16]; 3], ids: [0; 8] };

    /// The boxes of `group`, those that are there. Absent ones are points in the middle, so what is
    /// said of them has no meaning: count the items.
    pub fn new(group: &Group, ids: &[u32; 8]) -> Leaf16 {
        let bounds = group.union();
        let grid = Grid::over(bounds.min, bounds.max);
        let mut leaf = Leaf16 { ids: *ids, ..Leaf16::EMPTY };
        for (axis, row) in leaf.rows.iter_mut().enumerate() {
            let (middle, per_unit) = (grid.middle[axis], 1.0 / grid.step[axis]);
            let (min, max) = (group.row(Row::MIN[axis]), group.row(Row::MAX[axis]));
            for lane in 0..8 {
                row[lane] = floor((min[lane] - middle) * per_unit - SLOP);
                row[lane + 8] = -floor((middle - max[lane]) * per_unit - SLOP);
            }
        }
        leaf
    }

    /// All bounds, in steps from the middle: by axis the lesser and the greater ones.
    #[expect(clippy::needless_range_loop, reason = "iterators beside vectors may become calls")]
    #[inline(always)]
    pub fn ends<S: Simd>(&self, simd: S) -> [[f32x8<S>; 2]; 3] {
        let mut ends = [[f32x8::splat(simd, 0.0); 2]; 3];
        for axis in 0..3 {
            let (min, max) = simd.widen_i16x16(i16x16::simd_from(simd, self.rows[axis]));
            ends[axis] = [min.to_float(), max.to_float()];
        }
        ends
    }

    /// A word of each of its two lines of memory.
    #[inline(always)]
    pub fn touch(&self) -> u32 {
        self.rows[0][0] as u32 ^ self.ids[0]
    }
}

/// The greatest whole number that is not above `x`, which is no larger than 16 bits; 0 for NaN.
#[inline(always)]
fn floor(x: f32) -> i16 {
    let whole = x as i32;
    (whole - i32::from(whole as f32 > x)) as i16
}

/// Coordinates are `middle + n * step`, for whole `n`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grid {
    middle: [f32; 3],
    step: [f32; 3],
}

/// What a plane says of eight boxes, one bit each, where it is settled.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Said {
    /// Not excluded.
    pub reached: u8,
    /// Certainly not cut.
    pub inside: u8,
    /// Whether either is in doubt for any of those wanted.
    pub in_doubt: bool,
}

impl Grid {
    #[inline(always)]
    fn over(min: [f32; 3], max: [f32; 3]) -> Grid {
        let mut grid = Grid { middle: [0.0; 3], step: [0.0; 3] };
        for axis in 0..3 {
            grid.middle[axis] = 0.5 * (min[axis] + max[axis]);
            grid.step[axis] = (max[axis] - min[axis]) * (1.0 / STEPS) + SHORTEST;
        }
        grid
    }

    /// The grid over the box in `lane` of `group`: that of a leaf, if the box is the union of its boxes.
    #[inline(always)]
    pub fn in_lane(group: &Group, lane: usize) -> Grid {
        let (mut min, mut max) = ([0.0; 3], [0.0; 3]);
        for axis in 0..3 {
            min[axis] = group.row(Row::MIN[axis])[lane];
            max[axis] = group.row(Row::MAX[axis])[lane];
        }
        Grid::over(min, max)
    }

    /// What a plane says of the boxes on this grid that are `wanted`, one bit each; `error` is of
    /// [`errors`].
    #[inline(always)]
    pub fn ask<S: Simd>(
        &self,
        simd: S,
        plane: &Plane32,
        error: f32,
        ends: &[[f32x8<S>; 2]; 3],
        wanted: u8,
    ) -> Said {
        let (mut normal, mut middle) = ([0.0; 3], [0.0; 3]);
        let mut far = [f32x8::splat(simd, 0.0); 3];
        let mut near = far;
        for axis in 0..3 {
            normal[axis] = plane.normal[axis] * self.step[axis];
            middle[axis] = plane.normal[axis] * self.middle[axis];
            let [min, max] = [ends[axis][0] * normal[axis], ends[axis][1] * normal[axis]];
            far[axis] = min.max(max);
            near[axis] = min.min(max);
        }
        let steps = normal[0].abs() + normal[1].abs() + normal[2].abs();
        let away = middle[0].abs() + middle[1].abs() + middle[2].abs();
        let middle = middle[0] + middle[1] + middle[2];
        let half = (0.5 * WIDER) * steps;
        let far = far[0] + far[1] + (far[2] + (middle + plane.outer - half));
        let near = near[0] + near[1] + (near[2] + (middle + plane.inner + half));
        // Past half of W and E, on either side; never with NaN.
        let enough = error + E * away + (0.5 * WIDER + E * 32_002.0) * steps;
        let (zero, enough) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, enough));
        let settled = far.abs().simd_gt(enough) & near.abs().simd_gt(enough);
        Said {
            reached: far.simd_ge(zero).to_bitmask() as u8,
            inside: near.simd_ge(zero).to_bitmask() as u8,
            in_doubt: !settled.to_bitmask() as u8 & wanted != 0,
        }
    }
}

/// The part of `E` that each plane has of its own; see the module above.
#[inline]
pub(crate) fn errors(planes: &Planes8) -> [f32; 6] {
    let mut errors = [0.0; 6];
    for (error, plane) in errors.iter_mut().zip(&planes.planes) {
        *error = E * plane.outer.abs().max(plane.inner.abs()) + f32::MIN_POSITIVE;
    }
    errors
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;
    use glam::DVec3;

    use super::*;
    use crate::distributions::Rng;
    use crate::wide::planes8::corners;
    use crate::wide::{Box32, Level, levels};

    fn unit(random: &mut Rng) -> f64 {
        random.within(0.0, 1.0)
    }

    fn over(group: &Group) -> Grid {
        let bounds = group.union();
        Grid::over(bounds.min, bounds.max)
    }

    /// Eight boxes `size` wide at most, within as much of `at`.
    fn boxes(random: &mut Rng, at: [f32; 3], size: f32) -> Group {
        let mut group = Group::ABSENT;
        for lane in 0..8 {
            let mut min = [0.0; 3];
            let mut max = [0.0; 3];
            for axis in 0..3 {
                min[axis] = at[axis] + size * unit(random) as f32;
                max[axis] = min[axis] + size * unit(random) as f32;
            }
            group.set(lane, &Box32 { min, max });
        }
        group
    }

    #[test]
    fn the_grid_rounds_outwards_and_by_little_more_than_a_step() {
        let mut random = Rng(7);
        for size in [0.0, 1e-38, 1e-30, 1e-7, 1e-3, 1.0, 1e5, 1e30] {
            for at in [0.0, 1e-20, -1.0, 1000.0, -1e30] {
                let group = boxes(&mut random, [at, -at, 0.5 * at], size);
                let (leaf, grid) = (Leaf16::new(&group, &[0; 8]), over(&group));
                for axis in 0..3 {
                    let step = f64::from(grid.step[axis]);
                    let back = |n: i16| f64::from(grid.middle[axis]) + f64::from(n) * step;
                    for lane in 0..8 {
                        let (min, max) = (group.get(lane).min[axis], group.get(lane).max[axis]);
                        let below = f64::from(min) - back(leaf.rows[axis][lane]);
                        let above = back(leaf.rows[axis][lane + 8]) - f64::from(max);
                        // f64 cannot say more of large numbers.
                        let slop = 1e-9 * step + 1e-15 * f64::from(min.abs().max(max.abs()));
                        let most = step * (1.0 + 2.0 * f64::from(SLOP)) + slop;
                        assert!((-slop..most).contains(&below), "{size} {at}: {below}");
                        assert!((-slop..most).contains(&above), "{size} {at}: {above}");
                    }
                }
            }
        }
    }

    /// How many of the groups are in doubt; the others are found to agree with the plain twin.
    fn in_doubt(level: Level, plane: Plane32, groups: &[Group]) -> usize {
        let planes = Planes8 { planes: [plane; 6], asked: crate::PlaneMask::from_bits(1) };
        let [error, ..] = errors(&planes);
        let mut n_in_doubt = 0;
        for group in groups {
            let mut there = 0;
            for lane in 0..8 {
                there |= u8::from(group.get(lane).min[0] <= group.get(lane).max[0]) << lane;
            }
            let (leaf, grid) = (Leaf16::new(group, &[0; 8]), over(group));
            let (said, twin) = dispatch!(level, simd => {
                (grid.ask(simd, &plane, error, &leaf.ends(simd), there), planes.ask(simd, 0, group))
            });
            n_in_doubt += usize::from(said.in_doubt);
            let agree = (said.reached ^ twin.0) & there == 0 && (said.inside ^ twin.1) & there == 0;
            assert!(said.in_doubt || agree, "{plane:?} {group:?}");
        }
        n_in_doubt
    }

    /// A direction, along an axis or in a plane of two as often as not.
    fn direction(random: &mut Rng) -> [f32; 3] {
        let mut normal = random.point(DVec3::NEG_ONE, DVec3::ONE);
        match (6.0 * unit(random)) as usize {
            axis @ 0..3 => normal[axis] = 0.0,
            axis @ 3..5 => normal = DVec3::AXES[axis - 3] * normal,
            _ => {}
        }
        normal.normalize().as_vec3().to_array()
    }

    #[test]
    fn what_is_settled_is_what_the_plain_twin_says() {
        let mut random = Rng(8);
        let (mut n, mut n_in_doubt) = (0, 0);
        for (size, reach) in
            [(1e-6, 1.0), (1e-3, 1.0), (0.1, 1.0), (3.0, 1e3), (1e-30, 1e-29), (1e28, 1e29)]
        {
            let mut groups = Vec::new();
            for _ in 0..300 {
                let at = (random.point(DVec3::NEG_ONE, DVec3::ONE) * reach).as_vec3().to_array();
                groups.push(boxes(&mut random, at, size));
            }
            for _ in 0..80 {
                let normal = direction(&mut random);
                // Past the farthest or nearest corner of some box, by a step or two, as often as not.
                let near_by = groups[(unit(&mut random) * 300.0) as usize].get(3);
                let (far, near) = corners(normal);
                let rows = if unit(&mut random) < 0.5 { far } else { near };
                let corner = rows.map(|row| near_by.at(row));
                let past = size * (unit(&mut random) as f32 - 0.5) / 10_000.0;
                let offset = past - (0..3).map(|i| corner[i] * normal[i]).sum::<f32>();
                let anywhere = reach as f32 * (unit(&mut random) as f32 - 0.5);
                let offset = if unit(&mut random) < 0.5 { offset } else { anywhere };
                for (_, level) in levels() {
                    n_in_doubt += in_doubt(level, Plane32::through(normal, offset), &groups);
                    n += groups.len();
                }
            }
        }
        assert!((n / 1000..n / 20).contains(&n_in_doubt), "{n_in_doubt} of {n}");
    }

    /// Boxes whose bounds lie next to a whole number, so that the grid is a whole step away; planes that
    /// miss them, or cut them, by next to nothing.
    #[test]
    fn a_step_away_is_not_far_enough() {
        let mut random = Rng(10);
        let level = Level::new();
        let (mut n, mut n_in_doubt) = (0, 0);
        for _ in 0..20_000 {
            let all = Box32 { min: [-1.0, 3.0, -0.5], max: [1.0, 5.0, 1.5] };
            let grid = Grid::over(all.min, all.max);
            let next_to_a_step = |random: &mut Rng, axis: usize, low: f64, high: f64| {
                let n = random.within(low, high).floor() + random.within(-0.03, 0.03);
                (f64::from(grid.middle[axis]) + n * f64::from(grid.step[axis])) as f32
            };
            let mut small = all;
            for axis in 0..3 {
                small.min[axis] = next_to_a_step(&mut random, axis, -15_990.0, -10.0);
                small.max[axis] = next_to_a_step(&mut random, axis, 10.0, 15_990.0);
            }
            let mut group = Group::ABSENT;
            group.set(0, &all);
            group.set(5, &small);
            let normal = direction(&mut random);
            let (far, near) = corners(normal);
            let rows = if unit(&mut random) < 0.5 { far } else { near };
            let steps: f32 = (0..3).map(|i| normal[i].abs() * grid.step[i]).sum();
            let past = steps * random.within(-0.02, 0.02) as f32;
            let distance: f32 = (0..3).map(|i| small.at(rows[i]) * normal[i]).sum();
            n_in_doubt += in_doubt(level, Plane32::through(normal, past - distance), &[group]);
            n += 1;
        }
        assert!(n_in_doubt > n / 2, "{n_in_doubt} of {n}");
    }

    #[test]
    fn planes_that_f32_does_not_hold() {
        let mut random = Rng(9);
        let groups = [boxes(&mut random, [0.0; 3], 1.0)];
        let in_doubt = |plane| in_doubt(Level::new(), plane, &groups);
        assert_eq!(in_doubt(Plane32::UNKNOWN), 1);
        assert_eq!(in_doubt(Plane32::through([f32::NAN, 0.0, 0.0], 0.0)), 1);
        assert_eq!(in_doubt(Plane32::through([1.0, 0.0, 0.0], f32::INFINITY)), 1);
        assert_eq!(in_doubt(Plane32::through([1.0, 0.0, 0.0], f32::MAX)), 0);
    }

    #[test]
    fn how_far_other_boxes_reach_makes_no_doubt() {
        // 1000 leaves, each asked by a plane that is two thousandths of its size away.
        let mut random = Rng(11);
        let groups: Vec<Group> = (0..1000).map(|_| boxes(&mut random, [0.2; 3], 0.01)).collect();
        let n_in_doubt: usize = groups
            .iter()
            .map(|group| {
                let plane = Plane32::through([0.0, 1.0, 0.0], -(group.union().max[1] + 2e-5));
                in_doubt(Level::new(), plane, core::slice::from_ref(group))
            })
            .sum();
        assert_eq!(n_in_doubt, 0);
    }
}
