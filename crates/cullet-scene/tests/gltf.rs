//! glTF files made by hand: what is drawn, what is mended, what is refused.

use std::fmt::Write;

use cullet_scene::{ErrorKind, Images, LoadError, LoadOptions, Scene, load_glb_bytes};
use glam::{DVec3, Vec3, Vec4};

/// A document with the given text after its asset, and four accessors over a GLB chunk:
/// 0: a unit square of positions, 1: indices of its two triangles, 2: indices out of
/// range, 3: positions without data.
fn document(rest: &str) -> Vec<u8> {
    let mut data = Vec::new();
    for corner in [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]] {
        data.extend(corner.into_iter().flat_map(f32::to_le_bytes));
    }
    data.extend([0u8, 1, 2, 0, 2, 3, 0, 1, 9, 9, 9, 9]);
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":60}}],
        "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":12}}],
        "accessors":[
        {{"bufferView":0,"count":4,"componentType":5126,"type":"VEC3"}},
        {{"bufferView":1,"count":6,"componentType":5121,"type":"SCALAR"}},
        {{"bufferView":1,"byteOffset":6,"count":6,"componentType":5121,"type":"SCALAR"}},
        {{"count":1099511627776,"componentType":5126,"type":"VEC3"}}]{rest}}}"#
    );
    glb(&json, &data)
}

fn glb(json: &str, data: &[u8]) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((28 + json.len() as u32 + data.len() as u32).to_le_bytes());
    for (kind, content) in [(b"JSON", json.as_slice()), (b"BIN\0", data)] {
        bytes.extend((content.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(content);
    }
    bytes
}

fn load(rest: &str) -> Result<Scene, LoadError> {
    load_glb_bytes(document(rest), "t.glb", &LoadOptions::default())
}

/// A mesh with these primitives on one node that has `node` as further fields.
fn one_mesh(primitives: &str, node: &str) -> String {
    format!(r#","meshes":[{{"primitives":[{primitives}]}}],"nodes":[{{"mesh":0{node}}}]"#)
}

const SQUARE: &str = r#"{"attributes":{"POSITION":0},"indices":1}"#;

#[test]
fn a_square_is_loaded() {
    let scene = load(&one_mesh(SQUARE, r#","translation":[1,2,3]"#)).unwrap();
    assert_eq!(scene.meshes[0].triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(scene.meshes[0].positions[2], Vec3::new(1.0, 1.0, 0.0));
    assert_eq!(scene.objects[0].world_from_model.translation, DVec3::new(1.0, 2.0, 3.0));
    assert_eq!((scene.objects[0].material, &*scene.objects[0].name), (0, "node 0"));
    assert_eq!(scene.materials[0].base_color, Vec4::ONE);
}

#[test]
fn out_of_range_triangles_are_dropped_and_counted() {
    let primitive = r#"{"attributes":{"POSITION":0},"indices":2}"#;
    let error = load(&one_mesh(primitive, "")).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Input);
    assert!(error.to_string().contains("all indices are out of range"), "{error}");

    let scene = load(&one_mesh(&format!("{primitive},{SQUARE}"), "")).unwrap();
    assert_eq!(scene.objects.len(), 1);
    assert!(scene.warnings.iter().any(|warning| warning.contains("2 triangles")));
}

#[test]
fn a_bad_optional_attribute_counts_as_missing() {
    let primitive = r#"{"attributes":{"POSITION":0,"NORMAL":1,"TEXCOORD_0":0},"indices":1}"#;
    let scene = load(&one_mesh(primitive, "")).unwrap();
    assert!(scene.meshes[0].normals.is_none() && scene.meshes[0].uvs[0].is_none());
    let warnings = scene.warnings.join("\n");
    assert!(warnings.contains("NORMAL") && warnings.contains("TEXCOORD_0"), "{warnings}");
}

#[test]
fn claims_without_data_reach_a_limit() {
    let error = load(&one_mesh(r#"{"attributes":{"POSITION":3}}"#, "")).unwrap_err();
    assert!(error.to_string().contains("more vertices"), "{error}");
    let options = LoadOptions { max_triangles: 1, ..LoadOptions::default() };
    let error = load_glb_bytes(document(&one_mesh(SQUARE, "")), "t.glb", &options).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Limit);
    assert!(error.to_string().contains("--max-triangles"), "{error}");
}

/// Loads a document without data in which accessor 0 has 99 million rows, all zero but one,
/// and accessor 1 as many without that one.
fn load_claims(primitive: &str, node: &str) -> Result<Scene, LoadError> {
    let rows = r#""count":99000000,"componentType":5126,"type":"VEC3""#;
    let sparse = r#""sparse":{"count":1,"indices":{"bufferView":0,"componentType":5121},
        "values":{"bufferView":0}}"#;
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":12}}],
        "bufferViews":[{{"buffer":0,"byteLength":12}}],
        "accessors":[{{{rows},{sparse}}},{{{rows}}}]{}}}"#,
        one_mesh(primitive, node)
    );
    let options = LoadOptions { max_decoded_bytes: 1 << 20, ..LoadOptions::default() };
    load_glb_bytes(glb(&json, &[0; 12]), "t.glb", &options)
}

#[track_caller]
fn refuses_to_decode(result: Result<Scene, LoadError>) {
    let error = result.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Limit);
    assert!(error.to_string().contains("--max-decoded-bytes"), "{error}");
}

