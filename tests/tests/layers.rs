//! The architecture, held: which crate may name which, read from the manifests.

use std::collections::BTreeSet;

use cullet_tests::root;

/// Each crate and all that it may depend on among the Cullet crates.
const ARROWS: [(&str, &[&str]); 9] = [
    ("cullet-transform", &[]),
    ("cullet-cull", &["cullet-transform"]),
    ("cullet-raster", &["cullet-transform"]),
    ("cullet-scene", &["cullet-transform"]),
    ("cullet-shade", &["cullet-raster", "cullet-scene", "cullet-transform"]),
    (
        "cullet",
        &["cullet-cull", "cullet-raster", "cullet-scene", "cullet-shade", "cullet-transform"],
    ),
    ("cullet-measure", &[]),
    ("cullet-cli", &["cullet", "cullet-measure"]),
    ("cullet-view", &["cullet"]),
];

/// The programs; everything else is a library.
const APPS: [&str; 2] = ["cullet-cli", "cullet-view"];

/// Packages that only some crates may name.
const HOMES: [(&str, &[&str]); 6] = [
    ("gltf", &["cullet-scene"]),
    ("tobj", &["cullet-scene"]),
    ("image", &["cullet-scene", "cullet-cli", "cullet-view"]),
    ("clap", &["cullet-cli", "cullet-view"]),
    ("minifb", &["cullet-view"]),
    ("font8x8", &["cullet-view"]),
];

/// Every crate below `crates/` with all that its manifest names for building it, whatever the
/// platform and whatever it renames them to; not what only its tests need.
fn crates() -> Vec<(String, BTreeSet<String>)> {
    let cargo = std::process::Command::new(env!("CARGO"))
        .args(["metadata", "--no-deps", "--offline", "--format-version", "1"])
        .current_dir(root())
        .output()
        .expect("cargo runs");
    let metadata: serde_json::Value = serde_json::from_slice(&cargo.stdout).expect("metadata");
    let text = |value: &serde_json::Value| value.as_str().unwrap_or_default().to_owned();
    let packages = metadata["packages"].as_array().expect("packages");
    let packages = packages.iter().filter(|package| {
        let manifest = text(&package["manifest_path"]).replace('\\', "/");
        manifest.contains("/crates/")
    });
    let read = |package: &serde_json::Value| {
        let dependencies = package["dependencies"].as_array().expect("dependencies");
        let built = dependencies.iter().filter(|d| d["kind"] != "dev");
        (text(&package["name"]), built.map(|d| text(&d["name"])).collect())
    };
    packages.map(read).collect()
}

#[test]
fn arrows_point_down() {
    for (name, found) in crates() {
        let allowed = ARROWS.iter().find(|(crate_name, _)| *crate_name == name);
        let (_, allowed) = allowed.unwrap_or_else(|| panic!("{name} has no place in ARROWS"));
        for dependency in found.iter().filter(|d| d.starts_with("cullet")) {
            assert!(allowed.contains(&dependency.as_str()), "{name} must not name {dependency}");
        }
    }
}

#[test]
fn heavy_packages_stay_in_their_homes() {
    for (name, found) in crates() {
        for (package, homes) in HOMES {
            let at_home = homes.contains(&name.as_str());
            assert!(at_home || !found.contains(package), "{name} must not name {package}");
        }
    }
}

/// Every source file below `folder`.
fn sources(folder: &std::path::Path, out: &mut Vec<(String, String)>) {
    for entry in std::fs::read_dir(folder).expect("a folder of sources") {
        let path = entry.expect("a readable entry").path();
        if path.is_dir() {
            sources(&path, out);
        } else if path.extension().is_some_and(|e| e == "rs") {
            let text = std::fs::read_to_string(&path).expect("a source file");
            out.push((path.display().to_string(), text));
        }
    }
}

#[test]
fn libraries_start_threads_in_one_place_and_never_print_exit_or_read_the_environment() {
    for (name, _) in ARROWS.iter().filter(|(name, _)| !APPS.contains(name)) {
        let mut files = Vec::new();
        sources(&root().join("crates").join(name).join("src"), &mut files);
        for (file, text) in files {
            let code = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
            let code = code.lines().filter(|line| !line.trim_start().starts_with("//"));
            let code: String = code.flat_map(|line| [line, "\n"]).collect();
            for word in ["println!", "eprintln!", "print!(", "dbg!", "process::exit", "env::"] {
                assert!(!code.contains(word), "{file} says {word}");
            }
            let spawns = code.contains("thread::scope")
                || code.contains("thread::spawn")
                || code.contains("thread::Builder");
            assert!(!spawns || file.ends_with("cullet/src/schedule.rs"), "{file} starts threads");
        }
    }
}
