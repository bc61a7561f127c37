//! Same input, same bytes: what may not change a pixel, does not.

use cullet::scene::{LoadOptions, load};
use cullet::{CullTest, Frame, Prepared, Region, Renderer, Settings, View, Viewport};
use cullet_tests::{
    all_passes, bytes, cameras, prepare, prepare_file, real_models, render, shipped_scenes,
};

const SIZE: [u32; 2] = [161, 97];

fn settings() -> Settings {
    Settings { passes: all_passes(), ..Settings::default() }
}

/// Draws with each of `variants` from every camera and compares with the first.
#[track_caller]
fn check(name: &str, prepared: &Prepared, variants: &[Settings]) {
    for (i, camera) in cameras(prepared).iter().enumerate() {
        let first = bytes(&render(prepared, camera, SIZE, &variants[0]));
        for variant in &variants[1..] {
            let other = bytes(&render(prepared, camera, SIZE, variant));
            assert!(first == other, "{name}, camera {i}: {variant:?} changes the picture");
        }
    }
}

#[test]
fn neither_culling_nor_threads_change_a_byte_of_the_shipped_scenes() {
    let variants = [
        Settings { threads: 1, ..settings() },
        Settings { threads: 2, ..settings() },
        Settings { threads: 1, cull: CullTest::None, ..settings() },
        Settings { threads: 7, cull: CullTest::None, ..settings() },
    ];
    for path in shipped_scenes() {
        check(&path.display().to_string(), &prepare_file(&path), &variants);
    }
}

#[test]
fn neither_culling_nor_threads_change_a_byte_of_real_models() {
    let Some(folder) = real_models() else { return };
    let variants = [
        Settings { threads: 1, ..settings() },
        Settings { threads: 3, cull: CullTest::None, ..settings() },
    ];
    for model in [
        "FlightHelmet/FlightHelmet.gltf",
        "low-poly-jungle/scene.gltf",
        "terrain/terrain.glb",
        "many-cubes/many-cubes.gltf",
        "CornellBox/CornellBox.glb",
    ] {
        check(model, &prepare_file(&folder.join("scenes").join(model)), &variants);
    }
}

#[test]
fn a_region_is_a_crop() {
    for path in shipped_scenes() {
        let prepared = prepare_file(&path);
        let camera = &cameras(&prepared)[0];
        let whole = render(&prepared, camera, SIZE, &settings());
        for region in [
            Region { x: 0, y: 0, width: 161, height: 97 },
            Region { x: 13, y: 31, width: 70, height: 40 },
            Region { x: 160, y: 96, width: 1, height: 1 },
        ] {
            let settings = Settings { region: Some(region), ..settings() };
            let part = render(&prepared, camera, SIZE, &settings);
            assert_eq!((part.width, part.height), (region.width, region.height));
            assert!(bytes(&part) == bytes(&crop(&whole, region)), "{path:?}: {region:?}");
        }
    }
}

fn crop(frame: &Frame, region: Region) -> Frame {
    fn cut<T: Copy>(values: &[T], width: u32, r: Region) -> Vec<T> {
        let rows = values.chunks(width as usize).skip(r.y as usize).take(r.height as usize);
        let columns = r.x as usize..(r.x + r.width) as usize;
        rows.flat_map(|row| row[columns.clone()].iter().copied()).collect()
    }
    let w = frame.width;
    Frame {
        width: region.width,
        height: region.height,
        rgba8: cut(&frame.rgba8, w, region),
        linear: cut(&frame.linear, w, region),
        depth: cut(&frame.depth, w, region),
        normal: cut(&frame.normal, w, region),
        albedo: cut(&frame.albedo, w, region),
        uv: cut(&frame.uv, w, region),
        position: cut(&frame.position, w, region),
        id: cut(&frame.id, w, region),
        triangle: cut(&frame.triangle, w, region),
    }
}

#[test]
fn scratch_memory_carries_nothing_over() {
    let mut renderer = Renderer::default();
    let mut frame = Frame::default();
    let scenes: Vec<_> = shipped_scenes().iter().map(|path| prepare_file(path)).collect();
    for size in [[64, 48], [33, 57], [80, 20]] {
        let viewport = Viewport::new(size[0], size[1]).unwrap();
        for prepared in &scenes {
            let camera = &cameras(prepared)[0];
            renderer.render(prepared, &View::new(camera, viewport), &settings(), &mut frame);
            let fresh = render(prepared, camera, size, &settings());
            assert!(bytes(&frame) == bytes(&fresh), "{size:?}");
        }
    }
}

/// Model only what a scene requires: data that `lambert` does not read changes nothing.
#[test]
fn unread_data_changes_no_byte() {
    for path in shipped_scenes() {
        let scene = load(&path, &LoadOptions::default()).unwrap();
        let mut loaded = scene.clone();
        for mesh in &mut loaded.meshes {
            let n = mesh.positions.len();
            mesh.uvs[1].get_or_insert_with(|| vec![glam::Vec2::splat(f32::NAN); n]);
            mesh.uvs[0].get_or_insert_with(|| vec![glam::Vec2::splat(7.0); n]);
        }
        let settings = Settings::default();
        let (plain, loaded) = (prepare(scene), prepare(loaded));
        for camera in cameras(&plain) {
            let [a, b] = [&plain, &loaded].map(|p| bytes(&render(p, &camera, SIZE, &settings)));
            assert!(a == b, "{path:?}");
        }
    }
}
