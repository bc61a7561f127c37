//! Conditions over the figures of a report: `--fail-if`.
//!
//! ```text
//! any     = all  { "||" all }
//! all     = test { "&&" test }
//! test    = sum [ ("<" | "<=" | ">" | ">=" | "==" | "!=") sum ]
//! sum     = product { ("+" | "-") product }
//! product = value { ("*" | "/") value }
//! value   = number [ "%" ] | path | "(" any ")" | "-" value
//! ```
//!
//! A path names a figure as the JSON has it, keys joined by dots, places in lists by number;
//! `old.` before it asks the report of `--compare`. A condition holds where it is not 0. What is
//! divided by 0 is no number, nor is any condition that it is part of.

use serde_json::Value;

/// What a condition may ask.
#[derive(Clone, Copy, Debug)]
pub struct Reports<'a> {
    /// The report of this run.
    pub new: &'a Value,
    /// That of `--compare`.
    pub old: Option<&'a Value>,
}

/// What became of a condition.
#[derive(Clone, Debug, PartialEq)]
pub struct Asked {
    /// It is not 0.
    pub holds: bool,
    /// The figures it asked for, as `name = value`.
    pub figures: Vec<String>,
}

/// Whether the condition `text` holds. A value that is no number (1 / 0) decides nothing, and is a
/// fault.
pub fn holds(text: &str, reports: Reports<'_>) -> Result<Asked, String> {
    let mut parser =
        Parser { rest: text.trim_start(), reports: Some(reports), depth: 0, figures: Vec::new() };
    let value = parser.whole()?;
    if value.is_nan() {
        return Err("its value is not a number: something is divided by 0".into());
    }
    Ok(Asked { holds: value != 0.0, figures: parser.figures })
}

/// Finds faults of the spelling, before there is any report; `comparing` when there will be an old
/// one.
pub fn check(text: &str, comparing: bool) -> Result<(), String> {
    let mut parser =
        Parser { rest: text.trim_start(), reports: None, depth: 0, figures: Vec::new() };
    parser.whole()?;
    let old = parser.figures.iter().find(|name| name.starts_with("old."));
    match old {
        Some(name) if !comparing => Err(format!("`{name}` needs --compare OLD.json")),
        _ => Ok(()),
    }
}

struct Parser<'a> {
    rest: &'a str,
    /// `None` where only the spelling is looked at: then all figures are 1.
    reports: Option<Reports<'a>>,
    depth: u32,
    figures: Vec<String>,
}

/// Parentheses and signs within each other.
const DEEPEST: u32 = 100;

impl<'a> Parser<'a> {
    /// Goes on behind `token`, if it comes next.
    fn take(&mut self, token: &str) -> bool {
        let rest = self.rest.strip_prefix(token);
        self.rest = rest.map_or(self.rest, str::trim_start);
        rest.is_some()
    }

    /// Goes on behind all characters that `belongs` holds for.
    fn take_while(&mut self, belongs: impl Fn(char) -> bool) -> &'a str {
        let end = self.rest.find(|c| !belongs(c)).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest.trim_start();
        word
    }

    fn whole(&mut self) -> Result<f64, String> {
        let value = self.any()?;
        match self.rest {
            "" => Ok(value),
            rest => Err(format!("did not expect `{rest}`")),
        }
    }

    fn any(&mut self) -> Result<f64, String> {
        let mut value = self.all()?;
        while self.take("||") {
            value = either(value, self.all()?, |a, b| a || b);
        }
        Ok(value)
    }

    fn all(&mut self) -> Result<f64, String> {
        let mut value = self.test()?;
        while self.take("&&") {
            value = either(value, self.test()?, |a, b| a && b);
        }
        Ok(value)
    }

    fn test(&mut self) -> Result<f64, String> {
        type Relation = fn(&f64, &f64) -> bool;
        let relations: [(&str, Relation); 6] = [
            ("<=", f64::le),
            (">=", f64::ge),
            ("==", f64::eq),
            ("!=", f64::ne),
            ("<", f64::lt),
            (">", f64::gt),
        ];
        let left = self.sum()?;
        match relations.into_iter().find(|(token, _)| self.take(token)) {
            Some((_, relation)) => {
                let right = self.sum()?;
                let known = !left.is_nan() && !right.is_nan();
                Ok(if known { truth(relation(&left, &right)) } else { f64::NAN })
            }
            None => Ok(left),
        }
    }

    fn sum(&mut self) -> Result<f64, String> {
        let mut value = self.product()?;
        loop {
            if self.take("+") {
                value += self.product()?;
            } else if self.take("-") {
                value -= self.product()?;
            } else {
                return Ok(value);
            }
        }
    }

    fn product(&mut self) -> Result<f64, String> {
        let mut value = self.value()?;
        loop {
            if self.take("*") {
                value *= self.value()?;
            } else if self.take("/") {
                // Above every number it would let a gate fail, or pass, that has nothing to compare.
                let divisor = self.value()?;
                value = if divisor == 0.0 { f64::NAN } else { value / divisor };
            } else {
                return Ok(value);
            }
        }
    }

    fn value(&mut self) -> Result<f64, String> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err("too many parentheses".into());
        }
        let value = match self.rest.chars().next() {
            Some('(') => {
                self.take("(");
                let value = self.any()?;
                if !self.take(")") {
                    return Err("a `)` is missing".into());
                }
                value
            }
            Some('-') => {
                self.take("-");
                -self.value()?
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number()?,
            Some(c) if c.is_ascii_alphabetic() => {
                let belongs = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '.';
                let path = self.take_while(belongs);
                self.figure(path)?
            }
            _ => return Err(format!("expected a number or a figure at `{}`", self.rest)),
        };
        self.depth -= 1;
        Ok(value)
    }

    fn number(&mut self) -> Result<f64, String> {
        let mut previous = ' ';
        let ends = |c: char| {
            // The sign of an exponent belongs to the number.
            let sign = matches!(c, '-' | '+') && matches!(previous, 'e' | 'E');
            previous = c;
            !(sign || c.is_ascii_digit() || matches!(c, '.' | 'e' | 'E'))
        };
        let end = self.rest.find(ends).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest.trim_start();
        let number: f64 = word.parse().map_err(|_| format!("`{word}` is no number"))?;
        if number.is_infinite() {
            return Err(format!("`{word}` is too large a number"));
        }
        Ok(if self.take("%") { number / 100.0 } else { number })
    }

    fn figure(&mut self, path: &str) -> Result<f64, String> {
        let Some(reports) = self.reports else {
            self.figures.push(path.to_owned());
            return Ok(1.0);
        };
        let (report, keys) = match path.strip_prefix("old.") {
            Some(keys) => (reports.old.ok_or(format!("`{path}` needs --compare OLD.json"))?, keys),
            None => (reports.new, path.strip_prefix("new.").unwrap_or(path)),
        };
        let mut value = report;
        for key in keys.split('.') {
            let next = match value {
                Value::Object(keys) => keys.get(key),
                Value::Array(list) => key.parse::<usize>().ok().and_then(|i| list.get(i)),
                _ => None,
            };
            value = next.ok_or_else(|| missing(path, key, value))?;
        }
        let value = match value {
            Value::Bool(value) => truth(*value),
            value => value.as_f64().ok_or_else(|| missing(path, "", value))?,
        };
        self.figures.push(format!("{path} = {value}"));
        Ok(value)
    }
}

