//! A list of boxes in half the memory, asked first.
//!
//! One core of many a machine reads memory more slowly than it tests boxes, so that a box costs what
//! its bytes cost. Here each bound is a whole number of 16 bits on a grid over all boxes, rounded
//! outwards: 12 bytes a box. A plane then knows a distance only up to the steps of the grid, and
//! says of a box that it is outside, or certainly not, or neither; the few in doubt
//! are looked up among the bounds as they are. So the answer is that of [`Boxes8`], bit by bit,
//! which is the plain twin of this.
//!
//! # The doubt
//!
//! Let `R` be the exact distance, to a plane of [`Boxes8`], of the corner that its f32 arithmetic
//! gives `F` for: `|F - R| <= E2`, with `E2` 8u of the terms (u is 2^-24). The same corner on the
//! grid is at `G`, `R <= G <= R + W`, where `W` is the sum of the steps of the three axes, each times
//! the plane's coefficient. What is computed is `C`, which is `(G + E) / (W + 2 E)` up to
//! `E1 / (W + 2 E)`, `E1` being 16u of its terms, and `E` is `E1 + E2` and what f64 loses in making
//! the grid, for which a thousandth of `W` is plenty. So
//!
//! - `C < 0` means `G < -E2`, thus `F < 0`: outside;
//! - `C >= 1` means `G >= W + E2`, thus `F >= 0`: not outside;
//! - and all planes can share one least `C`.
//!
//! Source: for bounds in few bits, Mahovsky, "Ray Tracing with Reduced-Precision Bounding Volume
//! Hierarchies", 2005.

use alloc::vec::Vec;

use fearless_simd::{Simd, dispatch, f32x8, i16x16, prelude::*};

use super::planes8::Plane32;
use super::{Box32, Boxes8, Group, Level, Planes8};
use crate::Frustum;

/// [`Boxes8`] with an index of 12 bytes a box before it, 36 bytes a box in all.
///
/// For long lists: a million boxes that come from memory take 1.3 to 1.8 times less than in
/// [`Boxes8`], 100 000 in a large cache about as much, a thousand up to twice as much (bench
/// `cull`).
///
/// Groups of eight with a box that the grid does not hold are always asked as they are: empty ones,
/// NaN, infinite ones, and those far out, beyond four times what half of the boxes keep to.
#[derive(Clone, Debug)]
pub struct Coarse8 {
    boxes: Boxes8,
    grid: Grid,
    groups: Vec<Group16>,
    /// The groups that are always asked as they are.
    exact: Vec<u32>,
}

impl Coarse8 {
    /// The index of `boxes`.
    pub fn new(boxes: Boxes8) -> Coarse8 {
        let grid = Grid::over(&boxes.bounds);
        let mut groups = alloc::vec![Group16::ZERO; boxes.groups.len()];
        let mut exact = Vec::new();
        for (index, (group, coarse)) in boxes.groups.iter().zip(&mut groups).enumerate() {
            let fits = (0..8).all(|lane| match grid.store(&group.get(lane)) {
                Some(stored) => {
                    coarse.set(lane, stored);
                    true
                }
                None => false,
            });
            if !fits {
                exact.push(index as u32);
            }
        }
        Coarse8 { boxes, grid, groups, exact }
    }

    /// The boxes themselves.
    pub fn boxes(&self) -> &Boxes8 {
        &self.boxes
    }

    /// [`Boxes8::visible_into`], with the same answer.
    ///
    /// # Panics
    /// If `out` has not [`Boxes8::n_groups`] bytes.
    pub fn visible_into(&self, frustum: &Frustum, level: Level, out: &mut [u8]) {
        assert_eq!(out.len(), self.boxes.n_groups(), "one byte per group of eight boxes");
        let exact = self.boxes.planes(frustum);
        let coarse = exact.planes.each_ref().map(|plane| self.grid.plane(plane));
        dispatch!(level, simd => self.ask(simd, &coarse, &exact, out));
        self.boxes.ask_beside(frustum, out);
    }

    #[inline(always)]
    fn ask<S: Simd>(&self, simd: S, coarse: &[Plane16; 6], exact: &Planes8, out: &mut [u8]) {
        const N: usize = 4;
        let (fours, rest) = self.groups.as_chunks::<N>();
        let (exact_fours, exact_rest) = self.boxes.groups.as_chunks::<N>();
        let (out_fours, out_rest) = out.as_chunks_mut::<N>();
        for ((four, groups), out) in fours.iter().zip(exact_fours).zip(out_fours) {
            let may_be = visible(simd, coarse, four);
            for i in 0..N {
                out[i] = settled(simd, may_be[i], exact, &groups[i]);
            }
        }
        for ((one, group), out) in rest.iter().zip(exact_rest).zip(out_rest) {
            let [may_be] = visible(simd, coarse, core::array::from_ref(one));
            *out = settled(simd, may_be, exact, group);
        }
        for &index in &self.exact {
            let group = &self.boxes.groups[index as usize];
            [out[index as usize]] = exact.visible(simd, core::array::from_ref(group));
        }
    }
}

