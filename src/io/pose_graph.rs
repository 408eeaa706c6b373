//! Pose graphs as text, one vertex or edge a line: what g2o and TORO have in common. A [`Dialect`] holds what they do not.
//!
//! Metres, radians. Ids, edges and their order are kept, also duplicate edges. A vertex may come after its edges.

use std::collections::BTreeSet;
use std::io::{self, Write};
use std::path::Path;

use nalgebra::Matrix3;

use super::ids::Ids;
use super::source::Lines;
use super::text::{Shortest, exactly, fields, integer, numbers, show};
use super::{Indefinite, Read, atomic, carmen};
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
pub(super) fn read(path: &Path, dialect: &Dialect, indefinite: Indefinite) -> Result<Read<SlamMap>> {
    let mut lines = Lines::open(path)?;
    let mut graph = Graph { indefinite, ..Graph::default() };
    let mut warnings = Vec::new();
    let mut unknown = BTreeSet::new();
    let Dialect { vertex, edge, extended, .. } = *dialect;
    while lines.advance()? {
        let mut words = fields(lines.line());
        let Some(tag) = words.next().filter(|t| !t.starts_with(b"#")) else { continue };
        let number = lines.number();
        let taken = match tag {
            _ if tag == edge.as_bytes() => {
                graph.edge(words, number, dialect).map_err(|m| format!("{edge}: {m}"))
            }
            _ if tag == vertex.as_bytes() => graph.vertex(words).map_err(|m| format!("{vertex}: {m}")),
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
    warnings.extend(graph.repair_remark(&lines));
    let map = graph.resolve(&lines, &mut warnings)?;
    map.validate(lines.file())?;
    Ok(Read { value: map, warnings })
}

/// The file as read; ids are resolved at its end.
#[derive(Default)]
struct Graph {
    ids: Ids,
    poses: Vec<Pose2>,
    stamps_s: Vec<Option<f64>>,
    factors: Vec<RelativeFactor>,
    /// Factor, line and ids of edges that have to wait for the end of the file: a vertex is not known yet.
    open: Vec<(usize, usize, [i64; 2])>,
    fixed: Vec<(usize, i64)>,
    indefinite: Indefinite,
    /// Lines whose information was not positive definite.
    repaired: Vec<usize>,
}

type Taken = std::result::Result<(), String>;

impl Graph {
    fn vertex<'a>(&mut self, words: impl Iterator<Item = &'a [u8]>) -> Taken {
        let [first, pose @ ..] = exactly::<4>(words)?;
        let id = id(first)?;
        let pose = Pose2::from_array(numbers(&mut pose.into_iter(), &POSE)?);
        if !self.ids.insert(id) {
            return Err(format!("found vertex {id} a second time, expected each id once"));
        }
        self.poses.push(pose);
        self.stamps_s.push(None);
        Ok(())
    }

    fn edge<'a>(&mut self, words: impl Iterator<Item = &'a [u8]>, line: usize, dialect: &Dialect) -> Taken {
        let [first, second, rest @ ..] = exactly::<11>(words)?;
        let ids = [id(first)?, id(second)?];
        let [x, y, theta, upper @ ..] = numbers(&mut rest.into_iter(), &dialect.numbers)?;
        let mut omega = Matrix3::zeros();
        for (&(row, column), value) in dialect.places.iter().zip(upper) {
            omega[(row, column)] = value;
            omega[(column, row)] = value;
        }
        let information = match (Information::new(omega), self.indefinite) {
            (Err(_), Indefinite::Repair) => {
                self.repaired.push(line);
                Information::nearest(omega)?
            }
            (checked, _) => checked?,
        };
        let known = self.ids.index_of(ids[0]).zip(self.ids.index_of(ids[1])).filter(|(i, j)| i != j);
        let (i, j) = known.unwrap_or_default();
        if known.is_none() {
            self.open.push((self.factors.len(), line, ids));
        }
        self.factors.push(RelativeFactor { i, j, i_from_j: Pose2::new(x, y, theta), information });
        Ok(())
    }

    fn repair_remark(&self, lines: &Lines) -> Option<String> {
        let first = self.repaired.first()?;
        Some(format!(
            "{}:{first}: information matrix: not positive definite, the nearest one that is was taken (such edges: {})",
            lines.file(),
            self.repaired.len()
        ))
    }

    fn fix<'a>(&mut self, words: impl Iterator<Item = &'a [u8]>, line: usize) -> Taken {
        let mut words = words.peekable();
        if words.peek().is_none() {
            return Err("found no id, expected at least one".into());
        }
        for word in words {
            self.fixed.push((line, id(word)?));
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

    fn resolve(mut self, lines: &Lines, warnings: &mut Vec<String>) -> Result<SlamMap> {
        let index = |id: i64, line: usize| {
            self.ids.index_of(id).ok_or_else(|| {
                lines.error_at(line, format_args!("found vertex {id}, expected one that the file defines"))
            })
        };
        let mut to_itself = Vec::new();
        for &(factor, line, [id_i, id_j]) in &self.open {
            let (i, j) = (index(id_i, line)?, index(id_j, line)?);
            (self.factors[factor].i, self.factors[factor].j) = (i, j);
            if i == j {
                to_itself.push(factor);
                let file = lines.file();
                warnings.push(format!("{file}:{line}: the edge joins vertex {id_i} to itself: dropped"));
            }
        }
        let mut to_itself = to_itself.into_iter().peekable();
        let mut factor = 0..;
        self.factors.retain(|_| {
            let factor = factor.next();
            to_itself.next_if(|&dropped| Some(dropped) == factor).is_none()
        });
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
            vertex_ids: Some(self.ids.into_list()),
            held,
            relative_factors: self.factors,
            ..SlamMap::default()
        })
    }
}

fn id(word: &[u8]) -> std::result::Result<i64, String> {
    integer(word).map_err(|m| format!("id: {m}"))
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
