//! What the command prints: the fronts, what stands behind them, and the verdicts.

use std::fmt::Write;

use super::Report;
use super::table::{self, Row};
use super::words::distinct;

/// Everything for standard output.
pub fn all(report: &Report<'_>) -> String {
    let mut text = table::fronts(report.rows);
    text += "\n";
    for scene in report.scenes {
        let measured = &scene.measured;
        let (rounds, how) = (measured.n_rounds, &measured.reference.how);
        let _ = writeln!(text, "{}: {rounds} rounds; {how}", scene.name);
    }
    let plain = distinct(report.rows.iter().filter(|row| row.plain_code).map(Row::name));
    if !plain.is_empty() {
        let names = plain.join(", ");
        let _ =
            writeln!(text, "Not among the fronts, as their times are those of plain code: {names}");
    }
    text += "\n";
    for finding in &report.findings.expectations {
        let _ = writeln!(text, "{:<11}  {}", finding.kind.name(), finding.text);
    }
    text
}
