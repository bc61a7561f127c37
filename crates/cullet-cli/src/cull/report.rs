//! The figures as JSON, CSV and a table.

use cullet::cull::Counts;
use cullet::transform::Plane;
use cullet_measure::{Align, Table};
use serde_json::{Map, Value, json};

use super::CullArgs;
use super::measure::{Measured, TestFigures};

/// Everything, under the schema of the command line.
pub fn json(args: &CullArgs, measured: &Measured) -> Vec<u8> {
    let n = measured.n_boxes as u64;
    let tests: Map<String, Value> = measured
        .tests
        .iter()
        .map(|figures| {
            let value = json!({
                "in": figures.n_in,
                "out": n - figures.n_in,
                "ns_per_box": figures.ns_per_box,
                "spread": figures.spread,
                "false_visible": figures.n_false_visible,
            });
            (figures.test.name().to_owned(), value)
        })
        .collect();
    let planes: Vec<Value> = Plane::ALL
        .iter()
        .map(|plane| json!({"plane": plane.name(), "out": measured.planes[plane.index()]}))
        .collect();
    let tree = &measured.tree;
    let levels = tree.stats.levels.iter().enumerate().filter(|(_, counts)| counts.tested > 0);
    let levels: Vec<Value> = levels.map(|(i, counts)| level(i, counts)).collect();
    let path = |path: &Option<std::path::PathBuf>| path.as_ref().map(|p| p.display().to_string());
    let value = json!({
        "schema": 1,
        "version": env!("CARGO_PKG_VERSION"),
        "settings": {
            "scene": args.source.as_ref().map(|source| source.path.display().to_string()),
            "boxes": path(&args.boxes),
            "f64": args.f64,
            "camera": if args.clip_from_world.is_some() { Value::Null } else { json!(args.camera) },
            "clip_from_world": path(&args.clip_from_world),
            "repeat": args.repeat,
        },
        "boxes": n,
        "invalid": measured.n_invalid,
        "empty": measured.n_empty,
        "threads": 1,
        "simd": measured.simd,
        "tests": tests,
        "hierarchy": {
            "test": "both",
            "build_ms": tree.build_ms,
            "walk_ms": tree.walk_ms,
            "in": tree.n_in,
            "out": n - tree.n_in,
            "nodes": tree.quality.n_nodes,
            "nodes_tested": tree.stats.nodes().tested,
            "items_tested": tree.stats.items.tested,
        },
        "planes": planes,
        "levels": levels,
    });
    let mut bytes = serde_json::to_vec_pretty(&value).unwrap_or_default();
    bytes.push(b'\n');
    bytes
}

fn level(index: usize, counts: &Counts) -> Value {
    json!({
        "level": index,
        "tested": counts.tested,
        "out": counts.outside,
        "in": counts.inside,
        "crossing": counts.straddling,
    })
}

/// One row per test.
pub fn csv(measured: &Measured) -> String {
    tests(measured).to_csv()
}

/// What people read on a terminal.
pub fn table(measured: &Measured) -> String {
    let tree = &measured.tree;
    let planes = Plane::ALL
        .iter()
        .map(|plane| format!("{} {}", plane.name(), measured.planes[plane.index()]));
    let planes: Vec<String> = planes.collect();
    format!(
        "{} boxes, {} empty, {} invalid; one thread\n\n{}\n\
         rejected by plane: {}\n\
         tree ({}): built in {:.3} ms; a walk takes {:.4} ms, tests {} nodes and {} items, keeps {}\n",
        measured.n_boxes,
        measured.n_empty,
        measured.n_invalid,
        tests(measured),
        planes.join(", "),
        measured.simd,
        tree.build_ms,
        tree.walk_ms,
        tree.stats.nodes().tested,
        tree.stats.items.tested,
        tree.n_in,
    )
}

fn tests(measured: &Measured) -> Table {
    let mut table = Table::new(&[
        ("test", Align::Left),
        ("in", Align::Right),
        ("out", Align::Right),
        ("false visible", Align::Right),
        ("waste %", Align::Right),
        ("ns per box", Align::Right),
        ("spread %", Align::Right),
    ]);
    for figures in &measured.tests {
        let TestFigures { test, n_in, n_false_visible, ns_per_box, spread } = figures;
        table.push([
            test.name().to_owned(),
            n_in.to_string(),
            (measured.n_boxes as u64 - n_in).to_string(),
            n_false_visible.to_string(),
            // Of what the test keeps.
            format!("{:.2}", 100.0 * *n_false_visible as f64 / (*n_in).max(1) as f64),
            format!("{ns_per_box:.2}"),
            format!("{:.0}", 100.0 * spread),
        ]);
    }
    table
}
