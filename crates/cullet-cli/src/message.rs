//! Words for people: everything on standard error goes through here.
//!
//! One line per message, whatever names from foreign files hold, and no complaint when
//! nobody listens any more.

use std::fmt::Display;
use std::io::{IsTerminal, Write, stderr};

/// Lines of one kind that are shown before the rest is only counted.
const SHOWN: usize = 20;

/// Writes one line.
pub fn note(message: impl Display) {
    let _ = writeln!(stderr(), "cullet: {}", one_line(&message.to_string()));
}

/// Writes one line per warning, the first few of them.
pub fn warn(warnings: &[String]) {
    for warning in warnings.iter().take(SHOWN) {
        note(format_args!("warning: {warning}"));
    }
    if warnings.len() > SHOWN {
        note(format_args!("… and {} more", warnings.len() - SHOWN));
    }
}

/// On a terminal, says what takes so long; the line goes away with the value.
pub struct Progress(());

impl Progress {
    /// Shows `what`.
    pub fn show(what: &str) -> Option<Progress> {
        stderr().is_terminal().then(|| {
            let _ = write!(stderr(), "\r\x1b[K{what}…");
            Progress(())
        })
    }

    /// Shows `what` instead.
    pub fn update(&self, what: &str) {
        let _ = write!(stderr(), "\r\x1b[K{}…", one_line(what));
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        let _ = write!(stderr(), "\r\x1b[K");
    }
}

/// The text without control characters, which could forge lines or steer a terminal.
pub fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn foreign_names_stay_on_their_line() {
        assert_eq!(one_line("node `a\n\x1b[2Jb`: é"), "node `a  [2Jb`: é");
    }
}
