//! Both solvers on the identical problems: simulated runs in every variant, and a real log.

use std::f64::consts::PI;

use hitl_slam::crosscheck::{self, Totals};
use hitl_slam::front_end::{self, Chain};
use hitl_slam::geometry::{Information, Pose2};
use hitl_slam::io::{self, Source};
use hitl_slam::joint::{Backend, Formulation};
use hitl_slam::map::{Correction, RelativeFactor, SlamMap};
use hitl_slam::pipeline::Options;
use hitl_slam::simulate::{Scenario, Simulation};
use hitl_slam::solver::Loss;
use nalgebra::Matrix3;

use crate::page::{Claim, Result, Section, project};
use crate::runs;

const SEEDS: u64 = 10;

/// What is changed of a run before both solve it.
#[derive(Clone, Copy, PartialEq)]
enum Variant {
    Plain,
    Lossy(Loss),
    /// Closures of its own, with information that is not diagonal.
    Closures,
    /// Turned so that the robot sets out along −x.
    HalfTurn,
    Paper,
}

const VARIANTS: [(&str, Variant); 7] = [
    ("smooth", Variant::Plain),
    ("smooth, Huber 1 σ", Variant::Lossy(Loss::Huber(1.0))),
    ("smooth, Cauchy 1 σ", Variant::Lossy(Loss::Cauchy(1.0))),
    ("smooth, Geman–McClure 3 σ", Variant::Lossy(Loss::GemanMcClure(3.0))),
    ("smooth, 12 closures, Ω not diagonal", Variant::Closures),
    ("smooth, headings near ±π", Variant::HalfTurn),
    ("paper", Variant::Paper),
];

/// The worst of many corrections.
#[derive(Default)]
struct Row {
    compared: usize,
    rejected: usize,
    disagree: usize,
    not_converged: usize,
    worst: Totals,
}

impl Row {
    fn add(&mut self, other: &Row) {
        self.compared += other.compared;
        self.rejected += other.rejected;
        self.disagree += other.disagree;
        self.not_converged += other.not_converged;
        self.worsen(&other.worst);
    }

    fn worsen(&mut self, t: &Totals) {
        let w = &mut self.worst;
        for (kept, new) in [
            (&mut w.max_residual_difference, t.max_residual_difference),
            (&mut w.max_jacobian_difference, t.max_jacobian_difference),
            (&mut w.max_pose_difference_m, t.max_pose_difference_m),
            (&mut w.max_angle_difference_rad, t.max_angle_difference_rad),
            (&mut w.relative_cost_difference, t.relative_cost_difference),
        ] {
            // What is no number is worse than any.
            if new > *kept || new.is_nan() {
                *kept = new;
            }
        }
    }

    fn text(&self, name: &str) -> String {
        let w = &self.worst;
        let rejected =
            if self.rejected > 0 { format!(" ({} rejected)", self.rejected) } else { String::new() };
        format!(
            "| {name} | {}{rejected} | {:.1e} | {:.1e} | {:.1e} | {:.1e} | {:.1e} | {} | {} |\n",
            self.compared,
            w.max_residual_difference,
            w.max_jacobian_difference,
            w.relative_cost_difference,
            w.max_pose_difference_m,
            w.max_angle_difference_rad,
            self.not_converged,
            self.compared - self.disagree,
        )
    }
}

fn checked(map: SlamMap, corrections: &[Correction], variant: Variant) -> Result<Row> {
    let mut options = Options::default();
    match variant {
        Variant::Lossy(loss) => options.joint.loss = loss,
        Variant::Paper => options.joint.formulation = Formulation::Paper,
        _ => {}
    }
    let mut row = Row::default();
    for check in crosscheck::run(map, corrections, &options)?.corrections {
        let (Some(rust), Some(ceres)) = (&check.rust, &check.ceres) else {
            row.rejected += 1;
            continue;
        };
        row.compared += 1;
        row.disagree += usize::from(!check.agree);
        row.not_converged += usize::from(!(rust.termination.converged() && ceres.termination.converged()));
        row.worsen(&check.totals);
    }
    Ok(row)
}

/// Exact relations between poses far apart. Ω = 100 [[2, .6, −.4], [.6, 1, .3], [−.4, .3, 4]].
fn with_closures(s: &Simulation) -> Result<SlamMap> {
    let mut map = s.map.clone();
    let omega = Matrix3::new(2.0, 0.6, -0.4, 0.6, 1.0, 0.3, -0.4, 0.3, 4.0) * 100.0;
    let n = map.poses.len();
    for k in 0..12 {
        let (i, j) = (k * n / 40, n / 2 + k * n / 30);
        let i_from_j = s.truth[i].between(s.truth[j]);
        map.relative_factors.push(RelativeFactor { i, j, i_from_j, information: Information::new(omega)? });
    }
    Ok(map)
}

