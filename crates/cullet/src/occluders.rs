//! What large triangles hide, known before anything is drawn: so that objects behind a wall are left out one by
//! one, not cluster by cluster and tile by tile.
//!
//! The picture is divided into cells. A triangle that covers a cell with a margin of a pixel wins all of its samples
//! from whatever is farther than the farthest of the triangle there; so what is nowhere nearer than that shows
//! in none of its cells. A cell keeps the nearest such depth of all triangles looked at, which are those of large
//! objects of few triangles: walls, floors, houses. Source of asking depths by cells: Greene, Kass & Miller 1993,
//! "Hierarchical Z-Buffer Visibility".
//!
//! Two triangles with a common edge cover what lies inside their other edges. The margin is far more than snapping
//! moves a corner, and depths are linear over the picture, so they lie between those at the corners of the widened
//! cell.

use cullet_cull::Aabb;
use cullet_raster::{Facing, Precision, Transforms};
use cullet_transform::{Kind, View};
use glam::{DMat4, DVec2, DVec3, Vec3};

use crate::screen_box::ScreenBox;
use crate::{Item, Prepared, Settings};

/// Pixels along a side of a cell.
const CELL: u32 = 64;

/// How far beyond its cell a triangle must reach, px.
const MARGIN: f64 = 1.0;

/// Objects whose boxes are less from corner to corner, px, are not looked at: they hardly cover a cell.
const LARGE: f64 = 3.0 * CELL as f64;

/// Objects of more triangles are not looked at.
const FEW_TRIANGLES: u32 = 64;

/// Fewer clusters are not worth the trouble.
const MANY_CLUSTERS: u32 = 2048;

/// Cells and triangles are looked at no more often than this in a frame, so that thousands of layers, or of large
/// objects that cover nothing, cost no more than what they may save: some forty times all cells of 1920 x 1080 px.
const MOST_LOOKS: usize = 20_000;

/// Corners farther than this from the picture's are not looked at, px: they may be clipped.
const FAR_OUT: f64 = 8192.0;

/// Depth keys that whatever shows in a cell is nearer than. Memory is kept.
#[derive(Debug, Default)]
pub(crate) struct Occluders {
    columns: usize,
    /// Row by row; none at all where nothing is known.
    keys: Vec<i32>,
    /// How often cells and triangles may be looked at yet.
    looks_left: usize,
}

impl Occluders {
    /// Looks at the large triangles among the drawn `items`, which are numbers of items, of `n_clusters` in all.
    pub fn find(
        &mut self,
        prepared: &Prepared,
        view: &View,
        settings: &Settings,
        items: impl Iterator<Item = u32>,
        n_clusters: u32,
    ) {
        self.keys.clear();
        let precision = settings.precision();
        let is_exact = precision.transforms == Transforms::F64;
        if !settings.occlusion || !is_exact || n_clusters < MANY_CLUSTERS {
            return;
        }
        let viewport = view.viewport();
        let size = DVec2::new(viewport.width().into(), viewport.height().into());
        self.columns = viewport.width().div_ceil(CELL) as usize;
        self.keys.resize(self.columns * viewport.height().div_ceil(CELL) as usize, i32::MIN);
        self.looks_left = MOST_LOOKS;
        for item in items {
            if self.looks_left == 0 {
                return;
            }
            let item = &prepared.items()[item as usize];
            let is_simple = item.n_triangles <= FEW_TRIANGLES && !item.masked;
            if !is_simple || !is_large(item, view) {
                continue;
            }
            let clip_from_model = view.clip_from_model(&item.world_from_model);
            let mesh = prepared.mesh(item);
            self.looks_left = self.looks_left.saturating_sub(mesh.triangles.len());
            let mut before: Option<Face> = None;
            for corners in &mesh.triangles {
                let points = corners.map(|i| mesh.positions[i as usize]);
                let corners = points.map(|p| screen(&clip_from_model, p.as_dvec3(), size));
                let face = Face::new(points, corners, item.facing);
                if let Some(face) = &face {
                    self.cover(&[*face], [None; 2], precision);
                    if let Some(before) = &before
                        && let Some(shared) = before.edge_shared_with(face)
                    {
                        self.cover(&[*before, *face], shared.map(Some), precision);
                    }
                }
                before = face;
            }
        }
    }

    /// Whether any triangle was looked at.
    #[inline]
    pub fn are_known(&self) -> bool {
        !self.keys.is_empty()
    }

