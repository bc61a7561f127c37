//! The charts of the page, as scalable drawings.

use std::fmt::Write;

use super::escape;

/// Widths and heights are in the units of the drawing; the page scales it to its column.
const WIDTH: f64 = 620.0;
const ROW: f64 = 26.0;
const LABEL: f64 = 130.0;
const NUMBERS: f64 = 170.0;

/// A part of a bar.
pub struct Part {
    /// In the unit of the chart.
    pub value: f64,
    /// A CSS colour.
    pub color: &'static str,
    /// Said when pointed at.
    pub title: String,
}

/// A horizontal bar of parts side by side.
pub struct Bar {
    /// Before the bar.
    pub label: String,
    /// From left to right.
    pub parts: Vec<Part>,
    /// Behind the bar.
    pub note: String,
}

/// A line through values, one per step of x.
pub struct Series {
    /// In the key.
    pub label: String,
    /// A CSS colour.
    pub color: &'static str,
    /// NaN leaves a gap.
    pub values: Vec<f64>,
}

/// An empty drawing of that height with `body` in it.
fn drawing(height: f64, body: &str) -> String {
    format!("<svg viewBox='0 0 {WIDTH} {height}' role='img'>{body}</svg>\n")
}

/// Bars on one scale that begins at 0.
pub fn bars(bars: &[Bar]) -> String {
    let longest = bars.iter().map(sum).fold(0.0, f64::max);
    drawn(bars, |_| longest)
}

/// Bars of one length: what parts they are made of.
pub fn shares(bars: &[Bar]) -> String {
    drawn(bars, sum)
}

fn sum(bar: &Bar) -> f64 {
    bar.parts.iter().map(|part| part.value).sum()
}

/// Each bar on a scale that ends at `end`.
fn drawn(bars: &[Bar], end: impl Fn(&Bar) -> f64) -> String {
    let mut body = String::new();
    for (i, bar) in bars.iter().enumerate() {
        let y = ROW * i as f64;
        let end = end(bar);
        let scale = if end > 0.0 { (WIDTH - LABEL - NUMBERS) / end } else { 0.0 };
        let text_y = y + 17.0;
        let _ = write!(
            body,
            "<text x='{}' y='{text_y}' class='end'>{}</text>",
            LABEL - 8.0,
            escape(&bar.label)
        );
        let mut x = LABEL;
        for part in bar.parts.iter().filter(|part| part.value > 0.0) {
            // Whatever is there at all can be seen.
            let width = (part.value * scale).max(1.0);
            let _ = write!(
                body,
                "<rect x='{x:.1}' y='{}' width='{width:.1}' height='18' rx='2' fill='{}'><title>{}</title></rect>",
                y + 4.0,
                part.color,
                escape(&part.title),
            );
            x += width;
        }
        let _ = write!(
            body,
            "<text x='{:.1}' y='{text_y}' class='dim'>{}</text>",
            x + 7.0,
            escape(&bar.note)
        );
    }
    drawing(ROW * bars.len() as f64 + 4.0, &body)
}

