//! `cullet verify`: the shipped scenes have the promised bytes on every instruction set, for
//! every number of threads.

use std::path::Path;

use crate::run::{Folder, TRIANGLE};

/// The list that is compiled in.
fn promised() -> String {
    let list = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/verify/shipped.txt");
    std::fs::read_to_string(list).unwrap()
}

#[test]
fn shipped_scenes_have_the_promised_bytes_however_they_are_drawn() {
    let folder = Folder::new();
    let ran = folder.ok("verify --threads 1,3 --simd all --tile-size 8,64");
    let printed = String::from_utf8(ran.stdout).unwrap();
    let promised: String = promised().lines().skip(1).map(|line| format!("{line}\n")).collect();
    assert_eq!(printed, promised);
    assert_eq!(printed.lines().count(), 6);
}

/// The built-in scenes are the files of the folder `scenes/`.
#[test]
fn files_have_the_hash_of_the_scene_of_their_name() {
    let folder = Folder::new();
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut n = 0;
    for entry in std::fs::read_dir(scenes).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "glb") {
            continue;
        }
        let name = path.file_stem().unwrap().to_str().unwrap();
        std::fs::copy(&path, folder.path("scene.glb")).unwrap();
        let ran = folder.ok("verify --threads 1 --simd auto --bless list.txt scene.glb");
        let hash = String::from_utf8(ran.stdout).unwrap();
        let hash = hash.split_whitespace().next().unwrap();
        assert!(promised().contains(&format!("{hash}  {name}\n")), "{name}");
        n += 1;
    }
    assert_eq!(n, 6, "every scene of the folder is verified, and no other");
}

#[test]
fn other_bytes_are_a_difference() {
    let folder = Folder::new();
    folder.write("a.gltf", TRIANGLE);
    folder.ok("verify --simd fallback --bless list.txt a.gltf synth:sphere:8");
    let ran = folder.ok("verify --list list.txt synth:sphere:8 a.gltf");
    assert!(ran.stderr.contains("2 scenes, the same bytes in"), "{}", ran.stderr);
    let moved = TRIANGLE.replace(r#""name":"only""#, r#""scale":[2,1,1]"#);
    folder.write("a.gltf", moved);
    let fails = |words: &str, line: &str| folder.fails(1, words, line);
    fails("a.gltf: ", "verify --list list.txt a.gltf synth:sphere:8");
    fails("1 of 2 scenes differ", "verify --list list.txt a.gltf synth:sphere:8");
    fails("synth:sphere:9: is not in the list", "verify --list list.txt synth:sphere:9");
    fails("is not in the list", "verify a.gltf");
}

#[test]
fn lists_are_checked_and_written_whole() {
    let folder = Folder::new();
    folder.write("odd.txt", "abc  city\n");
    folder.fails(3, "odd.txt: line 1 is no hash and name", "verify --list odd.txt");
    folder.fails(3, "none.txt: cannot be read", "verify --list none.txt");
    folder.fails(3, "missing.glb", "verify --bless list.txt missing.glb");
    folder.fails(2, "give all, auto", "verify --simd mmx");
    assert_eq!(folder.names(), ["odd.txt"]);
    let ran = folder.ok("verify --simd auto --threads 1 --bless - synth:sphere:8");
    folder.ok("verify --simd auto --threads 1 --bless list.txt synth:sphere:8");
    assert_eq!(ran.stdout, folder.read("list.txt"));
}