    /// Whether nothing that shows inside `shown` can be in front of what covers its cells.
    #[inline]
    pub fn hide(&self, shown: &ScreenBox) -> bool {
        if !self.are_known() {
            return false;
        }
        let cells = |[start, end]: [i32; 2]| {
            start as usize / CELL as usize..(end as usize).div_ceil(CELL as usize)
        };
        let columns = cells(shown.x);
        cells(shown.y).all(|row| {
            let row = &self.keys[row * self.columns..][..self.columns];
            row[columns.clone()].iter().all(|key| *key > shown.nearest)
        })
    }

    /// Memory held.
    pub fn bytes(&self) -> usize {
        4 * self.keys.capacity()
    }

    /// Notes the cells that a face covers, or two of which each has an edge `without` meaning: the one that they
    /// share, which leaves no gap.
    fn cover(&mut self, faces: &[Face], without: [Option<usize>; 2], precision: Precision) {
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let mut nearest = 0.0_f64;
        for corner in faces.iter().flat_map(|face| face.corners) {
            low = low.min(corner.truncate());
            high = high.max(corner.truncate());
            nearest = nearest.max(corner.z);
        }
        let side = f64::from(CELL);
        // Cells that lie between with their margins.
        let range = |low: f64, high: f64, n: usize| {
            let first = ((low + MARGIN) / side).ceil().max(0.0) as usize;
            let end = ((high - MARGIN) / side).floor().max(0.0) as usize;
            first..end.min(n)
        };
        let rows = self.keys.len() / self.columns;
        for row in range(low.y, high.y, rows) {
            for column in range(low.x, high.x, self.columns) {
                if self.looks_left == 0 {
                    return;
                }
                self.looks_left -= 1;
                let corner = DVec2::new(column as f64, row as f64) * side;
                let mut farthest = f64::INFINITY;
                for (right, down) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
                    let reach = DVec2::new(right, down);
                    let place = corner + reach * side + (reach * 2.0 - 1.0) * MARGIN;
                    for (face, without) in faces.iter().zip(without) {
                        farthest = farthest.min(face.depth(place, without));
                    }
                }
                // Far below the nearest corner, rounding may be all that is left of a depth.
                if farthest > 1e-6 * nearest {
                    // The rasterizer rounds to f32 once.
                    let farthest = (farthest as f32).next_down().next_down();
                    let key = &mut self.keys[row * self.columns + column];
                    *key = (*key).max(precision.depth.key(farthest.into()));
                }
            }
        }
    }
}

/// A triangle on the screen that is seen from the side that is drawn, and is not clipped.
#[derive(Clone, Copy, Debug)]
struct Face {
    /// Corners as the mesh has them: who shares those shares a border on the screen to the last bit.
    points: [Vec3; 3],
    /// Px from the upper left corner of the picture, and depth, 1 at the near plane and 0 far away.
    corners: [DVec3; 3],
    /// Twice its area, px; negative where corners run counter-clockwise as seen.
    area: f64,
}

impl Face {
    fn new(points: [Vec3; 3], corners: [DVec3; 3], facing: Facing) -> Option<Self> {
        let [a, b, c] = corners.map(DVec3::truncate);
        let area = (b - a).perp_dot(c - a);
        let is_seen = match facing {
            Facing::Both => area != 0.0,
            Facing::Clockwise => area > 0.0,
            Facing::CounterClockwise => area < 0.0,
        };
        let is_inside = |p: &DVec3| p.x.abs() <= FAR_OUT && p.y.abs() <= FAR_OUT && p.z >= 0.0;
        // False for NaN.
        (is_seen && corners.iter().all(is_inside)).then_some(Face { points, corners, area })
    }

    /// The depth of its plane at a place, or minus infinity where that is beyond an edge, other than the one `without`
    /// meaning. Edges are numbered by the corner that they begin at.
    fn depth(&self, place: DVec2, without: Option<usize>) -> f64 {
        let mut depth = 0.0;
        for edge in 0..3 {
            let [from, to, opposite] = [0, 1, 2].map(|i| self.corners[(edge + i) % 3]);
            let way = to.truncate() - from.truncate();
            let share = way.perp_dot(place - from.truncate()) / self.area;
            let is_beyond = share < 0.0 && without != Some(edge);
            if is_beyond {
                return f64::NEG_INFINITY;
            }
            depth += share * opposite.z;
        }
        depth
    }

    /// The edge of each that joins the same corners, in opposite directions, if both are seen from one side.
    fn edge_shared_with(&self, other: &Face) -> Option<[usize; 2]> {
        let edge = |face: &Face, i: usize| [face.points[i], face.points[(i + 1) % 3]];
        let pairs = (0..3).flat_map(|own| (0..3).map(move |others| [own, others]));
        let mut pairs = pairs.filter(|[own, others]| {
            let [from, to] = edge(other, *others);
            edge(self, *own) == [to, from]
        });
        pairs.next().filter(|_| (self.area > 0.0) == (other.area > 0.0))
    }
}

