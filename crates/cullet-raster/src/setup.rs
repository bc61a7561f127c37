//! Set-up: from clip-space corners to triangles ready to be covered.
//!
//! Per vertex, however many triangles share it: outcode, divide, snap ([`Placer`]). Per triangle: drop
//! what is not finite or lies outside one plane with all corners, clip what must be, decide facing
//! by the snapped area. All later work on coverage is exact.

use cullet_transform::{ClipPoint, PlaneMask, Viewport};

use crate::clip::{GuardBand, Polygon};
use crate::fixed::Fixed;
use crate::precision::Transforms;

/// Which side of a triangle is drawn, as seen on the screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Facing {
    /// Both.
    Both,
    /// Counter-clockwise triangles only (y up): the usual front faces.
    CounterClockwise,
    /// Clockwise triangles only: the front faces of a mirrored object.
    Clockwise,
}

/// A vertex with all that triangles ask of it.
#[derive(Clone, Copy, Debug)]
pub struct Vertex {
    clip: ClipPoint,
    /// Snapped; meaningless where `cuts` is not empty.
    pub(crate) at: Fixed,
    /// Reversed depth, in `0..=1`; likewise.
    pub(crate) depth: f64,
    /// The planes it lies outside of.
    pub(crate) outside: PlaneMask,
    /// The planes that cut its triangles; all where it is not finite.
    pub(crate) cuts: PlaneMask,
}

/// Puts vertices on the screen. `BITS` is the number of subpixel bits, 1..=16; 8 is the default
/// everywhere.
#[derive(Clone, Copy, Debug)]
pub struct Placer<const BITS: u32> {
    viewport: Viewport,
    guard: GuardBand,
    planes: PlaneMask,
    transforms: Transforms,
}

impl<const BITS: u32> Placer<BITS> {
    /// `planes` may cut the object. Planes not in the mask are not tested at all.
    pub fn new(viewport: Viewport, planes: PlaneMask) -> Self {
        Placer::with(Transforms::F64, viewport, planes)
    }

    /// [`Placer::new`], for points of [`Transforms::clip`].
    pub fn with(transforms: Transforms, viewport: Viewport, planes: PlaneMask) -> Self {
        Placer { viewport, guard: GuardBand::new(viewport, BITS), planes, transforms }
    }

    /// Tests, divides and snaps.
    #[inline]
    pub fn place(&self, clip: ClipPoint) -> Vertex {
        let (mut outside, mut cuts) = (PlaneMask::NONE, PlaneMask::NONE);
        if !clip.is_finite() {
            cuts = PlaneMask::ALL;
        } else if !self.planes.is_empty() {
            outside = clip.outcode().and(self.planes);
            cuts = self.guard.cuts(&clip, self.planes);
        }
        let (at, depth) = match cuts.is_empty() {
            true => {
                (self.transforms.snap::<BITS>(self.viewport, &clip), self.transforms.depth(&clip))
            }
            false => (Fixed { x: 0, y: 0 }, 0.0),
        };
        Vertex { clip, at, depth, outside, cuts }
    }
}

/// The triangles of one object.
#[derive(Clone, Copy, Debug)]
pub struct Triangles<'a> {
    /// Corners.
    pub vertices: &'a [Vertex],
    /// Indices into `vertices`, after `first_vertex` is taken off.
    pub triangles: &'a [[u32; 3]],
    /// The index of the first of `vertices`.
    pub first_vertex: u32,
    /// Id of the first triangle; the others follow.
    pub first_id: u32,
    /// Which side is drawn.
    pub facing: Facing,
}

/// A triangle (or a piece of a clipped one) on the screen, corners turned so that its doubled
/// area is positive: clockwise as seen.
#[derive(Clone, Copy, Debug)]
pub struct ScreenTriangle {
    /// Snapped corners.
    pub corners: [Fixed; 3],
    /// Reversed depth of the corners, in `0..=1`.
    pub depth: [f64; 3],
    /// Id of the source triangle.
    pub id: u32,
}

impl ScreenTriangle {
    /// Depth of the nearest corner.
    pub(crate) fn nearest(&self) -> f64 {
        let [a, b, c] = self.depth;
        a.max(b).max(c)
    }
}

/// What became of the triangles given to [`set_up`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SetupCounters {
    /// Triangles given.
    pub n_in: u64,
    /// Dropped: a corner is NaN or infinite.
    pub n_not_finite: u64,
    /// Dropped: all corners outside one plane, or nothing left after clipping.
    pub n_outside: u64,
    /// Dropped: no area after snapping.
    pub n_zero_area: u64,
    /// Dropped: facing away.
    pub n_facing_away: u64,
    /// Drawn, after clipping.
    pub n_clipped: u64,
    /// Drawn, clipped or not.
    pub n_drawn: u64,
}

