//! Public pose graphs on both solvers, from the poses in the file, against what has to be reached.

use std::path::PathBuf;
use std::time::Instant;

use hitl_slam::io;
use hitl_slam::joint::{self, Backend, GraphReport, Options};
use hitl_slam::map::SlamMap;

use crate::page::{Claim, Result, Section, project};

/// Files, and the best χ² of ten solvers (the design notes on solvers).
const GRAPHS: [(&str, f64); 16] = [
    ("CSAIL", 38.95629),
    ("FR079", 37.59912),
    ("INTEL", 215.8311),
    ("M3500", 137.913),
    ("M3500a", 912.115),
    ("M3500b", 3906.112),
    ("MITb", 41.16327),
    ("ais2klinik", 172.8156),
    ("city10000", 511.9852),
    ("intel1728", 45.0047),
    ("intel943", 546.4611),
    ("kitti_00", 98.32201),
    ("kitti_05", 157.1044),
    ("manhattanOlson3500", 146.0766),
    ("manhattanOlson3500_odom", 146.0766),
    ("ring", 11.1631),
];

/// What our solver has to reach from the file's own start at its defaults, and with how many decimals (issue).
const TARGETS: [(&str, f64, usize); 8] = [
    ("INTEL", 215.83, 2),
    ("MITb", 41.163, 3),
    ("M3500", 137.913, 3),
    ("M3500a", 912.1, 1),
    ("city10000", 511.985, 3),
    ("ais2klinik", 172.816, 3),
    ("ring", 11.163, 3),
    ("M3500b", 3906.2, 1),
];

/// Σ eᵀΩe written out anew.
pub fn independent_chi2(map: &SlamMap) -> f64 {
    let mut sum = 0.0;
    for f in &map.relative_factors {
        let [xi, yi, ti] = map.poses[f.i].to_array();
        let [xj, yj, tj] = map.poses[f.j].to_array();
        let [xz, yz, tz] = f.i_from_j.to_array();
        let x = ti.cos() * (xj - xi) + ti.sin() * (yj - yi) - xz;
        let y = ti.cos() * (yj - yi) - ti.sin() * (xj - xi) - yz;
        let turn = tj - ti - tz;
        let e = [tz.cos() * x + tz.sin() * y, tz.cos() * y - tz.sin() * x, turn.sin().atan2(turn.cos())];
        for (row, a) in e.iter().enumerate() {
            for (column, b) in e.iter().enumerate() {
                sum += a * f.information.matrix()[(row, column)] * b;
            }
        }
    }
    sum
}

struct Solved {
    report: GraphReport,
    chi2: f64,
    ms: f64,
}

fn solved(map: &SlamMap, backend: Backend) -> Result<Solved> {
    let mut map = map.clone();
    let clock = Instant::now();
    let report = joint::optimize_graph(&mut map, &Options { backend, ..Options::default() })?;
    let ms = clock.elapsed().as_secs_f64() * 1e3;
    Ok(Solved { report, chi2: independent_chi2(&map), ms })
}

pub fn path(name: &str) -> PathBuf {
    project("../shared/data/g2o_2d").join(format!("{name}.g2o.xz"))
}

fn relative(a: f64, b: f64) -> f64 {
    (a - b).abs() / a.abs().max(b.abs()).max(1e-9)
}

pub fn section() -> Result<Section> {
    let mut section = Section { title: "Plain pose graphs", name: "graphs", ..Section::default() };
    if !path(GRAPHS[0].0).exists() || !Backend::Ceres.available() {
        section.body = "skipped: the public graphs or Ceres are absent\n".into();
        return Ok(section);
    }
    section.body = "`hitl optimize` on public 2D graphs (research data, not shipped), from the poses in the file, both solvers at their defaults (at most 50 \
                    accepted steps). χ² = Σ eᵀΩe, computed anew by `benches/results/graphs.rs` from the poses handed back. Best known: of the ten solvers in \
                    our design notes, also those with a better start than the file's. Time: the whole call.\n\n\
                    | graph | poses / edges | χ² before | χ² Rust | χ² Ceres | best known | steps tried, Rust / Ceres | end, Rust / Ceres | ms, Rust / Ceres |\n\
                    |---|---|---|---|---|---|---|---|---|\n"
        .into();
    let (mut apart, mut misreported) = (0.0_f64, 0.0_f64);
    let (mut both, mut ours_early, mut early, mut local) = (0, 0, Vec::new(), Vec::new());
    for (name, best) in GRAPHS.into_iter().filter(|(name, _)| path(name).exists()) {
        let map = io::g2o::read(&path(name))?.value;
        let before = independent_chi2(&map);
        let (rust, ceres) = (solved(&map, Backend::Rust)?, solved(&map, Backend::Ceres)?);
        for s in [&rust, &ceres] {
            misreported = misreported.max(relative(s.report.final_chi2, s.chi2));
        }
        ours_early += usize::from(!rust.report.solve.termination.converged());
        let ends = [&rust, &ceres].map(|s| s.report.solve.termination);
        if ends.iter().all(|e| e.converged()) {
            both += 1;
            apart = apart.max(relative(rust.chi2, ceres.chi2));
            if rust.chi2 > best * 1.001 {
                local.push(name);
            }
        } else {
            early.push(name);
        }
        if let Some(&(_, bound, decimals)) = TARGETS.iter().find(|t| t.0 == name) {
            section.claims.push(Claim {
                what: format!("{name}: χ² from the file's own start, default settings"),
                measured: rust.chi2,
                bound,
                unit: "",
                decimals,
                why: "issue",
            });
        }
        let [end_rust, end_ceres] = ends.map(|e| e.name().replace('_', " "));
        section.body += &format!(
            "| {name} | {} / {} | {before:.4e} | {:.5} | {:.5} | {best} | {} / {} | {end_rust} / {end_ceres} | {:.0} / {:.0} |\n",
            map.poses.len(),
            map.relative_factors.len(),
            rust.chi2,
            ceres.chi2,
            rust.report.solve.iterations.len(),
            ceres.report.solve.iterations.len(),
            rust.ms,
            ceres.ms,
        );
    }
    section.body += &format!(
        "\nBoth converge on {both}, to the same χ². Stopped early by at least one, and said so (*max iterations*, not converged): {}; what stands there is \
         where it stopped, no minimum. A minimum, but not the best one known: {}.\n",
        if early.is_empty() { "none".into() } else { early.join(", ") },
        if local.is_empty() { "none".into() } else { local.join(", ") },
    );
    let claim = |what: &str, measured, bound, why| Claim {
        what: what.into(),
        measured,
        bound,
        unit: "",
        decimals: 0,
        why,
    };
    section.claims.extend([
        claim("public graphs on which both converge: χ² of the two differ by", apart, 1e-8, "as crosscheck"),
        claim("public graphs: reported χ² is off the independent one by", misreported, 1e-9, "rounding"),
        claim(
            "public graphs on which our solver stops early",
            ours_early as f64,
            0.0,
            "issue: no failure on any file",
        ),
    ]);
    Ok(section)
}
