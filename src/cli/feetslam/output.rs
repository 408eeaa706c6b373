//! The result files of `hitl feetslam run`.

use std::io::Write;
use std::path::Path;

use hitl_slam::error::Result;
use hitl_slam::io;
use hitl_slam::pedestrian::Walk;
use hitl_slam::pedestrian::successive::Outcome;

/// Writes paths.csv, map.json and map.npz.
pub fn write(folder: &Path, walks: &[Walk], outcome: &Outcome) -> Result<()> {
    io::atomic::write(&folder.join("paths.csv"), |out: &mut dyn Write| {
        writeln!(
            out,
            "walker,time_s,best_x_m,best_y_m,mean_x_m,mean_y_m,mean_heading_rad,sigma_m,pdr_x_m,pdr_y_m"
        )?;
        for ((walk, estimate), start) in walks.iter().zip(&outcome.estimates).zip(&outcome.starts) {
            let track = walk.track(start.pose);
            for (k, step) in walk.steps.iter().enumerate() {
                let (best, mean, pdr) = (estimate.best[k + 1], estimate.mean[k + 1], track[k + 1]);
                writeln!(
                    out,
                    "{},{},{},{},{},{},{},{},{},{}",
                    walk.name,
                    step.time_s,
                    best.x,
                    best.y,
                    mean.x_m,
                    mean.y_m,
                    mean.theta_rad,
                    estimate.sigma_m[k + 1],
                    pdr.x_m,
                    pdr.y_m
                )?;
            }
        }
        Ok(())
    })?;
    io::transition_map::write_json(&folder.join("map.json"), &outcome.total)?;
    io::transition_map::write_npz(&folder.join("map.npz"), &outcome.total)
}
