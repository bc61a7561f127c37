//! Which samples of a tile a triangle wins where pixels have several: sixteen at a time, those of some
//! neighbouring pixels.
//!
//! The samples of a pixel lie side by side, so a triangle of few pixels finds all of theirs in few lines of
//! memory, and fills the lanes. Edges, depth and ties are those of [`crate::fill`], operation by operation.

use fearless_simd::{Simd, f32x16, f64x8, i16x32, i32x16, mask32x16, prelude::*, u32x16};

use crate::blocks::Columns;
use crate::depth::reversed_key;
use crate::fill::{KeepSample, TileTriangle, clamped_key, is_long, shift, wins_of};
use crate::samples::{Offset, Samples};
use crate::tile::TileBuffer;

/// Samples of a patch.
pub(crate) const PATCH: usize = 16;

/// Where the samples of a patch lie, lane by lane.
#[derive(Debug)]
pub(crate) struct Lattice {
    /// Twice as many 16-bit numbers: down and right of the centre of the first pixel, sixteenths.
    ways: [i16; 2 * PATCH],
    /// Right of the centre of the first pixel, px.
    pub x: [f64; PATCH],
    /// Down from it, px; again and again the same.
    pub y: [f64; PATCH / 2],
}

impl Lattice {
    const fn new(samples: Samples) -> Self {
        let offsets = samples.offsets();
        let n = offsets.len();
        let mut all = Lattice { ways: [0; 2 * PATCH], x: [0.0; PATCH], y: [0.0; PATCH / 2] };
        let mut lane = 0;
        while lane < PATCH {
            let [x, y] = offsets[lane % n];
            let x = x + 16 * (lane / n) as i32;
            (all.ways[2 * lane], all.ways[2 * lane + 1]) = (y as i16, x as i16);
            all.x[lane] = x as f64 / 16.0;
            all.y[lane % (PATCH / 2)] = y as f64 / 16.0;
            lane += 1;
        }
        all
    }

    /// That of `N` samples per pixel.
    #[inline(always)]
    pub fn of<const N: usize>() -> &'static Lattice {
        match N {
            2 => &LATTICE_OF_TWO,
            4 => &LATTICE_OF_FOUR,
            _ => &LATTICE_OF_EIGHT,
        }
    }
}

static LATTICE_OF_TWO: Lattice = Lattice::new(Samples::Two);
static LATTICE_OF_FOUR: Lattice = Lattice::new(Samples::Four);
static LATTICE_OF_EIGHT: Lattice = Lattice::new(Samples::Eight);

/// Edge values of a patch, in the first row of a triangle's box, its first pixel that of the box.
#[derive(Clone, Copy)]
pub(crate) struct Values<S: Simd>([i32x16<S>; 3]);

impl<S: Simd> Values<S> {
    /// Of any triangle.
    #[inline(always)]
    pub fn new<const N: usize>(simd: S, triangle: &TileTriangle, offsets: &[Offset; N]) -> Self {
        let TileTriangle { value, rest, left, down, .. } = triangle;
        let mut values = [[0; PATCH]; 3];
        for edge in 0..3 {
            for sample in 0..N {
                let shift = shift(rest[edge], left[edge], down[edge], offsets[sample]);
                for pixel in 0..PATCH / N {
                    values[edge][pixel * N + sample] =
                        value[edge] + shift - left[edge] * pixel as i32;
                }
            }
        }
        Values([
            i32x16::simd_from(simd, values[0]),
            i32x16::simd_from(simd, values[1]),
            i32x16::simd_from(simd, values[2]),
        ])
    }

    /// Of a triangle whose edges fit 16 bits. `pairs` are what its edges are multiplied with ways by: `down` in
    /// the lower half, less `left` in the upper.
    #[inline(always)]
    pub fn of_short<const N: usize>(simd: S, triangle: &TileTriangle, pairs: [i32; 3]) -> Self {
        Values(short_values::<S, N>(simd, triangle.value, triangle.rest, pairs))
    }

    /// Where the patch begins `n` pixels to the right.
    #[inline(always)]
    fn right(self, triangle: &TileTriangle, n: i32) -> Self {
        let ([a, b, c], left) = (self.0, &triangle.left);
        Values([a - left[0] * n, b - left[1] * n, c - left[2] * n])
    }

