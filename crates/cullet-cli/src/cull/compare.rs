//! What changed since an earlier report: `--compare`.

use std::path::Path;

use cullet_measure::{Align, Table};
use serde_json::Value;

use crate::exit::Failure;

/// The report of an earlier run.
pub fn read(path: &Path) -> Result<Value, Failure> {
    let wrong = |problem: String| Failure::input(format!("{}: {problem}", path.display()));
    let bytes = std::fs::read(path).map_err(|error| wrong(format!("cannot be read: {error}")))?;
    let value: Value = serde_json::from_slice(&bytes).map_err(|error| wrong(error.to_string()))?;
    match value["schema"].as_u64() {
        Some(super::report::SCHEMA) => Ok(value),
        Some(other) => Err(wrong(format!(
            "has schema {other}, this is {}: make it anew with this version",
            super::report::SCHEMA
        ))),
        None => Err(wrong("is no report of cullet cull --json".into())),
    }
}

/// Every figure of both reports that differs, as text.
pub fn table(new: &Value, old: &Value) -> String {
    let mut table = Table::new(&[
        ("figure", Align::Left),
        ("old", Align::Right),
        ("new", Align::Right),
        ("change", Align::Right),
    ]);
    let mut n_same = 0;
    compare("", new, old, &mut |name, new, old| match (new.as_f64(), old.as_f64()) {
        _ if new == old => n_same += 1,
        (Some(a), Some(b)) => {
            let change =
                if b == 0.0 { String::new() } else { format!("{:+.1}%", 100.0 * (a / b - 1.0)) };
            table.push([name.to_owned(), number(b), number(a), change]);
        }
        _ => table.push([name.to_owned(), short(old), short(new)]),
    });
    format!("\nchanged ({n_same} figures did not):\n{table}")
}

/// One line if the reports are of different things, so that no change says which version is better.
pub fn other_inputs(new: &Value, old: &Value) -> Option<String> {
    let (new, old) = (&new["settings"], &old["settings"]);
    let told = |key: &str| {
        let name = |value: &Value| match value {
            Value::Null => "none".to_owned(),
            Value::String(name) => format!("`{name}`"),
            other => short(other),
        };
        format!("{key} {}, was {}", name(&new[key]), name(&old[key]))
    };
    let keys = ["scene", "boxes", "camera", "clip_from_world", "path"];
    let differing: Vec<String> =
        keys.into_iter().filter(|&key| new[key] != old[key]).map(told).collect();
    let of = differing.join("; ");
    (!of.is_empty()).then(|| format!("warning: --compare with a report of something else: {of}"))
}

/// A value in a few characters: of what only one report has, how many figures that are.
fn short(value: &Value) -> String {
    const MOST: usize = 40;
    match value {
        Value::Object(_) | Value::Array(_) => format!("({} figures)", n_figures(value)),
        value => {
            let text = value.to_string();
            match text.char_indices().nth(MOST) {
                Some((end, _)) => format!("{}…", &text[..end]),
                None => text,
            }
        }
    }
}

fn n_figures(value: &Value) -> usize {
    match value {
        Value::Object(all) => all.values().map(n_figures).sum(),
        Value::Array(all) => all.iter().map(n_figures).sum(),
        _ => 1,
    }
}

fn number(value: f64) -> String {
    if value.fract() == 0.0 { format!("{value}") } else { format!("{value:.4}") }
}

/// Visits every value that is neither list nor object, by its path in both.
fn compare(name: &str, new: &Value, old: &Value, visit: &mut impl FnMut(&str, &Value, &Value)) {
    let join = |key: &str| if name.is_empty() { key.into() } else { format!("{name}.{key}") };
    match (new, old) {
        // Where from is for people; what a camera did is in the sums.
        _ if matches!(name, "cameras" | "sizes") => {}
        (Value::Object(new), Value::Object(old)) => {
            for (key, new) in new {
                compare(&join(key), new, old.get(key).unwrap_or(&Value::Null), visit);
            }
            for (key, old) in old.iter().filter(|(key, _)| !new.contains_key(*key)) {
                compare(&join(key), &Value::Null, old, visit);
            }
        }
        (Value::Array(new), Value::Array(old)) => {
            for i in 0..new.len().max(old.len()) {
                let at = |list: &'_ [Value]| list.get(i).cloned().unwrap_or(Value::Null);
                compare(&join(&i.to_string()), &at(new), &at(old), visit);
            }
        }
        (new, old) => visit(name, new, old),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn only_what_changed_is_listed() {
        let old = json!({"a": {"x": 4, "gone": 1}, "list": [1, 2], "same": "s"});
        let new = json!({"a": {"x": 5}, "list": [1, 3, 4], "same": "s"});
        let text = table(&new, &old);
        let lines: Vec<Vec<&str>> =
            text.lines().skip(3).map(|line| line.split_whitespace().collect()).collect();
        assert_eq!(
            lines,
            [
                vec!["a.x", "4", "5", "+25.0%"],
                vec!["a.gone", "1", "null"],
                vec!["list.1", "2", "3", "+50.0%"],
                vec!["list.2", "null", "4"],
            ]
        );
        assert!(text.contains("2 figures did not"), "{text}");
    }

    #[test]
    fn reports_of_different_things_are_told_apart() {
        let report = |scene: &str, path: Value| json!({"settings": {"scene": scene, "path": path, "repeat": 1}});
        let (a, b) = (report("a", Value::Null), report("b", json!("dolly:3")));
        assert_eq!(other_inputs(&a, &a), None);
        let line = other_inputs(&b, &a).unwrap();
        assert!(line.ends_with("scene `b`, was `a`; path `dolly:3`, was none"), "{line}");
    }

    #[test]
    fn lines_stay_short_whatever_a_report_lacks() {
        let level = json!({"tested": 8, "tests": {"sat": {"in": 1, "out": 7}}});
        let old = json!({"levels": [level, level], "gone": [1, 2], "name": "a".repeat(500)});
        let new = json!({"levels": [level], "name": "é".repeat(500)});
        let text = table(&new, &old);
        let lines: Vec<&str> = text.lines().skip(3).collect();
        assert_eq!(lines.len(), 3, "{text}");
        assert!(lines[0].starts_with("levels.1") && lines[0].contains("(3 figures)"), "{text}");
        assert!(lines[2].starts_with("gone") && lines[2].contains("(2 figures)"), "{text}");
        assert!(lines.iter().all(|line| line.chars().count() <= 100), "{text}");
    }
}
