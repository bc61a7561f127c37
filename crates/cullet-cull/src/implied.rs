//! Planes that follow from the six of a frustum.
//!
//! A sum of inequalities with weights that are not negative is another that holds wherever
//! they hold (Farkas 1902). Choose the weights so that one coordinate drops out, and the sum of
//! two planes is the plane through the frustum's edge parallel to that axis: it has the
//! edge's and the axis' cross product for a normal. Three planes and two coordinates:
//! the plane through a corner and across an axis. These, with the six themselves, are all the
//! separating axes of box and frustum, each taken from the one side that can separate, without a
//! cross product, a projection or a corner.
//!
//! A view volume is a slice of a four-dimensional cone over a cube, whatever the matrix: so its
//! edges lie between neighbouring faces of the cube, 12 at most, and its corners
//! between three, 8 at most; also where oblique projections tear it open. A matrix without inverse
//! flattens the cone, and needs no other planes: its rows depend on each other, so weights on
//! opposite faces can be exchanged for equal ones until one of the two is zero.
//!
//! Rows are `[x, y, z, offset]`, positive inside, in the order of `PlaneMask`.

use core::array::from_fn;
use core::cmp::Ordering::{Equal, Greater, Less};

use glam::{DVec3, DVec4};

use crate::number::{Interval, Number};

/// `a x + b y + c z + d`.
pub(crate) type Row<N> = [N; 4];

/// The planes of a corner, in the numbering of `Frustum::corners`.
pub(crate) fn planes_of_corner(corner: usize) -> [usize; 3] {
    [corner & 1, 2 + (corner >> 1 & 1), 4 + (corner >> 2)]
}

/// All planes through an edge and parallel to an axis: their coefficient there is exactly zero.
///
/// Where a sign is not known the edge gives no plane; one of the two faces then is
/// parallel to the axis up to rounding, and says nearly the same.
pub(crate) fn edge_planes<N: Number>(planes: &[Row<N>; 6]) -> impl Iterator<Item = Row<N>> {
    let pairs =
        (0..6).flat_map(|i| (i + 1..6).map(move |j| (i, j))).filter(|(i, j)| i / 2 != j / 2);
    pairs.flat_map(|(i, j)| (0..3).map(move |axis| (i, j, axis))).filter_map(|(i, j, axis)| {
        let (a, b) = (&planes[i][axis], &planes[j][axis]);
        let (of_i, of_j) = match (a.sign()?, b.sign()?) {
            (Greater, Less) => (b.negated(), a.clone()),
            (Less, Greater) => (b.clone(), a.negated()),
            _ => return None,
        };
        Some(from_fn(|c| {
            if c == axis {
                return N::zero();
            }
            planes[i][c].times(&of_i).plus(&planes[j][c].times(&of_j))
        }))
    })
}

/// All planes through a corner and across an axis: two of their coefficients are exactly zero.
pub(crate) fn corner_planes<N: Number>(planes: &[Row<N>; 6]) -> impl Iterator<Item = Row<N>> {
    (0..8).flat_map(|corner| (0..3).map(move |axis| (corner, axis))).filter_map(|(corner, axis)| {
        let rows = planes_of_corner(corner).map(|p| &planes[p]);
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let weights: [N; 3] = from_fn(|i| minor(rows[(i + 1) % 3], rows[(i + 2) % 3], u, v));
        let signs = [weights[0].sign()?, weights[1].sign()?, weights[2].sign()?];
        let negative = signs.contains(&Less);
        if signs == [Equal; 3] || negative && signs.contains(&Greater) {
            return None;
        }
        Some(from_fn(|c| {
            if c == u || c == v {
                return N::zero();
            }
            let sum = (0..3).fold(N::zero(), |sum, i| sum.plus(&rows[i][c].times(&weights[i])));
            if negative { sum.negated() } else { sum }
        }))
    })
}

/// Where three planes meet, as `[x, y, z, w]` on that side of zero on which the opposite
/// planes are positive: a point for `w > 0`, a direction for `w = 0`, and for `w < 0` a corner that
/// lies beyond infinity. `None` if they do not meet in one.
pub(crate) fn corner<N: Number>(planes: &[Row<N>; 6], corner: usize) -> Option<Row<N>> {
    let meeting = meeting(planes_of_corner(corner).map(|p| &planes[p]));
    let opposite = &planes[planes_of_corner(!corner & 7)[0]];
    match at(opposite, &meeting).sign()? {
        Greater => Some(meeting),
        Equal => None,
        Less => Some(meeting.map(|x| x.negated())),
    }
}

