//! `hitl correct DIR --corrections DIR -o DIR`: many maps, paired by file stem, on many threads.
//!
//! Every map is corrected by itself, so the files written are the same for any number of jobs. A map that fails is
//! named at the end and leaves the others done. `summary.json` holds no times: it too is always the same.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use hitl_slam::error::{Error, Result};
use hitl_slam::io;
use hitl_slam::pipeline::Options;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use super::Args;
use crate::cli::{Outcome, out, report};

/// The machine-readable summary.
#[derive(Debug, Serialize)]
struct Summary {
    version: &'static str,
    done: usize,
    failed: usize,
    rejected: usize,
    maps: Vec<Entry>,
}

/// One map.
#[derive(Debug, Serialize)]
struct Entry {
    name: String,
    /// What went wrong; null: nothing.
    error: Option<String>,
    output: Option<String>,
    poses: usize,
    points: usize,
    corrections: usize,
    accepted: usize,
    disabled: usize,
    rejected: Vec<Rejected>,
    automatic_factors: usize,
    #[serde(skip)]
    is_internal: bool,
}

/// A correction that was not applied.
#[derive(Debug, Serialize)]
struct Rejected {
    id: String,
    reason: String,
}

/// Runs the command on folders.
pub fn run(args: &Args, options: Options) -> Result<Outcome> {
    let Some(output) = args.output.as_deref().filter(|_| !args.interpret_only) else {
        return Err(Error::input("--interpret-only", "found with a folder of maps, expected a single map"));
    };
    if args.trajectory.is_some() {
        return Err(Error::input("--trajectory", "found with a folder of maps, expected a single map"));
    }
    let summary_path = args.report.clone().unwrap_or_else(|| output.join("summary.json"));
    report::check(Some(&summary_path))?;
    let (maps, corrections) = (files(&args.input)?, files(&args.corrections)?);
    let names: Vec<String> =
        maps.keys().chain(corrections.keys()).cloned().collect::<BTreeSet<_>>().into_iter().collect();
    if maps.is_empty() {
        return Err(Error::input(args.input.display(), "found no file, expected maps"));
    }

    let (next, entries) = (AtomicUsize::new(0), Mutex::new(BTreeMap::new()));
    let bar = progress(names.len());
    let work = || {
        while let Some(name) = names.get(next.fetch_add(1, Ordering::Relaxed)) {
            bar.set_message(name.clone());
            let entry = match (maps.get(name), corrections.get(name)) {
                (Some(Ok(map)), Some(Ok(corrections))) => {
                    entry(args, options, name, map, corrections, output)
                }
                (Some(Err(message)), _) | (_, Some(Err(message))) => {
                    failed(name, Error::input(name, message))
                }
                (Some(_), None) => failed(
                    name,
                    Error::input(name, "found no file of corrections, expected one of this stem"),
                ),
                (None, _) => failed(name, Error::input(name, "found no map, expected one of this stem")),
            };
            bar.inc(1);
            if let Ok(mut entries) = entries.lock() {
                entries.insert(name.clone(), entry);
            }
        }
    };
    thread::scope(|scope| {
        for _ in 0..args.jobs.unwrap_or_else(cores).min(names.len()) {
            scope.spawn(work);
        }
    });
    bar.finish_and_clear();
    let entries = entries.into_inner().map_err(|_| Error::Internal("a worker stopped".into()))?;
    if entries.len() != names.len() {
        return Err(Error::Internal("a worker stopped".into()));
    }
    conclude(args, entries.into_values().collect(), &summary_path)
}

fn conclude(args: &Args, maps: Vec<Entry>, summary_path: &Path) -> Result<Outcome> {
    let bad: Vec<&str> = maps.iter().filter(|e| e.error.is_some()).map(|e| e.name.as_str()).collect();
    let (failed, names) = (bad.len(), bad.join(", "));
    let is_internal = maps.iter().any(|e| e.is_internal);
    let rejected = maps.iter().map(|e| e.rejected.len()).sum();
    let summary =
        Summary { version: env!("CARGO_PKG_VERSION"), done: maps.len() - failed, failed, rejected, maps };
    if !report::is_on_stdout(Some(summary_path)) {
        out::print(&table(&summary))?;
    }
    report::write(Some(summary_path), &summary)?;
    if failed > 0 {
        let message =
            format!("found {failed} of {} maps that failed, expected none: {names}", summary.maps.len());
        return Err(if is_internal { Error::Internal(message) } else { Error::input("batch", message) });
    }
    Ok(if args.strict && rejected > 0 { Outcome::CheckFailed } else { Outcome::Done })
}

