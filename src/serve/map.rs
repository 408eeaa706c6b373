//! The map itself, binary: points once, poses after every change.

use std::sync::Arc;

use axum::extract::State;
use serde_json::json;

use super::app::App;
use super::wire::{Answer, Fault, answer, aside, packed, pose_bytes};
use crate::io;
use crate::joint;
use crate::map::AutomaticFactor;

/// `GET /api/points`: every pose's points, robot frame, f32 x, y; `starts` (u32) as in
/// [`crate::map::Observations::starts`]; `walks`: the first pose of every piece of the chain.
pub async fn points(State(app): State<Arc<App>>) -> Answer {
    aside(app, |app| {
        let desk = app.read();
        let desk = desk.as_ref().ok_or_else(Fault::nothing_open)?;
        let map = desk.session.solved().corrector().map();
        let (observations, walks) = (&map.observations, io::walks_of_map::first_poses(map));
        let mut points = Vec::with_capacity(observations.len() * 8);
        for [x, y] in &observations.points {
            points.extend_from_slice(&(*x as f32).to_le_bytes());
            points.extend_from_slice(&(*y as f32).to_le_bytes());
        }
        let starts: Vec<u8> = observations.starts.iter().flat_map(|s| s.to_le_bytes()).collect();
        let head =
            json!({"map": desk.map, "points": observations.len(), "starts": observations.starts.len(), "walks": walks});
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

/// `GET /api/closures`: the automatic factors as the map stands, where visits pass each other unmatched, what was refused.
pub async fn closures(State(app): State<Arc<App>>) -> Answer {
    aside(app, |app| {
        let desk = app.read();
        let desk = desk.as_ref().ok_or_else(Fault::nothing_open)?;
        let (solved, state) = (desk.session.solved(), desk.session.state());
        let map = solved.corrector().map();
        let factor = |a: &AutomaticFactor| {
            let chi2 = a.factor.chi2(map.poses[a.factor.i], map.poses[a.factor.j]);
            json!({
                "name": a.name(), "i": a.factor.i, "j": a.factor.j, "inliers": a.inliers, "chi2": chi2,
                "agrees": !AutomaticFactor { chi2, ..*a }.disagrees(), "weak": a.weak_rad.is_some(),
            })
        };
        let report = solved.matched().map(|m| &m.report);
        Ok(answer(&json!({
            "revision": desk.revision,
            "factors": map.automatic_factors.iter().map(factor).collect::<Vec<_>>(),
            "near_passes": report.map_or(&[][..], |r| &r.near_passes),
            "refused": state.refused.iter().map(|(i, j)| json!({"name": format!("{i}-{j}"), "i": i, "j": j})).collect::<Vec<_>>(),
        })))
    })
    .await
}

/// `GET /api/uncertainty`: how certain every pose's position is, given the first (or the held ones): covariance xx, xy, yy as
/// f32, m², axes of the map as it is shown.
pub async fn uncertainty(State(app): State<Arc<App>>) -> Answer {
    aside(app, |app| {
        let working = app.begin("working out uncertainty".into());
        let (map, options, revision) = {
            let desk = app.read();
            let desk = desk.as_ref().ok_or_else(Fault::nothing_open)?;
            let solved = desk.session.solved();
            (solved.map(), solved.corrector().options().joint, desk.revision)
        };
        let covariances = joint::map_covariances(&map, &options)?;
        drop(working);
        let sigmas: Vec<f64> = covariances.iter().map(joint::position_sigma_m).collect();
        let bytes: Vec<u8> = covariances
            .iter()
            .flat_map(|c| [c[(0, 0)], c[(0, 1)], c[(1, 1)]])
            .flat_map(|v| (v as f32).to_le_bytes())
            .collect();
        let worst = sigmas.iter().copied().fold(0.0, f64::max);
        let head = json!({"revision": revision, "poses": covariances.len(), "worst_sigma_m": worst});
        Ok(packed(&head, &[&bytes]))
    })
    .await
}