/// One bit per visible box: as the grid says, unless it leaves one in doubt.
#[inline(always)]
fn settled<S: Simd>(simd: S, may_be: MayBe, exact: &Planes8, group: &Group) -> u8 {
    if may_be.not_outside == may_be.visible {
        return may_be.visible;
    }
    let [visible] = exact.visible(simd, core::array::from_ref(group));
    visible
}

/// What the grid says of eight boxes, one bit each.
#[derive(Clone, Copy, Default)]
struct MayBe {
    not_outside: u8,
    visible: u8,
}

#[inline(always)]
fn visible<S: Simd, const N: usize>(
    simd: S,
    planes: &[Plane16; 6],
    groups: &[Group16; N],
) -> [MayBe; N] {
    let zero = f32x8::splat(simd, 0.0);
    let mut ends = [[[zero; 2]; 3]; N];
    for i in 0..N {
        for (row, ends) in groups[i].rows.iter().zip(&mut ends[i]) {
            let (min, max) = simd.widen_i16x16(i16x16::simd_from(simd, *row));
            *ends = [min.to_float(), max.to_float()];
        }
    }
    let [first, others @ ..] = planes;
    let mut least = [zero; N];
    for i in 0..N {
        least[i] = distance(first, &ends[i]);
    }
    for plane in others {
        for i in 0..N {
            least[i] = least[i].min(distance(plane, &ends[i]));
        }
    }
    let mut may_be = [MayBe::default(); N];
    for i in 0..N {
        may_be[i].not_outside = least[i].simd_ge(zero).to_bitmask() as u8;
        may_be[i].visible = least[i].simd_ge(f32x8::splat(simd, 1.0)).to_bitmask() as u8;
    }
    may_be
}

#[inline(always)]
fn distance<S: Simd>(plane: &Plane16, ends: &[[f32x8<S>; 2]; 3]) -> f32x8<S> {
    let [x, y, z] = plane.far;
    let x = ends[0][x & 1] * plane.normal[0];
    let y = ends[1][y & 1] * plane.normal[1];
    let z = ends[2][z & 1] * plane.normal[2];
    (x + y) + (z + plane.offset)
}

/// Eight boxes on the grid; per axis eight lesser bounds, then eight greater ones.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
struct Group16 {
    rows: [[i16; 16]; 3],
}

impl Group16 {
    const ZERO: Group16 = Group16 { rows: [[0; 16]; 3] };

    fn set(&mut self, lane: usize, bounds: [[i16; 2]; 3]) {
        for (row, [min, max]) in self.rows.iter_mut().zip(bounds) {
            (row[lane], row[lane + 8]) = (min, max);
        }
    }
}

/// A plane in steps of the grid, scaled so that what it leaves in doubt lies in [0, 1).
#[derive(Clone, Copy, Debug)]
struct Plane16 {
    normal: [f32; 3],
    /// By axis, which end is the farthest along the normal: 0 the lesser, 1 the greater.
    far: [usize; 3],
    offset: f32,
}

/// Stored coordinates are `middle + n * step`, for whole `n`.
#[derive(Clone, Copy, Debug)]
struct Grid {
    middle: [f64; 3],
    step: [f64; 3],
    /// The part of space it is over.
    min: [f32; 3],
    max: [f32; 3],
}

impl Grid {
    /// No whole number is larger.
    const MOST: f64 = 32766.0;

    /// Coordinates beyond are left to the boxes as they are: half of all boxes keep to 1.
    const FAR_OUT: f32 = 4.0;

    fn over(bounds: &Box32) -> Grid {
        let min = bounds.min.map(|x| x.clamp(-Grid::FAR_OUT, Grid::FAR_OUT));
        let max = bounds.max.map(|x| x.clamp(-Grid::FAR_OUT, Grid::FAR_OUT));
        let middle: [f64; 3] =
            core::array::from_fn(|i| 0.5 * (f64::from(min[i]) + f64::from(max[i])));
        let step = core::array::from_fn(|i| {
            let half = 0.5 * (f64::from(max[i]) - f64::from(min[i]));
            // Wide enough that f64 does not lose a thousandth of it.
            (half / Grid::MOST).max(1e-12 * middle[i].abs()).max(1e-30)
        });
        Grid { middle, step, min, max }
    }

