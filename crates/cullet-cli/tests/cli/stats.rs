use crate::run::Folder;

#[test]
fn every_key_of_the_contract_is_there() {
    let folder = Folder::new();
    folder.ok("render synth:sphere:8 --size 32x24 -o x.png --stats s.json --frames 3");
    let stats = folder.json("s.json");
    for key in ["frame", "min_ms", "median_ms", "cpu_min_ms", "total"] {
        assert!(stats[key].as_f64().is_some_and(|ms| ms >= 0.0), "{key}: {}", stats[key]);
    }
    for key in ["load", "prepare", "cull", "geometry", "raster", "shade", "resolve", "encode"] {
        assert!(stats["stages"][key].is_number(), "{key}");
    }
    for key in ["objects", "clusters", "triangles"] {
        let counters = &stats[key];
        let culled = counters["culled"].as_object().unwrap().values();
        let culled: u64 = culled.map(|n| n.as_u64().unwrap()).sum();
        let drawn = counters["drawn"].as_u64().unwrap();
        assert_eq!(counters["in"].as_u64().unwrap(), culled + drawn, "{counters}");
    }
    for key in ["boxes_tested", "pixels_shaded", "scratch_bytes"] {
        assert!(stats[key].as_u64().is_some_and(|n| n > 0), "{key}");
    }
    assert!(stats["triangles"]["clipped"].is_u64());
    for key in ["geometry", "images", "pyramids", "clusters"] {
        assert!(stats["parts"][key].as_f64().is_some_and(|ms| ms >= 0.0), "{key}");
    }
    for key in ["warnings", "left_out"] {
        assert!(stats[key].is_array(), "{key}");
    }
    assert_eq!(stats["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(stats["frame"], stats["median_ms"]);
    assert!(stats["min_ms"].as_f64() <= stats["median_ms"].as_f64());
    assert_eq!(stats["settings"]["shading"], "lambert");
    let settings = &stats["settings"];
    assert_eq!(settings["size"], serde_json::json!([32, 24]));
    assert_eq!(settings["camera_file"]["width"], serde_json::json!(32));
    assert_eq!(settings["background"], serde_json::json!([0.02, 0.03, 0.05, 1.0]));
    assert_eq!(settings["stats"], "s.json");
    assert!(settings["legend"].is_null() && settings.get("legend").is_some());
    for limit in ["pixels", "file_bytes", "image_pixels", "nodes", "triangles", "decoded_bytes"] {
        assert!(settings[format!("max_{limit}")].is_u64(), "{limit}");
    }
}

#[test]
fn settings_name_every_option() {
    let folder = Folder::new();
    let help = String::from_utf8(folder.ok("render --help").stdout).unwrap();
    let options = help.lines().filter_map(|line| line.trim_start().strip_prefix("--"));
    let options: Vec<String> = options
        .map(|line| line.split(|c: char| !c.is_alphanumeric() && c != '-').next().unwrap())
        .map(|name| name.replace('-', "_"))
        .collect();
    assert!(options.len() > 40, "{help}");
    folder.ok("render synth:sphere:8 --size 8x8 -o x.png --stats s.json --threads 1");
    let settings = folder.json("s.json")["settings"].clone();
    for option in options.iter().filter(|option| *option != "help") {
        assert!(settings.get(option).is_some(), "{option}: {settings}");
    }
    assert_ne!(settings["simd"], "auto");
    assert_eq!(settings["aa"], "msaa4");
    folder.ok("render synth:sphere:8 --size 8x8 -o x.png --stats s.json --renderer raycast");
    assert_eq!(folder.json("s.json")["settings"]["aa"], "none");
}

#[test]
fn the_camera_in_the_settings_draws_the_same_picture() {
    let folder = Folder::new();
    folder.ok("render synth:knots --size 48x32 -o x.png --stats s.json");
    folder.write("camera.json", folder.json("s.json")["settings"]["camera_file"].to_string());
    folder.ok("render synth:knots -o y.png --camera camera.json");
    folder.ok("diff x.png y.png --fail-below psnr=50");
}

#[test]
fn warnings_are_in_both_places() {
    let folder = Folder::new();
    folder.write("empty.gltf", r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{}]}"#);
    let ran = folder.ok("render empty.gltf --size 8x8 -o x.png --stats s.json");
    let warnings = folder.json("s.json")["warnings"].clone();
    let last = warnings.as_array().unwrap().last().unwrap().clone();
    assert!(ran.stderr.contains(last.as_str().unwrap()));
}
