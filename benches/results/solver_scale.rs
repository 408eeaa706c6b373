//! How the solver grows with the map: chains of 1e3 to 1e6 poses, one correction per thousand poses.

use std::f64::consts::TAU;
use std::process::Command;

use hitl_slam::geometry::{Pose2, Scatter, Vec2, wrap_angle};
use hitl_slam::joint::problem::{JointProblem, RelationTerm, RelativeTerm, SightingTerm, TieTerm};
use hitl_slam::joint::{Backend, Memory, Options};
use hitl_slam::map::Mode;
use hitl_slam::render::{Mark, Plot, Series};
use hitl_slam::solver::Loss;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, Normal};

use crate::cpu;
use crate::figures::save;
use crate::page::{Claim, Result, Section};
use crate::stats::Sample;

const LAP: usize = 500;
const SIZES: [usize; 4] = [1_000, 10_000, 100_000, 1_000_000];

/// Laps of 500 poses on a circle; a correction says that a wall seen by ten poses of one lap is the wall that ten poses
/// of the next lap see. Odometry of 1 cm and 1 mrad a step; the start is off by 5 cm and 10 mrad a pose.
pub fn chain(poses: usize, corrections: usize) -> Result<JointProblem> {
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

fn solve(problem: &JointProblem, repetitions: usize) -> Result<Solved> {
    let mut solved = Solved { ms: Sample(Vec::new()), order_ms: f64::INFINITY, steps: 0 };
    for _ in 0..repetitions {
        let mut problem = problem.clone();
        let (report, ms) = cpu::timed(|| Backend::Rust.solve(&mut problem, &Options::default()));
        let report = report?;
        solved.ms.0.push(ms);
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

/// Solves one size in a process of its own and prints what it took: so that memory is that of this size alone.
pub fn one_size(poses: usize) -> Result<()> {
    let solved = solve(&chain(poses, poses / 1000)?, (100_000 / poses).clamp(3, 20))?;
    let times: Vec<String> = solved.ms.0.iter().map(f64::to_string).collect();
    println!("{} {} {} {}", solved.order_ms, solved.steps, peak_mb(), times.join(" "));
    Ok(())
}

/// [`one_size`] in a child process: times, ordering, steps, peak MB.
fn in_a_child(poses: usize) -> Result<(Solved, f64)> {
    let child =
        Command::new(std::env::current_exe()?).args(["--bench", &format!("--size={poses}")]).output()?;
    let text = String::from_utf8_lossy(&child.stdout);
    let numbers = text.split_whitespace().map(str::parse).collect::<std::result::Result<Vec<f64>, _>>()?;
    match numbers[..] {
        [order_ms, steps, peak, ref times @ ..] if !times.is_empty() => {
            Ok((Solved { ms: Sample(times.to_vec()), order_ms, steps: steps as usize }, peak))
        }
        _ => Err(format!("{poses} poses: {}", String::from_utf8_lossy(&child.stderr)).into()),
    }
}

/// Corrections one after the other on a chain of 100,000 poses, in the memory of the first: CPU time of each, ms.
fn warm() -> Result<Sample> {
    let problem = chain(100_000, 1)?;
    let memory = Memory::default();
    let mut ms = Vec::new();
    for _ in 0..6 {
        let mut problem = problem.clone();
        let (report, time) =
            cpu::timed(|| Backend::Rust.solve_in(&memory, &mut problem, &Options::default()));
        report?;
        ms.push(time);
    }
    Ok(Sample(ms.split_off(1)))
}

pub fn section() -> Result<Section> {
    let mut body = String::from(
        "Chains of laps of 500 poses (`solver_scale.rs`), one correction per thousand poses, started 5 cm off everywhere; validation, ordering, all \
         iterations and the last digits included, one thread, CPU time, ms: median (smallest–largest). Each size in a process of its own; memory: its peak, the \
         problem and one copy of it included.\n\n\
         | poses | corrections | ours | of which ordering | steps | µs a pose | memory | bytes a pose |\n|---|---|---|---|---|---|---|---|\n",
    );
    let mut per_pose_us = Vec::new();
    let (mut times, mut intervals, mut memory) = (Vec::new(), Vec::new(), Vec::new());
    for poses in SIZES {
        let (solved, peak) = in_a_child(poses)?;
        let n = poses as f64;
        per_pose_us.push(solved.ms.smallest() * 1e3 / n);
        times.push([n, solved.ms.median()]);
        intervals.push([solved.ms.smallest(), solved.ms.largest()]);
        memory.push([n, peak]);
        body += &format!(
            "| {poses} | {} | {} | {:.1} | {} | {:.2} | {peak:.0} MB | {:.0} |\n",
            poses / 1000,
            solved.ms.with_range(1),
            solved.order_ms,
            solved.steps,
            solved.ms.smallest() * 1e3 / n,
            peak * 1e6 / n,
        );
    }
    let series =
        |label: &str, points, intervals| Series { label: label.into(), points, intervals, mark: Mark::Line };
    let plot = Plot {
        title: "Growth with the number of poses, one correction per thousand".into(),
        x_label: "poses".into(),
        y_label: "ms of CPU time; MB".into(),
        log_x: true,
        log_y: true,
        series: vec![series("time, ms", times, intervals), series("peak memory, MB", memory, vec![])],
        size_px: (1000, 560),
        ..Plot::default()
    };
    body += "\n";
    body += &save("solver-growth.png", "time and memory from 1e3 to 1e6 poses", &plot.draw())?;
    let first = solve(&chain(100_000, 1)?, 5)?;
    let warm = warm()?;
    body += &format!(
        "\nA single correction on 100000 poses, CPU time: {} ms, {} steps; the next ones in the same session, whose memory is there already: {} ms. What of it is reused when only a \
         weight changes: see Corrections reweighted.\n",
        first.ms.with_range(1),
        first.steps,
        warm.with_range(1),
    );
    let growth = per_pose_us[3] / per_pose_us[1];
    let claim = |what: &str, measured, bound, unit, why| Claim {
        what: what.into(),
        measured,
        bound,
        unit,
        decimals: 1,
        why,
    };
    let claims = vec![
        claim("time a pose, 1e6 poses over 1e4 poses", growth, 3.0, "", "close to linear"),
        claim(
            "100,000 poses: CPU time of one correction's optimisation in a session (median)",
            warm.median(),
            60.0,
            "ms",
            "issue",
        ),
    ];
    Ok(Section { title: "Growth of the solver", name: "solver-scale", body, claims })
}
