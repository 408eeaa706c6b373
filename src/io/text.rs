//! Numbers and fields in text formats: read strictly, written as the shortest text that reads back the same.

use std::borrow::Cow;
use std::fmt;

/// Fields separated by spaces or tabs.
pub(crate) fn fields(line: &[u8]) -> impl Iterator<Item = &[u8]> + Clone {
    line.split(|b| b.is_ascii_whitespace()).filter(|f| !f.is_empty())
}

/// A finite number, correctly rounded. The message says what was found instead, without a place.
pub(crate) fn number(field: &[u8]) -> Result<f64, String> {
    let general = || std::str::from_utf8(field).ok().and_then(|s| s.trim().parse::<f64>().ok());
    match short_decimal(field).or_else(general) {
        Some(v) if v.is_finite() => Ok(v),
        _ => Err(format!("found '{}', expected a finite number", show(field))),
    }
}

/// Powers of ten that an `f64` holds exactly.
const EXACT_POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];

/// Most numbers of public graphs: a sign, digits, a point, digits. `None` for anything else, and where the
/// digits do not fit an `f64`. Digits and power of ten are exact, so that the one division rounds correctly.
fn short_decimal(field: &[u8]) -> Option<f64> {
    let (negative, digits) = match field {
        [b'-', rest @ ..] => (true, rest),
        rest => (false, rest),
    };
    // 19 digits fit a u64; one byte more for the point.
    if digits.is_empty() || digits.len() > 20 {
        return None;
    }
    let mut mantissa = 0_u64;
    // Consumes digits; how many bytes are left.
    let mut take_digits = |mut from: &[u8]| {
        while let [byte, rest @ ..] = from {
            let digit = byte.wrapping_sub(b'0');
            if digit > 9 {
                break;
            }
            mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
            from = rest;
        }
        from.len()
    };
    let left = take_digits(digits);
    let (decimals, points) = match digits.len() - left {
        _ if left == 0 => (0, 0),
        whole if digits[whole] == b'.' && take_digits(&digits[whole + 1..]) == 0 => (left - 1, 1),
        _ => return None,
    };
    let count = digits.len() - points;
    if count == 0 || count > 19 || mantissa > 1 << f64::MANTISSA_DIGITS {
        return None;
    }
    let magnitude = mantissa as f64 / EXACT_POWERS[decimals];
    Some(if negative { -magnitude } else { magnitude })
}

/// A whole number.
pub(crate) fn integer(field: &[u8]) -> Result<i64, String> {
    let general = || std::str::from_utf8(field).ok().and_then(|s| s.trim().parse::<i64>().ok());
    short_count(field)
        .or_else(general)
        .ok_or_else(|| format!("found '{}', expected a whole number", show(field)))
}

/// A few digits and nothing else.
fn short_count(field: &[u8]) -> Option<i64> {
    let short = (1..=18).contains(&field.len()) && field.iter().all(u8::is_ascii_digit);
    short.then(|| field.iter().fold(0, |value, byte| 10 * value + i64::from(byte - b'0')))
}

/// Exactly `N` fields after a tag.
pub(crate) fn exactly<'a, const N: usize>(
    words: impl Iterator<Item = &'a [u8]>,
) -> Result<[&'a [u8]; N], String> {
    let mut taken: [&[u8]; N] = [&[]; N];
    let mut found = 0;
    for word in words {
        if let Some(place) = taken.get_mut(found) {
            *place = word;
        }
        found += 1;
    }
    if found == N { Ok(taken) } else { Err(format!("found {found} fields, expected {N} after the tag")) }
}

/// Exactly `names.len()` numbers; a message names the field at fault.
pub(crate) fn numbers<'a, const N: usize>(
    fields: &mut impl Iterator<Item = &'a [u8]>,
    names: &[&str; N],
) -> Result<[f64; N], String> {
    let mut values = [0.0; N];
    for (k, value) in values.iter_mut().enumerate() {
        let field = fields.next().ok_or_else(|| format!("{}: found the end of the line", names[k]))?;
        *value = number(field).map_err(|m| format!("{}: {m}", names[k]))?;
    }
    Ok(values)
}

/// A line of exactly `names.len()` numbers; `None` for an empty line or a `#` comment.
pub(crate) fn row<const N: usize>(line: &[u8], names: &[&str; N]) -> Result<Option<[f64; N]>, String> {
    let mut words = fields(line);
    if words.clone().next().is_none_or(|w| w.starts_with(b"#")) {
        return Ok(None);
    }
    let found = words.clone().count();
    if found != N {
        return Err(format!("found {found} fields, expected {N}: {}", names.join(" ")));
    }
    numbers(&mut words, names).map(Some)
}

/// Bytes of a file for a message: printable, and not longer than 40 characters.
pub(crate) fn show(field: &[u8]) -> Cow<'_, str> {
    let text = String::from_utf8_lossy(field);
    if text.chars().count() <= 40 && text.chars().all(|c| !c.is_control()) {
        return text;
    }
    let mut short: String = text.chars().filter(|c| !c.is_control()).take(40).collect();
    short.push('…');
    Cow::Owned(short)
}

/// Displays a number as the shortest text that reads back as the same `f64`.
pub(crate) struct Shortest(pub f64);

impl fmt::Display for Shortest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let magnitude = self.0.abs();
        if magnitude == 0.0 || (1e-5..1e16).contains(&magnitude) {
            write!(f, "{}", self.0)
        } else {
            write!(f, "{:e}", self.0)
        }
    }
}
