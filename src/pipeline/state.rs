//! What corrections change in a map, kept and put back.

use super::Corrector;
use crate::error::{Error, Result};
use crate::geometry::Pose2;
use crate::map::HumanFactor;

/// All that a correction changes in a map.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// `world_from_robot`, one per pose.
    pub poses: Vec<Pose2>,
    /// The human factors.
    pub human_factors: Vec<HumanFactor>,
}

impl Corrector {
    /// A copy of all that corrections have changed or may change.
    pub fn state(&self) -> State {
        State { poses: self.map.poses.clone(), human_factors: self.map.human_factors.clone() }
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
        Ok(())
    }
}
