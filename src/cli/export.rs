//! `hitl export`: a map for other people's tools.

use std::path::{Path, PathBuf};

use hitl_slam::error::{Error, Result};
use hitl_slam::io::{self, Source};

use super::{Outcome, load, out};

/// Write a map for other tools; the extension of X picks the format.
///
///   .npz .g2o .stfs.covars .tum   native map, graph, HitL-SLAM text, trajectory of every scan
///   .clf .log                     CARMEN log: corrected laser poses, original odometry
///   .ply                          point cloud with normals
///   .pgm                          occupancy grid and its .yaml for the ROS map server
///   .csv                          walk for feetslam run; of a map of several walks x-1.csv, x-2.csv, …
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment, allow_negative_numbers = true)]
pub struct Args {
    /// Map, graph or log.
    input: PathBuf,

    /// File to write.
    #[arg(short, long, value_name = "X")]
    output: PathBuf,

    /// For .clf: the log that the map was made from. Every scan keeps its ranges; without it the beams are put together
    /// from the map's points.
    #[arg(long, value_name = "LOG")]
    log: Option<PathBuf>,

    /// For .csv: names of the walkers in their order; the files are called so, in the folder of X.
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    walkers: Vec<String>,

    /// For .pgm: side of a cell, metres.
    #[arg(long, value_name = "M", default_value_t = 0.05)]
    resolution_m: f64,

    /// For .pgm: turn the map by this before it is drawn. The YAML's yaw stays 0: its readers ignore it.
    #[arg(long, value_name = "DEG", default_value_t = 0.0)]
    yaw_deg: f64,
}

/// Runs the command.
///
/// # Errors
/// Bad options, or files that cannot be read or written.
pub fn run(args: &Args) -> Result<Outcome> {
    super::options::positive("--resolution-m", args.resolution_m)?;
    if !args.yaw_deg.is_finite() {
        return Err(Error::input("--yaw-deg", format_args!("found {}, expected a number", args.yaw_deg)));
    }
    io::export::check(&args.output)?;
    if args.log.is_some() && !["clf", "log"].contains(&io::export::extension(&args.output).as_str()) {
        return Err(Error::input("--log", "found with another format, expected it with .clf or .log only"));
    }
    let is_walk = io::export::extension(&args.output) == "csv";
    if !args.walkers.is_empty() && !is_walk {
        return Err(Error::input("--walkers", "found with another format, expected it with .csv only"));
    }
    let map = load::map(&args.input)?;
    if is_walk {
        for w in io::walks_of_map::write(&args.output, &map, &args.walkers)? {
            let start = format!("{},{},{}", w.start.x_m, w.start.y_m, w.start.theta_rad.to_degrees());
            out::print(&format!("{}: {} steps, --start {start}\n", w.path.display(), w.steps))?;
        }
        return Ok(Outcome::Done);
    }
    let log = args.log.as_deref().map(raw).transpose()?;
    let options = io::export::Options {
        resolution_m: args.resolution_m,
        yaw_rad: args.yaw_deg.to_radians(),
        log: log.as_ref(),
    };
    io::export::write(&args.output, &map, &options)?;
    out::print(&format!(
        "{}: {} poses, {} points\n",
        args.output.display(),
        map.poses.len(),
        map.observations.len()
    ))?;
    Ok(Outcome::Done)
}

fn raw(path: &Path) -> Result<hitl_slam::map::RawLog> {
    match load::source(path)? {
        Source::Log(log) => Ok(log),
        _ => Err(Error::input(path.display(), "found something else, expected the CARMEN log of the map")),
    }
}