    /// `n` rows down.
    #[inline(always)]
    fn down(self, triangle: &TileTriangle, n: i32) -> Self {
        let ([a, b, c], down) = (self.0, &triangle.down);
        Values([a + down[0] * n, b + down[1] * n, c + down[2] * n])
    }

    /// Negative where a sample is outside.
    #[inline(always)]
    fn signs(self) -> i32x16<S> {
        let [a, b, c] = self.0;
        a | b | c
    }
}

/// [`Values::of_short`], edge by edge.
#[inline(always)]
pub(crate) fn short_values<S: Simd, const N: usize>(
    simd: S,
    value: [i32; 3],
    rest: [i32; 3],
    pairs: [i32; 3],
) -> [i32x16<S>; 3] {
    let ways = i16x32::simd_from(simd, Lattice::of::<N>().ways);
    [
        short(simd, ways, value[0], rest[0], pairs[0]),
        short(simd, ways, value[1], rest[1], pairs[1]),
        short(simd, ways, value[2], rest[2], pairs[2]),
    ]
}

/// An edge of them.
#[inline(always)]
fn short<S: Simd>(simd: S, ways: i16x32<S>, value: i32, rest: i32, pair: i32) -> i32x16<S> {
    let pair: i16x32<S> = i32x16::splat(simd, pair).bitcast();
    let way = simd.pairwise_dot_product_i16x32(pair, ways);
    (((way << 4) + rest) >> 8) + value
}

/// Draws a triangle that does not fill blocks. Returns how many samples were won.
#[inline(always)]
pub(crate) fn fill<S: Simd, const N: usize>(
    simd: S,
    tile: &mut TileBuffer,
    triangle: &TileTriangle,
    values: Values<S>,
    mut keep: Option<&mut KeepSample<'_>>,
) -> u32 {
    let TileTriangle { rect, depth, .. } = *triangle;
    let mut written = 0;
    if keep.is_some() {
        let mut x = rect.x[0] / 8 * 8;
        while x < rect.x[1] {
            let column = Column::<S, N> { x, values };
            written += column.rows::<true>(simd, tile, triangle, rect.y, keep.as_deref_mut());
            x += 8;
        }
    } else {
        // From the first column on: most triangles lie in one patch. All patches lie in the tile; what of them is left of
        // the box, then, is outside.
        let width = PATCH / N;
        let reach = (rect.x[1] - rect.x[0]).next_multiple_of(width);
        let mut x = rect.x[0].min(tile.side() - reach);
        let mut values = values;
        if x < rect.x[0] {
            values = values.right(triangle, x as i32 - rect.x[0] as i32);
        }
        loop {
            let patch = Patch::new::<N>(simd, tile, triangle, values, x);
            written += patch.rows::<N, true>(simd, tile, triangle, x, rect.y);
            x += width;
            if x >= rect.x[1] {
                break;
            }
            values = values.right(triangle, width as i32);
        }
    }
    if written > 0 {
        tile.touch(rect, reversed_key(depth.high as f32));
    }
    written
}

/// Sixteen samples of a row of pixels, and what is beneath them.
#[derive(Clone, Copy)]
struct Patch<S: Simd> {
    /// Edge values in the first row of the triangle.
    values: Values<S>,
    /// Depth that the way from the plane's origin along x adds.
    way: [f64x8<S>; 2],
}

impl<S: Simd> Patch<S> {
    /// With its first pixel in column `x`, where `values` are.
    #[inline(always)]
    fn new<const N: usize>(
        simd: S,
        tile: &TileBuffer,
        triangle: &TileTriangle,
        values: Values<S>,
        x: usize,
    ) -> Self {
        let TileTriangle { depth, .. } = triangle;
        let lattice = Lattice::of::<N>();
        // Multiples of 1 / 256: exact.
        let way = f64::from(tile.origin()[0] + x as i32) - depth.origin[0];
        Patch {
            values,
            way: [
                (f64x8::from_slice(simd, &lattice.x[..8]) + way) * depth.ddx,
                (f64x8::from_slice(simd, &lattice.x[8..]) + way) * depth.ddx,
            ],
        }
    }

