//! The report of `hitl feetslam run`, field by field as docs/FORMATS-walks.md gives it.

use hitl_slam::geometry::{Segment, Vec2};
use hitl_slam::pedestrian::feetslam::FallBack;
use hitl_slam::pedestrian::metrics;
use hitl_slam::pedestrian::successive::Outcome;
use hitl_slam::pedestrian::{Options, TruthPoint, Walk};
use serde::Serialize;

/// The whole report.
#[derive(Debug, Serialize)]
pub struct Report {
    version: &'static str,
    pub walkers: Vec<Walker>,
    rounds: usize,
    iterations: usize,
    particles: usize,
    particle_steps: u64,
    pub wall_ms: f64,
    pub peak_rss_mb: Option<f64>,
    change: f64,
    map_entropy_bits: f64,
    crossed_wall_ratio: Option<f64>,
    grid_angle_deg: f64,
    fall_back: Option<String>,
    pub settings: Settings,
}

/// What was asked for.
#[derive(Debug, Serialize)]
pub struct Settings {
    pub grid: &'static str,
    seed: u64,
    hex_radius_m: f64,
    alpha: f64,
    gain: f64,
    own_map_in_prior: bool,
    window_m: Option<f64>,
}

/// One walker.
#[derive(Debug, Serialize)]
pub struct Walker {
    pub name: String,
    pub points: Vec<Point>,
    steps: usize,
    length_m: f64,
    takes_part: bool,
    start: [f64; 3],
    resamplings: usize,
    standstills: Vec<Standstill>,
}

/// One line of the truth.
#[derive(Debug, Serialize)]
pub struct Point {
    pub stamp: f64,
    pub error_m: f64,
    pub error_mean_m: f64,
    pub error_pdr_m: f64,
}

/// A recognised pause.
#[derive(Debug, Serialize)]
struct Standstill {
    from_s: f64,
    to_s: f64,
    x_m: f64,
    y_m: f64,
}

impl Report {
    /// Everything but times and memory.
    pub fn new(
        walks: &[Walk],
        outcome: &Outcome,
        truth: &[TruthPoint],
        walls: &[Segment],
        options: &Options,
    ) -> Self {
        let walkers = (0..walks.len()).map(|j| walker(&walks[j], j, outcome, truth)).collect();
        Report {
            version: env!("CARGO_PKG_VERSION"),
            walkers,
            rounds: outcome.rounds,
            iterations: outcome.iterations,
            particles: options.particles,
            particle_steps: outcome.particle_steps,
            wall_ms: 0.0,
            peak_rss_mb: None,
            change: outcome.change,
            map_entropy_bits: metrics::entropy_bits(&outcome.total, options.alpha),
            crossed_wall_ratio: (!walls.is_empty())
                .then(|| metrics::crossed_wall_ratio(&outcome.total, walls)),
            grid_angle_deg: outcome.total.grid.angle_rad.to_degrees(),
            fall_back: outcome.fall_back.map(|why| match why {
                FallBack::NoDirection(r) => format!("no common direction (concentration {r:.2}): regrid"),
                FallBack::Bend(bend) => {
                    let deg = bend.angle_rad.to_degrees();
                    format!("all walkers turn by {deg:.1}° after {:.1} m: regrid", bend.at_m)
                }
            }),
            settings: Settings {
                grid: "",
                seed: options.seed,
                hex_radius_m: options.hex_radius_m,
                alpha: options.alpha,
                gain: options.gain,
                own_map_in_prior: options.own_map_in_prior,
                window_m: options.window_m,
            },
        }
    }

    /// The same numbers for a person.
    pub fn table(&self) -> String {
        let mut text = format!(
            "{} walkers, {} rounds, {} iterations, {} particles: {:.1} M particle-steps in {:.2} s\n",
            self.walkers.len(),
            self.rounds,
            self.iterations,
            self.particles,
            self.particle_steps as f64 / 1e6,
            self.wall_ms / 1e3
        );
        if let Some(why) = &self.fall_back {
            text += &format!("the aligned grid was given up: {why}\n");
        }
        text += &format!("map entropy {:.3} bit", self.map_entropy_bits);
        if let Some(ratio) = self.crossed_wall_ratio {
            text += &format!(", crossings through walls {:.1} %", 100.0 * ratio);
        }
        text += "\n";
        if self.walkers.iter().any(|w| !w.points.is_empty()) {
            text += "walker        last error: best   mean    PDR (m)\n";
        }
        for walker in &self.walkers {
            let mut line = format!("{:<24}", walker.name);
            if let Some(p) = walker.points.last() {
                line += &format!("{:7.2}{:7.2}{:7.2}", p.error_m, p.error_mean_m, p.error_pdr_m);
            }
            line += &format!("   {} steps, {:.1} m", walker.steps, walker.length_m);
            if !walker.takes_part {
                line += ", left out: no shared way found";
            }
            text += &format!("{line}\n");
        }
        text
    }
}

fn walker(walk: &Walk, j: usize, outcome: &Outcome, truth: &[TruthPoint]) -> Walker {
    let (estimate, start) = (&outcome.estimates[j], outcome.starts[j].pose);
    let positions = |poses: &[hitl_slam::geometry::Pose2]| -> Vec<Vec2> {
        poses.iter().map(|p| p.translation()).collect()
    };
    let mean = positions(&estimate.mean);
    let error = |path: &[Vec2]| metrics::errors_m(walk, path, truth);
    let errors = [error(&estimate.best), error(&mean), error(&positions(&walk.track(start)))];
    let stamps = truth.iter().filter(|t| t.walker == walk.name).map(|t| t.stamp_s);
    let points = stamps.enumerate().map(|(k, stamp)| Point {
        stamp,
        error_m: errors[0][k],
        error_mean_m: errors[1][k],
        error_pdr_m: errors[2][k],
    });
    let standstills = walk.standstills().into_iter().map(|s| {
        let p = mean[s.steps_before];
        Standstill { from_s: s.from_s, to_s: s.to_s, x_m: p.x, y_m: p.y }
    });
    Walker {
        name: walk.name.clone(),
        points: points.collect(),
        steps: walk.steps.len(),
        length_m: walk.lengths_m().last().copied().unwrap_or(0.0),
        takes_part: outcome.takes_part[j],
        start: start.to_array(),
        resamplings: estimate.resamplings,
        standstills: standstills.collect(),
    }
}
