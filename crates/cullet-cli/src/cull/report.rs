//! The figures as JSON, under the schema of the command line.

use std::path::PathBuf;

use cullet::cull::{Counts, Fate, Test};
use cullet::transform::Plane;
use serde_json::{Map, Value, json};

use super::downstream::{Drawn, Mode, ms};
use super::measure::{Figures, FlatFigures, LevelFigures, SizeFigures, Timing};
use super::path::CameraPath;
use super::sweep::{Metric, metrics};
use super::verdicts::TESTS;
use super::waste::Waste;
use super::{CullArgs, Measured};

/// Changes whenever a key changes its meaning or goes.
pub const SCHEMA: u64 = 1;

/// Everything.
pub fn json(args: &CullArgs, measured: Option<&Measured>, wastes: &[Waste]) -> Value {
    let mut value = json!({
        "schema": SCHEMA,
        "version": env!("CARGO_PKG_VERSION"),
        "settings": settings(args),
        "threads": 1,
    });
    if let Some(measured) = measured {
        value["boxes"] = measured.input.boxes.len().into();
        value["n_cameras"] = measured.shown.len().into();
        value["simd"] = measured.simd.into();
        merge(&mut value, figures(&measured.sum));
        value["hierarchy"]["build_ms"] = measured.build_ms.into();
        value["sizes"] = measured.sum.sizes.iter().map(|(i, size)| self::size(*i, size)).collect();
        value["invalid"] = measured.sum.n_of(Fate::Invalid).into();
        value["empty"] = measured.sum.n_of(Fate::Empty).into();
        if !measured.downstream.is_empty() {
            value["downstream"] = measured.downstream.iter().map(drawn).collect();
        }
        if args.path.is_some() {
            let metrics = metrics(&measured.shown);
            let metric = |metric: &Metric| (metric.name.to_owned(), self::metric(metric));
            value["path"] = json!({
                "n": measured.shown.len(),
                "focus": measured.focus,
                "metrics": metrics.iter().map(metric).collect::<Map<_, _>>(),
            });
            value["cameras"] = cameras(measured);
        }
    }
    if !wastes.is_empty() {
        value["distributions"] = wastes.iter().map(waste).collect();
    }
    value
}

fn settings(args: &CullArgs) -> Value {
    let file = |path: &Option<PathBuf>| path.as_ref().map(|path| path.display().to_string());
    let unused = args.clip_from_world.is_some() || matches!(args.path, Some(CameraPath::File(_)));
    let camera = (!unused).then_some(&args.camera);
    json!({
        "scene": args.scene.as_ref().map(|path| path.display().to_string()),
        "boxes": file(&args.boxes),
        "f64": args.f64,
        "camera": camera,
        "clip_from_world": file(&args.clip_from_world),
        "path": args.path.as_ref().map(path_name),
        "size": args.size.map(|(width, height)| [width, height]),
        "repeat": args.repeat,
        "cold": args.cold,
        "frames": args.frames,
        "distributions": args.distributions,
    })
}

/// A path as `--path` spells it.
pub fn path_name(path: &CameraPath) -> String {
    match path {
        CameraPath::Orbit { n, distance } => format!("orbit:{n}:{distance}"),
        CameraPath::Dolly { n } => format!("dolly:{n}"),
        CameraPath::File(path) => path.display().to_string(),
    }
}

fn merge(into: &mut Value, from: Value) {
    if let (Value::Object(into), Value::Object(from)) = (into, from) {
        into.extend(from);
    }
}

/// The figures of one camera or of all.
fn figures(figures: &Figures) -> Value {
    let n: u64 = figures.fates.iter().sum();
    let tests = TESTS.iter().zip(&figures.tests).map(|(test, figures)| {
        let mut value = timed("ns_per_box", &figures.ns);
        value["in"] = figures.n_in.into();
        value["out"] = (n - figures.n_in).into();
        value["false_visible"] = figures.n_false_visible.into();
        value["false_culled"] = figures.n_false_culled.into();
        (test.name().to_owned(), value)
    });
    let flat = |of: &FlatFigures| {
        let mut flat = timed("ns_per_box", &of.ns);
        flat["test"] = Test::PVertex.name().into();
        flat["in"] = of.n_in.into();
        flat["out"] = (n - of.n_in).into();
        flat
    };

    let tree = &figures.tree;
    let mut hierarchy = timed("walk_ms", &tree.ms);
    hierarchy["test"] = Test::Both.name().into();
    hierarchy["in"] = tree.n_in.into();
    hierarchy["out"] = (n - tree.n_in).into();
    // The box around everything is asked too, but it is no node: these are sums over `levels`.
    hierarchy["nodes"] = tree.n_nodes().into();
    hierarchy["nodes_tested"] = tree.n_nodes_tested().into();
    hierarchy["items_tested"] = tree.stats.items.tested.into();
    hierarchy["items_untested"] = tree.stats.n_untested.into();
    let [planes, both, exact] = tree.n_tested_by;
    hierarchy["nodes_tested_by"] = json!({"p_vertex": planes, "both": both, "sat": exact});

    let planes = Plane::ALL.iter().zip(figures.rejected()).zip(&figures.planes);
    let planes = planes.map(|((plane, first), alone)| {
        let mut value = timed("ns_per_box", &alone.ns);
        value["plane"] = plane.name().into();
        // `out`: by this plane, the first in order that rejects; the rest: by it alone.
        value["out"] = first.into();
        value["out_alone"] = (n - alone.n_in).into();
        value["in_alone"] = alone.n_in.into();
        value["false_visible_alone"] = alone.n_false_visible.into();
        value
    });
    let levels = tree.levels.iter().zip(&tree.walked).enumerate();
    let fates = Fate::ALL.iter().zip(figures.fates).map(|(fate, n)| (fate.name().into(), n.into()));
    json!({
        "tests": tests.collect::<Map<_, _>>(),
        "flat": flat(&figures.flat),
        "flat_coarse": flat(&figures.coarse),
        "hierarchy": hierarchy,
        "planes": planes.collect::<Vec<_>>(),
        "levels": levels.map(|(i, (all, walked))| level(i, all, walked)).collect::<Vec<_>>(),
        "fates": fates.collect::<Map<_, _>>(),
    })
}

