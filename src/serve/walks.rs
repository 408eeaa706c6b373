//! Where the walkers (or the robot) went, scan by scan, for the page's playback; how often they went there, as hexagons;
//! and the walls of a floor plan that lies beside the map.

use std::path::Path;
use std::sync::Arc;

use axum::extract::State;
use serde_json::json;

use super::app::App;
use super::wire::{Answer, Fault, aside, packed};
use crate::error::Result;
use crate::geometry::{Segment, Vec2};
use crate::io;
use crate::pedestrian::hex::HexGrid;
use crate::pedestrian::{Layout, Options, TransitionMap, grid};

/// The floor plan's file, beside the map.
const PLAN: &str = "walls.csv";
/// Larger hexagons are tried up to this, metres.
const LARGEST_RADIUS_M: f64 = 5.0;

/// `GET /api/walks`. Blocks: stamps (f64), parent poses (u32) and offsets from them (f32 x, y) of every scan, walk after
/// walk (`walks`: scans of each); hexagons (f32 centre x, y and crossings); walls (f32 x1, y1, x2, y2).
pub async fn walks(State(app): State<Arc<App>>) -> Answer {
    aside(app, |app| {
        let (map, source, revision, number) = {
            let desk = app.read();
            let desk = desk.as_ref().ok_or_else(Fault::nothing_open)?;
            (desk.session.solved().map(), desk.session.source().path.clone(), desk.revision, desk.map)
        };
        let pieces = io::walks_of_map::pieces(&map);
        let order: Vec<usize> = pieces.iter().flatten().copied().collect();
        let trajectory = map.trajectory();
        let (mut stamps, mut parents, mut offsets) = (Vec::new(), Vec::new(), Vec::new());
        for &k in &order {
            stamps.extend_from_slice(&trajectory.stamps_s[k].to_le_bytes());
            let (parent, offset) = match map.scans.get(k) {
                Some(scan) => (scan.parent, scan.parent_from_robot.translation()),
                None => (k, Vec2::zeros()),
            };
            parents.extend_from_slice(&(parent as u32).to_le_bytes());
            floats(&mut offsets, offset.iter().copied());
        }
        let paths: Vec<Vec<Vec2>> =
            pieces.iter().map(|p| p.iter().map(|&k| trajectory.poses[k].translation()).collect()).collect();
        let hexagons = hexagons(&paths);
        let (mut cells, mut shape) = (Vec::new(), [0.0; 2]);
        if let Some(map) = &hexagons {
            shape = [map.grid.radius_m, map.grid.angle_rad];
            for (cell, crossings) in map.cells() {
                let centre = map.grid.centre(cell);
                floats(&mut cells, [centre.x, centre.y, crossings]);
            }
        }
        let mut plan = Vec::new();
        let (walls, remark) = match walls_beside(&source) {
            Ok(walls) => (walls, None),
            Err(error) => (Vec::new(), Some(error.to_string())),
        };
        for wall in &walls {
            let [a, b] = wall.ends();
            floats(&mut plan, [a.x, a.y, b.x, b.y]);
        }
        let head = json!({
            "map": number, "revision": revision, "scans": order.len(),
            "walks": pieces.iter().map(Vec::len).collect::<Vec<_>>(),
            "hexagons": cells.len() / 12, "hex_radius_m": shape[0], "hex_angle_rad": shape[1],
            "walls": walls.len(), "remark": remark,
        });
        Ok(packed(&head, &[&stamps, &parents, &offsets, &cells, &plan]))
    })
    .await
}

fn floats(bytes: &mut Vec<u8>, values: impl IntoIterator<Item = f64>) {
    values.into_iter().for_each(|v| bytes.extend_from_slice(&(v as f32).to_le_bytes()));
}

/// How often every hexagon was crossed by the paths as they stand, on a grid along them; `None` if they go too far.
fn hexagons(paths: &[Vec<Vec2>]) -> Option<TransitionMap> {
    let origin = *paths.first()?.first()?;
    let direction = grid::group_direction(paths.iter().map(|p| (&p[..], 0.7)));
    let mut grid = HexGrid {
        radius_m: Options::default().hex_radius_m,
        angle_rad: direction.map_or(0.0, |d| d.angle_rad),
        origin,
    };
    let layout = loop {
        match Layout::around(&grid, paths.iter().flatten().copied()) {
            Ok(layout) => break layout,
            Err(_) if grid.radius_m < LARGEST_RADIUS_M => grid.radius_m *= 2.0,
            Err(_) => return None,
        }
    };
    let mut map = TransitionMap::new(grid, layout);
    paths.iter().for_each(|path| map.add_path(path, 1.0));
    Some(map)
}

fn walls_beside(source: &Path) -> Result<Vec<Segment>> {
    let path = source.with_file_name(PLAN);
    if path.is_file() { Ok(io::floor_plan::read(&path)?.value) } else { Ok(Vec::new()) }
}
