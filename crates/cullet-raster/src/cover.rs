//! Coverage and depth: which samples a triangle wins.
//!
//! Three edge functions (Pineda 1988, "A Parallel Algorithm for Polygon Rasterization") are
//! linear along a row, so the covered samples of a row are one interval; its ends come from one
//! exact integer division per edge. Depth is a plane through the snapped corners, in f64.

use crate::depth::DepthFormat;
use crate::setup::{ScreenTriangle, doubled_area};

/// The id of a sample that no triangle has won.
pub const NO_TRIANGLE: u32 = u32::MAX;

/// A rectangle of the picture's samples: ids and depths, row-major, `width * height` each.
#[derive(Debug)]
pub struct Tile<'a, D: DepthFormat> {
    /// Left border in the picture, px.
    pub x: u32,
    /// Upper border in the picture, px.
    pub y: u32,
    /// Pixels across.
    pub width: u32,
    /// Source triangle per sample, or [`NO_TRIANGLE`].
    pub ids: &'a mut [u32],
    /// Depth per sample.
    pub depth: &'a mut [D::Code],
}

impl<D: DepthFormat> Tile<'_, D> {
    /// Pixels down.
    pub fn height(&self) -> u32 {
        (self.ids.len() / self.width as usize) as u32
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.ids.fill(NO_TRIANGLE);
        self.depth.fill(D::FARTHEST);
    }
}

/// Asked, for alpha-masked triangles, whether a sample that passed the depth test is there.
pub trait Keep {
    /// The answer is always yes, and need not be asked for.
    const ALWAYS: bool = false;
    /// Whether triangle `id` has matter at pixel `(x, y)` of the picture.
    fn keep(&mut self, id: u32, x: u32, y: u32) -> bool;
}

/// For opaque triangles: every sample is there.
#[derive(Clone, Copy, Debug)]
pub struct KeepAll;

impl Keep for KeepAll {
    const ALWAYS: bool = true;
    fn keep(&mut self, _: u32, _: u32, _: u32) -> bool {
        true
    }
}

/// For masked triangles: asks the function.
#[derive(Clone, Copy, Debug)]
pub struct KeepIf<F>(pub F);

impl<F: FnMut(u32, u32, u32) -> bool> Keep for KeepIf<F> {
    fn keep(&mut self, id: u32, x: u32, y: u32) -> bool {
        (self.0)(id, x, y)
    }
}

/// Writes `triangle` into the samples of `tile` it wins: those it covers, where it is nearer
/// than what is there, or equally near with a lower id, and where `keep` agrees. The result does
/// not depend on the order in which triangles come. Returns how many samples were written.
pub fn cover<D: DepthFormat, const BITS: u32, K: Keep>(
    tile: &mut Tile<'_, D>,
    triangle: &ScreenTriangle,
    keep: &mut K,
) -> u64 {
    let Some(bounds) = Bounds::of::<BITS, D>(triangle, tile) else { return 0 };
    let edges = Edges::new::<BITS>(triangle, [0, 0]);
    // Many a small triangle covers no sample and needs no depth.
    let mut plane = None;
    let mut written = 0;
    for y in bounds.y.clone() {
        let row = edges.row::<BITS>(y);
        let (first, last) = row.covered(bounds.x.start, bounds.x.end);
        if first >= last {
            continue;
        }
        let start = (y - i64::from(tile.y)) as usize * tile.width as usize;
        let samples = start + (first - i64::from(tile.x)) as usize
            ..start + (last - i64::from(tile.x)) as usize;
        let plane = plane.get_or_insert_with(|| DepthPlane::new::<BITS>(triangle, &edges));
        let (depth, ids) = (&mut tile.depth[samples.clone()], &mut tile.ids[samples]);
        let (row, first) = (plane.row(y as f64), first as i32);
        written += u64::from(match K::ALWAYS && depth.len() >= LONG_RUN {
            true => win_all::<D>(plane, row, first, triangle.id, depth, ids),
            false => win_some::<D>(plane, row, [first, y as i32], triangle.id, depth, ids, keep),
        });
    }
    written
}

