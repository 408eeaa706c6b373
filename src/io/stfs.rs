//! The map format of the released Human-in-the-Loop SLAM, `.stfs.covars` (docs/FORMATS.md).
//!
//! Line 1 a name, line 2 a time stamp, then one line per laser return of 16 comma-separated numbers:
//! `pose_x,pose_y,pose_th, point_x,point_y, normal_x,normal_y, Cxx,Cxy,Cxth, Cyx,Cyy,Cyth, Cthx,Cthy,Cthth`.
//! Metres, radians. Point and normal are in the world frame of the line's pose; the normal is a direction, so only the
//! rotation takes it to the robot frame. A pose begins where (x, y, θ) changes.
//!
//! C is the covariance of one step i → j in world axes. A relative factor's residual is e = Rzᵀ(Rᵢᵀ(tⱼ − tᵢ) − tz): its
//! axes are those of RᵢRz, pose j as measured. The measurement z is the difference of the file's own poses, so
//! RᵢRz = Rⱼ and **Σ = R(−θⱼ) C R(−θⱼ)ᵀ**. The first pose has no step: its C is zero and not used.

use std::io::{self, Write};
use std::path::Path;

use nalgebra::Matrix3;

use super::source::Lines;
use super::text::{Shortest, number};
use super::{Read, atomic};
use crate::error::{Error, Result};
use crate::geometry::{Information, Pose2, Vec2};
use crate::map::{Observations, RelativeFactor, SlamMap};

const FIELDS: [&str; 16] = [
    "pose_x", "pose_y", "pose_th", "point_x", "point_y", "normal_x", "normal_y", "Cxx", "Cxy", "Cxth", "Cyx",
    "Cyy", "Cyth", "Cthx", "Cthy", "Cthth",
];

/// True if a line could be a return of this format.
pub(crate) fn is_return(line: &[u8]) -> bool {
    let mut found = 0;
    line.split(|&b| b == b',').all(|f| {
        found += 1;
        number(f).is_ok()
    }) && found == 16
}

/// Reads a map.
///
/// # Errors
/// [`Error::Input`] with the line: a line that is not 16 finite numbers, or the covariance of a pose other than the
/// first that is not positive definite.
pub fn read(path: &Path) -> Result<Read<SlamMap>> {
    let mut lines = Lines::open(path)?;
    for what in ["a name", "a time stamp"] {
        if !lines.advance()? {
            return Err(lines.error(format_args!("found the end of the file, expected {what}")));
        }
    }
    let mut map = SlamMap::default();
    let mut observations = Observations { starts: vec![0], ..Observations::default() };
    // Consecutive lines share the text of their pose and covariance: parse it once.
    let (mut pose_text, mut covariance_text) = (Vec::new(), Vec::new());
    let mut pose = Pose2::IDENTITY;
    let (mut sin, mut cos) = (0.0, 1.0);
    while lines.advance()? {
        let Some((pose_part, point_part, covariance_part)) = split(lines.line()) else {
            let found = lines.line().split(|&b| b == b',').count();
            return Err(
                lines.error(format_args!("found {found} fields, expected 16 comma-separated numbers"))
            );
        };
        let mut covariance = None;
        if covariance_part != covariance_text {
            covariance = Some(parse::<9>(covariance_part, 7).map_err(|m| lines.error(m))?);
        }
        let mut is_new = false;
        if pose_part != pose_text {
            let next = Pose2::from_array(parse(pose_part, 0).map_err(|m| lines.error(m))?);
            is_new = map.poses.is_empty() || next != pose;
            pose = next;
            pose_text.clear();
            pose_text.extend_from_slice(pose_part);
            (sin, cos) = pose.theta_rad.sin_cos();
        }
        if is_new {
            if let Some(&previous) = map.poses.last() {
                observations.end_pose();
                let values = match covariance {
                    Some(values) => values,
                    None => parse(covariance_part, 7).map_err(|m| lines.error(m))?,
                };
                let information = step_information(&values, pose)
                    .map_err(|m| lines.error(format_args!("covariance of pose {}: {m}", map.poses.len())))?;
                let i = map.poses.len() - 1;
                let i_from_j = previous.between(pose);
                map.relative_factors.push(RelativeFactor { i, j: i + 1, i_from_j, information });
            }
            map.poses.push(pose);
        }
        if covariance.is_some() {
            covariance_text.clear();
            covariance_text.extend_from_slice(covariance_part);
        }
        let [px, py, nx, ny] = parse(point_part, 3).map_err(|m| lines.error(m))?;
        let (dx, dy) = (px - pose.x_m, py - pose.y_m);
        let point = Vec2::new(cos * dx + sin * dy, cos * dy - sin * dx);
        let normal = Vec2::new(cos * nx + sin * ny, cos * ny - sin * nx);
        observations.push(point, normal, point.norm());
    }
    if map.poses.is_empty() {
        return Err(lines.error("found no laser return, expected 16 comma-separated numbers a line"));
    }
    observations.end_pose();
    map.observations = observations;
    map.validate(lines.file())?;
    Ok(Read { value: map, warnings: lines.cut_off_remark().into_iter().collect() })
}

