//! A simulated person who looks at the map as it stands and draws the strokes that repair it, from a reference.
//!
//! A person knows which pieces of wall are one and the same (the reference: a true trajectory, or hand-checked relations),
//! and sees on the map that they are apart. First come faults: what is farther apart than the map's own chain can explain, most
//! surprising first (the squared disagreement over what the chain's covariance allows between the two looks). So a torn step is
//! mended where it is torn, and a slip across its whole length. Such a correction is insisted on, with the weight `INSISTING`:
//! least squares would believe the chain. Then comes drift, what is farthest apart first. The person draws along the
//! two pieces with some noise per coordinate, now and then on the wrong wall, and says colocation where both looks show the
//! same corner and are visibly displaced along the wall too, collinear else, parallel where they share no wall. Pieces that are turned by nearly 90° or more
//! wait until another stroke has brought them nearer: a line has no direction, the tool would turn them the short way.
//!
//! [`repair`] is the person at work: look, draw, see what the strokes catch, let the map heal, look again, until nothing is
//! visibly apart or the budget is spent. Strokes that catch something else than was meant (walls cross where a map is torn)
//! are drawn elsewhere instead: the preview is free. The number of corrections is the human effort.

mod reference;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal, StandardUniform};

pub use reference::Reference;

use crate::error::{Error, Result};
use crate::geometry::Vec2;
use crate::map::{Correction, Mode, SlamMap, Stroke};
use crate::pipeline::{CorrectionReport, Corrector};
use crate::sights::{Chain, Look, Pieces, Sight};

/// A disagreement of more than this many standard deviations of the chain is not drift but a fault.
const FAULT_SIGMAS: f64 = 7.0;
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
    /// Index of what was drawn among the person's sights.
    sight: usize,
}

/// Someone who knows the building.
#[derive(Debug, Clone)]
pub struct Person {
    settings: Settings,
    sights: Vec<Sight>,
    /// How well the reference knows where two looks lie: metres, radians.
    known: (f64, f64),
    drawn: Vec<bool>,
    /// Sights whose strokes would catch something else on the map as it stands.
    unclear: Vec<usize>,
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
        let mut pieces = Pieces::new(&map.observations);
        let pairs = reference.pairs(map)?;
        let sights: Vec<Sight> =
            pairs.into_iter().flat_map(|(pair, i_from_j)| pieces.sights(pair, i_from_j)).collect();
        Ok(Person {
            settings: *settings,
            known: reference.sigmas(),
            drawn: vec![false; sights.len()],
            unclear: Vec::new(),
            sights,
            random: ChaCha8Rng::seed_from_u64(settings.seed),
            strokes: 0,
        })
    }

    /// From now on stroke b lies on the wrong wall with this probability: 0 and 1 choose which strokes are wrong.
    ///
    /// # Errors
    /// [`Error::Input`] if it is not within 0..=1.
    pub fn set_wrong(&mut self, wrong: f64) -> Result<()> {
        let settings = Settings { wrong, ..self.settings };
        settings.validate()?;
        self.settings = settings;
        Ok(())
    }

    /// What the person would draw on the map as it stands; `None`: nothing is visibly apart. The map has the poses and points
    /// that the person got to know; only where they are may have changed.
    pub fn look(&mut self, map: &SlamMap) -> Option<Drawn> {
        let chain = Chain::new(map);
        let mut worst: Option<(bool, f64, f64, usize)> = None;
        for (k, sight) in self.sights.iter().enumerate() {
            if self.drawn[k] || self.unclear.contains(&k) {
                continue;
            }
            let Some((apart_m, surprise)) = sight.disagreement(map, &chain, self.known) else { continue };
            let is_fault = surprise > FAULT_SIGMAS * FAULT_SIGMAS;
            let rank = if is_fault { surprise } else { apart_m };
            let is_worse = worst.is_none_or(|(fault, most, ..)| (is_fault, rank) > (fault, most));
            if apart_m >= self.settings.visible_m && is_worse {
                worst = Some((is_fault, rank, apart_m, k));
            }
        }
        let (is_fault, _, apart_m, k) = worst?;
        let sight = self.sights[k];
        let share: f64 = StandardUniform.sample(&mut self.random);
        let wrong = sight.wrong_b.filter(|_| share < self.settings.wrong);
        // Whoever sees no displacement along the wall does not claim to know the place along it: no hand draws it to the centimetre.
        let is_beside = sight.mode == Mode::Colocation && sight.along_m(map) < self.settings.visible_m;
        let mode = if is_beside { Mode::Collinear } else { sight.mode };
        let correction = Correction {
            id: format!("p{}", self.strokes + 1),
            mode,
            a: self.draw(sight.a),
            b: self.draw(wrong.unwrap_or(sight.b)),
            weight: if is_fault { INSISTING } else { 1.0 },
            enabled: true,
        };
        Some(Drawn { correction, is_wrong: wrong.is_some(), apart_m, sight: k })
    }

    /// Keeps in mind what became of a drawing: on the map (the right wall needs no second stroke, and the map has changed),
    /// or not drawn after all because it would have caught something else.
    fn remember(&mut self, drawn: &Drawn, on_the_map: bool) {
        if on_the_map {
            self.unclear.clear();
            self.drawn[drawn.sight] = !drawn.is_wrong;
            self.strokes += 1;
        } else {
            self.unclear.push(drawn.sight);
        }
    }

    fn draw(&mut self, look: Look) -> Stroke {
        let points = look.ends.map(|end| {
            let noise =
                Vec2::new(StandardNormal.sample(&mut self.random), StandardNormal.sample(&mut self.random));
            end + noise * self.settings.drawing_noise_m
        });
        Stroke::Pose { pose: look.pose, points }
    }
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
        let is_understood = corrector.preview(&drawn.correction)?.is_understood(&drawn.correction);
        person.remember(&drawn, is_understood);
        if !is_understood {
            continue;
        }
        let report = corrector.apply(&drawn.correction)?;
        done.push((drawn, report));
    }
    Ok(done)
}
