//! Corrections that contradict the rest, set aside: all are applied, and where some are named, the map is corrected anew
//! without the one whose absence leaves least to blame.

use super::{CorrectionReport, Corrector, State};
use crate::contradictions::{self, Strain};
use crate::error::Result;
use crate::map::Correction;

/// At most so many of the named are tried, the worst first.
const MOST_TRIED: usize = 6;

/// What [`Corrector::apply_agreeing`] did.
#[derive(Debug, Clone, PartialEq)]
pub struct Agreement {
    /// One report per correction, in order; of one that was set aside, the one from when it was applied.
    pub reports: Vec<CorrectionReport>,
    /// Indices of the corrections that were set aside, with what spoke against them, in the order of finding.
    pub set_aside: Vec<(usize, Strain)>,
    /// What still contradicts the rest: all that was named, where nothing is to be set aside, and corrections that the map
    /// brought with it.
    pub left: Vec<Strain>,
}

impl Corrector {
    /// Applies corrections in order, and without those that contradict the rest unless `keep`. `applied` is called after
    /// every single one, also when the map is corrected anew.
    ///
    /// # Errors
    /// As [`Corrector::apply`].
    pub fn apply_agreeing(
        &mut self,
        corrections: &[Correction],
        keep: bool,
        applied: &dyn Fn(&Correction),
    ) -> Result<Agreement> {
        let start = self.state();
        let mut wanted = corrections.to_vec();
        let mut tried = self.attempt(&start, &wanted, applied)?;
        let mut all = tried.reports.clone();
        let mut set_aside = Vec::new();
        loop {
            let own = tried.own(start.human_factors.len());
            if keep || own.is_empty() {
                for (k, report) in tried.reports.into_iter().enumerate().filter(|(k, _)| wanted[*k].enabled) {
                    all[k] = report;
                }
                self.restore(tried.state)?;
                return Ok(Agreement { reports: all, set_aside, left: tried.named });
            }
            let mut best: Option<(usize, Strain, Attempt)> = None;
            for (k, strain) in own.into_iter().take(MOST_TRIED) {
                let mut without = wanted.clone();
                without[k].enabled = false;
                let attempt = self.attempt(&start, &without, applied)?;
                if best.as_ref().is_none_or(|(.., b)| attempt.named.len() < b.named.len()) {
                    best = Some((k, strain, attempt));
                }
            }
            let Some((k, strain, attempt)) = best else { continue };
            wanted[k].enabled = false;
            all[k].clone_from(&tried.reports[k]);
            set_aside.push((k, strain));
            tried = attempt;
        }
    }

    fn attempt(
        &mut self,
        start: &State,
        corrections: &[Correction],
        applied: &dyn Fn(&Correction),
    ) -> Result<Attempt> {
        self.restore(start.clone())?;
        let mut reports = Vec::with_capacity(corrections.len());
        for correction in corrections {
            reports.push(self.apply(correction)?);
            applied(correction);
        }
        let named = contradictions::find(&self.map, &self.options.joint)?.named;
        Ok(Attempt { reports, named, state: self.state() })
    }
}

/// All wanted corrections applied.
struct Attempt {
    reports: Vec<CorrectionReport>,
    named: Vec<Strain>,
    state: State,
}

impl Attempt {
    /// The named ones among the corrections, by index; the map brought the first `earlier` factors with it.
    fn own(&self, earlier: usize) -> Vec<(usize, Strain)> {
        let accepted: Vec<usize> = (0..self.reports.len()).filter(|&k| self.reports[k].accepted()).collect();
        let index = |strain: &Strain| accepted.get(strain.factor.checked_sub(earlier)?).copied();
        self.named.iter().filter_map(|s| Some((index(s)?, s.clone()))).collect()
    }
}
