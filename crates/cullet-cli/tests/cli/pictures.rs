use crate::run::{Folder, TRIANGLE};

const ALL: &str = "color,depth,normal,albedo,uv,position,id,triangle";

#[test]
fn several_passes_stand_before_the_extension() {
    let folder = Folder::new();
    folder.ok(&format!("render synth:sphere:8 --size 16x12 -o x.png --passes {ALL}"));
    let names: Vec<String> = ALL.split(',').map(|pass| format!("x.{pass}.png")).collect();
    let mut sorted = names.clone();
    sorted.sort();
    assert_eq!(folder.names(), sorted);
    folder.ok("render synth:sphere:8 --size 16x12 -o one.png --passes id");
    assert_eq!(folder.read("one.png"), folder.read("x.id.png"));
}

#[test]
fn a_region_equals_the_crop_in_every_pass() {
    let folder = Folder::new();
    let scene = "render synth:masks --size 64x48 --camera 0";
    folder.ok(&format!("{scene} -o all.png --bits 16 --passes {ALL}"));
    folder.ok(&format!("{scene} -o part.png --bits 16 --passes {ALL} --region 13,7,30,21"));
    for pass in ALL.split(',') {
        let all = folder.image(&format!("all.{pass}.png")).crop_imm(13, 7, 30, 21);
        assert_eq!(all, folder.image(&format!("part.{pass}.png")), "{pass}");
    }
}

#[test]
fn raw_floats_have_the_promised_channels() {
    let folder = Folder::new();
    folder.ok(&format!("render synth:sphere:8 --size 16x12 -o x.f32 --passes {ALL}"));
    for (pass, channels) in [
        ("color", 4),
        ("depth", 1),
        ("normal", 3),
        ("albedo", 4),
        ("uv", 2),
        ("position", 3),
        ("id", 1),
        ("triangle", 1),
    ] {
        let length = folder.read(&format!("x.{pass}.f32")).len();
        assert_eq!(length, 16 * 12 * channels * 4, "{pass}");
    }
    let first = |pass: &str| folder.read(&format!("x.{pass}.f32"))[..4].to_vec();
    assert_eq!(first("depth"), f32::INFINITY.to_le_bytes());
    assert_eq!(first("color"), 0.02f32.to_le_bytes());
}

#[test]
fn every_format_can_be_read_back() {
    let folder = Folder::new();
    for format in ["png", "jpg", "webp", "ppm", "exr"] {
        let fits = |pass: &&str| format != "jpg" || !["id", "triangle"].contains(pass);
        for pass in ALL.split(',').filter(fits) {
            let line = format!("render synth:sphere:8 --size 16x12 -o x.{format} --passes {pass}");
            folder.ok(&line);
            assert_eq!(folder.image(&format!("x.{format}")).width(), 16, "{line}");
        }
    }
}

#[test]
fn transparency_is_kept_and_the_default_background_is_that_of_the_contract() {
    let folder = Folder::new();
    folder.ok("render synth:sphere:8 --size 16x12 -o clear.png --background transparent");
    assert_eq!(folder.image("clear.png").to_rgba8()[(0, 0)].0, [0, 0, 0, 0]);
    assert_eq!(folder.image("clear.png").to_rgba8()[(8, 6)].0[3], 255);
    // Where no background shows, no file need hold it.
    let depth = "render synth:sphere:8 --size 16x12 --passes depth -o";
    folder.ok(&format!("{depth} clear.ppm --background transparent"));
    folder.ok(&format!("{depth} x.ppm"));
    assert_eq!(folder.image("clear.ppm"), folder.image("x.ppm"));
    folder.ok("render synth:sphere:8 --size 16x12 -o x.png");
    assert_eq!(folder.image("x.png").to_rgba8()[(0, 0)].0, [39, 48, 63, 255]);
}

