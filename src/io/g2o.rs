//! g2o pose graphs, 2D part (docs/FORMATS.md, "g2o").
//!
//! ```text
//! VERTEX_SE2 id x y theta
//! FIX id …
//! EDGE_SE2 id_i id_j x y theta  xx xy xt yy yt tt      (pose j seen from pose i; upper triangle of Ω)
//! ROBOTLASER1 …                                        (after a vertex: only its stamp is used)
//! ```
//! Metres, radians. Ids, edges and their order are kept, also duplicate edges. A vertex may come after its edges.

use std::collections::{BTreeSet, HashMap};
use std::io::{self, Write};
use std::path::Path;

use nalgebra::Matrix3;

use super::source::Lines;
use super::text::{Shortest, fields, integer, numbers, show};
use super::{Read, atomic, carmen};
use crate::error::Result;
use crate::geometry::{Information, Pose2};
use crate::map::{Observations, RelativeFactor, SlamMap};

const POSE: [&str; 3] = ["x", "y", "theta"];
const EDGE: [&str; 9] = ["x", "y", "theta", "xx", "xy", "xt", "yy", "yt", "tt"];

/// Reads a graph. The result has no points.
///
/// # Errors
/// [`crate::error::Error::Input`] with the line: cut-off or garbled lines, duplicate or unknown ids, numbers that are
/// not finite, information that is not positive definite.
pub fn read(path: &Path) -> Result<Read<SlamMap>> {
    let mut lines = Lines::open(path)?;
    let mut graph = Graph::default();
    let mut warnings = Vec::new();
    let mut unknown = BTreeSet::new();
    while lines.advance()? {
        let mut words = fields(lines.line());
        let Some(tag) = words.next().filter(|t| !t.starts_with(b"#")) else { continue };
        let taken = match tag {
            b"VERTEX_SE2" => graph.vertex(words).map_err(|m| format!("VERTEX_SE2: {m}")),
            b"EDGE_SE2" => graph.edge(words, lines.number()).map_err(|m| format!("EDGE_SE2: {m}")),
            b"FIX" => graph.fix(words, lines.number()).map_err(|m| format!("FIX: {m}")),
            b"ROBOTLASER1" => graph.laser(lines.line()).map_err(|m| format!("ROBOTLASER1: {m}")),
            _ => {
                let tag = show(tag).into_owned();
                if !unknown.contains(&tag) {
                    warnings.push(lines.remark(format_args!("unknown tag {tag}: its lines are skipped")));
                    unknown.insert(tag);
                }
                Ok(())
            }
        };
        taken.map_err(|m| lines.error(m))?;
    }
    warnings.extend(lines.cut_off_remark());
    let map = graph.resolve(&lines, &mut warnings)?;
    map.validate(lines.file())?;
    Ok(Read { value: map, warnings })
}

/// The file as read; ids are resolved at its end.
#[derive(Default)]
struct Graph {
    ids: Vec<i64>,
    index_of: HashMap<i64, usize>,
    poses: Vec<Pose2>,
    stamps_s: Vec<Option<f64>>,
    edges: Vec<(usize, [i64; 2], Pose2, Information)>,
    fixed: Vec<(usize, i64)>,
}

type Taken = std::result::Result<(), String>;

