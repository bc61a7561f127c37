//! The report as one page that needs nothing else: no script, no font, no picture from elsewhere.

mod map;
mod svg;

use std::collections::BTreeMap;
use std::fmt::Write;

use base64::Engine;
use cullet::cull::{Fate, Test};
use cullet::transform::Plane;
use cullet::{Frame, Renderer, Settings, View};

use super::downstream::{Mode, ms, saved_percent};
use super::measure::{Figures, SizeFigures};
use super::sweep::{Metric, metrics};
use super::verdicts::TESTS;
use super::waste::Waste;
use super::{CullArgs, Measured, report};
use crate::picture_file::{Format, Pixels, PngCompression, Samples, encode};
use map::{MOST_BOXES, Map, Projection};
use svg::{Bar, Part, Series, bars, lines, shares, short};

const GREEN: &str = "#2f9e62";
const RED: &str = "#e5484d";
const ORANGE: &str = "#f0872e";
const BLUE: &str = "#4c78c8";
const GREY: &str = "#9aa4b2";
const PALE: &str = "#c9d0da";

/// The colour of boxes of one fate.
fn color(fate: Fate) -> &'static str {
    match fate {
        Fate::Inside => GREEN,
        Fate::Crossing => "#86c99b",
        Fate::Plane(Plane::Left) => BLUE,
        Fate::Plane(Plane::Right) => "#7fb2e8",
        Fate::Plane(Plane::Bottom) => "#8d63b8",
        Fate::Plane(Plane::Top) => "#c49ad8",
        Fate::Plane(Plane::Near) => "#d8b22c",
        Fate::Plane(Plane::Far) => "#9c755f",
        Fate::Reverse => ORANGE,
        Fate::Edges => RED,
        Fate::Empty => GREY,
        Fate::Invalid => "#5b6472",
    }
}

fn fate_title(fate: Fate) -> String {
    match fate {
        Fate::Inside => "visible, wholly inside".into(),
        Fate::Crossing => "visible, crossing".into(),
        Fate::Plane(plane) => format!("outside the {} plane", plane.name()),
        Fate::Reverse => "found by the reverse test only".into(),
        Fate::Edges => "found by exact SAT only".into(),
        Fate::Empty => "empty".into(),
        Fate::Invalid => "invalid (NaN): always kept".into(),
    }
}

/// Text for HTML.
fn escape(text: &str) -> String {
    let replace = |c: char| match c {
        '&' => "&amp;".to_owned(),
        '<' => "&lt;".to_owned(),
        '>' => "&gt;".to_owned(),
        '\'' => "&#39;".to_owned(),
        '"' => "&quot;".to_owned(),
        c if c.is_control() => " ".to_owned(),
        c => c.to_string(),
    };
    text.chars().map(replace).collect()
}

/// The whole page.
pub fn page(args: &CullArgs, measured: Option<&Measured>, wastes: &[Waste]) -> String {
    let scene = args.scene.as_ref().or(args.boxes.as_ref());
    let name = scene.map_or("generated boxes".into(), |path| match path.to_str() {
        Some("-") => "standard input".into(),
        _ => path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned(),
    });
    let mut body = format!("<h1>Culling {}</h1>\n", escape(&name));
    match measured {
        Some(measured) => body += &about(args, measured),
        None => body += "<p class='sub'>What each test leaves over on boxes of nine kinds.</p>\n",
    }
    if !wastes.is_empty() {
        body += &distributions(wastes);
    }
    let _ = writeln!(
        body,
        "<footer>cullet {}, report schema {}. False visible: kept by a test, rejected by the exact \
         one. False culls, the other way around: {}.</footer>",
        env!("CARGO_PKG_VERSION"),
        report::SCHEMA,
        measured.map_or(0, |m| m.sum.tests.iter().map(|test| test.n_false_culled).sum::<u64>()),
    );
    format!(
        "<!doctype html>\n<html lang='en'><head><meta charset='utf-8'>\
         <meta name='viewport' content='width=device-width,initial-scale=1'>\
         <title>Culling {}</title>\n<style>\n{}</style></head>\n<body>\n{body}</body></html>\n",
        escape(&name),
        include_str!("style.css"),
    )
}

