//! What a renderer meets at the ends of its ranges, and what it must do there: huge and tiny
//! numbers, bad numbers, odd lenses, odd pictures, flattened and mirrored nodes.
//!
//! Positions, coverage and attributes are held to [`ideal`], an oracle of its own that knows
//! neither clipping nor fixed point.

mod accuracy;
mod camera;
mod geometry;
mod ideal;
mod lights;
mod scenes;
mod surface;

use cullet::scene::{Material, Mesh, Node, Object, Scene};
use cullet::{
    Antialias, Camera, Frame, FrameStats, Prepared, Projection, Renderer, Settings, View, Viewport,
};
use cullet_tests::{all_passes, prepare};
use glam::{DAffine3, DVec3, Vec3};

const INF: f64 = f64::INFINITY;

/// A triangle list without attributes.
fn mesh(positions: &[Vec3], triangles: &[[u32; 3]]) -> Mesh {
    Mesh { positions: positions.to_vec(), triangles: triangles.to_vec(), ..Mesh::default() }
}

/// The square -1..=1 in x and y, seen from +z.
fn square() -> Mesh {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    mesh(&corners.map(|(x, y)| Vec3::new(x, y, 0.0)), &[[0, 1, 2], [0, 2, 3]])
}

/// The cube -1..=1, outside out.
fn cube() -> Mesh {
    let corner = |i: u8| {
        let side = |bit: u8| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
        Vec3::new(side(0), side(1), side(2))
    };
    let quads =
        [[4, 5, 7, 6], [1, 0, 2, 3], [5, 1, 3, 7], [0, 4, 6, 2], [6, 7, 3, 2], [0, 1, 5, 4]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    mesh(&[0, 1, 2, 3, 4, 5, 6, 7].map(corner), &triangles.collect::<Vec<_>>())
}

fn double_sided() -> Material {
    Material { double_sided: true, ..Material::default() }
}

/// One object per mesh and place, all of one material.
fn scene(material: Material, objects: &[(Mesh, DAffine3)]) -> Scene {
    let node = |(i, (_, world_from_node)): (usize, &(Mesh, DAffine3))| Node {
        name: format!("node {i}"),
        parent: None,
        world_from_node: *world_from_node,
    };
    let object = |(i, (_, world_from_model)): (usize, &(Mesh, DAffine3))| Object {
        name: format!("node {i}"),
        node: i,
        mesh: i,
        material: 0,
        world_from_model: *world_from_model,
    };
    Scene {
        name: "extremes".into(),
        meshes: objects.iter().map(|(mesh, _)| mesh.clone()).collect(),
        nodes: objects.iter().enumerate().map(node).collect(),
        objects: objects.iter().enumerate().map(object).collect(),
        materials: vec![material],
        ..Scene::default()
    }
}

/// One double-sided object.
fn alone(mesh: Mesh, world_from_model: DAffine3) -> Prepared {
    prepare(scene(double_sided(), &[(mesh, world_from_model)]))
}

fn perspective(degrees: f64, near: f64, far: f64) -> Projection {
    Projection::Perspective { yfov: degrees.to_radians(), near, far }
}

/// At the origin, looking down -z.
fn ahead(lens: Projection) -> Camera {
    look(DVec3::ZERO, DVec3::NEG_Z, lens)
}

fn look(eye: DVec3, target: DVec3, lens: Projection) -> Camera {
    Camera::look_at(eye, target, DVec3::Y, lens).expect("a possible camera")
}

fn view(camera: &Camera, [width, height]: [u32; 2]) -> View {
    View::new(camera, Viewport::new(width, height).expect("a possible size"))
}

fn settings() -> Settings {
    Settings { passes: all_passes(), antialias: Antialias::None, ..Settings::default() }
}

/// One frame with every pass, and what it did.
fn draw(prepared: &Prepared, camera: &Camera, size: [u32; 2]) -> (Frame, FrameStats) {
    let mut frame = Frame::default();
    let view = view(camera, size);
    let stats = Renderer::default().render(prepared, &view, &settings(), &mut frame);
    (frame, stats)
}

/// Every pass holds numbers; depth is infinite exactly where nothing is.
#[track_caller]
fn assert_finite(frame: &Frame) {
    assert!(frame.linear.iter().all(|v| v.is_finite()), "linear colour");
    assert!(frame.albedo.iter().all(|v| v.is_finite()), "albedo");
    assert!(frame.normal.iter().all(|v| v.is_finite()), "normal");
    assert!(frame.position.iter().all(|v| v.is_finite()), "position");
    for (depth, id) in frame.depth.iter().zip(&frame.id) {
        assert!(if *id == 0 { *depth == f32::INFINITY } else { depth.is_finite() }, "{depth}");
    }
}

/// Pixels that show something.
fn n_shown(frame: &Frame) -> usize {
    frame.id.iter().filter(|&&id| id > 0).count()
}
