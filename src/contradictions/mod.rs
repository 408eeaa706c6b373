//! Corrections that fight the others: found by what was seen, and by leaving each one out in turn.
//!
//! Two kinds of evidence. **Clash**: a colocation lays two visits on one another, and what one of them saw
//! must not stand where the other looked through (`clash::share`). **Strain**: a correction that says the same as
//! the others costs next to nothing; without it, the rest hardly relaxes. With χ²₋ₖ the cost (no ½) of what is left
//! without correction k at its own optimum, its strain is Δₖ = χ² − χ²₋ₖ − noiseₖ, noiseₖ being what its points scatter
//! about a straight line from each single pose, which no map could mend (leave-one-out as in geodetic outlier detection: Baarda
//! 1968). Where visits can be compared, clash decides; a strain is then a failure of the odometry that the
//! correction rightly mends. Where they cannot, strain does.
//!
//! A wrong correction bends the map under the right ones, which then clash too. So one is named at a time: the suspect
//! without which the others clash least, and the search goes on without it.

mod clash;

use rayon::prelude::*;

use crate::error::Result;
use crate::geometry::{Pose2, Scatter};
use crate::joint;
use crate::map::{Feature, HumanFactor, Mode, Observations, SlamMap};

/// A greater share of clashing returns is a contradiction. True corrections: at most 0.02 in simulations, below 0.01 on
/// ACES, from its odometry and scan-matched.
const MOST_CLASH: f64 = 0.05;
/// A strain so many times the median of the others' is a contradiction.
const MOST_STRAIN: f64 = 20.0;
/// … where there are at least so many others to compare with.
const LEAST_OTHERS: usize = 3;
/// A correction whose own terms stay at more than this χ² per thing that it ties was overruled by the rest.
const MOST_UNMET: f64 = 100.0;
/// Remaining clashes closer than this are as good as equal: strain decides.
const EQUAL_CLASH: f64 = 0.05;

/// More poses times corrections than this are not looked at.
const MOST_WORK: usize = 2_000_000;

/// One correction, and how it gets on with the rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Strain {
    /// Index into [`SlamMap::human_factors`].
    pub factor: usize,
    /// The correction's name.
    pub id: String,
    /// Share of what its two visits can compare that clashes, 0..=1; `None`: they see nothing of each other.
    pub clash: Option<f64>,
    /// χ² of its own terms per thing that it ties, without its points' noise and its weight: what is left unmet.
    pub unmet: f64,
    /// Δ: what the rest of the map pays for it, χ² (no ½).
    pub delta_chi2: f64,
    /// Δ per thing that the mode ties, over the median of the other corrections', which counts as 1 at least; 1 where there are
    /// too few others to tell.
    pub ratio: f64,
    /// Distance that the mode wants to be zero, if nobody had said it, metres; `None` if it wants none.
    pub offset_without_m: Option<f64>,
    /// Angle that the mode wants to be zero, if nobody had said it, radians.
    pub angle_without_rad: f64,
}

impl Strain {
    /// What speaks against it, for a person.
    pub fn reason(&self) -> String {
        let seen = match self.clash {
            Some(share) => {
                format!("{:.0} % of what its two visits saw does not fit together; ", 100.0 * share)
            }
            None => format!("it strains the map {:.0} times as much as the others; ", self.ratio),
        };
        let offset = self.offset_without_m.map_or(String::new(), |m| format!("{m:.2} m and "));
        let angle = self.angle_without_rad.to_degrees();
        format!("{seen}without it, its walls are {offset}{angle:.1}° off what it says")
    }

    /// True if it speaks against itself or is at odds with the rest.
    fn suspect(&self) -> bool {
        let fights = self.clash.map_or(self.ratio > MOST_STRAIN, |share| share > MOST_CLASH);
        fights || self.unmet > MOST_UNMET
    }

    /// Its visits see each other and agree: it is not the one to blame.
    fn confirmed(&self) -> bool {
        self.clash.is_some() && !self.suspect()
    }
}

/// What [`find`] found.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Contradictions {
    /// Every correction, in the order of the map; empty where there were too many to look at.
    pub strains: Vec<Strain>,
    /// Those that contradict the rest, the worst first, as they stood when they were found.
    pub named: Vec<Strain>,
}

/// Looks at every human factor of a map. The map stays as it is. n corrections need about n solves, and n more for each
/// that is named; where that is too much (more than 2 million poses times corrections), nothing is found.
///
/// # Errors
/// As [`joint::optimize`].
pub fn find(map: &SlamMap, options: &joint::Options) -> Result<Contradictions> {
    let mut found = Contradictions::default();
    let mut kept: Vec<usize> = (0..map.human_factors.len()).collect();
    if kept.len() * map.poses.len() > MOST_WORK {
        return Ok(found);
    }
    // Contradictions are judged by the plain cost: the paper's to the letter has no scale to judge by.
    let options = joint::Options { formulation: joint::Formulation::Smooth, ..*options };
    let mut poses = map.poses.clone();
    loop {
        let left_out = leave_each_out(map, &kept, &poses, &options)?;
        if found.strains.is_empty() {
            found.strains = left_out.iter().map(|l| l.strain.clone()).collect();
        }
        let Some(worst) = to_blame(map, &kept, &left_out) else { break };
        kept.retain(|&k| k != worst.strain.factor);
        poses.clone_from(&worst.poses);
        found.named.push(worst.strain.clone());
    }
    if found.named.len() > 1 {
        clear(map, &mut found.named, &mut kept, &poses, &options)?;
    }
    Ok(found)
}