/// Samples of a row from which on vectors pay.
const LONG_RUN: usize = 16;

/// Whether a sample is won: by the nearer one, or at equal depth by the lower id.
#[inline(always)]
fn wins<D: DepthFormat>(depth: D::Code, id: u32, old_depth: D::Code, old_id: u32) -> bool {
    D::nearer(depth, old_depth) | ((depth == old_depth) & (id < old_id))
}

/// A run of samples from pixel `first` on, without a branch: compilers make vectors of it.
fn win_all<D: DepthFormat>(
    plane: &DepthPlane,
    row: f64,
    first: i32,
    id: u32,
    depth: &mut [D::Code],
    ids: &mut [u32],
) -> u32 {
    let mut written = 0;
    for (x, (old_depth, old_id)) in (first..).zip(depth.iter_mut().zip(ids)) {
        let depth = D::encode(plane.at(row, f64::from(x)));
        let wins = wins::<D>(depth, id, *old_depth, *old_id);
        *old_depth = if wins { depth } else { *old_depth };
        *old_id = if wins { id } else { *old_id };
        written += u32::from(wins);
    }
    written
}

/// A run from pixel `[x, y]` on, of which `keep` has a say.
#[inline(always)]
fn win_some<D: DepthFormat>(
    plane: &DepthPlane,
    row: f64,
    [first, y]: [i32; 2],
    id: u32,
    depth: &mut [D::Code],
    ids: &mut [u32],
    keep: &mut impl Keep,
) -> u32 {
    let mut written = 0;
    for (x, (old_depth, old_id)) in (first..).zip(depth.iter_mut().zip(ids)) {
        let depth = D::encode(plane.at(row, f64::from(x)));
        let wins = wins::<D>(depth, id, *old_depth, *old_id);
        if wins && keep.keep(id, x as u32, y as u32) {
            (*old_depth, *old_id) = (depth, id);
            written += 1;
        }
    }
    written
}

/// The pixels of a tile whose centres may lie in a triangle, in picture coordinates.
struct Bounds {
    x: core::ops::Range<i64>,
    y: core::ops::Range<i64>,
}

impl Bounds {
    fn of<const BITS: u32, D: DepthFormat>(
        triangle: &ScreenTriangle,
        tile: &Tile<'_, D>,
    ) -> Option<Self> {
        // Centre p + 1/2 >= low  <=>  p >= ceil(low - 1/2); below likewise.
        let half = 1i64 << (BITS - 1);
        let first = |low: i64| (low - half + (1 << BITS) - 1) >> BITS;
        let last = |high: i64| ((high - half) >> BITS) + 1;
        let range = |values: [i64; 3], start: u32, size: u32| {
            let low = values[0].min(values[1]).min(values[2]);
            let high = values[0].max(values[1]).max(values[2]);
            let (start, end) = (i64::from(start), i64::from(start) + i64::from(size));
            first(low).max(start)..last(high).min(end)
        };
        let x = range(triangle.corners.map(|c| c.x), tile.x, tile.width);
        let y = range(triangle.corners.map(|c| c.y), tile.y, tile.height());
        (!x.is_empty() && !y.is_empty()).then_some(Bounds { x, y })
    }
}

/// Edge `i` is opposite corner `i`: `value = base + dx * x + dy * y` in subpixel units at
/// pixel centres `(x, y)`, positive inside, its corner's share of the doubled area.
pub(crate) struct Edges {
    base: [i64; 3],
    dx: [i64; 3],
    dy: [i64; 3],
    /// Smallest value that counts as inside: 0 on top and left edges, 1 on others.
    least: [i64; 3],
}

