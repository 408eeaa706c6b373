//! A session as it runs: the map on screen, the person's next move, the file behind it.

use std::path::Path;
use std::sync::{Mutex, PoisonError};

use super::caution::caution;
use super::{Content, Entry, Event, History, Log, Matched, Solved, Source, State, Summary, Told, read};
use crate::error::{Error, Result};
use crate::geometry::Vec2;
use crate::interpret::Caught;
use crate::map::{Correction, Mode, SlamMap, Stroke};
use crate::pipeline::Proposal;

/// A correction as drawn on the map as it is shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drawn {
    /// How the strokes relate.
    pub mode: Mode,
    /// The strokes' ends, world frame of [`Solved::map`].
    pub strokes: [[Vec2; 2]; 2],
    /// The poses that they hang on; `None`: those that saw most of what they catch.
    pub anchors: Option<[usize; 2]>,
    /// Multiplies the factor's cost; > 0.
    pub weight: f64,
}

/// What a stroke catches and what to be careful of, or why it catches nothing.
pub type Look = std::result::Result<(Caught, Option<String>), String>;

/// The last strokes that were looked at need not be worked out again: the page asks for each more than once.
const LOOKS_KEPT: usize = 4;

/// What became of an event.
#[derive(Debug, Clone, PartialEq)]
pub enum Answer {
    /// It is on disk and on the map.
    Done,
    /// It cannot be; why. Nothing has changed.
    Refused(String),
    /// Its work was given up. Nothing has changed.
    Cancelled,
}

/// A session.
#[derive(Debug)]
pub struct Session {
    source: Source,
    solved: Solved,
    history: History,
    log: Log,
    times_s: Vec<u64>,
    looked: Mutex<Vec<([Vec2; 2], Look)>>,
}

impl Session {
    /// Begins a session about a map, or goes on with the one at `log`. Returns remarks for the person, too.
    ///
    /// # Errors
    /// [`Error::Input`] for a map without points, a damaged session or one about another map; [`Error::Io`].
    pub fn open(
        map: SlamMap,
        source: Source,
        log: &Path,
        progress: Told<'_>,
    ) -> Result<(Session, Vec<String>)> {
        let mut solved = Solved::new(map)?;
        if log.exists() {
            // Looked at before it is opened for more: what is not ours must not be touched.
            if let Ok(content) = read(log) {
                source.check(&content.header, log)?;
            }
        }
        let (log, content) = Log::open(log, &source.header(log))?;
        let history = fold(&content, log.path())?;
        if !solved.follow(history.state(), progress)? {
            return Err(Error::input(
                log.path().display(),
                "found that it was given up, expected to be opened",
            ));
        }
        let times_s = content.entries.iter().map(|e| e.at_s).collect();
        let looked = Mutex::default();
        Ok((Session { source, solved, history, log, times_s, looked }, content.remark.into_iter().collect()))
    }

    /// The map's file.
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// The session's file.
    pub fn log_path(&self) -> &Path {
        self.log.path()
    }

    /// What is on screen.
    pub fn solved(&self) -> &Solved {
        &self.solved
    }

    /// What was done.
    pub fn history(&self) -> &History {
        &self.history
    }

    /// The state as it is.
    pub fn state(&self) -> &State {
        self.history.state()
    }

    /// What there is to say at the end.
    pub fn summary(&self) -> Summary {
        Summary::new(&self.times_s, self.state(), &self.solved)
    }

