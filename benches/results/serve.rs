//! The interactive page on a large map, in a browser without a GPU (`page/tests/measure.mjs` drives it).

use std::process::Command;

use hitl_slam::io;
use serde_json::Value;

use crate::big;
use crate::child::Scratch;
use crate::page::{Claim, Result, Section, project};
use crate::stats::Sample;

const POSES: usize = 3_000;
const POINTS: f64 = 1.5e6;

pub fn section() -> Result<Section> {
    let s = big::dense(POSES, POINTS)?;
    let scratch = Scratch::new()?;
    let (map, corrections) = (scratch.path("map.npz"), scratch.path("corrections.jsonl"));
    io::native::write(&map, &s.map)?;
    io::corrections::write(&corrections, &s.corrections)?;
    let mut run = Command::new("node");
    run.arg("tests/measure.mjs").args([&map, &corrections]);
    let output = run.current_dir(project("page")).output()?;
    if !output.status.success() {
        return Err(format!("measure.mjs: {}", String::from_utf8_lossy(&output.stderr)).into());
    }
    let found: Value = serde_json::from_slice(&output.stdout)?;
    let number = |path: &str| found.pointer(path).and_then(Value::as_f64).unwrap_or(f64::NAN);
    let rows = found["corrections"].as_array().cloned().unwrap_or_default();
    let sample = |name: &str| Sample::of(rows.iter().map(|r| r[name].as_f64().unwrap_or(f64::NAN)));
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    let load = load.split(' ').next().unwrap_or("unknown").to_owned();
    let body = format!(
        "The campus with {:.0} poses and {:.2} M points in headless Chromium, no GPU, 1600 × 900, two cores that the browser, \
         the server and others share (load average {load}: with others at work the smallest value tells more than the median). *Ready*: from the command until every point is on screen, in a browser that \
         is already open. *Preview*: from letting the mouse go to the ghost. *Commit*: from Enter to the first frame of the \
         corrected map; it is on disk by then. While something moves, every n-th point is drawn (n in brackets), and all of \
         them as soon as it stands still ({:.0} ms).\n\n\
         | | measured | of which the server |\n|---|---|---|\n\
         | ready | {:.0} ms | {:.0} ms until the address is printed: the map is read and checked |\n\
         | pan | {:.0} frames/s ({:.0}), {:.0} ms a frame, longest wait {:.0} ms | – |\n\
         | zoom | {:.0} frames/s ({:.0}), {:.0} ms a frame, longest wait {:.0} ms | – |\n\
         | release → preview, {} corrections, ms | {} | {} |\n\
         | commit → map on screen, ms | {} | {} |\n",
        number("/poses"),
        number("/points") / 1e6,
        number("/still_ms"),
        number("/ready_ms"),
        number("/printed_ms"),
        number("/pan/fps"),
        number("/pan/stride"),
        number("/pan/frame_ms"),
        number("/pan/worst_gap_ms"),
        number("/zoom/fps"),
        number("/zoom/stride"),
        number("/zoom/frame_ms"),
        number("/zoom/worst_gap_ms"),
        rows.len(),
        sample("preview_ms").with_range(0),
        sample("preview_server_ms").with_range(0),
        sample("commit_ms").with_range(0),
        sample("commit_server_ms").with_range(0),
    );
    let claim = |what: &str, measured: f64, bound: f64, unit| Claim {
        what: format!("page, 3,000 poses, 1.5 M points: {what}"),
        measured,
        bound,
        unit,
        decimals: 0,
        why: "issue 7",
    };
    let frame = |name: &str| 1000.0 / number(&format!("/{name}/fps"));
    let claims = vec![
        claim("ready after the command", number("/ready_ms"), 3000.0, "ms"),
        claim("time per frame while panning", frame("pan"), 50.0, "ms"),
        claim("time per frame while zooming", frame("zoom"), 50.0, "ms"),
        claim("median release → preview", sample("preview_ms").median(), 100.0, "ms"),
        claim("median commit → map on screen", sample("commit_ms").median(), 150.0, "ms"),
    ];
    Ok(Section { title: "The page on a large map", name: "serve", body, claims })
}
