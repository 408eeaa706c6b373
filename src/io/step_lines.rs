//! The lines of a live run, in and out: one JSON object a line (docs/FORMATS-walks.md).

use serde::Serialize;
use serde_json::{Map, Value};

use super::walk::{UNITS, WALK_COLUMNS};
use crate::geometry::{Pose2, wrap_angle};
use crate::pedestrian::live::{Live, Position};
use crate::pedestrian::{Step, TransitionMap, metrics};

/// Longest line that is looked at, bytes.
pub const LONGEST_LINE: usize = 1 << 16;
/// Longest name of a walker, bytes: it becomes a file's.
const LONGEST_NAME: usize = 100;

/// What a line says.
#[derive(Debug, Clone, PartialEq)]
pub enum Line {
    /// A walker took a step.
    Step(String, Step),
    /// Where a walker starts who does not start where the others do.
    Start(String, Pose2),
    /// `{"request": "map"}`
    Map,
    /// `{"request": "round"}`
    Round,
}

/// Reads a line.
///
/// # Errors
/// What was found and what was expected.
pub fn parse(line: &[u8]) -> Result<Line, String> {
    let value: Value = serde_json::from_slice(line)
        .map_err(|e| format!("found no JSON object ({e}), expected one such as {{\"walker\": …}}"))?;
    let Value::Object(fields) = value else {
        return Err(format!("found {value}, expected a JSON object"));
    };
    if let Some(request) = fields.get("request") {
        only(&fields, &["request"])?;
        return match request.as_str() {
            Some("map") => Ok(Line::Map),
            Some("round") => Ok(Line::Round),
            _ => Err(format!("request: found {request}, expected \"map\" or \"round\"")),
        };
    }
    let name = name(&fields)?;
    if fields.contains_key("start_x_m") {
        const START: [&str; 3] = ["start_x_m", "start_y_m", "start_heading_rad"];
        only(&fields, &["walker", START[0], START[1], START[2]])?;
        let mut pose = [0.0; 3];
        for (value, field) in pose.iter_mut().zip(START) {
            *value = number(&fields, field)?;
        }
        return Ok(Line::Start(name, Pose2::new(pose[0], pose[1], wrap_angle(pose[2]))));
    }
    let mut values = [0.0; 4];
    for (value, field) in values.iter_mut().zip(WALK_COLUMNS) {
        *value = number(&fields, field)?;
    }
    let has_unit = |f: &str| f.rsplit_once('_').is_some_and(|(_, unit)| UNITS.contains(&unit));
    for field in fields.keys().filter(|f| *f != "walker" && !WALK_COLUMNS.contains(&f.as_str())) {
        if !has_unit(field) {
            let expected = "expected further fields to be named with their unit, such as height_m";
            return Err(format!("found the field '{field}', {expected}"));
        }
        number(&fields, field)?;
    }
    let [time_s, forward_m, left_m, turn_rad] = values;
    Ok(Line::Step(name, Step { time_s, forward_m, left_m, turn_rad }))
}

fn name(fields: &Map<String, Value>) -> Result<String, String> {
    let expected = "expected a name of letters, digits, '-', '_' and '.', not beginning with '.'";
    let found = fields.get("walker").ok_or_else(|| format!("walker: found none, {expected}"))?;
    let good = |name: &&str| {
        let known = |c: char| c.is_alphanumeric() || "-_.".contains(c);
        (1..=LONGEST_NAME).contains(&name.len()) && !name.starts_with('.') && name.chars().all(known)
    };
    let name = found.as_str().filter(good).ok_or_else(|| format!("walker: found {found}, {expected}"))?;
    Ok(name.to_owned())
}

fn number(fields: &Map<String, Value>, name: &str) -> Result<f64, String> {
    let found = fields.get(name).ok_or_else(|| format!("{name}: found none, expected a number"))?;
    let number = found.as_f64().filter(|v| v.is_finite());
    number.ok_or_else(|| format!("{name}: found {found}, expected a finite number"))
}

fn only(fields: &Map<String, Value>, known: &[&str]) -> Result<(), String> {
    match fields.keys().find(|f| !known.contains(&f.as_str())) {
        Some(other) => Err(format!("found the field '{other}', expected {} only", known.join(", "))),
        None => Ok(()),
    }
}

/// The answer to a step.
pub fn position(line: usize, walker: &str, p: &Position) -> String {
    #[derive(Serialize)]
    struct Answer<'a> {
        line: usize,
        walker: &'a str,
        time_s: f64,
        x_m: f64,
        y_m: f64,
        heading_rad: f64,
        sigma_m: f64,
        best_x_m: f64,
        best_y_m: f64,
        pdr_x_m: f64,
        pdr_y_m: f64,
        steps: usize,
    }
    to_text(&Answer {
        line,
        walker,
        time_s: p.time_s,
        x_m: p.mean.x_m,
        y_m: p.mean.y_m,
        heading_rad: p.mean.theta_rad,
        sigma_m: p.sigma_m,
        best_x_m: p.best.x,
        best_y_m: p.best.y,
        pdr_x_m: p.reckoned.x_m,
        pdr_y_m: p.reckoned.y_m,
        steps: p.steps,
    })
}

/// The answer to a request for the map: that of map.json.
pub fn map(line: usize, map: &TransitionMap, alpha: f64) -> String {
    let mut value = super::transition_map::to_json(map);
    value["event"] = "map".into();
    value["line"] = line.into();
    value["entropy_bits"] = metrics::entropy_bits(map, alpha).into();
    value.to_string()
}

/// The answer to a closed round: where everybody is now.
pub fn round(line: usize, live: &Live) -> String {
    let walkers: Vec<Value> = live
        .positions()
        .map(|(name, p, sigma_m)| {
            serde_json::json!({"walker": name, "x_m": p.x_m, "y_m": p.y_m, "heading_rad": p.theta_rad, "sigma_m": sigma_m})
        })
        .collect();
    serde_json::json!({"event": "round", "line": line, "walkers": walkers}).to_string()
}

/// What a live run has to say by itself.
pub fn event(line: usize, event: &crate::pedestrian::live::Event) -> String {
    use crate::pedestrian::live::Event;
    match event {
        Event::Grid { angle_rad, fall_back } => serde_json::json!({
            "event": "grid", "line": line, "angle_deg": angle_rad.to_degrees(),
            "fall_back": fall_back.as_ref().map(ToString::to_string),
        }),
        Event::Strayed { walker, window_m } => serde_json::json!({
            "event": "strayed", "line": line, "walker": walker, "window_m": window_m,
        }),
    }
    .to_string()
}

fn to_text(value: &impl Serialize) -> String {
    serde_json::to_string(value).unwrap_or_default()
}
