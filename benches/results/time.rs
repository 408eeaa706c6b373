//! Time of one correction, stage by stage.

use hitl_slam::pipeline::{Options, Timings};
use hitl_slam::simulate::{Scenario, Simulation};

use crate::page::{Claim, Result, Section};
use crate::stats::Sample;
use crate::{big, runs};

/// One stage's share, ms.
type Stage = fn(&Timings) -> f64;

const STAGES: [(&str, Stage); 5] = [
    ("interpret", |t| t.interpret_ms),
    ("explicit", |t| t.explicit_ms),
    ("copslam", |t| t.copslam_ms),
    ("optimize", |t| t.optimize_ms),
    ("**total**", |t| t.total_ms),
];

/// Every correction of the run, `repetitions` times over.
fn timings(s: &Simulation, repetitions: usize) -> Result<Vec<Timings>> {
    let mut timings = Vec::new();
    for _ in 0..repetitions {
        let (_, reports) = runs::corrected(&s.map, &s.corrections, Options::default())?;
        timings.extend(reports.iter().map(|r| r.timings));
    }
    Ok(timings)
}

pub fn section() -> Result<Section> {
    let cases = [
        (runs::simulated(Scenario::Loop, 1, 0.02)?, 20),
        (runs::simulated(Scenario::Campus, 1, 0.02)?, 12),
        (big::map()?, 5),
    ];
    let mut measured = Vec::new();
    for (simulation, repetitions) in &cases {
        measured.push(timings(simulation, *repetitions)?);
    }
    let sample = |case: usize, stage: Stage| Sample::of(measured[case].iter().map(stage));
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    let load = load.split(' ').next().unwrap_or("unknown");
    let mut body = format!(
        "Release build, one thread, ms: median (smallest–largest) over all corrections of a run, repeated. What the pipeline \
         reports; reading, writing and drawing are not in it. The last column is the map of the next section. Load average while measuring: {load} on \
         two cores: with others at work the smallest value tells more than the median.\n\n",
    );
    let heads = cases.iter().zip(&measured).map(|((s, _), m)| {
        let (poses, points) = (s.map.poses.len(), s.map.observations.len());
        format!(" {poses} poses, {:.2} M points, {} samples |", points as f64 / 1e6, m.len())
    });
    body += &format!("| stage |{}\n|---|---|---|---|\n", heads.collect::<String>());
    for (name, stage) in STAGES {
        let cells: Vec<String> = (0..cases.len()).map(|case| sample(case, stage).with_range(3)).collect();
        body += &format!("| {name} | {} |\n", cells.join(" | "));
    }
    body += "\nThe released implementation, on another machine: 8–23 ms (650 poses) and 44–235 ms (3,000) for the useful part, \
             165–215 and 312–745 ms in all. Repeated with statistics by `make bench`.\n";
    let claim = |case: usize, what: &str, bound, why| Claim {
        what: format!("{what}: median time of a correction"),
        measured: sample(case, |t| t.total_ms).median(),
        bound,
        unit: "ms",
        decimals: 1,
        why,
    };
    let optimize = Claim {
        what: "3,100 poses: median time of its joint optimisation".into(),
        measured: sample(1, |t| t.optimize_ms).median(),
        bound: 2.0,
        unit: "ms",
        decimals: 1,
        why: "issue",
    };
    let claims = vec![
        claim(0, "650 poses", 8.0, "released implementation's fastest, its useful part alone"),
        claim(1, "3,100 poses", 5.0, "issue; released implementation's fastest: 44 ms"),
        optimize,
        claim(2, "5,000 poses, 2 M points", 165.0, "released implementation's fastest in all, at 650 poses"),
    ];
    Ok(Section { title: "Time of a correction", name: "time", body, claims })
}
