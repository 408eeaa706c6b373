//! What takes a while and looks only: on a copy of the map, so that drawing goes on meanwhile.

use std::sync::Arc;

use axum::body::Bytes;
use axum::extract::State;
use axum::http::StatusCode;
use serde_json::{Value, json};

use super::app::App;
use super::edit::current;
use super::wire::{Answer, Fault, answer, aside, object, packed};
use crate::crosscheck as check;
use crate::geometry::Vec2;
use crate::metrics;
use crate::session::Session;
use crate::suggest;

/// A copy of something of the open session.
fn copy<T>(app: &App, of: impl FnOnce(&Session) -> T) -> std::result::Result<T, Fault> {
    let desk = app.read();
    Ok(of(&desk.as_ref().ok_or_else(Fault::nothing_open)?.session))
}

fn given_up() -> Fault {
    Fault::new(StatusCode::CONFLICT, "given up")
}

/// `POST /api/inconsistency`: where the map contradicts itself: cells as f32 x, y, count.
pub async fn inconsistency(State(app): State<Arc<App>>) -> Answer {
    aside(app, |app| {
        let working = app.begin("measuring inconsistency".into());
        let map = copy(app, |s| s.solved().map())?;
        let found = metrics::inconsistency(&map, &metrics::InconsistencyOptions::default())?;
        if working.is_cancelled() {
            return Err(given_up());
        }
        let cells: Vec<u8> = found
            .cells
            .iter()
            .flat_map(|(p, count)| [p.x as f32, p.y as f32, *count as f32])
            .flat_map(f32::to_le_bytes)
            .collect();
        let head = json!({
            "inconsistency_m2": found.area_m2, "resolution_m": found.resolution_m, "cells": found.cells.len(),
        });
        Ok(packed(&head, &[&cells]))
    })
    .await
}

/// `POST /api/match {revision}`: matches the visits of the map on screen with each other, on a copy. Nothing changes yet: the
/// event `match` then shows what was found, at once. Given up if the map changes meanwhile.
pub async fn matching(State(app): State<Arc<App>>, body: Bytes) -> Answer {
    aside(app, move |app| {
        let fields = object(&body)?;
        let working = app.begin("matching visits".into());
        let (mut branch, revision) = {
            let desk = app.read();
            let desk = current(desk.as_ref(), &fields)?;
            (desk.session.branch(), desk.revision)
        };
        let found = branch.run(&mut |done, of| working.progress(done, of) && app.shows(revision))?;
        let mut desk = app.write();
        let desk = desk.as_mut().filter(|d| d.revision == revision).ok_or_else(Fault::outdated)?;
        if !found {
            return Err(given_up());
        }
        desk.session.learn(branch);
        Ok(answer(&json!({"revision": revision})))
    })
    .await
}

/// `POST /api/suggest {revision}`: the correction that would help most, on the map on screen: strokes in the world, the poses they hang on, the
/// mode and weight, and why; null if nothing is visibly wrong. For [`super::edit::preview`], and a person's look.
pub async fn suggest(State(app): State<Arc<App>>, body: Bytes) -> Answer {
    aside(app, move |app| {
        let fields = object(&body)?;
        let working = app.begin("looking where a stroke would help".into());
        let (map, world_from_map, pipeline, revision) = {
            let desk = app.read();
            let desk = current(desk.as_ref(), &fields)?;
            let solved = desk.session.solved();
            let pipeline = desk.session.state().settings.options();
            (solved.corrector().map().clone(), solved.world_from_map(), pipeline, desk.revision)
        };
        let options = suggest::Options { most: 1, pipeline, ..suggest::Options::default() };
        let told = |found| working.progress(found, 0) && app.shows(revision);
        let found = suggest::suggest(&map, &options, &told)?;
        if !told(0) {
            return Err(given_up());
        }
        let suggestion = found.first().map(|s| {
            let strokes = s.walls.map(|ends| {
                ends.map(|[x, y]| world_from_map.transform_point(Vec2::new(x, y))).map(|p| [p.x, p.y])
            });
            json!({
                "mode": s.correction.mode.name(), "weight": s.correction.weight, "strokes": strokes,
                "anchors": s.poses, "reason": s.reason,
            })
        });
        Ok(answer(&json!({"revision": revision, "suggestion": suggestion})))
    })
    .await
}

/// `POST /api/crosscheck`: every correction solved by both solvers, and how far they are apart.
pub async fn crosscheck(State(app): State<Arc<App>>) -> Answer {
    aside(app, |app| {
        let working = app.begin("cross-checking the solvers".into());
        let (map, corrections, options) = copy(app, |s| {
            let source = crate::map::SlamMap {
                poses: s.solved().source().poses.clone(),
                human_factors: s.solved().source().human_factors.clone(),
                automatic_factors: s.solved().source().automatic_factors.clone(),
                ..s.solved().corrector().map().clone()
            };
            (source, s.state().corrections.clone(), s.state().settings.options())
        })?;
        let mut progress = |done, of| working.progress(done, of);
        let found = check::run_while(map, &corrections, &options, &mut progress)?;
        if working.is_cancelled() {
            return Err(given_up());
        }
        let checks: Vec<Value> = found
            .corrections
            .iter()
            .map(|c| json!({"id": c.id, "agree": c.agree, "rejected": c.rejected, "totals": c.totals}))
            .collect();
        Ok(answer(&json!({"agree": found.agree, "total": found.total, "corrections": checks})))
    })
    .await
}

/// `POST /api/summary`: the session in numbers, with the inconsistency before and after.
pub async fn summary(State(app): State<Arc<App>>) -> Answer {
    aside(app, |app| {
        let working = app.begin("measuring before and after".into());
        let (summary, before, after) =
            copy(app, |s| (s.summary(), s.solved().source_map(), s.solved().map()))?;
        let options = metrics::InconsistencyOptions::default();
        let measure = |map| metrics::inconsistency(&map, &options).ok().map(|found| found.area_m2);
        let before = measure(before);
        if !working.progress(1, 2) {
            return Err(given_up());
        }
        let after = measure(after);
        if !working.progress(2, 2) {
            return Err(given_up());
        }
        let inconsistency = json!({"before": before, "after": after});
        Ok(answer(&json!({"summary": summary, "inconsistency_m2": inconsistency})))
    })
    .await
}

/// `POST /api/cancel {id}`: gives a work up.
pub async fn cancel(State(app): State<Arc<App>>, body: Bytes) -> Answer {
    let id = object(&body)?.get("id").and_then(Value::as_u64);
    let id = id.ok_or_else(|| Fault::bad("id: expected the number of a work"))?;
    Ok(answer(&json!({"cancelled": app.cancel(id)})))
}
