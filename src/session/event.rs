//! The events of a session, one JSON object a line (docs/FORMATS.md, Session).

use std::str::FromStr;

use serde_json::{Map, Value, json};

use super::Settings;
use crate::io::corrections::{describe_field, from_json, known_fields, stroke, stroke_json, to_json};
use crate::joint::{Backend, Formulation};
use crate::map::{AutomaticFactor, Correction, Stroke};
use crate::pipeline::CorrectionReport;

/// The first line: which map the session is about.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Header {
    /// The version of this program that began the session.
    pub version: String,
    /// The map's file, seen from the session's folder.
    pub map: String,
    /// SHA-256 of the map's file, hexadecimal.
    pub sha256: String,
}

/// One thing that a person did.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// Drew two strokes and committed them. Strokes are in the robot frame of a pose.
    Correct(Correction, Result),
    /// Switched a correction on or off.
    Enable(String, bool),
    /// Gave a correction another weight.
    Reweight(String, f64),
    /// Deleted a correction.
    Delete(String),
    /// Had the visits matched with each other anew: what fits closes loops.
    Match(Matched),
    /// Said of an automatic factor, by its two poses, that it is none, for good.
    Refuse(usize, usize),
    /// Took that back.
    Allow(usize, usize),
    /// Asked for the wall under a stroke to lie along an axis; `None`: as the map came.
    Straighten(Option<Stroke>),
    /// Other settings.
    Settings(Settings),
    /// One step back.
    Undo,
    /// One step forward again.
    Redo,
}

/// What came of a correction, for whoever reads the session; a replay finds it anew.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Result {
    /// |X_a|, |X_b|.
    pub poses: [usize; 2],
    /// |S_a|, |S_b|.
    pub observations: [usize; 2],
    /// Offset left, metres.
    pub offset_after_m: Option<f64>,
    /// Angle left, radians.
    pub angle_after_rad: Option<f64>,
    /// Σ‖r‖² of its terms.
    pub chi2: Option<f64>,
}

impl From<&CorrectionReport> for Result {
    fn from(report: &CorrectionReport) -> Self {
        Result {
            poses: report.poses,
            observations: report.observations,
            offset_after_m: report.offset_m[1],
            angle_after_rad: report.angle_rad[1],
            chi2: report.chi2,
        }
    }
}

/// What came of a re-association, for whoever reads the session; a replay finds it anew.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Matched {
    /// Automatic factors.
    pub factors: usize,
    /// Of those, in disagreement with the rest of the map.
    pub disagreeing: usize,
    /// True: so many contradicted each other that none was kept.
    pub withdrawn: bool,
}

/// An event and when it happened.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Seconds since 1970.
    pub at_s: u64,
    /// What happened.
    pub event: Event,
}

type Checked<T> = std::result::Result<T, String>;

impl Header {
    /// The line of JSON.
    pub fn to_line(&self) -> String {
        json!({"event": "session", "version": self.version, "map": self.map, "sha256": self.sha256})
            .to_string()
    }

    /// Reads the line.
    ///
    /// # Errors
    /// The field, what was found and what was expected.
    pub fn parse(line: &[u8]) -> Checked<Header> {
        let object = object(line)?;
        if object.get("event").and_then(Value::as_str) != Some("session") {
            let found = describe_field(object.get("event"));
            return Err(format!("event: found {found}, expected \"session\", which begins every session"));
        }
        known_fields(&object, &["event", "version", "map", "sha256"])?;
        let text = |name: &str| text(&object, name);
        Ok(Header { version: text("version")?, map: text("map")?, sha256: text("sha256")? })
    }
}

impl Entry {
    /// The line of JSON.
    pub fn to_line(&self) -> String {
        let mut value = match &self.event {
            Event::Correct(correction, result) => {
                let mut value = to_json(correction);
                value["result"] = result_json(result);
                value
            }
            Event::Enable(id, enabled) => json!({"id": id, "enabled": enabled}),
            Event::Reweight(id, weight) => json!({"id": id, "weight": weight}),
            Event::Delete(id) => json!({"id": id}),
            Event::Match(matched) => json!({"result": {
                "factors": matched.factors, "disagreeing": matched.disagreeing, "withdrawn": matched.withdrawn,
            }}),
            Event::Refuse(i, j) | Event::Allow(i, j) => json!({"name": format!("{i}-{j}")}),
            Event::Straighten(along) => json!({"along": along.as_ref().map(stroke_json)}),
            Event::Settings(settings) => json!({
                "solver": settings.solver.name(),
                "formulation": settings.formulation.name(),
                "drawing_sigma_m": settings.drawing_sigma_m,
            }),
            Event::Undo | Event::Redo => json!({}),
        };
        value["event"] = json!(self.event.name());
        value["at"] = json!(self.at_s);
        value.to_string()
    }

    /// Reads a line.
    ///
    /// # Errors
    /// The field, what was found and what was expected.
    pub fn parse(line: &[u8]) -> Checked<Entry> {
        let mut object = object(line)?;
        let name = text(&object, "event")?;
        object.remove("event");
        let at_s = match object.remove("at") {
            Some(Value::Number(n)) if n.is_u64() => n.as_u64().unwrap_or(0),
            other => {
                return Err(format!("at: found {}, expected whole seconds", describe_field(other.as_ref())));
            }
        };
        Ok(Entry { at_s, event: Event::parse(&name, object)? })
    }
}

