//! A simulated person who looks at the map as it stands and draws the strokes that repair it, from a reference.
//!
//! A person knows which pieces of wall are one and the same (the reference: a true trajectory, or hand-checked relations),
//! and sees on the map that they are apart. Of all that is visibly apart, the pair is taken that the map's own chain explains
//! least: the squared disagreement over what the chain's covariance allows between the two looks. So a torn step is mended
//! where it is torn, a slip across its whole length, and drift where a loop closes. The person draws along the two pieces
//! with some noise per coordinate, now and then on the wrong wall, and says colocation where both looks show the same corner,
//! collinear on a plain wall, parallel where they share no wall. What the chain plainly excludes (more than
//! `INSIST_SIGMAS`) is insisted on: such a correction gets the weight `INSISTING`, or least squares would believe the chain.
//!
//! [`repair`] is the person at work: look, draw, let the map heal, look again, until nothing is visibly apart or the budget is
//! spent. The number of strokes is the human effort.

mod chain;
mod pieces;
mod reference;
mod sights;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal, StandardUniform};

pub use reference::Reference;

use crate::error::{Error, Result};
use crate::geometry::{Segment, Vec2};
use crate::map::{Correction, Mode, SlamMap, Stroke};
use crate::pipeline::{CorrectionReport, Corrector};
use chain::Chain;
use sights::{Look, Sight, line_angle};

/// A disagreement of more than this many standard deviations of the chain is not drift but a fault.
const INSIST_SIGMAS: f64 = 7.0;
/// Weight of a correction that is insisted on.
const INSISTING: f64 = 1e3;

/// How the person draws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// The same seed and settings give the same strokes, to the byte.
    pub seed: u64,
    /// Standard deviation of a drawn end point, per coordinate, metres, 0..=10.
    pub drawing_noise_m: f64,
    /// Probability that stroke b lies on another wall near the right one, 0..=1.
    pub wrong: f64,
    /// What is less apart than this is not seen, metres, > 0.
    pub visible_m: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Settings { seed: 1, drawing_noise_m: 0.03, wrong: 0.0, visible_m: 0.1 }
    }
}

impl Settings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`Error::Input`] at the setting that is out of range.
    pub fn validate(&self) -> Result<()> {
        let ranges =
            [("drawing noise", self.drawing_noise_m, 10.0), ("probability of a wrong wall", self.wrong, 1.0)];
        for (name, value, most) in ranges {
            if !(0.0..=most).contains(&value) {
                let message = format!("found {value}, expected a number from 0 to {most}");
                return Err(Error::input(name, message));
            }
        }
        if !(self.visible_m.is_finite() && self.visible_m > 0.0) {
            let message = format!("found {}, expected a number > 0", self.visible_m);
            return Err(Error::input("visible distance", message));
        }
        Ok(())
    }
}

/// A correction as drawn, with what only the simulation knows.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawn {
    /// The correction, its strokes anchored to poses.
    pub correction: Correction,
    /// True if stroke b lies on the wrong wall.
    pub is_wrong: bool,
    /// How far the two pieces were apart on the map, metres.
    pub apart_m: f64,
}

/// Someone who knows the building.
#[derive(Debug, Clone)]
pub struct Person {
    settings: Settings,
    sights: Vec<Sight>,
    drawn: Vec<bool>,
    random: ChaCha8Rng,
    strokes: usize,
}

impl Person {
    /// Gets to know the map's scans and what the reference says about them.
    ///
    /// # Errors
    /// [`Error::Input`] for settings out of range, or a reference that shares no stamp with the map.
    pub fn new(map: &SlamMap, reference: Reference, settings: &Settings) -> Result<Person> {
        settings.validate()?;
        let mut pieces = sights::Pieces::new(&map.observations);
        let pairs = reference.pairs(map)?;
        let sights: Vec<Sight> =
            pairs.into_iter().flat_map(|(pair, i_from_j)| pieces.sights(pair, i_from_j)).collect();
        Ok(Person {
            settings: *settings,
            drawn: vec![false; sights.len()],
            sights,
            random: ChaCha8Rng::seed_from_u64(settings.seed),
            strokes: 0,
        })
    }