fn section(title: &str, text: &str, body: &str) -> String {
    format!("<section><h2>{title}</h2><p>{text}</p>{body}</section>\n")
}

/// Words beside a chart that would be too wide by itself.
fn beside(title: &str, text: &str, body: &str) -> String {
    format!(
        "<section class='beside'><div><h2>{title}</h2><p>{text}</p></div><div>{body}</div></section>\n"
    )
}

fn percent(part: u64, whole: u64) -> f64 {
    100.0 * part as f64 / whole.max(1) as f64
}

/// Everything about one scene or set of boxes.
fn about(args: &CullArgs, measured: &Measured) -> String {
    let figures = &measured.shown[measured.focus].figures;
    let sum = &measured.sum;
    let cameras = match (measured.shown.len(), &args.path) {
        (n, Some(path)) => format!(
            "{n} cameras along <b>{}</b>; pictures and charts show camera {}, the one with the most to \
             do, unless they say otherwise",
            escape(&report::path_name(path)),
            measured.focus
        ),
        _ if args.clip_from_world.is_some() => "One frustum, from a matrix".to_owned(),
        _ => format!("One camera, <b>{}</b>", escape(&args.camera)),
    };
    let mut page =
        format!("<p class='sub'>{cameras}. One thread, wide tests by {}.</p>\n", measured.simd);
    page += &tiles(measured, figures);
    page += &maps(measured);
    page += "<div class='pair'>";
    page += &tests(figures);
    page += &costs(sum, measured.simd);
    page += "</div>\n<div class='pair'>";
    page += &planes(figures);
    page += &sizes(sum);
    page += "</div>\n";
    page += &levels(measured, figures);
    if !measured.downstream.is_empty() {
        page += &downstream(measured);
    }
    if measured.shown.len() > 1 {
        page += &path(measured);
    }
    page
}

fn tiles(measured: &Measured, figures: &Figures) -> String {
    let n = measured.input.boxes.len() as u64;
    let visible = figures.of(Test::Sat).n_in;
    let tree = &figures.tree;
    let asked = tree.n_boxes_tested();
    let mut tiles = vec![
        (short(n as f64), "boxes".to_owned()),
        (short(visible as f64), format!("visible: {:.1}%", percent(visible, n))),
        (
            short(figures.of(Test::PVertex).n_false_visible as f64),
            "kept by six planes, not visible".to_owned(),
        ),
        (
            short(figures.of(Test::Both).n_false_visible as f64),
            "kept by planes and reverse, not visible".to_owned(),
        ),
        (short(asked as f64), format!("box tests in the tree: {:.1}% of flat", percent(asked, n))),
        (format!("{} µs", short(1e3 * tree.ms.warm())), "for a walk of the tree".to_owned()),
    ];
    if let Some(drawn) = measured.downstream.iter().find(|drawn| drawn.mode == Mode::DEFAULT) {
        let saved = drawn.frame.n_triangles_of_culled_objects;
        let all = saved + drawn.n_triangles();
        tiles.push((
            format!("{:.0}%", percent(saved, all)),
            "of all triangles never touched".into(),
        ));
    }
    let tiles: String = tiles
        .iter()
        .map(|(n, text)| format!("<div class='tile'><b>{n}</b><span>{text}</span></div>"))
        .collect();
    format!("<div class='tiles'>{tiles}</div>\n")
}

