//! What the command prints: the fronts, what stands behind them, and the verdicts.

use std::fmt::Write;

use super::Report;
use super::table;

/// Everything for standard output.
pub fn all(report: &Report<'_>) -> String {
    let mut text = table::fronts(report.rows);
    text += "\n";
    for scene in report.scenes {
        let measured = &scene.measured;
        let (rounds, how) = (measured.n_rounds, &measured.reference.how);
        let _ = writeln!(text, "{}: {rounds} rounds; {how}", scene.name);
    }
    if report.rows.iter().any(|row| row.plain_code) {
        text += "Not among the fronts, as their times are those of plain code: texture nearest, \
                 subpixel-bits but 8, depth-format but f32\n";
    }
    text += "\n";
    for finding in &report.findings.expectations {
        let _ = writeln!(text, "{:<11}  {}", finding.kind.name(), finding.text);
    }
    text
}