    /// What a stroke catches, drawn on the map as it is shown (the segment is in that frame too), and what to be
    /// careful of.
    ///
    /// # Errors
    /// The reason, for a person, why it catches nothing.
    pub fn catch(&self, ends: [Vec2; 2]) -> Look {
        let mut looked = self.looked.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, seen)) = looked.iter().find(|(known, _)| *known == ends) {
            return seen.clone();
        }
        let (corrector, world_from_map) = (self.solved.corrector(), self.solved.world_from_map());
        let map_from_world = world_from_map.inverse();
        let caught = corrector.catch(ends.map(|p| map_from_world.transform_point(p)));
        let seen = caught.map(|mut caught| {
            let caution = caution(corrector, &caught);
            caught.fit.segment = caught.fit.segment.transformed(world_from_map);
            (caught, caution)
        });
        looked.truncate(LOOKS_KEPT - 1);
        looked.insert(0, (ends, seen.clone()));
        seen
    }

    /// A stroke drawn on the map as it is shown, in the frame of the pose that saw most of it.
    pub fn anchor(&self, ends: [Vec2; 2]) -> Stroke {
        let seen = self.catch(ends).ok();
        let map = self.solved.corrector().map();
        let middle = self.solved.world_from_map().inverse().transform_point((ends[0] + ends[1]) / 2.0);
        let distance = |pose: usize| (map.poses[pose].translation() - middle).norm();
        let best = seen.and_then(|(c, _)| {
            c.poses.iter().max_by_key(|&&(pose, n)| (n, std::cmp::Reverse(pose))).map(|p| p.0)
        });
        let nearest = || (0..map.poses.len()).min_by(|&i, &j| distance(i).total_cmp(&distance(j)));
        self.hung(ends, best.or_else(nearest).unwrap_or(0))
    }

    /// A stroke drawn on the map as it is shown, in the frame of a pose that the map has.
    fn hung(&self, ends: [Vec2; 2], pose: usize) -> Stroke {
        let world_from_robot =
            self.solved.world_from_map().compose(self.solved.corrector().map().poses[pose]);
        let robot_from_world = world_from_robot.inverse();
        Stroke::Pose { pose, points: ends.map(|p| robot_from_world.transform_point(p)) }
    }

    /// The correction that a drawing stands for, under the next free name; its poses are the map's.
    pub fn correction(&self, drawn: &Drawn) -> Correction {
        let [a, b] = match drawn.anchors {
            Some([i, j]) => [self.hung(drawn.strokes[0], i), self.hung(drawn.strokes[1], j)],
            None => drawn.strokes.map(|ends| self.anchor(ends)),
        };
        Correction { id: self.history.free_id(), mode: drawn.mode, a, b, weight: drawn.weight, enabled: true }
    }

    /// What a correction would do, committed now.
    ///
    /// # Errors
    /// [`Error::Internal`] for a fault of the solver.
    pub fn preview(&mut self, correction: &Correction) -> Result<&Proposal> {
        self.solved.preview(correction)
    }

    /// Lets an event happen: works it out, writes it down, shows it, in that order. `at_s`: seconds since 1970.
    ///
    /// # Errors
    /// [`Error::Io`] if it cannot be written down; nothing has changed then.
    pub fn act(&mut self, event: Event, at_s: u64, progress: Told<'_>) -> Result<Answer> {
        let event = match event {
            Event::Correct(correction, _) => {
                let proposal = self.solved.preview(&correction)?;
                if let Some(reason) = &proposal.report.rejection {
                    return Ok(Answer::Refused(reason.clone()));
                }
                let result = (&proposal.report).into();
                Event::Correct(correction, result)
            }
            other => other,
        };
        let plan = match self.history.plan(&event) {
            Ok(plan) => plan,
            Err(reason) => return Ok(Answer::Refused(reason)),
        };
        match &event {
            Event::Settings(settings) => settings.solver.require()?,
            Event::Refuse(_, j) if *j >= self.solved.source().poses.len() => {
                return Ok(Answer::Refused(format!("name: found pose {j}, expected one that the map has")));
            }
            _ => {}
        }
        self.looked.get_mut().unwrap_or_else(PoisonError::into_inner).clear();
        match self.solved.follow(self.history.planned(&plan), progress) {
            Ok(true) => {}
            Ok(false) => return Ok(Answer::Cancelled),
            Err(error) => return Err(error),
        }
        let event = match event {
            Event::Match(_) => Event::Match(self.matched()),
            other => other,
        };
        if let Err(error) = self.log.append(&Entry { at_s, event }) {
            self.solved.follow(self.history.state(), &mut |_, _| true)?;
            return Err(error);
        }
        self.history.commit(plan);
        self.times_s.push(at_s);
        Ok(Answer::Done)
    }

    /// The last re-association in numbers.
    fn matched(&self) -> Matched {
        let factors = &self.solved.corrector().map().automatic_factors;
        Matched {
            factors: factors.len(),
            disagreeing: factors.iter().filter(|a| a.disagrees()).count(),
            withdrawn: self.solved.matched().is_some_and(|m| m.report.withdrawn),
        }
    }

    /// A copy on which the visits can be matched while this session goes on.
    pub fn branch(&self) -> Branch {
        let plan = self.history.plan(&Event::Match(Matched::default()));
        let state = plan.as_ref().map_or(self.state(), |plan| self.history.planned(plan)).clone();
        Branch { solved: self.solved.clone(), state }
    }

    /// Takes over what a branch has found. [`Event::Match`] then need not look for it, if nothing has changed meanwhile.
    pub fn learn(&mut self, branch: Branch) {
        self.solved.learn(branch.solved);
    }
}

/// A session's map on which visits are matched beside it.
#[derive(Debug)]
pub struct Branch {
    solved: Solved,
    state: State,
}

impl Branch {
    /// Matches the visits; false: given up.
    ///
    /// # Errors
    /// As [`crate::pipeline::Corrector::reassociate`].
    pub fn run(&mut self, progress: Told<'_>) -> Result<bool> {
        self.solved.follow(&self.state, progress)
    }
}

/// Runs a session's events again on its map, without touching its file: the map that the person saw last.
///
/// # Errors
/// [`Error::Input`] for a session about another map, or a damaged one.
pub fn replay(
    map: SlamMap,
    source: &Source,
    content: &Content,
    log: &Path,
    progress: Told<'_>,
) -> Result<(Solved, State)> {
    source.check(&content.header, log)?;
    let history = fold(content, log)?;
    let mut solved = Solved::new(map)?;
    history.state().settings.solver.require()?;
    solved.follow(history.state(), progress)?;
    Ok((solved, history.state().clone()))
}

/// What the events of a session leave.
fn fold(content: &Content, log: &Path) -> Result<History> {
    content.history().map_err(|(line, message)| Error::line(log.display(), line, message))
}
