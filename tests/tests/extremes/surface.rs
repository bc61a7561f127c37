//! Flattened and mirrored nodes, odd textures, denormals, files that lie
//! (numerics 4, items 9, 11, 14 and 15).

use cullet::scene::{
    Image, LoadOptions, Material, Mesh, Sampler, Texture, TextureRef, Wrap, load_glb_bytes,
};
use cullet::{Filter, Frame, Settings, Shading, frame_scene};
use cullet_tests::{Random, bytes, prepare, render};
use glam::{Affine2, DAffine3, DQuat, DVec3, Vec2, Vec3, Vec4};

use crate::{
    INF, ahead, alone, assert_finite, cube, draw, look, mesh, n_shown, perspective, scene,
    settings, square,
};

const SIZE: [u32; 2] = [64, 48];

fn scaled(x: f64, y: f64, z: f64) -> DAffine3 {
    DAffine3::from_scale(DVec3::new(x, y, z))
}

/// A bumpy ball with normals, coordinates and colours, of exact short numbers.
fn ball() -> Mesh {
    let mut random = Random::new(21);
    let short = |x: f64| (x * 1024.0).round() as f32 / 1024.0;
    let (columns, rows) = (12, 8);
    let mut mesh = Mesh::default();
    let (mut normals, mut uvs, mut colors) = (Vec::new(), Vec::new(), Vec::new());
    for row in 0..=rows {
        for column in 0..=columns {
            let [u, v] = [f64::from(column) / f64::from(columns), f64::from(row) / f64::from(rows)];
            let (longitude, latitude) = (u * std::f64::consts::TAU, v * std::f64::consts::PI);
            let (sin, cos) = latitude.sin_cos();
            let out = DVec3::new(sin * longitude.sin(), cos, sin * longitude.cos());
            let bumpy = out * random.within(0.8, 1.2);
            mesh.positions.push(Vec3::new(short(bumpy.x), short(bumpy.y), short(bumpy.z)));
            normals.push(Vec3::new(short(out.x), short(out.y), short(out.z)));
            uvs.push(Vec2::new(short(u), short(v)));
            colors.push(Vec4::new(short(u), short(v), 0.5, 1.0));
            if row > 0 && column > 0 {
                let [d, a] = [row, row - 1].map(|row| row * (columns + 1) + column - 1);
                mesh.triangles.extend([[a, d, d + 1], [a, d + 1, a + 1]]);
            }
        }
    }
    mesh.normals = Some(normals);
    mesh.uvs[0] = Some(uvs);
    mesh.colors = Some(colors);
    mesh
}

