//! Real data made bad on purpose: what breaks maps in practice, at places drawn by a seed.
//!
//! | kind | what happens | what stays |
//! |---|---|---|
//! | kick | 30° of heading are lost in one step, either way | all else |
//! | slip | for 20 m one wheel counts 1.5 % too much, on a wheel base of 0.5 m: 34° and 0.15 m | all else |
//! | blind | for 60 s every beam reads "no return", as in dust, sun or glass: nothing to match, odometry alone | odometry |
//! | drift | the whole odometry bends by 0.2–0.5° a metre and stretches by up to 2 % | ranges |
//! | drop | 60 s of scans are missing; the odometry counts on | all else |
//!
//! A **log** ([`log`]) is damaged in its odometry and ranges; what a map makes of that is the front end's matter: a scan
//! matcher heals a kick where scans overlap. So a **map** ([`map`]) can be damaged as well, which is what a front end
//! leaves that failed: the relative factors between neighbours are wrong, their covariance knows nothing of it, and the poses
//! are chained anew. A map has no raw scans any more: there `blind` and `drop` mean nothing and are refused.

mod place;
mod steps;

use std::fmt;
use std::str::FromStr;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::Serialize;

use crate::error::{Error, Result};
use crate::geometry::Pose2;
use crate::map::{NO_RETURN_M, RawLog, SlamMap};
use place::Drive;

/// Logged poses that differ from the odometry by no more than this everywhere are the odometry: metres and radians.
const SAME_POSE: (f64, f64) = (0.01, 0.01);

/// What goes wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Kind {
    /// A heading failure in one step.
    Kick,
    /// A wheel that slips.
    Slip,
    /// A laser that sees nothing.
    Blind,
    /// An odometry that drifts all the way.
    Drift,
    /// A part of the log that is missing.
    Drop,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Kind; 5] = [Kind::Kick, Kind::Slip, Kind::Blind, Kind::Drift, Kind::Drop];

    /// The name used on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Kick => "kick",
            Kind::Slip => "slip",
            Kind::Blind => "blind",
            Kind::Drift => "drift",
            Kind::Drop => "drop",
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Kind {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        Kind::ALL.into_iter().find(|k| k.name() == name).ok_or_else(|| {
            let names = Kind::ALL.map(Kind::name).join(", ");
            Error::input("kind", format_args!("found \"{name}\", expected one of {names}"))
        })
    }
}

/// What to damage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// What goes wrong.
    pub kind: Kind,
    /// How often, 1 or more; a drift happens once.
    pub count: usize,
    /// Decides where and which way. The same seed and settings give the same damage, to the byte.
    pub seed: u64,
}

/// One damage that was done.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Damage {
    /// What went wrong.
    pub kind: Kind,
    /// Kick, slip, drift: the steps from scan (in a map: pose) `first` on are wrong. Blind, drop: the first scan that is.
    pub first: usize,
    /// Kick, slip, drift: … up to this one. Blind, drop: the last scan that is. Counted in the input.
    pub last: usize,
    /// Stamp of `first`, seconds; `None` in a map without stamps.
    pub from_s: Option<f64>,
    /// Stamp of `last`, seconds.
    pub to_s: Option<f64>,
    /// Way between the two, metres.
    pub path_m: f64,
    /// What was added to the heading in all, degrees.
    pub heading_deg: f64,
    /// What was added to the way in all, metres.
    pub stretch_m: f64,
}

/// A damaged log: the odometry (and the logged poses, where they are only the odometry again), or the scans.
///
/// # Errors
/// [`Error::Input`] for a count out of range, or if the robot drives too little for such damages.
pub fn log(log: &RawLog, settings: &Settings) -> Result<(RawLog, Vec<Damage>)> {
    let drive = Drive {
        poses: log.scans.iter().map(|s| s.odometry_from_robot).collect(),
        stamps_s: Some(log.scans.iter().map(|s| s.stamp_s).collect()),
    };
    let plan = Plan::new("log", &drive, settings)?;
    let mut damaged = log.clone();
    match settings.kind {
        Kind::Kick | Kind::Slip | Kind::Drift => {
            let is_raw = log.scans.iter().all(|s| is_same(s.odometry_from_robot, s.world_from_robot));
            let chained = chained(&drive.poses, &plan.errors);
            for (scan, pose) in damaged.scans.iter_mut().zip(chained) {
                if is_raw && scan.odometry_from_robot != pose {
                    scan.world_from_robot = pose;
                }
                scan.odometry_from_robot = pose;
            }
        }
        Kind::Blind => {
            for scan in plan.damages.iter().flat_map(|d| d.first..=d.last) {
                let scan = &mut damaged.scans[scan];
                let nothing =
                    if scan.max_range_m.is_finite() { scan.max_range_m as f32 } else { NO_RETURN_M };
                scan.ranges_m.fill(nothing);
            }
        }
        Kind::Drop => {
            let mut index = 0;
            damaged.scans.retain(|_| {
                index += 1;
                !plan.damages.iter().any(|d| (d.first..=d.last).contains(&(index - 1)))
            });
        }
    }
    Ok((damaged, plan.damages))
}

