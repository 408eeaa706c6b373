//! What the method has to beat: one relative factor per correction, straight from the raw strokes. No EM, no segments,
//! no COP-SLAM; the original odometry is kept, and the solver is the library's own.

use hitl_slam::geometry::{Pose2, Segment, Vec2, wrap_angle};
use hitl_slam::joint::{self, problem::RelativeTerm};
use hitl_slam::map::{Correction, Mode, SlamMap, Stroke};
use hitl_slam::solver::{self, Loss};
use nalgebra::{Matrix3, RowVector3};

use crate::page::Result;

/// σ of a drawn end point across and along its stroke, metres.
const ACROSS_M: f64 = 0.03;
const ALONG_M: f64 = 0.04;

/// The poses after `corrections`, all of them at once, from `map.poses`.
pub fn solve(map: &SlamMap, corrections: &[Correction]) -> Result<Vec<Pose2>> {
    let options = joint::Options::default();
    let mut problem = joint::build(map, &map.poses, &[], &options);
    for correction in corrections {
        problem.relatives.push(factor(map, correction)?);
    }
    // Straight to the solver: a joint problem wants regular information, and these factors leave axes free.
    let mut x = problem.blocks();
    solver::minimize(&problem, &mut x, &problem.held, &options.solver);
    Ok(x.into_iter().take(map.poses.len()).map(Pose2::from_array).collect())
}

/// The pose from which stroke b lies as the mode wants it to a, weighted by how well its two ends say so.
fn factor(map: &SlamMap, correction: &Correction) -> Result<RelativeTerm> {
    let (Stroke::Pose { pose: i, points: a }, Stroke::Pose { pose: j, points: b }) =
        (correction.a, correction.b)
    else {
        return Err("the baseline wants strokes on poses".into());
    };
    let (a, b) = (Segment::from_ends(a[0], a[1]), Segment::from_ends(b[0], b[1]));
    let wanted = if correction.mode == Mode::Perpendicular { std::f64::consts::FRAC_PI_2 } else { 0.0 };
    // A line has no direction: of all turns that make the mode true, the nearest to the map as it stands.
    let now = map.poses[i].between(map.poses[j]).theta_rad;
    let turn = a.direction_rad + wanted - b.direction_rad;
    let theta = now + wrap_angle(2.0 * (turn - now)) / 2.0;
    let at = a.centre - Pose2::new(0.0, 0.0, theta).rotate(b.centre);
    // An error (e, eθ) in the frame of pose j moves the end q of b by e + eθ·(−q_y, q_x).
    let row = |axis: Vec2, q: Vec2, sigma_m: f64| {
        RowVector3::new(axis.x, axis.y, axis.dot(&Vec2::new(-q.y, q.x))) / sigma_m
    };
    let [p, q] = b.ends();
    let across = [p, q].map(|end| row(b.normal(), end, ACROSS_M));
    let u = match correction.mode {
        // Both ends along the wall say the same.
        Mode::Colocation => {
            let along = row(b.direction(), b.centre, ALONG_M / 2.0_f64.sqrt());
            Matrix3::from_rows(&[along, across[0], across[1]])
        }
        Mode::Collinear => Matrix3::from_rows(&[RowVector3::zeros(), across[0], across[1]]),
        Mode::Parallel | Mode::Perpendicular => {
            let heading = 2.0 * b.half_length_m / (2.0_f64.sqrt() * ACROSS_M);
            Matrix3::from_diagonal(&[0.0, 0.0, heading].into())
        }
    };
    let sqrt_information = std::array::from_fn(|k| u[(k / 3, k % 3)]);
    Ok(RelativeTerm { i, j, measured: [at.x, at.y, theta], sqrt_information, loss: Loss::None })
}