impl SetupCounters {
    /// Counts what became of a finite triangle, and whether it was clipped.
    pub(crate) fn count(&mut self, outcome: Outcome, clipped: bool) {
        match outcome {
            Outcome::Drawn => {
                self.n_drawn += 1;
                self.n_clipped += u64::from(clipped);
            }
            Outcome::Outside => self.n_outside += 1,
            Outcome::ZeroArea => self.n_zero_area += 1,
            Outcome::FacingAway => self.n_facing_away += 1,
        }
    }
}

impl core::ops::AddAssign for SetupCounters {
    fn add_assign(&mut self, other: Self) {
        self.n_in += other.n_in;
        self.n_not_finite += other.n_not_finite;
        self.n_outside += other.n_outside;
        self.n_zero_area += other.n_zero_area;
        self.n_facing_away += other.n_facing_away;
        self.n_clipped += other.n_clipped;
        self.n_drawn += other.n_drawn;
    }
}

/// Appends the set-up triangles of `input` to `out`, in order; its vertices come from `placer`.
pub fn set_up<const BITS: u32>(
    placer: &Placer<BITS>,
    input: &Triangles<'_>,
    out: &mut Vec<ScreenTriangle>,
) -> SetupCounters {
    let mut counters = SetupCounters { n_in: input.triangles.len() as u64, ..Default::default() };
    for (id, triangle) in (input.first_id..).zip(input.triangles) {
        let corners = triangle.map(|i| &input.vertices[(i - input.first_vertex) as usize]);
        let [a, b, c] = corners;
        if !a.outside.and(b.outside).and(c.outside).is_empty() {
            counters.n_outside += 1;
            continue;
        }
        let cuts = a.cuts.or(b.cuts).or(c.cuts);
        let outcome = if cuts.is_empty() {
            whole([a.at, b.at, c.at], [a.depth, b.depth, c.depth], input.facing, id, out)
        } else if corners.iter().all(|corner| corner.clip.is_finite()) {
            let polygon = Polygon::triangle(&corners.map(|corner| corner.clip));
            let polygon = placer.guard.clip(polygon, cuts);
            placer.finish(polygon.corners(), input.facing, id, out)
        } else {
            counters.n_not_finite += 1;
            continue;
        };
        counters.count(outcome, !cuts.is_empty());
    }
    counters
}

/// A triangle that nothing cuts: [`Placer::finish`] for the usual case.
pub(crate) fn whole(
    [a, b, c]: [Fixed; 3],
    depth: [f64; 3],
    facing: Facing,
    id: u32,
    out: &mut Vec<ScreenTriangle>,
) -> Outcome {
    let [near_a, near_b, near_c] = depth;
    let (corners, depth) = match (doubled_area([a, b, c]).signum(), facing) {
        (0, _) => return Outcome::ZeroArea,
        (1, Facing::CounterClockwise) | (-1, Facing::Clockwise) => return Outcome::FacingAway,
        (1, _) => ([a, b, c], depth),
        _ => ([a, c, b], [near_a, near_c, near_b]),
    };
    out.push(ScreenTriangle { corners, depth, id });
    Outcome::Drawn
}

/// What became of a triangle.
pub(crate) enum Outcome {
    Drawn,
    Outside,
    ZeroArea,
    FacingAway,
}

impl<const BITS: u32> Placer<BITS> {
    /// Snaps a convex polygon, decides its facing as a whole, and fans it into triangles.
    pub(crate) fn finish(
        &self,
        polygon: &[ClipPoint],
        facing: Facing,
        id: u32,
        out: &mut Vec<ScreenTriangle>,
    ) -> Outcome {
        if polygon.len() < 3 {
            return Outcome::Outside;
        }
        let mut corners = [Fixed { x: 0, y: 0 }; 9];
        for (corner, point) in corners.iter_mut().zip(polygon) {
            *corner = self.transforms.snap::<BITS>(self.viewport, point);
        }
        let corners = &corners[..polygon.len()];
        let pieces = || (2..corners.len()).map(|i| [0, i - 1, i]);
        let area = |piece: [usize; 3]| doubled_area(piece.map(|i| corners[i]));
        let total: i128 = pieces().map(|piece| i128::from(area(piece))).sum();
        let turned = match (total.signum(), facing) {
            (0, _) => return Outcome::ZeroArea,
            (1, Facing::CounterClockwise) | (-1, Facing::Clockwise) => return Outcome::FacingAway,
            (sign, _) => sign < 0,
        };
        for piece in pieces() {
            // A piece that snapping has turned over is thinner than the grid: its samples belong to
            // its neighbours.
            let piece_area = area(piece);
            if piece_area == 0 || (piece_area < 0) != turned {
                continue;
            }
            let [a, b, c] = piece;
            let piece = if turned { [a, c, b] } else { piece };
            out.push(ScreenTriangle {
                corners: piece.map(|i| corners[i]),
                depth: piece.map(|i| self.transforms.depth(&polygon[i])),
                id,
            });
        }
        Outcome::Drawn
    }
}

