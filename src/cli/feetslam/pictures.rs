//! Pictures of `hitl feetslam run`: the paper's figures 3 (iterations), 5 (rounds), 2 (paths), 4 and 6 (errors).

use std::path::Path;

use hitl_slam::error::Result;
use hitl_slam::geometry::{Segment, Vec2};
use hitl_slam::pedestrian::feetslam::Snapshot;
use hitl_slam::pedestrian::picture::HexPicture;
use hitl_slam::pedestrian::successive::Outcome;
use hitl_slam::pedestrian::{TransitionMap, Walk};
use hitl_slam::render::{Mark, Plot, Series};

use super::report::{Point, Report};
use crate::cli::picture;

/// Iterations of the last round that are drawn, as in the paper.
const ITERATIONS: usize = 4;
const WIDTH_PX: u32 = 1000;

/// Which of a point's errors to draw.
type ErrorOf = fn(&Point) -> f64;

/// Maps kept on the way.
#[derive(Default)]
pub struct Gallery {
    /// The first iterations of the round at hand.
    iterations: Vec<TransitionMap>,
    /// The latest map of each round.
    rounds: Vec<TransitionMap>,
}

impl Gallery {
    /// Keeps what will be drawn.
    pub fn keep(&mut self, snapshot: &Snapshot) {
        if snapshot.iteration == 0 {
            self.iterations.clear();
        }
        if snapshot.iteration < ITERATIONS {
            self.iterations.push(snapshot.total.clone());
        }
        self.rounds.truncate(snapshot.round);
        self.rounds.push(snapshot.total.clone());
    }

    /// Writes all pictures.
    pub fn write(
        &self,
        folder: &Path,
        walks: &[Walk],
        outcome: &Outcome,
        report: &Report,
        walls: &[Segment],
    ) -> Result<()> {
        let hexes = |title: &str, maps: Vec<(String, &TransitionMap)>, paths: Vec<Vec<Vec2>>| {
            HexPicture { title: title.to_owned(), maps, walls, paths, width_px: WIDTH_PX }.draw()
        };
        let numbered =
            |name: &str, maps: &'_ [TransitionMap], first: usize| -> Vec<(String, TransitionMap)> {
                maps.iter().enumerate().map(|(k, m)| (format!("{name} {}", k + first), m.clone())).collect()
            };
        for (file, title, maps) in [
            (
                "iterations.png",
                "total map, first iterations of the last round",
                numbered("iteration", &self.iterations, 0),
            ),
            ("rounds.png", "total map after each round", numbered("round", &self.rounds, 1)),
        ] {
            let maps = maps.iter().map(|(name, map)| (name.clone(), map)).collect();
            picture::write(&folder.join(file), &hexes(title, maps, Vec::new()))?;
        }
        let last = || vec![(String::new(), &outcome.total)];
        picture::write(&folder.join("map.svg"), &hexes("total map", last(), Vec::new()))?;
        let tracks = walks
            .iter()
            .zip(&outcome.starts)
            .map(|(walk, start)| walk.track(start.pose).iter().map(|p| p.translation()).collect());
        let means = outcome.estimates.iter().map(|e| e.mean.iter().map(|p| p.translation()).collect());
        let best = outcome.estimates.iter().map(|e| e.best.clone());
        for (file, title, paths) in [
            ("paths-before.png", "dead reckoning", tracks.collect::<Vec<Vec<Vec2>>>()),
            ("paths-after.png", "weighted mean of the particles", means.collect()),
            ("paths-best.png", "best particle", best.collect()),
        ] {
            let maps = if file == "paths-before.png" { Vec::new() } else { last() };
            picture::write(&folder.join(file), &hexes(title, maps, paths))?;
        }
        if report.walkers.iter().any(|w| !w.points.is_empty()) {
            let kinds: [(&str, &str, ErrorOf); 3] = [
                ("errors-mean.png", "weighted mean", |p| p.error_mean_m),
                ("errors-best.png", "best particle", |p| p.error_m),
                ("errors-pdr.png", "dead reckoning", |p| p.error_pdr_m),
            ];
            for (file, title, error) in kinds {
                picture::write(&folder.join(file), &curves(report, title, error).draw())?;
            }
        }
        Ok(())
    }
}

/// Error over time, a curve per walker.
fn curves(report: &Report, title: &str, error: ErrorOf) -> Plot {
    let series = report.walkers.iter().map(|walker| Series {
        label: if report.walkers.len() <= 8 { walker.name.clone() } else { String::new() },
        points: walker.points.iter().map(|p| [p.stamp, error(p)]).collect(),
        intervals: Vec::new(),
        mark: Mark::Line,
    });
    Plot {
        title: format!("Position error at true positions: {title}"),
        x_label: "time (s)".into(),
        y_label: "error (m)".into(),
        series: series.collect(),
        ..Plot::default()
    }
}
