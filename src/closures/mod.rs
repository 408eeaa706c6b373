//! Re-association: visits that come near each other are matched with each other, and what matches becomes a factor.
//!
//! A stage of its own after [`crate::joint`]: a stroke brings two visits near enough, this finds everything that then
//! fits. Each round forgets all automatic factors and finds them anew from the poses of the round before, so that nothing
//! wrong stays: pairs of places → search and refinement in the frame of the earlier visit → gates → a solve
//! under a bounded loss. Before the first round the map is solved without any automatic factor: the result depends on
//! the chain and the person's corrections alone, never on what was found before.

mod candidates;
mod matching;
mod near_pass;
mod neighbours;
mod place;
mod report;

pub use neighbours::{Step, compare_step, compare_steps};
pub use report::{NearPass, Report, Round};

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use rayon::prelude::*;

use crate::error::Result;
use crate::geometry::Pose2;
use crate::joint;
use crate::map::{AutomaticFactor, SlamMap};
use crate::scan_match::{Cloud, Search};
use crate::solver::Covariance;
use candidates::Candidate;
use matching::Outcome;
use place::Places;

/// If more than this share of the factors disagree, the map is too bent to tell right matches from wrong ones: none is kept.
const MOST_DISAGREEING: f64 = 0.25;
/// Two places are visits of their own if the robot drove at least so far between them, metres.
const SHORTEST_LOOP_M: f64 = 8.0;
/// Loss scales of the solves of a round: from wide, so that many weak voices can pull a loop shut, to what stays.
const LOSS_SCALES: [f64; 2] = [20.0, 8.0];
/// A round that moves no pose further than this was the last, metres.
const SETTLED_M: f64 = 0.03;

/// Tunables.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Rounds at most.
    pub rounds: usize,
    /// Pairs of poses (earlier, later) that a person said are no match: they and those beside them are not compared.
    pub refused: Vec<(usize, usize)>,
}

impl Default for Options {
    fn default() -> Self {
        Options { rounds: 3, refused: Vec::new() }
    }
}

/// How far it is, for a progress bar.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// From 0.
    pub round: usize,
    /// At most.
    pub rounds: usize,
    /// Pairs compared in this round …
    pub done: usize,
    /// … of so many.
    pub pairs: usize,
}

/// Finds all automatic factors anew and optimises the map with them. `None`, and the map as it was, if `cancelled`
/// becomes true on the way. On a map of walks nothing is looked for: footprints are no walls, and two people do not tread in
/// one line.
///
/// # Errors
/// As [`joint::optimize`].
pub fn reassociate(
    map: &mut SlamMap,
    joint_options: &joint::Options,
    options: &Options,
    progress: &(dyn Fn(Progress) + Sync),
    cancelled: &AtomicBool,
) -> Result<Option<Report>> {
    let footprints = map.points_are_footprints();
    if footprints && map.automatic_factors.is_empty() {
        return Ok(Some(Report { footprints, ..Report::default() }));
    }
    let mut work = map.clone();
    work.automatic_factors.clear();
    solve(&mut work, joint_options, joint_options.automatic_loss_scale)?;
    let unassisted = (work.poses.clone(), work.human_factors.clone());
    let mut report = Report { footprints, ..Report::default() };
    let mut last = Vec::new();
    let rounds = if footprints { 0 } else { options.rounds };
    for round in 0..rounds {
        let before = work.poses.clone();
        let told = |done, pairs| progress(Progress { round, rounds: options.rounds, done, pairs });
        let Some(compared) = search(&work, joint_options, options, &told, cancelled)? else {
            return Ok(None);
        };
        work.automatic_factors = compared.iter().filter_map(|(_, outcome)| outcome.accepted()).collect();
        for scale in LOSS_SCALES {
            solve(&mut work, joint_options, scale)?;
        }
        solve(&mut work, joint_options, joint_options.automatic_loss_scale)?;
        judge(&mut work);
        let moved_m = largest_move_m(&before, &work.poses);
        report.rounds.push(Round {
            pairs: compared.len(),
            accepted: work.automatic_factors.len(),
            disagreeing: disagreeing(&work),
            moved_m,
            widest_m: compared.iter().map(|(c, _)| c.position_m).fold(0.0, f64::max),
        });
        last = compared;
        if moved_m < SETTLED_M {
            break;
        }
    }
    if disagreeing(&work) as f64 > MOST_DISAGREEING * work.automatic_factors.len() as f64 {
        report.withdrawn = true;
        work.automatic_factors.clear();
        (work.poses, work.human_factors) = unassisted;
    }
    report.near_passes = near_pass::find(&work, &last);
    *map = work;
    Ok(Some(report))
}

/// Two visits that were compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    /// Pose of the earlier visit.
    pub i: usize,
    /// Pose of the later visit.
    pub j: usize,
    /// Where the later was found, seen from the earlier; `None` if too few of its points fit anywhere.
    pub matched: Option<AutomaticFactor>,
}

