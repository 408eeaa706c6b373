//! Graphs that grow: every new pose at the cost of what it changes.

use hitl_slam::geometry::Pose2;
use hitl_slam::io;
use hitl_slam::joint::{self, GrowingGraph, Options};

use crate::cpu;
use crate::page::{Claim, Result, Section, project};

/// Public graphs fed pose by pose, every pose with the factors that end in it.
pub fn section() -> Result<Section> {
    let mut section = Section { title: "Graphs that grow", name: "growing", ..Section::default() };
    let mut rows = String::new();
    for name in ["INTEL", "M3500", "city10000"] {
        let path = project(&format!("../shared/data/g2o_2d/{name}.g2o.xz"));
        if !path.exists() {
            continue;
        }
        let map = io::g2o::read(&path)?.value;
        let mut arriving = vec![Vec::new(); map.poses.len()];
        for f in &map.relative_factors {
            arriving[f.i.max(f.j)].push(*f);
        }
        let mut graph = GrowingGraph::new(map.poses[0]);
        let mut ms = Vec::with_capacity(arriving.len());
        for factors in &arriving[1..] {
            let (added, time) = cpu::timed(|| graph.add(factors));
            added?;
            ms.push(time);
        }
        let ((settled, _), settle_ms) = cpu::timed(|| graph.settled(&Options::default().solver));
        let chi2 = |poses: &[Pose2]| -> f64 {
            map.relative_factors.iter().map(|f| f.chi2(poses[f.i], poses[f.j])).sum()
        };
        let total_s = ms.iter().sum::<f64>() / 1e3;
        ms.sort_by(f64::total_cmp);
        let mut batch = map.clone();
        let batch_chi2 = joint::optimize_graph(&mut batch, &Options::default())?.final_chi2;
        if name == "city10000" {
            let claim = |what: &str, measured, bound, unit, decimals| Claim {
                what: format!("{name} pose by pose: {what}"),
                measured,
                bound,
                unit,
                decimals,
                why: "issue; GTSAM's iSAM2 took 73 s and 39 ms elsewhere",
            };
            section.claims.extend([
                claim("CPU time in total, settling included", total_s + settle_ms / 1e3, 5.0, "s", 2),
                claim("CPU time of a pose, 99th percentile", ms[ms.len() * 99 / 100], 5.0, "ms", 2),
                claim(
                    "χ² settled, relative to batch",
                    (chi2(&settled) / batch_chi2 - 1.0).abs(),
                    1e-6,
                    "",
                    0,
                ),
            ]);
        }
        rows += &format!(
            "| {name} | {total_s:.2} | {:.3} | {:.2} | {:.1} | {:.3} | {:.6} | {settle_ms:.1} |\n",
            ms[ms.len() / 2],
            ms[ms.len() * 99 / 100],
            ms[ms.len() - 1],
            chi2(&graph.poses()),
            chi2(&settled),
        );
    }
    section.body = if rows.is_empty() {
        "skipped: the public graphs are absent\n".into()
    } else {
        format!(
            "Public graphs grown pose by pose (`joint::GrowingGraph`), every pose with the factors that end in it, an update of the estimate after each; CPU \
             time. `settled`: the batch solver from the last estimate.\n\n\
             | graph | total, s | median, ms | p99, ms | largest, ms | χ² of the last estimate | χ² settled | settling, ms |\n\
             |---|---|---|---|---|---|---|---|\n{rows}"
        )
    };
    Ok(section)
}
