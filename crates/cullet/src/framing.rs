//! The automatic camera: everything in the picture, and as large as it goes.
//!
//! For a fixed direction, a point lies inside the left border of a perspective picture exactly
//! when `-x - t z <= -(ex + t ez)`-like linear inequalities hold for the eye `(ex, ey, ez)` in
//! camera axes. Over all points only the extreme one per border matters, so the closest eye that
//! sees everything follows from four maxima: no search, and no sphere around the scene.

use std::cmp::Ordering;

use cullet_cull::Aabb;
use cullet_raster::Facing;
use cullet_transform::{Camera, Projection};
use glam::{DAffine3, DVec3, Vec3};

use crate::prepared::drawable;
use crate::{Item, Prepared};

/// From the scene to the eye: a little from the right and from above.
pub const DEFAULT_DIRECTION: DVec3 = DVec3::new(0.7, 0.45, 1.0);

/// Vertical field of view of the automatic camera, radians.
const YFOV: f64 = 45.0 * std::f64::consts::PI / 180.0;

/// Share of the half picture that the scene may fill.
const FILL: f64 = 0.95;

/// The camera that frames everything from [`DEFAULT_DIRECTION`], for pictures `aspect` times as
/// wide as high; from the opposite direction if everything turns its back to the default one.
pub fn frame_scene(prepared: &Prepared, aspect: f64) -> Camera {
    let shows =
        |direction| prepared.items().iter().any(|item| shows_front(prepared, item, direction));
    let turned = !shows(DEFAULT_DIRECTION) && shows(-DEFAULT_DIRECTION);
    frame_direction(prepared, aspect, if turned { -DEFAULT_DIRECTION } else { DEFAULT_DIRECTION })
}

/// Whether some face of `item` that is drawn looks towards `direction`.
fn shows_front(prepared: &Prepared, item: &Item, direction: DVec3) -> bool {
    let sign = match item.facing {
        Facing::Both => return item.n_triangles > 0,
        Facing::CounterClockwise => 1.0,
        Facing::Clockwise => -1.0,
    };
    let matrix = item.world_from_model.matrix3;
    drawable(prepared.mesh(item)).any(|corners| {
        let [a, b, c] = corners.map(|p| matrix * p.as_dvec3());
        (b - a).cross(c - a).dot(direction) * sign > 0.0
    })
}

/// The camera that frames everything, looking against `direction` (world space, any length but
/// 0). A scene with nothing to draw gets a camera at distance 1 from the origin.
pub fn frame_direction(prepared: &Prepared, aspect: f64, direction: DVec3) -> Camera {
    let lens = |near| Projection::Perspective { yfov: YFOV, near, far: f64::INFINITY };
    let up = if direction.cross(DVec3::Y).length() > 1e-6 * direction.length() {
        DVec3::Y
    } else {
        DVec3::NEG_Z
    };
    let looking = |eye: DVec3, near| Camera::look_at(eye, eye - direction, up, lens(near));
    let default = || {
        let lens = lens(0.01);
        let eye = DEFAULT_DIRECTION.normalize();
        Camera::look_at(eye, DVec3::ZERO, DVec3::Y, lens)
            .unwrap_or_else(|_| unreachable!("the default camera is a possible one"))
    };
    let Ok(axes) = looking(DVec3::ZERO, 1.0) else { return default() };
    let tangent_y = libm::tan(0.5 * YFOV) * FILL;
    let tangent_x = tangent_y * aspect;
    let bounds = prepared.bounds();
    if bounds.is_empty() || bounds.is_nan() {
        return default();
    }

    // Everything is measured from the middle of the scene, which keeps digits far from the origin.
    let middle = bounds.center();
    let middle = if middle.is_finite() { middle } else { DVec3::ZERO };
    let (right, up, back) = (axes.right(), axes.up(), axes.back());
    let normals = [
        right + back * tangent_x,
        -right + back * tangent_x,
        up + back * tangent_y,
        -up + back * tangent_y,
        back,
    ];
    let [r, l, t, b, front] = extremes(prepared, middle, normals);
    let distance_x = (r + l) / (2.0 * tangent_x);
    let distance_y = (t + b) / (2.0 * tangent_y);
    let size = r + l + t + b;
    if !size.is_finite() {
        return default();
    }
    let mut distance = if distance_x > distance_y { distance_x } else { distance_y };
    // A scene without width (a point, or an edge seen end on) still gets some room.
    let closest = front + if size > 0.0 { 0.02 * size } else { 1.0 };
    distance = if distance > closest { distance } else { closest };
    let eye = middle + right * (0.5 * (r - l)) + up * (0.5 * (t - b)) + back * distance;
    let near = 0.9 * (distance - front);
    looking(eye, near).unwrap_or_else(|_| default())
}