impl Graph {
    fn vertex<'a>(&mut self, mut words: impl Iterator<Item = &'a [u8]> + Clone) -> Taken {
        expect_fields(words.clone(), 4)?;
        let id = id(words.next())?;
        let pose = Pose2::from_array(numbers(&mut words, &POSE)?);
        if self.index_of.insert(id, self.poses.len()).is_some() {
            return Err(format!("found vertex {id} a second time, expected each id once"));
        }
        self.ids.push(id);
        self.poses.push(pose);
        self.stamps_s.push(None);
        Ok(())
    }

    fn edge<'a>(&mut self, mut words: impl Iterator<Item = &'a [u8]> + Clone, line: usize) -> Taken {
        expect_fields(words.clone(), 11)?;
        let ids = [id(words.next())?, id(words.next())?];
        let [x, y, theta, xx, xy, xt, yy, yt, tt] = numbers(&mut words, &EDGE)?;
        let information = Information::new(Matrix3::new(xx, xy, xt, xy, yy, yt, xt, yt, tt))?;
        self.edges.push((line, ids, Pose2::new(x, y, theta), information));
        Ok(())
    }

    fn fix<'a>(&mut self, words: impl Iterator<Item = &'a [u8]> + Clone, line: usize) -> Taken {
        if words.clone().next().is_none() {
            return Err("found no id, expected at least one".into());
        }
        for word in words {
            self.fixed.push((line, id(Some(word))?));
        }
        Ok(())
    }

    fn laser(&mut self, line: &[u8]) -> Taken {
        let stamp_s = carmen::robot_laser(line)?.stamp_s;
        match self.stamps_s.last_mut() {
            Some(stamp) => *stamp = Some(stamp_s),
            None => return Err("found a scan before any vertex, expected it after its vertex".into()),
        }
        Ok(())
    }

    fn resolve(self, lines: &Lines, warnings: &mut Vec<String>) -> Result<SlamMap> {
        let index = |id: i64, line: usize| {
            self.index_of.get(&id).copied().ok_or_else(|| {
                lines.error_at(line, format_args!("found vertex {id}, expected one that the file defines"))
            })
        };
        let mut relative_factors = Vec::with_capacity(self.edges.len());
        for (line, [id_i, id_j], i_from_j, information) in self.edges {
            let (i, j) = (index(id_i, line)?, index(id_j, line)?);
            if i == j {
                warnings.push(format!(
                    "{}:{line}: the edge joins vertex {id_i} to itself: dropped",
                    lines.file()
                ));
                continue;
            }
            relative_factors.push(RelativeFactor { i, j, i_from_j, information });
        }
        let mut held = self.fixed.iter().map(|&(line, id)| index(id, line)).collect::<Result<Vec<_>>>()?;
        held.sort_unstable();
        held.dedup();
        let stamped = self.stamps_s.iter().flatten().count();
        if stamped > 0 && stamped < self.poses.len() {
            let n = self.poses.len();
            warnings.push(format!("{}: only {stamped} of {n} vertices have a stamp: ignored", lines.file()));
        }
        Ok(SlamMap {
            observations: Observations::empty(self.poses.len()),
            poses: self.poses,
            stamps_s: self.stamps_s.into_iter().collect(),
            vertex_ids: Some(self.ids),
            held,
            relative_factors,
            ..SlamMap::default()
        })
    }
}

fn expect_fields<'a>(words: impl Iterator<Item = &'a [u8]>, expected: usize) -> Taken {
    let found = words.count();
    if found == expected {
        Ok(())
    } else {
        Err(format!("found {found} fields, expected {expected} after the tag"))
    }
}

fn id(word: Option<&[u8]>) -> std::result::Result<i64, String> {
    integer(word.unwrap_or_default()).map_err(|m| format!("id: {m}"))
}

/// Writes the poses, held poses and relative factors of a map.
///
/// # Errors
/// [`crate::error::Error::Io`] if the file cannot be written.
pub fn write(path: &Path, map: &SlamMap) -> Result<()> {
    atomic::write(path, |out| fill(out, map))
}

fn fill(out: &mut dyn Write, map: &SlamMap) -> io::Result<()> {
    let id = |index: usize| map.vertex_ids.as_ref().map_or(index as i64, |ids| ids[index]);
    for (index, pose) in map.poses.iter().enumerate() {
        let [x, y, theta] = pose.to_array().map(Shortest);
        writeln!(out, "VERTEX_SE2 {} {x} {y} {theta}", id(index))?;
    }
    for &held in &map.held {
        writeln!(out, "FIX {}", id(held))?;
    }
    for factor in &map.relative_factors {
        let [x, y, theta] = factor.i_from_j.to_array().map(Shortest);
        write!(out, "EDGE_SE2 {} {} {x} {y} {theta}", id(factor.i), id(factor.j))?;
        let m = factor.information.matrix();
        for (row, column) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)] {
            write!(out, " {}", Shortest(m[(row, column)]))?;
        }
        writeln!(out)?;
    }
    Ok(())
}
