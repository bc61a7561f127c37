//! `cullet tradeoff`: the table, its fronts, and what it says about itself; and the presets.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value;

use crate::run::Folder;

/// Two small scenes within a short budget, once for all checks of one test.
fn measured() -> Folder {
    let folder = Folder::new();
    let ran =
        folder.ok("tradeoff synth:sphere:8 synth:box-grid:2 --size 40x32 --budget 12 --out report");
    let fronts = String::from_utf8(ran.stdout).unwrap();
    assert!(fronts.starts_with("scene") && fronts.contains("quality fast"), "{fronts}");
    for says in ["samples per pixel", " rounds; ", "No configuration dominates the default"] {
        assert!(fronts.contains(says), "{says} is not in {fronts}");
    }
    assert!(ran.stderr.lines().all(|line| line.starts_with("cullet: ")), "{}", ran.stderr);
    folder
}

/// A line of the table.
struct Row {
    scene: String,
    knob: String,
    value: String,
    time_ms: f64,
    spread: f64,
    metric: String,
    error: f64,
    pareto: bool,
}

fn rows(csv: &[u8]) -> Vec<Row> {
    let text = std::str::from_utf8(csv).unwrap();
    let mut lines = text.lines();
    let heading = "scene,knob,value,time_ms,time_ratio,spread,metric,error,pareto";
    assert_eq!(lines.next(), Some(heading));
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        assert_eq!(cells.len(), 9, "{line}");
        let number = |i: usize| {
            let number: f64 = cells[i].parse().unwrap();
            assert!(number >= 0.0 && number.is_finite(), "{line}");
            number
        };
        number(4);
        Row {
            scene: cells[0].into(),
            knob: cells[1].into(),
            value: cells[2].into(),
            time_ms: number(3),
            spread: number(5),
            metric: cells[6].into(),
            error: number(7),
            pareto: cells[8].parse().unwrap(),
        }
    };
    lines.map(row).collect()
}

#[test]
fn the_table_is_as_promised_and_its_fronts_are_fronts() {
    let folder = measured();
    let rows = rows(&folder.read("report/tradeoff.csv"));
    let keys: BTreeSet<_> =
        rows.iter().map(|row| (&row.scene, &row.knob, &row.value, &row.metric)).collect();
    assert_eq!(keys.len(), rows.len(), "no row twice");
    for scene in ["synth:sphere:8", "synth:box-grid:2"] {
        for preset in ["fast", "balanced", "reference"] {
            let is_it = |row: &&Row| row.scene == scene && row.value == preset;
            assert!(rows.iter().filter(is_it).count() >= 2, "{scene} {preset}");
        }
    }
    for row in &rows {
        let panel = || rows.iter().filter(|r| r.scene == row.scene && r.metric == row.metric);
        let beats = |other: &&Row| {
            other.time_ms <= row.time_ms
                && other.error <= row.error
                && (other.time_ms < row.time_ms || other.error < row.error)
        };
        let by: Vec<&Row> = panel().filter(beats).collect();
        let fastest = by.iter().map(|other| other.time_ms).fold(row.time_ms, f64::min);
        // What nothing beats is on the front, and what is beaten by no more than its spread may be.
        let may = 1.0 - fastest / row.time_ms <= row.spread;
        let name = format!("{} {} {}", row.knob, row.value, row.metric);
        assert!(if by.is_empty() { row.pareto } else { !row.pareto || may }, "{name}");
        let excess = by.iter().map(|other| row.error - other.error).fold(0.0, f64::max);
        // Errors that are counted are told apart however close they are.
        let is_counted = ["id_ppm", "default_max", "false_visible_ppm"].contains(&&*row.metric);
        assert!(!(is_counted && excess > 0.0 && row.pareto), "{name}");
    }
    let errors = |knob: &str, metric: &str| -> Vec<f64> {
        let own = rows.iter().filter(|row| row.knob == knob && row.metric == metric);
        own.map(|row| row.error).collect()
    };
    assert!(errors("quality", "flip").iter().any(|error| *error > 0.0));
    assert!(errors("sincos", "max_abs").len() >= 6, "near 0 and far from it");
}

