//! Hand-checked relations: `t1 t2 x y z roll pitch yaw`, the pose at t2 seen from the one at t1.
//!
//! Seconds (stamps of the log's scans), metres, radians. z, roll and pitch are dropped; `#` comments.

use std::path::Path;

use super::Read;
use super::source::Lines;
use super::text::{fields, numbers};
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
        let mut words = fields(lines.line());
        if words.clone().next().is_none_or(|w| w.starts_with(b"#")) {
            continue;
        }
        let found = words.clone().count();
        if found != 8 {
            let message = format!("found {found} fields, expected 8: t1 t2 x y z roll pitch yaw");
            return Err(lines.error(message));
        }
        let [stamp_1_s, stamp_2_s, x, y, _, _, _, yaw] =
            numbers(&mut words, &NAMES).map_err(|m| lines.error(m))?;
        relations.push(Relation { stamp_1_s, stamp_2_s, first_from_second: Pose2::new(x, y, yaw) });
    }
    if relations.is_empty() {
        return Err(lines.file_error("found no relation, expected lines `t1 t2 x y z roll pitch yaw`"));
    }
    Ok(Read { value: relations, warnings: lines.cut_off_remark().into_iter().collect() })
}
