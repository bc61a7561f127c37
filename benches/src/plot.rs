//! Lines on two logarithmic axes, as one self-contained SVG file.

use std::fmt::Write;

/// A line through points, both coordinates above 0.
pub struct Line {
    /// In the key.
    pub label: String,
    /// Of any colour that SVG knows.
    pub color: &'static str,
    /// In order of x.
    pub points: Vec<[f64; 2]>,
}

const WIDTH: f64 = 720.0;
const HEIGHT: f64 = 440.0;
const LEFT: f64 = 64.0;
const RIGHT: f64 = 20.0;
const TOP: f64 = 48.0;
const BOTTOM: f64 = 52.0;

/// The drawing. A dotted line of slope 1 through the first point of the first line shows what
/// proportional growth would be.
pub fn log_log(title: &str, x_label: &str, y_label: &str, lines: &[Line]) -> String {
    let range = |axis: usize| {
        let values = lines.iter().flat_map(|line| &line.points).map(|point| point[axis].log10());
        let (low, high) = values
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        // At least a decade, with some air.
        let middle = 0.5 * (low + high);
        let half = (0.5 * (high - low)).max(0.5) + 0.1;
        [middle - half, middle + half]
    };
    let (xs, ys) = (range(0), range(1));
    let x = |value: f64| LEFT + (WIDTH - LEFT - RIGHT) * (value.log10() - xs[0]) / (xs[1] - xs[0]);
    let y = |value: f64| {
        HEIGHT - BOTTOM - (HEIGHT - BOTTOM - TOP) * (value.log10() - ys[0]) / (ys[1] - ys[0])
    };
    let middle = 0.5 * (TOP + HEIGHT - BOTTOM);
    let mut svg = format!(
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {WIDTH} {HEIGHT}' font-family='sans-serif' font-size='13'>\n\
         <rect width='{WIDTH}' height='{HEIGHT}' fill='#fff'/>\n\
         <text x='{LEFT}' y='20' font-size='15'>{title}</text>\n\
         <text x='{}' y='{}' text-anchor='middle'>{x_label}</text>\n\
         <text x='16' y='{middle}' text-anchor='middle' transform='rotate(-90 16 {middle})'>{y_label}</text>\n",
        0.5 * (LEFT + WIDTH - RIGHT),
        HEIGHT - 12.0,
    );
    for value in ticks(xs) {
        let at = x(value);
        let _ = writeln!(
            svg,
            "<line x1='{at:.1}' x2='{at:.1}' y1='{TOP}' y2='{:.1}' stroke='#ddd'/>\
             <text x='{at:.1}' y='{:.1}' text-anchor='middle' fill='#555'>{}</text>",
            HEIGHT - BOTTOM,
            HEIGHT - BOTTOM + 17.0,
            short(value),
        );
    }
    for value in ticks(ys) {
        let at = y(value);
        let _ = writeln!(
            svg,
            "<line x1='{LEFT}' x2='{:.1}' y1='{at:.1}' y2='{at:.1}' stroke='#ddd'/>\
             <text x='{:.1}' y='{:.1}' text-anchor='end' fill='#555'>{}</text>",
            WIDTH - RIGHT,
            LEFT - 7.0,
            at + 4.5,
            short(value),
        );
    }
    if let Some([x0, y0]) = lines.first().and_then(|line| line.points.first()) {
        // As far as both axes reach.
        let grow = 10f64.powf((xs[1] - x0.log10()).min(ys[1] - y0.log10()).max(0.0));
        let _ = writeln!(
            svg,
            "<line x1='{:.1}' y1='{:.1}' x2='{:.1}' y2='{:.1}' stroke='#999' stroke-dasharray='2 4'/>",
            x(*x0),
            y(*y0),
            x(x0 * grow),
            y(y0 * grow)
        );
    }
    let mut key = LEFT;
    for line in lines {
        let color = line.color;
        let path: Vec<_> =
            line.points.iter().map(|p| format!("{:.1},{:.1}", x(p[0]), y(p[1]))).collect();
        let _ = writeln!(
            svg,
            "<polyline points='{}' fill='none' stroke='{color}' stroke-width='2'/>",
            path.join(" ")
        );
        for point in &line.points {
            let _ = writeln!(
                svg,
                "<circle cx='{:.1}' cy='{:.1}' r='3.5' fill='{color}'><title>{}: {}, {}</title></circle>",
                x(point[0]),
                y(point[1]),
                line.label,
                short(point[0]),
                short(point[1])
            );
        }
        let _ = writeln!(
            svg,
            "<rect x='{key}' y='31' width='11' height='11' fill='{color}'/><text x='{:.1}' y='41'>{}</text>",
            key + 16.0,
            line.label
        );
        key += 40.0 + 7.5 * line.label.len() as f64;
    }
    svg.push_str("</svg>\n");
    svg
}

/// 1, 2 and 5 of every decade within the range of logarithms; of a long range, 1 alone.
fn ticks(range: [f64; 2]) -> Vec<f64> {
    let steps: &[f64] = if range[1] - range[0] > 2.5 { &[1.0] } else { &[1.0, 2.0, 5.0] };
    let decades = range[0].floor() as i32..=range[1].ceil() as i32;
    let values = decades.flat_map(|d| steps.iter().map(move |step| step * 10f64.powi(d)));
    values.filter(|v| (range[0]..=range[1]).contains(&v.log10())).collect()
}

/// 3.2 M, 500 k, 12, 0.25.
pub fn short(value: f64) -> String {
    let (value, unit) = match value {
        v if v >= 1e6 => (v / 1e6, " M"),
        v if v >= 1e4 => (v / 1e3, " k"),
        v => (v, ""),
    };
    let digits = (2 - value.abs().log10().floor() as i32).clamp(0, 4) as usize;
    let text = format!("{value:.digits$}");
    let text =
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    format!("{text}{unit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (3_200_000.0, "3.2 M"),
            (1e8, "100 M"),
            (500_000.0, "500 k"),
            (1234.0, "1234"),
            (12.0, "12"),
            (0.25, "0.25"),
            (0.02, "0.02"),
        ] {
            assert_eq!(short(value), text);
        }
    }

    #[test]
    fn equal_steps_of_a_factor_are_equally_far_apart() {
        let points = vec![[1e3, 1.0], [1e4, 10.0], [1e5, 100.0]];
        let svg = log_log("t", "x", "y", &[Line { label: "l".into(), color: "#000", points }]);
        let start = svg.find("<polyline points='").unwrap() + 18;
        let end = start + svg[start..].find('\'').unwrap();
        let at: Vec<Vec<f64>> = svg[start..end]
            .split(' ')
            .map(|p| p.split(',').map(|v| v.parse().unwrap()).collect())
            .collect();
        for axis in 0..2 {
            let steps = [at[1][axis] - at[0][axis], at[2][axis] - at[1][axis]];
            assert!((steps[0] - steps[1]).abs() < 0.2 && steps[0].abs() > 50.0, "{at:?}");
        }
        assert!(svg.ends_with("</svg>\n"));
    }
}