    /// The whole numbers at the bounds or next to them outwards; `None` for a box that is absent or
    /// far out.
    fn store(&self, bounds: &Box32) -> Option<[[i16; 2]; 3]> {
        let fits = |i: usize| bounds.min[i] >= self.min[i] && bounds.max[i] <= self.max[i];
        if !(0..3).all(fits) {
            return None;
        }
        Some(core::array::from_fn(|i| {
            let steps = |x: f32| (f64::from(x) - self.middle[i]) / self.step[i];
            // Both fit, with room to spare for rounding.
            [libm::floor(steps(bounds.min[i])) as i16, libm::ceil(steps(bounds.max[i])) as i16]
        }))
    }

    /// `plane` on the grid; see the module above.
    fn plane(&self, plane: &Plane32) -> Plane16 {
        const U: f64 = 1.0 / (1 << 24) as f64;
        const TINY: f64 = f32::MIN_POSITIVE as f64;
        let far = plane.normal.map(|n| usize::from(n >= 0.0));
        let outer = f64::from(plane.outer);
        if outer.is_infinite() {
            // The plane is farther away than f32 reaches: all of the grid is on one side.
            return Plane16 { normal: [0.0; 3], far, offset: 2.0 * outer.signum() as f32 };
        }
        let normal = plane.normal.map(f64::from);
        let sum = |of: &dyn Fn(usize) -> f64| (0..3).map(of).sum::<f64>();
        let reach = |i: usize| f64::from(self.min[i].abs().max(self.max[i].abs()));
        let offset = outer + sum(&|i| normal[i] * self.middle[i]);
        let steps = sum(&|i| normal[i].abs() * self.step[i]);
        let computed = 16.0 * U * (32768.0 * steps + offset.abs());
        let plain = 8.0 * U * (sum(&|i| normal[i].abs() * reach(i)) + outer.abs()) + TINY;
        let error = computed + 1.001 * plain + 0.002 * steps;
        let scale = 1.0 / (1.001 * steps + 2.0 * error);
        Plane16 {
            normal: core::array::from_fn(|i| (normal[i] * self.step[i] * scale) as f32),
            far,
            offset: ((offset + error) * scale) as f32,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grid_rounds_outwards_and_by_less_than_a_step() {
        let bounds = Box32 { min: [-3.0, 0.25, 2.0], max: [1.0, 0.75, 2.0] };
        let grid = Grid::over(&bounds);
        for t in 0..100 {
            let at = |i: usize, t: f32| bounds.min[i] + t * (bounds.max[i] - bounds.min[i]);
            let (low, high) = (t as f32 / 101.0, (t + 1) as f32 / 100.0);
            let inner = Box32 {
                min: core::array::from_fn(|i| at(i, low)),
                max: core::array::from_fn(|i| at(i, high).min(bounds.max[i])),
            };
            let stored = grid.store(&inner).expect("it fits");
            for (i, [min, max]) in stored.into_iter().enumerate() {
                let back = |n: i16| grid.middle[i] + f64::from(n) * grid.step[i];
                let (below, above) =
                    (f64::from(inner.min[i]) - back(min), back(max) - f64::from(inner.max[i]));
                let slop = 1e-3 * grid.step[i];
                assert!((-slop..grid.step[i] + slop).contains(&below), "{below}");
                assert!((-slop..grid.step[i] + slop).contains(&above), "{above}");
            }
        }
        assert_eq!(grid.store(&Box32 { max: [1.1, 0.5, 2.0], ..bounds }), None);
        assert_eq!(grid.store(&Group::ABSENT.get(0)), None);
    }

    #[test]
    fn few_are_in_doubt() {
        // A plane through the middle of a million places: those within a step or two.
        let bounds = Box32 { min: [-1.0; 3], max: [1.0; 3] };
        let grid = Grid::over(&bounds);
        let plane = Plane32::through([0.6, 0.0, 0.8], 0.0);
        let coarse = grid.plane(&plane);
        let doubtful = |x: f64| {
            let n = (x / grid.step[0]) as f32;
            let c = n * coarse.normal[0] + coarse.offset;
            (0.0..1.0).contains(&c)
        };
        let n = (0..100_000).filter(|i| doubtful(f64::from(*i) / 5e4 - 1.0)).count();
        // Along x a doubt of two steps and a third, each as wide as three places in two.
        assert!((3..=5).contains(&n), "{n}");
    }
}
