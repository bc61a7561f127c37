//! Which triangles make up a polygon? Ear clipping in the plane of the polygon.
//!
//! The polygon is looked at along its Newell normal, which is robust against corners that
//! are collinear or not quite in one plane. Then corners are cut off one at a time: a
//! corner is an ear when it turns left and no other corner lies in its triangle. Polygons
//! without ears (degenerate, self-crossing) are fanned, so `n` corners always give `n - 2`
//! triangles, in O(n^2) for ordinary ones.
//!
//! Space: positions in model space; the triangles keep the winding of the polygon.
//! Source: Meisters, "Polygons Have Ears", 1975; Sutherland, Sproull and Schumacker,
//! "A Characterization of Ten Hidden-Surface Algorithms", 1974, for Newell's normal.

use glam::{DVec2, DVec3, Vec3, Vec3Swizzles};

/// Polygons with more corners are fanned from their first one: made with malice, they could
/// keep the clipping busy for O(n^3).
const MAX_CORNERS: usize = 1024;

/// Calls `emit` for each of the `corners.len() - 2` triangles, as indices into `corners`.
///
/// Convex polygons become fans around corner 0. Positions that are not finite are no
/// error: the triangles are there, and whoever draws them drops the bad ones.
pub(super) fn triangulate(corners: &[Vec3], mut emit: impl FnMut([usize; 3])) {
    let n = corners.len();
    let flat = project(corners);
    if n <= 3 || n > MAX_CORNERS || is_convex(&flat) {
        for i in 2..n {
            emit([0, i - 1, i]);
        }
        return;
    }
    let mut left: Vec<usize> = (0..n).collect();
    let mut at = 0; // where to look next: beside the last cut, which spreads the triangles
    while left.len() > 3 {
        let m = left.len();
        let around = |i: usize| [left[(i + m - 1) % m], left[i % m], left[(i + 1) % m]];
        let Some(ear) = (at..at + m).find(|i| is_ear(&flat, &left, around(*i))) else { break };
        emit(around(ear));
        left.remove(ear % m);
        at = ear % m % left.len();
    }
    for pair in left[1..].windows(2) {
        emit([left[0], pair[0], pair[1]]);
    }
}

/// Twice the area vector; points to where the polygon runs counter-clockwise.
fn newell_normal(corners: &[Vec3]) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for (i, corner) in corners.iter().enumerate() {
        // Relative to the first corner, so that far polygons keep their precision.
        let a = (*corner - corners[0]).as_dvec3();
        let b = (corners[(i + 1) % corners.len()] - corners[0]).as_dvec3();
        sum += (a - b).yzx() * (a + b).zxy();
    }
    sum
}

/// The corners in a plane in which the polygon runs counter-clockwise: the axis that the
/// normal leans to most is left out.
fn project(corners: &[Vec3]) -> Vec<DVec2> {
    let normal = newell_normal(corners);
    let size = normal.abs();
    let origin = corners.first().copied().unwrap_or_default();
    let view = |point: &Vec3| {
        let p = (*point - origin).as_dvec3();
        if size.z >= size.x && size.z >= size.y {
            DVec2::new(p.x * normal.z.signum(), p.y)
        } else if size.y >= size.x {
            DVec2::new(p.z * normal.y.signum(), p.x)
        } else {
            DVec2::new(p.y * normal.x.signum(), p.z)
        }
    };
    corners.iter().map(view).collect()
}

/// Turns left everywhere and goes around once. Straight corners do not count as convex: a
/// fan would make a triangle without area of them while another cut needs none.
fn is_convex(flat: &[DVec2]) -> bool {
    let n = flat.len();
    let turns_left = |i: usize| turn(flat[i], flat[(i + 1) % n], flat[(i + 2) % n]) > 0.0;
    let visible_from_first = |i: usize| turn(flat[0], flat[i], flat[i + 1]) > 0.0;
    (0..n).all(turns_left) && (1..n - 1).all(visible_from_first)
}

