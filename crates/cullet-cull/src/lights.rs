//! Which lights reach what is seen.
//!
//! A light that falls to zero at its range (see `Cone` and `Sphere`) changes nothing beyond it,
//! so lists of lights may be cut down by range without changing a pixel: by
//! [`light_visible`] for a whole view, by [`Clusters`] for tiles of the picture, cut into slices
//! of depth.
//!
//! A cluster is a small frustum. Its four sides and two ends are shared with its neighbours,
//! so a light is asked once per column, row and slice of the grid, and only where all three
//! keep it once more per cluster, against the cluster's own box: planes first, then the
//! reverse test, for the price of a few comparisons.
//!
//! Source: Olsson, Billeter and Assarsson, "Clustered Deferred and Forward Shading", HPG 2012.

use alloc::vec;
use alloc::vec::Vec;

use cullet_transform::Window;
use glam::{DMat3, DVec3};

use crate::{Aabb, Cone, Frustum, Overlap, Sphere, overlap_cone, overlap_sphere, sphere_visible};

/// Where a light ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightRange {
    /// A point light.
    Ball(Sphere),
    /// A spot light.
    Cone(Cone),
}

/// Whether `light` may reach into `frustum` (both in one space). Never false where it does.
/// NaN: true; an empty range: false.
pub fn light_visible(light: &LightRange, frustum: &Frustum) -> bool {
    in_planes(light, frustum) && reaches(light, frustum.origin, &frustum.bounds())
}

/// Whether no plane has all of `cone` behind it.
///
/// Of all points of a cone, one that its axis is turned from the plane's normal towards as far
/// as the opening allows comes closest.
fn cone_in_planes(cone: &Cone, frustum: &Frustum) -> bool {
    const ROUNDING: f64 = 32.0 * f64::EPSILON;
    let apex = cone.apex - frustum.origin;
    let apex = Aabb { min: apex, max: apex };
    let (sin, cos) = libm::sincos(cone.half_angle);
    (0..6).all(|i| {
        let normal = frustum.planes[i].normal;
        let along = normal.dot(cone.direction);
        let across = libm::sqrt(normal.cross(cone.direction).length_squared());
        // Cosine of the angle that remains between the normal and the cone.
        let facing = if along >= cos { 1.0 } else { along * cos + across * sin };
        let doubt = ROUNDING + frustum.errors[i].normal.element_sum();
        let reach = if facing < -doubt { 0.0 } else { cone.range * (facing.max(0.0) + doubt) };
        let behind = frustum.farthest(i, &apex) + reach < 0.0;
        !behind
    })
}

fn in_planes(light: &LightRange, frustum: &Frustum) -> bool {
    match light {
        LightRange::Cone(cone) if is_nan(cone) => true,
        LightRange::Ball(sphere) => sphere_visible(sphere, frustum),
        LightRange::Cone(cone) => cone_in_planes(cone, frustum),
    }
}

fn is_nan(cone: &Cone) -> bool {
    let vectors = cone.apex.is_nan() || cone.direction.is_nan();
    vectors || cone.half_angle.is_nan() || cone.range.is_nan()
}

/// Whether `light` may reach into `bounds`, which count from `origin`.
fn reaches(light: &LightRange, origin: DVec3, bounds: &Aabb) -> bool {
    // Moving the light rounds, which moving the faces of the box makes up for.
    let room = |at: DVec3| bounds.grown(2.0 * f64::EPSILON * at.abs().max_element());
    let overlap = match *light {
        LightRange::Ball(sphere) => {
            let center = sphere.center - origin;
            overlap_sphere(&Sphere { center, ..sphere }, &room(center))
        }
        LightRange::Cone(cone) => {
            let apex = cone.apex - origin;
            overlap_cone(&Cone { apex, ..cone }, &room(apex))
        }
    };
    overlap != Overlap::Outside
}

