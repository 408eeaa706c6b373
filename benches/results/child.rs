//! Runs the program itself and watches its memory.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::page::Result;

/// How a run of `hitl` went.
pub struct Run {
    pub seconds: f64,
    /// Peak resident memory (VmHWM), MB of 10⁶ bytes, as last seen while it ran.
    pub peak_mb: f64,
}

/// Runs `hitl` with these arguments to its end.
pub fn hitl(arguments: &[&str]) -> Result<Run> {
    let start = Instant::now();
    let mut child = Command::new(env!("CARGO_BIN_EXE_hitl"))
        .args(arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()?;
    let status = format!("/proc/{}/status", child.id());
    let mut peak_mb = f64::NAN;
    let exit = loop {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let peak = text.lines().find_map(|l| l.strip_prefix("VmHWM:"));
        let kib = peak.and_then(|v| v.trim().trim_end_matches(" kB").trim().parse::<f64>().ok());
        peak_mb = kib.map_or(peak_mb, |kib| kib * 1024.0 / 1e6);
        if let Some(exit) = child.try_wait()? {
            break exit;
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    let seconds = start.elapsed().as_secs_f64();
    if !exit.success() {
        let mut message = String::new();
        if let Some(mut stderr) = child.stderr.take() {
            std::io::Read::read_to_string(&mut stderr, &mut message)?;
        }
        return Err(format!("hitl {}: {exit}: {message}", arguments.join(" ")).into());
    }
    Ok(Run { seconds, peak_mb })
}

/// A folder for large files, removed at the end.
pub struct Scratch(PathBuf);

impl Scratch {
    pub fn new() -> Result<Self> {
        let folder = std::env::temp_dir().join(format!("hitl-slam-results-{}", std::process::id()));
        fs::create_dir_all(&folder)?;
        Ok(Scratch(folder))
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// The same as text, for a command line.
    pub fn text(&self, name: &str) -> String {
        self.path(name).display().to_string()
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}