fn maps(measured: &Measured) -> String {
    let shot = &measured.input.shots[measured.focus];
    let map = Map {
        boxes: &measured.input.boxes,
        verdicts: &measured.verdicts,
        frustum: &shot.frustum,
        eye: shot.camera.is_some(),
    };
    let forward =
        shot.camera.map_or(shot.frustum.planes()[Plane::Near.index()].normal, |c| -c.back());
    let (mut keys, mut switches, mut rules) = (String::new(), String::new(), String::new());
    let figures = &measured.shown[measured.focus].figures;
    for (i, (fate, n)) in
        Fate::ALL.iter().zip(figures.fates).enumerate().filter(|(_, (_, n))| *n > 0)
    {
        let _ = write!(switches, "<input class='show' type='checkbox' id='f{i}' checked>");
        let _ = write!(
            keys,
            "<label class='key' for='f{i}'><i style='background:{}'></i>{} <b>{n}</b></label>",
            color(*fate),
            fate_title(*fate)
        );
        let _ = write!(
            rules,
            "#f{i}:not(:checked)~.maps .f{i}{{display:none}}#f{i}:not(:checked)~div label[for=f{i}]{{opacity:.35}}"
        );
    }
    let mut figures = String::new();
    for (name, projection) in
        [("From above", Projection::TOP), ("From the side", Projection::side(forward))]
    {
        let _ = write!(
            figures,
            "<figure>{}<figcaption>{name}: {}</figcaption></figure>",
            map.draw(projection),
            projection.title()
        );
    }
    if let Some(picture) = picture(measured) {
        let _ = write!(
            figures,
            "<figure><img alt='the picture of this camera' src='data:image/png;base64,{picture}'>\
             <figcaption>What the camera sees</figcaption></figure>"
        );
    }
    let n = measured.input.boxes.len();
    let step = n.div_ceil(MOST_BOXES).max(1);
    let shown = match step {
        1 => String::new(),
        _ => format!(" One box in {step} is drawn, of {n}."),
    };
    let text = format!(
        "Each box in the colour of its verdict; a box outside several planes has the colour of the \
         first. Click a colour to hide its boxes.{shown}"
    );
    let body = format!(
        "<style>{rules}</style>{switches}<div>{keys}</div><div class='maps pair'>{figures}</div>"
    );
    section("Boxes and frustum", &text, &body)
}

/// The picture of the camera in focus, PNG in base64.
fn picture(measured: &Measured) -> Option<String> {
    let shot = &measured.input.shots[measured.focus];
    let (prepared, camera) = (measured.input.prepared.as_ref()?, shot.camera.as_ref()?);
    let aspect = shot.viewport?.aspect();
    let height = (620.0 / aspect).clamp(100.0, 620.0).round();
    let width = (height * aspect).clamp(1.0, 2000.0).round();
    let viewport = cullet::Viewport::new(width as u32, height as u32).ok()?;
    let mut frame = Frame::default();
    let view = View::new(camera, viewport);
    Renderer::default().render(prepared, &view, &Settings::default(), &mut frame);
    let rgb = frame.rgba8.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect();
    let pixels = Pixels {
        width: viewport.width(),
        height: viewport.height(),
        channels: 3,
        samples: Samples::U8(rgb),
    };
    let png = encode(Format::Png, &pixels, PngCompression::Default).ok()?;
    Some(base64::engine::general_purpose::STANDARD.encode(png))
}

fn tests(figures: &Figures) -> String {
    let n: u64 = figures.fates.iter().sum();
    let visible = figures.of(Test::Sat).n_in;
    let bar = |(test, of): (&Test, &super::measure::TestFigures)| {
        let part = |value: u64, color, what: &str| Part {
            value: value as f64,
            color,
            title: format!("{}: {value} {what}", test.name()),
        };
        let wasted = of.n_false_visible;
        Bar {
            label: test.name().replace('_', "-"),
            parts: vec![
                part(visible, GREEN, "visible"),
                part(wasted, RED, "kept, not visible"),
                part(n - of.n_in, PALE, "rejected"),
            ],
            note: match wasted {
                0 => "nothing wasted".into(),
                _ => format!("{} wasted, {:.1}%", short(wasted as f64), percent(wasted, of.n_in)),
            },
        }
    };
    let body = bars(&TESTS.iter().zip(&figures.tests).map(bar).collect::<Vec<_>>());
    section(
        "What each test keeps",
        "<b style='color:#2f9e62'>Visible</b>, <b style='color:#e5484d'>kept though not \
         visible</b>, and rejected. Each test alone, over all boxes.",
        &body,
    )
}