/// Lines over a common x with names for some of its steps, y from 0 on; `unit` is written at the
/// top of the y axis.
pub fn lines(series: &[Series], names: &[(usize, String)], unit: &str) -> String {
    const HEIGHT: f64 = 230.0;
    const BOTTOM: f64 = HEIGHT - 42.0;
    const TOP: f64 = 22.0;
    const LEFT: f64 = 56.0;
    let n = series.iter().map(|line| line.values.len()).max().unwrap_or(0);
    let values = series.iter().flat_map(|line| &line.values);
    let top = nice(values.copied().filter(|value| value.is_finite()).fold(0.0, f64::max));
    let x = |i: usize| LEFT + (WIDTH - LEFT - 14.0) * (i as f64 + 0.5) / n.max(1) as f64;
    let y = |value: f64| BOTTOM - (BOTTOM - TOP) * value / top;
    let mut body = format!("<text x='{LEFT}' y='12' class='dim'>{}</text>", escape(unit));
    for i in 0..=4 {
        let value = top * f64::from(i) / 4.0;
        let at = y(value);
        let _ = write!(
            body,
            "<line class='axis' x1='{LEFT}' x2='{WIDTH}' y1='{at:.1}' y2='{at:.1}'/>\
             <text class='end dim' x='{}' y='{:.1}'>{}</text>",
            LEFT - 8.0,
            at + 4.0,
            short(value),
        );
    }
    for (i, name) in names {
        let _ = write!(
            body,
            "<text class='mid dim' x='{:.1}' y='{}'>{}</text>",
            x(*i),
            BOTTOM + 16.0,
            escape(name)
        );
    }
    let mut key_x = LEFT;
    for line in series {
        let mut path = String::new();
        let mut pen_up = true;
        for (i, value) in line.values.iter().enumerate() {
            if value.is_finite() {
                let command = if pen_up { 'M' } else { 'L' };
                let _ = write!(path, "{command}{:.1} {:.1}", x(i), y(*value));
                if n <= 48 {
                    let _ = write!(
                        body,
                        "<circle cx='{:.1}' cy='{:.1}' r='3' fill='{}'><title>{}: {}</title></circle>",
                        x(i),
                        y(*value),
                        line.color,
                        escape(&line.label),
                        short(*value)
                    );
                }
            }
            pen_up = !value.is_finite();
        }
        let _ = write!(
            body,
            "<path d='{path}' fill='none' stroke='{0}' stroke-width='2' stroke-linejoin='round'/>\
             <circle cx='{1:.1}' cy='{2}' r='4' fill='{0}'/><text x='{3:.1}' y='{4}'>{5}</text>",
            line.color,
            key_x + 4.0,
            HEIGHT - 8.0,
            key_x + 13.0,
            HEIGHT - 4.0,
            escape(&line.label),
        );
        key_x += 34.0 + 6.6 * line.label.chars().count() as f64;
    }
    drawing(HEIGHT, &body)
}

/// The least of 1, 2, 2.5 and 5 times a power of ten that reaches `value`; 1 for 0.
fn nice(value: f64) -> f64 {
    if !(value > 0.0 && value.is_finite()) {
        return 1.0;
    }
    let power = 10f64.powf(value.log10().floor());
    let steps = [1.0, 2.0, 2.5, 5.0, 10.0].map(|step| step * power);
    steps.into_iter().find(|step| *step >= value).unwrap_or(10.0 * power)
}

/// A number in a few digits.
pub fn short(value: f64) -> String {
    let size = value.abs();
    match value {
        _ if !value.is_finite() => "–".into(),
        _ if size >= 1e12 => format!("{value:.0e}"),
        _ if size >= 1e9 => format!("{:.1} G", value / 1e9),
        _ if size >= 1e6 => format!("{:.1} M", value / 1e6),
        _ if size >= 1e4 => format!("{:.1} k", value / 1e3),
        _ if value.fract() == 0.0 => format!("{value}"),
        _ if size >= 100.0 => format!("{value:.0}"),
        _ if size >= 1.0 => format!("{value:.1}"),
        _ if size >= 0.1 => format!("{value:.2}"),
        _ if size >= 0.01 => format!("{value:.3}"),
        _ if size >= 0.0001 => format!("{value:.4}"),
        _ => format!("{value:.2e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_end_on_round_numbers() {
        for (value, expected) in [(0.0, 1.0), (0.7, 1.0), (1.01, 2.0), (23.0, 25.0), (26.0, 50.0)] {
            assert_eq!(nice(value), expected);
        }
    }

    #[test]
    fn numbers_stay_short() {
        let shown = [0.0, 12.0, 0.25, 3.26, 123.4, 12_345.0, 2.5e6, f64::NAN].map(short);
        assert_eq!(shown, ["0", "12", "0.25", "3.3", "123", "12.3 k", "2.5 M", "–"]);
    }

    #[test]
    fn drawings_hold_no_foreign_markup_and_no_nan() {
        let part = |value| Part { value, color: "red", title: "<b>".into() };
        let drawn = bars(&[Bar { label: "<a>".into(), parts: vec![part(0.0)], note: "&".into() }]);
        assert!(drawn.contains("&lt;a&gt;") && drawn.contains("&amp;"));
        let series = Series { label: "l".into(), color: "red", values: vec![1.0, f64::NAN, 2.0] };
        let drawn = lines(&[series], &[], "u") + &lines(&[], &[], "") + &bars(&[]);
        assert!(!drawn.contains("NaN") && !drawn.contains("inf"), "{drawn}");
    }
}