    /// Draws some rows from column `x` on; returns how many samples were won. Without `PARTLY` all are covered,
    /// and their depths need no clamp.
    #[inline(always)]
    fn rows<const N: usize, const PARTLY: bool>(
        &self,
        simd: S,
        tile: &mut TileBuffer,
        triangle: &TileTriangle,
        x: usize,
        rows: [usize; 2],
    ) -> u32 {
        let mut values = self.values;
        if PARTLY {
            values = values.down(triangle, rows[0] as i32 - triangle.rect.y[0] as i32);
        }
        let mut way_y = way_down::<S, N>(simd, tile, triangle, rows[0]);
        let mut written = 0;
        let stride = tile.stride_px() * N;
        let start = rows[0] * stride + x * N;
        let n = (rows[1] - rows[0]) * stride;
        let mut keys = &mut tile.keys[tile.starts[0] + start..][..n];
        let mut ids = &mut tile.ids[tile.starts[1] + start..][..n];
        assert!(stride >= PATCH);
        while keys.len() >= stride {
            let (row_keys, other_keys) = keys.split_at_mut(stride);
            let (row_ids, other_ids) = ids.split_at_mut(stride);
            (keys, ids) = (other_keys, other_ids);
            let outside = match PARTLY {
                true => values.signs(),
                false => i32x16::splat(simd, 0),
            };
            if !PARTLY || is_long::<S>() || outside.simd_ge(0).any_true() {
                let key = self.key::<PARTLY>(simd, triangle, way_y);
                let id = u32x16::splat(simd, triangle.id);
                written += win(simd, outside, key, id, row_keys, row_ids);
            }
            if PARTLY {
                values = values.down(triangle, 1);
            }
            way_y += 1.0;
        }
        written
    }

    /// The keys in a row, `way_y` below the origin of the plane.
    #[inline(always)]
    fn key<const PARTLY: bool>(
        &self,
        simd: S,
        TileTriangle { depth, .. }: &TileTriangle,
        way_y: f64x8<S>,
    ) -> i32x16<S> {
        let in_row = way_y * depth.ddy + depth.depth;
        let [near, far] = self.way;
        let reversed: f32x16<S> = (near + in_row).narrow(far + in_row);
        match PARTLY {
            true => clamped_key(simd, depth, reversed),
            // The sum has no negative zero.
            false => (reversed + 0.0).bitcast(),
        }
    }
}

/// Writes the samples of a patch that are not `outside`, and nearer than what is there, or as near with a lower id.
/// Returns how many there are.
#[inline(always)]
pub(crate) fn win<S: Simd>(
    simd: S,
    outside: i32x16<S>,
    key: i32x16<S>,
    id: u32x16<S>,
    keys: &mut [i32],
    ids: &mut [u32],
) -> u32 {
    let (keys, ids) = (sixteen(keys), sixteen(ids));
    let (old_key, old_id) = (i32x16::simd_from(simd, *keys), u32x16::simd_from(simd, *ids));
    let wins = wins_of(simd, outside, [key, old_key], [id, old_id]);
    wins.select(key, old_key).store_slice(keys);
    wins.select(id, old_id).store_slice(ids);
    wins.to_bitmask().count_ones()
}

/// From the origin of the plane of depth down to the samples of a row, px: multiples of 1 / 256, so that
/// sums are exact.
#[inline(always)]
fn way_down<S: Simd, const N: usize>(
    simd: S,
    tile: &TileBuffer,
    triangle: &TileTriangle,
    row: usize,
) -> f64x8<S> {
    let way = f64::from(tile.origin()[1] + row as i32) - triangle.depth.origin[1];
    f64x8::simd_from(simd, Lattice::of::<N>().y) + way
}

/// Eight columns of pixels with `N` samples each.
pub(crate) struct Column<S: Simd, const N: usize> {
    /// First column in the tile.
    x: usize,
    /// Edge values at the first column of the triangle.
    values: Values<S>,
}

impl<S: Simd, const N: usize> Column<S, N> {
    /// Pixels of a patch.
    const WIDTH: usize = PATCH / N;
    /// Patches of a column, at most four.
    const PATCHES: usize = N / 2;

    /// The `i`th patch.
    #[inline(always)]
    fn patch(&self, simd: S, tile: &TileBuffer, triangle: &TileTriangle, i: usize) -> Patch<S> {
        let x = self.x + i * Self::WIDTH;
        let values = self.values.right(triangle, x as i32 - triangle.rect.x[0] as i32);
        Patch::new::<N>(simd, tile, triangle, values, x)
    }

