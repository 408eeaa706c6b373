//! True walls and the pairs of them that are compared (docs/FORMATS.md, "Walls").
//!
//! ```text
//! name,x1_m,y1_m,x2_m,y2_m        walls.csv: one wall a line
//! a,b,measure                     pairs.csv: two names and `angle` or `distance`
//! ```

use std::path::Path;

use super::source::Lines;
use super::text::{number, show};
use super::{Read, atomic};
use crate::error::Result;
use crate::geometry::{Segment, Vec2};
use crate::map::{Measure, Wall, WallPair};

const WALLS: &str = "name,x1_m,y1_m,x2_m,y2_m";
const PAIRS: &str = "a,b,measure";

/// Reads walls.
///
/// # Errors
/// [`crate::error::Error::Input`] with the line that is not a name and four finite numbers.
pub fn read(path: &Path) -> Result<Read<Vec<Wall>>> {
    rows(path, WALLS, |fields: [&[u8]; 5]| {
        let [name, ends @ ..] = fields;
        let mut values = [0.0; 4];
        for (k, (value, field)) in values.iter_mut().zip(ends).enumerate() {
            *value = number(field).map_err(|m| format!("{}: {m}", ["x1_m", "y1_m", "x2_m", "y2_m"][k]))?;
        }
        let [x1, y1, x2, y2] = values;
        Ok(Wall { name: text(name), segment: Segment::from_ends(Vec2::new(x1, y1), Vec2::new(x2, y2)) })
    })
}

/// Reads pairs.
///
/// # Errors
/// [`crate::error::Error::Input`] with the line that is not two names and a measure.
pub fn read_pairs(path: &Path) -> Result<Read<Vec<WallPair>>> {
    rows(path, PAIRS, |[a, b, measure]: [&[u8]; 3]| {
        let named = text(measure);
        let measure = Measure::ALL.into_iter().find(|m| m.name() == named);
        let measure =
            measure.ok_or_else(|| format!("measure: found '{named}', expected angle or distance"))?;
        Ok(WallPair { a: text(a), b: text(b), measure })
    })
}

/// Writes walls.
///
/// # Errors
/// [`crate::error::Error::Io`] if the file cannot be written.
pub fn write(path: &Path, walls: &[Wall]) -> Result<()> {
    atomic::write(path, |out| {
        writeln!(out, "{WALLS}")?;
        for wall in walls {
            let [p, q] = wall.segment.ends();
            writeln!(out, "{},{},{},{},{}", wall.name, p.x, p.y, q.x, q.y)?;
        }
        Ok(())
    })
}

/// Writes pairs.
///
/// # Errors
/// [`crate::error::Error::Io`] if the file cannot be written.
pub fn write_pairs(path: &Path, pairs: &[WallPair]) -> Result<()> {
    atomic::write(path, |out| {
        writeln!(out, "{PAIRS}")?;
        for pair in pairs {
            writeln!(out, "{},{},{}", pair.a, pair.b, pair.measure.name())?;
        }
        Ok(())
    })
}

fn rows<T, const N: usize>(
    path: &Path,
    header: &str,
    row: impl Fn([&[u8]; N]) -> std::result::Result<T, String>,
) -> Result<Read<Vec<T>>> {
    let mut lines = Lines::open(path)?;
    let mut value = Vec::new();
    while lines.advance()? {
        let line = lines.line();
        if lines.number() == 1 {
            if line != header.as_bytes() {
                return Err(lines.error(format_args!("found '{}', expected the header {header}", show(line))));
            }
            continue;
        }
        if line.is_empty() {
            continue;
        }
        let fields: Vec<&[u8]> = line.split(|&b| b == b',').collect();
        let Ok(fields) = <[&[u8]; N]>::try_from(fields) else {
            let found = line.split(|&b| b == b',').count();
            return Err(lines.error(format_args!("found {found} fields, expected {N}: {header}")));
        };
        value.push(row(fields).map_err(|m| lines.error(m))?);
    }
    if value.is_empty() {
        return Err(lines.file_error(format_args!("found no line of values, expected some after {header}")));
    }
    Ok(Read { value, warnings: lines.cut_off_remark().into_iter().collect() })
}

fn text(field: &[u8]) -> String {
    String::from_utf8_lossy(field).trim().to_owned()
}
