//! The figures as text: what people read on a terminal, and CSV.

use cullet::cull::{Fate, Test};
use cullet::transform::Plane;
use cullet_measure::{Align, Table};

use super::Measured;
use super::downstream::{ms, saved_percent};
use super::measure::{Figures, Timing};
use super::sweep::metrics;
use super::verdicts::TESTS;
use super::waste::Waste;

/// Everything about a set of boxes.
pub fn all(measured: &Measured) -> String {
    let sum = &measured.sum;
    let mut text = match measured.input.boxes.len() {
        1 => "1 box".to_owned(),
        n => format!("{n} boxes"),
    };
    match measured.shown.len() {
        1 => text += ", one camera",
        n => text += &format!(", {n} cameras (counts added up, times averaged)"),
    }
    let [visible, empty, invalid] =
        [sum.of(Test::Sat).n_in, sum.n_of(Fate::Empty), sum.n_of(Fate::Invalid)];
    text += &format!("; {visible} visible, {empty} empty, {invalid} invalid; one thread\n\n");
    text += &tests(measured, sum).to_string();
    let planes =
        Plane::ALL.iter().zip(sum.rejected()).map(|(plane, n)| format!("{} {n}", plane.name()));
    text += &format!("\nrejected by plane: {}\n", planes.collect::<Vec<_>>().join(", "));
    text += &tree(measured);
    if !measured.downstream.is_empty() {
        text += &downstream(measured);
    }
    if measured.shown.len() > 1 {
        text += &sweep(measured);
    }
    text
}

fn right<'a, const N: usize>(first: &'a str, rest: [&'a str; N]) -> Table {
    let mut columns = vec![(first, Align::Left)];
    columns.extend(rest.map(|name| (name, Align::Right)));
    Table::new(&columns)
}

fn spread(spread: Option<f64>) -> String {
    spread.map_or("–".to_owned(), |spread| format!("{:.0}", 100.0 * spread))
}

fn percent(part: u64, whole: u64) -> String {
    format!("{:.2}", 100.0 * part as f64 / whole.max(1) as f64)
}

fn tests(measured: &Measured, figures: &Figures) -> Table {
    let n: u64 = figures.fates.iter().sum();
    let mut table =
        right("test", ["in", "out", "false visible", "waste %", "ns per box", "cold", "spread %"]);
    // Time per box of no boxes is a dash, and so is its spread.
    let times = |ns: &Timing| match n {
        0 => ["–", "–", "–"].map(str::to_owned),
        _ => [
            format!("{:.2}", ns.warm()),
            ns.cold().map_or(String::new(), |ns| format!("{ns:.2}")),
            spread(ns.spread()),
        ],
    };
    for (test, figures) in TESTS.iter().zip(&figures.tests) {
        let [warm, cold, spread] = times(&figures.ns);
        table.push([
            test.name().to_owned(),
            figures.n_in.to_string(),
            (n - figures.n_in).to_string(),
            figures.n_false_visible.to_string(),
            percent(figures.n_false_visible, figures.n_in),
            warm,
            cold,
            spread,
        ]);
    }
    let x8 = format!("p_vertex x8 ({})", measured.simd);
    for (name, flat) in [(x8.as_str(), &figures.flat), ("  16-bit bounds first", &figures.coarse)] {
        let wasted = flat.n_in.saturating_sub(figures.of(Test::Sat).n_in);
        let [warm, cold, spread] = times(&flat.ns);
        table.push([
            name.to_owned(),
            flat.n_in.to_string(),
            (n - flat.n_in).to_string(),
            wasted.to_string(),
            percent(wasted, flat.n_in),
            warm,
            cold,
            spread,
        ]);
    }
    table
}

fn tree(measured: &Measured) -> String {
    let tree = &measured.sum.tree;
    let cold = tree.ms.cold().map_or(String::new(), |ms| format!(" ({ms:.4} cold)"));
    let mut text = format!(
        "\ntree: built in {:.3} ms; a walk takes {:.4} ms{cold}, tests {} of {} nodes and {} boxes, \
         keeps {}\n",
        measured.build_ms,
        tree.ms.warm(),
        tree.n_nodes_tested(),
        tree.n_nodes(),
        tree.stats.items.tested,
        tree.n_in,
    );
    let [planes, both, exact] = tree.n_tested_by;
    let fewer = |n: u64| 100.0 * planes.saturating_sub(n) as f64 / planes.max(1) as f64;
    text += &format!(
        "nodes to test if nodes are asked by planes {planes}, by both {both} ({:.1}% fewer), by \
         sat {exact} ({:.1}% fewer)\n\n",
        fewer(both),
        fewer(exact),
    );
    let mut table = right(
        "level",
        ["nodes", "tested", "out", "inside", "crossing", "p-vertex wastes", "both waste"],
    );
    for (i, (level, walked)) in tree.levels.iter().zip(&tree.walked).enumerate() {
        let [.., planes, _, both, exact] = level.n_in;
        table.push([
            i.to_string(),
            level.n_nodes.to_string(),
            walked.tested.to_string(),
            walked.outside.to_string(),
            walked.inside.to_string(),
            walked.straddling.to_string(),
            planes.saturating_sub(exact).to_string(),
            both.saturating_sub(exact).to_string(),
        ]);
    }
    text + &table.to_string()
}

