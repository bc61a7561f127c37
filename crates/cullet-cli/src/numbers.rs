//! Numbers as JSON holds them here: plain, or as strings where JSON cannot say them.
//!
//! Strings may be decimal, C hexadecimal floats (`"0x1.8p+1"`, which name every f64
//! exactly), `"inf"`, `"-inf"` or `"nan"`. What is written uses strings for the last
//! three only.

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

/// An f64 in a JSON file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Number(pub f64);

impl<'de> Deserialize<'de> for Number {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(
            untagged,
            expecting = "expected a number, or a string that holds one, such as \"inf\""
        )]
        enum Spelling {
            Plain(f64),
            Quoted(String),
        }
        match Spelling::deserialize(deserializer)? {
            Spelling::Plain(value) => Ok(Number(value)),
            Spelling::Quoted(text) => parse(&text)
                .map(Number)
                .ok_or_else(|| de::Error::custom(format!("`{text}` is not a number"))),
        }
    }
}

impl Serialize for Number {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.0.is_finite() {
            serializer.serialize_f64(self.0)
        } else if self.0.is_nan() {
            serializer.serialize_str("nan")
        } else {
            serializer.serialize_str(if self.0 > 0.0 { "inf" } else { "-inf" })
        }
    }
}

/// The f64 that is written with the few digits that name `value` among f32s: 0.02, where the
/// exact one would be 0.019999999552965164.
pub fn from_f32(value: f32) -> f64 {
    value.to_string().parse().unwrap_or_else(|_| f64::from(value))
}

/// The f64 nearest to what `text` says, ties to even; `None` when it is not a number.
pub fn parse(text: &str) -> Option<f64> {
    let text = text.trim();
    let (negative, magnitude) = match text.as_bytes().first()? {
        b'-' => (true, &text[1..]),
        b'+' => (false, &text[1..]),
        _ => (false, text),
    };
    let hex = magnitude.strip_prefix("0x").or_else(|| magnitude.strip_prefix("0X"));
    match hex {
        Some(digits) => parse_hex(digits).map(|value| if negative { -value } else { value }),
        None => text.parse().ok(),
    }
}

/// The part of a hex float after `0x`: `h.hhhp±d`, point and exponent optional.
fn parse_hex(text: &str) -> Option<f64> {
    let (digits, exponent) = match text.split_once(['p', 'P']) {
        Some((digits, exponent)) => (digits, exponent.parse::<i32>().ok()?),
        None => (text, 0),
    };
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
    if whole.is_empty() && fraction.is_empty() {
        return None;
    }
    // The value so far is `mantissa * 2^scale`, plus something less than one unit of the
    // mantissa when `sticky`.
    let (mut mantissa, mut sticky, mut scale) = (0u64, false, 0i64);
    for (digits, in_fraction) in [(whole, false), (fraction, true)] {
        for digit in digits.chars() {
            let digit = u64::from(digit.to_digit(16)?);
            let full = mantissa >> 59 != 0;
            if full {
                sticky |= digit != 0;
            } else {
                mantissa = mantissa << 4 | digit;
            }
            scale += match (full, in_fraction) {
                (false, true) => -4,
                (true, false) => 4,
                _ => 0,
            };
        }
    }
    Some(rounded(mantissa, sticky, scale + i64::from(exponent)))
}

/// `mantissa * 2^scale`, plus a little when `sticky`, rounded once to the nearest f64.
fn rounded(mantissa: u64, sticky: bool, scale: i64) -> f64 {
    if mantissa == 0 {
        return 0.0;
    }
    let n_bits = i64::from(u64::BITS - mantissa.leading_zeros());
    let top = scale + n_bits - 1;
    if top > 1023 {
        return f64::INFINITY;
    }
    // Bits that f64 keeps: 53, fewer below the smallest normal number.
    let kept = 53 - (-1022 - top).clamp(0, 54);
    let dropped = n_bits - kept;
    if dropped <= 0 {
        return libm::scalbn(mantissa as f64, scale as i32);
    }
    let (quotient, remainder) = match u32::try_from(dropped) {
        Ok(shift) if shift < u64::BITS => (mantissa >> shift, mantissa & ((1 << shift) - 1)),
        _ => (0, mantissa),
    };
    let half = 1u128 << (dropped - 1);
    let up = match u128::from(remainder).cmp(&half) {
        std::cmp::Ordering::Greater => true,
        std::cmp::Ordering::Equal => sticky || quotient % 2 == 1,
        std::cmp::Ordering::Less => false,
    };
    libm::scalbn((quotient + u64::from(up)) as f64, (scale + dropped) as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(text: &str, expected: f64) {
        let value = parse(text).unwrap();
        assert_eq!(value.to_bits(), expected.to_bits(), "{text}: {value:e}");
    }

    #[test]
    fn decimals_and_words() {
        check("1.5", 1.5);
        check("-1e-3", -1e-3);
        check("+7", 7.0);
        check("inf", f64::INFINITY);
        check("-inf", f64::NEG_INFINITY);
        assert!(parse("nan").unwrap().is_nan());
        for text in ["", " ", "x", "1,5", "1e", "0x", "0x.", "0xg", "0x1p", "0x1p1.5", "--1", "1 2"]
        {
            assert_eq!(parse(text), None, "{text}");
        }
    }

    #[test]
    fn hex_floats_name_every_bit() {
        check("0x1.8p+1", 3.0);
        check("-0x1p-1", -0.5);
        check("0X.8P1", 1.0);
        check("0x10", 16.0);
        check("0x0p0", 0.0);
        check("-0x0p0", -0.0);
        check("0x1.999999999999ap-4", 0.1);
        check("0x1.fffffffffffffp+1023", f64::MAX);
        check("0x1p-1022", f64::MIN_POSITIVE);
        check("0x1p-1074", 5e-324);
        check("0x0.0000000000001p-1022", 5e-324);
    }

    #[test]
    fn hex_floats_round_once_and_to_even() {
        check("0x1.00000000000008p0", 1.0); // a tie, down
        check("0x1.00000000000018p0", 1.0 + 2.0 * f64::EPSILON); // a tie, up
        check("0x1.000000000000080000000000000001p0", 1.0 + f64::EPSILON);
        check("0x1p-1075", 0.0); // a tie between 0 and the least number
        check("0x1.8p-1075", 5e-324);
        check("0x1p-5000", 0.0);
        check("0x1.fffffffffffff8p1023", f64::INFINITY);
        check("0x1p5000", f64::INFINITY);
    }

    #[test]
    fn what_is_written_can_be_read() {
        for value in [0.1, f64::INFINITY, f64::NEG_INFINITY, -0.0, 1e300] {
            let text = serde_json::to_string(&Number(value)).unwrap();
            assert_eq!(serde_json::from_str::<Number>(&text).unwrap().0, value);
        }
        assert_eq!(serde_json::to_string(&Number(f64::NAN)).unwrap(), "\"nan\"");
        assert!(serde_json::from_str::<Number>("[1]").is_err());
    }

    #[test]
    fn f32s_keep_their_short_names() {
        for (value, text) in [(0.02f32, "0.02"), (1.0, "1.0"), (1e-30, "1e-30"), (0.1, "0.1")] {
            assert_eq!(serde_json::to_string(&from_f32(value)).unwrap(), text);
            assert_eq!(from_f32(value) as f32, value);
        }
    }
}
