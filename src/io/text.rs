//! Numbers and fields in text formats: read strictly, written as the shortest text that reads back the same.

use std::borrow::Cow;
use std::fmt;

/// Fields separated by spaces or tabs.
pub(crate) fn fields(line: &[u8]) -> impl Iterator<Item = &[u8]> + Clone {
    line.split(|b| b.is_ascii_whitespace()).filter(|f| !f.is_empty())
}

/// A finite number. The message says what was found instead, without a place.
pub(crate) fn number(field: &[u8]) -> Result<f64, String> {
    let value = std::str::from_utf8(field).ok().and_then(|s| s.trim().parse::<f64>().ok());
    match value {
        Some(v) if v.is_finite() => Ok(v),
        _ => Err(format!("found '{}', expected a finite number", show(field))),
    }
}

/// A whole number.
pub(crate) fn integer(field: &[u8]) -> Result<i64, String> {
    std::str::from_utf8(field)
        .ok()
        .and_then(|s| s.trim().parse::<i64>().ok())
        .ok_or_else(|| format!("found '{}', expected a whole number", show(field)))
}

/// Exactly `names.len()` numbers; a message names the field at fault.
pub(crate) fn numbers<const N: usize>(
    fields: &mut dyn Iterator<Item = &[u8]>,
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