impl Event {
    /// The name in the file.
    pub fn name(&self) -> &'static str {
        match self {
            Event::Correct(..) => "correct",
            Event::Enable(..) => "enable",
            Event::Reweight(..) => "reweight",
            Event::Delete(..) => "delete",
            Event::Match(..) => "match",
            Event::Refuse(..) => "refuse",
            Event::Allow(..) => "allow",
            Event::Straighten(..) => "straighten",
            Event::Settings(..) => "settings",
            Event::Undo => "undo",
            Event::Redo => "redo",
        }
    }

    /// Reads an event from its name and its other fields.
    ///
    /// # Errors
    /// The field, what was found and what was expected.
    pub fn parse(name: &str, mut fields: Map<String, Value>) -> Checked<Event> {
        let id = |fields: &Map<String, Value>| text(fields, "id");
        match name {
            "correct" => {
                let result = fields.remove("result").as_ref().map(result).unwrap_or_default();
                let correction = from_json(&fields)?;
                if correction.id.is_empty() {
                    return Err("id: found nothing, expected a non-empty text".into());
                }
                Ok(Event::Correct(correction, result))
            }
            "enable" => {
                known_fields(&fields, &["id", "enabled"])?;
                let enabled = fields.get("enabled");
                let enabled = enabled.and_then(Value::as_bool).ok_or_else(|| {
                    format!("enabled: found {}, expected true or false", describe_field(enabled))
                })?;
                Ok(Event::Enable(id(&fields)?, enabled))
            }
            "reweight" => {
                known_fields(&fields, &["id", "weight"])?;
                Ok(Event::Reweight(id(&fields)?, positive(&fields, "weight")?))
            }
            "delete" => {
                known_fields(&fields, &["id"])?;
                Ok(Event::Delete(id(&fields)?))
            }
            "match" => {
                let result = fields.remove("result").as_ref().map(matched).unwrap_or_default();
                known_fields(&fields, &[])?;
                Ok(Event::Match(result))
            }
            "refuse" | "allow" => {
                known_fields(&fields, &["name"])?;
                let given = text(&fields, "name")?;
                let (i, j) = AutomaticFactor::poses_of(&given)
                    .filter(|(i, j)| i < j)
                    .ok_or_else(|| format!("name: found \"{given}\", expected two poses such as 120-431"))?;
                Ok(if name == "refuse" { Event::Refuse(i, j) } else { Event::Allow(i, j) })
            }
            "straighten" => {
                known_fields(&fields, &["along"])?;
                let along = fields.get("along").filter(|v| !v.is_null());
                let along = along.map(|v| stroke(Some(v)).map_err(|m| format!("along: {m}"))).transpose()?;
                Ok(Event::Straighten(along))
            }
            "settings" => {
                known_fields(&fields, &["solver", "formulation", "drawing_sigma_m"])?;
                let plain = |error: crate::error::Error| error.to_string();
                Ok(Event::Settings(Settings {
                    solver: Backend::from_str(&text(&fields, "solver")?).map_err(plain)?,
                    formulation: Formulation::from_str(&text(&fields, "formulation")?).map_err(plain)?,
                    drawing_sigma_m: positive(&fields, "drawing_sigma_m")?,
                }))
            }
            "undo" | "redo" => {
                known_fields(&fields, &[])?;
                Ok(if name == "undo" { Event::Undo } else { Event::Redo })
            }
            "session" => Err("event: found a second beginning, expected one session a file".into()),
            other => Err(format!("event: found \"{other}\", expected an event that this version knows")),
        }
    }
}

fn object(line: &[u8]) -> Checked<Map<String, Value>> {
    match serde_json::from_slice(line) {
        Ok(Value::Object(object)) => Ok(object),
        Ok(_) => Err("found no JSON object, expected one a line".into()),
        Err(e) => Err(format!(
            "found text that is not JSON ({}), expected one object a line",
            crate::io::corrections::fault(&e)
        )),
    }
}

fn text(object: &Map<String, Value>, name: &str) -> Checked<String> {
    match object.get(name) {
        Some(Value::String(text)) if !text.is_empty() => Ok(text.clone()),
        other => Err(format!("{name}: found {}, expected a non-empty text", describe_field(other))),
    }
}

fn positive(object: &Map<String, Value>, name: &str) -> Checked<f64> {
    let value = object.get(name);
    let number = value.and_then(Value::as_f64).filter(|v| *v > 0.0 && v.is_finite());
    number.ok_or_else(|| format!("{name}: found {}, expected a number > 0", describe_field(value)))
}

fn result_json(result: &Result) -> Value {
    json!({
        "poses": result.poses, "observations": result.observations, "offset_after_m": result.offset_after_m,
        "angle_after_rad": result.angle_after_rad, "chi2": result.chi2,
    })
}

fn result(value: &Value) -> Result {
    let counts = |name: &str| [0, 1].map(|k| value[name][k].as_u64().unwrap_or(0) as usize);
    Result {
        poses: counts("poses"),
        observations: counts("observations"),
        offset_after_m: value["offset_after_m"].as_f64(),
        angle_after_rad: value["angle_after_rad"].as_f64(),
        chi2: value["chi2"].as_f64(),
    }
}

fn matched(value: &Value) -> Matched {
    let count = |name: &str| value[name].as_u64().unwrap_or(0) as usize;
    Matched {
        factors: count("factors"),
        disagreeing: count("disagreeing"),
        withdrawn: value["withdrawn"].as_bool().unwrap_or(false),
    }
}