/// A time under `name`, with its spread, and the one with cold caches where there is one.
fn timed(name: &str, timing: &Timing) -> Value {
    let mut value = json!({"spread": timing.spread()});
    value[name] = timing.warm().into();
    if let Some(cold) = timing.cold() {
        value[format!("{name}_cold")] = cold.into();
    }
    value
}

fn level(index: usize, all: &LevelFigures, walked: &Counts) -> Value {
    json!({
        "level": index,
        "ns_per_box": all.ns.warm(),
        "nodes": all.n_nodes,
        "tested": walked.tested,
        "in": walked.inside + walked.straddling,
        "out": walked.outside,
        "inside": walked.inside,
        "crossing": walked.straddling,
        "tests": kept(all.n_nodes, &all.n_in),
    })
}

fn size(exponent: i32, size: &SizeFigures) -> Value {
    json!({
        "from": 2f64.powi(exponent),
        "to": 2f64.powi(exponent + 1),
        "boxes": size.n_boxes,
        "tests": kept(size.n_boxes, &size.n_in),
    })
}

/// Per test, of `n` boxes.
fn kept(n: u64, n_in: &[u64; TESTS.len()]) -> Value {
    let exact = n_in[TESTS.len() - 1];
    let value = |(test, n_in): (&Test, &u64)| {
        let wasted = n_in.saturating_sub(exact);
        let value = json!({"in": n_in, "out": n - n_in, "false_visible": wasted});
        (test.name().to_owned(), value)
    };
    Value::Object(TESTS.iter().zip(n_in).map(value).collect())
}

fn drawn(drawn: &Drawn) -> Value {
    let Drawn { mode: Mode { test, hierarchy }, frame, .. } = drawn;
    json!({
        "cull": test.name(),
        "hierarchy": hierarchy,
        "boxes_tested": frame.boxes_tested,
        "objects": frame.objects.n_drawn,
        "triangles": drawn.n_triangles(),
        "triangles_saved": frame.n_triangles_of_culled_objects,
        "pixels_shaded": frame.pixels_shaded,
        "cull_ms": ms(frame.stages.cull),
        "geometry_ms": ms(frame.stages.geometry),
        "raster_ms": ms(frame.stages.raster),
        "shade_ms": ms(frame.stages.shade),
        "frame_ms": drawn.ms(),
        "frame_min_ms": ms(drawn.min),
        "spread": drawn.spread,
    })
}

fn metric(metric: &Metric) -> Value {
    json!({
        "min": metric.percentile(0.0),
        "p50": metric.percentile(0.5),
        "p90": metric.percentile(0.9),
        "p99": metric.percentile(0.99),
        "max": metric.percentile(1.0),
        "worst_camera": metric.worst(),
    })
}

fn cameras(measured: &Measured) -> Value {
    let cameras = measured.shown.iter().zip(&measured.input.shots).enumerate();
    let camera = |(i, (shown, shot)): (usize, (&super::Shown, &super::Shot))| {
        let mut value = figures(&shown.figures);
        value["camera"] = i.into();
        if let Some(camera) = &shot.camera {
            value["eye"] = camera.eye().to_array().to_vec().into();
            value["forward"] = (-camera.back()).to_array().to_vec().into();
        }
        if !shown.drawn.is_empty() {
            value["downstream"] = shown.drawn.iter().map(drawn).collect();
        }
        value
    };
    cameras.map(camera).collect()
}

fn waste(waste: &Waste) -> Value {
    json!({
        "name": waste.distribution.name(),
        "boxes": waste.n_boxes,
        "tests": kept(waste.n_boxes, &waste.n_in),
        "waste_percent": {
            "p_vertex": waste.percent(Test::PVertex),
            "reverse": waste.percent(Test::Reverse),
            "both": waste.percent(Test::Both),
            "sat": waste.percent(Test::Sat),
        },
    })
}
