//! The plain twin of the rasterizer: a ray per pixel, in f64.
//!
//! It shares with the rasterizer the scene, the view and the kernels, and nothing in between:
//! visibility comes from the slab test and a ray-triangle test over a tree of boxes, weights and
//! their derivatives from geometry in view space. Where the two pictures differ, one is wrong.

use cullet_cull::{Aabb, Ray, ray_aabb, ray_triangle};
use cullet_raster::{Facing, Fragment, SubpixelBits};
use cullet_transform::{ClipPoint, Kind, PlaneMask, View, Window};
use glam::{DMat4, DVec3, Vec3};

use crate::shading::{Emit, Places, Run, VisibleTriangle, keeps};
use crate::{Item, Prepared, Region, Settings};

/// Triangles in view space under a tree of boxes.
pub(crate) struct Raycaster<'a> {
    prepared: &'a Prepared,
    view: &'a View,
    settings: &'a Settings,
    window: Window,
    triangles: Vec<Triangle>,
    nodes: Vec<Node>,
}

struct Triangle {
    id: u32,
    corners: [DVec3; 3],
}

/// A box; a leaf when `len` is not 0, else its children are `first` and `first + 1`.
struct Node {
    bounds: Aabb,
    first: usize,
    len: usize,
}

/// What a ray met.
struct Hit<'a> {
    distance: f64,
    triangle: VisibleTriangle<'a>,
    fragment: Fragment,
}

impl<'a> Raycaster<'a> {
    /// Collects the triangles of all objects that `planes` keeps.
    pub(crate) fn new(
        prepared: &'a Prepared,
        view: &'a View,
        settings: &'a Settings,
        planes: &[Option<PlaneMask>],
        snapped: bool,
    ) -> Self {
        let mut triangles = Vec::new();
        let grid = snapped.then_some(settings.subpixel_bits);
        for (item, _) in prepared.items().iter().zip(planes).filter(|(_, p)| p.is_some()) {
            collect(prepared, view, item, grid, &mut triangles);
        }
        let mut nodes = vec![Node { bounds: Aabb::EMPTY, first: 0, len: triangles.len() }];
        build(&mut nodes, 0, &mut triangles, 0);
        Raycaster { prepared, view, settings, window: view.window(), triangles, nodes }
    }

    /// The nearest thing at a pixel; of equally near ones that with the lowest id.
    fn cast(&self, x: u32, y: u32) -> Option<Hit<'_>> {
        let pixel = PixelRay::new(self.view, &self.window, x, y);
        let mut nearest: Option<Hit<'_>> = None;
        let mut stack = vec![0];
        while let Some(node) = stack.pop().map(|i: usize| &self.nodes[i]) {
            let Some((enter, _)) = ray_aabb(&pixel.ray, &node.bounds) else {
                continue;
            };
            if nearest.as_ref().is_some_and(|hit| enter > hit.distance * (1.0 + 1e-12)) {
                continue;
            }
            if node.len == 0 {
                stack.extend([node.first, node.first + 1]);
                continue;
            }
            for triangle in &self.triangles[node.first..node.first + node.len] {
                let Some(hit) = self.hit(&pixel, triangle) else {
                    continue;
                };
                let nearer = nearest.as_ref().is_none_or(|best| {
                    hit.distance < best.distance
                        || (hit.distance == best.distance && hit.triangle.id < best.triangle.id)
                });
                let VisibleTriangle { surface, corners, .. } = &hit.triangle;
                if nearer && keeps(surface, *corners, &hit.fragment, self.settings) {
                    nearest = Some(hit);
                }
            }
        }
        nearest
    }

    fn hit(&self, pixel: &PixelRay, triangle: &Triangle) -> Option<Hit<'_>> {
        let hit = ray_triangle(&pixel.ray, &triangle.corners)?;
        // The ray's direction has unit length along the view axis.
        if !(hit.t >= self.window.near && hit.t <= self.window.far) {
            return None;
        }
        let [a, b, c] = triangle.corners;
        let clockwise = (b - a).cross(c - a).dot(pixel.ray.direction) > 0.0;
        let mut visible = VisibleTriangle::new(
            self.prepared,
            self.prepared.item_of(triangle.id),
            triangle.id,
            true,
        );
        visible.front = clockwise == visible.item.mirrored;
        let drawn = match visible.item.facing {
            Facing::Both => true,
            Facing::CounterClockwise => !clockwise,
            Facing::Clockwise => clockwise,
        };
        let fragment = pixel.fragment(&triangle.corners, hit.t, hit.barycentrics);
        drawn.then_some(Hit { distance: hit.t, triangle: visible, fragment })
    }
}

impl Raycaster<'_> {
    /// Finds what the pixels of `region` show, row by row.
    pub(crate) fn scan<'a>(&'a self, region: Region, emit: &mut Emit<'_, 'a>) {
        for y in region.y..region.y + region.height {
            for x in region.x..region.x + region.width {
                if let Some(hit) = self.cast(x, y) {
                    let places = Places::One(&hit.fragment);
                    emit(Run { x, y, len: 1, places }, &hit.triangle);
                }
            }
        }
    }
}

/// The ray through a pixel centre in view space, with its change per pixel (Igehy 1999,
/// "Tracing Ray Differentials"). Its parameter is the distance along the view axis.
struct PixelRay {
    ray: Ray,
    ddx: Ray,
    ddy: Ray,
}

