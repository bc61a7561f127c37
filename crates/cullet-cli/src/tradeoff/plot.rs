//! Time against error, both on logarithmic axes: a row of panels per scene, a panel per metric.
//!
//! What is on the front is a full dot on the line; what is beaten is hollow; what is timed in plain code is
//! a square, and on no line: its time compares with that of other squares alone. An error of 0 lies on the
//! bottom line, which says so.

use std::fmt::Write;

use super::metrics::Metric;
use super::table::{Row, has_front, panels};
use super::words::{distinct, short};

const WIDTH: f64 = 372.0;
const HEIGHT: f64 = 300.0;
const LEFT: f64 = 56.0;
const RIGHT: f64 = 16.0;
const TOP: f64 = 34.0;
const BOTTOM: f64 = 44.0;
/// Above the panels, for the title and the key.
const HEAD: f64 = 84.0;
/// Below the smallest error, for errors of 0.
const ZERO: f64 = 20.0;

const COLORS: [&str; 18] = [
    "#d62728", "#1f77b4", "#2ca02c", "#9467bd", "#e67700", "#8c564b", "#17899a", "#c2549d",
    "#6b7280", "#a3871a", "#0b3d91", "#7a1f1f", "#3d5a1e", "#5c2a86", "#ff9d5c", "#c9a38f",
    "#63c6d4", "#f2a3cf",
];

/// The drawing, for a file of its own or a page.
pub fn svg(rows: &[Row]) -> String {
    let of = |scene: &str, metric| -> Vec<&Row> {
        rows.iter().filter(|row| row.scene == scene && row.metric == metric).collect()
    };
    // A panel of one configuration has nothing to compare.
    let mut panels = panels(rows);
    panels.retain(|(scene, metric)| has_front(&of(scene, *metric)));
    let knobs = distinct(rows.iter().map(|row| row.knob));
    let mut scenes: Vec<(&str, Vec<Metric>)> = Vec::new();
    for (scene, metric) in &panels {
        match scenes.iter_mut().find(|(known, _)| known == scene) {
            Some((_, metrics)) => metrics.push(*metric),
            None => scenes.push((scene, vec![*metric])),
        }
    }
    let columns = scenes.iter().map(|(_, metrics)| metrics.len()).max().unwrap_or(0).clamp(1, 3);
    let n_rows: usize = scenes.iter().map(|(_, metrics)| metrics.len().div_ceil(columns)).sum();
    let (width, height) = (WIDTH * columns.max(2) as f64, HEAD + HEIGHT * n_rows as f64);
    let mut svg = format!(
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {width} {height}' \
         font-family='system-ui, Segoe UI, Roboto, Arial, sans-serif' font-size='11.5'>\n\
         <rect width='{width}' height='{height}' fill='#fff'/>\n\
         <text x='14' y='22' font-size='15' font-weight='600'>Time against error</text>\n\
         <text x='176' y='22' fill='#555'>left is faster, down is truer; full dots on the line: \
         the front; hollow: beaten; squares: timed in plain code</text>\n"
    );
    let (mut x, mut y) = (14.0, 42.0);
    for (i, knob) in knobs.iter().enumerate() {
        let color = COLORS[i % COLORS.len()];
        let room = 30.0 + 6.6 * knob.len() as f64;
        if x + room > width {
            (x, y) = (14.0, y + 20.0);
        }
        let _ = writeln!(
            svg,
            "<circle cx='{:.1}' cy='{y}' r='4.5' fill='{color}'/><text x='{:.1}' y='{}'>{knob}</text>",
            x + 4.5,
            x + 13.0,
            y + 4.0
        );
        x += room;
    }
    let mut y = HEAD;
    for (scene, metrics) in scenes {
        for line in metrics.chunks(columns) {
            for (column, metric) in line.iter().enumerate() {
                let own = of(scene, *metric);
                let _ = writeln!(svg, "<g transform='translate({} {y})'>", WIDTH * column as f64);
                panel(&mut svg, scene, *metric, &own, &knobs);
                svg += "</g>\n";
            }
            y += HEIGHT;
        }
    }
    svg + "</svg>\n"
}

