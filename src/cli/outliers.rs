//! Edges that the rest of a graph contradicts, as flags and as a report.

use hitl_slam::error::{Error, Result};
use hitl_slam::joint::{self, GraphReport, Options};
use hitl_slam::map::SlamMap;
use hitl_slam::solver::{Loss, chi2_quantile_3};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use super::loss::{LossArgs, LossFlag};

/// Steps of the bar.
const BAR_STEPS: f64 = 100.0;
/// As many edges are named on the terminal; the report has them all.
const NAMED: usize = 6;

/// How a graph with wrong edges is handled.
#[derive(Debug, Clone, Copy, clap::Args)]
pub struct Args {
    /// The loss.
    #[command(flatten)]
    pub loss: LossArgs,
    /// Find the edges that contradict the rest by graduated non-convexity, and leave them out.
    #[arg(long, conflicts_with = "loss")]
    pub gnc: bool,
    /// An edge is recognised as wrong where a right one would be in fewer than 1 − P of all cases.
    #[arg(long, value_name = "P", default_value_t = 0.99)]
    pub inlier_probability: f64,
    /// Odometry (edges between neighbours) may be wrong too, not only loop closures.
    #[arg(long)]
    pub doubt_odometry: bool,
}

/// What was found, for the report; only where a loss or `--gnc` asks for it.
#[derive(Serialize)]
pub struct Found {
    method: &'static str,
    loss_scale: Option<f64>,
    inlier_probability: f64,
    chi2_threshold: f64,
    doubted_edges: usize,
    inlier_chi2: f64,
    outliers: Vec<Named>,
}

/// An outlier by the names of the file.
#[derive(Serialize)]
struct Named {
    /// Number of the edge in the file, from 0.
    edge: usize,
    from: i64,
    to: i64,
    chi2: f64,
}

impl Args {
    /// Checks the flags and puts them into the options.
    pub fn set(&self, options: &mut Options) -> Result<()> {
        options.loss = self.loss.loss()?;
        options.doubt_odometry = self.doubt_odometry;
        let p = self.inlier_probability;
        if p > 0.0 && p < 1.0 {
            return Ok(());
        }
        Err(Error::input(
            "--inlier-probability",
            format_args!("found {p}, expected a number between 0 and 1"),
        ))
    }

    /// Optimises as the flags say.
    pub fn optimize(&self, map: &mut SlamMap, options: &Options) -> Result<GraphReport> {
        if !self.gnc {
            return joint::optimize_graph(map, options);
        }
        let style = ProgressStyle::with_template("sorting edges {bar:30} {percent} %");
        let bar = ProgressBar::new(BAR_STEPS as u64)
            .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        let progress = |share: f64| bar.set_position((share * BAR_STEPS) as u64);
        let done = joint::optimize_graph_without_outliers(map, options, self.threshold(), &progress);
        bar.finish_and_clear();
        done
    }

    /// The edges that the result contradicts; `None` where nobody asked.
    pub fn found(&self, map: &SlamMap, options: &Options) -> Option<Found> {
        if !self.gnc && self.loss.loss == LossFlag::None {
            return None;
        }
        let id = |pose: usize| map.vertex_ids.as_ref().map_or(pose as i64, |ids| ids[pose]);
        let named = |o: joint::Outlier| {
            let f = &map.relative_factors[o.factor];
            Named { edge: o.factor, from: id(f.i), to: id(f.j), chi2: o.chi2 }
        };
        let threshold = self.threshold();
        let outliers: Vec<Named> = joint::outliers(map, options, threshold).into_iter().map(named).collect();
        let all: f64 = map.relative_factors.iter().map(|f| f.chi2(map.poses[f.i], map.poses[f.j])).sum();
        Some(Found {
            method: match options.loss {
                _ if self.gnc => "gnc",
                Loss::Huber(_) => "huber",
                Loss::Cauchy(_) => "cauchy",
                _ => "geman-mcclure",
            },
            loss_scale: options.loss.scale(),
            inlier_probability: self.inlier_probability,
            chi2_threshold: threshold,
            doubted_edges: joint::doubted(map, options),
            inlier_chi2: all - outliers.iter().map(|o| o.chi2).sum::<f64>(),
            outliers,
        })
    }

    fn threshold(&self) -> f64 {
        chi2_quantile_3(self.inlier_probability)
    }
}

impl Found {
    /// One line for a person.
    pub fn text(&self) -> String {
        let names: Vec<String> =
            self.outliers.iter().take(NAMED).map(|o| format!("{}–{}", o.from, o.to)).collect();
        let list = if names.is_empty() { String::new() } else { format!(": {}", names.join(", ")) };
        let more = if self.outliers.len() > NAMED { ", …" } else { "" };
        format!(
            "outliers: {} of {} doubted edges (chi2 above {:.2}){list}{more}\nchi2 of the rest {:.6}\n",
            self.outliers.len(),
            self.doubted_edges,
            self.chi2_threshold,
            self.inlier_chi2
        )
    }
}
