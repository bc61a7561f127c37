//! Clipping: cut off what has no place on the screen.
//!
//! Only near and far are real cuts. In x and y a triangle is left alone as long as it stays in
//! the guard band around the viewport, since coverage there is exact without a cut. Source:
//! Sutherland & Hodgman 1974, "Reentrant Polygon Clipping", in homogeneous coordinates (Blinn &
//! Newell 1978, "Clipping Using Homogeneous Coordinates").
//!
//! ```text
//!        +---------------- guard band ----------------+
//!        |         +----- viewport -----+             |
//!        |      .--|--------------------|------.      |   left alone
//!        |         +--------------------+         .---|--- ---   cut here
//!        +--------------------------------------------+
//! ```
//!
//! A cut is always computed from the inside end of an edge to its outside end, so two triangles
//! that share the edge, in either direction, get the same point to the last bit. It is computed
//! until it lies on the plane: a first step along an edge of length 1e20 ends 1e4 off.

use cullet_transform::{ClipPoint, Plane, PlaneMask, Viewport};

use crate::fixed::guard_band;

/// A triangle cut by six planes has at most nine corners.
const MAX_CORNERS: usize = 9;

/// A convex polygon in clip space, no allocation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Polygon {
    corners: [ClipPoint; MAX_CORNERS],
    len: usize,
}

impl Polygon {
    pub(crate) fn triangle(corners: &[ClipPoint; 3]) -> Self {
        let mut polygon = Polygon { corners: [corners[0]; MAX_CORNERS], len: 3 };
        polygon.corners[..3].copy_from_slice(corners);
        polygon
    }

    pub(crate) fn corners(&self) -> &[ClipPoint] {
        &self.corners[..self.len]
    }

    fn push(&mut self, corner: ClipPoint) {
        // Rounding could in theory cut a polygon once more than geometry can.
        if self.len < MAX_CORNERS {
            self.corners[self.len] = corner;
            self.len += 1;
        }
    }
}

/// Where the guard band ends, as multiples of `w`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GuardBand {
    pub(crate) x: f64,
    pub(crate) y: f64,
}

impl GuardBand {
    pub(crate) fn new(viewport: Viewport, subpixel_bits: u32) -> Self {
        let extent =
            |side: u32| 1.0 + 2.0 * f64::from(guard_band(side, subpixel_bits)) / f64::from(side);
        GuardBand { x: extent(viewport.width()), y: extent(viewport.height()) }
    }

    /// The planes among `asked` that `point` must be cut by: outside near or far, or beyond the
    /// guard band.
    pub(crate) fn cuts(&self, point: &ClipPoint, asked: PlaneMask) -> PlaneMask {
        let mut cuts = PlaneMask::NONE;
        for i in asked.iter() {
            // Written so that NaN counts as outside.
            let inside = self.inside(point, i) >= 0.0;
            if !inside {
                cuts.insert(i);
            }
        }
        cuts
    }

    /// Positive inside plane `index`, zero on it.
    fn inside(&self, p: &ClipPoint, index: usize) -> f64 {
        match Plane::ALL[index] {
            Plane::Left => p.x + self.x * p.w,
            Plane::Right => self.x * p.w - p.x,
            Plane::Bottom => p.y + self.y * p.w,
            Plane::Top => self.y * p.w - p.y,
            Plane::Near => p.w - p.z,
            Plane::Far => p.z,
        }
    }

    /// What is left of `polygon` inside the planes of `cuts`; fewer than three corners if
    /// nothing is. Near comes first: it makes `w` positive for the others.
    pub(crate) fn clip(&self, polygon: Polygon, cuts: PlaneMask) -> Polygon {
        const ORDER: [Plane; 6] =
            [Plane::Near, Plane::Far, Plane::Left, Plane::Right, Plane::Bottom, Plane::Top];
        let mut polygon = polygon;
        for plane in ORDER {
            if cuts.contains(plane.index()) {
                polygon = self.cut(&polygon, plane.index());
            }
        }
        polygon
    }

    fn cut(&self, polygon: &Polygon, plane: usize) -> Polygon {
        let mut kept = Polygon { len: 0, ..*polygon };
        for (i, corner) in polygon.corners().iter().enumerate() {
            let next = &polygon.corners()[(i + 1) % polygon.len];
            let (here, there) = (self.inside(corner, plane), self.inside(next, plane));
            if here >= 0.0 {
                kept.push(*corner);
            }
            if here >= 0.0 && there < 0.0 {
                kept.push(self.crossing(corner, next, plane));
            } else if here < 0.0 && there >= 0.0 {
                kept.push(self.crossing(next, corner, plane));
            }
        }
        kept
    }