/// The line's pose (3 fields), point and normal (4) and covariance (9); `None` unless it has 16 fields.
fn split(line: &[u8]) -> Option<(&[u8], &[u8], &[u8])> {
    let (mut commas, mut point_at, mut covariance_at) = (0, 0, 0);
    for (at, _) in line.iter().enumerate().filter(|&(_, &b)| b == b',') {
        commas += 1;
        match commas {
            3 => point_at = at,
            7 => covariance_at = at,
            _ => {}
        }
    }
    (commas == 15)
        .then(|| (&line[..point_at], &line[point_at + 1..covariance_at], &line[covariance_at + 1..]))
}

/// `N` comma-separated numbers, of which the first is field `first` of the line.
fn parse<const N: usize>(part: &[u8], first: usize) -> std::result::Result<[f64; N], String> {
    let mut values = [0.0; N];
    for (k, (value, text)) in values.iter_mut().zip(part.split(|&b| b == b',')).enumerate() {
        *value = number(text).map_err(|m| format!("{}: {m}", FIELDS[first + k]))?;
    }
    Ok(values)
}

fn step_information(values: &[f64; 9], pose: Pose2) -> std::result::Result<Information, String> {
    let c = Matrix3::from_row_slice(values);
    if (c - c.transpose()).amax() > 1e-6 * c.amax() {
        return Err("found an asymmetric matrix, expected a symmetric one".into());
    }
    // Rotation leaves the last bit asymmetric; made symmetric here, a file gives back what was written.
    Information::new(Information::from_covariance(c)?.rotated(-pose.theta_rad).matrix())
}

/// Writes the chain and the points of a map; loop closures and human factors have no place in this format.
/// Poses without points have none either: their steps are joined with the next one.
///
/// # Errors
/// [`Error::Input`] if no pose has points or two consecutive poses have no relative factor; [`Error::Io`] if the file cannot be written.
pub fn write(path: &Path, map: &SlamMap) -> Result<()> {
    let steps = steps(path, map)?;
    atomic::write(path, |out| fill(out, map, &steps))
}

/// For every pose the covariance, in world axes, of the motion since the last pose that has points.
fn steps(path: &Path, map: &SlamMap) -> Result<Vec<Matrix3<f64>>> {
    let place = path.display();
    let mut chain = vec![None; map.poses.len()];
    for factor in map.relative_factors.iter().filter(|f| f.j == f.i + 1) {
        chain[factor.j].get_or_insert(factor);
    }
    let mut steps = vec![Matrix3::zeros(); map.poses.len()];
    let mut seen = false;
    let mut sum = Matrix3::zeros();
    for (j, &world_from_j) in map.poses.iter().enumerate() {
        if seen {
            let Some(factor) = chain[j] else {
                let message =
                    format!("found no relative factor from pose {} to {j}, expected a chain", j - 1);
                return Err(Error::input(place, message));
            };
            let lever = world_from_j.translation() - map.poses[j - 1].translation();
            let turn = Matrix3::new(1.0, 0.0, -lever.y, 0.0, 1.0, lever.x, 0.0, 0.0, 1.0);
            let step = factor.information.rotated(world_from_j.theta_rad).covariance();
            sum = turn * sum * turn.transpose() + step;
        }
        if !map.observations.range(j).is_empty() {
            steps[j] = (sum + sum.transpose()) / 2.0;
            sum = Matrix3::zeros();
            seen = true;
        }
    }
    if !seen {
        return Err(Error::input(
            place,
            "found no points in the map, expected some: the format has one line a point",
        ));
    }
    Ok(steps)
}

fn fill(out: &mut dyn Write, map: &SlamMap, steps: &[Matrix3<f64>]) -> io::Result<()> {
    writeln!(out, "hitl-slam")?;
    writeln!(out, "{}", Shortest(map.stamps_s.as_ref().map_or(0.0, |s| s[0])))?;
    for (pose_index, pose) in map.poses.iter().enumerate() {
        let [x, y, theta] = pose.to_array().map(Shortest);
        let head = format!("{x},{y},{theta}");
        let c = steps[pose_index].transpose();
        let tail: String = c.iter().map(|v| format!(",{}", Shortest(*v))).collect();
        for point in map.observations.range(pose_index) {
            let p = pose.transform_point(map.observations.point(point));
            let n = pose.rotate(map.observations.normal(point));
            let [px, py, nx, ny] = [p.x, p.y, n.x, n.y].map(Shortest);
            writeln!(out, "{head},{px},{py},{nx},{ny}{tail}")?;
        }
    }
    Ok(())
}
