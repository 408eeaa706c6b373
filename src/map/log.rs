//! A raw laser log as recorded: before any pose graph exists.

use crate::geometry::Pose2;

/// What a beam without a return reads where the log does not say, metres: a SICK's own value.
pub const NO_RETURN_M: f32 = 81.83;

/// A recording of one robot with one 2D laser.
#[derive(Debug, Clone, PartialEq)]
pub struct RawLog {
    /// Every scan, in the order of the file. Stamps need not increase.
    pub scans: Vec<LogScan>,
    /// Where the laser sits on the robot.
    pub robot_from_laser: Pose2,
}

/// One sweep of the laser.
#[derive(Debug, Clone, PartialEq)]
pub struct LogScan {
    /// Seconds, the log's clock.
    pub stamp_s: f64,
    /// The robot by its odometry.
    pub odometry_from_robot: Pose2,
    /// The robot by the pose that the log gives for the scan: a SLAM result in corrected logs, else the odometry again.
    pub world_from_robot: Pose2,
    /// Bearing of the first beam in the laser frame, radians, counter-clockwise positive.
    pub first_bearing_rad: f64,
    /// Angle from one beam to the next, radians.
    pub bearing_step_rad: f64,
    /// Readings at or beyond this are "no return"; infinite where the log does not say.
    pub max_range_m: f64,
    /// Range of every beam, metres.
    pub ranges_m: Vec<f32>,
}
