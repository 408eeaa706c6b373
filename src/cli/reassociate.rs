//! Re-association with a progress bar.

use std::sync::atomic::AtomicBool;

use hitl_slam::closures::{self, Progress, Report};
use hitl_slam::error::Result;
use hitl_slam::joint;
use hitl_slam::map::SlamMap;
use indicatif::{ProgressBar, ProgressStyle};

/// Finds the automatic factors of a map.
pub fn run(map: &mut SlamMap, joint_options: &joint::Options, options: &closures::Options) -> Result<Report> {
    let bar = bar();
    let told = |p: Progress| show(&bar, p);
    let report = closures::reassociate(map, joint_options, options, &told, &AtomicBool::new(false))?;
    bar.finish_and_clear();
    Ok(report.unwrap_or_default())
}

fn bar() -> ProgressBar {
    let style = ProgressStyle::with_template("closing loops {bar:30} {pos}/{len} {msg}")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(0).with_style(style)
}

fn show(bar: &ProgressBar, p: Progress) {
    bar.set_length(p.pairs as u64);
    bar.set_position(p.done as u64);
    bar.set_message(format!("round {} of at most {}", p.round + 1, p.rounds));
}