/// The largest dot product of any drawn vertex (relative to `origin`) with each normal. Objects and clusters
/// whose boxes cannot beat what is known are not looked into.
fn extremes(prepared: &Prepared, origin: DVec3, normals: [DVec3; 5]) -> [f64; 5] {
    let mut largest = [f64::NEG_INFINITY; 5];
    for (i, item) in prepared.items().iter().enumerate() {
        let Item { bounds, world_from_model, .. } = item;
        let may_win = normals.iter().zip(&largest).any(|(normal, largest)| {
            may_exceed((bounds.farthest_along(*normal) - origin).dot(*normal), *largest)
        });
        if !may_win {
            continue;
        }
        let clusters = prepared.clusters(i);
        for (j, cluster) in clusters.list().iter().enumerate() {
            let may_win = normals.iter().zip(&largest).any(|(normal, largest)| {
                may_exceed(reach(world_from_model, &cluster.bounds, origin, *normal), *largest)
            });
            if !may_win {
                continue;
            }
            let [x, y, z] = clusters.geometry(j).positions;
            for ((x, y), z) in x.iter().zip(y).zip(z) {
                let point = Vec3::new(*x, *y, *z).as_dvec3();
                let point = world_from_model.transform_point3(point) - origin;
                for (largest, normal) in largest.iter_mut().zip(&normals) {
                    let reach = point.dot(*normal);
                    if reach > *largest {
                        *largest = reach;
                    }
                }
            }
        }
    }
    largest
}

/// At least the largest dot product of a point of a box in model space (relative to `origin`) with a normal.
fn reach(world_from_model: &DAffine3, bounds: &Aabb, origin: DVec3, normal: DVec3) -> f64 {
    let DAffine3 { matrix3, translation } = world_from_model;
    let corner = bounds.farthest_along(matrix3.transpose() * normal);
    let reach = (world_from_model.transform_point3(corner) - origin).dot(normal);
    // Far more than all roundings together, here and of the points.
    let terms = matrix3.abs() * bounds.min.abs().max(bounds.max.abs()) + translation.abs();
    reach + 1e-12 * (terms + origin.abs()).dot(normal.abs())
}

/// Anything but a sure loss: NaN too.
fn may_exceed(reach: f64, largest: f64) -> bool {
    !matches!(reach.partial_cmp(&largest), Some(Ordering::Less))
}

#[cfg(test)]
mod tests {
    use cullet_scene::synth::synth;

    use super::*;

    /// [`extremes`] of every corner of every triangle.
    fn plainly(prepared: &Prepared, origin: DVec3, normals: [DVec3; 5]) -> [f64; 5] {
        normals.map(|normal| {
            let corners = prepared.items().iter().flat_map(|item| {
                drawable(prepared.mesh(item)).flatten().map(|corner| {
                    item.world_from_model.transform_point3(corner.as_dvec3()) - origin
                })
            });
            corners.map(|point| point.dot(normal)).fold(f64::NEG_INFINITY, f64::max)
        })
    }

    #[test]
    fn boxes_that_cannot_win_hide_nothing() {
        let away = DAffine3::from_translation(DVec3::new(1e9, -3e8, 1e7));
        let turned =
            DAffine3::from_rotation_y(0.3) * DAffine3::from_scale(DVec3::new(-2.0, 0.1, 7.0));
        for name in ["showpiece", "city", "knots", "masks", "sphere:100", "extreme:not-a-number"] {
            let scene = synth(name).unwrap();
            for place in [DAffine3::IDENTITY, away, turned, away * turned] {
                let mut scene = scene.clone();
                for object in &mut scene.objects {
                    object.world_from_model = place * object.world_from_model;
                }
                let prepared = Prepared::new(scene).unwrap();
                for origin in [prepared.bounds().center(), DVec3::ZERO, DVec3::new(-1e6, 5.0, 0.0)]
                {
                    for direction in [DEFAULT_DIRECTION, DVec3::X, DVec3::NEG_ONE] {
                        let side = direction.any_orthogonal_vector();
                        let normals = [direction, side, -side, side + direction, DVec3::Z];
                        let own = extremes(&prepared, origin, normals);
                        assert_eq!(own, plainly(&prepared, origin, normals), "{name} {place:?}");
                    }
                }
            }
        }
    }
}
