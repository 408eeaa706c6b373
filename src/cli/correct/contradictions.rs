//! Corrections that contradict the rest: named, and set aside unless they are to be kept.

use hitl_slam::contradictions::Strain;
use hitl_slam::pipeline::Agreement;
use serde::Serialize;

/// What the report says of a correction that contradicts the rest.
#[derive(Debug, Clone, Serialize)]
pub struct Entry {
    pub id: String,
    /// True if the map was corrected without it.
    pub set_aside: bool,
    /// Share of comparable returns of its two visits that clash.
    pub clash: Option<f64>,
    /// What the rest pays for it, χ².
    pub strain_chi2: f64,
    /// The same per thing that its mode ties, over the median of the others'.
    pub strain_ratio: f64,
    /// How far its walls are from what it says, had nobody said it.
    pub offset_without_m: Option<f64>,
    pub angle_without_rad: f64,
    /// The same for a person.
    pub reason: String,
}

impl Entry {
    fn new(strain: &Strain, set_aside: bool) -> Self {
        Entry {
            id: strain.id.clone(),
            set_aside,
            clash: strain.clash,
            strain_chi2: strain.delta_chi2,
            strain_ratio: strain.ratio,
            offset_without_m: strain.offset_without_m,
            angle_without_rad: strain.angle_without_rad,
            reason: strain.reason(),
        }
    }

    /// One line for a person.
    pub fn text(&self) -> String {
        let done = if self.set_aside { "was set aside (--keep-contradictions keeps it)" } else { "was kept" };
        format!("{} contradicts the rest and {done}: {}\n", self.id, self.reason)
    }
}

/// What an agreement says of contradictions; the reports of those set aside get their reason.
pub fn entries(agreement: &mut Agreement) -> Vec<Entry> {
    let mut entries = Vec::new();
    for (k, strain) in &agreement.set_aside {
        let entry = Entry::new(strain, true);
        agreement.reports[*k].rejection = Some(format!("contradicts the rest: {}", entry.reason));
        entries.push(entry);
    }
    entries.extend(agreement.left.iter().map(|strain| Entry::new(strain, false)));
    entries
}
