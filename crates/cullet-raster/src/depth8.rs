//! Planes of depth of eight triangles side by side: those of [`crate::cover`], to the last bit.

use fearless_simd::{Simd, SimdCvtFloat, f32x8, f64x4, i32x8, prelude::*};

use crate::fill::TileDepth;

/// Planes of depth of four triangles, as [`TileDepth`](crate::fill::TileDepth).
#[derive(Clone, Copy)]
pub(crate) struct Depth4<S: Simd> {
    depth: f64x4<S>,
    pub origin: [f64x4<S>; 2],
    pub ddx: f64x4<S>,
    pub ddy: f64x4<S>,
}

impl<S: Simd> Depth4<S> {
    /// What reversed depth, before clamping, has from the row alone, at points of the picture, pixels; centres have
    /// whole numbers here.
    #[inline(always)]
    pub fn row(&self, y: f64x4<S>) -> f64x4<S> {
        self.depth + self.ddy * (y - self.origin[1])
    }

    /// Reversed depth in a row.
    #[inline(always)]
    pub fn in_row(&self, row: f64x4<S>, x: f64x4<S>) -> f64x4<S> {
        row + self.ddx * (x - self.origin[0])
    }
}

/// What planes of depth are made of: eight triangles whose edges are shorter than 2^14 units.
pub(crate) struct Corners8<'c, S: Simd> {
    /// Twice the area, square units.
    pub area: i32x8<S>,
    /// The first corner, units: below 2^24, and so exact in f32, for the guard band ends at 12.6 million.
    pub corner: [i32x8<S>; 2],
    /// Of each edge, down and right from its first corner to the second, units.
    pub drop: [i32x8<S>; 3],
    pub run: [i32x8<S>; 3],
    /// Reversed depth of the corners, clockwise.
    pub depth: &'c [[f64; 8]; 3],
}

impl<S: Simd> Corners8<'_, S> {
    /// The planes of the first four and of the others.
    #[inline(always)]
    pub fn planes(&self, simd: S) -> [Depth4<S>; 2] {
        let unit = f32x8::splat(simd, 256.0);
        // Within 2^23: exact in f32.
        let dx1 = (f32x8::float_from(-self.drop[1]) * unit).widen();
        let dx2 = (f32x8::float_from(-self.drop[2]) * unit).widen();
        let dy1 = (f32x8::float_from(self.run[1]) * unit).widen();
        let dy2 = (f32x8::float_from(self.run[2]) * unit).widen();
        let x = f32x8::float_from(self.corner[0]).widen();
        let y = f32x8::float_from(self.corner[1]).widen();
        // In two parts of fewer bits.
        let high = f32x8::float_from(self.area >> 12).widen();
        let low = f32x8::float_from(self.area & 0xfff).widen();
        let area = (high.0 * 4096.0 + low.0, high.1 * 4096.0 + low.1);
        [
            self.plane(simd, 0, area.0, [dx1.0, dx2.0], [dy1.0, dy2.0], [x.0, y.0]),
            self.plane(simd, 4, area.1, [dx1.1, dx2.1], [dy1.1, dy2.1], [x.1, y.1]),
        ]
    }

    /// Of the four triangles from `first` on.
    #[inline(always)]
    fn plane(
        &self,
        simd: S,
        first: usize,
        area: f64x4<S>,
        [dx1, dx2]: [f64x4<S>; 2],
        [dy1, dy2]: [f64x4<S>; 2],
        [x, y]: [f64x4<S>; 2],
    ) -> Depth4<S> {
        let inverse_area = f64x4::splat(simd, 1.0) / area;
        let a = f64x4::from_slice(simd, &self.depth[0][first..first + 4]);
        let b = f64x4::from_slice(simd, &self.depth[1][first..first + 4]);
        let c = f64x4::from_slice(simd, &self.depth[2][first..first + 4]);
        let (ab, ac) = (b - a, c - a);
        Depth4 {
            depth: a,
            origin: [x * (1.0 / 256.0) - 0.5, y * (1.0 / 256.0) - 0.5],
            ddx: (ab * dx1 + ac * dx2) * inverse_area,
            ddy: (ab * dy1 + ac * dy2) * inverse_area,
        }
    }
}

/// Planes one by one.
pub(crate) struct Planes8 {
    origin: [[f64; 8]; 2],
    ddx: [f64; 8],
    ddy: [f64; 8],
}

