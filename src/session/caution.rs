//! What a person should know of a stroke before using it.

use crate::interpret::{self, Caught};
use crate::pipeline::Corrector;

/// A correction wants at least so many times T_p points to be trusted.
const ENOUGH: usize = 3;

/// A warning about what a stroke caught, in the map's own frame; `None`: it looks fine.
pub fn caution(corrector: &Corrector, caught: &Caught) -> Option<String> {
    if caught.points.len() < ENOUGH * corrector.min_points() {
        return Some("few points: draw along more of the wall".into());
    }
    let map = corrector.map();
    let mut pose = 0;
    let across: Vec<f64> = caught
        .points
        .iter()
        .map(|&point| {
            while map.observations.starts[pose + 1] <= point {
                pose += 1;
            }
            let at = map.poses[pose].transform_point(map.observations.point(point as usize));
            caught.fit.segment.along_across(at).1
        })
        .collect();
    if let Some(apart_m) = interpret::two_walls(&across) {
        let centimetres = (100.0 * apart_m).round();
        return Some(format!("two walls, {centimetres} cm apart: draw where only one of them is"));
    }
    (!caught.fit.settled).then(|| "the wall is not clear here: draw along a straight piece".into())
}
