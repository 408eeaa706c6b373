//! Stage 3: the explicit correction A takes P_b to where the mode wants it relative to P_a, rigidly, with no motion
//! along the mode's null space (section "Applying Explicit Human Corrections" of the paper).
//!
//! | mode | rotation | translation |
//! |---|---|---|
//! | colocation | directions equal | centres equal |
//! | collinear | directions equal | onto the line of a, none along it |
//! | parallel | directions equal, about b's own points | none |
//! | perpendicular | directions at 90°, about b's own points | none |

use std::f64::consts::{FRAC_PI_2, PI};

use crate::geometry::{Pose2, Segment, Vec2, wrap_angle};
use crate::map::Mode;

/// Two readings of a line (it has no direction) whose rotations differ by less than this are ambiguous.
pub const AMBIGUITY_RAD: f64 = 10.0 * PI / 180.0;

/// The rotation that the mode asks of b, radians: the smaller of the two that a line without direction allows.
/// `None` where the two are within [`AMBIGUITY_RAD`] of each other in size.
pub fn rotation(mode: Mode, a: &Segment, b: &Segment) -> Option<f64> {
    let wanted = if mode == Mode::Perpendicular { FRAC_PI_2 } else { 0.0 };
    // Modulo π, in [−π/2, π/2].
    let turn = wrap_angle(2.0 * (a.direction_rad + wanted - b.direction_rad)) / 2.0;
    let other_candidate = PI - turn.abs();
    (other_candidate - turn.abs() >= AMBIGUITY_RAD).then_some(turn)
}

/// `corrected_world_from_world`: moves b (and everything after it) to where the mode wants it relative to a.
/// `pivot` is the mean of b's points; rank-deficient modes do not move it along the null space.
/// `None` where the mode is ambiguous at these segments.
pub fn correction(mode: Mode, a: &Segment, b: &Segment, pivot: Vec2) -> Option<Pose2> {
    let turn = rotation(mode, a, b)?;
    let rotated = |p: Vec2| Pose2::new(0.0, 0.0, turn).rotate(p - pivot) + pivot;
    let shift = match mode {
        Mode::Colocation => a.centre - rotated(b.centre),
        Mode::Collinear => a.normal() * a.normal().dot(&(a.centre - rotated(b.centre))),
        Mode::Parallel | Mode::Perpendicular => Vec2::zeros(),
    };
    let translation = rotated(Vec2::zeros()) + shift;
    Some(Pose2::new(translation.x, translation.y, turn))
}
