//! Walkers whose start frames are unknown: where each started, seen from the first.
//!
//! Every walker is mapped alone (FootSLAM), and its path made consistent with itself ([`super::smoothing`]). Paths, not counts, are
//! moved (counts would smear) and drawn on a common grid. How well a walker B fits the map A of those placed so far is
//! the evidence that one map made both,
//!
//! Σ_h [ln B(α + N_A + N_B) − ln B(α + N_A) − ln B(α + N_B) + ln B(α)],  B = multivariate Beta (Dirichlet-multinomial).
//!
//! Candidates come from `super::hough` and are refined by coordinate search. A walker is placed if its best place has clearly
//! more evidence than the best *other* place: the other places are the sample of what chance does, and a building that
//! looks alike in two places gives none. Then all who are placed are made consistent with each other, and the others are tried
//! again on the larger map. Who is left over is mapped alone.

use rayon::prelude::*;

use super::chain::Chain;
use super::feetslam::Group;
use super::options::{OdometryNoise, Options, Start};
use super::overlap::{Boards, Fit, Placing, Shape};
use super::smoothing::{refine, smooth};
use super::walk::Walk;
use crate::error::Result;
use crate::geometry::{Pose2, Vec2, wrap_angle};

/// A walker is placed if support (that many times) less rival reaches [`ENOUGH`], both as shares of the evidence against itself:
/// a look-alike costs one who fits well less than one who hardly fits. Where both come from: docs/DECISIONS.md.
const WEIGHT_OF_FIT: f64 = 1.2;
/// Against the map of one walker, of two, of three and more: the larger a map, the more places a stranger may fit by chance.
const ENOUGH: [f64; 3] = [0.33, 0.375, 0.42];
/// Rounds of estimating scales from paths that are consistent.
const RESCALINGS: usize = 5;
/// The start pose is that of the dead reckoning of so many metres, laid onto the path that was found: over fewer the path's own error
/// turns it, over more the drift does.
const START_M: f64 = 15.0;

/// The heading noise that a walk itself shows is believed down to this share of the options'.
const LEAST_NOISE: f64 = 0.2;
/// Rounds of taking noise and drift from a walk: a part that was folded wrongly needs some until the odometry straightens it.
const CALIBRATIONS: usize = 4;

/// Where walkers start.
#[derive(Debug, Clone, PartialEq)]
pub struct Alignment {
    /// Start pose of each walker in the first one's frame; of those left out, as if alone.
    pub starts: Vec<Pose2>,
    /// What each walk's lengths are multiplied by to fit the first one's; 1 unless asked for.
    pub scales: Vec<f64>,
    /// Who was placed.
    pub placed: Vec<bool>,
    /// Evidence of the best place over that against itself, per walker; 1 for the first.
    pub support: Vec<f64>,
    /// The same of the best place but that one; 0 for the first.
    pub rival: Vec<f64>,
    /// The pose after each step (and at the start), made consistent with all who were placed.
    pub paths: Vec<Vec<Pose2>>,
    /// Particles times steps.
    pub particle_steps: u64,
}

/// One walker's own map as a path.
struct Member {
    walk: Walk,
    noise: OdometryNoise,
    chain: Chain,
    nodes: Vec<Pose2>,
    /// Positions of the nodes, and after every step.
    corners: Vec<Vec2>,
    path: Vec<Vec2>,
    own_evidence: f64,
    particle_steps: u64,
}

/// Finds the starts; the first walker's is `start`.
///
/// # Errors
/// As [`Group::new`] and [`Group::round`].
pub fn find_starts(walks: &[Walk], start: Start, options: &Options) -> Result<Alignment> {
    let alone: Vec<Result<Member>> =
        walks.par_iter().map(|walk| Member::alone(walk, start, options)).collect();
    let mut members = alone.into_iter().collect::<Result<Vec<Member>>>()?;
    let count = walks.len();
    let mut alignment = Alignment {
        starts: vec![start.pose; count],
        scales: vec![1.0; count],
        placed: vec![false; count],
        support: vec![0.0; count],
        rival: vec![0.0; count],
        paths: Vec::new(),
        particle_steps: members.iter().map(|m| m.particle_steps).sum(),
    };
    (alignment.placed[0], alignment.support[0]) = (true, 1.0);
    loop {
        // Everybody not yet placed against everybody placed.
        let placed: Vec<Shape> =
            members.iter().zip(&alignment.placed).filter(|(_, p)| **p).map(|(m, _)| m.shape()).collect();
        let enough = ENOUGH[placed.len().min(ENOUGH.len()) - 1];
        let boards = Boards::new(&placed, start.pose.translation(), options.alpha)?;
        let open: Vec<usize> = (0..count).filter(|&j| !alignment.placed[j]).collect();
        let fits: Vec<Option<Fit>> = open
            .par_iter()
            .map(|&j| boards.best_fit(members[j].shape(), members[j].own_evidence, options))
            .collect();
        let mut found_one = false;
        for (&j, fit) in open.iter().zip(fits) {
            let Some(fit) = fit else { continue };
            (alignment.support[j], alignment.rival[j]) = (fit.support, fit.rival);
            if WEIGHT_OF_FIT * fit.support - fit.rival >= enough {
                members[j].put(fit.placing);
                alignment.scales[j] = fit.placing.scale;
                (alignment.placed[j], found_one) = (true, true);
            }
        }
        if !found_one {
            break;
        }
        make_consistent(&mut members, &alignment.placed, smooth);
        for _ in 0..if options.align_scale { RESCALINGS } else { 0 } {
            // What is left of a scale error strains the dead reckoning of that walker against the first one's.
            let reference = members[0].chain.stretch(&members[0].nodes);
            let placed = alignment.placed.iter().zip(&mut alignment.scales);
            for (member, (_, scale)) in members.iter_mut().zip(placed).skip(1).filter(|(_, (p, _))| **p) {
                let rest = member.chain.stretch(&member.nodes) / reference;
                member.rescale(rest);
                *scale *= rest;
            }
            make_consistent(&mut members, &alignment.placed, smooth);
        }
    }
    make_consistent(&mut members, &alignment.placed, refine);
    // The first walker's start is given: the whole world follows it.
    let world = start.pose.compose(members[0].start(&walks[0]).inverse());
    for (j, member) in members.iter_mut().enumerate() {
        let given = walks[j].scaled(alignment.scales[j]);
        let alone = || start.pose.compose(member.start(&given).inverse());
        let motion = if alignment.placed[j] { world } else { alone() };
        member.nodes.iter_mut().for_each(|node| *node = motion.compose(*node));
        alignment.starts[j] = member.start(&given);
        alignment.paths.push(member.chain.filled(&member.nodes));
    }
    Ok(alignment)
}