fn costs(sum: &Figures, simd: &str) -> String {
    let rows =
        TESTS.iter().zip(&sum.tests).map(|(test, of)| (test.name().replace('_', "-"), of.ns));
    let rows = rows.chain([
        (format!("p-vertex x8 {simd}"), sum.flat.ns),
        ("16-bit bounds first".to_owned(), sum.coarse.ns),
    ]);
    let has_boxes = sum.fates.iter().any(|n| *n > 0);
    let bar = |(label, ns): (String, super::measure::Timing)| {
        if !has_boxes {
            return Bar { label, parts: vec![], note: "–".into() };
        }
        let warm = ns.warm();
        let extra = ns.cold().map_or(0.0, |cold| (cold - warm).max(0.0));
        Bar {
            label,
            parts: vec![
                Part { value: warm, color: BLUE, title: format!("{warm:.2} ns") },
                Part { value: extra, color: PALE, title: format!("{:.2} ns cold", warm + extra) },
            ],
            note: match ns.cold() {
                Some(cold) => format!("{} ns, cold {}", short(warm), short(cold)),
                None => format!("{} ns", short(warm)),
            },
        }
    };
    section(
        "What each test costs",
        "Nanoseconds per box, median of interleaved rounds, on a path the mean over its cameras; \
         <b>cold</b>: after the caches were filled with something else, at the first camera. \
         x8: eight boxes at a time in f32, the test that the tree makes.",
        &bars(&rows.map(bar).collect::<Vec<_>>()),
    )
}

fn planes(figures: &Figures) -> String {
    let n: u64 = figures.fates.iter().sum();
    let bar = |fate: &Fate| {
        let at = fate.index();
        let value = figures.fates[at];
        Bar {
            label: match fate {
                Fate::Edges => "SAT only".into(),
                Fate::Reverse => "reverse only".into(),
                fate => fate.name().into(),
            },
            parts: vec![Part {
                value: value as f64,
                color: color(*fate),
                title: value.to_string(),
            }],
            note: format!("{} ({:.1}%)", short(value as f64), percent(value, n)),
        }
    };
    section(
        "Who rejects",
        "Boxes by the first plane that rejects them, then those that only a finer test rejects.",
        &bars(&Fate::ALL[2..10].iter().map(bar).collect::<Vec<_>>()),
    )
}

fn sizes(sum: &Figures) -> String {
    let Some((low, high)) = usual_sizes(&sum.sizes) else {
        return section("Waste by size of box", "No box here has a size.", "");
    };
    let n_boxes =
        |sizes: &mut dyn Iterator<Item = &SizeFigures>| sizes.map(|size| size.n_boxes).sum::<u64>();
    let n_all = n_boxes(&mut sum.sizes.values());
    let n_left_out = n_all - n_boxes(&mut sum.sizes.range(low..=high).map(|(_, size)| size));
    let left_out = match (n_left_out, sum.sizes.first_key_value(), sum.sizes.last_key_value()) {
        (1.., Some((&least, _)), Some((&most, _))) => format!(
            " <b>Left out:</b> at both ends, sizes that fewer than one box in a thousand has ({}% of \
             all boxes; the sizes go from {} to {}).",
            short(percent(n_left_out, n_all)),
            short(2f64.powi(least)),
            short(2f64.powi(most)),
        ),
        _ => String::new(),
    };
    let exact = TESTS.len() - 1;
    let series = |label: &str, color, test: usize| Series {
        label: label.into(),
        color,
        values: (low..=high)
            .map(|i| {
                let kept = sum.sizes.get(&i).map_or([0; TESTS.len()], |size| size.n_in);
                match kept[test] {
                    0 => f64::NAN,
                    n => percent(n.saturating_sub(kept[exact]), n),
                }
            })
            .collect(),
    };
    let step = (((high - low) / 10) + 1) as usize;
    let names: Vec<(usize, String)> = (low..=high)
        .enumerate()
        .step_by(step)
        .map(|(i, exponent)| (i, short(2f64.powi(exponent))))
        .collect();
    let body = lines(
        &[
            series("sat", GREEN, exact),
            series("reverse", ORANGE, 3),
            series("p-vertex", BLUE, 2),
            series("both", "#8d63b8", 4),
        ],
        &names,
        "% of what the test keeps is not visible",
    );
    let text = format!(
        "By the longest edge of the box, from a power of two up to the next, in units of the scene, \
         all cameras together. Planes alone waste on boxes larger than the view, the reverse test on \
         small ones.{left_out}"
    );
    section("Waste by size of box", &text, &body)
}