/// While the wrong correction was in the map, right ones may have been named before it: whoever gets on with what is kept
/// is named no more.
fn clear(
    map: &SlamMap,
    named: &mut Vec<Strain>,
    kept: &mut Vec<usize>,
    poses: &[Pose2],
    options: &joint::Options,
) -> Result<()> {
    let mut k = 0;
    while k < named.len() {
        let factor = named[k].factor;
        let mut with: Vec<usize> = kept.clone();
        with.insert(with.partition_point(|&i| i < factor), factor);
        if leave_each_out(map, &with, poses, options)?.iter().any(|l| l.strain.suspect()) {
            k += 1;
        } else {
            *kept = with;
            named.remove(k);
        }
    }
    Ok(())
}

/// The map without one of its corrections.
struct LeftOut {
    strain: Strain,
    poses: Vec<Pose2>,
}

/// If there is a suspect: the correction without which the others clash least, and of several the most strained. Not
/// always the suspect: the wrong one may lie where nothing can be compared.
fn to_blame<'a>(map: &SlamMap, kept: &[usize], left_out: &'a [LeftOut]) -> Option<&'a LeftOut> {
    if !left_out.iter().any(|l| l.strain.suspect()) {
        return None;
    }
    let remaining_clash = |l: &LeftOut| -> f64 {
        let others = kept.iter().filter(|&&i| i != l.strain.factor);
        let clashes = others.filter_map(|&i| clash::share(map, &map.human_factors[i], &l.poses));
        clashes.filter(|&share| share > MOST_CLASH).sum()
    };
    let open: Vec<&LeftOut> = left_out.iter().filter(|l| !l.strain.confirmed()).collect();
    let remaining: Vec<f64> = open.par_iter().map(|l| remaining_clash(l)).collect();
    let least = remaining.iter().copied().fold(f64::INFINITY, f64::min);
    let candidates = open.into_iter().zip(remaining).filter(|c| c.1 < least + EQUAL_CLASH);
    candidates.map(|c| c.0).max_by(|a, b| a.strain.ratio.total_cmp(&b.strain.ratio))
}

fn leave_each_out(
    map: &SlamMap,
    kept: &[usize],
    poses: &[Pose2],
    options: &joint::Options,
) -> Result<Vec<LeftOut>> {
    let (chi2, poses, factors) = solve(map, kept, poses, options)?;
    let one = |(&k, factor): (&usize, &HumanFactor)| -> Result<LeftOut> {
        let others: Vec<usize> = kept.iter().copied().filter(|&i| i != k).collect();
        let (chi2_rest, without, _) = solve(map, &others, &poses, options)?;
        let mut moved = factor.clone();
        for feature in [&mut moved.a, &mut moved.b] {
            feature.segment = joint::refit(feature, &map.observations, &without);
        }
        let noise = noise(factor, &map.observations, options);
        let own = joint::factor_chi2(map, &poses, factor, options) - noise;
        let strain = Strain {
            factor: k,
            id: factor.id.clone(),
            clash: clash::share(map, factor, &poses),
            unmet: own / factor.weight / ties(factor.mode),
            delta_chi2: chi2 - chi2_rest - noise,
            ratio: 1.0,
            offset_without_m: moved.offset_m(),
            angle_without_rad: moved.angle_rad(),
        };
        Ok(LeftOut { strain, poses: without })
    };
    let mut all: Vec<LeftOut> = kept.par_iter().zip(&factors).map(one).collect::<Result<_>>()?;
    let per_tie = |l: &LeftOut| l.strain.delta_chi2 / ties(map.human_factors[l.strain.factor].mode);
    let strains: Vec<f64> = all.iter().map(per_tie).collect();
    for (k, left_out) in all.iter_mut().enumerate() {
        let mut others: Vec<f64> = strains.iter().enumerate().filter(|o| o.0 != k).map(|o| *o.1).collect();
        others.sort_by(f64::total_cmp);
        if others.len() >= LEAST_OTHERS {
            left_out.strain.ratio = strains[k] / others[others.len() / 2].max(1.0);
        }
    }
    Ok(all)
}

/// χ² at the optimum with only some of the human factors, and the poses there.
fn solve(
    map: &SlamMap,
    kept: &[usize],
    poses: &[Pose2],
    options: &joint::Options,
) -> Result<(f64, Vec<Pose2>, Vec<HumanFactor>)> {
    let mut factors: Vec<HumanFactor> = kept.iter().map(|&k| map.human_factors[k].clone()).collect();
    let mut poses = poses.to_vec();
    let report = joint::optimize(map, &mut poses, &mut factors, options)?;
    Ok((2.0 * report.final_cost, poses, factors))
}

/// How many things a mode ties.
fn ties(mode: Mode) -> f64 {
    match mode {
        Mode::Colocation => 3.0,
        Mode::Collinear => 2.0,
        Mode::Perpendicular | Mode::Parallel => 1.0,
    }
}

/// What a factor's points scatter about a straight line, each pose by itself, in the cost's units.
fn noise(factor: &HumanFactor, observations: &Observations, options: &joint::Options) -> f64 {
    let of = |feature: &Feature| -> f64 {
        let sightings = feature.points_by_sighting(observations);
        let scatter = |points: &[u32]| Scatter::of(points.iter().map(|&p| observations.point(p as usize)));
        let sum: f64 = sightings.map(|(_, points)| scatter(points).across_squared()).sum();
        match options.normalization {
            joint::Normalization::Sum => sum,
            joint::Normalization::Mean => sum / feature.points.len() as f64,
        }
    };
    factor.weight * (of(&factor.a) + of(&factor.b)) / options.observation_sigma_m.powi(2)
}
