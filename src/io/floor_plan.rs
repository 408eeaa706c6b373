//! Floor plans as walls: vector maps (`x1, y1, x2, y2`, metres, one wall a line) and `walls.csv` of `hitl simulate`.
//!
//! `walls.csv` has the header `name,x1_m,y1_m,x2_m,y2_m`. Robots and walkers use the same worlds.

use std::io::Write;
use std::path::Path;

use super::source::Lines;
use super::text::{Shortest, number};
use super::{Read, atomic};
use crate::error::Result;
use crate::geometry::{Segment, Vec2};

const HEADER: &str = "name,x1_m,y1_m,x2_m,y2_m";

/// Reads walls; those without length are left out with a remark.
///
/// # Errors
/// [`crate::error::Error::Input`] with the line, if it is not four finite numbers (after a name in `walls.csv`).
pub fn read(path: &Path) -> Result<Read<Vec<Segment>>> {
    let mut lines = Lines::open(path)?;
    let (mut walls, mut points, mut has_names) = (Vec::new(), 0, false);
    while lines.advance()? {
        let text = lines.line().trim_ascii();
        if text.is_empty() || text.starts_with(b"#") {
            continue;
        }
        if walls.is_empty() && text == HEADER.as_bytes() {
            has_names = true;
            continue;
        }
        let fields: Vec<&[u8]> = text.split(|&b| b == b',').skip(usize::from(has_names)).collect();
        if fields.len() != 4 {
            let message = format!("found {} numbers, expected 4: x1, y1, x2, y2", fields.len());
            return Err(lines.error(message));
        }
        let mut v = [0.0; 4];
        for (value, field) in v.iter_mut().zip(&fields) {
            *value = number(field).map_err(|m| lines.error(m))?;
        }
        let (from, to) = (Vec2::new(v[0], v[1]), Vec2::new(v[2], v[3]));
        if from == to {
            points += 1;
        } else {
            walls.push(Segment::from_ends(from, to));
        }
    }
    if walls.is_empty() {
        return Err(lines.file_error("found no wall, expected lines `x1, y1, x2, y2`"));
    }
    let remark =
        (points > 0).then(|| format!("{}: {points} walls without length are left out", lines.file()));
    Ok(Read { value: walls, warnings: remark.into_iter().collect() })
}

/// Writes walls as a vector map.
///
/// # Errors
/// [`crate::error::Error::Io`] if the file cannot be written.
pub fn write(path: &Path, walls: &[Segment]) -> Result<()> {
    atomic::write(path, |out: &mut dyn Write| {
        walls.iter().try_for_each(|wall| {
            let [p, q] = wall.ends();
            let [a, b, c, d] = [p.x, p.y, q.x, q.y].map(Shortest);
            writeln!(out, "{a}, {b}, {c}, {d}")
        })
    })
}
