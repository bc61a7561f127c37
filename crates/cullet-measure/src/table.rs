//! Aligned plain text for terminals, and CSV for everything else, from the same rows.

use std::borrow::Cow;
use std::fmt;

/// On which side of its column a cell stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    /// Names and words.
    Left,
    /// Numbers, so that their last digits line up.
    Right,
}

/// A heading and rows of cells; `{}` writes aligned text, one line per row, each ended by
/// a newline, no blanks at line ends.
///
/// ```
/// use cullet_measure::{Align, Table};
/// let mut table = Table::new(&[("test", Align::Left), ("ns", Align::Right)]);
/// table.push(["p-vertex", "3.1"]);
/// table.push(["sat", "12.4"]);
/// assert_eq!(table.to_string(), "test        ns\np-vertex   3.1\nsat       12.4\n");
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    aligns: Vec<Align>,
    /// The heading first.
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table with these headings and no rows yet.
    pub fn new(columns: &[(&str, Align)]) -> Table {
        Table {
            aligns: columns.iter().map(|(_, align)| *align).collect(),
            rows: vec![columns.iter().map(|(name, _)| (*name).to_string()).collect()],
        }
    }

    /// Adds a row. Missing cells stay blank, surplus ones are dropped.
    pub fn push<S: Into<String>>(&mut self, cells: impl IntoIterator<Item = S>) {
        let cells = cells.into_iter().map(S::into).chain(std::iter::repeat_with(String::new));
        self.rows.push(cells.take(self.aligns.len()).collect());
    }

    /// The same table as CSV, heading first, lines ended by `\n` alone.
    pub fn to_csv(&self) -> String {
        let line = |row: &Vec<String>| {
            row.iter().map(|cell| csv_field(cell)).collect::<Vec<_>>().join(",") + "\n"
        };
        self.rows.iter().map(line).collect()
    }

    /// Characters in the widest cell of a column; every character counts as one wide.
    fn width(&self, column: usize) -> usize {
        self.rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0)
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let widths: Vec<usize> = (0..self.aligns.len()).map(|column| self.width(column)).collect();
        for row in &self.rows {
            let cells =
                row.iter().zip(&self.aligns).zip(&widths).map(
                    |((cell, align), &width)| match align {
                        Align::Left => format!("{cell:<width$}"),
                        Align::Right => format!("{cell:>width$}"),
                    },
                );
            writeln!(f, "{}", cells.collect::<Vec<_>>().join("  ").trim_end())?;
        }
        Ok(())
    }
}

/// A cell as RFC 4180 wants it: quoted when it holds a comma, a quote or a line break,
/// quotes doubled.
pub fn csv_field(cell: &str) -> Cow<'_, str> {
    if cell.contains([',', '"', '\n', '\r']) {
        Cow::Owned(format!("\"{}\"", cell.replace('"', "\"\"")))
    } else {
        Cow::Borrowed(cell)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_left_numbers_right_and_no_trailing_blanks() {
        let mut table =
            Table::new(&[("scene", Align::Left), ("ms", Align::Right), ("note", Align::Left)]);
        table.push(["café", "9.5", ""]);
        table.push(["forest", "120.0", "slow"]);
        table.push(["x"]);
        let expected = "scene      ms  note\n\
                        café      9.5\n\
                        forest  120.0  slow\n\
                        x\n";
        assert_eq!(table.to_string(), expected);
    }

    #[test]
    fn csv_quotes_only_what_needs_it() {
        for (cell, expected) in [
            ("", ""),
            ("plain text", "plain text"),
            ("a,b", "\"a,b\""),
            ("5\" tape", "\"5\"\" tape\""),
            ("two\nlines", "\"two\nlines\""),
        ] {
            assert_eq!(csv_field(cell), expected);
        }
        let mut table = Table::new(&[("a", Align::Left), ("b", Align::Right)]);
        table.push(["x,y", "1"]);
        table.push(["z", "2"].map(String::from));
        assert_eq!(table.to_csv(), "a,b\n\"x,y\",1\nz,2\n");
    }
}