/// Compares all visits that come near each other, as far apart as the map's own uncertainty allows, on the map as it stands, and changes
/// nothing. Ascending by (j, i).
///
/// # Errors
/// As [`joint::optimize`].
pub fn compare_visits(map: &SlamMap, joint_options: &joint::Options) -> Result<Vec<Comparison>> {
    let found = search(map, joint_options, &Options::default(), &|_, _| (), &AtomicBool::new(false))?;
    let comparison =
        |(c, outcome): &(Candidate, Outcome)| Comparison { i: c.i, j: c.j, matched: outcome.accepted() };
    Ok(found.iter().flatten().map(comparison).collect())
}

/// Number of automatic factors that disagree with the rest of the map.
fn disagreeing(map: &SlamMap) -> usize {
    map.automatic_factors.iter().filter(|a| a.disagrees()).count()
}

/// Every candidate with what came of it, ascending by (j, i); `None` if cancelled.
fn search(
    map: &SlamMap,
    joint_options: &joint::Options,
    options: &Options,
    told: &(dyn Fn(usize, usize) + Sync),
    cancelled: &AtomicBool,
) -> Result<Option<Vec<(Candidate, Outcome)>>> {
    let path_m = map.path_lengths_m();
    let has_points = |pose: usize| !map.observations.range(pose).is_empty();
    let stations = candidates::stations(&map.poses, &path_m, has_points);
    let problem = joint::build(map, &map.poses, &map.human_factors, joint_options);
    let Some(covariance) = Covariance::new(&problem, &problem.blocks(), &problem.held) else {
        return Ok(Some(Vec::new()));
    };
    let is_refused = |c: &Candidate| options.refused.iter().any(|&pair| is_beside(&path_m, pair, (c.i, c.j)));
    let mut candidates = candidates::find(&map.poses, &path_m, &stations, &covariance);
    candidates.retain(|c| !is_refused(c));
    let places = Places { poses: &map.poses, observations: &map.observations, path_m: &path_m };
    let queries: Vec<Option<Cloud>> = stations
        .par_iter()
        .map(|&s| candidates.binary_search_by(|c| c.j.cmp(&s)).is_ok().then(|| places.query(s)))
        .collect();
    // One local map for all candidates that share it.
    let mut by_map: Vec<usize> = (0..candidates.len()).collect();
    by_map.sort_by_key(|&k| (candidates[k].i, k));
    let groups: Vec<&[usize]> = by_map.chunk_by(|&a, &b| candidates[a].i == candidates[b].i).collect();
    let done = AtomicUsize::new(0);
    let outcomes: Vec<Vec<(usize, Outcome)>> = groups
        .par_iter()
        .map(|group| {
            if cancelled.load(Ordering::Relaxed) {
                return Vec::new();
            }
            let i = candidates[group[0]].i;
            let local = places.map(i);
            let picture = Search::new(&local);
            let compared = group.iter().filter_map(|&k| {
                let c = &candidates[k];
                let query = queries[stations.binary_search(&c.j).ok()?].as_ref()?;
                let estimate = map.poses[i].between(map.poses[c.j]);
                Some((k, matching::compare(&local, &picture, query, estimate, c)))
            });
            let compared = compared.collect();
            told(done.fetch_add(group.len(), Ordering::Relaxed) + group.len(), candidates.len());
            compared
        })
        .collect();
    if cancelled.load(Ordering::Relaxed) {
        return Ok(None);
    }
    let mut found: Vec<(usize, Outcome)> = outcomes.into_iter().flatten().collect();
    found.sort_by_key(|(k, _)| *k);
    Ok(Some(found.into_iter().map(|(k, outcome)| (candidates[k], outcome)).collect()))
}

/// True if two pairs of poses are of the same two visits: each end within half a shortest loop of the other's. `path_m`: as
/// [`SlamMap::path_lengths_m`]; a pose that the map does not have is beside none.
pub fn is_beside(path_m: &[f64], (i, j): (usize, usize), (k, l): (usize, usize)) -> bool {
    let is_near = |a: usize, b: usize| match (path_m.get(a), path_m.get(b)) {
        (Some(a), Some(b)) => (a - b).abs() < SHORTEST_LOOP_M / 2.0,
        _ => false,
    };
    is_near(i, k) && is_near(j, l)
}

/// One joint optimisation with the automatic factors under a loss of this scale.
fn solve(map: &mut SlamMap, options: &joint::Options, scale: f64) -> Result<()> {
    let options = joint::Options { automatic_loss_scale: scale, ..*options };
    let (mut poses, mut factors) = (map.poses.clone(), map.human_factors.clone());
    joint::optimize(map, &mut poses, &mut factors, &options)?;
    (map.poses, map.human_factors) = (poses, factors);
    Ok(())
}

/// χ² of every automatic factor where the map now stands.
fn judge(map: &mut SlamMap) {
    for a in &mut map.automatic_factors {
        a.chi2 = a.factor.chi2(map.poses[a.factor.i], map.poses[a.factor.j]);
    }
}

fn largest_move_m(before: &[Pose2], after: &[Pose2]) -> f64 {
    let moves = before.iter().zip(after).map(|(a, b)| (b.translation() - a.translation()).norm());
    moves.fold(0.0, f64::max)
}
