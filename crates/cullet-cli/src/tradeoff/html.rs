//! The report as one page that needs nothing else: no script, no font, no picture from elsewhere.

use std::fmt::Write;

use base64::Engine;
use cullet_measure::{ErrorMap, Picture, heatmap};

use super::Report;
use super::findings::{Finding, Kind};
use super::measure::{Measured, name};
use super::plot::{self, escape};
use super::study::Study;
use super::table::{Row, panels};
use super::words::short;
use crate::exit::Failure;
use crate::picture_file::{Format, Pixels, PngCompression, Samples, encode};

/// The FLIP error that is painted brightest.
const FULL: f32 = 0.4;

/// The whole page.
pub fn page(report: &Report<'_>) -> Result<String, Failure> {
    let mut body = String::from("<h1>Speed against accuracy</h1>\n");
    let _ = writeln!(
        body,
        "<p class='sub'>cullet {}: {}, {} rows, at {} x {} px on {}. {}</p>",
        env!("CARGO_PKG_VERSION"),
        match report.scenes.len() {
            1 => "one scene".to_owned(),
            n => format!("{n} scenes"),
        },
        report.rows.len(),
        report.size.0,
        report.size.1,
        match report.threads {
            0 => "all cores".into(),
            1 => "one thread".into(),
            n => format!("{n} threads"),
        },
        escape(&report.machine.words()),
    );
    let _ = writeln!(body, "<section><h2>What the figures say</h2>{}</section>", findings(report));
    let _ = writeln!(
        body,
        "<section><h2>Time against error</h2><p>Time is the median frame ({}), error is against \
         references that are not the fast path. Point at a dot for its figures.</p>{}</section>",
        report.clock,
        plot::svg(report.rows)
    );
    for scene in report.scenes {
        let _ = writeln!(
            body,
            "<section><h2>{}</h2><p>Camera: {}. Reference: {}. {} rounds.{}</p>",
            escape(&scene.name),
            escape(&scene.camera),
            escape(&scene.measured.reference.how),
            scene.measured.n_rounds,
            match scene.measured.left_out.is_empty() {
                true => String::new(),
                false => format!(
                    " <b>Left out</b>, as the budget was short: {}.",
                    escape(&scene.measured.left_out.join(", "))
                ),
            }
        );
        body += &pictures(&scene.measured.reference.picture, &scene.measured.all)?;
        body += "</section>\n";
    }
    body += &studies(report.studies);
    body += &tables(report.rows);
    let _ = writeln!(
        body,
        "<footer>Times are the default's median times the median ratio to it, round by round; spread: half \
         the interquartile range of the ratio as a fraction of it; &#177;: how far the ratio may be off. \
         Rows of plain code are timed where there is no wide code for their value: compare them with each other. Rows beaten \
         by no more than their spread in time, and in error by half a percent or what the \
         two halves of the samples disagree by, or chance makes of counts, count as on the front. Verdicts are given beyond the \
         doubts (&#177;); within them the page cannot tell. FLIP error maps: black is 0, \
         the palest yellow {FULL} and more. Budget {} s, took {:.0} s. Settings: {}.</footer>",
        report.budget,
        report.took,
        escape(&report.command),
    );
    Ok(format!(
        "<!doctype html>\n<html lang='en'><head><meta charset='utf-8'>\
         <meta name='viewport' content='width=device-width,initial-scale=1'>\
         <title>Speed against accuracy</title>\n<style>\n{}</style></head>\n<body>\n{body}</body></html>\n",
        include_str!("style.css"),
    ))
}

fn findings(report: &Report<'_>) -> String {
    let mut html = String::new();
    let mut list = |title: &str, findings: &[Finding]| {
        let _ = write!(html, "<h3>{title}</h3><ul>");
        for finding in findings {
            let class = match finding.kind {
                Kind::Confirmed => "yes",
                Kind::Refuted => "no",
                Kind::CannotTell | Kind::Measured => "open",
            };
            let name = finding.kind.name();
            let _ =
                write!(html, "<li><b class='{class}'>{name}</b> {}</li>", escape(&finding.text));
        }
        html += "</ul>";
    };
    list("What one would expect", &report.findings.expectations);
    list("Every trade against the default", &report.findings.trades);
    html
}

/// The reference, and each picture that differs from all before, over its errors.
fn pictures(reference: &Picture, all: &[Measured]) -> Result<String, Failure> {
    let mut html = String::from("<div class='pictures'>");
    let _ = write!(
        html,
        "<figure><img alt='reference' src='{}'><figcaption><b>reference</b></figcaption></figure>",
        photo(reference)?
    );
    let mut shown: Vec<&Picture> = Vec::new();
    for one in all {
        let Some(map) = &one.errors.map else { continue };
        if shown.contains(&&one.picture) {
            continue;
        }
        shown.push(&one.picture);
        let name = name(&one.configuration);
        let name = escape(&name);
        let _ = write!(
            html,
            "<figure><img alt='{name}' src='{}'><img alt='errors of {name}' src='{}'>\
             <figcaption><b>{name}</b> {:.2}x, FLIP {}</figcaption></figure>",
            photo(&one.picture)?,
            heat(map)?,
            one.ratio.median,
            short(map.mean()),
        );
    }
    Ok(html + "</div>")
}