/// On the front is what nothing beats, or only what does so by no more than its spread in time, and in error by
/// what the halves of the samples, or counts, do not tell or half a percent.
fn fronts_follow_their_rule(rows: &[Value]) {
    let number = |row: &Value, key: &str| row[key].as_f64().unwrap();
    let half = |row: &Value, i: usize| row["error_by_halves"][i].as_f64();
    for row in rows {
        let (time, error) = (number(row, "time_ms"), number(row, "error"));
        let kept = rows
            .iter()
            .filter(|other| other["scene"] == row["scene"] && other["metric"] == row["metric"])
            .filter(|other| number(other, "time_ms") <= time && number(other, "error") <= error)
            .filter(|other| number(other, "time_ms") < time || number(other, "error") < error)
            .all(|other| {
                let less = error - number(other, "error");
                let by_half = |i| Some(half(row, i)? - half(other, i)?);
                let halves = by_half(0).zip(by_half(1)).map(|(even, odd)| (even - odd).abs());
                let of_one = row["error_of_one"].as_f64().unwrap_or(0.0);
                let by_chance = 1.96 * (of_one * (error + number(other, "error"))).sqrt();
                let next_to_nothing = halves.is_some() && less <= 0.005 * error;
                let in_error = less <= halves.unwrap_or(0.0) + by_chance || next_to_nothing;
                1.0 - number(other, "time_ms") / time <= number(row, "spread") && in_error
            });
        assert_eq!(row["pareto"], kept, "{row}");
    }
}

fn name_of(study: &Value) -> &str {
    study["name"].as_str().unwrap()
}

#[test]
fn the_report_says_what_it_was_measured_on() {
    let folder = measured();
    let json = folder.json("report/tradeoff.json");
    fronts_follow_their_rule(json["rows"].as_array().unwrap());
    assert_eq!(json["schema"], 1);
    for key in ["version", "machine", "settings", "scenes", "rows", "findings"] {
        assert!(!json[key].is_null(), "{key}");
    }
    assert_eq!(json["settings"]["size"], serde_json::json!([40, 32]));
    let n_rows = rows(&folder.read("report/tradeoff.csv")).len();
    assert_eq!(json["rows"].as_array().unwrap().len(), n_rows);
    let says = |of: &Value| of["text"].as_str().unwrap().contains("aa none takes");
    assert!(json["findings"].as_array().unwrap().iter().any(says));
    let scene = &json["scenes"][0];
    assert!(scene["rounds"].as_u64().unwrap() >= 3);
    assert!(scene["reference"].as_str().unwrap().contains("samples per pixel"));

    assert!(scene["samples"].as_u64().unwrap() >= 64, "more than ssaa16 takes");
    for row in json["rows"].as_array().unwrap() {
        let is_plain = row["value"] == "nearest"
            || row["knob"] == "subpixel-bits" && row["value"] != "8"
            || row["knob"] == "depth-format" && row["value"] != "f32";
        assert_eq!(row["plain_code"], is_plain, "{row}");
        let sampled = ["flip", "edge_rmse", "flat_rmse", "ssim_loss", "shimmer"];
        let has_halves = sampled.contains(&row["metric"].as_str().unwrap());
        assert_eq!(!row["error_by_halves"].is_null(), has_halves, "{row}");
        assert_eq!(!row["error_of_one"].is_null(), row["metric"] == "id_ppm", "{row}");
    }
    let kinds: BTreeSet<_> = json["findings"]
        .as_array()
        .unwrap()
        .iter()
        .map(|one| one["kind"].as_str().unwrap())
        .collect();
    let known = ["confirmed", "refuted", "cannot tell", "measured"];
    assert!(kinds.iter().all(|kind| known.contains(kind)), "{kinds:?}");

    let studies: BTreeSet<_> = json["studies"].as_array().unwrap().iter().map(name_of).collect();
    for name in ["transforms", "subpixel", "culling", "edges"] {
        let left_out = json["left_out"].to_string() + &json["scenes"].to_string();
        assert!(studies.contains(name) || left_out.contains(&format!("study {name}")), "{name}");
    }
    for study in json["studies"].as_array().unwrap() {
        let n = study["columns"].as_array().unwrap().len();
        let lines = study["lines"].as_array().unwrap();
        assert!(lines.iter().all(|line| line[1].as_array().unwrap().len() == n), "{study}");
    }

    let html = String::from_utf8(folder.read("report/tradeoff.html")).unwrap();
    assert!(html.contains("<svg") && html.contains("data:image/jpeg;base64,"));
    let outside = ["<script", "src='http", "href=", "@import", "url("];
    assert!(outside.iter().all(|word| !html.contains(word)));
    let svg = String::from_utf8(folder.read("report/tradeoff.svg")).unwrap();
    assert!(svg.starts_with("<svg") && svg.ends_with("</svg>\n"));
    assert!(!svg.contains("NaN"));
    assert_eq!(folder.names(), ["report"]);
}