/// Twice the signed area in squared subpixel units; positive is clockwise as seen (y down).
pub(crate) fn doubled_area([a, b, c]: [Fixed; 3]) -> i64 {
    (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [[f64; 2]; 4] = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];

    fn run(points: &[ClipPoint], triangles: &[[u32; 3]], facing: Facing) -> SetupCounters {
        let placer = Placer::<8>::new(Viewport::new(64, 64).unwrap(), PlaneMask::ALL);
        let vertices: Vec<Vertex> = points.iter().map(|point| placer.place(*point)).collect();
        let input =
            Triangles { vertices: &vertices, triangles, first_vertex: 0, first_id: 7, facing };
        let mut out = Vec::new();
        let counters = set_up(&placer, &input, &mut out);
        assert!(out.iter().all(|t| doubled_area(t.corners) > 0 && t.id >= 7));
        counters
    }

    fn square() -> Vec<ClipPoint> {
        SQUARE.map(|[x, y]| ClipPoint { x, y, z: 0.5, w: 1.0 }).to_vec()
    }

    #[test]
    fn facing_is_seen_from_the_screen() {
        let (ccw, cw) = ([[0, 1, 2]], [[0, 2, 1]]);
        assert_eq!(run(&square(), &ccw, Facing::CounterClockwise).n_drawn, 1);
        assert_eq!(run(&square(), &ccw, Facing::Clockwise).n_facing_away, 1);
        assert_eq!(run(&square(), &cw, Facing::CounterClockwise).n_facing_away, 1);
        assert_eq!(run(&square(), &cw, Facing::Clockwise).n_drawn, 1);
        assert_eq!(run(&square(), &cw, Facing::Both).n_drawn, 1);
    }

    #[test]
    fn what_cannot_be_drawn_is_counted() {
        let mut points = square();
        points.push(ClipPoint { x: f64::NAN, y: 0.0, z: 0.5, w: 1.0 });
        points.push(ClipPoint { x: 0.0, y: 0.0, z: f64::INFINITY, w: 1.0 });
        points.extend([2.0, 3.0, 4.0].map(|x| ClipPoint { x, y: x * x, z: 0.5, w: 1.0 }));
        let triangles = [[0, 1, 4], [0, 1, 5], [0, 1, 1], [6, 7, 8], [0, 1, 2]];
        let counters = run(&points, &triangles, Facing::Both);
        let expected = SetupCounters {
            n_in: 5,
            n_not_finite: 2,
            n_outside: 1,
            n_zero_area: 1,
            n_drawn: 1,
            ..Default::default()
        };
        assert_eq!(counters, expected);
    }

    #[test]
    fn a_triangle_through_the_eye_is_clipped_and_drawn() {
        let points = [(-1.0, -0.5, 2.0), (1.0, -0.5, 2.0), (0.0, -0.5, -3.0)]
            .map(|(x, y, w)| ClipPoint { x, y, z: 0.1, w });
        let counters = run(&points, &[[0, 1, 2]], Facing::Both);
        assert_eq!((counters.n_clipped, counters.n_drawn), (1, 1));
    }

    #[test]
    fn whole_triangles_are_finished_as_any_polygon() {
        let placer = Placer::<8>::new(Viewport::new(64, 48).unwrap(), PlaneMask::ALL);
        let points = (0..30).map(|i| {
            let x = f64::from(i * 7919 % 31) / 15.5 - 1.0;
            let y = f64::from(i * 6367 % 29) / 14.5 - 1.0;
            ClipPoint { x, y, z: 0.3 + 0.01 * f64::from(i), w: 1.0 + 0.05 * f64::from(i % 5) }
        });
        let points: Vec<ClipPoint> = points.collect();
        for corners in points.windows(3) {
            let vertices: Vec<Vertex> = corners.iter().map(|point| placer.place(*point)).collect();
            for facing in [Facing::Both, Facing::CounterClockwise, Facing::Clockwise] {
                let (mut quick, mut plain) = (Vec::new(), Vec::new());
                let (at, depth) =
                    ([0, 1, 2].map(|i| vertices[i].at), [0, 1, 2].map(|i| vertices[i].depth));
                whole(at, depth, facing, 3, &mut quick);
                placer.finish(corners, facing, 3, &mut plain);
                assert_eq!(format!("{quick:?}"), format!("{plain:?}"));
            }
        }
    }
}
