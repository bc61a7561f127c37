//! Coverage against exact integer arithmetic, written here from the rule and from nothing else.
//!
//! Asked twice: of the stages one by one, and of whole frames as [`Renderer`] draws them.
//!
//! Positions are chosen on a grid of 1/512 px, half of them exact ties of the 1/256 px snap, in
//! pictures whose sides are powers of two, so that the clip-space coordinates are exact and the
//! snapped position is known without floating point.

use cullet::raster::{
    DepthFormat, Facing, KeepAll, NO_TRIANGLE, Placer, ReversedF32, Tile, Triangles, cover, set_up,
};
use cullet::scene::{Material, Mesh, Node, Object, Scene};
use cullet::transform::{ClipPoint, PlaneMask, Viewport};
use cullet::{Camera, Frame, Pass, Passes, Prepared, Projection, Renderer, Settings, View};
use cullet_tests::{Random, long_mode, prepare};
use glam::{DAffine3, DVec3, Vec3};

const WIDTH: i64 = 64;
const HEIGHT: i64 = 32;

/// A position in units of 1/512 px.
type Fine = [i64; 2];

fn clip_point([x, y]: Fine, w: f64) -> ClipPoint {
    let ndc = |units: i64, side: i64| units as f64 / 256.0 / side as f64 - 1.0;
    ClipPoint { x: ndc(x, WIDTH) * w, y: -ndc(y, HEIGHT) * w, z: 0.25 * w, w }
}

/// 1/512 px to 1/256 px, half to even.
fn snapped(units: i64) -> i128 {
    let (down, odd) = (units.div_euclid(2), units.rem_euclid(2) == 1);
    i128::from(if odd && down.rem_euclid(2) == 1 { down + 1 } else { down })
}

/// The rule for one sample: inside all edges, or on an edge that is a top or a left one.
fn covered(corners: &[Fine; 3], x: i64, y: i64) -> bool {
    let p = corners.map(|[x, y]| [snapped(x), snapped(y)]);
    let s = [i128::from(x) * 256 + 128, i128::from(y) * 256 + 128];
    let cross = |a: [i128; 2], b: [i128; 2], c: [i128; 2]| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let area = cross(p[0], p[1], p[2]);
    let sign = area.signum();
    area != 0
        && (0..3).all(|i| {
            let (a, b) = (p[i], p[(i + 1) % 3]);
            let side = sign * cross(a, b, s);
            // Walking clockwise as seen (y down), a left edge goes up, a top edge goes right.
            let (dx, dy) = (sign * (b[0] - a[0]), sign * (b[1] - a[1]));
            side > 0 || (side == 0 && (dy < 0 || (dy == 0 && dx > 0)))
        })
}

/// How often each sample of the picture is covered by the triangles, drawn one by one.
fn drawn(triangles: &[[Fine; 3]], w: f64) -> Vec<u32> {
    let viewport = Viewport::new(WIDTH as u32, HEIGHT as u32).unwrap();
    let n = (WIDTH * HEIGHT) as usize;
    let mut counts = vec![0; n];
    let (mut ids, mut depth) = (vec![NO_TRIANGLE; n], vec![ReversedF32::FARTHEST; n]);
    for corners in triangles {
        let placer = Placer::<8>::new(viewport, PlaneMask::ALL);
        let vertices = corners.map(|p| placer.place(clip_point(p, w)));
        let input = Triangles {
            vertices: &vertices,
            triangles: &[[0, 1, 2]],
            first_vertex: 0,
            first_id: 0,
            facing: Facing::Both,
        };
        let mut out = Vec::new();
        set_up(&placer, &input, &mut out);
        let mut tile = Tile::<ReversedF32> {
            x: 0,
            y: 0,
            width: WIDTH as u32,
            ids: &mut ids,
            depth: &mut depth,
        };
        tile.clear();
        for triangle in &out {
            cover::<ReversedF32, 8, _>(&mut tile, triangle, &mut KeepAll);
        }
        for (count, id) in counts.iter_mut().zip(&ids) {
            *count += u32::from(*id != NO_TRIANGLE);
        }
    }
    counts
}

#[track_caller]
fn check(corners: [Fine; 3], w: f64) -> u64 {
    let drawn = drawn(&[corners], w);
    for (i, count) in drawn.iter().enumerate() {
        let (x, y) = (i as i64 % WIDTH, i as i64 / WIDTH);
        let expected = covered(&corners, x, y);
        assert_eq!(*count == 1, expected, "{corners:?} at pixel {x}, {y} with w = {w}");
    }
    drawn.len() as u64
}

/// Checks triangles from `corner` until enough samples are compared.
#[track_caller]
fn check_many(seed: u64, corner: impl Fn(&mut Random) -> Fine) {
    let mut random = Random::new(seed);
    let wanted = if long_mode() { 10_000_000 } else { 1_000_000 };
    let mut samples = 0;
    while samples < wanted {
        let corners = [0; 3].map(|_| corner(&mut random));
        let w = [1.0, 0.5, 4.0, 1024.0][random.integer(0, 3) as usize];
        samples += check(corners, w);
    }
}

