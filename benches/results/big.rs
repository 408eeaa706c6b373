//! Large inputs: 5,000 poses with two million points, and 74 MB of the released implementation's text.

use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

use hitl_slam::geometry::{Pose2, Vec2};
use hitl_slam::io;
use hitl_slam::map::{Correction, Observations, SlamMap, Stroke};
use hitl_slam::simulate::drift::Drift;
use hitl_slam::simulate::lidar::Lidar;
use hitl_slam::simulate::world::World;
use hitl_slam::simulate::{Scenario, Simulation};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use crate::child::{self, Scratch};
use crate::page::{Claim, Result, Section};
use crate::runs;
use crate::stats::Sample;

const POSES: usize = 5_000;
const POINTS: f64 = 2e6;
const TEXT_MB: f64 = 74.0;

/// The campus of seed 1 driven again with 5,000 poses on its way and a laser of as many beams as give two million
/// returns. A stroke keeps its place in the world as its robot saw it, from the new pose next to its own.
pub fn map() -> Result<Simulation> {
    dense(POSES, POINTS)
}

/// The same with so many poses and returns.
pub fn dense(poses_wanted: usize, points_wanted: f64) -> Result<Simulation> {
    let s = runs::simulated(Scenario::Campus, 1, 0.02)?;
    let (old, new) = (s.truth.len() - 1, poses_wanted - 1);
    let truth: Vec<Pose2> = (0..poses_wanted)
        .map(|k| {
            let at = (k * old) as f64 / new as f64;
            let before = (at as usize).min(old - 1);
            s.truth[before].interpolate(s.truth[before + 1], at - before as f64)
        })
        .collect();
    let world = World::new(s.walls.clone());
    let mut lidar = Lidar::half_circle(12.0);
    let returns_per_beam = s.map.observations.len() as f64 / (s.truth.len() * lidar.beams) as f64;
    lidar.beams = (1.002 * points_wanted / poses_wanted as f64 / returns_per_beam).ceil() as usize;
    let (mut observations, mut seen) = (Observations::default(), Vec::new());
    let mut random = ChaCha8Rng::seed_from_u64(1);
    for &pose in &truth {
        lidar.scan(&world, pose, 0.01, &mut random, &mut observations, &mut seen);
    }
    let relative_factors = Drift::scan_matched([10.0, 12.5], 4e-4).measure(&truth, &mut random)?;
    let mut poses = vec![truth[0]];
    for (i, factor) in relative_factors.iter().enumerate() {
        poses.push(poses[i].compose(factor.i_from_j));
    }
    let again = |stroke: Stroke| match stroke {
        Stroke::Pose { pose, points } => {
            let near = (pose * new + old / 2) / old;
            let new_from_old = truth[near].between(s.truth[pose]);
            Stroke::Pose { pose: near, points: points.map(|p: Vec2| new_from_old.transform_point(p)) }
        }
        other => other,
    };
    let corrections =
        s.corrections.iter().map(|c| Correction { a: again(c.a), b: again(c.b), ..c.clone() }).collect();
    let map = SlamMap {
        stamps_s: Some((0..poses_wanted).map(|k| k as f64 * 0.3).collect()),
        poses,
        relative_factors,
        observations,
        robot_from_laser: lidar.robot_from_laser,
        ..SlamMap::default()
    };
    Ok(Simulation { map, truth, corrections, walls: s.walls, pairs: s.pairs })
}

pub fn section() -> Result<Section> {
    let scratch = Scratch::new()?;
    let mut section = Section { title: "Large maps", name: "size", ..Section::default() };
    correct_big(&scratch, &mut section)?;
    load_text(&scratch, &mut section)?;
    Ok(section)
}