impl Edges {
    /// At the samples that lie `offset` from the centres, subpixel units.
    pub(crate) fn new<const BITS: u32>(triangle: &ScreenTriangle, offset: [i64; 2]) -> Self {
        let half = 1i64 << (BITS - 1);
        let (px, py) = (half + offset[0], half + offset[1]);
        let mut edges = Edges { base: [0; 3], dx: [0; 3], dy: [0; 3], least: [0; 3] };
        for i in 0..3 {
            let from = triangle.corners[(i + 1) % 3];
            let to = triangle.corners[(i + 2) % 3];
            let (run, drop) = (to.x - from.x, to.y - from.y); // y down: drop > 0 goes down
            // run (py - from.y) - drop (px - from.x)
            edges.base[i] = run * (py - from.y) - drop * (px - from.x);
            edges.dx[i] = -drop << BITS;
            edges.dy[i] = run << BITS;
            // Clockwise as seen: left edges go up, top edges go right.
            let top_left = drop < 0 || (drop == 0 && run > 0);
            edges.least[i] = i64::from(!top_left);
        }
        edges
    }

    pub(crate) fn row<const BITS: u32>(&self, y: i64) -> Row<'_> {
        let mut values = self.base;
        for (value, dy) in values.iter_mut().zip(self.dy) {
            *value += dy * y;
        }
        Row { edges: self, values }
    }
}

/// The edge functions along one row of pixels.
pub(crate) struct Row<'a> {
    edges: &'a Edges,
    /// Values at x = 0.
    values: [i64; 3],
}

impl Row<'_> {
    /// The covered pixels among `from..to`, as a half-open interval; empty if first >= last.
    pub(crate) fn covered(&self, from: i64, to: i64) -> (i64, i64) {
        let (mut first, mut last) = (from, to);
        for i in 0..3 {
            // value + dx * x >= least
            let (dx, missing) = (self.edges.dx[i], self.edges.least[i] - self.values[i]);
            if dx > 0 {
                first = first.max(-((-missing).div_euclid(dx))); // x >= ceil(missing / dx)
            } else if dx < 0 {
                last = last.min((-missing).div_euclid(-dx) + 1); // x <= floor(-missing / -dx)
            } else if missing > 0 {
                last = from;
            }
        }
        (first, last)
    }
}

/// Depth over a triangle: the depth of the first corner and its change per pixel. What a sample gets
/// depends on the triangle and the sample alone.
pub(crate) struct DepthPlane {
    /// Of the first corner.
    depth: f64,
    /// The first corner, counted from the centre of pixel 0, px.
    origin: [f64; 2],
    ddx: f64,
    ddy: f64,
    low: f64,
    high: f64,
}

impl DepthPlane {
    pub(crate) fn new<const BITS: u32>(triangle: &ScreenTriangle, edges: &Edges) -> Self {
        let [a, b, c] = triangle.depth;
        let inverse_area = 1.0 / doubled_area(triangle.corners) as f64;
        // An edge value over the doubled area is its corner's share.
        let slope = |d: &[i64; 3]| ((b - a) * d[1] as f64 + (c - a) * d[2] as f64) * inverse_area;
        let px = |units: i64| units as f64 / f64::from(1u32 << BITS) - 0.5;
        let corner = triangle.corners[0];
        DepthPlane {
            depth: a,
            origin: [px(corner.x), px(corner.y)],
            ddx: slope(&edges.dx),
            ddy: slope(&edges.dy),
            low: a.min(b).min(c),
            high: a.max(b).max(c),
        }
    }

    /// Reversed depth in row `y` straight above or below the first corner.
    pub(crate) fn row(&self, y: f64) -> f64 {
        self.depth + self.ddy * (y - self.origin[1])
    }

