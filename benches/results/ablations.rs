//! What each part of the method is worth: the paper's claims, one at a time, over the four kinds of map and the loop.

use std::time::Instant;

use hitl_slam::geometry::Information;
use hitl_slam::interpret;
use hitl_slam::joint;
use hitl_slam::map::{RelativeFactor, SlamMap};
use hitl_slam::pipeline::{Corrector, Options};
use hitl_slam::simulate::{Scenario, Simulation};
use nalgebra::Matrix3;

use crate::page::{Result, Section};
use crate::stats::Sample;
use crate::table1;
use crate::{figures, runs};

const SEEDS: u64 = 20;
const NOISE_M: f64 = 0.02;
/// Tried in the sweep of drawing noise, metres.
const NOISES_M: [f64; 7] = [0.0, 0.02, 0.04, 0.06, 0.08, 0.11, 0.15];

pub fn section() -> Result<Section> {
    let body = [variants()?, naive()?, noise()?].concat();
    Ok(Section { title: "Ablations", name: "ablations", body, claims: Vec::new() })
}

/// How a map is corrected.
#[derive(Clone, Copy)]
enum Method {
    Pipeline(Options),
    /// Stages 1 to 4 alone: nothing is optimised, older corrections are not kept.
    CopSlamAlone,
    /// The same with off-diagonal covariances dropped.
    Diagonal,
}

fn methods() -> Vec<(&'static str, Method)> {
    let default = Options::default();
    let with = |interpret: interpret::Options| Method::Pipeline(Options { interpret, ..default });
    let i = default.interpret;
    vec![
        ("**default**", Method::Pipeline(default)),
        ("without EM: strokes as drawn", with(interpret::Options { max_rounds: 0, ..i })),
        ("EM stopped after one round", with(interpret::Options { max_rounds: 1, ..i })),
        ("no explicit step, no COP-SLAM", Method::Pipeline(Options { initial_guess: false, ..default })),
        ("COP-SLAM alone, nothing optimised", Method::CopSlamAlone),
        ("diagonal covariances", Method::Diagonal),
        ("σ 0.02 m", with(interpret::Options { drawing_sigma_m: 0.02, ..i })),
        ("σ 0.10 m", with(interpret::Options { drawing_sigma_m: 0.1, ..i })),
        ("σ 0.15 m", with(interpret::Options { drawing_sigma_m: 0.15, ..i })),
        ("T_p 3", with(interpret::Options { min_points: Some(3), ..i })),
        ("T_p 6 (paper)", with(interpret::Options { min_points: Some(6), ..i })),
        ("T_p 12", with(interpret::Options { min_points: Some(12), ..i })),
        ("T_p 24", with(interpret::Options { min_points: Some(24), ..i })),
    ]
}

/// ATE in metres, mean angle and distance error, and how many solves did not converge or were rejected.
struct Outcome {
    ate_m: f64,
    angle_deg: f64,
    distance_m: f64,
    rejected: usize,
    unconverged: usize,
}

fn outcome(s: &Simulation, method: Method) -> Result<Outcome> {
    let (mut rejected, mut unconverged) = (0, 0);
    let map = match method {
        Method::Pipeline(options) => {
            let (map, reports) = runs::corrected(&s.map, &s.corrections, options)?;
            rejected = reports.iter().filter(|r| !r.accepted()).count();
            let solves = reports.iter().filter_map(|r| r.solve.as_ref());
            unconverged = solves.filter(|s| !s.termination.converged()).count();
            map
        }
        Method::Diagonal => {
            let mut map = s.map.clone();
            for factor in &mut map.relative_factors {
                let variances = factor.information.covariance().diagonal();
                factor.information = Information::from_covariance(Matrix3::from_diagonal(&variances))?;
            }
            runs::corrected(&map, &s.corrections, Options::default())?.0
        }
        Method::CopSlamAlone => {
            let mut map = s.map.clone();
            for correction in &s.corrections {
                let corrector = Corrector::new(map.clone(), Options::default())?;
                match corrector.prepare(correction)? {
                    Ok(prepared) => map.poses = prepared.poses,
                    Err(_) => rejected += 1,
                }
            }
            map
        }
    };
    let walls = table1::walls(s, &map);
    Ok(Outcome {
        ate_m: runs::ate_m(&map.poses, &s.truth),
        angle_deg: walls.angle_mean_deg.unwrap_or(f64::NAN),
        distance_m: walls.distance_mean_m.unwrap_or(f64::NAN),
        rejected,
        unconverged,
    })
}

const MAPS: [Scenario; 5] =
    [Scenario::Loop, Scenario::LostPoses, Scenario::OfficeBent, Scenario::OfficeKick, Scenario::Campus];