/// The mesh with `(x, y, z)` times `scale` in its positions, outside still out.
fn baked(mesh: &Mesh, scale: Vec3) -> Mesh {
    let mirrored = scale.x * scale.y * scale.z < 0.0;
    let mut mesh = mesh.clone();
    mesh.positions.iter_mut().for_each(|p| *p *= scale);
    for normal in mesh.normals.iter_mut().flatten() {
        *normal /= scale;
    }
    if mirrored {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    mesh
}

/// The same faces, and the same of everything else up to the order of additions.
#[track_caller]
fn assert_same_picture(a: &Frame, b: &Frame) {
    assert!(a.triangle == b.triangle && a.id == b.id, "faces differ");
    let near = |a: &[f32], b: &[f32]| {
        a.iter().zip(b).all(|(a, b)| a == b || (a - b).abs() <= 2e-6 * (1.0 + a.abs()))
    };
    for pixel in 0..a.len() {
        assert!(near(&a.linear[pixel].to_array(), &b.linear[pixel].to_array()), "light");
        assert!(near(&a.normal[pixel].to_array(), &b.normal[pixel].to_array()), "normal");
        assert!(near(&a.albedo[pixel].to_array(), &b.albedo[pixel].to_array()), "albedo");
        assert!(near(&a.uv[pixel].to_array(), &b.uv[pixel].to_array()), "uv");
        assert!(near(&a.position[pixel].to_array(), &b.position[pixel].to_array()), "position");
        assert!(near(&[a.depth[pixel]], &[b.depth[pixel]]), "depth");
        let off = (0..4).map(|i| a.rgba8[pixel][i].abs_diff(b.rgba8[pixel][i])).max();
        assert!(off <= Some(1), "colour");
    }
}

#[test]
fn a_mirrored_node_looks_like_a_mirrored_mesh() {
    let smooth = ball();
    let flat = Mesh { normals: None, ..smooth.clone() };
    for mesh in [smooth, flat] {
        for (x, y, z) in [(-1.0, 1.0, 1.0), (1.0, -1.0, 1.0), (1.0, 1.0, -2.0), (-1.0, -0.5, -1.0)]
        {
            let turn = DAffine3::from_rotation_translation(
                DQuat::from_rotation_y(0.7) * DQuat::from_rotation_x(0.4),
                DVec3::new(0.25, -0.5, 1.0),
            );
            let node = turn * scaled(x, y, z);
            let scale = DVec3::new(x, y, z).as_vec3();
            let single_sided = Material::default;
            let mirrored = prepare(scene(single_sided(), &[(mesh.clone(), node)]));
            let expected = prepare(scene(single_sided(), &[(baked(&mesh, scale), turn)]));
            for eye in [DVec3::new(2.0, 3.0, 4.0), DVec3::new(0.3, -0.4, 1.0)] {
                let camera = look(eye, DVec3::new(0.2, -0.5, 0.9), perspective(70.0, 0.05, INF));
                let [(a, stats), (b, _)] = [&mirrored, &expected].map(|p| draw(p, &camera, SIZE));
                assert!(n_shown(&a) > 300 || stats.triangles.n_facing_away > 0);
                assert_same_picture(&a, &b);
            }
        }
    }
}

#[test]
fn a_flattened_node_is_drawn_flat() {
    let turn = DQuat::from_rotation_y(0.5) * DQuat::from_rotation_x(-0.3);
    for axis in 0..3 {
        let mut scale = DVec3::ONE;
        scale[axis] = 0.0;
        let normal = turn * (DVec3::ONE - scale);
        let node =
            DAffine3::from_scale_rotation_translation(scale, turn, DVec3::new(0.1, 0.2, 0.3));
        for mesh in [cube(), Mesh { normals: None, ..ball() }, ball()] {
            for side in [1.0, -1.0] {
                let single_sided = prepare(scene(Material::default(), &[(mesh.clone(), node)]));
                let camera = look(
                    node.translation + normal * 4.0 * side,
                    node.translation,
                    perspective(45.0, 0.1, INF),
                );
                let (frame, _) = draw(&single_sided, &camera, SIZE);
                assert_finite(&frame);
                assert!(n_shown(&frame) > 300, "axis {axis}: {}", n_shown(&frame));
                for (seen, _) in frame.normal.iter().zip(&frame.id).filter(|(_, id)| **id > 0) {
                    // Smooth normals of a bumpy ball may look away where its faces do not.
                    let along = seen.as_dvec3().dot(normal * side);
                    let along = if mesh.normals.is_some() { along.abs() } else { along };
                    assert!(along > 0.9999, "axis {axis}, side {side}: {seen} against {normal}");
                }
            }
        }
    }
}

/// A product of rotations and a flat scale has a determinant of rounding noise.
#[test]
fn a_flattened_node_in_a_turned_one_is_not_mirrored() {
    let mut random = Random::new(22);
    for _ in 0..50 {
        let mut turn = || {
            let axis = DVec3::from_array([0; 3].map(|_| random.within(-1.0, 1.0))).normalize();
            DAffine3::from_quat(DQuat::from_axis_angle(axis, random.within(0.1, 3.0)))
        };
        let (outer, inner) = (turn(), turn());
        let node = outer * scaled(1.0, 1.0, 0.0) * inner;
        let front = node.transform_vector3(DVec3::X).cross(node.transform_vector3(DVec3::Y));
        let prepared = prepare(scene(Material::default(), &[(square(), node)]));
        for (side, n_away) in [(4.0, 0), (-4.0, 2)] {
            let eye = front.normalize() * side;
            let camera = look(eye, DVec3::ZERO, perspective(45.0, 0.1, INF));
            let (_, stats) = draw(&prepared, &camera, SIZE);
            assert_eq!(stats.triangles.n_facing_away, n_away, "{node:?}");
        }
    }
}

#[test]
fn a_node_without_extent_shows_nothing() {
    let camera = look(DVec3::new(2.0, 3.0, 4.0), DVec3::ZERO, perspective(60.0, 0.1, INF));
    for scale in [scaled(0.0, 0.0, 0.0), scaled(-0.0, 0.0, -0.0)] {
        for mesh in [cube(), ball()] {
            let (frame, _) = draw(&alone(mesh, scale), &camera, SIZE);
            assert_eq!(n_shown(&frame), 0);
        }
    }
}

/// The square with one texture and these coordinates at its corners.
fn textured(size: [u32; 2], sampler: Sampler, uvs: [Vec2; 4], transform: Option<Affine2>) -> Frame {
    let [width, height] = size;
    let mut random = Random::new(23);
    let rgba = (0..width * height * 4).map(|_| random.bits() as u8).collect();
    let texture = TextureRef { texture: 0, uv_set: 0, transform };
    let material = Material { base_color_texture: Some(texture), ..Material::default() };
    let mesh = Mesh { uvs: [Some(uvs.to_vec()), None], ..square() };
    let place = DAffine3::from_rotation_translation(
        DQuat::from_rotation_x(-1.2),
        DVec3::new(0.0, 0.0, -2.0),
    );
    let mut scene = scene(material, &[(mesh, place)]);
    scene.images = vec![Image { width, height, rgba, ..Image::default() }];
    scene.textures = vec![cullet::scene::Texture { image: 0, sampler }];
    let prepared = prepare(scene);
    let camera = ahead(perspective(60.0, 0.1, INF));
    let mut last = None;
    for filter in [Filter::Nearest, Filter::Bilinear, Filter::Trilinear] {
        let [one, many] = [1, 3].map(|threads| {
            let settings = Settings { filter, threads, shading: Shading::Unlit, ..settings() };
            render(&prepared, &camera, [32, 24], &settings)
        });
        assert!(n_shown(&one) > 50 && bytes(&one) == bytes(&many));
        assert_finite(&one);
        let inside = |c: &Vec4| c.min_element() >= 0.0 && c.max_element() <= 1.0;
        assert!(one.albedo.iter().all(inside), "{size:?} {uvs:?} {filter:?}");
        last = Some(one);
    }
    last.expect("three frames")
}

#[test]
fn any_texture_at_any_coordinates_has_a_colour() {
    let extremes =
        [0.0, -0.5, 3.0, 1e30, -1e30, f32::MAX, f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    for size in [[1, 1], [1, 7], [5, 1], [3, 5], [64, 64], [16384, 1], [1, 16384]] {
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            let sampler = Sampler { wrap_u: wrap, wrap_v: wrap, ..Sampler::default() };
            for (i, &extreme) in extremes.iter().enumerate() {
                let mut uvs = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
                uvs[i % 4].x = extreme;
                uvs[(i + 1) % 4].y = extreme;
                textured(size, sampler, uvs, None);
            }
            let everywhere = [Vec2::new(0.3, 0.6); 4];
            let far_away = Affine2::from_scale(Vec2::new(1e30, -1e38));
            textured(size, sampler, everywhere, Some(far_away));
        }
    }
}

/// Bad numbers in what is not a position: a picture of numbers, the same for every thread count.
#[test]
fn attributes_that_are_no_numbers_give_a_picture_of_numbers() {
    let camera = look(DVec3::new(2.0, 3.0, 4.0), DVec3::ZERO, perspective(60.0, 0.1, INF));
    let extremes = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, 1e-45, 0.0];
    for bad in extremes {
        for kind in 0..3 {
            let mut mesh = ball();
            match kind {
                0 => mesh.normals.iter_mut().flatten().step_by(3).for_each(|n| n.y = bad),
                1 => mesh.uvs[0].iter_mut().flatten().step_by(3).for_each(|uv| uv.x = bad),
                _ => mesh.normals.iter_mut().flatten().for_each(|n| *n = Vec3::splat(bad)),
            }
            let prepared = alone(mesh, DAffine3::IDENTITY);
            let [one, many] = [1, 3].map(|threads| {
                render(&prepared, &camera, SIZE, &Settings { threads, ..settings() })
            });
            assert!(n_shown(&one) > 100 && bytes(&one) == bytes(&many), "{bad}, kind {kind}");
            assert_finite(&one);
        }
    }
}

