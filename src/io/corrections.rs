//! Corrections: JSON Lines, one correction a line, in the order in which they are applied.
//!
//! ```text
//! {"mode": "collinear", "a": STROKE, "b": STROKE, "weight": 1.0, "id": "c1", "enabled": true}
//! ```
//! STROKE: `[[x, y], [x, y]]` in the world frame, or `{"pose": i, "points": …}` or `{"stamp": t, "points": …}` in the
//! robot frame of a pose or scan. Metres, seconds. Unknown fields are errors: a misspelt `weight` must not be lost.
//! Whether a pose exists is checked where the map is known.

use std::collections::HashSet;
use std::path::Path;

use serde_json::{Map, Value, json};

use super::source::Lines;
use super::{Read, atomic};
use crate::error::Result;
use crate::geometry::Vec2;
use crate::map::{Correction, Mode, Stroke};

pub(crate) type Checked<T> = std::result::Result<T, String>;

/// Reads corrections. One without an `id` is called `c1`, `c2`, … by its place among the corrections.
///
/// # Errors
/// [`crate::error::Error::Input`] at `file:line`, naming the field, what was found and what was expected; or if there
/// is no correction in the file.
pub fn read(path: &Path) -> Result<Read<Vec<Correction>>> {
    let mut lines = Lines::open(path)?;
    let mut corrections: Vec<Correction> = Vec::new();
    let mut ids = HashSet::new();
    while lines.advance()? {
        if lines.line().trim_ascii().is_empty() {
            continue;
        }
        let correction = parse(lines.line()).map_err(|m| lines.error(m))?;
        if !correction.id.is_empty() && !ids.insert(correction.id.clone()) {
            let message = format!("id: found '{}' a second time, expected each id once", correction.id);
            return Err(lines.error(message));
        }
        corrections.push(correction);
    }
    if corrections.is_empty() {
        return Err(lines.file_error("found no correction, expected one JSON object a line"));
    }
    for (k, correction) in corrections.iter_mut().enumerate().filter(|(_, c)| c.id.is_empty()) {
        let mut id = format!("c{}", k + 1);
        while !ids.insert(id.clone()) {
            id.push('_');
        }
        correction.id = id;
    }
    Ok(Read { value: corrections, warnings: Vec::new() })
}

/// One line; the id is empty where the line has none.
fn parse(line: &[u8]) -> Checked<Correction> {
    let value: Value = serde_json::from_slice(line).map_err(|e| {
        format!("found text that is not JSON ({}), expected one JSON object a line", fault(&e))
    })?;
    let Value::Object(object) = value else {
        return Err(format!("found {}, expected a JSON object", describe(&value)));
    };
    if object.contains_key("event") {
        return Err(
            "event: found a session event, expected a correction: a session begins with its event `session`"
                .into(),
        );
    }
    from_json(&object)
}

/// A correction from its object; the id is empty where the object has none.
///
/// # Errors
/// The field, what was found and what was expected.
pub(crate) fn from_json(object: &Map<String, Value>) -> Checked<Correction> {
    known_fields(object, &["mode", "a", "b", "weight", "id", "enabled"])?;
    let mode = match object.get("mode") {
        Some(Value::String(name)) => Mode::ALL.into_iter().find(|m| m.name() == name),
        _ => None,
    };
    let mode = mode.ok_or_else(|| {
        let known = Mode::ALL.map(Mode::name).join(", ");
        format!("mode: found {}, expected one of {known}", describe_field(object.get("mode")))
    })?;
    let weight = match object.get("weight") {
        None => 1.0,
        Some(v) => v
            .as_f64()
            .filter(|w| *w > 0.0 && w.is_finite())
            .ok_or_else(|| format!("weight: found {}, expected a number > 0", describe(v)))?,
    };
    let id = match object.get("id") {
        None => String::new(),
        Some(Value::String(id)) if !id.is_empty() => id.clone(),
        Some(v) => return Err(format!("id: found {}, expected a non-empty text", describe(v))),
    };
    let enabled = match object.get("enabled") {
        None => true,
        Some(Value::Bool(enabled)) => *enabled,
        Some(v) => return Err(format!("enabled: found {}, expected true or false", describe(v))),
    };
    let a = stroke(object.get("a")).map_err(|m| format!("a: {m}"))?;
    let b = stroke(object.get("b")).map_err(|m| format!("b: {m}"))?;
    Ok(Correction { id, mode, a, b, weight, enabled })
}

/// serde's complaint without its own count of lines, which is always 1.
pub(crate) fn fault(error: &serde_json::Error) -> String {
    error.to_string().replace(" at line 1 column ", " at column ")
}

