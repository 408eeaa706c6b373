//! Pose graphs as text, one vertex or edge a line: what g2o and TORO have in common. A [`Dialect`] holds what they do not.
//!
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

/// What a format calls things and how it orders them.
pub(super) struct Dialect {
    /// Tag of a vertex.
    pub vertex: &'static str,
    /// Tag of an edge.
    pub edge: &'static str,
    /// Names of an edge's numbers: x, y, theta, then the information.
    pub numbers: [&'static str; 9],
    /// Row and column in Ω of each of the last six.
    pub places: [(usize, usize); 6],
    /// True if lines FIX and ROBOTLASER1 mean something.
    pub extended: bool,
}

/// Reads a graph. The result has no points.
pub(super) fn read(path: &Path, dialect: &Dialect) -> Result<Read<SlamMap>> {
    let mut lines = Lines::open(path)?;
    let mut graph = Graph::default();
    let mut warnings = Vec::new();
    let mut unknown = BTreeSet::new();
    while lines.advance()? {
        let mut words = fields(lines.line());
        let Some(tag) = words.next().filter(|t| !t.starts_with(b"#")) else { continue };
        let number = lines.number();
        let Dialect { vertex, edge, extended, .. } = *dialect;
        let taken = match tag {
            _ if tag == vertex.as_bytes() => graph.vertex(words).map_err(|m| format!("{vertex}: {m}")),
            _ if tag == edge.as_bytes() => {
                graph.edge(words, number, dialect).map_err(|m| format!("{edge}: {m}"))
            }
            b"FIX" if extended => graph.fix(words, number).map_err(|m| format!("FIX: {m}")),
            b"ROBOTLASER1" if extended => graph.laser(lines.line()).map_err(|m| format!("ROBOTLASER1: {m}")),
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

    fn edge<'a>(
        &mut self,
        mut words: impl Iterator<Item = &'a [u8]> + Clone,
        line: usize,
        dialect: &Dialect,
    ) -> Taken {
        expect_fields(words.clone(), 11)?;
        let ids = [id(words.next())?, id(words.next())?];
        let [x, y, theta, upper @ ..] = numbers(&mut words, &dialect.numbers)?;
        let mut omega = Matrix3::zeros();
        for (&(row, column), value) in dialect.places.iter().zip(upper) {
            omega[(row, column)] = value;
            omega[(column, row)] = value;
        }
        let information = Information::new(omega)?;
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

/// Writes the poses, relative and automatic factors of a map; its held poses where the format can say so.
pub(super) fn write(path: &Path, map: &SlamMap, dialect: &Dialect) -> Result<()> {
    atomic::write(path, |out| fill(out, map, dialect))
}

fn fill(out: &mut dyn Write, map: &SlamMap, dialect: &Dialect) -> io::Result<()> {
    let id = |index: usize| map.vertex_ids.as_ref().map_or(index as i64, |ids| ids[index]);
    for (index, pose) in map.poses.iter().enumerate() {
        let [x, y, theta] = pose.to_array().map(Shortest);
        writeln!(out, "{} {} {x} {y} {theta}", dialect.vertex, id(index))?;
    }
    for &held in map.held.iter().filter(|_| dialect.extended) {
        writeln!(out, "FIX {}", id(held))?;
    }
    for factor in map.every_relative_factor() {
        let [x, y, theta] = factor.i_from_j.to_array().map(Shortest);
        write!(out, "{} {} {} {x} {y} {theta}", dialect.edge, id(factor.i), id(factor.j))?;
        let m = factor.information.matrix();
        for place in dialect.places {
            write!(out, " {}", Shortest(m[place]))?;
        }
        writeln!(out)?;
    }
    Ok(())
}