#[test]
fn time_saving_options_change_no_pixel() {
    let folder = Folder::new();
    let scene = "render synth:city:2 --size 64x48 --camera 0";
    folder.ok(&format!("{scene} -o x.png"));
    for (i, option) in
        ["--cull none", "--threads 1", "--threads 3", "--frames 3", "--png-compression best"]
            .into_iter()
            .enumerate()
    {
        folder.ok(&format!("{scene} -o {i}.png {option}"));
        assert_eq!(folder.image(&format!("{i}.png")), folder.image("x.png"), "{option}");
    }
}

#[test]
fn the_ray_caster_draws_the_same_objects() {
    let folder = Folder::new();
    let scene = "render synth:box-grid:2 --size 48x32 --passes id";
    folder.ok(&format!("{scene} -o raster.png"));
    folder.ok(&format!("{scene} -o cast.png --renderer raycast"));
    folder.ok("diff raster.png cast.png --fail-above max=0");
    folder.ok(&format!("{scene} -o exact.png --renderer raycast --raycast-geometry exact"));
}

#[test]
fn the_size_comes_from_the_option_the_camera_file_or_nowhere() {
    let folder = Folder::new();
    let camera = r#"{"eye":["0x1.8p+1",2,5],"target":[0,0,0],"up":[0,1,0],"yfov_deg":"45",
        "znear":0.1,"zfar":null SIZE}"#;
    folder.write("sized.json", camera.replace("SIZE", r#","width":20,"height":10"#));
    folder.write("plain.json", camera.replace("SIZE", ""));
    for (options, size) in [
        ("--camera sized.json", (20, 10)),
        ("--camera sized.json --size 8x9", (8, 9)),
        ("--camera plain.json", (1280, 720)),
    ] {
        folder.ok(&format!("render synth:sphere:8 -o x.png {options}"));
        let image = folder.image("x.png");
        assert_eq!((image.width(), image.height()), size, "{options}");
    }
}

#[test]
fn a_scene_camera_goes_by_index_and_by_name() {
    let folder = Folder::new();
    folder.ok("synth knots -o knots.glb");
    let info = folder.ok("info knots.glb --json").stdout;
    let info: serde_json::Value = serde_json::from_slice(&info).unwrap();
    let name = info["cameras"][0]["name"].as_str().unwrap();
    folder.ok("render knots.glb --size 16x12 -o index.png --camera 0");
    let named =
        folder.command("render knots.glb --size 16x12 -o name.png --camera").arg(name).status();
    assert!(named.unwrap().success());
    assert_eq!(folder.read("index.png"), folder.read("name.png"));
}

#[test]
fn the_legend_names_what_the_id_picture_shows() {
    let folder = Folder::new();
    folder.ok("render synth:spheres --size 64x48 --camera 0 -o x.png --passes id --legend l.json");
    let ids = folder.image("x.png").to_rgb8();
    let legend = folder.json("l.json");
    assert_eq!((&legend["schema"], &legend["width"]), (&1.into(), &64.into()));
    let objects = legend["objects"].as_array().unwrap();
    assert!(!objects.is_empty());
    let mut n_pixels = 0;
    for object in objects {
        let id = object["id"].as_u64().unwrap();
        let shown =
            |p: &&image::Rgb<u8>| id == u64::from(u32::from_be_bytes([0, p[0], p[1], p[2]]));
        assert_eq!(object["pixels"].as_u64(), Some(ids.pixels().filter(shown).count() as u64));
        assert!(object["name"].is_string() && object["path"].is_array());
        n_pixels += object["pixels"].as_u64().unwrap();
    }
    let background = ids.pixels().filter(|p| p.0 == [0; 3]).count() as u64;
    assert_eq!(n_pixels + background, 64 * 48);
    assert_eq!(legend["region"], serde_json::json!([0, 0, 64, 48]));
    let part = "render synth:spheres --size 64x48 --camera 0 -o y.png --region 20,10,30,30";
    folder.ok(&format!("{part} --legend part.json"));
    let part = folder.json("part.json");
    assert_eq!(part["region"], serde_json::json!([20, 10, 30, 30]));
    for object in part["objects"].as_array().unwrap() {
        let sides = object["bounds"].as_array().unwrap();
        assert!(sides.iter().all(|side| side.as_u64() <= Some(30)), "{object}");
    }
}

#[test]
fn the_triangle_pass_numbers_triangles() {
    let folder = Folder::new();
    folder.write("one.gltf", TRIANGLE);
    folder.ok("render one.gltf --size 16x12 -o x.png --passes triangle");
    let picture = folder.image("x.png").to_rgb8();
    assert!(picture.pixels().any(|pixel| pixel.0 == [0, 0, 1]));
    assert!(picture.pixels().all(|pixel| pixel.0 == [0, 0, 1] || pixel.0 == [0, 0, 0]));
}

#[test]
fn nothing_to_draw_is_a_background_and_a_word() {
    let folder = Folder::new();
    folder.write("empty.gltf", r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{}]}"#);
    let ran = folder.ok("render empty.gltf --size 16x12 -o x.png --passes color,depth,id,position");
    assert!(ran.stderr.contains("nothing to draw"), "{}", ran.stderr);
    assert_eq!(folder.image("x.color.png").to_rgb8()[(3, 3)].0, [39, 48, 63]);
    assert_eq!(folder.image("x.depth.png").to_luma8()[(3, 3)].0, [255]);
}

