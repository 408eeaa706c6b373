//! Strokes, previews and everything that changes the map.

use std::sync::Arc;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use axum::body::Bytes;
use axum::extract::State;
use axum::http::StatusCode;
use serde_json::{Map, Value, json};

use super::app::{App, Desk};
use super::view;
use super::wire::{Answer, Fault, aside, ends_json, object, packed, pose_bytes};
use crate::geometry::Vec2;
use crate::map::Mode;
use crate::session::{Answer as Done, Drawn, Event, EventResult, Look};

type Fields = Map<String, Value>;
type Checked<T> = std::result::Result<T, Fault>;

/// `POST /api/catch {stroke, revision}`: the wall under a stroke, the points that belong to it (u32).
pub async fn catch(State(app): State<Arc<App>>, body: Bytes) -> Answer {
    aside(app, move |app| {
        let fields = object(&body)?;
        let ends = stroke(&fields, "stroke")?;
        let desk = app.read();
        let desk = current(desk.as_ref(), &fields)?;
        let (head, points) = looked(&desk.session.catch(ends));
        Ok(packed(&head, &[&points]))
    })
    .await
}

/// What a stroke caught, and its points (u32).
fn looked(look: &Look) -> (Value, Vec<u8>) {
    let (caught, warning) = match look {
        Ok(found) => found,
        Err(reason) => return (json!({"reason": reason, "count": 0}), Vec::new()),
    };
    let head = json!({
        "segment": ends_json(caught.fit.segment.ends()), "count": caught.points.len(),
        "poses": caught.poses.len(), "warning": warning,
    });
    (head, caught.points.iter().flat_map(|p| p.to_le_bytes()).collect())
}

/// `POST /api/preview {mode, a, b, weight, anchors, revision}` (anchors: the two poses that the strokes hang on, if they are known): the poses as they would be, and what stroke b caught.
pub async fn preview(State(app): State<Arc<App>>, body: Bytes) -> Answer {
    aside(app, move |app| {
        let start = Instant::now();
        let fields = object(&body)?;
        let mut desk = app.write();
        let desk = desk.as_mut().ok_or_else(Fault::nothing_open)?;
        let drawn = drawn(&fields, current(Some(desk), &fields)?)?;
        let (caught, points) = looked(&desk.session.catch(drawn.strokes[1]));
        let correction = desk.session.correction(&drawn);
        let world_from_map = desk.session.solved().world_from_map();
        let proposal = desk.session.preview(&correction)?;
        let mut head = view::report(&proposal.report);
        let poses = proposal.state.as_ref().map(|s| pose_bytes(&s.poses, world_from_map)).unwrap_or_default();
        head["poses"] = json!(poses.len() / 24);
        head["b"] = caught;
        head["server_ms"] = json!(start.elapsed().as_secs_f64() * 1e3);
        Ok(packed(&head, &[&poses, &points]))
    })
    .await
}

/// `POST /api/commit`, as [`preview`]: the correction is on disk and on the map when this answers.
pub async fn commit(State(app): State<Arc<App>>, body: Bytes) -> Answer {
    let changed = aside(Arc::clone(&app), move |app| {
        let fields = object(&body)?;
        let start = Instant::now();
        let mut desk = app.write();
        let desk = desk.as_mut().ok_or_else(Fault::nothing_open)?;
        let drawn = drawn(&fields, current(Some(desk), &fields)?)?;
        let correction = desk.session.correction(&drawn);
        carry_out(app, desk, Event::Correct(correction, EventResult::default()), start)
    })
    .await;
    tokio::task::spawn_blocking(move || app.judge());
    changed
}

