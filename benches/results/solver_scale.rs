//! How the solver grows with the map: chains of 1e3 to 1e6 poses, one correction per thousand poses.

use std::f64::consts::TAU;
use std::time::Instant;

use hitl_slam::geometry::{Pose2, Scatter, Vec2, wrap_angle};
use hitl_slam::io;
use hitl_slam::joint::problem::{JointProblem, RelationTerm, RelativeTerm, SightingTerm, TieTerm};
use hitl_slam::joint::{Backend, GrowingGraph, Options};
use hitl_slam::map::Mode;
use hitl_slam::solver::Loss;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, Normal};

use crate::page::{Claim, Result, Section, project};
use crate::stats::Sample;

const LAP: usize = 500;
const SIZES: [usize; 4] = [1_000, 10_000, 100_000, 1_000_000];

/// Laps of 500 poses on a circle; a correction says that a wall seen by ten poses of one lap is the wall that ten poses
/// of the next lap see. Odometry of 1 cm and 1 mrad a step; the start is off by 5 cm and 10 mrad a pose.
fn chain(poses: usize, corrections: usize) -> Result<JointProblem> {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let unit = Normal::new(0.0, 1.0)?;
    let mut noise = |sigma: f64| sigma * unit.sample(&mut random);
    let truth: Vec<Pose2> = (0..poses)
        .map(|i| {
            let around = TAU * (i % LAP) as f64 / LAP as f64;
            Pose2::new(40.0 * around.cos(), 40.0 * around.sin(), wrap_angle(around + TAU / 4.0))
        })
        .collect();
    let mut problem = JointProblem { held: vec![0], ..JointProblem::default() };
    problem.poses =
        truth.iter().map(|t| [t.x_m + noise(0.05), t.y_m + noise(0.05), t.theta_rad + noise(0.01)]).collect();
    problem.poses[0] = truth[0].to_array();
    for j in 1..poses {
        let [x, y, theta] = truth[j - 1].between(truth[j]).to_array();
        problem.relatives.push(RelativeTerm {
            i: j - 1,
            j,
            measured: [x + noise(0.01), y + noise(0.01), theta + noise(0.001)],
            sqrt_information: [100.0, 0.0, 0.0, 0.0, 100.0, 0.0, 0.0, 0.0, 1000.0],
            loss: Loss::None,
        });
    }
    for c in 0..corrections {
        let at = (c * (poses - LAP - 20) / corrections.max(1)) + 5;
        let wall = truth[at + 5].compose(Pose2::new(0.0, 3.0, 0.0));
        for first in [at, at + LAP] {
            let segment = problem.segments.len();
            problem.segments.push([wall.x_m + noise(0.05), wall.y_m + noise(0.05), wall.theta_rad]);
            for (pose, world_from_robot) in truth.iter().enumerate().skip(first).take(10) {
                let robot_from_wall = world_from_robot.between(wall);
                let points = (0..20).map(|k| Vec2::new(0.1 * f64::from(k) - 1.0, 0.01 * f64::from(k % 3)));
                let scatter = Scatter::of(points.map(|p| robot_from_wall.transform_point(p)));
                let along = wall.inverse().transform_point(world_from_robot.transform_point(scatter.mean)).x;
                let (mean, count) = (scatter.mean.into(), scatter.count as f64);
                let scatter_root = scatter.root;
                problem.sightings.push(SightingTerm {
                    pose,
                    segment,
                    mean,
                    scatter_root,
                    count,
                    scale: 20.0,
                });
                problem.ties.push(TieTerm { pose, segment, mean, along, scale: 6.0 });
            }
        }
        let (a, b) = (2 * c, 2 * c + 1);
        let mode = if c % 2 == 0 { Mode::Colocation } else { Mode::Collinear };
        problem.relations.push(RelationTerm {
            mode,
            a,
            b,
            offset_scale: 50.0,
            angle_scale: 100.0,
            loss: Loss::None,
        });
    }
    Ok(problem)
}

struct Solved {
    ms: Sample,
    order_ms: f64,
    steps: usize,
}

fn solve(problem: &JointProblem, backend: Backend, repetitions: usize) -> Result<Solved> {
    let mut solved = Solved { ms: Sample(Vec::new()), order_ms: f64::INFINITY, steps: 0 };
    for _ in 0..repetitions {
        let mut problem = problem.clone();
        let start = Instant::now();
        let report = backend.solve(&mut problem, &Options::default())?;
        solved.ms.0.push(start.elapsed().as_secs_f64() * 1e3);
        if !report.termination.converged() {
            return Err(format!("{} poses: {:?}", problem.poses.len(), report.termination).into());
        }
        solved.order_ms = solved.order_ms.min(report.timings.order_ms);
        solved.steps = report.iterations.len() + report.polish.steps;
    }
    Ok(solved)
}