    /// What the person would draw on the map as it stands; `None`: nothing is visibly apart. The map has the poses and points
    /// that the person got to know; only where they are may have changed.
    pub fn look(&mut self, map: &SlamMap) -> Option<Drawn> {
        let chain = Chain::new(map);
        let mut worst: Option<(f64, f64, usize)> = None;
        for (k, sight) in self.sights.iter().enumerate().filter(|(k, _)| !self.drawn[*k]) {
            let (apart_m, surprise) = disagreement(sight, map, &chain, self.settings.drawing_noise_m);
            if apart_m >= self.settings.visible_m && worst.is_none_or(|(most, ..)| surprise > most) {
                worst = Some((surprise, apart_m, k));
            }
        }
        let (surprise, apart_m, k) = worst?;
        let sight = self.sights[k];
        let share: f64 = StandardUniform.sample(&mut self.random);
        let wrong = sight.wrong_b.filter(|_| share < self.settings.wrong);
        // Who has drawn on the wrong wall still sees the right one.
        self.drawn[k] = wrong.is_none();
        self.strokes += 1;
        let correction = Correction {
            id: format!("p{}", self.strokes),
            mode: sight.mode,
            a: self.draw(sight.a),
            b: self.draw(wrong.unwrap_or(sight.b)),
            weight: if surprise > INSIST_SIGMAS * INSIST_SIGMAS { INSISTING } else { 1.0 },
            enabled: true,
        };
        Some(Drawn { correction, is_wrong: wrong.is_some(), apart_m })
    }

    fn draw(&mut self, look: Look) -> Stroke {
        let points = look.ends.map(|end| {
            let noise = Vec2::new(
                StandardNormal.sample(&mut self.random),
                StandardNormal.sample(&mut self.random),
            );
            end + noise * self.settings.drawing_noise_m
        });
        Stroke::Pose { pose: look.pose, points }
    }
}

/// How far two looks at one wall are apart on the map, metres, and the square of that in the chain's own standard deviations.
fn disagreement(sight: &Sight, map: &SlamMap, chain: &Chain, noise_m: f64) -> (f64, f64) {
    let place = |look: &Look| look.ends.map(|p| map.poses[look.pose].transform_point(p));
    let (a, b) = (place(&sight.a), place(&sight.b));
    let [line_a, line_b] = [a, b].map(|[p, q]| Segment::from_ends(p, q));
    let turn_rad = line_angle(line_b.direction_rad - line_a.direction_rad);
    let (_, across_m) = line_a.along_across(line_b.centre);
    let (offset_m, apart_m) = match sight.mode {
        Mode::Colocation => {
            let gaps = [(b[0] - a[0]).norm(), (b[1] - a[1]).norm()];
            ((line_b.centre - line_a.centre).norm(), gaps[0].max(gaps[1]))
        }
        Mode::Collinear => {
            let gaps = b.map(|end| line_a.along_across(end).1.abs());
            (across_m.abs(), gaps[0].max(gaps[1]))
        }
        Mode::Parallel | Mode::Perpendicular => (0.0, turn_rad.sin().abs() * line_b.half_length_m),
    };
    let (position, heading) = chain.variances(sight.a.pose, sight.b.pose, line_b.centre);
    // What the drawing itself leaves open.
    let drawn_m = noise_m.max(0.01);
    let drawn_rad = drawn_m / line_a.half_length_m.min(line_b.half_length_m);
    let surprise = offset_m.powi(2) / (position + drawn_m.powi(2))
        + turn_rad.powi(2) / (heading + drawn_rad.powi(2));
    (apart_m, surprise)
}

/// The person at work on a map: what was drawn, and what became of it.
///
/// # Errors
/// As [`Corrector::apply`].
pub fn repair(
    corrector: &mut Corrector,
    person: &mut Person,
    strokes: usize,
) -> Result<Vec<(Drawn, CorrectionReport)>> {
    let mut done = Vec::new();
    while done.len() < strokes {
        let Some(drawn) = person.look(corrector.map()) else { break };
        let report = corrector.apply(&drawn.correction)?;
        done.push((drawn, report));
    }
    Ok(done)
}