/// Refuses fields that are not known: a misspelt one must not be lost.
pub(crate) fn known_fields(object: &Map<String, Value>, known: &[&str]) -> Checked<()> {
    match object.keys().find(|k| !known.contains(&k.as_str())) {
        Some(unknown) => Err(format!("{unknown}: found an unknown field, expected {}", known.join(", "))),
        None => Ok(()),
    }
}

/// A stroke from its JSON.
pub(crate) fn stroke(value: Option<&Value>) -> Checked<Stroke> {
    let object = match value {
        Some(value @ Value::Array(_)) => return points(Some(value)).map(Stroke::World),
        Some(Value::Object(object)) => object,
        other => {
            let found = describe_field(other);
            return Err(format!(
                "found {found}, expected a stroke: [[x, y], [x, y]] or an object with pose or stamp"
            ));
        }
    };
    known_fields(object, &["pose", "stamp", "points"])?;
    let points = points(object.get("points")).map_err(|m| format!("points: {m}"))?;
    match (object.get("pose"), object.get("stamp")) {
        (Some(pose), None) => {
            let index = pose.as_u64().and_then(|p| usize::try_from(p).ok());
            let pose = index
                .ok_or_else(|| format!("pose: found {}, expected an index of 0 or more", describe(pose)))?;
            Ok(Stroke::Pose { pose, points })
        }
        (None, Some(stamp)) => {
            let stamp_s = stamp
                .as_f64()
                .filter(|s| s.is_finite())
                .ok_or_else(|| format!("stamp: found {}, expected seconds", describe(stamp)))?;
            Ok(Stroke::Stamp { stamp_s, points })
        }
        (Some(_), Some(_)) => Err("found both pose and stamp, expected one of them".into()),
        (None, None) => Err("found neither pose nor stamp, expected one of them".into()),
    }
}

fn points(value: Option<&Value>) -> Checked<[Vec2; 2]> {
    let fail = || format!("found {}, expected two points [[x, y], [x, y]] in metres", describe_field(value));
    let Some(Value::Array(ends)) = value else { return Err(fail()) };
    let mut points = [Vec2::zeros(); 2];
    if ends.len() != 2 {
        return Err(fail());
    }
    for (point, end) in points.iter_mut().zip(ends) {
        let Value::Array(xy) = end else { return Err(fail()) };
        let [x, y] = xy.as_slice() else { return Err(fail()) };
        let (Some(x), Some(y)) = (x.as_f64(), y.as_f64()) else { return Err(fail()) };
        if !x.is_finite() || !y.is_finite() {
            return Err(fail());
        }
        *point = Vec2::new(x, y);
    }
    let length_m = (points[1] - points[0]).norm();
    if !length_m.is_finite() {
        return Err("found a stroke of infinite length, expected metres".into());
    }
    if length_m == 0.0 {
        return Err("found a stroke of zero length, expected two different points".into());
    }
    Ok(points)
}

/// A field as it stands in the file, cut short.
pub(crate) fn describe_field(value: Option<&Value>) -> String {
    value.map_or_else(|| "nothing".into(), describe)
}

/// A value as it stands in the file, cut short.
fn describe(value: &Value) -> String {
    super::text::show(value.to_string().as_bytes()).into_owned()
}

/// Writes corrections, one a line.
///
/// # Errors
/// [`crate::error::Error::Io`] if the file cannot be written.
pub fn write(path: &Path, corrections: &[Correction]) -> Result<()> {
    atomic::write(path, |out| corrections.iter().try_for_each(|c| writeln!(out, "{}", to_json_line(c))))
}

/// One correction as its JSON object.
pub(crate) fn to_json(correction: &Correction) -> Value {
    let c = correction;
    json!({
        "mode": c.mode.name(), "a": stroke_json(&c.a), "b": stroke_json(&c.b),
        "weight": c.weight, "id": c.id, "enabled": c.enabled,
    })
}

impl serde::Serialize for Correction {
    /// As in a corrections file.
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        to_json(self).serialize(serializer)
    }
}

/// One correction as its line of JSON.
pub fn to_json_line(correction: &Correction) -> String {
    to_json(correction).to_string()
}

/// A stroke as its JSON.
pub(crate) fn stroke_json(stroke: &Stroke) -> Value {
    let ends = |points: &[Vec2; 2]| json!([[points[0].x, points[0].y], [points[1].x, points[1].y]]);
    match stroke {
        Stroke::World(points) => ends(points),
        Stroke::Pose { pose, points } => json!({"pose": pose, "points": ends(points)}),
        Stroke::Stamp { stamp_s, points } => json!({"stamp": stamp_s, "points": ends(points)}),
    }
}