/// The first and the last size that at least one box in a thousand has, as powers of two: one odd box
/// must not stretch the axis over all that floats can hold. All sizes, if none is that frequent.
fn usual_sizes(sizes: &BTreeMap<i32, SizeFigures>) -> Option<(i32, i32)> {
    let n_all: u64 = sizes.values().map(|size| size.n_boxes).sum();
    let usual = |(_, size): &(&i32, &SizeFigures)| 1000 * size.n_boxes >= n_all;
    let first = sizes.iter().find(usual).or(sizes.first_key_value());
    let last = sizes.iter().rev().find(usual).or(sizes.last_key_value());
    Some((*first?.0, *last?.0))
}

fn levels(measured: &Measured, figures: &Figures) -> String {
    let tree = &figures.tree;
    let walked = tree.levels.iter().zip(&tree.walked).enumerate();
    let mut rows: Vec<Bar> = walked
        .map(|(i, (all, walked))| {
            let part = |value: u64, color, what: &str| Part {
                value: value as f64,
                color,
                title: format!("level {i}: {value} {what}"),
            };
            let skipped = all.n_nodes.saturating_sub(walked.tested);
            Bar {
                label: format!("level {i}"),
                parts: vec![
                    part(walked.inside, GREEN, "inside: nothing below is tested"),
                    part(walked.straddling, "#86c99b", "crossing"),
                    part(walked.outside, BLUE, "outside: nothing below is tested"),
                    part(skipped, PALE, "not tested"),
                ],
                note: format!(
                    "{} of {} tested",
                    short(walked.tested as f64),
                    short(all.n_nodes as f64)
                ),
            }
        })
        .collect();
    let items = &tree.stats.items;
    let part = |value: u64, color, what: &str| Part {
        value: value as f64,
        color,
        title: format!("{value} boxes {what}"),
    };
    let n = measured.input.boxes.len() as u64;
    rows.push(Bar {
        label: "boxes".into(),
        parts: vec![
            part(items.inside + tree.stats.n_untested, GREEN, "inside"),
            part(items.straddling, "#86c99b", "crossing"),
            part(items.outside, BLUE, "outside"),
            part(n.saturating_sub(items.tested + tree.stats.n_untested), PALE, "never looked at"),
        ],
        note: format!("{} of {} tested", short(items.tested as f64), short(n as f64)),
    });
    let [planes, both, exact] = tree.n_tested_by;
    let fewer = |n: u64| percent(planes.saturating_sub(n), planes);
    let text = format!(
        "Eight children to a node, asked by planes with inherited masks: \
         <b style='color:#2f9e62'>inside</b>, crossing, <b style='color:#4c78c8'>outside</b>, and \
         what no test was spent on. Asking the nodes finer questions would change little or much: \
         by planes alone <b>{planes}</b> node tests, with the reverse test <b>{both}</b> \
         ({:.1}% fewer), by exact SAT <b>{exact}</b> ({:.1}% fewer).",
        fewer(both),
        fewer(exact)
    );
    beside("Down the tree", &text, &shares(&rows))
}