/// A damaged map: relative factors between neighbours altered, information left, poses chained anew. Factors between other
/// poses (closures) stay, and so do the points; automatic factors go: they were found on the map as it was.
///
/// # Errors
/// [`Error::Input`] as [`log`]; for a kind that only a log can have; for a map with corrections, which would be about poses
/// that are gone.
pub fn map(map: &SlamMap, settings: &Settings) -> Result<(SlamMap, Vec<Damage>)> {
    if matches!(settings.kind, Kind::Blind | Kind::Drop) {
        let message =
            format!("found {}, expected kick, slip or drift: a map has no raw scans", settings.kind);
        return Err(Error::input("kind", message));
    }
    if !map.human_factors.is_empty() {
        let found = map.human_factors.len();
        return Err(Error::input("map: human factors", format!("found {found}, expected a map without any")));
    }
    let drive = Drive { poses: map.poses.clone(), stamps_s: map.stamps_s.clone() };
    let plan = Plan::new("map", &drive, settings)?;
    let mut damaged = map.clone();
    damaged.automatic_factors.clear();
    damaged.poses = chained(&map.poses, &plan.errors);
    for factor in &mut damaged.relative_factors {
        if factor.j == factor.i + 1 {
            factor.i_from_j = erred(factor.i_from_j, plan.errors[factor.i]);
        } else if factor.i == factor.j + 1 {
            factor.i_from_j = erred(factor.i_from_j.inverse(), plan.errors[factor.j]).inverse();
        }
    }
    Ok((damaged, plan.damages))
}

/// Where it happens and what it does to the steps.
struct Plan {
    damages: Vec<Damage>,
    /// One per step: step as damaged = step · error. `None`: the step is left alone.
    errors: Vec<Option<Pose2>>,
}

impl Plan {
    fn new(place: &str, drive: &Drive, settings: &Settings) -> Result<Plan> {
        if settings.count == 0 {
            return Err(Error::input("count", "found 0, expected 1 or more"));
        }
        if settings.kind == Kind::Drift && settings.count > 1 {
            let message = format!("found {}, expected 1: a drift goes on all the way", settings.count);
            return Err(Error::input("count", message));
        }
        let mut random = ChaCha8Rng::seed_from_u64(settings.seed);
        random.set_stream(settings.kind as u64);
        let spans = place::choose(place, drive, settings, &mut random)?;
        let mut errors = vec![None; drive.poses.len().saturating_sub(1)];
        let mut damages = Vec::with_capacity(spans.len());
        for (first, last) in spans {
            let (heading_deg, stretch_m) =
                steps::spoil(settings.kind, &drive.poses, first..last, &mut errors, &mut random);
            let stamp = |k: usize| drive.stamps_s.as_ref().map(|s| s[k]);
            damages.push(Damage {
                kind: settings.kind,
                first,
                last,
                from_s: stamp(first),
                to_s: stamp(last),
                path_m: drive.path_m(first, last),
                heading_deg,
                stretch_m,
            });
        }
        Ok(Plan { damages, errors })
    }
}

fn erred(step: Pose2, error: Option<Pose2>) -> Pose2 {
    error.map_or(step, |e| step.compose(e))
}

/// The same steps with their errors. Bit for bit the same up to the first error.
fn chained(poses: &[Pose2], errors: &[Option<Pose2>]) -> Vec<Pose2> {
    let Some(first) = errors.iter().position(Option::is_some) else { return poses.to_vec() };
    let mut chained = poses[..=first].to_vec();
    for k in first..errors.len() {
        let step = poses[k].between(poses[k + 1]);
        chained.push(chained[k].compose(erred(step, errors[k])));
    }
    chained
}

fn is_same(a: Pose2, b: Pose2) -> bool {
    let d = a.between(b);
    d.translation().norm() <= SAME_POSE.0 && d.theta_rad.abs() <= SAME_POSE.1
}