    /// Where the edge from `inside` to `outside` crosses the plane. Rounding moves a step along
    /// the edge off the plane by an ulp of the longest coordinate, so the rest is stepped again;
    /// each step wins some 15 digits.
    fn crossing(&self, inside: &ClipPoint, outside: &ClipPoint, plane: usize) -> ClipPoint {
        let start = self.inside(inside, plane);
        let length = start - self.inside(outside, plane);
        let edge = ClipPoint {
            x: outside.x - inside.x,
            y: outside.y - inside.y,
            z: outside.z - inside.z,
            w: outside.w - inside.w,
        };
        let step = |from: &ClipPoint, t: f64| ClipPoint {
            x: from.x + edge.x * t,
            y: from.y + edge.y * t,
            z: from.z + edge.z * t,
            w: from.w + edge.w * t,
        };
        let (mut at, mut off) = (*inside, start);
        loop {
            let next = step(&at, off / length);
            let rest = self.inside(&next, plane);
            let nearer = rest.abs() < off.abs();
            if !nearer {
                return at;
            }
            (at, off) = (next, rest);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NEAR: f64 = 0.5;

    fn point(x: f64, y: f64, w: f64) -> ClipPoint {
        ClipPoint { x, y, z: NEAR, w }
    }

    fn guard() -> GuardBand {
        GuardBand::new(Viewport::new(100, 100).unwrap(), 8)
    }

    #[test]
    fn a_triangle_with_one_corner_behind_the_eye_becomes_a_quad() {
        let corners = [point(0.0, 0.0, -1.0), point(1.0, 0.0, 2.0), point(0.0, 1.0, 2.0)];
        let cuts = guard().cuts(&corners[0], PlaneMask::ALL);
        assert!(cuts.contains(Plane::Near.index()));
        let polygon = guard().clip(Polygon::triangle(&corners), cuts);
        assert_eq!(polygon.corners().len(), 4);
        assert!(polygon.corners().iter().all(|p| p.w >= NEAR));
    }

    #[test]
    fn nothing_is_left_behind_the_eye() {
        let corners = [point(0.0, 0.0, -1.0), point(1.0, 0.0, 0.0), point(0.0, 1.0, 0.25)];
        let cuts = PlaneMask::ALL;
        assert!(guard().clip(Polygon::triangle(&corners), cuts).corners().len() < 3);
    }

    #[test]
    fn cuts_of_endless_edges_lie_on_the_plane() {
        for far in [1e3, 1e9, 1e20, 1e38] {
            let corners =
                [point(-far, 1.0, far), point(far, 1.0, far), point(0.0, 1.0, -3.0 * far)];
            let polygon = guard().clip(Polygon::triangle(&corners), PlaneMask::ALL);
            let on_near = polygon.corners().iter().filter(|p| (p.w - NEAR).abs() < 1e-12).count();
            assert_eq!(on_near, 2, "{far}: {polygon:?}");
        }
    }

    #[test]
    fn both_ends_of_a_shared_edge_give_the_same_cut() {
        let (inside, outside) = (point(0.3, 0.7, 3.1), point(-0.9, 0.2, -7.7));
        let third = [point(1.0, 0.0, 2.0), point(-1.0, 0.1, 2.3)];
        let near = PlaneMask::from_bits(1 << Plane::Near.index());
        let one = guard().clip(Polygon::triangle(&[inside, outside, third[0]]), near);
        let two = guard().clip(Polygon::triangle(&[outside, inside, third[1]]), near);
        let shared = one.corners().iter().filter(|p| two.corners().contains(p)).count();
        assert_eq!(shared, 2); // the inside end and the cut
    }

    #[test]
    fn the_guard_band_leaves_wide_triangles_alone() {
        assert!(guard().cuts(&point(300.0, -300.0, 1.0), PlaneMask::ALL).is_empty());
        let cuts = guard().cuts(&point(400.0, 0.0, 1.0), PlaneMask::ALL);
        assert_eq!(cuts.iter().collect::<Vec<_>>(), [Plane::Right.index()]);
    }
}