/// Px from the upper left corner of the picture, and depth; not a number where the rasterizer may cut at the near or
/// the far plane, which it asks by the same comparisons: a quotient could be rounded to the other side.
fn screen(clip_from_model: &DMat4, point: DVec3, size: DVec2) -> DVec3 {
    let clip = *clip_from_model * point.extend(1.0);
    let is_between = clip.w > 0.0 && 0.0 <= clip.z && clip.z <= clip.w; // false for NaN
    let w = if is_between { clip.w } else { f64::NAN };
    let ndc = clip.truncate() / w;
    DVec3::new((0.5 + 0.5 * ndc.x) * size.x, (0.5 - 0.5 * ndc.y) * size.y, ndc.z)
}

/// Whether an object is [`LARGE`], as seen from its middle: who is not looked at hides nothing, so
/// what is quickly told will do.
fn is_large(item: &Item, view: &View) -> bool {
    let window = view.window();
    let px = f64::from(view.viewport().height()) / (window.top - window.bottom).abs();
    let Aabb { min, max } = item.bounds;
    let distance = match window.kind {
        Kind::Orthographic => 1.0,
        Kind::Perspective => (0.5 * (min + max) - view.camera().eye()).length(),
    };
    (max - min).length() * px >= LARGE * distance
}

#[cfg(test)]
mod tests {
    use cullet_raster::{DepthKind, SubpixelBits};
    use cullet_scene::{Mesh, Node, Object, Scene, synth};
    use cullet_transform::{Camera, Projection, Viewport};
    use glam::{DAffine3, DQuat};

    use super::*;
    use crate::{Antialias, CullTest, Frame, Pass, Passes, Renderer};

    fn put(scene: &mut Scene, mesh: usize, place: DAffine3) {
        let (node, name) = (scene.nodes.len(), format!("{}", scene.objects.len()));
        scene.nodes.push(Node { name: name.clone(), parent: None, world_from_node: place });
        scene.objects.push(Object { name, node, mesh, material: 0, world_from_model: place });
    }

    /// Forty balls of some sixty clusters each, and a wall of two triangles between them and the eye.
    fn balls_behind(wall: DAffine3) -> Scene {
        let mut scene = synth::synth("sphere:90").unwrap();
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        scene.meshes.push(Mesh {
            positions: corners.map(|[x, y]| Vec3::new(x, y, 0.0)).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        });
        scene.objects.clear();
        scene.nodes.clear();
        for i in 0..40 {
            let at = DVec3::new(f64::from(i % 8) - 3.5, f64::from(i / 8) - 2.0, -8.0);
            let place = DAffine3::from_translation(at) * DAffine3::from_scale(DVec3::splat(0.45));
            put(&mut scene, 0, place);
        }
        put(&mut scene, 1, wall);
        scene
    }

