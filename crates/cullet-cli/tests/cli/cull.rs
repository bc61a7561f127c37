use serde_json::Value;

use crate::run::Folder;

const CAMERA: &str = r#"{"eye":[0,0,5], "target":[0,0,0], "up":[0,1,0], "yfov_deg":45,
    "znear":0.1, "zfar":null, "aspect":1}"#;

/// Inside, empty, NaN, endless, beside the view, and one that both cheap tests keep.
const BOXES: &str = r#"{"min":[-1,-1,-1],"max":[1,1,1]}
{"min":[1,1,1],"max":[-1,-1,-1]}
{"min":["nan",0,0],"max":[1,1,1]}
{"min":["-inf","-inf","-inf"],"max":["inf","inf","inf"]}
{"min":[100,100,100],"max":[101,101,"0x1.94p+6"]}
"#;

fn folder() -> Folder {
    let folder = Folder::new();
    std::fs::write(folder.path("camera.json"), CAMERA).unwrap();
    std::fs::write(folder.path("boxes.jsonl"), BOXES).unwrap();
    folder
}

fn lines(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn every_box_gets_its_verdict_in_order() {
    let folder = folder();
    folder.ok("cull --boxes boxes.jsonl --camera camera.json --verdicts out.jsonl");
    let verdicts = lines(&std::fs::read_to_string(folder.path("out.jsonl")).unwrap());
    let classes: Vec<_> = verdicts.iter().map(|v| v["class"].as_str().unwrap()).collect();
    assert_eq!(classes, ["inside", "outside", "invalid", "crossing", "outside"]);
    for (i, verdict) in verdicts.iter().enumerate() {
        assert_eq!(verdict["i"], i);
        let kept = [true, false, true, true, false][i];
        for test in ["corners", "p_vertex", "both", "sat"] {
            assert_eq!(verdict[test], kept, "{test} of box {i}");
        }
    }
}

#[test]
fn the_figures_add_up() {
    let folder = folder();
    for scene in ["--boxes boxes.jsonl --camera camera.json", "synth:box-grid:6 --camera 0"] {
        let json = folder.ok(&format!("cull {scene} --repeat 1 --json -")).stdout;
        let json: Value = serde_json::from_slice(&json).unwrap();
        assert_eq!((&json["schema"], &json["threads"]), (&1.into(), &1.into()));
        let n = json["boxes"].as_u64().unwrap();
        for test in ["corners", "p_vertex", "reverse", "both", "sat"] {
            let figures = &json["tests"][test];
            let count = |key: &str| figures[key].as_u64().unwrap();
            assert_eq!(count("in") + count("out"), n, "{test}");
            let exact = json["tests"]["sat"]["in"].as_u64().unwrap();
            assert_eq!(count("in") - count("false_visible"), exact, "{test}");
            assert!(figures["ns_per_box"].as_f64().unwrap() >= 0.0);
        }
        // The tree finds what the flat test finds.
        assert_eq!(json["hierarchy"]["in"], json["tests"]["both"]["in"]);
        assert_eq!(json["planes"].as_array().unwrap().len(), 6);
    }
}

#[test]
fn a_matrix_serves_as_well_as_the_camera_it_came_from() {
    let folder = folder();
    // Perspective, 90 degrees, near 1, infinite far, looking down -z from the origin.
    let matrix = r#"{"rows":[[1,0,0,0],[0,1,0,0],[0,0,0,1],[0,0,-1,0]], "depth":"reversed"}"#;
    std::fs::write(folder.path("matrix.json"), matrix).unwrap();
    let camera = r#"{"eye":[0,0,0], "target":[0,0,-1], "up":[0,1,0], "yfov_deg":90, "znear":1,
        "zfar":null, "aspect":1}"#;
    std::fs::write(folder.path("camera.json"), camera).unwrap();
    folder.ok("cull --boxes boxes.jsonl --camera camera.json --verdicts a.jsonl");
    folder.ok("cull --boxes boxes.jsonl --clip-from-world matrix.json --verdicts b.jsonl");
    let [a, b] = ["a.jsonl", "b.jsonl"].map(|f| std::fs::read(folder.path(f)).unwrap());
    assert_eq!(a, b);
}

#[test]
fn faulty_input_is_named() {
    let folder = folder();
    folder.fails(2, "give --camera", "cull --boxes boxes.jsonl");
    folder.fails(3, "line 1", "cull --boxes camera.json --camera camera.json");
    folder.fails(3, "boxes.jsonl", "cull --boxes boxes.jsonl --clip-from-world boxes.jsonl");
    folder.fails(3, "nowhere", "cull --boxes nowhere.jsonl --camera camera.json");
}