impl PixelRay {
    fn new(view: &View, window: &Window, x: u32, y: u32) -> Self {
        let (width, height) =
            (f64::from(view.viewport().width()), f64::from(view.viewport().height()));
        let (per_x, per_y) =
            ((window.right - window.left) / width, (window.bottom - window.top) / height);
        let right = window.left + (f64::from(x) + 0.5) * per_x;
        let up = window.top + (f64::from(y) + 0.5) * per_y;
        let (shift_x, shift_y) = (DVec3::X * per_x, DVec3::Y * per_y);
        let ray = |origin, direction| Ray { origin, direction };
        match window.kind {
            Kind::Perspective => PixelRay {
                ray: ray(DVec3::ZERO, DVec3::new(right, up, -1.0)),
                ddx: ray(DVec3::ZERO, shift_x),
                ddy: ray(DVec3::ZERO, shift_y),
            },
            Kind::Orthographic => PixelRay {
                ray: ray(DVec3::new(right, up, 0.0), DVec3::NEG_Z),
                ddx: ray(shift_x, DVec3::ZERO),
                ddy: ray(shift_y, DVec3::ZERO),
            },
        }
    }

    /// Weights and their derivatives, from the change of the hit point in the triangle's plane.
    fn fragment(&self, [a, b, c]: &[DVec3; 3], t: f64, weights: DVec3) -> Fragment {
        let (ab, ac) = (*b - *a, *c - *a);
        let normal = ab.cross(ac);
        let slope = |change: &Ray| -> Vec3 {
            let shift = change.origin + change.direction * t;
            let dt = -normal.dot(shift) / normal.dot(self.ray.direction);
            let dhit = shift + self.ray.direction * dt;
            let db = dhit.cross(ac).dot(normal) / normal.dot(normal);
            let dc = ab.cross(dhit).dot(normal) / normal.dot(normal);
            DVec3::new(-db - dc, db, dc).as_vec3()
        };
        Fragment { weights, ddx: slope(&self.ddx), ddy: slope(&self.ddy) }
    }
}

/// Adds the triangles of an item in view space. With a `grid`, corners inside the picture's
/// reach are moved to where that puts them; triangles it would clip stay.
fn collect(
    prepared: &Prepared,
    view: &View,
    item: &Item,
    grid: Option<SubpixelBits>,
    out: &mut Vec<Triangle>,
) {
    let view_from_model = view.view_from_model(&item.world_from_model);
    let clip_from_model: DMat4 = view.clip_from_model(&item.world_from_model);
    let mesh = prepared.mesh(item);
    for (id, corners) in (item.first_triangle..).zip(&mesh.triangles) {
        let points = corners.map(|i| mesh.positions[i as usize].as_dvec3());
        let exact = points.map(|p| view_from_model.transform_point3(p));
        if !exact.iter().all(|p| p.is_finite()) {
            continue;
        }
        let clip = points.map(|p| ClipPoint::from_model(&clip_from_model, p));
        let corners = match grid {
            Some(grid) if clip.iter().all(is_in_reach) => {
                [0, 1, 2].map(|i| snapped_corner(view, grid, &clip[i], -exact[i].z))
            }
            _ => exact,
        };
        out.push(Triangle { id, corners });
    }
}

/// Neither near nor far nor the guard band (here: 8 pictures wide, well within it) clips it.
fn is_in_reach(p: &ClipPoint) -> bool {
    let reach = 8.0 * p.w;
    p.w > 0.0 && p.z <= p.w && p.z >= 0.0 && p.x.abs() <= reach && p.y.abs() <= reach
}

fn snapped_corner(view: &View, grid: SubpixelBits, clip: &ClipPoint, distance: f64) -> DVec3 {
    let at = grid.snap(view.viewport(), clip);
    let units = grid.units();
    let (width, height) = (f64::from(view.viewport().width()), f64::from(view.viewport().height()));
    view.window().at(at.x as f64 / units / width, at.y as f64 / units / height, distance)
}

/// Most triangles of a leaf.
const LEAF: usize = 4;

/// Splits node `index`, which holds a range of `triangles` that starts at `first`, at the median
/// of its longest side, until leaves are small. Depth is logarithmic.
fn build(nodes: &mut Vec<Node>, index: usize, triangles: &mut [Triangle], first: usize) {
    let boxes = triangles.iter().map(|t| Aabb::from_triangle(&t.corners));
    let bounds = boxes.fold(Aabb::EMPTY, |all, b| all.union(&b));
    let len = triangles.len();
    nodes[index] = Node { bounds, first, len };
    if len <= LEAF {
        return;
    }
    let size = bounds.max - bounds.min;
    let axis = if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    let key = |t: &Triangle| t.corners[0][axis] + t.corners[1][axis] + t.corners[2][axis];
    triangles.select_nth_unstable_by(len / 2, |a, b| key(a).total_cmp(&key(b)));
    let children = nodes.len();
    nodes[index] = Node { bounds, first: children, len: 0 };
    nodes.extend([0, 1].map(|_| Node { bounds: Aabb::EMPTY, first: 0, len: 0 }));
    let (low, high) = triangles.split_at_mut(len / 2);
    build(nodes, children, low, first);
    build(nodes, children + 1, high, first + len / 2);
}