/// The figures of what was measured by itself.
fn studies(studies: &[Study]) -> String {
    let mut html = String::from("<section><h2>Measured by itself</h2><div class='tables'>");
    for study in studies {
        let scene = study.scene.as_ref().map_or(String::new(), |scene| format!("{scene}: "));
        let _ = write!(
            html,
            "<details><summary><b>{}{}</b></summary><p>{}</p><div class='scroll'><table><thead><tr><th>",
            escape(&scene),
            study.name,
            escape(study.about)
        );
        study.columns.iter().for_each(|name| _ = write!(html, "<th>{}", escape(name)));
        html += "</tr></thead><tbody>";
        for (name, numbers) in &study.lines {
            let _ = write!(html, "<tr><td>{}", escape(name));
            numbers.iter().for_each(|number| _ = write!(html, "<td>{}", short(*number)));
            html += "</tr>";
        }
        html += "</tbody></table></div></details>\n";
    }
    html + "</div></section>\n"
}

fn tables(rows: &[Row]) -> String {
    let mut html = String::from("<section><h2>All figures</h2><div class='tables'>");
    for (scene, metric) in panels(rows) {
        let _ = write!(
            html,
            "<details><summary><b>{}</b>: {}</summary><p>{}</p><div class='scroll'><table><thead>\
             <tr><th>knob<th>value<th>ms<th>times the default<th>spread<th>&#177;<th>{}<th>front</tr></thead><tbody>",
            escape(&scene),
            metric.name(),
            metric.about(),
            metric.name(),
        );
        for row in rows.iter().filter(|row| row.scene == scene && row.metric == metric) {
            let _ = write!(
                html,
                "<tr{}><td>{}<td>{}<td>{}<td>{:.2}<td>{:.1}%<td>{:.1}%<td>{}<td>{}</tr>",
                if row.default { " class='default'" } else { "" },
                row.knob,
                row.value,
                short(row.time_ms),
                row.time_ratio,
                100.0 * row.spread,
                100.0 * row.time_doubt,
                short(row.error),
                match (row.pareto, row.tied) {
                    _ if row.plain_code => "plain code",
                    (true, false) => "●",
                    (true, true) => "≈",
                    _ => "",
                },
            );
        }
        html += "</tbody></table></div></details>\n";
    }
    html + "</div></section>\n"
}

/// A picture at half its size, as a data URL.
fn photo(picture: &Picture) -> Result<String, Failure> {
    let (width, height) = (picture.width(), picture.height());
    let pixels = picture.pixels();
    let mean = |x: usize, y: usize, c: usize| {
        let at = |dx: usize, dy: usize| {
            pixels[(2 * y + dy).min(height - 1) * width + (2 * x + dx).min(width - 1)][c]
        };
        (255.0 * 0.25 * (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1))).round() as u8
    };
    let (w, h) = (width.div_ceil(2), height.div_ceil(2));
    let samples = (0..h).flat_map(|y| (0..w).flat_map(move |x| [0, 1, 2].map(|c| mean(x, y, c))));
    data_url(w, h, samples.collect())
}

/// An error map at half its size, the largest of four for each, so that nothing gets lost.
fn heat(map: &ErrorMap) -> Result<String, Failure> {
    let (w, h) = (map.width.div_ceil(2), map.height.div_ceil(2));
    let at =
        |x: usize, y: usize| map.values[y.min(map.height - 1) * map.width + x.min(map.width - 1)];
    let largest = |x: usize, y: usize| {
        let four = [
            at(2 * x, 2 * y),
            at(2 * x + 1, 2 * y),
            at(2 * x, 2 * y + 1),
            at(2 * x + 1, 2 * y + 1),
        ];
        four.into_iter().fold(0.0, f32::max)
    };
    let values = (0..h).flat_map(|y| (0..w).map(move |x| largest(x, y))).collect();
    let small = ErrorMap { width: w, height: h, values };
    data_url(w, h, heatmap(&small, FULL))
}

fn data_url(width: usize, height: usize, samples: Vec<u8>) -> Result<String, Failure> {
    let (width, height) = (width as u32, height as u32);
    let pixels = Pixels { width, height, channels: 3, samples: Samples::U8(samples) };
    let file = encode(Format::Jpeg, &pixels, PngCompression::Fast).map_err(Failure::output)?;
    let text = base64::engine::general_purpose::STANDARD.encode(file);
    Ok(format!("data:image/jpeg;base64,{text}"))
}
