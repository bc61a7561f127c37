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
        _ => table.push([name.to_owned(), old.to_string(), new.to_string()]),
    });
    format!("\nchanged ({n_same} figures did not):\n{table}")
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
}
