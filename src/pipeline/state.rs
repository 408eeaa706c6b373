//! What corrections change in a map, kept and put back; how well every factor is satisfied; and single strokes.

use super::{Corrector, Options};
use crate::error::{Error, Result};
use crate::geometry::{Pose2, Vec2};
use crate::interpret::{self, Caught};
use crate::joint;
use crate::map::{AutomaticFactor, HumanFactor, Mode, SlamMap};

/// All that a correction or a re-association changes in a map.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// `world_from_robot`, one per pose.
    pub poses: Vec<Pose2>,
    /// The human factors.
    pub human_factors: Vec<HumanFactor>,
    /// The automatic factors.
    pub automatic_factors: Vec<AutomaticFactor>,
}

impl State {
    /// Moved rigidly.
    #[must_use]
    pub fn turned(mut self, world_from_map: Pose2) -> State {
        if world_from_map == Pose2::IDENTITY {
            return self;
        }
        for pose in &mut self.poses {
            *pose = world_from_map.compose(*pose);
        }
        for feature in self.human_factors.iter_mut().flat_map(|f| [&mut f.a, &mut f.b]) {
            feature.segment = feature.segment.transformed(world_from_map);
        }
        self
    }
}

/// How far a human factor of the map is from what the person said, as the map stands.
#[derive(Debug, Clone, PartialEq)]
pub struct Standing {
    /// The correction's name.
    pub id: String,
    /// Its mode.
    pub mode: Mode,
    /// Distance that the mode wants to be zero, metres; `None` if it wants none.
    pub offset_m: Option<f64>,
    /// Angle that the mode wants to be zero, radians, ≥ 0.
    pub angle_rad: f64,
    /// Σ‖r‖² of the factor's terms: no ½, no loss.
    pub chi2: f64,
}

impl Corrector {
    /// A copy of all that corrections have changed or may change.
    pub fn state(&self) -> State {
        let SlamMap { poses, human_factors, automatic_factors, .. } = &self.map;
        State {
            poses: poses.clone(),
            human_factors: human_factors.clone(),
            automatic_factors: automatic_factors.clone(),
        }
    }

    /// Puts a copy back.
    ///
    /// # Errors
    /// [`Error::Internal`] if it is of another map: it has another number of poses.
    pub fn restore(&mut self, state: State) -> Result<()> {
        if state.poses.len() != self.map.poses.len() {
            return Err(Error::Internal("a state of another map was to be restored".into()));
        }
        self.map.poses = state.poses;
        self.map.human_factors = state.human_factors;
        self.map.automatic_factors = state.automatic_factors;
        Ok(())
    }

    /// Moves the whole map rigidly: nothing bends.
    pub fn turn(&mut self, world_from_map: Pose2) {
        let state = self.state().turned(world_from_map);
        self.map.poses = state.poses;
        self.map.human_factors = state.human_factors;
    }

    /// Other options from here on; the map stays as it is.
    ///
    /// # Errors
    /// [`Error::Input`] for options out of range.
    pub fn set_options(&mut self, options: Options) -> Result<()> {
        options.interpret.validate()?;
        options.joint.validate()?;
        self.options = options;
        Ok(())
    }

    /// What one stroke, given by its ends in the world, catches on the map as it stands.
    ///
    /// # Errors
    /// The reason, for a person, why it catches nothing.
    pub fn catch(&self, ends: [Vec2; 2]) -> std::result::Result<Caught, String> {
        let (map, options) = (&self.map, &self.options.interpret);
        interpret::catch(&map.observations, &map.poses, &self.reach, ends, options)
    }

    /// Every human factor as the map stands, in the order of the map.
    pub fn standings(&self) -> Vec<Standing> {
        let standing = |factor: &HumanFactor| Standing {
            id: factor.id.clone(),
            mode: factor.mode,
            offset_m: factor.offset_m(),
            angle_rad: factor.angle_rad(),
            chi2: joint::factor_chi2(&self.map, &self.map.poses, factor, &self.options.joint),
        };
        self.map.human_factors.iter().map(standing).collect()
    }
}