/// All corners of a frustum whose planes are any within the intervals, if every choice of these
/// has them where a frustum does: each certainly inside the three planes that do not make it, and
/// certainly a point or a direction.
///
/// Then no choice has any other corner, and all of the volume lies between these: in the cone over
/// it, an edge leads from each corner away from each of its planes, and ends at the corner that has
/// the opposite plane instead, since that one is in the cone and on the same edge. So the eight are
/// joined to no others, but the corners of a convex body are all joined (Balinski 1961).
pub(crate) fn all_corners(planes: &[Row<Interval>; 6]) -> Option<[Row<Interval>; 8]> {
    let mut corners = [[Interval::zero(); 4]; 8];
    for (i, place) in corners.iter_mut().enumerate() {
        let meeting = meeting(planes_of_corner(i).map(|p| &planes[p]));
        let opposite = planes_of_corner(!i & 7).map(|p| at(&planes[p], &meeting).sign());
        *place = match opposite {
            [Some(Greater), Some(Greater), Some(Greater)] => meeting,
            [Some(Less), Some(Less), Some(Less)] => meeting.map(|n| n.negated()),
            _ => return None,
        };
        if !matches!(place[3].sign(), Some(Greater | Equal)) {
            return None;
        }
    }
    Some(corners)
}

/// A corner with `w` at 1, 0 or -1, and what its coordinates may be off by, scene units.
pub(crate) fn rounded([x, y, z, w]: Row<Interval>) -> (DVec4, DVec3) {
    let v = [x, y, z];
    match w.sign() {
        Some(Equal) => {
            (DVec4::new(x.value, y.value, z.value, 0.0), DVec3::from_array(v.map(|n| n.error)))
        }
        Some(Greater) => {
            let at = |n: &Interval| n.value / w.value;
            let error = |n: &Interval| {
                let off = (n.error + at(n).abs() * w.error) / (w.value - w.error);
                2.0 * off + f64::EPSILON * at(n).abs()
            };
            (DVec4::new(at(&x), at(&y), at(&z), 1.0), DVec3::from_array(v.each_ref().map(error)))
        }
        Some(Less) | None => (DVec3::ZERO.extend(-1.0), DVec3::ZERO),
    }
}

/// Where three planes meet, on either side of zero; all zero if they share a line.
pub(crate) fn meeting<N: Number>([a, b, c]: [&Row<N>; 3]) -> Row<N> {
    let cofactor = |[u, v, w]: [usize; 3]| {
        a[u].times(&minor(b, c, v, w))
            .plus(&a[v].times(&minor(b, c, w, u)))
            .plus(&a[w].times(&minor(b, c, u, v)))
    };
    [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]].map(cofactor)
}

/// The value of a plane at `[x, y, z, w]`.
pub(crate) fn at<N: Number>(plane: &Row<N>, point: &Row<N>) -> N {
    (0..4).fold(N::zero(), |sum, i| sum.plus(&plane[i].times(&point[i])))
}

fn minor<N: Number>(a: &Row<N>, b: &Row<N>, u: usize, v: usize) -> N {
    a[u].times(&b[v]).plus(&a[v].times(&b[u]).negated())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::Expansion;

    /// 90 degrees both ways down -z, near 1, far 4.
    fn pyramid<N>(number: impl Fn(f64) -> N) -> [Row<N>; 6] {
        [
            [1.0, 0.0, -1.0, 0.0],
            [-1.0, 0.0, -1.0, 0.0],
            [0.0, 1.0, -1.0, 0.0],
            [0.0, -1.0, -1.0, 0.0],
            [0.0, 0.0, -1.0, -1.0],
            [0.0, 0.0, 1.0, 4.0],
        ]
        .map(|row| row.map(&number))
    }

    #[test]
    fn corners_are_where_they_should_be() {
        let planes = pyramid(|x| Expansion::from_sum([x]));
        for i in 0..8 {
            let at = corner(&planes, i).expect("a corner").map(|n| n.value());
            let depth = if i & 4 == 0 { 1.0 } else { 4.0 };
            let [x, y] = [1, 2].map(|bit| if i & bit == 0 { -depth } else { depth });
            assert_eq!(at.map(|n| n / at[3]), [x, y, -depth, 1.0]);
            assert!(at[3] > 0.0);
        }
    }

    #[test]
    fn implied_planes_hold_at_every_corner_and_touch_some() {
        let planes = pyramid(|value| Interval { value, error: 0.0 });
        let corners: Vec<_> = (0..8).map(|i| corner(&planes, i).expect("a corner")).collect();
        let (edges, axes) = (edge_planes(&planes).count(), corner_planes(&planes).count());
        assert!(edges > 0 && axes >= 6);
        for plane in edge_planes(&planes).chain(corner_planes(&planes)) {
            let distances = corners
                .iter()
                .map(|corner| (0..4).map(|c| plane[c].value * corner[c].value).sum::<f64>());
            assert_eq!(distances.fold(f64::INFINITY, f64::min), 0.0);
        }
    }
}