#[test]
fn random_triangles() {
    check_many(1, |r| [r.integer(-8 * 512, 72 * 512), r.integer(-8 * 512, 40 * 512)]);
}

#[test]
fn corners_and_edges_on_pixel_centres() {
    check_many(2, |r| [r.integer(-4, 132) * 256, r.integer(-4, 68) * 256]);
}

#[test]
fn corners_on_exact_snapping_ties() {
    check_many(3, |r| [r.integer(0, 64 * 256) * 2 + 1, r.integer(0, 32 * 256) * 2 + 1]);
}

#[test]
fn tiny_triangles_around_a_centre() {
    check_many(4, |r| [20 * 512 + 256 + r.integer(-6, 6), 10 * 512 + 256 + r.integer(-6, 6)]);
}

#[test]
fn triangles_that_cross_the_border_and_fill_the_guard_band() {
    let reach = 16_000 * 512;
    check_many(5, |r| [r.integer(-reach, reach), r.integer(-reach, reach)]);
}

#[test]
fn slivers() {
    let mut random = Random::new(6);
    for _ in 0..if long_mode() { 5_000 } else { 500 } {
        let end = |r: &mut Random| [r.integer(-100, 33_000), r.integer(-100, 17_000)];
        let (a, b) = (end(&mut random), end(&mut random));
        let c = [b[0] + random.integer(-3, 3), b[1] + random.integer(-3, 3)];
        check([a, b, c], 1.0);
        // The middle of an edge, as nearly as the grid has it.
        check([a, [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2], b], 1.0);
    }
}

#[test]
fn degenerate_triangles_cover_nothing() {
    let on_centres = [256, 256 + 512];
    for a in on_centres {
        for b in on_centres {
            check([[a, b], [a, b], [a + 512, b]], 1.0);
            check([[a, b], [a + 512, b], [a + 1024, b]], 1.0);
            check([[a, b], [a + 512, b + 512], [a + 1024, b + 1024]], 1.0);
        }
    }
}

/// Any triangulated partition of the picture covers every sample exactly once, whatever the
/// order of corners, and also when moved by single units.
#[test]
fn partitions_are_watertight() {
    let mut random = Random::new(7);
    for round in 0..if long_mode() { 400 } else { 40 } {
        let shift = [random.integer(-2, 2), random.integer(-2, 2)];
        let triangles = partition(&mut random, round % 2 == 0, shift);
        let counts = drawn(&triangles, 1.0);
        let odd = counts.iter().position(|&count| count != 1);
        assert_eq!(odd, None, "round {round}: covered {} times", counts[odd.unwrap_or(0)]);
    }
}

/// A jittered grid of quads that reaches beyond the picture, each cut along a random diagonal.
/// `on_centres` puts every corner on the centre of a pixel.
fn partition(random: &mut Random, on_centres: bool, shift: Fine) -> Vec<[Fine; 3]> {
    let (columns, rows) = (9, 7);
    let mut grid = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let middle = [(column * 10 - 8) * 512 + 256, (row * 7 - 5) * 512 + 256];
            let jitter = [0; 2].map(|_| match on_centres {
                true => random.integer(-2, 2) * 512,
                false => random.integer(-1000, 1000),
            });
            grid.push([0, 1].map(|i| middle[i] + jitter[i] + shift[i]));
        }
    }
    let mut triangles = Vec::new();
    for row in 0..rows - 1 {
        for column in 0..columns - 1 {
            let at = |dx: i64, dy: i64| grid[((row + dy) * columns + column + dx) as usize];
            let (a, b, c, d) = (at(0, 0), at(1, 0), at(1, 1), at(0, 1));
            let halves = match random.integer(0, 1) {
                0 => [[a, b, c], [a, c, d]],
                _ => [[a, b, d], [b, c, d]],
            };
            for mut half in halves {
                half.rotate_left(random.integer(0, 2) as usize);
                if random.integer(0, 1) == 1 {
                    half.swap(0, 1);
                }
                triangles.push(half);
            }
        }
    }
    triangles
}

/// A mesh of these triangles, all at one distance, of which one unit is one pixel.
fn flat_scene(triangles: &[[Fine; 3]]) -> Prepared {
    let position = |[x, y]: Fine| {
        // Exact: multiples of 1/512 below 2^14.
        let px = |units: i64, side: i64| units as f32 / 512.0 - side as f32 / 2.0;
        Vec3::new(px(x, WIDTH), -px(y, HEIGHT), -1.0)
    };
    let first = (0..).step_by(3);
    prepare(Scene {
        name: "coverage".into(),
        meshes: vec![Mesh {
            positions: triangles.iter().flatten().map(|p| position(*p)).collect(),
            triangles: first.take(triangles.len()).map(|i| [i, i + 1, i + 2]).collect(),
            ..Mesh::default()
        }],
        materials: vec![Material { double_sided: true, ..Material::default() }],
        nodes: vec![Node { name: "all".into(), parent: None, world_from_node: DAffine3::IDENTITY }],
        objects: vec![Object {
            name: "all".into(),
            node: 0,
            mesh: 0,
            material: 0,
            world_from_model: DAffine3::IDENTITY,
        }],
        ..Scene::default()
    })
}