/// A logarithmic axis.
struct Axis {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl Axis {
    /// Around `values`, those above 0, and at least `least` decades long.
    fn around(values: impl Iterator<Item = f64>, least: f64, from: f64, to: f64) -> Axis {
        let logs = values.filter(|v| *v > 0.0 && v.is_finite()).map(f64::log10);
        let (low, high) = logs
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        let (low, high) = if low <= high { (low, high) } else { (0.0, 0.0) };
        let (middle, half) = (0.5 * (low + high), (0.5 * (high - low)).max(0.5 * least));
        let half = 1.08 * half + 0.02;
        Axis { low: middle - half, high: middle + half, from, to }
    }

    fn at(&self, value: f64) -> f64 {
        let part = (value.log10() - self.low) / (self.high - self.low);
        self.from + (self.to - self.from) * part
    }

    /// Of short ranges up to ten of every decade, or 1, 2 and 5; of long ranges every so many decades.
    fn ticks(&self) -> Vec<f64> {
        let span = self.high - self.low;
        let steps: &[f64] = match span {
            _ if span > 2.2 => &[1.0],
            _ if span > 0.9 => &[1.0, 2.0, 5.0],
            _ => &[1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0], // two at least, on the least span
        };
        let stride = ((span / 6.0).ceil() as i32).max(1);
        let decades = (self.low.floor() as i32..=self.high.ceil() as i32)
            .filter(|decade| decade.rem_euclid(stride) == 0);
        let values = decades.flat_map(|d| steps.iter().map(move |step| step * 10f64.powi(d)));
        values.filter(|v| (self.low..=self.high).contains(&v.log10())).collect()
    }
}

fn panel(svg: &mut String, scene: &str, metric: Metric, rows: &[&Row], knobs: &[&str]) {
    let (bottom, right) = (HEIGHT - BOTTOM, WIDTH - RIGHT);
    let xs = Axis::around(rows.iter().map(|row| row.time_ms), 0.3, LEFT, right);
    let ys = Axis::around(rows.iter().map(|row| row.error), 0.5, bottom - ZERO, TOP);
    let name = metric.name();
    let _ = writeln!(
        svg,
        "<text x='{LEFT}' y='20' font-weight='600'>{}: {name}</text>\n\
         <text x='{:.1}' y='{:.1}' text-anchor='middle' fill='#555'>ms</text>\n\
         <rect x='{LEFT}' y='{TOP}' width='{:.1}' height='{:.1}' fill='none' stroke='#ccc'/>",
        escape(scene),
        0.5 * (LEFT + right),
        HEIGHT - 10.0,
        right - LEFT,
        bottom - TOP,
    );
    for value in xs.ticks() {
        let x = xs.at(value);
        let _ = writeln!(
            svg,
            "<line x1='{x:.1}' x2='{x:.1}' y1='{TOP}' y2='{bottom:.1}' stroke='#eee'/>\
             <text x='{x:.1}' y='{:.1}' text-anchor='middle' fill='#555'>{}</text>",
            bottom + 15.0,
            short(value)
        );
    }
    for value in ys.ticks().into_iter().filter(|value| ys.at(*value) < bottom - ZERO + 6.0) {
        let y = ys.at(value);
        let _ = writeln!(
            svg,
            "<line x1='{LEFT}' x2='{right}' y1='{y:.1}' y2='{y:.1}' stroke='#eee'/>\
             <text x='{:.1}' y='{:.1}' text-anchor='end' fill='#555'>{}</text>",
            LEFT - 6.0,
            y + 4.0,
            short(value)
        );
    }
    let place = |row: &Row| {
        let y = if row.error > 0.0 { ys.at(row.error) } else { bottom - 6.0 };
        (xs.at(row.time_ms), y)
    };
    if rows.iter().any(|row| row.error == 0.0) {
        let _ = writeln!(
            svg,
            "<text x='{:.1}' y='{:.1}' text-anchor='end' fill='#555'>0</text>",
            LEFT - 6.0,
            bottom - 2.0
        );
    }
    // Configurations that several knobs name are one dot, of the first.
    let mut dots: Vec<(&Row, Vec<String>)> = Vec::new();
    for row in rows {
        match dots.iter_mut().find(|(known, _)| known.configuration == row.configuration) {
            Some((_, names)) => names.push(row.name()),
            None => dots.push((row, vec![row.name()])),
        }
    }
    dots.sort_by(|(a, _), (b, _)| a.time_ms.total_cmp(&b.time_ms));
    let front: Vec<String> = dots
        .iter()
        .filter(|(row, _)| row.pareto && !row.tied && !row.plain_code)
        .map(|(row, _)| {
            let (x, y) = place(row);
            format!("{x:.1},{y:.1}")
        })
        .collect();
    let _ = writeln!(
        svg,
        "<polyline points='{}' fill='none' stroke='#333' stroke-width='1.2' stroke-opacity='.6'/>",
        front.join(" ")
    );
    // Where no more text fits: dots, and labels as they come. Left, right, base line.
    let mut taken: Vec<(f64, f64, f64)> = Vec::new();
    for (row, _) in &dots {
        let (x, y) = place(row);
        taken.push((x - 5.0, x + 5.0, y + 4.0));
    }
    for (row, names) in &dots {
        let (x, y) = place(row);
        let knob = knobs.iter().position(|knob| *knob == row.knob).unwrap_or(0);
        let color = COLORS[knob % COLORS.len()];
        let fill = if row.pareto && !row.plain_code { color } else { "#fff" };
        let title = format!(
            "{}: {} ms{}, {} {name}",
            escape(&names.join(" = ")),
            short(row.time_ms),
            if row.plain_code { " by plain code" } else { "" },
            short(row.error),
        );
        let paint = format!("fill='{fill}' stroke='{color}' stroke-width='1.6'");
        let _ = if row.plain_code {
            writeln!(
                svg,
                "<rect x='{:.1}' y='{:.1}' width='7' height='7' {paint}><title>{title}</title></rect>",
                x - 3.5,
                y - 3.5
            )
        } else {
            writeln!(
                svg,
                "<circle cx='{x:.1}' cy='{y:.1}' r='4.2' {paint}><title>{title}</title></circle>"
            )
        };
        // The front has names, as far as there is room.
        if row.pareto && !row.plain_code {
            let text = if row.knob == knobs[0] { row.value.to_owned() } else { row.name() };
            let width = 5.9 * text.len() as f64;
            let to_left = x + 8.0 + width > right;
            let start = if to_left { x - 8.0 - width } else { x + 8.0 };
            let at = [y - 5.0, y + 13.0, y - 17.0, y + 25.0].into_iter().find(|at| {
                let inside = *at > TOP + 8.0 && *at < bottom;
                let apart = |(other_start, other_end, other_y): &(f64, f64, f64)| {
                    (at - other_y).abs() > 11.0
                        || start > *other_end
                        || start + width < *other_start
                };
                inside && taken.iter().all(apart)
            });
            if let Some(at) = at {
                taken.push((start, start + width, at));
                let _ = writeln!(
                    svg,
                    "<text x='{start:.1}' y='{at:.1}' font-size='10.5' fill='#222'>{}</text>",
                    escape(&text)
                );
            }
        }
    }
}

/// Text for XML.
pub fn escape(text: &str) -> String {
    let text: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    let text = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    text.replace('\'', "&#39;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::super::table::find_fronts;
    use super::super::table::tests::row;
    use super::*;

    #[test]
    fn fronts_are_full_and_joined_and_the_beaten_hollow() {
        let mut rows = vec![
            row("a<b", "none", 1.0, 0.3),
            Row { configuration: 1, ..row("a<b", "msaa2", 2.0, 0.0) },
            Row { configuration: 2, ..row("a<b", "msaa8", 3.0, 0.4) },
            Row { configuration: 3, plain_code: true, ..row("a<b", "msaa8", 4.0, 0.0) },
            row("alone", "none", 1.0, 0.3),
        ];
        find_fronts(&mut rows);
        let svg = svg(&rows);
        assert_eq!(svg.matches("r='4.2' fill='#fff' stroke=").count(), 1);
        assert_eq!(svg.matches("by plain code").count(), 1);
        assert!(!svg.contains("alone"));
        let line = svg.split("<polyline points='").nth(1).unwrap().split('\'').next().unwrap();
        assert_eq!(line.split(' ').count(), 2);
        assert!(svg.contains("a&lt;b: flip") && svg.ends_with("</svg>\n"));
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
    }

    #[test]
    fn every_axis_can_be_read() {
        for i in 0..200 {
            for wider in [1.0, 1.3, 2.5, 9.0, 120.0, 1e7] {
                let least = 10f64.powf(-3.0 + f64::from(i) * 0.03);
                let axis = Axis::around([least, wider * least].into_iter(), 0.3, 0.0, 300.0);
                let ticks = axis.ticks();
                assert!((2..=12).contains(&ticks.len()), "{least} to {}: {ticks:?}", wider * least);
            }
        }
    }
}