/// VmHWM of this process, MB.
fn peak_mb() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"));
    let kib = line.and_then(|v| v.trim().trim_end_matches(" kB").trim().parse::<f64>().ok());
    kib.map_or(f64::NAN, |kib| kib * 1024.0 / 1e6)
}

/// Public graphs fed pose by pose, every pose with the factors that end in it.
fn grown() -> Result<String> {
    let mut rows = String::new();
    for name in ["INTEL", "M3500", "city10000"] {
        let path = project(&format!("../shared/data/g2o_2d/{name}.g2o.xz"));
        if !path.exists() {
            continue;
        }
        let map = io::g2o::read(&path)?.value;
        let mut arriving = vec![Vec::new(); map.poses.len()];
        for f in &map.relative_factors {
            arriving[f.i.max(f.j)].push(*f);
        }
        let mut graph = GrowingGraph::new(map.poses[0]);
        let mut ms = Vec::with_capacity(arriving.len());
        for factors in &arriving[1..] {
            let start = Instant::now();
            graph.add(factors)?;
            ms.push(start.elapsed().as_secs_f64() * 1e3);
        }
        let start = Instant::now();
        let (settled, _) = graph.settled(&Options::default().solver);
        let settle_ms = start.elapsed().as_secs_f64() * 1e3;
        let chi2 = |poses: &[Pose2]| -> f64 {
            map.relative_factors.iter().map(|f| f.chi2(poses[f.i], poses[f.j])).sum()
        };
        let total_s = ms.iter().sum::<f64>() / 1e3;
        ms.sort_by(f64::total_cmp);
        rows += &format!(
            "| {name} | {total_s:.2} | {:.3} | {:.2} | {:.1} | {:.3} | {:.6} | {settle_ms:.1} |\n",
            ms[ms.len() / 2],
            ms[ms.len() * 99 / 100],
            ms[ms.len() - 1],
            chi2(&graph.poses()),
            chi2(&settled),
        );
    }
    if rows.is_empty() {
        return Ok("\nPose by pose: not measured, the public graphs are not there.\n".into());
    }
    Ok(format!(
        "\nPublic graphs grown pose by pose (`joint::GrowingGraph`), an update of the estimate after each; wall clock on a shared machine. \
         `settled`: the batch solver from the last estimate.\n\n\
         | graph | total, s | median, ms | p99, ms | largest, ms | χ² of the last estimate | χ² settled | settling, ms |\n\
         |---|---|---|---|---|---|---|---|\n{rows}"
    ))
}

pub fn section() -> Result<Section> {
    let mut body = String::from(
        "Chains of laps of 500 poses (`solver_scale.rs`), one correction per thousand poses, started 5 cm off everywhere; validation, ordering, all \
         iterations and the last digits included, one thread, ms: median (smallest–largest). Memory: peak of the measuring process so far, the \
         problem included.\n\n\
         | poses | corrections | ours | of which ordering | steps | µs a pose | memory |\n|---|---|---|---|---|---|---|\n",
    );
    let mut per_pose_us = Vec::new();
    for poses in SIZES {
        let problem = chain(poses, poses / 1000)?;
        let solved = solve(&problem, Backend::Rust, (100_000 / poses).clamp(1, 20))?;
        per_pose_us.push(solved.ms.smallest() * 1e3 / poses as f64);
        body += &format!(
            "| {poses} | {} | {} | {:.1} | {} | {:.2} | {:.0} MB |\n",
            poses / 1000,
            solved.ms.with_range(1),
            solved.order_ms,
            solved.steps,
            solved.ms.smallest() * 1e3 / poses as f64,
            peak_mb(),
        );
    }
    let single = solve(&chain(100_000, 1)?, Backend::Rust, 5)?;
    body += &format!(
        "\nA single correction on 100000 poses: {} ms, {} steps.\n",
        single.ms.with_range(1),
        single.steps
    );
    body += &grown()?;
    let growth = per_pose_us[3] / per_pose_us[1];
    let claims = vec![Claim {
        what: "time a pose, 1e6 poses over 1e4 poses".into(),
        measured: growth,
        bound: 3.0,
        unit: "",
        decimals: 1,
        why: "close to linear",
    }];
    Ok(Section { title: "Growth of the solver", name: "solver-scale", body, claims })
}