fn downstream(measured: &Measured) -> String {
    let mut rows = String::new();
    let mut chart = Vec::new();
    for drawn in &measured.downstream {
        let stages = &drawn.frame.stages;
        let parts = [
            ("cull", RED, stages.cull),
            ("geometry", BLUE, stages.geometry),
            ("raster", ORANGE, stages.raster),
            ("shade", GREEN, stages.shade),
        ];
        chart.push(Bar {
            label: drawn.mode.name().replace('_', "-"),
            parts: parts
                .iter()
                .map(|(name, color, time)| Part {
                    value: ms(*time),
                    color,
                    title: format!("{name} {:.3} ms", ms(*time)),
                })
                .collect(),
            note: match saved_percent(&measured.downstream[0], drawn) {
                Some(percent) => format!("{} ms, saves {percent:.0}%", short(drawn.ms())),
                None => format!("{} ms", short(drawn.ms())),
            },
        });
        let _ = write!(
            rows,
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{:.4}</td><td>{:.3}</td></tr>",
            drawn.mode.name().replace('_', "-"),
            drawn.frame.boxes_tested,
            drawn.frame.objects.n_drawn,
            drawn.n_triangles(),
            drawn.frame.pixels_shaded,
            ms(stages.cull),
            drawn.ms(),
        );
    }
    let body = format!(
        "{}<div class='scroll'><table><thead><tr><th>--cull</th><th>boxes tested</th><th>objects \
         drawn</th><th>triangles</th><th>pixels shaded</th><th>cull ms</th><th>frame ms</th></tr>\
         </thead><tbody>{rows}</tbody></table></div>",
        bars(&chart)
    );
    beside(
        "What it saves in the renderer",
        "Real frames, one thread: time to <b style='color:#e5484d'>cull</b>, for \
         <b style='color:#4c78c8'>geometry</b>, <b style='color:#f0872e'>coverage and depth</b>, \
         and <b style='color:#2f9e62'>shading</b>. Culling never changes a pixel, so those shaded \
         are the same in every row: what is saved is vertex work, told by the fastest of the \
         frames, where it is more than their spread.",
        &body,
    )
}

fn path(measured: &Measured) -> String {
    let metrics = metrics(&measured.shown);
    let find = |name: &str| metrics.iter().find(|metric| metric.name == name);
    let n = measured.shown.len();
    let names: Vec<(usize, String)> =
        (0..n).step_by(n.div_ceil(12).max(1)).map(|i| (i, i.to_string())).collect();
    let series = |name: &str, label: &str, color| {
        find(name).map(|metric| Series {
            label: label.into(),
            color,
            values: metric.values.clone(),
        })
    };
    let with_wasted = |wasted: &str, label: &str, color| {
        let (visible, wasted) = (find("visible")?, find(wasted)?);
        let values = visible.values.iter().zip(&wasted.values).map(|(a, b)| a + b).collect();
        Some(Series { label: label.into(), color, values })
    };
    let chart = |series: Vec<Option<Series>>, unit: &str| {
        let series: Vec<Series> = series.into_iter().flatten().collect();
        if series.is_empty() {
            String::new()
        } else {
            format!("<div>{}</div>", lines(&series, &names, unit))
        }
    };
    let mut body = String::from("<div class='pair'>");
    body += &chart(
        vec![
            with_wasted("p_vertex_false_visible", "kept by p-vertex", RED),
            with_wasted("both_false_visible", "kept by both", ORANGE),
            series("visible", "visible", GREEN),
        ],
        "boxes",
    );
    body += &chart(vec![series("boxes_tested", "box tests in the walk", BLUE)], "box tests");
    body += &chart(vec![series("walk_ms", "walk", BLUE)], "ms");
    body += &chart(
        vec![
            series("frame_ms_all", "frame, no culling", GREY),
            series("frame_ms", "frame, culled", GREEN),
        ],
        "ms",
    );
    body += "</div><div class='scroll'><table><thead><tr><th>over the path</th><th>min</th><th>p50</th>\
             <th>p90</th><th>p99</th><th>max</th><th>worst camera</th></tr></thead><tbody>";
    for metric in &metrics {
        body += &row(metric);
    }
    body += "</tbody></table></div>";
    section(
        "Along the path",
        "One point per camera. Percentiles are values that a camera has; the worst one is named, so \
         that it can be looked at by itself.",
        &body,
    )
}

