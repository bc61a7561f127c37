//! Scenes that differ in one number only: how much is seen, hidden, or outside the view.

use cullet::scene::{Lens, Material, Mesh, Node, Object, Scene, SceneCamera, synth};
use glam::{DAffine3, DVec3, Vec3, Vec4};

/// Triangles of one instance, about ten thousand.
pub const PER_INSTANCE: usize = 9_940;

/// One smooth sphere of about `n` triangles that fills much of the view.
pub fn sphere(n: usize) -> Scene {
    let around = (n as f64).sqrt().round().clamp(3.0, 2048.0);
    synth::synth(&format!("sphere:{around}")).expect("a sphere")
}

/// The view looks along -z at a sphere; about `n` further triangles, instances of one mesh, stand
/// where no part of them can be seen: in the space behind the camera.
pub fn outside(n: usize) -> Scene {
    let mut scene = stage();
    strew(&mut scene, n, DVec3::new(0.0, 0.0, 120.0), 100.0);
    scene
}

/// As [`outside`], but the instances stand in the view behind a wall that covers all of it.
pub fn hidden(n: usize) -> Scene {
    let mut scene = stage();
    let wall = Mesh {
        name: "wall".into(),
        positions: [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
            .map(|[x, y]| Vec3::new(x, y, 0.0))
            .to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    scene.meshes.push(wall);
    let place = DAffine3::from_translation(DVec3::new(0.0, 0.0, -6.0))
        * DAffine3::from_scale(DVec3::new(12.0, 12.0, 1.0));
    put(&mut scene, 1, place);
    // Wholly inside the view: at that distance it is 66 high.
    strew(&mut scene, n, DVec3::new(0.0, 0.0, -80.0), 25.0);
    scene
}

/// A sphere in front of a camera at the origin.
fn stage() -> Scene {
    let mut mesh = sphere(PER_INSTANCE).meshes.swap_remove(0);
    mesh.name = "sphere".into();
    let clay = Material { base_color: Vec4::new(0.7, 0.45, 0.3, 1.0), ..Material::default() };
    let mut scene = Scene {
        name: "growing".into(),
        meshes: vec![mesh],
        materials: vec![clay],
        ..Scene::default()
    };
    put(&mut scene, 0, DAffine3::from_translation(DVec3::new(0.0, 0.0, -4.0)));
    scene.nodes.push(Node {
        name: "camera".into(),
        parent: None,
        world_from_node: DAffine3::IDENTITY,
    });
    scene.cameras.push(SceneCamera {
        name: "camera".into(),
        node: scene.nodes.len() - 1,
        world_from_camera: DAffine3::IDENTITY,
        lens: Lens::Perspective { yfov: 0.785, aspect: None, near: 0.1, far: f64::INFINITY },
    });
    scene
}

/// About `n` triangles as instances on a cubic lattice around `center`, within `extent` of it.
fn strew(scene: &mut Scene, n: usize, center: DVec3, extent: f64) {
    let n_instances = n.div_ceil(PER_INSTANCE);
    let side = (n_instances as f64).cbrt().ceil() as usize;
    let step = 2.0 * extent / side as f64;
    for i in 0..n_instances {
        let cell = [i % side, i / side % side, i / (side * side)].map(|k| k as f64 + 0.5);
        let at = center + DVec3::from_array(cell) * step - extent;
        let size = DVec3::splat(0.4 * step.min(2.0));
        put(scene, 0, DAffine3::from_translation(at) * DAffine3::from_scale(size));
    }
}

fn put(scene: &mut Scene, mesh: usize, world_from_model: DAffine3) {
    let name = format!("{} {}", scene.meshes[mesh].name, scene.objects.len());
    let node = scene.nodes.len();
    scene.nodes.push(Node { name: name.clone(), parent: None, world_from_node: world_from_model });
    scene.objects.push(Object { name, node, mesh, material: 0, world_from_model });
}