impl Member {
    /// A walker alone, in its own frame, with its own aligned grid.
    fn alone(walk: &Walk, start: Start, options: &Options) -> Result<Member> {
        let alone = Options { iterations: 0, ..*options };
        let mut group = Group::new(std::slice::from_ref(walk), start, &alone)?;
        group.round(0, 0, &[walk.steps.len()], &mut |_| ())?;
        let chain = Chain::new(walk, &options.noise);
        let mut nodes = vec![chain.along(walk, &group.latest()[0].best)];
        smooth(&[&chain], &mut nodes);
        // The options' noise must cover any sensor; what this walk shows of its own is often far less. A drift that stays the
        // same is taken out, so that it need not be paid for as noise.
        let mut noise = options.noise;
        let (mut walk, mut chain) = (walk.clone(), chain);
        for _ in 0..CALIBRATIONS {
            walk = walk.turned_back(chain.drift_rad_per_m(&walk, &nodes[0]));
            if let Some(shown_rad) = chain.heading_noise_rad(&walk, &nodes[0]) {
                let given_rad = options.noise.heading_rad;
                noise.heading_rad = shown_rad.clamp(LEAST_NOISE * given_rad, given_rad);
            }
            chain = Chain::new(&walk, &noise);
            smooth(&[&chain], &mut nodes);
        }
        let mut member = Member {
            walk,
            noise,
            chain,
            nodes: nodes.swap_remove(0),
            corners: Vec::new(),
            path: Vec::new(),
            own_evidence: 0.0,
            particle_steps: group.particle_steps,
        };
        member.draw_path();
        member.own_evidence = member.shape().own_evidence(start.pose.translation(), options.alpha)?;
        Ok(member)
    }

    fn shape(&self) -> Shape<'_> {
        Shape { corners: &self.corners, path: &self.path }
    }

    fn draw_path(&mut self) {
        let poses = self.chain.filled(&self.nodes);
        self.path = poses.iter().map(|p| p.translation()).collect();
        self.corners = self.nodes.iter().map(|p| p.translation()).collect();
    }

    /// Multiplies the lengths of the dead reckoning; the nodes stay.
    fn rescale(&mut self, factor: f64) {
        if factor != 1.0 {
            self.walk = self.walk.scaled(factor);
            self.chain = Chain::new(&self.walk, &self.noise);
        }
    }

    fn put(&mut self, placing: Placing) {
        self.rescale(placing.scale);
        for node in &mut self.nodes {
            let t = placing.of(node.translation());
            *node = Pose2::new(t.x, t.y, wrap_angle(placing.motion.theta_rad + node.theta_rad));
        }
        self.draw_path();
    }

    /// Start pose: the first metres of the dead reckoning as it was given, laid onto the path.
    fn start(&self, given: &Walk) -> Pose2 {
        let poses = self.chain.filled(&self.nodes);
        let count = given.steps_to_length(START_M).min(given.steps.len());
        let from: Vec<Vec2> =
            given.track(Pose2::IDENTITY)[..=count].iter().map(|p| p.translation()).collect();
        let to: Vec<Vec2> = poses[..=count].iter().map(|p| p.translation()).collect();
        super::metrics::rigid_fit(&from, &to)
    }
}

/// All who are placed are made consistent with each other.
fn make_consistent(members: &mut [Member], placed: &[bool], how: impl Fn(&[&Chain], &mut [Vec<Pose2>])) {
    let inside: Vec<usize> = (0..members.len()).filter(|&j| placed[j]).collect();
    let mut nodes: Vec<Vec<Pose2>> = inside.iter().map(|&j| members[j].nodes.clone()).collect();
    let chains: Vec<&Chain> = inside.iter().map(|&j| &members[j].chain).collect();
    how(&chains, &mut nodes);
    for (j, nodes) in inside.into_iter().zip(nodes) {
        members[j].nodes = nodes;
        members[j].draw_path();
    }
}
