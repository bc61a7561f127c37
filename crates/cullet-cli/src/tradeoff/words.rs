//! Numbers as people read them.

/// Least and most.
pub struct Range {
    least: f64,
    most: f64,
}

impl Range {
    /// Over all `values`; `None` without any.
    pub fn of(values: impl Iterator<Item = f64>) -> Option<Range> {
        values.fold(None, |range, value| {
            let Range { least, most } = range.unwrap_or(Range { least: value, most: value });
            Some(Range { least: least.min(value), most: most.max(value) })
        })
    }

    /// `0.1 to 0.2`, or one number where they print alike.
    pub fn words(&self) -> String {
        let (least, most) = (short(self.least), short(self.most));
        if least == most { least } else { format!("{least} to {most}") }
    }

    /// The same with two places behind the point, and `times`.
    pub fn times(&self) -> String {
        let (least, most) = (format!("{:.2}", self.least), format!("{:.2}", self.most));
        if least == most { format!("{least} times") } else { format!("{least} to {most} times") }
    }
}

/// Three digits.
pub fn short(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let digits = 2 - value.abs().log10().floor() as i32;
    if (-3..=6).contains(&digits) {
        let text = format!("{value:.*}", digits.max(0) as usize);
        if !text.contains('.') {
            return text;
        }
        return text.trim_end_matches('0').trim_end_matches('.').to_owned();
    }
    let text = format!("{value:.2e}");
    let Some((digits, exponent)) = text.split_once('e') else { return text };
    format!("{}e{exponent}", digits.trim_end_matches('0').trim_end_matches('.'))
}

/// The values that differ, in the order they come in.
pub fn distinct<T: PartialEq>(values: impl Iterator<Item = T>) -> Vec<T> {
    let mut distinct = Vec::new();
    for value in values {
        if !distinct.contains(&value) {
            distinct.push(value);
        }
    }
    distinct
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        for (value, text) in [
            (0.0, "0"),
            (0.012345, "0.0123"),
            (1.0, "1"),
            (250_000.0, "250000"),
            (3.2e-9, "3.2e-9"),
            (12.34, "12.3"),
        ] {
            assert_eq!(short(value), text);
        }
    }
}
