//! Same input, same bytes: what may not change a pixel, does not.

use cullet::cull::wide::levels;
use cullet::scene::{LoadOptions, load_glb_bytes};
use cullet::{
    Antialias, CullTest, DepthKind, Frame, PointLight, Prepared, Region, Renderer, Settings,
    ShadingRate, SubpixelBits, Transforms, View, Viewport,
};
use cullet_tests::{
    all_passes, bytes, cameras, prepare, prepare_file, prepare_synth, real_models, render,
    shipped_scenes,
};
use glam::Vec3;
use serde_json::json;

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

/// Every test, with and without the tree, on various numbers of threads, after one plain frame.
fn variants() -> Vec<Settings> {
    let plain = Settings { threads: 1, cull: CullTest::None, hierarchy: false, ..settings() };
    let mut variants = vec![plain];
    for (i, cull) in CullTest::ALL.into_iter().enumerate() {
        for hierarchy in [false, true] {
            variants.push(Settings { threads: 1 + i % 3, cull, hierarchy, ..settings() });
        }
    }
    for (tile_px, occlusion) in [(32, true), (64, false), (128, true), (24, false)] {
        variants.push(Settings { tile_px, occlusion, threads: 2, ..settings() });
    }
    for (_, simd) in levels() {
        variants.push(Settings { threads: 7, simd, ..settings() });
    }
    variants
}

#[test]
fn neither_culling_nor_threads_change_a_byte_of_the_shipped_scenes() {
    for path in shipped_scenes() {
        check(&path.display().to_string(), &prepare_file(&path), &variants());
    }
}

#[test]
fn neither_culling_nor_threads_change_a_byte_of_real_models() {
    let Some(folder) = real_models() else { return };
    for model in [
        "FlightHelmet/FlightHelmet.gltf",
        "low-poly-jungle/scene.gltf",
        "terrain/terrain.glb",
        "many-cubes/many-cubes.gltf",
        "CornellBox/CornellBox.glb",
    ] {
        check(model, &prepare_file(&folder.join("scenes").join(model)), &variants());
    }
}

/// What changes the picture does not let show how it was drawn either.
#[test]
fn no_switch_lets_culling_tiles_or_threads_show() {
    let prepared = prepare_synth("masks");
    let bounds = prepared.bounds();
    let radius = 0.4 * bounds.half_extent().length() as f32;
    let light = PointLight::new(bounds.center(), Vec3::new(5.0, 3.0, 1.0), radius).unwrap();
    let mut switches = vec![
        Settings { antialias: Antialias::Ssaa4, ..settings() },
        Settings { antialias: Antialias::Ssaa16, ..settings() },
        Settings { transforms: Transforms::F32, ..settings() },
        Settings { shading_rate: ShadingRate::Two, ..settings() },
        Settings { point_light: Some(light), ..settings() },
    ];
    for (subpixel_bits, depth_format) in SubpixelBits::ALL.into_iter().zip(DepthKind::ALL) {
        switches.push(Settings { subpixel_bits, ..settings() });
        switches.push(Settings { depth_format, ..settings() });
    }
    let (_, plainest) = levels()[0];
    for camera in &cameras(&prepared)[..2] {
        for switch in &switches {
            let draw = |settings: &Settings| bytes(&render(&prepared, camera, SIZE, settings));
            let expected = draw(switch);
            for variant in [
                Settings { cull: CullTest::None, hierarchy: false, threads: 1, ..*switch },
                Settings { occlusion: false, tile_px: 24, threads: 3, ..*switch },
                Settings { tile_px: 256, simd: plainest, ..*switch },
            ] {
                assert!(draw(&variant) == expected, "{variant:?} changes the picture");
            }
        }
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

/// Model only what a scene requires: tangents, normal maps and second texture coordinates that a
/// file has and `lambert` does not read change nothing.
#[test]
fn unread_data_changes_no_byte() {
    for path in shipped_scenes() {
        let plain = std::fs::read(&path).unwrap();
        let loaded = with_unread_data(&plain);
        let [plain, loaded] = [plain, loaded]
            .map(|bytes| prepare(load_glb_bytes(bytes, "test", &LoadOptions::default()).unwrap()));
        for camera in cameras(&plain) {
            let settings = Settings::default();
            let [a, b] = [&plain, &loaded].map(|p| bytes(&render(p, &camera, SIZE, &settings)));
            assert!(a == b, "{path:?}");
        }
    }
}

/// The same GLB with tangents, a second set of texture coordinates (both all zero, so without
/// bytes) and, where it has a texture at all, a normal map on every material.
fn with_unread_data(glb: &[u8]) -> Vec<u8> {
    let word = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().unwrap()) as usize;
    let json_end = 20 + word(12);
    let mut root: serde_json::Value = serde_json::from_slice(&glb[20..json_end]).unwrap();
    let counts: Vec<_> =
        root["accessors"].as_array().unwrap().iter().map(|a| a["count"].clone()).collect();
    let mut added = Vec::new();
    for mesh in root["meshes"].as_array_mut().unwrap() {
        for primitive in mesh["primitives"].as_array_mut().unwrap() {
            let attributes = primitive["attributes"].as_object_mut().unwrap();
            let count = &counts[attributes["POSITION"].as_u64().unwrap() as usize];
            for (name, kind) in [("TANGENT", "VEC4"), ("TEXCOORD_1", "VEC2")] {
                attributes.insert(name.into(), (counts.len() + added.len()).into());
                let accessor = json!({"componentType": 5126, "count": count, "type": kind});
                added.push(accessor);
            }
        }
    }
    root["accessors"].as_array_mut().unwrap().extend(added);
    if root.get("textures").is_some() {
        for material in root["materials"].as_array_mut().unwrap() {
            material["normalTexture"] = json!({"index": 0});
        }
    }
    let mut json = serde_json::to_vec(&root).unwrap();
    json.resize(json.len().next_multiple_of(4), b' ');
    let rest = &glb[json_end..];
    let mut out = glb[..8].to_vec();
    out.extend((20 + json.len() + rest.len()).to_le_bytes()[..4].iter());
    out.extend((json.len() as u32).to_le_bytes());
    out.extend(b"JSON");
    out.extend(json);
    out.extend(rest);
    out
}
