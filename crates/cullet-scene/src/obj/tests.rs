//! Whole OBJ files, written to a folder of their own and loaded.

use std::fs;

use glam::Affine2;

use super::*;
use crate::{AlphaMode, Images, write_glb};

/// Loads `text` as an OBJ file beside further files.
fn loaded_with(text: impl AsRef<[u8]>, others: &[(&str, &[u8])]) -> Result<Scene, LoadError> {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in others {
        fs::write(folder.path().join(name), bytes).unwrap();
    }
    let path = folder.path().join("model.obj");
    fs::write(&path, text).unwrap();
    crate::load(&path, &LoadOptions::default())
}

fn loaded(text: &str) -> Scene {
    loaded_with(text, &[]).unwrap()
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn names(scene: &Scene) -> Vec<&str> {
    scene.objects.iter().map(|object| &*object.name).collect()
}

#[test]
fn a_square_is_two_triangles_without_attributes() {
    let scene = loaded(&format!("{SQUARE}f 1 2 3 4"));
    let mesh = &scene.meshes[0];
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert!(mesh.normals.is_none() && mesh.uvs[0].is_none() && mesh.colors.is_none());
    assert_eq!(names(&scene), ["model"]);
    assert_eq!((scene.warnings.len(), scene.left_out.len()), (0, 0));
    assert!(scene.materials[0].double_sided);
}

#[test]
fn a_concave_quad_keeps_its_notch() {
    let scene = loaded("v 0 0 0\nv 2 0 0\nv 0.5 0.5 0\nv 0 2 0\nf 2 3 4 1");
    assert_eq!(scene.meshes[0].triangles.len(), 2);
    let cut = |[a, b, c]: [u32; 3]| {
        let [a, b, c] = [a, b, c].map(|i| scene.meshes[0].positions[i as usize]);
        (b - a).cross(c - a).z
    };
    assert!(scene.meshes[0].triangles.iter().all(|triangle| cut(*triangle) > 0.0));
}

#[test]
fn attributes_follow_their_corners() {
    let text = format!("{SQUARE}vt 0 0\nvt 0.25 1\nvn 0 0 1\nf 1/1/1 2/2/1 3/1/1");
    let scene = loaded(&text);
    let mesh = &scene.meshes[0];
    assert_eq!(mesh.uvs[0].as_ref().unwrap()[1], Vec2::new(0.25, 0.0));
    assert_eq!(mesh.uvs[0].as_ref().unwrap()[2], Vec2::new(0.0, 1.0));
    assert_eq!(mesh.normals.as_ref().unwrap()[2], Vec3::Z);
}

#[test]
fn groups_and_materials_make_objects() {
    let text = format!(
        "{SQUARE}usemtl a\nf 1 2 3\ng x\nf 1 2 3\nusemtl b\nf 1 3 4\nusemtl a\nf 1 3 4\n\
         g y\nf 1 2 3\ng x\nf 2 3 4"
    );
    let scene = loaded_with(text, &[]).unwrap();
    assert_eq!(names(&scene), ["model/a", "x/a", "x/b", "y/a"]);
    let n_triangles: Vec<_> = scene.meshes.iter().map(|mesh| mesh.triangles.len()).collect();
    assert_eq!(n_triangles, [1, 3, 1, 1]);
    assert_eq!(scene.nodes.len(), 3);
    assert_eq!(scene.warnings.len(), 2, "{:?}", scene.warnings);
    assert!(scene.warnings[0].contains("material `a` is in no material library"));
}

#[test]
fn faces_of_one_group_may_differ_in_attributes() {
    let scene = loaded(&format!("{SQUARE}vn 0 0 1\nf 1//1 2//1 3//1\nf 1 3 4\nf 2//1 3//1 4//1"));
    let smooth: Vec<_> = scene.meshes.iter().map(|mesh| mesh.normals.is_some()).collect();
    assert_eq!(smooth, [true, false]);
    assert_eq!(scene.meshes[0].triangles.len(), 2);
}

#[test]
fn vertex_colors_are_srgb() {
    let scene = loaded("v 0 0 0 1 0 0.5\nv 1 0 0\nv 0 1 0 2 nan 0\nf 1 2 3");
    let colors = scene.meshes[0].colors.as_ref().unwrap();
    assert_eq!(colors[0].to_array(), [1.0, 0.0, 0.214_041_14, 1.0]);
    assert_eq!(colors[1], Vec4::ONE);
}

#[test]
fn materials_are_read_with_their_library() {
    let mtl = b"newmtl red\nKd 1 0.5 0\nd 0.5\nnewmtl green\nKd 0 1 0\nTr 0.25\nmap_d a.png\n";
    let text = format!("{SQUARE}mtllib a b.mtl\nusemtl red\nf 1 2 3\nusemtl green\nf 1 3 4");
    let scene = loaded_with(text, &[("a b.mtl", mtl)]).unwrap();
    assert_eq!(scene.materials.len(), 3);
    assert_eq!(scene.materials[1].base_color, Vec4::new(1.0, 0.5, 0.0, 0.5));
    assert_eq!(scene.materials[2].base_color, Vec4::new(0.0, 1.0, 0.0, 0.75));
    assert_eq!(scene.materials[2].alpha, AlphaMode::Blend);
    assert_eq!(scene.warnings.len(), 2, "{:?}", scene.warnings);
    assert_eq!(scene.left_out, ["maps other than map_Kd: 1"]);
}

#[test]
fn a_library_may_follow_the_faces_and_be_one_of_several() {
    let (a, b) = (b"newmtl a\nKd 0.5\n", b"newmtl b\nKd 1 0 0\n");
    let text = format!("{SQUARE}usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\nmtllib a.mtl b.mtl");
    let scene = loaded_with(text, &[("a.mtl", a), ("b.mtl", b)]).unwrap();
    assert_eq!(scene.warnings, Vec::<String>::new());
    assert_eq!(scene.materials[1].base_color, Vec4::new(0.5, 0.5, 0.5, 1.0));
    assert_eq!(scene.materials[2].base_color.x, 1.0);
}

#[test]
fn maps_are_decoded_once_and_transformed() {
    let image = image::RgbImage::from_pixel(2, 1, image::Rgb([10, 20, 30]));
    let mut png = std::io::Cursor::new(Vec::new());
    image.write_to(&mut png, image::ImageFormat::Png).unwrap();
    let mtl = b"newmtl a\nmap_Kd -s 2 2 1 C:\\work\\my wall.png\nnewmtl b\nKd 0 0 0\nmap_Kd my wall.png\n";
    let text = format!("{SQUARE}mtllib m.mtl\nusemtl a\nf 1 2 3\nusemtl b\nf 1 3 4");
    let scene = loaded_with(text, &[("m.mtl", mtl), ("my wall.png", png.get_ref())]).unwrap();
    let texture = scene.materials[1].base_color_texture.clone().unwrap();
    let expected =
        Affine2::from_scale_angle_translation(Vec2::splat(2.0), 0.0, Vec2::new(0.0, -1.0));
    assert_eq!(texture.transform, Some(expected));
    assert_eq!(scene.images[0].rgba, [10, 20, 30, 255, 10, 20, 30, 255]);
    assert_eq!(scene.materials[2].base_color, Vec4::ONE);
    assert_eq!(scene.warnings.len(), 1, "{:?}", scene.warnings);
}

#[test]
fn missing_files_cost_a_warning_each() {
    let mtl = b"newmtl a\nmap_Kd gone.png\n";
    let text =
        format!("mtllib m.mtl\nmtllib /etc/passwd\nmtllib gone.mtl\n{SQUARE}usemtl a\nf 1 2 3");
    let scene = loaded_with(text, &[("m.mtl", mtl)]).unwrap();
    assert_eq!(scene.warnings.len(), 3, "{:?}", scene.warnings);
    assert!(scene.images[0].placeholder);
    assert_eq!(scene.objects.len(), 1);
}

#[test]
fn files_without_faces_are_empty_scenes() {
    for text in ["# nothing", "v 1 2 3", "g An f Three\nv 1 2 3", "v 0 0 0\nv 1 0 0\nl 1 2"] {
        let scene = loaded(text);
        assert!(scene.objects.is_empty() && scene.nodes.is_empty());
        assert!(scene.warnings.iter().any(|warning| warning.contains("no geometry")), "{text}");
    }
}

#[test]
fn errors_name_the_line() {
    let error = loaded_with("v 0 0 0\nv x 0 0\n", &[]).unwrap_err().to_string();
    assert!(error.ends_with("line 2: `x` is not a number; export the model again"), "{error}");
    assert!(loaded_with(b"\x89PNG\r\n\x1a\n\0\0", &[]).is_err());
    assert!(loaded_with("", &[]).is_err());
}

#[test]
fn limits_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.obj");
    fs::write(&path, format!("{SQUARE}f 1 2 3 4\n")).unwrap();
    let options = LoadOptions { max_triangles: 1, ..LoadOptions::default() };
    let error = crate::load(&path, &options).unwrap_err();
    assert!(error.to_string().contains("--max-triangles"), "{error}");
}