/// Denormal attributes and coordinates are numbers like others.
#[test]
fn denormal_coordinates_are_ordinary() {
    let tiny = 2_f64.powi(-148);
    let positions = [(-3.0, -2.0, 1.0), (4.0, -1.0, -2.0), (1.0, 3.0, 2.0), (-2.0, 2.0, -1.0)];
    let positions = positions.map(|(x, y, z)| DVec3::new(x, y, z));
    let triangles = [[0, 1, 2], [0, 2, 3]];
    let camera = look(DVec3::new(2.0, 3.0, 9.0), DVec3::ZERO, perspective(60.0, 0.1, INF));
    let drawn = |scale: f64| {
        let mesh = mesh(&positions.map(|p| (p * scale).as_vec3()), &triangles);
        let (frame, stats) =
            draw(&alone(mesh, DAffine3::from_scale(DVec3::splat(1.0 / scale))), &camera, SIZE);
        assert_eq!(stats.triangles.n_drawn, 2);
        frame
    };
    let ordinary = drawn(1.0);
    assert!(n_shown(&ordinary) > 300 && bytes(&ordinary) == bytes(&drawn(tiny)));
}

/// Two squares in a file that says about its positions whatever `bounds` says.
fn file(bounds: &str) -> Vec<u8> {
    let mut data = Vec::new();
    let corners = [[-1.0f32, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    data.extend(corners.as_flattened().iter().flat_map(|v| v.to_le_bytes()));
    data.extend([0, 1, 2, 0, 2, 3u16].iter().flat_map(|v| v.to_le_bytes()));
    let mut json = format!(
        r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":60}}],
        "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":12}}],
        "accessors":[{{"bufferView":0,"count":4,"componentType":5126,"type":"VEC3"{bounds}}},
        {{"bufferView":1,"count":6,"componentType":5123,"type":"SCALAR"}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
        "nodes":[{{"mesh":0}},{{"mesh":0,"translation":[2,1,0.5]}}]}}"#
    );
    json.extend(std::iter::repeat_n(' ', json.len().next_multiple_of(4) - json.len()));
    let length = |n: usize| (n as u32).to_le_bytes();
    let total = length(28 + json.len() + data.len());
    let [json_length, data_length] = [length(json.len()), length(data.len())];
    let parts: [&[u8]; 9] = [
        b"glTF",
        &[2, 0, 0, 0],
        &total,
        &json_length,
        b"JSON",
        json.as_bytes(),
        &data_length,
        b"BIN\0",
        &data,
    ];
    parts.concat()
}

