//! TUM trajectories: `stamp x y z qx qy qz qw`, one pose a line; seconds, metres, unit quaternion; `#` comments.
//!
//! A planar pose is yaw only. Tilted poses (3D trajectories) are projected: z, roll and pitch are dropped, with a warning.

use std::io::{self, Write};
use std::path::Path;

use super::source::Lines;
use super::text::{Shortest, row};
use super::{Read, atomic};
use crate::error::Result;
use crate::geometry::Pose2;
use crate::map::Trajectory;

/// Quaternions in files carry few digits; further from unit length than this they are something else.
const UNIT_TOLERANCE: f64 = 1e-2;
/// Sine of the half tilt from which on the projection is worth a word.
const TILT_TOLERANCE: f64 = 1e-3;

const NAMES: [&str; 8] = ["stamp", "x", "y", "z", "qx", "qy", "qz", "qw"];

/// Reads a trajectory.
///
/// # Errors
/// [`crate::error::Error::Input`] with the line, if a line is not eight finite numbers with a unit quaternion.
pub fn read(path: &Path) -> Result<Read<Trajectory>> {
    let mut lines = Lines::open(path)?;
    let mut trajectory = Trajectory::default();
    let mut warnings = Vec::new();
    while lines.advance()? {
        let Some([stamp_s, x_m, y_m, _, qx, qy, qz, qw]) =
            row(lines.line(), &NAMES).map_err(|m| lines.error(m))?
        else {
            continue;
        };
        let norm = (qx * qx + qy * qy + qz * qz + qw * qw).sqrt();
        if (norm - 1.0).abs() > UNIT_TOLERANCE {
            return Err(lines.error(format_args!("quaternion: found length {norm}, expected 1")));
        }
        if qx.hypot(qy) > TILT_TOLERANCE && warnings.is_empty() {
            warnings.push(lines.remark("the poses are tilted: z, roll and pitch are dropped"));
        }
        let yaw_rad = if qx == 0.0 && qy == 0.0 {
            2.0 * qz.atan2(qw)
        } else {
            (2.0 * (qw * qz + qx * qy)).atan2(norm * norm - 2.0 * (qy * qy + qz * qz))
        };
        trajectory.stamps_s.push(stamp_s);
        trajectory.poses.push(Pose2::new(x_m, y_m, yaw_rad));
    }
    warnings.extend(lines.cut_off_remark());
    if trajectory.poses.is_empty() {
        return Err(lines.file_error("found no pose, expected lines `stamp x y z qx qy qz qw`"));
    }
    Ok(Read { value: trajectory, warnings })
}

/// Writes a trajectory.
///
/// # Errors
/// [`crate::error::Error::Io`] if the file cannot be written.
pub fn write(path: &Path, trajectory: &Trajectory) -> Result<()> {
    atomic::write(path, |out| fill(out, trajectory))
}

fn fill(out: &mut dyn Write, trajectory: &Trajectory) -> io::Result<()> {
    for (stamp_s, pose) in trajectory.stamps_s.iter().zip(&trajectory.poses) {
        let (qz, qw) = (pose.theta_rad / 2.0).sin_cos();
        let [stamp, x, y, qz, qw] = [*stamp_s, pose.x_m, pose.y_m, qz, qw].map(Shortest);
        writeln!(out, "{stamp} {x} {y} 0 0 0 {qz} {qw}")?;
    }
    Ok(())
}
