//! What the page is told: the map's name and size, the corrections as they stand, what can be undone, what is going on.

use std::convert::Infallible;
use std::sync::Arc;

use axum::body::{Body, Bytes};
use axum::extract::State;
use axum::http::header;
use axum::response::{IntoResponse, Response};
use serde_json::{Value, json};
use tokio_stream::StreamExt;
use tokio_stream::wrappers::WatchStream;

use super::app::{App, Desk};
use super::wire::{Answer, ends_json};
use crate::contradictions;
use crate::joint::{self, Backend};
use crate::map::{AutomaticFactor, SlamMap};
use crate::pipeline::CorrectionReport;

/// The corrections that contradict the rest, each with its reason; or why that is not known.
pub type Judged = Result<Vec<(String, String)>, String>;

/// Poses times corrections up to which contradictions are looked for after every change.
const MOST_JUDGED: usize = 200_000;

/// `GET /api/state`: all of it.
pub async fn state(State(app): State<Arc<App>>) -> Answer {
    let text = app.told().to_string();
    Ok(([(header::CONTENT_TYPE, "application/json")], text).into_response())
}

/// `GET /api/news`: the same, one line at every change, for ever. A slow reader misses what is out of date.
pub async fn news(State(app): State<Arc<App>>) -> Response {
    let lines =
        WatchStream::new(app.listen()).map(|told| Ok::<_, Infallible>(Bytes::from(format!("{told}\n"))));
    ([(header::CONTENT_TYPE, "application/x-ndjson")], Body::from_stream(lines)).into_response()
}

/// The line for the pages.
pub fn told(view: &Value, works: Vec<Value>) -> Arc<str> {
    let mut told = view.clone();
    told["works"] = works.into();
    told["version"] = env!("CARGO_PKG_VERSION").into();
    told["solvers"] = match Backend::Ceres.available() {
        true => json!(["rust", "ceres"]),
        false => json!(["rust"]),
    };
    told.to_string().into()
}

/// The open map.
pub fn of(desk: &Desk) -> Value {
    let session = &desk.session;
    let (history, state, solved) = (session.history(), session.state(), session.solved());
    let map = solved.corrector().map();
    let standings = solved.corrector().standings();
    let corrections = solved.reports().map(|report| {
        let standing = standings.iter().rev().find(|s| s.id == report.id);
        let factor = map.human_factors.iter().rev().find(|f| f.id == report.id);
        let turned = |s: crate::geometry::Segment| ends_json(s.transformed(solved.world_from_map()).ends());
        let poses = |f: &crate::map::Feature| f.sightings.iter().map(|s| s.pose).collect::<Vec<_>>();
        let correction = state.corrections.iter().find(|c| c.id == report.id);
        json!({
            "id": report.id, "mode": report.mode.name(), "enabled": report.enabled,
            "weight": correction.map(|c| c.weight),
            "rejection": report.rejection.as_ref().filter(|_| report.enabled),
            "offset_before_m": report.offset_m[0], "angle_before_rad": report.angle_rad[0],
            "offset_m": standing.and_then(|s| s.offset_m), "angle_rad": standing.map(|s| s.angle_rad),
            "chi2": standing.map(|s| s.chi2),
            "conflicts": [],
            "poses": report.poses, "observations": report.observations,
            "segments": factor.map(|f| json!([turned(f.a.segment), turned(f.b.segment)])),
            "seen_from": factor.map(|f| json!([poses(&f.a), poses(&f.b)])),
        })
    });
    let name = session.source().path.file_name().unwrap_or_default().to_string_lossy();
    json!({
        "map": {
            "number": desk.map, "name": name, "path": session.source().path.display().to_string(),
            "poses": map.poses.len(), "points": map.observations.len(),
            "closures": map.relative_factors.iter().filter(|f| f.i.abs_diff(f.j) != 1).count(),
            "session": session.log_path().display().to_string(),
        },
        "revision": desk.revision,
        "corrections": corrections.collect::<Vec<_>>(),
        "unjudged": null,
        "matching": {
            "is_current": state.is_matched(), "factors": map.automatic_factors.len(), "refused": state.refused.len(),
            "disagreeing": disagreeing(map), "withdrawn": solved.matched().is_some_and(|m| m.report.withdrawn),
            "footprints": map.points_are_footprints(),
            "near_passes": solved.matched().map_or(0, |m| m.report.near_passes.len()),
        },
        "straightened": state.straighten.is_some(),
        "undo": history.undo(), "redo": history.redo(),
        "settings": {
            "solver": state.settings.solver.name(), "formulation": state.settings.formulation.name(),
            "drawing_sigma_m": state.settings.drawing_sigma_m,
        },
        "summary": session.summary(),
        "remarks": desk.remarks,
    })
}

/// Names of the corrections that contradict the rest, and why.
///
/// # Errors
/// Why that is not known, for a person: the map counts, not what is said of it.
pub fn contradictions_of(map: &SlamMap, options: &joint::Options) -> Judged {
    if map.poses.len() * map.human_factors.len() > MOST_JUDGED {
        return Err(
            "not looked for contradictions: on a map of this size that takes too long after every change; \
                    hitl correct names them"
                .into(),
        );
    }
    let found = contradictions::find(map, options)
        .map_err(|error| format!("could not look for contradictions: {error}"))?;
    Ok(found.named.iter().map(|s| (s.id.clone(), format!("the rest: {}", s.reason()))).collect())
}

/// Puts down in a view which corrections contradict the rest.
pub fn judge(view: &mut Value, judged: &Judged) {
    view["unjudged"] = json!(judged.as_ref().err());
    for correction in view["corrections"].as_array_mut().into_iter().flatten() {
        let found = judged.iter().flatten().filter(|(id, _)| correction["id"] == id.as_str());
        correction["conflicts"] = found.map(|(_, reason)| json!(reason)).collect();
    }
}

/// Until the new map is judged, what was known of the old one stays.
pub fn inherit(view: &mut Value, old: &Value) {
    if view["map"]["number"] != old["map"]["number"] {
        return;
    }
    view["unjudged"] = old["unjudged"].clone();
    for correction in view["corrections"].as_array_mut().into_iter().flatten() {
        let known = old["corrections"].as_array().into_iter().flatten().find(|c| c["id"] == correction["id"]);
        if let Some(known) = known {
            correction["conflicts"] = known["conflicts"].clone();
        }
    }
}

/// Number of automatic factors that disagree with the map as it stands.
fn disagreeing(map: &SlamMap) -> usize {
    let disagrees = |a: &&AutomaticFactor| {
        let chi2 = a.factor.chi2(map.poses[a.factor.i], map.poses[a.factor.j]);
        AutomaticFactor { chi2, ..**a }.disagrees()
    };
    map.automatic_factors.iter().filter(disagrees).count()
}

/// What a correction would do, for the status line.
pub fn report(report: &CorrectionReport) -> Value {
    let stroke = |s: &crate::pipeline::Stroke| {
        json!({"name": s.name, "points": s.caught.as_ref().map(|c| c.points.len()),
               "poses": s.caught.as_ref().map(|c| c.poses.len())})
    };
    json!({
        "accepted": report.accepted(), "reason": report.rejection, "mode": report.mode.name(),
        "offset_m": report.offset_m, "angle_rad": report.angle_rad, "chi2": report.chi2,
        "strokes": report.strokes.iter().map(stroke).collect::<Vec<_>>(),
        "total_ms": report.timings.total_ms,
    })
}