#[test]
fn bounds_come_from_the_data_whatever_a_file_says() {
    let drawn = |bounds: &str| {
        let loaded = load_glb_bytes(file(bounds), "lie.glb", &LoadOptions::default());
        let prepared = prepare(loaded.unwrap_or_else(|e| panic!("{e}")));
        let camera = frame_scene(&prepared, 4.0 / 3.0);
        (bytes(&draw(&prepared, &camera, SIZE).0), camera)
    };
    let honest = drawn(r#","min":[-1,-1,0],"max":[1,1,0]"#);
    for lie in [
        r#","min":[0,0,0],"max":[0,0,0]"#,
        r#","min":[5,5,5],"max":[6,6,6]"#,
        r#","min":[1e30,1,0],"max":[-1e30,-1,0]"#,
        r#","min":[-1e38,-1e38,-1e38],"max":[1e38,1e38,1e38]"#,
    ] {
        assert!(drawn(lie) == honest, "{lie}");
    }
}

#[test]
fn textures_without_pixels_are_white() {
    let texture = Texture { image: 0, sampler: Sampler::default() };
    let reference = TextureRef { texture: 0, uv_set: 0, transform: None };
    let material = Material { base_color_texture: Some(reference), ..Material::default() };
    let place = DAffine3::from_translation(DVec3::new(0.0, 0.0, -3.0));
    let mut scene = scene(material, &[(square(), place)]);
    scene.images = vec![Image::default()];
    scene.textures = vec![texture];
    let (frame, _) = draw(&prepare(scene), &ahead(perspective(60.0, 0.1, INF)), SIZE);
    assert!(n_shown(&frame) > 300);
    assert!(frame.albedo.iter().zip(&frame.id).all(|(a, id)| *id == 0 || *a == Vec4::ONE));
}
