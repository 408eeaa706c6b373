//! What a file is, told from what stands in it; its name decides only where the content does not.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use super::source::Lines;
use super::text::{fields, number};
use super::{carmen, stfs};
use crate::error::{Error, Result};

/// Lines looked at before giving up: logs may begin with hundreds of parameters.
const LINES_TO_LOOK_AT: usize = 2000;

/// The formats that can be an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// CARMEN log.
    Carmen,
    /// g2o pose graph.
    G2o,
    /// TORO pose graph.
    Toro,
    /// 16-column text of the released HitL-SLAM.
    Stfs,
    /// TUM trajectory.
    Tum,
    /// A pedestrian's walk.
    Walk,
    /// Walkers' paths, as `hitl feetslam` writes them.
    Paths,
    /// Native map (`.npz`).
    Native,
}

impl Format {
    /// The format's name for people.
    pub fn name(self) -> &'static str {
        match self {
            Format::Carmen => "CARMEN log",
            Format::G2o => "g2o pose graph",
            Format::Toro => "TORO pose graph",
            Format::Stfs => "HitL-SLAM 16-column text (.stfs.covars)",
            Format::Tum => "TUM trajectory",
            Format::Walk => "walk (CSV)",
            Format::Paths => "walkers' paths (paths.csv)",
            Format::Native => "native map (.npz)",
        }
    }
}

/// Tells the format of a file.
///
/// # Errors
/// [`Error::Io`] if it cannot be read, [`Error::Input`] if it is none of the known formats.
pub fn format(path: &Path) -> Result<Format> {
    let mut magic = Vec::new();
    let file = File::open(path).map_err(|e| Error::io(path, e))?;
    file.take(4).read_to_end(&mut magic).map_err(|e| Error::io(path, e))?;
    if magic.is_empty() {
        return Err(Error::input(path.display(), "found an empty file, expected a log or a map"));
    }
    if magic.starts_with(b"PK") {
        return Ok(Format::Native);
    }
    by_lines(path)?.or_else(|| by_name(path)).ok_or_else(|| {
        let known = "a CARMEN log, g2o, TORO, .stfs.covars, TUM, a walk (.csv) or a native map (.npz)";
        Error::input(path.display(), format_args!("found nothing that tells its format, expected {known}"))
    })
}

fn by_lines(path: &Path) -> Result<Option<Format>> {
    let mut lines = Lines::open(path)?;
    while lines.number() < LINES_TO_LOOK_AT && lines.advance()? {
        let line = lines.line();
        if lines.number() == 3 && stfs::is_return(line) {
            return Ok(Some(Format::Stfs));
        }
        let mut words = fields(line);
        let Some(first) = words.clone().next() else { continue };
        match std::str::from_utf8(first).unwrap_or_default() {
            "VERTEX2" | "EDGE2" => return Ok(Some(Format::Toro)),
            "FIX" => return Ok(Some(Format::G2o)),
            tag if tag.starts_with("VERTEX_") || tag.starts_with("EDGE_") => return Ok(Some(Format::G2o)),
            tag if begins(tag, "time_s,forward_m") => return Ok(Some(Format::Walk)),
            tag if begins(tag, "walker,time_s,best_x_m") => return Ok(Some(Format::Paths)),
            tag if carmen::is_tag(tag) => return Ok(Some(Format::Carmen)),
            // The first two lines of .stfs.covars are free text: numbers on them prove nothing yet.
            _ if words.clone().count() == 8 && words.all(|w| number(w).is_ok()) => {
                return Ok(Some(Format::Tum));
            }
            _ => {}
        }
    }
    Ok(None)
}

/// True if a header's first word, whatever spreadsheet wrote it, begins like this.
fn begins(word: &str, header: &str) -> bool {
    word.trim_start_matches('\u{feff}').starts_with(header)
}

/// For a file too damaged to tell: the reader of its name will say on which line.
fn by_name(path: &Path) -> Option<Format> {
    let name = path.file_name()?.to_string_lossy().to_lowercase();
    let name = [".gz", ".bz2", ".xz"].iter().find_map(|e| name.strip_suffix(e)).unwrap_or(&name);
    let ends = |endings: &[&str]| endings.iter().any(|e| name.ends_with(e));
    if ends(&[".stfs.covars", ".stfs", ".covars"]) {
        Some(Format::Stfs)
    } else if ends(&[".g2o"]) {
        Some(Format::G2o)
    } else if ends(&[".graph", ".toro"]) {
        Some(Format::Toro)
    } else if ends(&[".clf", ".log"]) {
        Some(Format::Carmen)
    } else if ends(&[".tum"]) {
        Some(Format::Tum)
    } else if ends(&[".npz"]) {
        Some(Format::Native)
    } else {
        None
    }
}