impl Planes8 {
    #[inline(always)]
    pub fn new<S: Simd>(_: S, [low, high]: [Depth4<S>; 2]) -> Self {
        Planes8 {
            origin: [both(low.origin[0], high.origin[0]), both(low.origin[1], high.origin[1])],
            ddx: both(low.ddx, high.ddx),
            ddy: both(low.ddy, high.ddy),
        }
    }

    /// That of a triangle with these depths of its corners.
    #[inline(always)]
    pub fn of(&self, lane: usize, [a, b, c]: [f64; 3]) -> TileDepth {
        TileDepth {
            depth: a,
            origin: [self.origin[0][lane], self.origin[1][lane]],
            ddx: self.ddx[lane],
            ddy: self.ddy[lane],
            low: least(least(a, b), c),
            high: greatest(greatest(a, b), c),
        }
    }
}

#[inline(always)]
pub(crate) fn least(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

#[inline(always)]
pub(crate) fn greatest(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// Whole numbers below 2^24.
#[inline(always)]
pub(crate) fn widened<S: Simd>(_: S, x: i32x8<S>) -> [f64x4<S>; 2] {
    let (low, high) = f32x8::float_from(x).widen();
    [low, high]
}

#[inline(always)]
pub(crate) fn both<S: Simd>(low: f64x4<S>, high: f64x4<S>) -> [f64; 8] {
    let mut all = [0.0; 8];
    low.store_slice(&mut all[..4]);
    high.store_slice(&mut all[4..]);
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::level::dispatch_wide;
    use crate::piece::depth_plane;
    use crate::testing::{Random, levels};

    #[test]
    fn planes_of_eight_are_those_of_one() {
        let random = &mut Random(11);
        for round in 0..400 {
            let mut between = |low: f64, high: f64| (low + (high - low) * random.next()) as i32;
            let reach = [300.0, 16_383.0][round % 2];
            let mut corners = [[[0; 8]; 2]; 3];
            let mut depth = [[0.0; 8]; 3];
            for lane in 0..8 {
                let far = [0.0, 12_500_000.0, -12_500_000.0][(round + lane) % 3];
                for axis in [0, 1] {
                    let first = far as i32 + between(-50_000.0, 50_000.0);
                    corners[0][axis][lane] = first;
                    corners[1][axis][lane] = first + between(0.0, reach);
                    corners[2][axis][lane] = first + between(-0.0, reach);
                }
                for corner in &mut depth {
                    corner[lane] = f64::from(between(0.0, 1e9)) * 1e-9;
                }
            }
            let sides = [1, 2, 0].map(|from| (from, (from + 1) % 3));
            let area = |lane: usize| {
                let way = |corner: usize, axis: usize| {
                    i64::from(corners[corner][axis][lane] - corners[0][axis][lane])
                };
                way(1, 0) * way(2, 1) - way(2, 0) * way(1, 1)
            };
            for level in levels().into_iter().filter(|level| !level.is_fallback()) {
                let planes = dispatch_wide!(level, simd => {
                    let of = |axis: usize| sides.map(|(from, to)| {
                        i32x8::simd_from(simd, corners[to][axis]) - i32x8::simd_from(simd, corners[from][axis])
                    });
                    let areas = [0, 1, 2, 3, 4, 5, 6, 7].map(|lane| area(lane) as i32);
                    let corners = Corners8 {
                        area: i32x8::simd_from(simd, areas),
                        corner: corners[0].map(|along| i32x8::simd_from(simd, along)),
                        drop: of(1),
                        run: of(0),
                        depth: &depth,
                    };
                    Planes8::new(simd, corners.planes(simd))
                });
                for lane in 0..8 {
                    let of = |axis: usize| {
                        sides.map(|(from, to)| {
                            i64::from(corners[to][axis][lane])
                                - i64::from(corners[from][axis][lane])
                        })
                    };
                    let depth = depth.map(|corner| corner[lane]);
                    let corner = corners[0].map(|along| i64::from(along[lane]));
                    let one = depth_plane(depth, of(1), of(0), area(lane) as f64, corner);
                    let got = planes.of(lane, depth);
                    assert_eq!(format!("{got:?}"), format!("{one:?}"), "{level:?}");
                }
            }
        }
    }
}