    /// Draws some rows of a material with holes; returns how many samples were won.
    #[inline(always)]
    #[expect(clippy::needless_range_loop, reason = "iterators beside vectors may become calls")]
    fn rows_kept(
        &self,
        simd: S,
        tile: &mut TileBuffer,
        triangle: &TileTriangle,
        rows: [usize; 2],
        keep: &mut KeepSample<'_>,
    ) -> u32 {
        let offsets = tile.samples().offsets();
        let origin = tile.origin();
        let id = u32x16::splat(simd, triangle.id);
        let mut patches = [self.patch(simd, tile, triangle, 0); 4];
        for i in 1..Self::PATCHES {
            patches[i] = self.patch(simd, tile, triangle, i);
        }
        let mut written = 0;
        for row in rows[0]..rows[1] {
            let rows_down = row as i32 - triangle.rect.y[0] as i32;
            let way_y = way_down::<S, N>(simd, tile, triangle, row);
            let start = (row * tile.stride_px() + self.x) * N;
            let (key_start, id_start) = (tile.starts[0] + start, tile.starts[1] + start);
            let mut keys = [i32x16::splat(simd, 0); 4];
            let mut wins = 0_u64;
            for i in 0..Self::PATCHES {
                let outside = patches[i].values.down(triangle, rows_down).signs();
                if outside.simd_ge(0).any_true() {
                    keys[i] = patches[i].key::<true>(simd, triangle, way_y);
                    let old_key = sixteen(&mut tile.keys[key_start + i * PATCH..]);
                    let old_key = i32x16::simd_from(simd, *old_key);
                    let old_id = sixteen(&mut tile.ids[id_start + i * PATCH..]);
                    let old_id = u32x16::simd_from(simd, *old_id);
                    let own = wins_of(simd, outside, [keys[i], old_key], [id, old_id]);
                    wins |= own.to_bitmask() << (i * PATCH);
                }
            }
            if wins == 0 {
                continue;
            }
            let mut kept = 0_u64;
            for (sample, [x, y]) in offsets.iter().enumerate() {
                let asked = gather::<N>(wins >> sample);
                if asked != 0 {
                    let place = [
                        16 * (origin[0] + self.x as i32) + 8 + x,
                        16 * (origin[1] + row as i32) + 8 + y,
                    ];
                    kept |= spread::<N>(keep(triangle.id, place, asked) & asked) << sample;
                }
            }
            if kept == 0 {
                continue;
            }
            written += kept.count_ones();
            for i in 0..Self::PATCHES {
                let own: mask32x16<S> = SimdMask::from_bitmask(simd, kept >> (i * PATCH) & 0xffff);
                let old_keys = sixteen(&mut tile.keys[key_start + i * PATCH..]);
                own.select(keys[i], i32x16::simd_from(simd, *old_keys)).store_slice(old_keys);
                let old_ids = sixteen(&mut tile.ids[id_start + i * PATCH..]);
                own.select(id, u32x16::simd_from(simd, *old_ids)).store_slice(old_ids);
            }
        }
        written
    }
}

impl<S: Simd, const N: usize> Columns<S> for Column<S, N> {
    type Setup = Values<S>;

    #[inline(always)]
    fn at(_: S, _: &TileBuffer, _: &TileTriangle, setup: &Values<S>, x: usize) -> Self {
        Column { x, values: *setup }
    }

    #[inline(always)]
    fn rows<const PARTLY: bool>(
        &self,
        simd: S,
        tile: &mut TileBuffer,
        triangle: &TileTriangle,
        rows: [usize; 2],
        keep: Option<&mut KeepSample<'_>>,
    ) -> u32 {
        if let Some(keep) = keep {
            return self.rows_kept(simd, tile, triangle, rows, keep);
        }
        let mut written = 0;
        for i in 0..Self::PATCHES {
            let x = self.x + i * Self::WIDTH;
            let patch = self.patch(simd, tile, triangle, i);
            written += patch.rows::<N, PARTLY>(simd, tile, triangle, x, rows);
        }
        written
    }

