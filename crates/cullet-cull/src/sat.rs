//! Box against frustum, exactly: every separating axis.
//!
//! Two convex polyhedra miss each other if and only if some plane lies between them, and
//! then there is one that is a face of either or holds an edge of both (Gottschalk, Lin and
//! Manocha, "OBBTree", SIGGRAPH 1996; for frusta Assarsson and Möller 2000): 3 axes of the
//! box, 5 normals of a symmetric frustum, 3 x 6 products of edges make 26 for a camera,
//! and 3 x 12 products 45 for a matrix, whose rounding makes no two edges parallel.
//!
//! All of them are found beforehand, per frustum, as [`implied`](crate::implied) planes. What
//! is left is the p-vertex test with some thirty planes instead of six.
//!
//! **How exact.** Derived planes carry their error, so exclusion is proof. A frustum from a
//! matrix is what its numbers say: where rounding leaves a box in doubt, the deciding sum is
//! evaluated without rounding, and the verdict is exact, touching included. (Entries and
//! coordinates beyond 2^±216 of each other are left in doubt.) A camera's frustum has square
//! roots and tangents in it: there a box in doubt is kept, which happens only within
//! [`ROUNDING`](crate::ROUNDING) of the sum of the sizes of the deciding terms, and where a
//! box without end runs along a face that is parallel to it up to rounding.

use alloc::vec::Vec;
use core::cmp::Ordering::{Equal, Less};

use glam::DVec3;

use crate::halfspace::{EVALUATION, Halfspace};
use crate::implied::{Row, corner_planes, edge_planes};
use crate::matrix::exact_range;
use crate::number::{Expansion, Interval, Number};
use crate::{Aabb, Frustum, Plane, PlaneMask, ROUNDING, Visibility, planes_cutting};

/// A frustum made ready for the exact test.
///
/// ```
/// use cullet_cull::{Aabb, Frustum, Sat, Visibility};
/// # use cullet_transform::{Camera, Projection};
/// # use glam::DVec3;
/// # let lens = Projection::Perspective { yfov: 1.0, near: 0.1, far: 100.0 };
/// # let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, lens)?;
/// let frustum = Frustum::from_camera(&camera, 1.0);
/// let sat = Sat::new(&frustum);
/// let cube = |z: f64| Aabb { min: DVec3::new(-1.0, -1.0, z), max: DVec3::new(1.0, 1.0, z + 2.0) };
/// assert_eq!(sat.classify(&cube(-9.0)), Visibility::Inside);
/// assert_eq!(sat.classify(&cube(-1.0)), Visibility::Crossing);
/// assert_eq!(sat.classify(&cube(9.0)), Visibility::Outside);
/// # Ok::<(), cullet_transform::CameraError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Sat {
    frustum: Frustum,
    halfspaces: Vec<Halfspace>,
    /// What the half-spaces were rounded from, one each, or none at all.
    exact: Vec<Row<Expansion>>,
}

impl Sat {
    /// Derives the planes: a microsecond or two, some hundred for a frustum from a matrix.
    pub fn new(frustum: &Frustum) -> Sat {
        let rows = frustum.exact.filter(|_| {
            // Moved planes and moved boxes are no longer what the matrix says.
            frustum.slack == ROUNDING && frustum.origin == DVec3::ZERO
        });
        let Some(rows) = rows else {
            let faces = (0..6).map(|i| frustum.halfspace(i));
            let rows = frustum.rows();
            let edges = edge_planes(&rows).map(|row| uncertain(&row));
            return Sat {
                frustum: *frustum,
                halfspaces: faces.chain(edges).collect(),
                exact: Vec::new(),
            };
        };
        let planes = rows.planes();
        let implied = edge_planes(&planes).chain(corner_planes(&planes));
        let exact: Vec<Row<Expansion>> = planes.clone().into_iter().chain(implied).collect();
        Sat { frustum: *frustum, halfspaces: exact.iter().map(correct).collect(), exact }
    }

    /// The frustum.
    pub fn frustum(&self) -> &Frustum {
        &self.frustum
    }

    /// Whether `bounds` shares a point with the frustum. NaN: true; empty: false.
    pub fn visible(&self, bounds: &Aabb) -> bool {
        if let Some(verdict) = bounds.undisputed() {
            return verdict;
        }
        let bounds = bounds.relative_to(self.frustum.origin);
        if !bounds.overlaps(&self.frustum.bounds())
            || self.halfspaces.iter().any(|halfspace| halfspace.excludes(&bounds))
        {
            return false;
        }
        !self.exact.iter().zip(&self.halfspaces).any(|(row, halfspace)| {
            let certainly_not = halfspace.reached(&bounds) >= 0.0; // false for NaN
            !certainly_not && excludes(row, &bounds)
        })
    }

    /// Where `bounds` lies. NaN bounds cross.
    pub fn classify(&self, bounds: &Aabb) -> Visibility {
        if !self.visible(bounds) {
            return Visibility::Outside;
        }
        match planes_cutting(bounds, &self.frustum, PlaneMask::ALL) {
            Some(PlaneMask::NONE) => Visibility::Inside,
            _ => Visibility::Crossing,
        }
    }
}

fn uncertain(row: &Row<Interval>) -> Halfspace {
    let error = row.each_ref().map(|n| n.error + EVALUATION * (n.value.abs() + n.error));
    Halfspace { plane: plane(row.each_ref().map(|n| n.value)), error: plane(error) }
}

fn correct(row: &Row<Expansion>) -> Halfspace {
    Halfspace::from(plane(row.each_ref().map(Expansion::value)))
}

fn plane([x, y, z, offset]: [f64; 4]) -> Plane {
    Plane { normal: DVec3::new(x, y, z), offset }
}

/// Whether all of `bounds` is behind the plane, without rounding; no, if that is beyond reach.
fn excludes(row: &Row<Expansion>, bounds: &Aabb) -> bool {
    let [normal @ .., offset] = row;
    let mut sum = offset.clone();
    for (axis, along) in normal.iter().enumerate() {
        let farthest = match along.sign() {
            Some(Equal) => continue,
            Some(Less) => bounds.min[axis],
            _ => bounds.max[axis],
        };
        if !exact_range(farthest) {
            return false;
        }
        sum = sum.plus(&along.scaled(farthest));
    }
    sum.sign() == Some(Less)
}