#[test]
fn errors_do_not_depend_on_the_run() {
    type Key = (String, String, String, String);
    let references = |folder: &Folder| folder.json("report/tradeoff.json")["scenes"].clone();
    let errors = |folder: &Folder| -> BTreeMap<Key, f64> {
        let rows = rows(&folder.read("report/tradeoff.csv")).into_iter();
        rows.map(|r| ((r.scene, r.knob, r.value, r.metric), r.error)).collect()
    };
    let (a, b) = (measured(), measured());
    // A busy machine may have had no time for some rows, or for all samples of a reference.
    let (of_a, of_b) = (references(&a), references(&b));
    let agree = |scene: &str| {
        let find = |of: &Value| {
            let all = of.as_array().unwrap().iter();
            all.filter(|one| one["scene"] == scene).map(|one| one["reference"].clone()).next()
        };
        find(&of_a) == find(&of_b)
    };
    let (a, b) = (errors(&a), errors(&b));
    for (key, error) in a.iter().filter(|(key, _)| agree(&key.0)) {
        assert!(b.get(key).is_none_or(|other| other == error), "{key:?}");
    }
}

#[test]
fn wrong_usage_and_inputs_leave_nothing() {
    let folder = Folder::new();
    folder.fails(2, "required", "tradeoff");
    folder.fails(2, "seconds above 0", "tradeoff synth:sphere:8 --budget 0");
    folder.fails(2, "seconds above 0", "tradeoff synth:sphere:8 --budget -1");
    folder.fails(3, "none.glb", "tradeoff none.glb --size 8x8 --budget 1");
    folder.fails(
        2,
        "there is no camera",
        "tradeoff synth:sphere:8 --camera 7 --size 8x8 --budget 1",
    );
    assert_eq!(folder.names(), [""; 0]);
}

#[test]
fn presets_are_sets_of_options_and_explicit_options_beat_them() {
    let folder = Folder::new();
    let render = |options: &str| {
        let line = format!("render synth:knots --size 64x48 -o x.png --stats x.json {options}");
        folder.ok(&line);
        (folder.read("x.png"), folder.json("x.json")["settings"].clone())
    };
    let [plain, balanced, fast, reference] =
        ["", "--quality balanced", "--quality fast", "--quality reference"].map(render);
    assert_eq!(plain.0, balanced.0);
    assert_eq!(fast.0, render("--aa none").0);
    assert_eq!(reference.0, render("--aa ssaa16").0);
    assert!(fast.0 != plain.0 && reference.0 != plain.0);
    assert_eq!((&fast.1["aa"], &fast.1["quality"]), (&"none".into(), &"fast".into()));
    let smooth = render("--quality fast --aa msaa4");
    assert_eq!(smooth.0, plain.0);
    let [log, centre] = ["--texture trilinear-log", "--edge-shading centre"].map(&render);
    assert!(log.0 != plain.0 && centre.0 != plain.0 && log.0 != centre.0);
    assert_eq!(
        (&log.1["texture"], &centre.1["edge_shading"]),
        (&"trilinear-log".into(), &"centre".into())
    );
    assert_eq!(render("--aa none --edge-shading centre").0, fast.0);
    let [half, adaptive] = ["half", "adaptive"].map(|name| render(&format!("--resolution {name}")));
    assert!(half.0 != plain.0 && adaptive.0 != half.0);
    assert_eq!(adaptive.1["resolution"], "adaptive");
    folder.fails(2, "--accumulate", "render synth:knots -o x.png --accumulate 0");
    folder.fails(2, "-1 is not in 1..=65536", "render synth:knots -o x.png --accumulate -1");
    folder.fails(2, "pixels, 0 or more", "render synth:knots -o x.png --min-size -1");
}

#[test]
fn a_scene_that_is_not_there_is_told_before_anything_is_measured() {
    let folder = Folder::new();
    let line = "tradeoff synth:sphere:4 nope.glb --size 8x8 --budget 600 --out report";
    folder.fails(3, "nope.glb", line); // within the patience of a test
    assert!(!folder.path("report").exists());
}