#[test]
fn an_empty_picture_says_why() {
    let folder = Folder::new();
    folder.write("one.gltf", TRIANGLE);
    for (eye, target, why) in [
        ("[0,0,3]", "[0,0,9]", "outside the view"),
        ("[0,0,-3]", "[0,0,0]", "all 1 triangles in view face away"),
        ("[0,0,1e5]", "[0.1,0.3,0]", "covers a pixel centre"),
    ] {
        folder.write(
            "cam.json",
            format!(
                r#"{{"eye":{eye},"target":{target},"up":[0,1,0],"yfov_deg":90,"znear":0.1,"zfar":null}}"#
            ),
        );
        for cull in ["none", "p-vertex"] {
            let line = "render one.gltf --size 16x12 -o x.png --camera cam.json --cull";
            let ran = folder.ok(&format!("{line} {cull}"));
            assert!(ran.stderr.contains(why), "{why}: {}", ran.stderr);
        }
    }
}

#[test]
fn images_that_nothing_needs_are_not_read() {
    let folder = Folder::new();
    let image = r#"{"images":[{"name":"spare","uri":"none.png"}],"#;
    folder.write("spare.gltf", TRIANGLE.replacen('{', image, 1));
    let info = folder.ok("info spare.gltf --json").stdout;
    let info: serde_json::Value = serde_json::from_slice(&info).unwrap();
    assert!(info["images"][0]["width"].is_null(), "{}", info["images"]);
    let text = String::from_utf8(folder.ok("info spare.gltf").stdout).unwrap();
    assert!(text.contains("`spare` not read"), "{text}");
}

#[test]
fn info_tells_bounds_and_counts() {
    let folder = Folder::new();
    folder.write("one.gltf", TRIANGLE);
    let info = folder.ok("info one.gltf --json").stdout;
    let info: serde_json::Value = serde_json::from_slice(&info).unwrap();
    assert_eq!(info["bounds"]["min"], serde_json::json!([0.0, 0.0, 0.0]));
    assert_eq!(info["bounds"]["max"], serde_json::json!([1.0, 1.0, 0.0]));
    assert_eq!((&info["counts"]["triangles"], &info["schema"]), (&1.into(), &1.into()));
    for key in ["name", "needs", "cameras", "animations", "extensions", "left_out", "warnings"] {
        assert!(!info[key].is_null(), "{key}");
    }
    let text = String::from_utf8(folder.ok("info one.gltf").stdout).unwrap();
    assert!(
        text.lines().any(|l| l.starts_with("bounds max") && l.ends_with(" 1.0, 1.0, 0.0")),
        "{text}"
    );
}