/// `POST /api/act {event, …}`: any other event, with the fields of a session's line; a stroke is in the world.
pub async fn act(State(app): State<Arc<App>>, body: Bytes) -> Answer {
    let changed = aside(Arc::clone(&app), move |app| {
        let mut fields = object(&body)?;
        let name = match fields.remove("event") {
            Some(Value::String(name)) if name != "correct" => name,
            _ => return Err(Fault::bad("event: found none, expected the name of an event")),
        };
        let start = Instant::now();
        let mut desk = app.write();
        let desk = desk.as_mut().ok_or_else(Fault::nothing_open)?;
        current(Some(desk), &fields)?;
        fields.remove("revision");
        let event = if name == "straighten" && fields.contains_key("stroke") {
            Event::Straighten(Some(desk.session.anchor(stroke(&fields, "stroke")?)))
        } else {
            Event::parse(&name, fields).map_err(Fault::bad)?
        };
        carry_out(app, desk, event, start)
    })
    .await;
    tokio::task::spawn_blocking(move || app.judge());
    changed
}

/// Lets an event happen, tells the pages, and answers with the new poses.
fn carry_out(app: &App, desk: &mut Desk, event: Event, start: Instant) -> Answer {
    let at_s = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    let working = app.begin("solving".into());
    match desk.session.act(event, at_s, &mut |done, of| working.progress(done, of))? {
        Done::Done => {}
        Done::Refused(reason) => return Err(Fault::new(StatusCode::UNPROCESSABLE_ENTITY, reason)),
        Done::Cancelled => return Err(Fault::new(StatusCode::CONFLICT, "given up: nothing has changed")),
    }
    drop(working);
    desk.revision = app.number();
    app.show(desk);
    let solved = desk.session.solved();
    let poses = pose_bytes(&solved.corrector().map().poses, solved.world_from_map());
    let server_ms = start.elapsed().as_secs_f64() * 1e3;
    let head = json!({"revision": desk.revision, "poses": poses.len() / 24, "server_ms": server_ms});
    Ok(packed(&head, &[&poses]))
}

/// The open session, if it still shows what the person saw.
pub fn current<'a>(desk: Option<&'a Desk>, fields: &Fields) -> Checked<&'a Desk> {
    let desk = desk.ok_or_else(Fault::nothing_open)?;
    match fields.get("revision").and_then(Value::as_u64) {
        Some(revision) if revision == desk.revision => Ok(desk),
        Some(_) => Err(Fault::outdated()),
        None => Err(Fault::bad("revision: found none, expected the number of the map on screen")),
    }
}

fn drawn(fields: &Fields, desk: &Desk) -> Checked<Drawn> {
    let mode = fields.get("mode").and_then(Value::as_str);
    let mode = Mode::ALL.into_iter().find(|m| Some(m.name()) == mode);
    let mode = mode.ok_or_else(|| Fault::bad("mode: found an unknown one, expected one of the four"))?;
    let weight = match fields.get("weight") {
        None => Some(1.0),
        Some(weight) => weight.as_f64().filter(|w| w.is_finite() && *w > 0.0),
    };
    let weight = weight.ok_or_else(|| Fault::bad("weight: expected a number > 0"))?;
    let poses = desk.session.solved().corrector().map().poses.len();
    let pose = |value: &Value, k: usize| usize::try_from(value.get(k)?.as_u64()?).ok().filter(|p| *p < poses);
    let anchors = match fields.get("anchors") {
        None | Some(Value::Null) => None,
        Some(both) => {
            Some(pose(both, 0).zip(pose(both, 1)).map(<[usize; 2]>::from).ok_or_else(|| {
                Fault::bad(format!("anchors: found {both}, expected two poses below {poses}"))
            })?)
        }
    };
    Ok(Drawn { mode, strokes: [stroke(fields, "a")?, stroke(fields, "b")?], anchors, weight })
}

/// Two different points that are somewhere.
fn stroke(fields: &Fields, name: &str) -> Checked<[Vec2; 2]> {
    let fail = || Fault::bad(format!("{name}: expected two different points [[x, y], [x, y]] in metres"));
    let value = fields.get(name).ok_or_else(fail)?;
    let number = |i: usize, k: usize| value.get(i).and_then(|p| p.get(k)).and_then(Value::as_f64);
    let point = |i: usize| Some(Vec2::new(number(i, 0)?, number(i, 1)?));
    let (Some(a), Some(b)) = (point(0), point(1)) else { return Err(fail()) };
    let length = (b - a).norm();
    if !(length.is_finite() && length > 0.0 && a.norm() < 1e9) { Err(fail()) } else { Ok([a, b]) }
}