/// Per sample, the triangle that a whole frame shows, counted from 1.
fn frame_of(renderer: &mut Renderer, triangles: &[[Fine; 3]], threads: usize) -> Vec<u32> {
    let height = HEIGHT as f64;
    let lens = Projection::Orthographic { height, near: 0.0, far: 2.0 };
    let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, lens).unwrap();
    let view = View::new(&camera, Viewport::new(WIDTH as u32, HEIGHT as u32).unwrap());
    let passes = Passes::NONE.with(Pass::Triangle);
    let settings = Settings { passes, threads, ..Settings::default() };
    let mut frame = Frame::default();
    renderer.render(&flat_scene(triangles), &view, &settings, &mut frame);
    frame.triangle
}

/// Whole frames of several triangles at one depth: each sample shows the first that covers it.
#[track_caller]
fn check_frames(seed: u64, n_triangles: usize, corner: impl Fn(&mut Random) -> Fine) {
    let mut random = Random::new(seed);
    let mut renderer = Renderer::default();
    let wanted = if long_mode() { 10_000_000 } else { 400_000 };
    let mut samples = 0;
    while samples < wanted {
        let triangles: Vec<[Fine; 3]> =
            (0..n_triangles).map(|_| [0; 3].map(|_| corner(&mut random))).collect();
        let frame = frame_of(&mut renderer, &triangles, 1 + samples % 3);
        for (i, &shown) in frame.iter().enumerate() {
            let (x, y) = (i as i64 % WIDTH, i as i64 / WIDTH);
            let first = triangles.iter().position(|corners| covered(corners, x, y));
            let expected = first.map_or(0, |first| first as u32 + 1);
            assert_eq!(shown, expected, "pixel {x}, {y} of {triangles:?}");
        }
        samples += frame.len();
    }
}

#[test]
fn whole_frames_of_random_triangles() {
    check_frames(8, 6, |r| [r.integer(-8 * 512, 72 * 512), r.integer(-8 * 512, 40 * 512)]);
}

#[test]
fn whole_frames_of_corners_on_centres() {
    check_frames(9, 6, |r| [r.integer(-4, 132) * 256, r.integer(-4, 68) * 256]);
}

#[test]
fn whole_frames_of_exact_ties_of_the_snap() {
    check_frames(10, 6, |r| [r.integer(0, 64 * 256) * 2 + 1, r.integer(0, 32 * 256) * 2 + 1]);
}

#[test]
fn whole_frames_of_triangles_as_large_as_the_guard_band() {
    let reach = 16_000 * 512;
    check_frames(11, 3, |r| [r.integer(-reach, reach), r.integer(-reach, reach)]);
}

/// One partition everywhere: moved by every multiple of 1/256 px within a pixel (by 1/512 px too,
/// where the snap meets ties), its corners in each of the six orders.
#[test]
fn partitions_stay_watertight_in_every_placement() {
    let still = partition(&mut Random::new(12), true, [0, 0]);
    let step = if long_mode() { 1 } else { 37 };
    for x in (-256_i64..256).step_by(step) {
        for shift in [[x, 0], [0, x], [x, x], [x, -3 * x]] {
            let order = (x + shift[1]).rem_euclid(6);
            let moved = still.iter().map(|corners| {
                let mut corners = corners.map(|p| [p[0] + shift[0], p[1] + shift[1]]);
                corners.rotate_left(order as usize % 3);
                if order >= 3 {
                    corners.swap(0, 1);
                }
                corners
            });
            let counts = drawn(&moved.collect::<Vec<_>>(), 1.0);
            assert!(counts.iter().all(|&count| count == 1), "moved by {shift:?} / 512 px");
        }
    }
}

/// The same of whole frames: nothing shines through, and the triangles drawn one by one show as
/// many samples as the picture has.
#[test]
fn partitions_are_watertight_in_whole_frames() {
    let mut random = Random::new(13);
    let mut renderer = Renderer::default();
    for round in 0..if long_mode() { 60 } else { 3 } {
        let shift = [random.integer(-256, 256), random.integer(-256, 256)];
        let triangles = partition(&mut random, round % 2 == 0, shift);
        let together = frame_of(&mut renderer, &triangles, 3);
        assert!(together.iter().all(|&shown| shown > 0), "round {round}");
        let mut counts = vec![0; together.len()];
        for triangle in &triangles {
            let alone = frame_of(&mut renderer, &[*triangle], 1);
            counts.iter_mut().zip(alone).for_each(|(count, shown)| *count += shown);
        }
        assert!(counts.iter().all(|&count| count == 1), "round {round}");
    }
}
