//! Re-association as every command does it: with a progress bar, and a few words about what came of it.

use std::sync::atomic::AtomicBool;

use hitl_slam::closures::{self, Options, Progress, Report};
use hitl_slam::error::{Error, Result};
use hitl_slam::map::{AutomaticFactor, SlamMap};
use hitl_slam::pipeline::{Corrector, Reassociation};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

/// Places named in the text for a person; the report has all.
const MOST_NAMED: usize = 5;

/// Whether, and what a person ruled out.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// Do not look for loop closures after the strokes: the person's corrections alone.
    #[arg(long, conflicts_with = "refuse")]
    no_reassociate: bool,

    #[command(flatten)]
    refused: Refused,
}

/// What a person ruled out.
#[derive(Debug, Clone, clap::Args)]
pub struct Refused {
    /// Never match these two poses, nor those beside them: the name of an automatic factor that is wrong (see the report).
    /// May be given more than once.
    #[arg(long, value_name = "I-J")]
    refuse: Vec<String>,
}

impl Args {
    /// The options; `None`: not wanted.
    pub fn options(&self) -> Result<Option<Options>> {
        let options = self.refused.options()?;
        Ok((!self.no_reassociate).then_some(options))
    }
}

impl Refused {
    /// The options.
    pub fn options(&self) -> Result<Options> {
        let refused = self.refuse.iter().map(|name| pair(name)).collect::<Result<_>>()?;
        Ok(Options { refused, ..Options::default() })
    }
}

fn pair(name: &str) -> Result<(usize, usize)> {
    AutomaticFactor::poses_of(name).ok_or_else(|| {
        Error::input("--refuse", format_args!("found \"{name}\", expected two poses such as 120-431"))
    })
}

/// Finds the automatic factors of a corrector's map.
pub fn run(corrector: &mut Corrector, options: &Options, is_quiet: bool) -> Result<Reassociation> {
    let bar = bar(is_quiet);
    let told = |p: Progress| show(&bar, p);
    let found = corrector.reassociate(options, &told, &AtomicBool::new(false))?;
    bar.finish_and_clear();
    found.ok_or_else(|| Error::Internal("re-association was cancelled by nobody".into()))
}

fn bar(is_quiet: bool) -> ProgressBar {
    let style = ProgressStyle::with_template("closing loops {bar:30} {pos}/{len} {msg}")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    if is_quiet { ProgressBar::hidden() } else { ProgressBar::new(0).with_style(style) }
}

fn show(bar: &ProgressBar, p: Progress) {
    bar.set_length(p.pairs as u64);
    bar.set_position(p.done as u64);
    bar.set_message(format!("round {} of at most {}", p.round + 1, p.rounds));
}

/// Re-association in a report.
#[derive(Debug, Serialize)]
pub struct Summary {
    automatic_factors: Vec<Entry>,
    reassociation: Option<Report>,
    reassociate_ms: f64,
}

impl Summary {
    /// The automatic factors of a map and how they were found, if they were.
    pub fn new(map: &SlamMap, found: Option<&Reassociation>) -> Self {
        Summary {
            automatic_factors: entries(map),
            reassociation: found.map(|r| r.report.clone()),
            reassociate_ms: found.map_or(0.0, |r| r.total_ms),
        }
    }
}

/// One automatic factor in a report.
#[derive(Debug, Serialize)]
struct Entry {
    name: String,
    i: usize,
    j: usize,
    inliers: f64,
    ambiguity: f64,
    weak_direction_rad: Option<f64>,
    chi2: f64,
    agrees: bool,
}

fn entries(map: &SlamMap) -> Vec<Entry> {
    let entry = |a: &AutomaticFactor| Entry {
        name: a.name(),
        i: a.factor.i,
        j: a.factor.j,
        inliers: a.inliers,
        ambiguity: a.ambiguity,
        weak_direction_rad: a.weak_rad,
        chi2: a.chi2,
        agrees: !a.disagrees(),
    };
    map.automatic_factors.iter().map(entry).collect()
}

/// What a person should know: how many, and where to look next.
pub fn text(map: &SlamMap, found: &Reassociation) -> String {
    let Report { rounds, near_passes, withdrawn, footprints } = &found.report;
    if *footprints {
        return "re-association: off, since this is a map of walks: footprints are no walls\n".into();
    }
    let mut text = match withdrawn {
        true => format!(
            "re-association: {} of {} matches contradict each other, so none is kept; draw strokes first\n",
            rounds.last().map_or(0, |r| r.disagreeing),
            rounds.last().map_or(0, |r| r.accepted)
        ),
        false => format!(
            "re-association: {} automatic factors in {} rounds, {:.0} ms\n",
            map.automatic_factors.len(),
            rounds.len(),
            found.total_ms
        ),
    };
    let disagree = map.automatic_factors.iter().filter(|a| a.disagrees());
    let named: Vec<String> = disagree.map(|a| format!("{} (chi2 {:.0})", a.name(), a.chi2)).collect();
    line(&mut text, "disagree with the rest", &named);
    let pass = |p: &closures::NearPass| format!("{}-{} ({:.1} m)", p.i, p.j, p.distance_m);
    line(&mut text, "near, but not matched", &near_passes.iter().map(pass).collect::<Vec<_>>());
    text
}

fn line(text: &mut String, what: &str, named: &[String]) {
    if named.is_empty() {
        return;
    }
    let shown = named[..named.len().min(MOST_NAMED)].join(", ");
    let more = match named.len().saturating_sub(MOST_NAMED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    text.push_str(&format!("  {what}: {shown}{more}\n"));
}
