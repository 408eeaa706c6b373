//! Machine-readable reports: JSON to a file, or to stdout where the path is `-`.

use std::path::Path;

use hitl_slam::error::{Error, Result};
use hitl_slam::io;
use hitl_slam::joint;
use hitl_slam::map::SlamMap;

use super::out;

/// True if the report goes to stdout, which then is for nothing else.
pub fn is_on_stdout(path: Option<&Path>) -> bool {
    path == Some(Path::new("-"))
}

/// Checks that a report can be written, before any work is done for it.
///
/// # Errors
/// As [`io::atomic::check`].
pub fn check(path: Option<&Path>) -> Result<()> {
    match path {
        Some(file) if !is_on_stdout(path) => io::atomic::check(file),
        _ => Ok(()),
    }
}

/// Writes `report` where the user asked for it, if anywhere.
pub fn write(path: Option<&Path>, report: &impl serde::Serialize) -> Result<()> {
    let Some(path) = path else { return Ok(()) };
    let mut text = serde_json::to_string_pretty(report).map_err(|e| Error::Internal(e.to_string()))?;
    text.push('\n');
    if is_on_stdout(Some(path)) {
        return out::print(&text);
    }
    io::atomic::write(path, |out| out.write_all(text.as_bytes()))
}

/// Largest resident memory of this process so far, 10⁶ bytes; `None` where the system does not tell.
pub fn peak_rss_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    let kibibytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kibibytes * 1024.0 / 1e6)
}

/// How certain the poses of a map are, given its held ones.
#[derive(Debug, serde::Serialize)]
pub struct Uncertainty {
    position_sigma_median_m: f64,
    position_sigma_worst_m: f64,
    worst_pose: usize,
}

impl Uncertainty {
    /// Of a map as it stands.
    ///
    /// # Errors
    /// As [`joint::map_covariances`].
    pub fn of(map: &SlamMap, options: &joint::Options) -> Result<Self> {
        let covariances = joint::map_covariances(map, options)?;
        let sigmas: Vec<f64> = covariances.iter().map(joint::position_sigma_m).collect();
        let worst = (0..sigmas.len()).max_by(|&a, &b| sigmas[a].total_cmp(&sigmas[b])).unwrap_or(0);
        let mut sorted = sigmas.clone();
        sorted.sort_by(f64::total_cmp);
        Ok(Uncertainty {
            position_sigma_median_m: sorted.get(sorted.len() / 2).copied().unwrap_or(0.0),
            position_sigma_worst_m: sigmas.get(worst).copied().unwrap_or(0.0),
            worst_pose: worst,
        })
    }
}