/// A view cut into columns, rows and slices of depth.
///
/// ```
/// use cullet_cull::{Clusters, LightRange, Sphere, slice_depths};
/// # use cullet_transform::{Camera, Projection};
/// # use glam::{DMat3, DVec3};
/// # let lens = Projection::Perspective { yfov: 1.0, near: 0.1, far: 100.0 };
/// # let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, lens)?;
/// let axes = DMat3::from_cols(camera.right(), camera.up(), camera.back());
/// let depths = slice_depths(0.1, 100.0, 8);
/// let clusters = Clusters::new(camera.eye(), &axes, &camera.window(1.5), (12, 8), &depths);
/// let lamp = LightRange::Ball(Sphere { center: DVec3::new(0.0, 0.0, -50.0), radius: 1.0 });
/// let lists = clusters.assign(&[lamp]);
/// let n_lit = (0..clusters.len()).filter(|&cluster| lists.of(cluster) == [0]).count();
/// assert!(n_lit > 0 && n_lit < 20); // of 768
/// # Ok::<(), cullet_transform::CameraError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Clusters {
    columns: Vec<Frustum>,
    rows: Vec<Frustum>,
    slices: Vec<Frustum>,
    /// Per cluster, counted from the eye.
    bounds: Vec<Aabb>,
}

impl Clusters {
    /// The window of [`Frustum::from_window`] in `n_columns` by `n_rows` equal tiles and a slice
    /// between each two neighbours of `depths`, which ascend (see [`slice_depths`]); one slice
    /// from near to far makes plain tiles. The window's own near and far do not count.
    pub fn new(
        eye: DVec3,
        world_from_view: &DMat3,
        window: &Window,
        (n_columns, n_rows): (usize, usize),
        depths: &[f64],
    ) -> Clusters {
        let (Some(&near), Some(&far)) = (depths.first(), depths.last()) else {
            return Clusters { columns: vec![], rows: vec![], slices: vec![], bounds: vec![] };
        };
        let all = Window { near, far, ..*window };
        let step = |from: f64, to: f64, i: usize, n: usize| {
            if i == n { to } else { from + (to - from) * (i as f64 / n as f64) }
        };
        let column = |window: &Window, i: usize| Window {
            left: step(all.left, all.right, i, n_columns),
            right: step(all.left, all.right, i + 1, n_columns),
            ..*window
        };
        let row = |window: &Window, i: usize| Window {
            top: step(all.top, all.bottom, i, n_rows),
            bottom: step(all.top, all.bottom, i + 1, n_rows),
            ..*window
        };
        let slice =
            |window: &Window, depths: &[f64]| Window { near: depths[0], far: depths[1], ..*window };
        let frustum = |window: Window| Frustum::from_window(eye, world_from_view, &window);
        let mut bounds = Vec::with_capacity(n_columns * n_rows * (depths.len() - 1));
        for depths in depths.windows(2) {
            for y in 0..n_rows {
                for x in 0..n_columns {
                    let cluster = slice(&row(&column(&all, x), y), depths);
                    bounds.push(frustum(cluster).bounds());
                }
            }
        }
        Clusters {
            columns: (0..n_columns).map(|i| frustum(column(&all, i))).collect(),
            rows: (0..n_rows).map(|i| frustum(row(&all, i))).collect(),
            slices: depths.windows(2).map(|depths| frustum(slice(&all, depths))).collect(),
            bounds,
        }
    }

    /// How many clusters.
    pub fn len(&self) -> usize {
        self.bounds.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.bounds.is_empty()
    }

    /// The index of a cluster: columns from the left, rows from the top, slices from near.
    pub fn index(&self, column: usize, row: usize, slice: usize) -> usize {
        (slice * self.rows.len() + row) * self.columns.len() + column
    }

