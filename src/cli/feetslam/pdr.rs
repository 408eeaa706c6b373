//! `hitl feetslam pdr`: raw inertial data → steps.

use std::path::PathBuf;

use clap::ValueEnum;
use hitl_slam::error::Result;
use hitl_slam::inertial::{self, Mount, Options, Pdr};
use hitl_slam::io;
use serde::Serialize;

use crate::cli::{Outcome, load, out, report};

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MountName {
    /// Told from how fast the sensor turns.
    Auto,
    /// Strapdown with zero-velocity updates.
    Foot,
    /// Step detector, Weinberg's step length.
    Hand,
}

/// Steps from raw inertial data (pedestrian dead reckoning).
///
/// IMU is a table with the header time_s,acc_x_mps2,…,gyro_z_radps (others that name their columns are recognised), or one
/// of a phone recorder's two text files, or their folder; .gz, .bz2 and .xz too. How the sensor is turned in its mount does
/// not matter. Each step has a covariance.
#[derive(clap::Args)]
pub struct Args {
    /// The recording
    #[arg(value_name = "IMU")]
    input: PathBuf,
    /// The steps; the file's stem is the walker's name
    #[arg(short, long, value_name = "WALK.csv")]
    output: PathBuf,
    /// What the sensor is fixed to
    #[arg(long, value_enum, default_value_t = MountName::Auto)]
    mount: MountName,
    /// Do not take the gyroscope's bias from still periods
    #[arg(long)]
    no_bias: bool,
    /// Foot: threshold of the stance detector
    #[arg(long, value_name = "T", default_value_t = Options::default().stance_threshold)]
    stance_threshold: f64,
    /// Hand: Weinberg's K; a step's length is K times the fourth root of the swing of the vertical acceleration
    #[arg(long, value_name = "K", default_value_t = Options::default().weinberg_gain)]
    weinberg_gain: f64,
    /// Hand: least swing of the vertical acceleration in a step, m/s²
    #[arg(long, value_name = "A", default_value_t = Options::default().step_swing_mps2)]
    step_swing_mps2: f64,
    /// Write the report as JSON here; - for the standard output
    #[arg(long, value_name = "R.json")]
    report: Option<PathBuf>,
}

/// The report.
#[derive(Serialize)]
struct Report {
    version: &'static str,
    mount: &'static str,
    samples: usize,
    duration_s: f64,
    sample_rate_hz: f64,
    steps: usize,
    length_m: f64,
    /// From the start to the last step.
    end_m: [f64; 2],
    end_heading_rad: f64,
    starts_s: f64,
    gyro_bias_radps: Option<[f64; 3]>,
    bias_from_s: Option<[f64; 2]>,
    dropouts: Vec<Dropout>,
    remarks: Vec<String>,
}

#[derive(Serialize)]
struct Dropout {
    from_s: f64,
    to_s: f64,
    what: &'static str,
}

/// Runs the command.
///
/// # Errors
/// A recording that cannot be read or is not fit for dead reckoning, or files that cannot be written.
pub fn run(args: &Args) -> Result<Outcome> {
    io::atomic::check(&args.output)?;
    report::check(args.report.as_deref())?;
    let read = io::imu::read(&args.input)?;
    let options = Options {
        mount: match args.mount {
            MountName::Auto => None,
            MountName::Foot => Some(Mount::Foot),
            MountName::Hand => Some(Mount::Hand),
        },
        still_bias: !args.no_bias,
        stance_threshold: args.stance_threshold,
        weinberg_gain: args.weinberg_gain,
        step_swing_mps2: args.step_swing_mps2,
        ..Options::default()
    };
    let pdr = inertial::reckon(&args.input.display().to_string(), &read.value, &options)?;
    load::remark(&read.warnings);
    load::remark(&pdr.remarks);
    io::walk::write_events(&args.output, &pdr.steps)?;
    let result = Report::new(&read.value, pdr);
    report::write(args.report.as_deref(), &result)?;
    if !report::is_on_stdout(args.report.as_deref()) {
        out::print(&result.table())?;
    }
    Ok(Outcome::Done)
}

impl Report {
    fn new(recording: &inertial::Recording, pdr: Pdr) -> Self {
        let walk = pdr.walk("");
        let track = walk.track(Default::default());
        let end = track.last().copied().unwrap_or_default();
        let times = || recording.samples.iter().map(|s| s.time_s);
        let duration_s = times().next_back().unwrap_or(0.0) - times().next().unwrap_or(0.0);
        let dropout = |d: &inertial::Dropout| Dropout { from_s: d.from_s, to_s: d.to_s, what: d.what };
        Report {
            version: env!("CARGO_PKG_VERSION"),
            mount: pdr.mount.name(),
            samples: recording.samples.len(),
            duration_s,
            sample_rate_hz: recording.samples.len().saturating_sub(1) as f64 / duration_s,
            steps: pdr.steps.len(),
            length_m: walk.lengths_m().last().copied().unwrap_or(0.0),
            end_m: [end.x_m, end.y_m],
            end_heading_rad: end.theta_rad,
            starts_s: pdr.starts_s,
            gyro_bias_radps: pdr.gyro_bias_radps,
            bias_from_s: pdr.bias_from_s,
            dropouts: pdr.dropouts.iter().map(dropout).collect(),
            remarks: pdr.remarks,
        }
    }

    /// The same numbers for a person.
    fn table(&self) -> String {
        let mut text = format!(
            "{} samples, {:.1} s at {:.0} a second, {}-mounted\n{} steps, {:.1} m; ends {:.2} m from its start\n",
            self.samples,
            self.duration_s,
            self.sample_rate_hz,
            self.mount,
            self.steps,
            self.length_m,
            self.end_m[0].hypot(self.end_m[1])
        );
        if let (Some(bias), Some([from, to])) = (self.gyro_bias_radps, self.bias_from_s) {
            let norm = bias.iter().map(|b| b * b).sum::<f64>().sqrt().to_degrees() * 60.0;
            text += &format!("gyroscope bias {norm:.1}°/min, from {from:.1} s to {to:.1} s\n");
        }
        for d in &self.dropouts {
            text += &format!("bridged from {:.2} s to {:.2} s: {}\n", d.from_s, d.to_s, d.what);
        }
        text
    }
}
