//! The report of `hitl feetslam run`, field by field as docs/FORMATS-walks.md gives it.

use hitl_slam::geometry::{Segment, Vec2};
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
    map_precision: Option<f64>,
    map_recall: Option<f64>,
    grid_angle_deg: f64,
    fall_back: Option<String>,
    pub settings: Settings,
}

/// What was asked for.
#[derive(Debug, Serialize)]
pub struct Settings {
    pub grid: &'static str,
    seed: u64,
    islands: usize,
    hex_radius_m: f64,
    alpha: f64,
    norm: String,
    gain: f64,
    gain_schedule: String,
    converged_below: f64,
    own_map_in_prior: bool,
    window_m: Option<f64>,
    start_sigma_m: f64,
    start_heading_sigma_deg: f64,
    heading_noise_deg: f64,
    drift_deg: f64,
}

/// One walker.
#[derive(Debug, Serialize)]
pub struct Walker {
    pub name: String,
    pub points: Vec<Point>,
    steps: usize,
    length_m: f64,
    takes_part: bool,
    /// With `--align`: what speaks for its place, and for the next best one, as shares of what a perfect fit would have.
    support: Option<f64>,
    rival: Option<f64>,
    start: [f64; 3],
    scale: f64,
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
        let ways: Vec<Vec<Vec2>> = walks.iter().flat_map(|walk| metrics::true_ways(walk, truth)).collect();
        let coverage = (!ways.is_empty())
            .then(|| metrics::coverage(&outcome.total, &ways, metrics::NEAR_A_WAY_M, metrics::A_WAY));
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
            map_precision: coverage.map(|c| c.precision),
            map_recall: coverage.map(|c| c.recall),
            grid_angle_deg: outcome.total.grid.angle_rad.to_degrees(),
            fall_back: outcome.fall_back.map(|why| format!("{why}: regrid")),
            settings: Settings {
                grid: "",
                seed: options.seed,
                islands: options.islands,
                hex_radius_m: options.hex_radius_m,
                alpha: options.alpha,
                norm: format!("{:?}", options.norm).to_lowercase(),
                gain: options.gain,
                gain_schedule: format!("{:?}", options.gain_schedule).to_lowercase(),
                converged_below: options.converged_below,
                own_map_in_prior: options.own_map_in_prior,
                window_m: options.window_m,
                start_sigma_m: outcome.starts[0].position_sigma_m,
                start_heading_sigma_deg: outcome.starts[0].heading_sigma_rad.to_degrees(),
                heading_noise_deg: options.noise.heading_rad.to_degrees(),
                drift_deg: options.noise.drift_start_rad.to_degrees(),
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
        if let (Some(precision), Some(recall)) = (self.map_precision, self.map_recall) {
            text +=
                &format!(", on true ways {:.1} %, of them found {:.1} %", 100.0 * precision, 100.0 * recall);
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
            let place = walker.support.zip(walker.rival);
            let place = place.map_or(String::new(), |(s, r)| format!(" (support {s:.2}, rival {r:.2})"));
            if !walker.takes_part {
                line += &format!(", left out: no shared way found{place}");
            } else if !place.is_empty() && walker.name != self.walkers[0].name {
                line += &format!(", placed by its map{place}");
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
    let errors = [
        error(&estimate.best),
        error(&mean),
        error(&positions(&walk.scaled(outcome.scales[j]).track(start))),
    ];
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
        support: outcome.evidence.as_ref().map(|e| e[j][0]),
        rival: outcome.evidence.as_ref().map(|e| e[j][1]),
        start: start.to_array(),
        scale: outcome.scales[j],
        resamplings: estimate.resamplings,
        standstills: standstills.collect(),
    }
}