    /// Calls `visit` with each cluster that `light` may reach into, ascending.
    pub fn reached_by(&self, light: &LightRange, mut visit: impl FnMut(usize)) {
        let kept = |frusta: &[Frustum]| -> Vec<usize> {
            (0..frusta.len()).filter(|&i| in_planes(light, &frusta[i])).collect()
        };
        let Some(Frustum { origin, .. }) = self.columns.first() else { return };
        let (columns, rows) = (kept(&self.columns), kept(&self.rows));
        for slice in kept(&self.slices) {
            for &row in &rows {
                for &column in &columns {
                    let cluster = self.index(column, row, slice);
                    if reaches(light, *origin, &self.bounds[cluster]) {
                        visit(cluster);
                    }
                }
            }
        }
    }

    /// For each cluster the lights that may reach into it.
    pub fn assign(&self, lights: &[LightRange]) -> ClusterLights {
        let mut pairs = Vec::new();
        let mut starts = vec![0_u32; self.len() + 1];
        for (light, range) in (0_u32..).zip(lights) {
            self.reached_by(range, |cluster| {
                pairs.push((cluster, light));
                starts[cluster + 1] += 1;
            });
        }
        for cluster in 0..self.len() {
            starts[cluster + 1] += starts[cluster];
        }
        let (mut next, mut lights) = (starts.clone(), vec![0; pairs.len()]);
        for (cluster, light) in pairs {
            lights[next[cluster] as usize] = light;
            next[cluster] += 1;
        }
        ClusterLights { starts, lights }
    }
}

/// `n` slices between `near` and `far` (finite), each the same multiple of the one before.
pub fn slice_depths(near: f64, far: f64, n: usize) -> Vec<f64> {
    let depth = |i: usize| match i {
        _ if i == n => far,
        0 => near,
        _ => near * libm::pow(far / near, i as f64 / n as f64),
    };
    (0..=n).map(depth).collect()
}

/// Lists of lights, one per cluster.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ClusterLights {
    /// Where the list of each cluster starts in `lights`, and one more.
    pub starts: Vec<u32>,
    /// Indices of lights, ascending within each list.
    pub lights: Vec<u32>,
}

