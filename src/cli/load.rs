//! Opens whatever file a command was given; what its reader has to remark goes to stderr.

use std::path::Path;

use hitl_slam::error::{Error, Result};
use hitl_slam::front_end::{self, Chain};
use hitl_slam::io::{self, Indefinite, Source};
use hitl_slam::map::{Correction, RawLog, Relation, SlamMap, Trajectory, Wall, WallPair};
use hitl_slam::session;

use super::out;

/// Prints remarks.
pub fn remark(warnings: &[String]) {
    for warning in warnings {
        out::complain(format_args!("note: {warning}"));
    }
}

/// Any input file.
pub fn source(path: &Path) -> Result<Source> {
    let (_, read) = io::read(path)?;
    remark(&read.warnings);
    Ok(read.value)
}

/// A map: as it is, or from a raw log by its odometry; a trajectory is a map without factors and points.
pub fn map(path: &Path) -> Result<SlamMap> {
    map_with(path, Indefinite::Refuse)
}

/// The same, with a choice of what happens to a pose graph's information that is not positive definite.
pub fn map_with(path: &Path, indefinite: Indefinite) -> Result<SlamMap> {
    let read = front_end::open(path, indefinite)?;
    remark(&read.warnings);
    Ok(read.value)
}

/// A map from a raw log.
pub fn map_of(log: &RawLog, chain: Chain, options: &front_end::Options) -> Result<SlamMap> {
    let (map, warnings) = front_end::build(log, chain, options)?;
    remark(&warnings);
    Ok(map)
}

/// A trajectory: a TUM file's, or a map's own (one pose per scan of its log).
pub fn trajectory(path: &Path) -> Result<Trajectory> {
    match source(path)? {
        Source::Trajectory(trajectory) => Ok(trajectory),
        Source::Map(map) => Ok(map.trajectory()),
        Source::Walks { walks, starts } => {
            Ok(front_end::map_of_walks(&walks, &front_end::WalkOptions::starting(&starts))?.trajectory())
        }
        Source::Log(log) => Ok(map_of(&log, Chain::Odometry, &front_end::Options::default())?.trajectory()),
        _ => Err(Error::input(path.display(), "found something else, expected a trajectory or a map")),
    }
}

/// A pose graph: vertices and factors, points or not.
pub fn graph(path: &Path) -> Result<SlamMap> {
    match source(path)? {
        Source::Map(map) => Ok(map),
        _ => Err(Error::input(path.display(), "found no pose graph, expected g2o or a native map")),
    }
}

/// A file of hand-checked relations.
pub fn relations(path: &Path) -> Result<Vec<Relation>> {
    let read = io::relations::read(path)?;
    remark(&read.warnings);
    Ok(read.value)
}

/// A file of corrections, or the corrections that a session leaves.
pub fn corrections(path: &Path) -> Result<Vec<Correction>> {
    Ok(wanted(path)?.corrections)
}

/// What a file of corrections or a session wants of a map. A session's settings are not looked at: the flags count.
pub fn wanted(path: &Path) -> Result<session::State> {
    if session::is_session(path) {
        let content = session::read(path)?;
        remark(content.remark.as_slice());
        let history =
            content.history().map_err(|(line, message)| Error::line(path.display(), line, message))?;
        let state = history.state().clone();
        if state.corrections.is_empty() && state.closings.is_empty() {
            return Err(Error::input(
                path.display(),
                "found a session without corrections, expected at least one",
            ));
        }
        return Ok(state);
    }
    let read = io::corrections::read(path)?;
    remark(&read.warnings);
    Ok(session::State { corrections: read.value, ..session::State::default() })
}

/// A file of true walls.
pub fn walls(path: &Path) -> Result<Vec<Wall>> {
    let read = io::walls::read(path)?;
    remark(&read.warnings);
    Ok(read.value)
}

/// A file that says which walls to compare.
pub fn wall_pairs(path: &Path) -> Result<Vec<WallPair>> {
    let read = io::walls::read_pairs(path)?;
    remark(&read.warnings);
    Ok(read.value)
}