    fn view(lens: Projection) -> View {
        let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, lens).unwrap();
        View::new(&camera, Viewport::new(330, 210).unwrap())
    }

    const EYE: Projection = Projection::Perspective { yfov: 0.8, near: 0.1, far: f64::INFINITY };

    fn draw(scene: Scene, view: &View, settings: &Settings) -> ([Frame; 2], [u64; 2]) {
        let prepared = Prepared::new(scene).unwrap();
        let mut frames = [Frame::default(), Frame::default()];
        let mut hidden = [0; 2];
        for (i, occlusion) in [false, true].into_iter().enumerate() {
            let settings = Settings { occlusion, ..*settings };
            let stats = Renderer::default().render(&prepared, view, &settings, &mut frames[i]);
            let clusters = stats.clusters;
            hidden[i] = clusters.n_hidden;
            assert!(clusters.n_in >= MANY_CLUSTERS.into(), "{}", clusters.n_in);
            assert_eq!(
                clusters.n_in,
                clusters.n_outside
                    + clusters.n_between_samples
                    + clusters.n_hidden
                    + clusters.n_drawn
            );
        }
        (frames, hidden)
    }

    /// Walls in all directions, cutting through the balls, ending among them, seen from behind.
    #[test]
    fn nothing_that_shows_is_hidden() {
        let settings = Settings {
            passes: Passes::COLOR.with(Pass::Triangle).with(Pass::Depth),
            ..Settings::default()
        };
        let lenses = [EYE, Projection::Orthographic { height: 6.0, near: 0.0, far: 50.0 }];
        let mut n_hidden = Vec::new();
        for i in 0..24 {
            let angle = f64::from(i) * 0.7;
            let turned = DQuat::from_rotation_y(0.9 * angle.sin())
                * DQuat::from_rotation_x(0.7 * (2.3 * angle).sin())
                * DQuat::from_rotation_z(angle);
            let at = DVec3::new(
                angle.cos(),
                (1.7 * angle).sin(),
                -4.0 - 4.0 * (0.5 * angle).sin().abs(),
            );
            let wall = DAffine3::from_scale_rotation_translation(
                DVec3::new(1.0 + f64::from(i % 5), 2.5, if i % 7 == 0 { -1.0 } else { 1.0 }),
                turned,
                at,
            );
            let antialias = [Antialias::None, Antialias::Msaa4, Antialias::Msaa8][i as usize % 3];
            let (subpixel_bits, depth_format) =
                (SubpixelBits::ALL[i as usize / 6 % 4], DepthKind::ALL[i as usize / 4 % 4]);
            let settings = Settings { antialias, subpixel_bits, depth_format, ..settings };
            let view = view(lenses[i as usize % 2]);
            let ([all, some], [_, hidden]) = draw(balls_behind(wall), &view, &settings);
            assert!(all.rgba8 == some.rgba8, "{i}");
            assert!(all.triangle == some.triangle && all.depth == some.depth, "{i}");
            n_hidden.push(hidden);
        }
        assert!(n_hidden.iter().filter(|n| **n > 300).count() > 6, "{n_hidden:?}");
    }

    /// A wall that fills the view hides every ball whole, and a cell is covered only with a margin.
    #[test]
    fn cells_behind_a_wall_are_known() {
        let near = |half: f64| {
            DAffine3::from_translation(DVec3::new(0.0, 0.0, -2.0))
                * DAffine3::from_scale(DVec3::new(half, half, 1.0))
        };
        let view = view(EYE);
        let settings = Settings::default();
        let known = |half: f64| {
            let prepared = Prepared::new(balls_behind(near(half))).unwrap();
            let mut occluders = Occluders::default();
            occluders.find(&prepared, &view, &settings, 0..41, MANY_CLUSTERS);
            assert!(occluders.bytes() >= 4 * 6 * 4);
            occluders.keys.iter().filter(|key| **key > i32::MIN).count()
        };
        // The cells along the right and the lower border reach beyond the picture, and so does the wall.
        assert_eq!(known(4.0), 6 * 4);
        // 210 px high are 1.69 at this distance: the wall is 62 px wide, then 300.
        assert_eq!(known(0.25), 0);
        assert!((2..12).contains(&known(1.2)));
    }

    /// A wall that the near plane has just cut off hides nothing, however its depth is rounded.
    #[test]
    fn what_the_near_plane_cuts_off_hides_nothing() {
        for depth in [1.5_f64, 1.9, 3.0, 3.3, 3.5] {
            let place = DAffine3::from_translation(DVec3::new(0.0, 0.0, -depth));
            let scene = balls_behind(place * DAffine3::from_scale(DVec3::splat(9.0)));
            for near in [depth.next_down(), depth, depth.next_up(), 1.000_01 * depth] {
                let lens = Projection::Perspective { yfov: 0.8, near, far: f64::INFINITY };
                // Or else the wall is left out as an object, and nobody looks at it.
                let settings = Settings { cull: CullTest::None, ..Settings::default() };
                let ([all, some], _) = draw(scene.clone(), &view(lens), &settings);
                assert!(all.rgba8 == some.rgba8, "{depth}, {near}");
            }
        }
    }

    /// Thousands of layers are looked at as far as the looks last, and nothing is lost.
    #[test]
    fn many_layers_cost_what_few_do() {
        let mut scene = balls_behind(DAffine3::IDENTITY);
        for i in 0..2000 {
            let at = DVec3::new(0.0, 0.0, -9.0 + f64::from(i) * 0.003);
            let wall = DAffine3::from_translation(at) * DAffine3::from_scale(DVec3::splat(9.0));
            put(&mut scene, 1, wall);
        }
        let ([all, some], _) = draw(scene.clone(), &view(EYE), &Settings::default());
        assert!(all.rgba8 == some.rgba8);
        let prepared = Prepared::new(scene).unwrap();
        let mut occluders = Occluders::default();
        let items = 0..prepared.items().len() as u32;
        occluders.find(&prepared, &view(EYE), &Settings::default(), items, MANY_CLUSTERS);
        assert_eq!(occluders.looks_left, 0);
    }
}
