//! The map itself, binary: points once, poses after every change.

use std::sync::Arc;

use axum::extract::State;
use serde_json::json;

use super::app::App;
use super::wire::{Answer, Fault, aside, packed, pose_bytes};

/// `GET /api/points`: every pose's points, robot frame, f32 x, y; `starts` (u32) as in
/// [`crate::map::Observations::starts`].
pub async fn points(State(app): State<Arc<App>>) -> Answer {
    aside(app, |app| {
        let desk = app.read();
        let desk = desk.as_ref().ok_or_else(Fault::nothing_open)?;
        let observations = &desk.session.solved().corrector().map().observations;
        let mut points = Vec::with_capacity(observations.len() * 8);
        for [x, y] in &observations.points {
            points.extend_from_slice(&(*x as f32).to_le_bytes());
            points.extend_from_slice(&(*y as f32).to_le_bytes());
        }
        let starts: Vec<u8> = observations.starts.iter().flat_map(|s| s.to_le_bytes()).collect();
        let head =
            json!({"map": desk.map, "points": observations.len(), "starts": observations.starts.len()});
        Ok(packed(&head, &[&starts, &points]))
    })
    .await
}

/// `GET /api/poses`: the map as it stands, and as it was before any correction.
pub async fn poses(State(app): State<Arc<App>>) -> Answer {
    aside(app, |app| {
        let desk = app.read();
        let desk = desk.as_ref().ok_or_else(Fault::nothing_open)?;
        let solved = desk.session.solved();
        let now = pose_bytes(&solved.corrector().map().poses, solved.world_from_map());
        let source = pose_bytes(&solved.source().poses, solved.world_from_map());
        let head = json!({"map": desk.map, "revision": desk.revision, "poses": solved.source().poses.len()});
        Ok(packed(&head, &[&now, &source]))
    })
    .await
}

/// `GET /api/factors`: the two poses of every relative factor, u32.
pub async fn factors(State(app): State<Arc<App>>) -> Answer {
    aside(app, |app| {
        let desk = app.read();
        let desk = desk.as_ref().ok_or_else(Fault::nothing_open)?;
        let factors = &desk.session.solved().corrector().map().relative_factors;
        let bytes: Vec<u8> =
            factors.iter().flat_map(|f| [f.i as u32, f.j as u32]).flat_map(u32::to_le_bytes).collect();
        Ok(packed(&json!({"map": desk.map, "factors": factors.len()}), &[&bytes]))
    })
    .await
}
