//! The study as a picture: a panel per mapping, distance against separation, both logarithmic.

use std::fmt::Write;

use super::Point;

/// One panel.
pub struct Panel {
    /// Above it.
    pub title: String,
    /// A name, and what was measured.
    pub curves: Vec<(&'static str, Vec<Point>)>,
}

const WIDTH: f64 = 400.0;
const HEIGHT: f64 = 340.0;
const LEFT: f64 = 62.0;
const TOP: f64 = 40.0;
/// Decades shown.
const X: [i32; 2] = [-1, 12];
const Y: [i32; 2] = [-8, 3];
const COLORS: [&str; 4] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7"];

/// The panels side by side. Lines are predictions, dots are measured, crosses at the upper border
/// mean that nothing could be told apart.
pub fn svg(panels: &[Panel]) -> String {
    let width = panels.len() as f64 * (WIDTH + LEFT + 16.0);
    let height = HEIGHT + TOP + 84.0;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
         font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"{width}\" \
         height=\"{height}\" fill=\"#fff\"/>\n"
    );
    for (i, panel) in panels.iter().enumerate() {
        let left = LEFT + i as f64 * (WIDTH + LEFT + 16.0);
        let _ = writeln!(svg, "<g transform=\"translate({left} {TOP})\">");
        axes(&mut svg, &panel.title);
        for ((name, points), color) in panel.curves.iter().zip(COLORS) {
            curve(&mut svg, points, color);
            let _ = name;
        }
        svg.push_str("</g>\n");
    }
    legend(&mut svg, &panels[0], height);
    svg.push_str("</svg>\n");
    svg
}

fn x(distance: f64) -> f64 {
    (distance.log10() - f64::from(X[0])) / f64::from(X[1] - X[0]) * WIDTH
}

fn y(separation: f64) -> f64 {
    let share = (separation.log10() - f64::from(Y[0])) / f64::from(Y[1] - Y[0]);
    HEIGHT * (1.0 - share.min(1.0))
}

fn axes(svg: &mut String, title: &str) {
    let _ = writeln!(
        svg,
        "<text x=\"{}\" y=\"-16\" text-anchor=\"middle\">{title}</text>",
        WIDTH / 2.0
    );
    for decade in (X[0]..=X[1]).filter(|d| d % 2 == 0) {
        let at = x(10_f64.powi(decade));
        let _ = writeln!(
            svg,
            "<path d=\"M{at:.1} 0V{HEIGHT}\" stroke=\"#e4e4e4\"/><text x=\"{at:.1}\" y=\"{}\" \
             text-anchor=\"middle\">1e{decade}</text>",
            HEIGHT + 18.0
        );
    }
    for decade in (Y[0]..=Y[1]).filter(|d| d % 2 == 0) {
        let at = y(10_f64.powi(decade));
        let _ = writeln!(
            svg,
            "<path d=\"M0 {at:.1}H{WIDTH}\" stroke=\"#e4e4e4\"/><text x=\"-6\" y=\"{:.1}\" \
             text-anchor=\"end\">1e{decade}</text>",
            at + 4.0
        );
    }
    let _ = writeln!(
        svg,
        "<rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"none\" stroke=\"#888\"/>\
         <text x=\"{}\" y=\"{}\" text-anchor=\"middle\">distance</text>\
         <text transform=\"translate(-46 {}) rotate(-90)\" text-anchor=\"middle\">\
         smallest separation / distance</text>",
        WIDTH / 2.0,
        HEIGHT + 38.0,
        HEIGHT / 2.0
    );
}

fn curve(svg: &mut String, points: &[Point], color: &str) {
    let finite = points.iter().filter(|point| point.predicted < 1e3);
    let line: Vec<String> =
        finite.map(|point| format!("{:.1} {:.1}", x(point.distance), y(point.predicted))).collect();
    if !line.is_empty() {
        let _ = writeln!(
            svg,
            "<path d=\"M{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"1.5\"/>",
            line.join("L")
        );
    }
    for point in points {
        let (x, y) = (x(point.distance), y(point.measured));
        if point.measured.is_finite() {
            let _ = writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"{color}\"/>");
        } else {
            let _ = writeln!(
                svg,
                "<path d=\"M{:.1} -4l8 8m0 -8l-8 8\" stroke=\"{color}\" stroke-width=\"1.5\"/>",
                x - 4.0
            );
        }
    }
}

fn legend(svg: &mut String, panel: &Panel, height: f64) {
    let mut at = LEFT;
    for ((name, _), color) in panel.curves.iter().zip(COLORS) {
        let _ = writeln!(
            svg,
            "<circle cx=\"{at}\" cy=\"{}\" r=\"4\" fill=\"{color}\"/><text x=\"{}\" y=\"{}\">{name}</text>",
            height - 20.0,
            at + 10.0,
            height - 16.0
        );
        at += 130.0;
    }
    let _ = writeln!(
        svg,
        "<text x=\"{at}\" y=\"{}\">lines: width of one code; dots: measured; crosses: nothing can \
         be told apart</text>",
        height - 16.0
    );
}