    /// Reversed depth of pixel `x` of a row, clamped to the range of the corners.
    #[inline(always)]
    pub(crate) fn at(&self, row: f64, x: f64) -> f64 {
        let depth = row + self.ddx * (x - self.origin[0]);
        // Compare and select, in the order of `f64::clamp`.
        let depth = if depth < self.low { self.low } else { depth };
        if depth > self.high { self.high } else { depth }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::depth::ReversedF32;
    use crate::fixed::Fixed;
    use crate::reference;

    /// Draws triangles given in eighths of a pixel into a 8x4 picture and reads it back as rows
    /// of digits (triangle index) and dots.
    fn picture(triangles: &[([[i64; 2]; 3], f64)]) -> Vec<String> {
        let (mut ids, mut depth) = (vec![NO_TRIANGLE; 32], vec![0.0; 32]);
        let mut tile =
            Tile::<ReversedF32> { x: 0, y: 0, width: 8, ids: &mut ids, depth: &mut depth };
        tile.clear();
        for (id, (corners, z)) in (0..).zip(triangles) {
            let mut corners = corners.map(|[x, y]| Fixed { x: x * 32, y: y * 32 });
            if doubled_area(corners) < 0 {
                corners.swap(1, 2);
            }
            let triangle = ScreenTriangle { corners, depth: [*z; 3], id };
            cover::<ReversedF32, 8, _>(&mut tile, &triangle, &mut KeepAll);
            for (i, &got) in tile.ids.iter().enumerate() {
                let (x, y) = ((i % 8) as i64, (i / 8) as i64);
                assert!(got != id || reference::covers::<8>(corners, x, y), "{x} {y}");
            }
        }
        let text = |id: &u32| if *id == NO_TRIANGLE { ".".into() } else { id.to_string() };
        ids.chunks(8).map(|row| row.iter().map(text).collect()).collect()
    }

    #[test]
    fn two_halves_of_a_square_meet_without_gap_or_overlap() {
        let picture =
            picture(&[([[4, 4], [36, 4], [36, 36]], 0.5), ([[4, 4], [36, 36], [4, 36]], 0.5)]);
        assert_eq!(picture, ["0000....", "1000....", "1100....", "1110...."]);
    }

    #[test]
    fn the_nearer_triangle_wins_in_any_order() {
        let near = ([[0, 0], [64, 0], [0, 64]], 0.7);
        let far = ([[0, 0], [64, 0], [0, 64]], 0.2);
        assert_eq!(picture(&[near, far])[0], "0000000.");
        assert_eq!(picture(&[far, near])[0], "1111111.");
    }

    #[test]
    fn ties_go_to_the_lower_id() {
        let one = ([[0, 0], [64, 0], [0, 64]], 0.5);
        assert_eq!(picture(&[one, one])[0], "0000000.");
    }

    #[test]
    fn a_triangle_between_centres_covers_nothing() {
        assert_eq!(picture(&[([[5, 5], [11, 5], [5, 11]], 0.5)]).concat(), ".".repeat(32));
    }

    #[test]
    fn keep_is_asked_per_sample() {
        let (mut ids, mut depth) = ([NO_TRIANGLE; 8], [0.0; 8]);
        let mut tile =
            Tile::<ReversedF32> { x: 10, y: 20, width: 4, ids: &mut ids, depth: &mut depth };
        let corners = [[0, 0], [99 * 256, 0], [0, 99 * 256]].map(|[x, y]| Fixed { x, y });
        let triangle = ScreenTriangle { corners, depth: [0.5; 3], id: 3 };
        let mut asked = Vec::new();
        let mut keep = KeepIf(|id, x, y| {
            asked.push((id, x, y));
            x == 11
        });
        assert_eq!(cover::<ReversedF32, 8, _>(&mut tile, &triangle, &mut keep), 2);
        assert_eq!(asked.len(), 8);
        assert_eq!((asked[0], asked[7]), ((3, 10, 20), (3, 13, 21)));
        assert_eq!(ids.map(|id| id == 3), [false, true, false, false, false, true, false, false]);
    }
}