fn half_turned(s: &Simulation) -> SlamMap {
    let mut map = s.map.clone();
    let by = Pose2::new(0.0, 0.0, PI - 1e-9 - map.poses[0].theta_rad);
    for pose in &mut map.poses {
        *pose = by.compose(*pose);
    }
    map
}

fn simulated(scenario: Scenario, variant: Variant) -> Result<Row> {
    let seeds: Vec<u64> = (1..=SEEDS).collect();
    let rows = runs::parallel(&seeds, |&seed| {
        let s = runs::simulated(scenario, seed, 0.02)?;
        let map = match variant {
            Variant::Closures => with_closures(&s)?,
            Variant::HalfTurn => half_turned(&s),
            _ => s.map.clone(),
        };
        checked(map, &s.corrections, variant)
    })?;
    let mut all = Row::default();
    for row in &rows {
        all.add(row);
    }
    Ok(all)
}

/// The real log, in both forms; nothing where it is absent.
fn aces() -> Result<Vec<(&'static str, Variant, Row)>> {
    let (log, corrections) = (project("data/aces.clf.bz2"), project("data/aces.corrections.jsonl"));
    if !log.exists() {
        return Ok(Vec::new());
    }
    let Source::Log(log) = io::read(&log)?.1.value else {
        return Err("data/aces.clf.bz2 is no raw log".into());
    };
    let (map, _) = front_end::build(&log, Chain::Odometry, &front_end::Options::default())?;
    let corrections = io::corrections::read(&corrections)?.value;
    let mut rows = Vec::new();
    for (name, variant) in [("ACES: smooth", Variant::Plain), ("ACES: paper", Variant::Paper)] {
        rows.push((name, variant, checked(map.clone(), &corrections, variant)?));
    }
    Ok(rows)
}

pub fn section() -> Result<Section> {
    let mut section =
        Section { title: "Two solvers, one objective", name: "crosscheck", ..Section::default() };
    if !Backend::Ceres.available() {
        section.body = "skipped: built without Ceres\n".into();
        return Ok(section);
    }
    section.body = format!(
        "`hitl crosscheck` on `loop` and `campus`, seeds 1–{SEEDS} (all four modes between them), and on a real log. Every \
         correction's joint problem goes to our solver (analytic Jacobians) and to Ceres (automatic ones); differences are the \
         largest of all corrections. Residuals and Jacobians: |a − b| / max(1, |a|, |b|), at the start and at the result. In `paper` only \
         these two must agree: neither solver comes to an end in it within 50 steps.\n\n\
         | | corrections | residuals | Jacobians | cost | poses, m | angles, rad | not converged | agree |\n\
         |---|---|---|---|---|---|---|---|---|\n"
    );
    // Smooth, then paper.
    let mut all = [Row::default(), Row::default()];
    for scenario in [Scenario::Loop, Scenario::Campus] {
        for (name, variant) in VARIANTS {
            let row = simulated(scenario, variant)?;
            let scenario = if scenario == Scenario::Loop { "loop" } else { "campus" };
            section.body += &row.text(&format!("{scenario}: {name}"));
            all[usize::from(variant == Variant::Paper)].add(&row);
        }
    }
    for (name, variant, row) in aces()? {
        section.body += &row.text(name);
        all[usize::from(variant == Variant::Paper)].add(&row);
    }
    let [smooth, paper] = &all;
    let terms = |t: fn(&Totals) -> f64| t(&smooth.worst).max(t(&paper.worst));
    let claim = |what: &str, measured, bound, unit| Claim {
        what: format!("both solvers: {what}"),
        measured,
        bound,
        unit,
        decimals: 0,
        why: "the contract of crosscheck",
    };
    section.claims = vec![
        claim("residuals differ by", terms(|t| t.max_residual_difference), 1e-9, ""),
        claim("Jacobians differ by", terms(|t| t.max_jacobian_difference), 1e-7, ""),
        claim("final costs (smooth) differ by", smooth.worst.relative_cost_difference, 1e-8, ""),
        claim("poses (smooth) differ by", smooth.worst.max_pose_difference_m, 1e-6, "m"),
        claim("headings (smooth) differ by", smooth.worst.max_angle_difference_rad, 1e-6, "rad"),
        claim("corrections that disagree", (smooth.disagree + paper.disagree) as f64, 0.0, ""),
    ];
    Ok(section)
}
