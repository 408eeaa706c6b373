//! Hand-checked relations: `t1 t2 x y z roll pitch yaw`, the pose at t2 seen from the one at t1.
//!
//! Seconds (stamps of the log's scans), metres, radians. z, roll and pitch are dropped; `#` comments.

use std::path::Path;

use super::Read;
use super::source::Lines;
use super::text::row;
use crate::error::Result;
use crate::geometry::Pose2;
use crate::map::Relation;

const NAMES: [&str; 8] = ["t1", "t2", "x", "y", "z", "roll", "pitch", "yaw"];

/// Reads relations, in the order of the file.
///
/// # Errors
/// [`crate::error::Error::Input`] with the line, if a line is not eight finite numbers.
pub fn read(path: &Path) -> Result<Read<Vec<Relation>>> {
    let mut lines = Lines::open(path)?;
    let mut relations = Vec::new();
    while lines.advance()? {
        let Some([stamp_1_s, stamp_2_s, x, y, _, _, _, yaw]) =
            row(lines.line(), &NAMES).map_err(|m| lines.error(m))?
        else {
            continue;
        };
        relations.push(Relation { stamp_1_s, stamp_2_s, first_from_second: Pose2::new(x, y, yaw) });
    }
    if relations.is_empty() {
        return Err(lines.file_error("found no relation, expected lines `t1 t2 x y z roll pitch yaw`"));
    }
    Ok(Read { value: relations, warnings: lines.cut_off_remark().into_iter().collect() })
}
