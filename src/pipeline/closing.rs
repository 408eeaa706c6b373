//! Automatic factors of a map under correction: found anew, refused, taken back.

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use super::{Corrector, Reassociation, judged, milliseconds};
use crate::closures;
use crate::error::Result;
use crate::joint;

impl Corrector {
    /// Finds all automatic factors anew, from the chain and the corrections alone: after a correction, or after one was taken
    /// back. A step of its own, so that a person sees a stroke's effect at once. `None`, and the map as it was, if
    /// `cancelled` becomes true on the way.
    ///
    /// # Errors
    /// [`crate::error::Error`] of the joint optimisation.
    pub fn reassociate(
        &mut self,
        options: &closures::Options,
        progress: &(dyn Fn(closures::Progress) + Sync),
        cancelled: &AtomicBool,
    ) -> Result<Option<Reassociation>> {
        let start = Instant::now();
        let found = closures::reassociate(&mut self.map, &self.options.joint, options, progress, cancelled)?;
        Ok(found.map(|report| Reassociation { report, total_ms: milliseconds(start) }))
    }

    /// Takes back the automatic factors between the two visits that these poses belong to, and optimises without them; false,
    /// and the map as it was, if there are none. The next re-association may find them again, unless its options refuse
    /// the pair.
    ///
    /// # Errors
    /// [`crate::error::Error`] of the joint optimisation.
    pub fn refuse(&mut self, pair: (usize, usize)) -> Result<bool> {
        let path_m = self.map.path_lengths_m();
        let before = self.map.automatic_factors.clone();
        self.map.automatic_factors.retain(|a| !closures::is_beside(&path_m, pair, (a.factor.i, a.factor.j)));
        if self.map.automatic_factors.len() == before.len() {
            return Ok(false);
        }
        let outcome = self.settle();
        if outcome.is_err() {
            self.map.automatic_factors = before;
        }
        outcome.map(|()| true)
    }

    /// Takes back the correction, or the automatic factor, of this name, and optimises without it; false if there is
    /// none. With a correction go all automatic factors, since it may have caused any of them.
    ///
    /// # Errors
    /// [`crate::error::Error`] of the joint optimisation.
    pub fn remove(&mut self, name: &str) -> Result<bool> {
        let before = (self.map.human_factors.clone(), self.map.automatic_factors.clone());
        self.map.human_factors.retain(|f| f.id != name);
        if self.map.human_factors.len() < before.0.len() {
            self.map.automatic_factors.clear();
        } else {
            self.map.automatic_factors.retain(|a| a.name() != name);
            if self.map.automatic_factors.len() == before.1.len() {
                return Ok(false);
            }
        }
        let outcome = self.settle();
        if outcome.is_err() {
            (self.map.human_factors, self.map.automatic_factors) = before;
        }
        outcome.map(|()| true)
    }

    /// Optimises the map with the factors that it now has.
    fn settle(&mut self) -> Result<()> {
        let (mut poses, mut factors) = (self.map.poses.clone(), self.map.human_factors.clone());
        joint::optimize(&self.map, &mut poses, &mut factors, &self.options.joint)?;
        self.map.automatic_factors = judged(&self.map.automatic_factors, &poses);
        (self.map.poses, self.map.human_factors) = (poses, factors);
        Ok(())
    }
}
