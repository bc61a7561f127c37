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
        // The tree finds what the flat test finds, and short bounds first change nothing.
        assert_eq!(json["hierarchy"]["in"], json["tests"]["both"]["in"]);
        assert_eq!(json["flat"]["in"], json["flat_coarse"]["in"]);
        // Of one time there is no spread.
        assert_eq!(json["tests"]["sat"]["spread"], Value::Null);
        assert_eq!(json["planes"].as_array().unwrap().len(), 6);
        // Nodes are those of the levels, and none is tested twice.
        let levels = json["levels"].as_array().unwrap();
        let sum = |key: &str| levels.iter().map(|level| level[key].as_u64().unwrap()).sum::<u64>();
        assert_eq!(json["hierarchy"]["nodes"], sum("nodes"));
        assert_eq!(json["hierarchy"]["nodes_tested"], sum("tested"));
        assert!(sum("tested") > 0 && sum("tested") <= sum("nodes"), "{scene}");
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
    // The same with a near distance that rounding has taken away: row z is row w.
    for (z, depth) in
        [("0,0,-1,0", "zero-to-one"), ("0,0,-1,0", "minus-one-to-one"), ("0,0,0,0", "reversed")]
    {
        let matrix =
            format!("{{\"rows\":[[1,0,0,0],[0,1,0,0],[{z}],[0,0,-1,0]], \"depth\":\"{depth}\"}}");
        folder.write("matrix.json", &matrix);
        folder.ok("cull --boxes boxes.jsonl --clip-from-world matrix.json --verdicts c.jsonl");
        assert_eq!(std::fs::read(folder.path("c.jsonl")).unwrap(), a, "{depth}");
    }
}

fn report(folder: &Folder, line: &str) -> Value {
    let json = folder.ok(&format!("cull {line} --repeat 1 --cold 1 --json -")).stdout;
    serde_json::from_slice(&json).unwrap()
}