/// Why a path leads to no number, and where it could have gone.
fn missing(path: &str, key: &str, at: &Value) -> String {
    match at {
        Value::Object(keys) => {
            let keys: Vec<&str> = keys.keys().map(String::as_str).collect();
            format!(
                "there is no figure `{path}`: instead of `{key}` give one of {}",
                keys.join(", ")
            )
        }
        Value::Array(list) => {
            format!("there is no figure `{path}`: the list has {}, counted from 0", list.len())
        }
        _ => format!("`{path}` is no number"),
    }
}

/// Both as truths, put together; NaN if either is.
fn either(a: f64, b: f64, join: impl Fn(bool, bool) -> bool) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { truth(join(a != 0.0, b != 0.0)) }
}

fn truth(holds: bool) -> f64 {
    f64::from(u8::from(holds))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn ask(text: &str) -> Result<bool, String> {
        let new =
            json!({"tests": {"sat": {"in": 6, "ns": 2.5}}, "levels": [{"in": 1}], "on": true});
        let old = json!({"tests": {"sat": {"in": 4}}});
        holds(text, Reports { new: &new, old: Some(&old) }).map(|asked| asked.holds)
    }

    #[test]
    fn conditions() {
        for (text, expected) in [
            ("tests.sat.in > 5", true),
            ("tests.sat.in>1.5*old.tests.sat.in", false),
            ("new.tests.sat.in >= 1.5 * old.tests.sat.in", true),
            ("levels.0.in == 1 && tests.sat.ns < 2", false),
            ("levels.0.in != 1 || tests.sat.ns <= 2.5", true),
            ("1 + 2 * 3 == 7", true),
            ("(1 + 2) * 3 == 9 && 8 / 2 / 2 == 2 && 5 - 2 - 1 == 2", true),
            ("-1 < 1e-3 && 1E+2 == 100 && - -1 == 1", true),
            ("tests.sat.in / 100 > 5%", true),
            ("0", false),
            ("on", true),
        ] {
            assert_eq!(ask(text), Ok(expected), "{text}");
        }
    }

    #[test]
    fn faults_are_named() {
        for (text, words) in [
            ("", "expected a number"),
            ("1 <", "expected a number"),
            ("(1", ")"),
            ("1 2", "`2`"),
            ("1.2.3", "1.2.3"),
            ("tests.set.in > 0", "one of sat"),
            ("levels.7.in > 0", "list has 1"),
            ("tests > 0", "no figure"),
            ("0 / 0 < 1", "not a number"),
            ("0 / 0 || 1", "not a number"),
            ("1 / 0 > 1", "divided by 0"),
            ("1 / (tests.sat.in - 6) > 1 && 0", "divided by 0"),
            ("-1 / 0", "divided by 0"),
            ("1e999 > 1", "too large"),
            ("tests.sat.in.x > 0", "is no number"),
        ] {
            let fault = ask(text).unwrap_err();
            assert!(fault.contains(words), "{text}: {fault}");
        }
        let deep = "(".repeat(100_000);
        assert!(ask(&deep).is_err());
        let new = json!({"a": 1});
        let fault = holds("old.a > 0", Reports { new: &new, old: None }).unwrap_err();
        assert!(fault.contains("--compare"));
        let asked = holds("a + 1 > 0", Reports { new: &new, old: None }).unwrap();
        assert_eq!(asked.figures, ["a = 1"]);
    }

    #[test]
    fn spelling_is_checked_without_a_report() {
        assert_eq!(check("whatever.there.is > 0 && old.x", true), Ok(()));
        assert!(check("old.x", false).unwrap_err().contains("--compare"));
        assert!(check("1 +", true).is_err());
    }
}