fn is_ear(flat: &[DVec2], left: &[usize], corners: [usize; 3]) -> bool {
    let [a, b, c] = corners.map(|i| flat[i]);
    if turn(a, b, c) <= 0.0 {
        return false;
    }
    left.iter().filter(|i| !corners.contains(i)).all(|i| {
        let p = flat[*i];
        // A copy of a corner (where a hole is tied to the outline) does not block the ear.
        let copy = p == a || p == b || p == c;
        copy || turn(a, b, p) < 0.0 || turn(b, c, p) < 0.0 || turn(c, a, p) < 0.0
    })
}

/// Twice the area of a triangle, positive when it is counter-clockwise.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that the triangles of a polygon in the plane z = 0 add up to its area without
    /// overlap, seen from both sides and in each main plane.
    #[track_caller]
    fn check(outline: &[[f32; 2]]) {
        let swizzles: [fn(f32, f32) -> Vec3; 3] =
            [|x, y| Vec3::new(x, y, 0.0), |x, y| Vec3::new(0.0, x, y), |x, y| Vec3::new(y, 7e3, x)];
        for place in swizzles {
            let forth: Vec<Vec3> = outline.iter().map(|[x, y]| place(*x, *y)).collect();
            let back: Vec<Vec3> = forth.iter().rev().copied().collect();
            for corners in [forth, back] {
                let normal = newell_normal(&corners);
                let mut area = 0.0;
                let mut n_triangles = 0;
                triangulate(&corners, |triangle| {
                    let [a, b, c] = triangle.map(|i| corners[i].as_dvec3());
                    let part = (b - a).cross(c - a).dot(normal.normalize());
                    assert!(part >= -1e-9, "{triangle:?} is flipped");
                    area += part;
                    n_triangles += 1;
                });
                assert_eq!(n_triangles, corners.len() - 2);
                assert!((area - normal.length()).abs() < 1e-6 * area.max(1.0), "{area}");
            }
        }
    }

    #[test]
    fn convex_polygons() {
        check(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
        check(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]]);
        check(&[[0.0, 0.0], [2.0, 0.0], [3.0, 2.0], [1.0, 3.0], [-1.0, 1.0]]);
    }

    #[test]
    fn concave_polygons() {
        check(&[[0.0, 0.0], [2.0, 0.0], [0.5, 0.5], [0.0, 2.0]]);
        check(&[[0.5, 0.5], [0.0, 2.0], [0.0, 0.0], [2.0, 0.0]]);
        check(&[
            [0.0, 0.0],
            [3.0, 0.0],
            [3.0, 3.0],
            [2.0, 3.0],
            [2.0, 1.0],
            [1.0, 1.0],
            [1.0, 3.0],
            [0.0, 3.0],
        ]);
        check(&[
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 4.0],
            [3.0, 1.0],
            [2.0, 4.0],
            [1.0, 1.0],
            [0.0, 4.0],
        ]);
    }

    #[test]
    fn straight_and_repeated_corners() {
        check(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 2.0], [0.0, 2.0]]);
        check(&[[0.0, 0.0], [2.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]);
    }

    #[test]
    fn a_hole_tied_to_the_outline() {
        let outer = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0], [0.0, 0.0]];
        let hole = [[1.0, 1.0], [1.0, 3.0], [3.0, 3.0], [3.0, 1.0], [1.0, 1.0]];
        check(&[&outer[..], &hole[..]].concat());
    }

    #[test]
    fn degenerate_polygons_end_with_as_many_triangles() {
        let point = Vec3::ONE;
        let line: Vec<Vec3> = (0..9).map(|i| i as f32 * Vec3::X).collect();
        let bow_tie =
            [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
        let broken = [Vec3::NAN, Vec3::X, Vec3::Y, Vec3::INFINITY, Vec3::Z];
        let huge = [Vec3::ZERO, Vec3::X * 3e38, Vec3::ONE * 1e38, Vec3::Y * 3e38, -Vec3::X];
        for corners in [&[point; 6][..], &line, &bow_tie, &broken, &huge, &vec![point; 5000]] {
            let mut n_triangles = 0;
            triangulate(corners, |_| n_triangles += 1);
            assert_eq!(n_triangles, corners.len() - 2);
        }
        triangulate(&[], |_| unreachable!("nothing has no triangles"));
    }
}