impl ClusterLights {
    /// The lights of `cluster`.
    pub fn of(&self, cluster: usize) -> &[u32] {
        &self.lights[self.starts[cluster] as usize..self.starts[cluster + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use cullet_transform::Kind;
    use glam::DQuat;
    use proptest::prelude::*;

    use super::*;

    fn window(kind: Kind) -> Window {
        let (near, far) = (0.5, 50.0);
        Window { kind, left: -2.0, right: 2.0, bottom: -1.0, top: 1.0, near, far }
    }

    fn ball(center: [f64; 3], radius: f64) -> LightRange {
        LightRange::Ball(Sphere { center: center.into(), radius })
    }

    fn spot(apex: [f64; 3], direction: DVec3, half_angle: f64, range: f64) -> LightRange {
        LightRange::Cone(Cone { apex: apex.into(), direction, half_angle, range })
    }

    #[test]
    fn a_light_is_seen_where_it_reaches() {
        #[track_caller]
        fn check(light: LightRange, expected: bool) {
            let view = window(Kind::Perspective);
            let frustum = Frustum::from_window(DVec3::ZERO, &DMat3::IDENTITY, &view);
            assert_eq!(light_visible(&light, &frustum), expected);
        }
        check(ball([0.0, 0.0, 3.0], 2.0), false);
        check(ball([0.0, 0.0, 3.0], 3.5), true);
        check(ball([0.0, 0.0, -9.0], 0.0), true);
        check(ball([0.0, 0.0, -9.0], -1.0), false);
        check(ball([f64::NAN; 3], 1.0), true);
        check(spot([0.0, 0.0, 3.0], DVec3::Z, 0.5, f64::INFINITY), false);
        check(spot([0.0, 0.0, 3.0], -DVec3::Z, 0.5, f64::INFINITY), true);
        check(spot([0.0, 0.0, 3.0], -DVec3::Z, 0.5, 3.0), false);
        check(spot([0.0, 9.0, -4.0], DVec3::Y, 0.5, 100.0), false);
        check(spot([0.0, 9.0, -4.0], -DVec3::Y, 0.1, 100.0), true);
        check(spot([0.0, 9.0, -4.0], DVec3::NAN, 0.1, 100.0), true);
    }

    #[test]
    fn a_small_light_is_in_few_lists() {
        let depths = slice_depths(0.5, 50.0, 24);
        let view = window(Kind::Perspective);
        let clusters = Clusters::new(DVec3::ZERO, &DMat3::IDENTITY, &view, (16, 9), &depths);
        assert_eq!(clusters.len(), 16 * 9 * 24);
        let lists = clusters.assign(&[ball([0.3, 0.2, -7.0], 0.1), ball([0.0; 3], 1e9)]);
        let n_lists = |light| (0..clusters.len()).filter(|&i| lists.of(i).contains(&light)).count();
        assert!((1..=4).contains(&n_lists(0)), "{}", n_lists(0));
        assert_eq!(n_lists(1), clusters.len());
        let none = Clusters::new(DVec3::ZERO, &DMat3::IDENTITY, &view, (16, 9), &[]);
        assert!(none.is_empty() && none.assign(&[ball([0.0; 3], 1.0)]).lights.is_empty());
    }

    proptest! {
        /// Whatever point a light reaches, the cluster that holds the point lists the light.
        #[test]
        fn no_lit_point_is_left_dark(
            turn in prop::array::uniform3(-3.0_f64..3.0),
            eye in prop::array::uniform3(-1e5_f64..1e5),
            is_parallel in any::<bool>(),
            lights in prop::collection::vec(
                (prop::array::uniform3(-20.0_f64..20.0), prop::array::uniform3(-1.0_f64..1.0),
                 0.01_f64..3.0, 0.1_f64..15.0, any::<bool>()),
                1..6,
            ),
            places in prop::collection::vec(prop::array::uniform3(0.0_f64..1.0), 64),
        ) {
            let kind = if is_parallel { Kind::Orthographic } else { Kind::Perspective };
            let (view, eye) = (window(kind), DVec3::from_array(eye));
            let axes = DMat3::from_quat(DQuat::from_scaled_axis(turn.into()));
            let (n_columns, n_rows, depths) = (7, 5, slice_depths(view.near, view.far, 6));
            let clusters = Clusters::new(eye, &axes, &view, (n_columns, n_rows), &depths);
            let frustum = Frustum::from_window(eye, &axes, &view);
            let ranges: Vec<LightRange> = lights.iter().map(|&(at, to, half_angle, range, round)| {
                let center = eye + DVec3::from_array(at);
                let direction = DVec3::from_array(to).try_normalize().unwrap_or(DVec3::X);
                if round {
                    LightRange::Ball(Sphere { center, radius: range })
                } else {
                    LightRange::Cone(Cone { apex: center, direction, half_angle, range })
                }
            }).collect();
            let lists = clusters.assign(&ranges);
            for [u, v, w] in places {
                let slice = (w * 6.0) as usize;
                let depth = depths[slice] + (depths[slice + 1] - depths[slice]) * (w * 6.0).fract();
                let point = eye + axes * view.at(u, v, depth);
                let (column, row) =
                    ((u * n_columns as f64) as usize, (v * n_rows as f64) as usize);
                let list = lists.of(clusters.index(column, row, slice));
                for (i, range) in ranges.iter().enumerate() {
                    let lit = match range {
                        LightRange::Ball(sphere) => sphere.center.distance(point) < sphere.radius,
                        LightRange::Cone(cone) => {
                            let to_point = point - cone.apex;
                            to_point.length() < cone.range
                                && to_point.angle_between(cone.direction) < cone.half_angle
                        }
                    };
                    if lit {
                        prop_assert!(list.contains(&(i as u32)), "{range:?} {point}");
                        prop_assert!(light_visible(range, &frustum));
                    }
                }
            }
        }
    }
}