fn variants() -> Result<String> {
    let seeds: Vec<u64> = (1..=SEEDS).collect();
    let methods = methods();
    let mut rows: Vec<String> = methods.iter().map(|(name, _)| format!("| {name} |")).collect();
    let mut failures = vec![[0, 0]; methods.len()];
    for scenario in MAPS {
        let all = runs::parallel(&seeds, |&seed| {
            let s = runs::simulated(scenario, seed, NOISE_M)?;
            methods.iter().map(|(_, method)| outcome(&s, *method)).collect::<Result<Vec<_>>>()
        })?;
        for (m, row) in rows.iter_mut().enumerate() {
            let sample = |value: fn(&Outcome) -> f64| Sample::of(all.iter().map(|seed| value(&seed[m])));
            *row += &format!(
                " {}, {:.2}°, {:.3} |",
                sample(|o| o.ate_m).with_interval(3),
                sample(|o| o.angle_deg).mean(),
                sample(|o| o.distance_m).mean()
            );
            for seed in &all {
                failures[m][0] += seed[m].rejected;
                failures[m][1] += seed[m].unconverged;
            }
        }
    }
    let mut text = format!(
        "Seeds 1–{SEEDS}, 2 cm of drawing noise, all corrections: ATE in m ± 95 % interval, then Table 1's mean errors of angle and distance (m). \
         Last: corrections rejected and solves not converged, all maps and seeds.\n\n| | {} | rejected, not converged |\n|---|{}---|\n",
        MAPS.map(Scenario::name).join(" | "),
        "---|".repeat(MAPS.len())
    );
    for (row, [rejected, unconverged]) in rows.iter().zip(failures) {
        text += &format!("{row} {rejected}, {unconverged} |\n");
    }
    Ok(text + "\n")
}

/// The (m + n)² scheme: every correction becomes a relative factor between every two poses of X_a ∪ X_b.
fn naive() -> Result<String> {
    let mut text = String::from(
        "**Number of factors and time**, seed 1: ours has one residual block per pose and feature, and one relation per correction; the naive scheme \
         that the paper names puts a relative factor between every two of the m + n poses of a correction. Last solve with all corrections, \
         one thread.\n\n| map | poses, strokes | ours: human terms | ms | naive: factors Σ(m+n)² | ms |\n|---|---|---|---|---|---|\n",
    );
    for scenario in MAPS {
        let s = runs::simulated(scenario, 1, NOISE_M)?;
        let (map, _) = runs::corrected(&s.map, &s.corrections, Options::default())?;
        let timed = |map: &SlamMap| -> Result<(usize, f64)> {
            let (mut poses, mut factors) = (s.map.poses.clone(), map.human_factors.clone());
            let options = joint::Options::default();
            let problem = joint::build(map, &poses, &factors, &options);
            let terms = problem.sightings.len() + problem.ties.len() + problem.relations.len();
            let start = Instant::now();
            joint::optimize(map, &mut poses, &mut factors, &options)?;
            Ok((terms, 1e3 * start.elapsed().as_secs_f64()))
        };
        let (terms, ours_ms) = timed(&map)?;
        let mut naive = map.clone();
        for factor in std::mem::take(&mut naive.human_factors) {
            let seen = factor.a.sightings.iter().chain(&factor.b.sightings).map(|s| s.pose);
            let poses: std::collections::BTreeSet<usize> = seen.collect();
            for &i in &poses {
                for &j in poses.iter().filter(|&&j| j != i) {
                    let i_from_j = map.poses[i].between(map.poses[j]);
                    let information = Information::from_sigmas(0.05, 0.05, 0.02);
                    naive.relative_factors.push(RelativeFactor { i, j, i_from_j, information });
                }
            }
        }
        let added = naive.relative_factors.len() - map.relative_factors.len();
        let (_, naive_ms) = timed(&naive)?;
        text += &format!(
            "| {scenario} | {}, {} | {terms} | {ours_ms:.1} | {added} | {naive_ms:.1} |\n",
            map.poses.len(),
            s.corrections.len()
        );
    }
    Ok(text + "\n")
}

fn noise() -> Result<String> {
    let seeds: Vec<u64> = (1..=SEEDS).collect();
    let mut text = format!(
        "**Drawing noise** swept, seeds 1–{SEEDS}: ATE in m ± 95 % interval (corrections rejected in all). σ is 0.05 m throughout.\n\n| noise (cm) | {} |\n|---|{}\n",
        MAPS.map(Scenario::name).join(" | "),
        "---|".repeat(MAPS.len())
    );
    let mut curves: Vec<(Scenario, Vec<Sample>)> = MAPS.iter().map(|&s| (s, Vec::new())).collect();
    let default = Options::default();
    let as_drawn =
        Options { interpret: interpret::Options { max_rounds: 0, ..default.interpret }, ..default };
    for noise_m in NOISES_M {
        let mut rows = [format!("| {:.0} |", 100.0 * noise_m), "| … without EM |".to_owned()];
        for (scenario, curve) in &mut curves {
            let all = runs::parallel(&seeds, |&seed| {
                let s = runs::simulated(*scenario, seed, noise_m)?;
                Ok([outcome(&s, Method::Pipeline(default))?, outcome(&s, Method::Pipeline(as_drawn))?])
            })?;
            for (k, row) in rows.iter_mut().enumerate() {
                let sample = Sample::of(all.iter().map(|o| o[k].ate_m));
                let rejected: usize = all.iter().map(|o| o[k].rejected).sum();
                *row += &format!(" {} ({rejected}) |", sample.with_interval(3));
                if k == 0 {
                    curve.push(sample);
                }
            }
        }
        text += &(rows.join("\n") + "\n");
    }
    Ok(text + &figures::noise_plot(&NOISES_M, &curves)?)
}