#[test]
fn a_path_adds_up_over_its_cameras() {
    let folder = folder();
    let cameras = format!("[{CAMERA}, {}]", CAMERA.replace("[0,0,5]", r#"["0x1.9p6",100,105]"#));
    folder.write("path.json", &cameras);
    folder.write("object.json", format!("{{\"cameras\": {cameras}}}"));
    let sums = ["--boxes boxes.jsonl --path path.json", "--boxes boxes.jsonl --path object.json"]
        .map(|line| report(&folder, line));
    assert_eq!(sums[0]["fates"], sums[1]["fates"]);
    for line in [
        "--boxes boxes.jsonl --path path.json",
        "--boxes boxes.jsonl --camera camera.json --path dolly:3",
        "synth:box-grid:6 --path orbit:4:0.5 --size 64x48",
    ] {
        let json = report(&folder, line);
        let cameras = json["cameras"].as_array().unwrap();
        assert_eq!(json["n_cameras"], cameras.len());
        assert_eq!(json["path"]["n"], cameras.len());
        for key in ["in", "out", "false_visible"] {
            let sum =
                cameras.iter().map(|c| c["tests"]["both"][key].as_u64().unwrap()).sum::<u64>();
            assert_eq!(json["tests"]["both"][key], sum, "{line}");
        }
        let visible = &json["path"]["metrics"]["visible"];
        let worst = &cameras[visible["worst_camera"].as_u64().unwrap() as usize];
        assert_eq!(visible["max"].as_f64(), worst["tests"]["sat"]["in"].as_f64());
        let fates = json["fates"].as_object().unwrap().values();
        let n = json["boxes"].as_u64().unwrap() * cameras.len() as u64;
        assert_eq!(fates.map(|n| n.as_u64().unwrap()).sum::<u64>(), n);
    }
}

#[test]
fn verdicts_along_a_path_name_their_camera() {
    let folder = folder();
    let orbit = "cull --boxes boxes.jsonl --camera camera.json --path orbit:2 --repeat 1";
    folder.ok(&format!("{orbit} --verdicts v.jsonl"));
    let verdicts = lines(&std::fs::read_to_string(folder.path("v.jsonl")).unwrap());
    let order: Vec<_> = verdicts
        .iter()
        .map(|v| (v["camera"].as_u64().unwrap(), v["i"].as_u64().unwrap()))
        .collect();
    let expected: Vec<_> = (0..2).flat_map(|camera| (0..5).map(move |i| (camera, i))).collect();
    assert_eq!(order, expected);
}

#[test]
fn what_no_camera_changes_is_counted_once() {
    let folder = folder();
    let orbit = "cull --boxes boxes.jsonl --camera camera.json --path orbit:3 --repeat 1";
    let text = String::from_utf8(folder.ok(orbit).stdout).unwrap();
    assert!(text.contains(" 1 empty, 1 invalid;"), "{text}");
}

#[test]
fn the_csv_has_the_walk_and_the_renderer_of_every_camera() {
    let folder = folder();
    let path = "synth:box-grid:6 --path dolly:2 --size 96x64 --frames 1 --repeat 1";
    folder.ok(&format!("cull {path} --csv x.csv --json x.json"));
    let csv = std::fs::read_to_string(folder.path("x.csv")).unwrap();
    let json = std::fs::read(folder.path("x.json")).unwrap();
    let json: Value = serde_json::from_slice(&json).unwrap();
    let mut rows = csv.lines().map(|row| row.split(',').collect::<Vec<_>>());
    let head = rows.next().unwrap();
    let rows: Vec<_> = rows.collect();
    assert!(rows.iter().all(|row| row.len() == head.len()));
    let column = |name: &str| head.iter().position(|known| *known == name).unwrap();
    let number = |row: &[&str], name: &str| row[column(name)].parse::<f64>().unwrap();
    for (i, camera) in json["cameras"].as_array().unwrap().iter().enumerate() {
        let of = |source: &str| {
            let wanted = [source.to_owned(), i.to_string()];
            rows.iter().filter(|row| row[..2] == wanted).cloned().collect::<Vec<_>>()
        };
        let walk = of("walk");
        assert_eq!(walk.len(), 1);
        assert_eq!(number(&walk[0], "in"), camera["tests"]["both"]["in"].as_f64().unwrap());
        assert!(number(&walk[0], "ms") > 0.0);
        let render = of("render");
        let [all, culled] = ["none", "both + tree"].map(|way| {
            render.iter().find(|row| row[column("test")] == way).expect("a way to cull")
        });
        assert_eq!(number(all, "in"), 216.0);
        assert!(number(culled, "triangles") <= number(all, "triangles"));
        assert_eq!(number(culled, "pixels"), number(all, "pixels"));
        assert_eq!(number(culled, "in") + number(culled, "out"), 216.0);
    }
}

#[test]
fn the_renderer_says_what_was_saved() {
    let folder = folder();
    // From the middle of the grid most of it is out of view.
    let json = report(&folder, "synth:box-grid:6 --path dolly:2 --size 96x64 --frames 1");
    for drawn in [&json["downstream"], &json["cameras"][1]["downstream"]] {
        let drawn = drawn.as_array().unwrap();
        let all = |key: &str| drawn.iter().map(|d| d[key].as_u64().unwrap()).collect::<Vec<_>>();
        assert_eq!(drawn[0]["cull"], "none");
        let (triangles, saved) = (all("triangles"), all("triangles_saved"));
        assert!(triangles.iter().zip(&saved).all(|(a, b)| a + b == triangles[0]), "{triangles:?}");
        let pixels = all("pixels_shaded");
        assert!(pixels.iter().all(|n| *n == pixels[0]), "{pixels:?}");
    }
    let none = report(&folder, "synth:box-grid:6 --frames 0");
    assert!(none["downstream"].is_null());
}

#[test]
fn generated_boxes_show_where_the_tests_differ() {
    let folder = folder();
    let json = report(&folder, "--distributions 40");
    let kinds = json["distributions"].as_array().unwrap();
    assert_eq!(kinds.len(), 9);
    for kind in kinds {
        let waste = |test: &str| kind["waste_percent"][test].as_f64().unwrap();
        let name = kind["name"].as_str().unwrap();
        assert_eq!(waste("sat"), 0.0, "{name}");
        let cheap = waste("p_vertex").min(waste("reverse"));
        assert!(waste("both") <= cheap, "{name}");
        match name {
            "city" | "small" => assert!(waste("both") < 0.5, "{name}"),
            "tiles" => assert!((13.0..21.0).contains(&waste("both"))),
            "rolled" => assert!((8.0..13.0).contains(&waste("both"))),
            "clusters" => assert!((4.0..7.0).contains(&waste("both"))),
            _ => {}
        }
    }
    let text = String::from_utf8(folder.ok("cull --distributions 5").stdout).unwrap();
    assert!(text.contains("frustum-sized"), "{text}");
}

#[test]
fn conditions_decide_the_exit_code() {
    let folder = folder();
    let boxes = "cull --boxes boxes.jsonl --camera camera.json --repeat 1";
    folder.ok(&format!("{boxes} --json old.json"));
    let run = |condition: &str| {
        let mut command = folder.command(&format!("{boxes} --compare old.json --fail-if"));
        command.arg(condition).output().unwrap()
    };
    assert_eq!(run("tests.sat.false_visible > 0").status.code(), Some(0));
    assert_eq!(run("tests.sat.in < old.tests.sat.in").status.code(), Some(0));
    let holds = run("tests.sat.in >= old.tests.sat.in && levels.0.nodes == 1");
    assert_eq!(holds.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&holds.stdout).contains("figures did not"));
    assert_eq!(run("tests.sat.on > 0").status.code(), Some(2));
    folder.fails(2, "--compare", &format!("{boxes} --fail-if old.boxes"));
    folder.fails(3, "no report", &format!("{boxes} --compare camera.json"));
    // Reports are written even when a condition holds: that is when one wants to read them.
    folder.fails(1, "conditions hold", &format!("{boxes} --fail-if boxes --csv x.csv"));
    assert!(folder.names().contains(&"x.csv".to_owned()));
}

#[test]
fn the_page_needs_nothing_else() {
    let folder = folder();
    folder.ok("cull synth:box-grid:4 --path orbit:3:0.4 --size 64x48 --repeat 1 --html page.html");
    folder.ok("cull --boxes boxes.jsonl --camera camera.json --repeat 1 --html boxes.html");
    for (name, has_picture) in [("page.html", true), ("boxes.html", false)] {
        let page = std::fs::read_to_string(folder.path(name)).unwrap();
        assert!(!page.contains("http:") && !page.contains("https:") && !page.contains("<script"));
        assert_eq!(page.contains("data:image/png;base64,"), has_picture);
        assert_eq!(page.contains("Along the path"), has_picture);
        assert!(!page.contains("NaN") || !has_picture);
        for title in ["Boxes and frustum", "Waste by size of box", "When do the finer tests pay?"] {
            assert!(page.contains(title), "{name}: {title}");
        }
        for tag in ["section", "svg", "div", "p", "table"] {
            let n = |tag: String| page.matches(&tag).count();
            let open = n(format!("<{tag}>")) + n(format!("<{tag} "));
            assert_eq!(open, n(format!("</{tag}>")), "{name}: {tag}");
        }
    }
}

#[test]
fn one_odd_box_does_not_stretch_the_charts() {
    let folder = folder();
    let cube = |at: usize| format!("{{\"min\":[{at},0,0],\"max\":[{at}.75,1,1]}}\n");
    let boxes: String = (0..4020).map(cube).collect();
    folder.write("many.jsonl", boxes + r#"{"min":[0,0,0],"max":["1e-44",0,0]}"#);
    folder.ok("cull --boxes many.jsonl --camera camera.json --repeat 1 --html many.html");
    let page = String::from_utf8(folder.read("many.html")).unwrap();
    assert!(page.contains("Left out:</b> at both ends, sizes that fewer than"), "sizes");
    assert!(page.contains("<p class='sub'>One camera, "), "{}", &page[..page.len().min(9000)]);
    assert!(page.contains("One box in 2 is drawn, of 4021."));
}

#[test]
fn boxes_may_come_from_standard_input() {
    let folder = folder();
    let rest = "--camera camera.json --repeat 1 --verdicts";
    folder.ok(&format!("cull --boxes boxes.jsonl {rest} a.jsonl"));
    let mut command = folder.command(&format!("cull --boxes - {rest} b.jsonl"));
    command.stdin(std::fs::File::open(folder.path("boxes.jsonl")).unwrap());
    assert!(command.output().unwrap().status.success());
    assert_eq!(folder.read("a.jsonl"), folder.read("b.jsonl"));
    let mut command = folder.command("cull --boxes - --camera camera.json");
    command.stdin(std::fs::File::open(folder.path("camera.json")).unwrap());
    let wrong = command.output().unwrap();
    assert_eq!(wrong.status.code(), Some(3));
    let words = String::from_utf8(wrong.stderr).unwrap();
    assert!(words.contains("standard input: line 1"), "{words}");
}

#[test]
fn an_orbit_begins_with_the_camera_whatever_the_boxes() {
    let folder = folder();
    let odd = r#"{"min":["-1e30",0,0],"max":["3e29",1,1]}"#;
    folder.write("odd.jsonl", format!("{BOXES}{odd}\n{odd}\n"));
    let boxes = "cull --boxes odd.jsonl --f64 --camera camera.json --repeat 1 --verdicts";
    folder.ok(&format!("{boxes} one.jsonl"));
    folder.ok(&format!("{boxes} orbit.jsonl --path orbit:4"));
    let [one, orbit] = ["one.jsonl", "orbit.jsonl"]
        .map(|name| lines(&String::from_utf8(folder.read(name)).unwrap()));
    for (mut a, b) in orbit.into_iter().zip(one) {
        assert_eq!(a["camera"].take(), 0);
        a.as_object_mut().unwrap().remove("camera");
        assert_eq!(a, b);
    }
}

#[test]
fn few_boxes_and_none_are_told_in_words() {
    let folder = folder();
    folder.write("one.jsonl", BOXES.lines().next().unwrap());
    folder.write("none.jsonl", "");
    let text = |name: &str| {
        let line = format!("cull --boxes {name}.jsonl --camera camera.json --repeat 4 --html -");
        let page = String::from_utf8(folder.ok(&line).stdout).unwrap();
        let table = folder.ok(&line.replace(" --html -", "")).stdout;
        (String::from_utf8(table).unwrap(), page)
    };
    let (one, _) = text("one");
    assert!(one.starts_with("1 box, one camera"), "{one}");
    let (none, page) = text("none");
    assert!(none.starts_with("0 boxes, one camera"), "{none}");
    let row = none.lines().find(|line| line.starts_with("p_vertex ")).unwrap();
    assert_eq!(row.split_whitespace().filter(|word| *word == "–").count(), 3, "{row}");
    assert!(!page.contains(">0 ns"), "{page}");
}

#[test]
fn a_report_of_other_boxes_is_compared_with_a_warning() {
    let folder = folder();
    folder.write("other.jsonl", BOXES);
    let cull = |boxes: &str, rest: &str| {
        folder.ok(&format!("cull --boxes {boxes} --camera camera.json --repeat 1 {rest}")).stderr
    };
    cull("boxes.jsonl", "--json old.json");
    assert_eq!(cull("boxes.jsonl", "--compare old.json"), "");
    let warning = cull("other.jsonl", "--compare old.json --path dolly:2");
    assert_eq!(warning.lines().count(), 1, "{warning}");
    assert!(warning.contains("boxes `other.jsonl`, was `boxes.jsonl`; path `dolly:2`, was none"));
}

#[test]
fn faulty_input_is_named() {
    let folder = folder();
    folder.fails(2, "give --camera", "cull --boxes boxes.jsonl");
    folder.fails(3, "line 1", "cull --boxes camera.json --camera camera.json");
    folder.fails(3, "boxes.jsonl", "cull --boxes boxes.jsonl --clip-from-world boxes.jsonl");
    folder.fails(2, "orbit:N", "cull synth:sphere:8 --path circle:3");
    folder.fails(
        2,
        "is an input",
        "cull --boxes boxes.jsonl --camera camera.json --csv camera.json",
    );
    folder.fails(3, "no list", "cull --boxes boxes.jsonl --path camera.json");
    folder.fails(3, "nowhere", "cull --boxes nowhere.jsonl --camera camera.json");
}

/// A group of options that clap takes for never given would let a command succeed at nothing.
#[test]
fn a_scene_is_measured_or_refused() {
    let folder = folder();
    folder.fails(3, "nowhere.glb", "cull nowhere.glb");
    folder.fails(2, "the scene has 1: 0 `", "cull synth:box-grid:2 --camera nobody");
    folder.ok("cull synth:box-grid:2 --json figures.json --repeat 1");
    let figures = folder.json("figures.json");
    assert_eq!(figures["settings"]["scene"], "synth:box-grid:2");
    assert_eq!(figures["boxes"], 8);
    folder.fails(2, "<SCENE|--boxes", "cull");
}