#[test]
fn what_is_decoded_is_counted_before() {
    let all = r#""NORMAL":1,"TEXCOORD_0":1,"COLOR_0":1"#;
    refuses_to_decode(load_claims(&format!(r#"{{"attributes":{{"POSITION":0,{all}}}}}"#), ""));
    refuses_to_decode(load_claims(
        r#"{"attributes":{"POSITION":1},"targets":[{"POSITION":0}]}"#,
        r#","weights":[1]"#,
    ));
}

#[test]
fn positions_without_data_are_nothing_to_draw() {
    let scene = load_claims(r#"{"attributes":{"POSITION":1,"NORMAL":1}}"#, "").unwrap();
    assert!(scene.objects.is_empty());
    assert!(scene.warnings[1].contains("for lack of data; left out"), "{:?}", scene.warnings);
}

/// The same moves may be asked for again and again.
#[test]
fn morph_targets_are_counted() {
    let targets = [r#"{"POSITION":0}"#; 20_000].join(",");
    let primitive =
        format!(r#"{{"attributes":{{"POSITION":0}},"indices":1,"targets":[{targets}]}}"#);
    let weights = ["1"; 20_000].join(",");
    let rest = one_mesh(&primitive, &format!(r#","weights":[{weights}]"#));
    let options = LoadOptions { max_decoded_bytes: 1 << 20, ..LoadOptions::default() };
    refuses_to_decode(load_glb_bytes(document(&rest), "t.glb", &options));
    assert_eq!(load(&rest).unwrap().meshes[0].positions[1], Vec3::new(20_001.0, 0.0, 0.0));
}

#[test]
fn points_and_lines_are_listed_as_left_out() {
    let primitives =
        [0, 1, 2, 3].map(|mode| format!(r#"{{"attributes":{{"POSITION":0}},"mode":{mode}}}"#));
    let scene = load(&one_mesh(&primitives.join(","), "")).unwrap();
    assert!(scene.objects.is_empty());
    assert_eq!(scene.left_out, ["primitives made of lines: 3", "primitives made of points: 1"]);
}

#[test]
fn hidden_nodes_hide_their_children() {
    let hidden = r#"{"children":[1],"extensions":{"KHR_node_visibility":{"visible":false}}}"#;
    let scene = load(&format!(
        r#","meshes":[{{"primitives":[{SQUARE}]}}],"nodes":[{hidden},{{"mesh":0}},{{"mesh":0}}]"#
    ));
    let scene = scene.unwrap();
    assert_eq!(scene.objects.len(), 1);
    assert_eq!(scene.nodes.len(), 3);
    assert_eq!(scene.left_out, ["hidden nodes with a mesh: 1"]);
}

#[test]
fn instances_become_objects_that_share_a_mesh() {
    let instancing =
        r#","extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":0}}}"#;
    let scene = load(&one_mesh(SQUARE, instancing)).unwrap();
    assert_eq!((scene.objects.len(), scene.meshes.len()), (4, 1));
    assert_eq!(scene.objects[2].world_from_model.translation, DVec3::new(1.0, 1.0, 0.0));
    assert_eq!(scene.objects[2].name, "node 0/instance 2");
}

#[test]
fn a_very_deep_chain_of_nodes_is_walked() {
    let n_nodes = 200_000;
    let mut nodes = String::new();
    for child in 1..n_nodes {
        write!(nodes, r#"{{"children":[{child}],"translation":[1,0,0]}},"#).unwrap();
    }
    let rest = format!(r#","meshes":[{{"primitives":[{SQUARE}]}}],"nodes":[{nodes}{{"mesh":0}}]"#);
    let scene = load(&rest).unwrap();
    assert_eq!(scene.objects[0].world_from_model.translation.x, f64::from(n_nodes - 1));
}

#[test]
fn cycles_and_doubled_children_end_at_once() {
    let doubled: Vec<String> =
        (1..40).map(|child| format!(r#"{{"children":[{child},{child}]}}"#)).collect();
    for nodes in [r#"{"children":[0]}"#, r#"{"children":[1]},{"children":[0]}"#, &doubled.join(",")]
    {
        let rest = format!(r#","scenes":[{{"nodes":[0]}}],"nodes":[{nodes},{{}}]"#);
        let error = load(&rest).unwrap_err().to_string();
        assert!(error.contains("reached twice"), "{error}");
    }
    assert!(load(r#","nodes":[{"children":[0]}]"#).is_err());
}

#[test]
fn a_node_without_finite_transform_is_left_out() {
    let scene = load(&format!(
        r#","meshes":[{{"primitives":[{SQUARE}]}}],
        "nodes":[{{"mesh":0,"scale":[1e200,1,1],"children":[1]}},
        {{"mesh":0,"scale":[1e200,1,1]}},{{"mesh":0}}]"#
    ));
    let scene = scene.unwrap();
    assert_eq!((scene.objects.len(), scene.warnings.len()), (2, 2));
}

#[test]
fn only_images_that_are_asked_for_are_read() {
    let load = |alpha_mode: &str, images| {
        let rest = format!(
            r#","images":[{{"uri":"gone.png"}}],"textures":[{{"source":0}}],
            "materials":[{{"normalTexture":{{"index":0}},"alphaMode":"{alpha_mode}",
            "pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}}]"#
        );
        let primitive = r#"{"attributes":{"POSITION":0},"indices":1,"material":0}"#;
        let options = LoadOptions { images, ..LoadOptions::default() };
        load_glb_bytes(document(&(rest + &one_mesh(primitive, ""))), "t.glb", &options).unwrap()
    };
    let others = "textures other than base colours: 1";
    let not_shown = "images that the passes do not show: 1";
    for (alpha_mode, images, n_warnings, left_out) in [
        ("OPAQUE", Images::BaseColors, 1, &[others][..]),
        ("OPAQUE", Images::Masks, 0, &[not_shown, others]),
        ("MASK", Images::Masks, 1, &[others]),
        ("MASK", Images::None, 0, &[others]),
    ] {
        let scene = load(alpha_mode, images);
        let n = scene.warnings.iter().filter(|warning| warning.contains("gone.png")).count();
        assert_eq!(n, n_warnings, "{alpha_mode} {images:?}: {:?}", scene.warnings);
        assert_eq!(scene.left_out, left_out, "{alpha_mode} {images:?}");
    }
}

#[test]
fn a_missing_texture_becomes_a_visible_placeholder() {
    let rest = r#","images":[{"uri":"gone.png"},{"uri":"unused.png"}],"textures":[{"source":0}],
        "materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}]"#;
    let primitive = r#"{"attributes":{"POSITION":0},"indices":1,"material":0}"#;
    let scene = load(&(rest.to_string() + &one_mesh(primitive, ""))).unwrap();
    assert!(scene.images[0].placeholder && scene.images[0].rgba.len() == 256);
    assert!(!scene.images[1].placeholder && scene.images[1].rgba.is_empty());
    assert_eq!(scene.objects[0].material, 1);
    assert!(scene.warnings.iter().any(|warning| warning.contains("gone.png")));
}

#[test]
fn default_morph_weights_are_applied() {
    let primitive = r#"{"attributes":{"POSITION":0},"indices":1,"targets":[{"POSITION":0}]}"#;
    let scene = load(&one_mesh(primitive, r#","weights":[2]"#)).unwrap();
    assert_eq!(scene.meshes[0].positions[2], Vec3::new(3.0, 3.0, 0.0));
}

#[test]
fn skins_follow_their_joints_and_not_their_node() {
    // Joints and weights are zeros without data: all vertices hang on the first joint.
    let json = r#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":36}],
        "bufferViews":[{"buffer":0,"byteLength":36}],
        "accessors":[{"bufferView":0,"count":3,"componentType":5126,"type":"VEC3"},
        {"count":3,"componentType":5121,"type":"VEC4"},
        {"count":3,"componentType":5126,"type":"VEC4"}],
        "meshes":[{"primitives":[
            {"attributes":{"POSITION":0,"JOINTS_0":1,"WEIGHTS_0":2}}]}],
        "skins":[{"joints":[1]}],
        "nodes":[{"mesh":0,"skin":0,"translation":[100,0,0]},{"translation":[0,5,0]}]}"#;
    let data: Vec<u8> = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]
        .into_iter()
        .flat_map(f32::to_le_bytes)
        .collect();
    let scene = load_glb_bytes(glb(json, &data), "t.glb", &LoadOptions::default()).unwrap();
    assert_eq!(scene.meshes[0].positions[1], Vec3::new(1.0, 5.0, 0.0));
    assert_eq!(scene.objects[0].world_from_model.translation, DVec3::ZERO);
    assert_eq!(scene.warnings.len(), 2, "no scene; vertices without weights");
}

#[test]
fn no_mutation_of_a_file_panics() {
    let instancing =
        r#","extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":0}}}"#;
    let skinned = r#"{"attributes":{"POSITION":0,"NORMAL":0,"JOINTS_0":1,"WEIGHTS_0":1},
        "targets":[{"POSITION":0}],"mode":5}"#;
    let posed = one_mesh(skinned, r#","skin":0,"weights":[1],"children":[1]"#);
    let files = [
        document(&one_mesh(SQUARE, instancing)),
        document(&(posed.trim_end_matches(']').to_string() + r#",{}],"skins":[{"joints":[1]}]"#)),
    ];
    let options =
        LoadOptions { max_nodes: 10_000, max_decoded_bytes: 1 << 24, ..LoadOptions::default() };
    let mut state = 1u64;
    let mut random = move |below: usize| {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 33) as usize % below
    };
    for file in files {
        load_glb_bytes(file.clone(), "t.glb", &options).unwrap();
        for _ in 0..2000 {
            let mut mutant = file.clone();
            for _ in 0..=random(3) {
                let at = random(mutant.len());
                match random(4) {
                    0 => mutant[at] ^= 1 << random(8),
                    1 => mutant[at] = b"0123456789-.e[]{},\""[random(19)],
                    2 => mutant[at] = random(256) as u8,
                    _ => mutant.truncate(at.max(1)),
                }
            }
            let _ = load_glb_bytes(mutant, "t.glb", &options);
        }
    }
}