    #[inline(always)]
    fn rows_in_front(
        &self,
        simd: S,
        tile: &mut TileBuffer,
        triangle: &TileTriangle,
        rows: [usize; 2],
    ) -> u32 {
        let id = u32x16::splat(simd, triangle.id);
        for i in 0..Self::PATCHES {
            let patch = self.patch(simd, tile, triangle, i);
            let mut way_y = way_down::<S, N>(simd, tile, triangle, rows[0]);
            for row in rows[0]..rows[1] {
                let at = (row * tile.stride_px() + self.x) * N + i * PATCH;
                let key = patch.key::<false>(simd, triangle, way_y);
                key.store_slice(sixteen(&mut tile.keys[tile.starts[0] + at..]));
                id.store_slice(sixteen(&mut tile.ids[tile.starts[1] + at..]));
                way_y += 1.0;
            }
        }
        (8 * N * (rows[1] - rows[0])) as u32
    }
}

/// Every `N`th of `8 * N` bits, from the lowest on.
#[inline(always)]
fn gather<const N: usize>(bits: u64) -> u64 {
    let mut out = 0;
    for pixel in 0..8 {
        out |= (bits >> (pixel * N) & 1) << pixel;
    }
    out
}

/// The other way around, zeros between.
#[inline(always)]
fn spread<const N: usize>(bits: u64) -> u64 {
    let mut out = 0;
    for pixel in 0..8 {
        out |= (bits >> pixel & 1) << (pixel * N);
    }
    out
}

/// The first sixteen values.
#[inline(always)]
fn sixteen<T>(list: &mut [T]) -> &mut [T; PATCH] {
    list.first_chunk_mut().expect("rows have a margin of eight pixels")
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;

    use super::*;
    use crate::fill::TileDepth;
    use crate::testing::levels;
    use crate::tile::TileRect;

    fn check<const N: usize>(samples: Samples) {
        let offsets: &[Offset; N] = samples.offsets().first_chunk().unwrap();
        let depth =
            TileDepth { depth: 0.0, origin: [0.0; 2], ddx: 0.0, ddy: 0.0, low: 0.0, high: 0.0 };
        let lengths = [-16383, -16382, -4097, -300, -1, 0, 1, 255, 256, 8191, 16383];
        for (i, &left) in lengths.iter().enumerate() {
            for (j, &down) in lengths.iter().enumerate() {
                let triangle = TileTriangle {
                    id: 0,
                    rect: TileRect { x: [0, 1], y: [0, 1] },
                    value: [1000, -70_000, i as i32],
                    rest: [0, 255, 128],
                    left: [left, down, lengths[10 - i]],
                    down: [down, left, lengths[10 - j]],
                    depth,
                };
                let pairs =
                    [0, 1, 2].map(|edge| triangle.down[edge] & 0xffff | -triangle.left[edge] << 16);
                for level in levels() {
                    let [any, short] = dispatch!(level, simd => {
                        let any = Values::new(simd, &triangle, offsets).0;
                        let short = Values::of_short::<N>(simd, &triangle, pairs).0;
                        [any.map(<[i32; PATCH]>::from), short.map(<[i32; PATCH]>::from)]
                    });
                    assert_eq!(any, short, "{level:?} {triangle:?}");
                    // Inside is where the value at the place itself is not negative.
                    let of = |x: i64, y: i64| {
                        let way = (i64::from(triangle.down[0]) * y
                            - i64::from(triangle.left[0]) * x)
                            * 16;
                        (i64::from(triangle.value[0]) * 256 + i64::from(triangle.rest[0]) + way)
                            >> 8
                    };
                    for (lane, value) in any[0].iter().enumerate() {
                        let [x, y] = offsets[lane % N].map(i64::from);
                        assert_eq!(i64::from(*value), of(x + 16 * (lane / N) as i64, y));
                    }
                }
            }
        }
    }

    #[test]
    fn edges_of_a_patch_are_those_of_its_samples() {
        check::<2>(Samples::Two);
        check::<4>(Samples::Four);
        check::<8>(Samples::Eight);
    }

    #[test]
    fn bits_of_a_sample_are_gathered_and_spread() {
        fn check<const N: usize>() {
            for bits in 0..256 {
                let own = spread::<N>(bits);
                assert_eq!(gather::<N>(own), bits);
                assert_eq!(own.count_ones(), bits.count_ones());
                // Other samples of the same pixels have no part in it.
                let others = !spread::<N>(255);
                assert_eq!(gather::<N>(own | others), bits);
            }
        }
        check::<2>();
        check::<4>();
        check::<8>();
    }
}