#[test]
fn polygons_of_any_size_end() {
    let mut text = String::from("v 0 0 0\nv 1 0 0\nv 1 1 0\nf");
    for i in 0..30_000 {
        text.push_str([" 1", " 2", " 3"][i % 3]);
    }
    assert_eq!(loaded(&text).meshes[0].triangles.len(), 29_998);
}

#[test]
fn a_loaded_obj_is_written_and_read_again() {
    let mtl = b"newmtl a\nKd 0.2 0.4 0.6\n";
    let text = format!("{SQUARE}mtllib m.mtl\nf 1 2 3\nusemtl a\ng x\nf 1 2 3 4");
    let scene = loaded_with(text, &[("m.mtl", mtl)]).unwrap();
    let bytes = write_glb(&scene).unwrap();
    let again = crate::load_glb_bytes(bytes, "again", &LoadOptions::default()).unwrap();
    assert_eq!(again.meshes[1].positions, scene.meshes[1].positions);
    assert_eq!(again.materials[1].base_color, scene.materials[1].base_color);
}

/// Quadratic work on this takes minutes.
#[test]
fn many_materials_and_maps_are_told_apart() {
    let n = 60_000;
    let (mut text, mut mtl) = (SQUARE.to_owned() + "mtllib m.mtl\n", String::new());
    for i in 0..n {
        text += &format!("usemtl a{i}\nf 1 2 3\n");
        mtl += &format!("newmtl a{i}\nKd 0 0 0\nmap_Kd {i}.png\n");
    }
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("model.obj"), text).unwrap();
    fs::write(folder.path().join("m.mtl"), mtl).unwrap();
    let options = LoadOptions { images: Images::None, ..LoadOptions::default() };
    let scene = crate::load(&folder.path().join("model.obj"), &options).unwrap();
    assert_eq!((scene.objects.len(), scene.images.len(), scene.textures.len()), (n, n, n));
    assert_eq!(scene.warnings.len(), 1, "black Kd");
}
