//! Foot-mounted walks that end where they begin (x-io Technologies).

use std::fmt::Write as _;
use std::path::Path;

use hitl_slam::inertial::{self, Options};
use hitl_slam::io;

use crate::page::Claim;

pub fn part(folder: &Path, text: &mut String) -> Vec<Claim> {
    text.push_str("\n## Foot-mounted, closed loops (x-io, another sensor at 400 Hz)\n\nWhere the walk ends of where it began; its makers report 0.082 m (short) and 0.421 m (long).\n\n| walk | steps | m | ours, m | without the bias step, m |\n|---|---|---|---|---|\n");
    for name in ["short_walk", "long_walk"] {
        let recording = io::imu::read(&folder.join(format!("{name}.csv.xz"))).expect("a walk").value;
        let walk = |still_bias| {
            let options = Options { still_bias, ..Options::default() };
            inertial::reckon("walk", &recording, &options).expect("a walk").walk("w")
        };
        let end = |w: &hitl_slam::pedestrian::Walk| {
            w.track(Default::default()).last().map_or(f64::NAN, |p| p.translation().norm())
        };
        let (ours, plain) = (walk(true), walk(false));
        let length = ours.lengths_m().last().copied().unwrap_or(0.0);
        let _ = writeln!(
            text,
            "| {name} | {} | {length:.1} | {:.3} | {:.3} |",
            ours.steps.len(),
            end(&ours),
            end(&plain)
        );
        eprintln!("x-io {name}: {:.3} m, without bias {:.3} m", end(&ours), end(&plain));
    }
    Vec::new()
}