fn downstream(measured: &Measured) -> String {
    let mut table = right(
        "render --cull",
        [
            "objects",
            "triangles",
            "pixels",
            "cull ms",
            "geometry",
            "raster",
            "shade",
            "frame",
            "least",
            "saves %",
        ],
    );
    let all = &measured.downstream[0];
    for drawn in &measured.downstream {
        let frame = &drawn.frame;
        let time = |duration| format!("{:.3}", ms(duration));
        table.push([
            drawn.mode.name(),
            frame.objects.n_drawn.to_string(),
            drawn.n_triangles().to_string(),
            frame.pixels_shaded.to_string(),
            time(frame.stages.cull),
            time(frame.stages.geometry),
            time(frame.stages.raster),
            time(frame.stages.shade),
            time(frame.total),
            time(drawn.min),
            saved_percent(all, drawn).map_or("–".into(), |percent| format!("{percent:.1}")),
        ]);
    }
    format!(
        "\nwhat it saves in the renderer (camera {}, ms; pixels are always the same; saved of the \
         least times):\n{table}",
        measured.focus
    )
}

fn sweep(measured: &Measured) -> String {
    let mut table = right("over the path", ["min", "p50", "p90", "p99", "max", "worst camera"]);
    for metric in metrics(&measured.shown) {
        let value = |share| {
            let value = metric.percentile(share);
            if value.fract() == 0.0 { format!("{value}") } else { format!("{value:.4}") }
        };
        table.push([
            metric.title.to_owned(),
            value(0.0),
            value(0.5),
            value(0.9),
            value(0.99),
            value(1.0),
            metric.worst().to_string(),
        ]);
    }
    format!("\n{table}")
}

/// What the tests leave over on generated boxes.
pub fn distributions(wastes: &[Waste]) -> String {
    let mut table = right(
        "waste % by kind of boxes",
        ["boxes", "visible", "p-vertex", "reverse", "both", "sat"],
    );
    for waste in wastes {
        let percent = |test| format!("{:.3}", waste.percent(test));
        table.push([
            waste.distribution.name().to_owned(),
            waste.n_boxes.to_string(),
            waste.n_in(Test::Sat).to_string(),
            percent(Test::PVertex),
            percent(Test::Reverse),
            percent(Test::Both),
            percent(Test::Sat),
        ]);
    }
    format!("{table}(waste: of the boxes a test keeps, those that are not visible)\n")
}

/// One row per camera and test, plane by itself, or level of the tree (by [`Test::Both`]), the walk,
/// and way for the renderer to cull (`in` and `out` are objects there); or per kind of generated
/// boxes and test. `ms`: per walk, per frame.
pub fn csv(measured: Option<&Measured>, wastes: &[Waste]) -> String {
    let mut table = right(
        "source",
        [
            "camera",
            "test",
            "in",
            "out",
            "false_visible",
            "ns_per_box",
            "ns_per_box_cold",
            "ms",
            "ms_cold",
            "triangles",
            "pixels",
        ],
    );
    let number = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:.4}"));
    for (camera, shown) in measured.iter().flat_map(|m| m.shown.iter().enumerate()) {
        let figures = &shown.figures;
        let n: u64 = figures.fates.iter().sum();
        let mut row =
            |source: &str, test: String, n: u64, [n_in, wasted]: [u64; 2], ns: &Timing| {
                table.push([
                    source.to_owned(),
                    camera.to_string(),
                    test,
                    n_in.to_string(),
                    (n - n_in).to_string(),
                    wasted.to_string(),
                    format!("{:.4}", ns.warm()),
                    number(ns.cold()),
                ]);
            };
        for (test, of) in TESTS.iter().zip(&figures.tests) {
            row("boxes", test.name().to_owned(), n, [of.n_in, of.n_false_visible], &of.ns);
        }
        let wide = [("p_vertex_x8", &figures.flat), ("p_vertex_x8_coarse", &figures.coarse)];
        for (name, flat) in wide {
            let wasted = flat.n_in.saturating_sub(figures.of(Test::Sat).n_in);
            row("boxes", name.to_owned(), n, [flat.n_in, wasted], &flat.ns);
        }
        for (plane, of) in Plane::ALL.iter().zip(&figures.planes) {
            row("plane", plane.name().to_owned(), n, [of.n_in, of.n_false_visible], &of.ns);
        }
        for (i, level) in figures.tree.levels.iter().enumerate() {
            let [.., both, exact] = level.n_in;
            let wasted = both.saturating_sub(exact);
            row("level", i.to_string(), level.n_nodes, [both, wasted], &level.ns);
        }
        let tree = &figures.tree;
        let per_box = |ms: f64| 1e6 * ms / n.max(1) as f64;
        let (warm, cold) = (tree.ms.warm(), tree.ms.cold());
        table.push([
            "walk".to_owned(),
            camera.to_string(),
            Test::Both.name().to_owned(),
            tree.n_in.to_string(),
            (n - tree.n_in).to_string(),
            tree.n_in.saturating_sub(figures.of(Test::Sat).n_in).to_string(),
            number(Some(per_box(warm))),
            number(cold.map(per_box)),
            number(Some(warm)),
            number(cold),
        ]);
        for drawn in measured.iter().flat_map(|m| m.drawn(camera)) {
            let frame = &drawn.frame;
            let objects = frame.objects;
            table.push([
                "render".to_owned(),
                camera.to_string(),
                drawn.mode.name(),
                objects.n_drawn.to_string(),
                (objects.n_in - objects.n_drawn).to_string(),
                String::new(),
                String::new(),
                String::new(),
                number(Some(drawn.ms())),
                String::new(),
                drawn.n_triangles().to_string(),
                frame.pixels_shaded.to_string(),
            ]);
        }
    }
    for waste in wastes {
        for test in TESTS {
            let n_in = waste.n_in(test);
            table.push([
                waste.distribution.name().to_owned(),
                String::new(),
                test.name().to_owned(),
                n_in.to_string(),
                (waste.n_boxes - n_in).to_string(),
                (n_in - waste.n_in(Test::Sat)).to_string(),
            ]);
        }
    }
    table.to_csv()
}