fn row(metric: &Metric) -> String {
    let value = |share| format!("<td>{}</td>", short(metric.percentile(share)));
    let values: String = [0.0, 0.5, 0.9, 0.99, 1.0].map(value).concat();
    format!("<tr><td>{}</td>{values}<td>{}</td></tr>", metric.title, metric.worst())
}

fn distributions(wastes: &[Waste]) -> String {
    let mut chart = Vec::new();
    let mut rows = String::new();
    for waste in wastes {
        let row = [
            (Test::PVertex, BLUE, "p-vertex"),
            (Test::Reverse, ORANGE, "reverse"),
            (Test::Both, "#8d63b8", "both"),
        ];
        for (i, (test, color, name)) in row.into_iter().enumerate() {
            let percent = waste.percent(test);
            chart.push(Bar {
                label: if i == 1 { waste.distribution.name().into() } else { String::new() },
                parts: vec![Part {
                    value: percent,
                    color,
                    title: format!("{name}: {percent:.2}%"),
                }],
                note: format!("{name} {percent:.2}%"),
            });
        }
        let cell = |test| format!("<td>{:.2}%</td>", waste.percent(test));
        let _ = write!(
            rows,
            "<tr><td>{}</td><td>{}</td><td>{}</td>{}{}{}{}</tr>",
            waste.distribution.name(),
            waste.n_boxes,
            waste.n_in(Test::Sat),
            cell(Test::PVertex),
            cell(Test::Reverse),
            cell(Test::Both),
            cell(Test::Sat),
        );
    }
    let of = |name: &str, test| {
        let waste = wastes.iter().find(|waste| waste.distribution.name() == name);
        waste.map_or(f64::NAN, |waste| waste.percent(test))
    };
    let text = format!(
        "The share of what a test keeps that is not visible, on generated boxes. <b>In an ordinary \
         city the finer tests pay little:</b> planes alone waste {:.1}% there, both {:.1}%. \
         <b>Where boxes are large beside the frustum only SAT is clean:</b> both cheap tests together \
         still waste {:.0}% on screen tiles, {:.0}% on light clusters and {:.0}% under a rolled camera; \
         SAT wastes nothing anywhere. It asks some thirty planes of what no plane rejects, so ask it \
         last, of what the others keep.",
        of("city", Test::PVertex),
        of("city", Test::Both),
        of("tiles", Test::Both),
        of("clusters", Test::Both),
        of("rolled", Test::Both),
    );
    let body = format!(
        "<div class='pair'><div>{}</div><div class='scroll'><table><thead><tr><th>kind</th><th>boxes\
         </th><th>visible</th><th>p-vertex</th><th>reverse</th><th>both</th><th>sat</th></tr></thead>\
         <tbody>{rows}</tbody></table></div></div>",
        bars(&chart)
    );
    section("When do the finer tests pay?", &text, &body)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_odd_size_does_not_stretch_the_axis() {
        let sizes = |all: &[(i32, u64)]| -> BTreeMap<i32, SizeFigures> {
            let size = |n_boxes| SizeFigures { n_boxes, ..SizeFigures::default() };
            all.iter().map(|&(i, n_boxes)| (i, size(n_boxes))).collect()
        };
        assert_eq!(usual_sizes(&sizes(&[])), None);
        assert_eq!(usual_sizes(&sizes(&[(7, 1)])), Some((7, 7)));
        assert_eq!(
            usual_sizes(&sizes(&[(-149, 1), (0, 500), (3, 498), (127, 1)])),
            Some((-149, 127))
        );
        assert_eq!(
            usual_sizes(&sizes(&[(-149, 1), (0, 500), (2, 1), (3, 599), (127, 1)])),
            Some((0, 3))
        );
    }
}
