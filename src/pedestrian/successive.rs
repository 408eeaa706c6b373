//! Successive collaborative mapping: FeetSLAM on ever longer parts of the walks.
//!
//! At each end (a path length or a time since the start) FeetSLAM runs on all walks cut there, always from their
//! start; its final maps are the priors of iteration 0 at the next end. The drift of a short distance is small, so the
//! map is right near the start, and holds the walks together from there on.

use super::align;
use super::feetslam::{FallBack, Group, Snapshot};
use super::footslam::Estimate;
use super::options::{Options, Start};
use super::transition_map::TransitionMap;
use super::walk::Walk;
use crate::error::{Error, Result};

/// Where rounds end.
#[derive(Debug, Clone, PartialEq)]
pub enum Ends {
    /// After these path lengths of each walker, metres.
    Lengths(Vec<f64>),
    /// After these times since each walker's start, seconds.
    Times(Vec<f64>),
}

/// What to do with a set of walks.
#[derive(Debug, Clone, PartialEq)]
pub enum Mode {
    /// Every walker alone.
    FootSlam,
    /// One round on the whole walks.
    FeetSlam,
    /// A round at each end; the end of the walks is always the last.
    Successive(Ends),
}

/// What a run found out.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// Per walker, after the last round.
    pub estimates: Vec<Estimate>,
    /// Sum of all walkers' maps.
    pub total: TransitionMap,
    /// Number of rounds.
    pub rounds: usize,
    /// Number of the last round's last iteration.
    pub iterations: usize,
    /// Change of the total map in the last iteration.
    pub change: f64,
    /// Particles times steps.
    pub particle_steps: u64,
    /// Why the aligned grid was given up, if it was.
    pub fall_back: Option<FallBack>,
    /// Where each walker was taken to start.
    pub starts: Vec<Start>,
    /// What each walk's lengths were multiplied by; 1 unless starts were unknown and scales asked for.
    pub scales: Vec<f64>,
    /// Who gave to the total map; walkers whose start could not be found are mapped alone.
    pub takes_part: Vec<bool>,
    /// Where starts were unknown: support and rival of every walker's place ([`align::Alignment`]).
    pub evidence: Option<Vec<[f64; 2]>>,
}

impl Ends {
    /// Checks that the ends are positive and ascend.
    ///
    /// # Errors
    /// [`Error::Input`] with the first that does not.
    pub fn validate(&self) -> Result<()> {
        let (Ends::Lengths(ends) | Ends::Times(ends)) = self;
        let mut before = 0.0;
        for &end in ends {
            if !(end > before && end.is_finite()) {
                let message = format!("found {end} after {before}, expected ascending numbers > 0");
                return Err(Error::input("ends", message));
            }
            before = end;
        }
        Ok(())
    }

    /// Steps of each walk in each round; ends that no walk reaches are the last.
    fn cuts(&self, walks: &[Walk]) -> Vec<Vec<usize>> {
        let cut = |end: f64, walk: &Walk| match self {
            Ends::Lengths(_) => walk.steps_to_length(end),
            Ends::Times(_) => walk.steps_to_time(end),
        };
        let whole: Vec<usize> = walks.iter().map(|w| w.steps.len()).collect();
        let (Ends::Lengths(ends) | Ends::Times(ends)) = self;
        let mut cuts: Vec<Vec<usize>> =
            ends.iter().map(|&end| walks.iter().map(|w| cut(end, w)).collect()).collect();
        cuts.retain(|cut| *cut != whole && cut.iter().any(|&steps| steps > 0));
        cuts.push(whole);
        cuts
    }
}

/// How well the start of an aligned walker is known: metres per axis, radians.
const ALIGNED_SIGMAS: (f64, f64) = (0.2, 0.02);

/// Runs a mode on walks that all start alike, or, if `unknown_starts`, anywhere: `start` is then the first walker's.
///
/// # Errors
/// [`Error::Input`] for walks, options or ends that make no sense.
pub fn run(
    walks: &[Walk],
    start: Start,
    unknown_starts: bool,
    mode: &Mode,
    options: &Options,
    observe: &mut dyn FnMut(&Snapshot),
) -> Result<Outcome> {
    options.validate()?;
    let alone = Options { iterations: 0, ..*options };
    let (options, cuts) = match mode {
        Mode::FootSlam => (&alone, Ends::Lengths(Vec::new()).cuts(walks)),
        Mode::FeetSlam => (options, Ends::Lengths(Vec::new()).cuts(walks)),
        Mode::Successive(ends) => {
            ends.validate()?;
            (options, ends.cuts(walks))
        }
    };
    // Checks walks and options before the alignment takes its time.
    let mut group = Group::new(walks, start, options)?;
    let alignment = unknown_starts.then(|| align::find_starts(walks, start, options)).transpose()?;
    let evidence =
        alignment.as_ref().map(|a| a.support.iter().zip(&a.rival).map(|(&s, &r)| [s, r]).collect());
    let (scaled, mut scales): (Vec<Walk>, Vec<f64>);
    scales = vec![1.0; walks.len()];
    let mut first = 0;
    if let Some(alignment) = alignment {
        scaled = walks.iter().zip(&alignment.scales).map(|(walk, &s)| walk.scaled(s)).collect();
        group = Group::new(&scaled, start, options)?;
        group.move_starts(&alignment.starts);
        for moved in &mut group.starts[1..] {
            (moved.position_sigma_m, moved.heading_sigma_rad) = ALIGNED_SIGMAS;
        }
        group.takes_part = alignment.placed;
        group.particle_steps += alignment.particle_steps;
        scales = alignment.scales;
        if *mode != Mode::FootSlam {
            // The walks were mapped alone and together there: iterations go on from that.
            group.begin_with(alignment.paths)?;
            first = 1;
        }
    }
    let (mut total, mut change, mut iterations) = (None, 1.0, 0);
    for (round, steps) in cuts.iter().enumerate() {
        let first = if round == 0 { first } else { 0 };
        iterations = group.round(round, first, steps, &mut |snapshot: &Snapshot| {
            change = snapshot.change;
            if round + 1 == cuts.len() {
                total = Some(snapshot.total.clone());
            }
            observe(snapshot);
        })?;
    }
    Ok(Outcome {
        total: total.ok_or_else(|| Error::Internal("no round was run".into()))?,
        rounds: cuts.len(),
        iterations,
        change,
        particle_steps: group.particle_steps,
        fall_back: group.fall_back,
        scales,
        takes_part: std::mem::take(&mut group.takes_part),
        evidence,
        starts: std::mem::take(&mut group.starts),
        estimates: group.into_latest(),
    })
}