fn entry(args: &Args, options: Options, name: &str, map: &Path, corrections: &Path, output: &Path) -> Entry {
    let target = output.join(format!("{name}.npz"));
    let attempt = || -> Result<Entry> {
        io::check_map_path(&target)?;
        let done = super::one(args, options, map, corrections)?;
        io::write_map(&target, done.corrector.map())?;
        if let (Some(folder), Some(before)) = (&args.pictures, &done.before) {
            super::pictures::write(&folder.join(name), before, done.corrector.map(), &done.reports, false)?;
        }
        let refused = done.reports.iter().filter(|r| r.enabled);
        let rejected =
            refused.filter_map(|r| Some(Rejected { id: r.id.clone(), reason: r.rejection.clone()? }));
        Ok(Entry {
            name: name.into(),
            error: None,
            output: Some(format!("{name}.npz")),
            poses: done.corrector.map().poses.len(),
            points: done.corrector.map().observations.len(),
            corrections: done.reports.len(),
            accepted: done.reports.iter().filter(|r| r.accepted()).count(),
            disabled: done.reports.iter().filter(|r| !r.enabled).count(),
            rejected: rejected.collect(),
            automatic_factors: done.corrector.map().automatic_factors.len(),
            is_internal: false,
        })
    };
    attempt().unwrap_or_else(|error| failed(name, error))
}

fn failed(name: &str, error: Error) -> Entry {
    Entry {
        name: name.into(),
        is_internal: matches!(error, Error::Internal(_)),
        error: Some(error.to_string()),
        output: None,
        poses: 0,
        points: 0,
        corrections: 0,
        accepted: 0,
        disabled: 0,
        rejected: Vec::new(),
        automatic_factors: 0,
    }
}

/// The files of a folder by stem; two of one stem are a fault of that stem.
fn files(folder: &Path) -> Result<BTreeMap<String, std::result::Result<PathBuf, String>>> {
    let mut found: BTreeMap<String, std::result::Result<PathBuf, String>> = BTreeMap::new();
    let entries = std::fs::read_dir(folder).map_err(|e| Error::io(folder, e))?;
    for entry in entries {
        let path = entry.map_err(|e| Error::io(folder, e))?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() || name.starts_with('.') {
            continue;
        }
        let twice = || Err(format!("found two files of this stem in {}, expected one", folder.display()));
        found.entry(stem(&name)).and_modify(|e| *e = twice()).or_insert(Ok(path));
    }
    Ok(found)
}

/// The name without what says its format: `aces.clf.bz2` and `aces.jsonl` are both `aces`.
fn stem(name: &str) -> String {
    const ENDINGS: [&str; 14] = [
        ".gz", ".bz2", ".xz", ".npz", ".g2o", ".graph", ".toro", ".covars", ".stfs", ".tum", ".clf", ".log",
        ".jsonl", ".txt",
    ];
    let mut rest = name;
    while let Some(shorter) = ENDINGS.iter().find_map(|e| rest.strip_suffix(e)).filter(|s| !s.is_empty()) {
        rest = shorter;
    }
    rest.to_owned()
}

fn progress(count: usize) -> ProgressBar {
    let style = ProgressStyle::with_template("correcting {bar:30} {pos}/{len} maps {msg}")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(count as u64).with_style(style)
}

fn cores() -> usize {
    thread::available_parallelism().map_or(1, usize::from)
}

/// One line a map.
fn table(summary: &Summary) -> String {
    let width = summary.maps.iter().map(|e| e.name.chars().count()).max().unwrap_or(0).max(4);
    let mut text = format!("{:<width$}  {:>7}  {:>9}  corrections\n", "map", "poses", "points");
    for e in &summary.maps {
        let what = match &e.error {
            Some(error) => format!("FAILED: {error}"),
            None => {
                let off = if e.disabled > 0 { format!(", {} disabled", e.disabled) } else { String::new() };
                let refused: Vec<&str> = e.rejected.iter().map(|r| r.id.as_str()).collect();
                let refused = if refused.is_empty() {
                    String::new()
                } else {
                    format!(", rejected: {}", refused.join(", "))
                };
                format!("{} of {} applied{off}{refused}", e.accepted, e.corrections)
            }
        };
        text.push_str(&format!("{:<width$}  {:>7}  {:>9}  {what}\n", e.name, e.poses, e.points));
    }
    text.push_str(&format!(
        "{} done, {} failed, {} corrections rejected\n",
        summary.done, summary.failed, summary.rejected
    ));
    text
}