/// `hitl correct` from file to file.
fn correct_big(scratch: &Scratch, section: &mut Section) -> Result<()> {
    let s = map()?;
    let points = s.map.observations.len() as f64;
    io::write_map(&scratch.path("big.npz"), &s.map)?;
    io::corrections::write(&scratch.path("c.jsonl"), &s.corrections)?;
    let size_mb = std::fs::metadata(scratch.path("big.npz"))?.len() as f64 / 1e6;
    let [input, strokes, output, trajectory] =
        ["big.npz", "c.jsonl", "out.npz", "t.tum"].map(|f| scratch.text(f));
    let arguments = [
        "correct",
        &input,
        "--corrections",
        &strokes,
        "-o",
        &output,
        "--trajectory",
        &trajectory,
        "--strict",
        "--no-reassociate",
    ];
    let runs = (0..3).map(|_| child::hitl(&arguments)).collect::<Result<Vec<_>>>()?;
    let seconds = Sample::of(runs.iter().map(|r| r.seconds));
    let peak_mb = Sample::of(runs.iter().map(|r| r.peak_mb)).largest();
    let corrected = io::native::read(&scratch.path("out.npz"))?.value;
    section.body += &format!(
        "**{POSES} poses, {:.2} M points**: the way, the walls and the strokes of `campus` seed 1, driven again with {POSES} poses and \
         a laser of more beams (`big.rs`). `hitl correct big.npz --corrections c.jsonl -o out.npz --trajectory t.tum --strict --no-reassociate`, {} \
         corrections, {size_mb:.0} MB file, whole process: {} s. ATE {:.2} → {:.3} m. Peak memory (VmHWM) {peak_mb:.0} MB.\n\n",
        points / 1e6,
        s.corrections.len(),
        seconds.with_range(2),
        runs::ate_m(&s.map.poses, &s.truth),
        runs::ate_m(&corrected.poses, &s.truth),
    );
    section.claims.push(Claim {
        what: format!("{POSES} poses, {:.1} M points: peak memory of `hitl correct`", points / 1e6),
        measured: peak_mb,
        bound: 60.0 + 100.0 * points / 1e6,
        unit: "MB",
        decimals: 0,
        why: "60 MB + 100 bytes a point",
    });
    Ok(())
}

/// The large map as `.stfs.covars`, cut to the poses that make 74 MB, with as many digits as released files have.
fn load_text(scratch: &Scratch, section: &mut Section) -> Result<()> {
    let mut map = map()?.map;
    let path = scratch.path("map.stfs.covars");
    let per_pose_mb = {
        let mut few = map.clone();
        cut(&mut few, 200);
        write_short(&path, &few)? / few.poses.len() as f64
    };
    cut(&mut map, (TEXT_MB / per_pose_mb).ceil() as usize);
    let file_mb = write_short(&path, &map)?;
    let mut seconds = Sample(Vec::new());
    for _ in 0..5 {
        let start = Instant::now();
        let read = io::stfs::read(&path)?;
        seconds.0.push(start.elapsed().as_secs_f64());
        let (found, expected) = (&read.value, &map);
        if (found.poses.len(), found.observations.len())
            != (expected.poses.len(), expected.observations.len())
        {
            return Err("the text was not read completely".into());
        }
    }
    section.body += &format!(
        "**`.stfs.covars` text**: the first {} poses of the same map with {} points, six decimals (poses four), {file_mb:.1} MB, read in \
         {} s: {:.0} MB/s from the page cache.\n",
        map.poses.len(),
        map.observations.len(),
        seconds.with_range(3),
        file_mb / seconds.median(),
    );
    section.claims.push(Claim {
        what: format!("{file_mb:.0} MB of `.stfs.covars` text: median time to read"),
        measured: seconds.median(),
        bound: 1.0,
        unit: "s",
        decimals: 2,
        why: "74 MB in 1 s",
    });
    Ok(())
}

/// Writes a map with short numbers; returns the file's size in MB.
fn write_short(path: &Path, map: &SlamMap) -> Result<f64> {
    io::write_map(path, map)?;
    let exact = std::fs::read_to_string(path)?;
    let mut short = String::with_capacity(exact.len() / 2);
    for (number, line) in exact.lines().enumerate() {
        if number < 2 {
            short += line;
            short.push('\n');
            continue;
        }
        for (field, text) in line.split(',').enumerate() {
            let value: f64 = text.parse()?;
            let separator = if field == 15 { '\n' } else { ',' };
            match field {
                0..3 => write!(short, "{value:.4}{separator}")?,
                3..7 => write!(short, "{value:.6}{separator}")?,
                _ => write!(short, "{value:.5e}{separator}")?,
            }
        }
    }
    std::fs::write(path, &short)?;
    Ok(short.len() as f64 / 1e6)
}

/// Keeps the first `poses`.
fn cut(map: &mut SlamMap, poses: usize) {
    let poses = poses.min(map.poses.len());
    map.poses.truncate(poses);
    map.stamps_s.iter_mut().for_each(|s| s.truncate(poses));
    map.relative_factors.retain(|f| f.i.max(f.j) < poses);
    let observations = &mut map.observations;
    observations.starts.truncate(poses + 1);
    let points = observations.starts[poses] as usize;
    observations.points.truncate(points);
    observations.normals.truncate(points);
    observations.ranges_m.truncate(points);
}
