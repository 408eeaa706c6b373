//! Table 1 of the paper over its four kinds of map, the lost poses, and the inconsistency, each against truth.

use hitl_slam::geometry::Pose2;
use hitl_slam::map::{Measure, SlamMap, Trajectory};
use hitl_slam::metrics::{self, InconsistencyOptions, WallErrors};
use hitl_slam::pipeline::Options;
use hitl_slam::simulate::{Scenario, Simulation};

use crate::page::{Claim, Result, Section};
use crate::stats::Sample;
use crate::{big, runs};

const SEEDS: u64 = 20;
pub const KINDS: [Scenario; 4] =
    [Scenario::LostPoses, Scenario::OfficeBent, Scenario::OfficeKick, Scenario::Campus];
const NOISE_M: f64 = 0.02;
/// The inconsistency map's size.
const LARGE_POSES: usize = 3_000;

/// One seed: before and after.
struct Run {
    walls: [WallErrors; 2],
    /// m², without the true map's own.
    excess_m2: [f64; 2],
    true_m2: f64,
    strokes: usize,
    rejected: usize,
}

pub fn walls(s: &Simulation, map: &SlamMap) -> WallErrors {
    let stamps_s = s.map.stamps_s.clone().unwrap_or_default();
    let truth = Trajectory { stamps_s, poses: s.truth.clone() };
    metrics::wall_errors(map, &truth, &s.walls, &s.pairs, metrics::DEFAULT_TOLERANCE_S)
}

fn inconsistency_m2(map: &SlamMap) -> Result<f64> {
    Ok(metrics::inconsistency(map, &InconsistencyOptions::default())?.area_m2)
}

fn measure(scenario: Scenario, seed: u64) -> Result<Run> {
    let s = runs::simulated(scenario, seed, NOISE_M)?;
    let (after, reports) = runs::corrected(&s.map, &s.corrections, Options::default())?;
    let with = |poses: &[Pose2]| SlamMap { poses: poses.to_vec(), ..s.map.clone() };
    let true_m2 = inconsistency_m2(&with(&s.truth))?;
    let excess = |map: &SlamMap| -> Result<f64> { Ok(inconsistency_m2(map)? - true_m2) };
    Ok(Run {
        walls: [walls(&s, &s.map), walls(&s, &after)],
        excess_m2: [excess(&s.map)?, excess(&after)?],
        true_m2,
        strokes: s.corrections.len(),
        rejected: reports.iter().filter(|r| !r.accepted()).count(),
    })
}

/// Error of one comparison, by names.
fn of(walls: &WallErrors, a: &str, b: &str, measure: Measure) -> f64 {
    let found = walls.samples.iter().find(|s| s.a == a && s.b == b && s.measure == measure);
    found.map_or(f64::NAN, |s| s.error)
}

pub fn section() -> Result<Section> {
    let seeds: Vec<u64> = (1..=SEEDS).collect();
    let mut section = Section {
        title: "Table 1: walls against truth, and inconsistency",
        name: "table1",
        ..Section::default()
    };
    section.body = format!(
        "The paper's four kinds of map, simulated with truth (`hitl simulate`), seeds 1–{SEEDS}, each with its own strokes at 2 cm of drawing \
         noise. Error of the angle (A) and of the distance (T) between named walls, mean over a map's pairs, then over seeds \
         ± 95 % interval; walls are fitted to the map's own points (docs/MATH.md). Before and after all corrections. \
         Excess inconsistency: what a map has more than the true map of the same run, which is itself not zero.\n\n\
         | map | strokes | samples A, T | A before (°) | A after (°) | T before (m) | T after (m) | true map's own (m²) | excess before (m²) | excess after (m²) | reduced by |\n\
         |---|---|---|---|---|---|---|---|---|---|---|\n"
    );
    let mut means: [Vec<f64>; 5] = Default::default();
    for scenario in KINDS {
        let runs = runs::parallel(&seeds, |&seed| measure(scenario, seed))?;
        let angle = |k: usize| Sample::of(runs.iter().filter_map(|r| r.walls[k].angle_mean_deg));
        let distance = |k: usize| Sample::of(runs.iter().filter_map(|r| r.walls[k].distance_mean_m));
        let excess = |k: usize| Sample::of(runs.iter().map(|r| r.excess_m2[k]));
        let reduced = 100.0 * (1.0 - excess(1).mean() / excess(0).mean());
        section.body += &format!(
            "| {scenario} | {} | {}, {} | {} | {} | {} | {} | {:.1} | {} | {} | {reduced:.1} % |\n",
            runs[0].strokes,
            runs[0].walls[1].angle_count,
            runs[0].walls[1].distance_count,
            angle(0).with_interval(2),
            angle(1).with_interval(2),
            distance(0).with_interval(3),
            distance(1).with_interval(3),
            runs.iter().map(|r| r.true_m2).sum::<f64>() / runs.len() as f64,
            excess(0).with_interval(1),
            excess(1).with_interval(1),
        );
        for (list, value) in means.iter_mut().zip([
            angle(0).mean(),
            angle(1).mean(),
            distance(0).mean(),
            distance(1).mean(),
            reduced,
        ]) {
            list.push(value);
        }
        if scenario == Scenario::LostPoses {
            lost_poses(&mut section, &runs);
        }
        let rejected: usize = runs.iter().map(|r| r.rejected).sum();
        if rejected > 0 {
            section.body += &format!("| | {rejected} rejected | | | | | | | | | |\n");
        }
    }
    let [a0, a1, t0, t1, reduced] = means.map(|v| v.iter().sum::<f64>() / v.len() as f64);
    section.body += &format!(
        "| **mean** | | | {a0:.2} | **{a1:.2}** | {t0:.3} | **{t1:.3}** | | | | **{reduced:.1} %** |\n\n\
         Published (paper's Table 1, on data that cannot be had): A 6.74 → 1.4°, T 2.71 → 0.04 m; inconsistency reduced by 91 %, not \
         of the excess. `office-kick`: the strokes across the torn place carry weight 1,000 (`src/simulate/scenario/office.rs` says why).\n\n"
    );
    section.claims.extend([
        claim(
            "Table 1, mean of the four kinds: angle error after correction",
            a1,
            0.7,
            "°",
            2,
            "issue; paper: 1.4°",
        ),
        claim(
            "Table 1, mean of the four kinds: distance error after correction",
            t1,
            0.03,
            "m",
            3,
            "issue; paper: 0.04 m",
        ),
    ]);
    section.body += &format!(
        "**Excess inconsistency**: wanted was a reduction by 95 %, measured is {reduced:.1} %{}. What is left lies all along the \
         corridors, not at the strokes (heat map below). The likely cause, not proven: the heading of single steps wanders by \
         0.4–0.6 mrad, a ray that grazes a wall far ahead then passes through it, and no stroke speaks of single steps. The lost \
         poses, which see 1.5 m, keep nothing of it.\n\n",
        if reduced < 95.0 { ": **not met**" } else { "" }
    );
    speed(&mut section)?;
    Ok(section)
}

fn claim(
    what: &str,
    measured: f64,
    bound: f64,
    unit: &'static str,
    decimals: usize,
    why: &'static str,
) -> Claim {
    Claim { what: what.into(), measured, bound, unit, decimals, why }
}

fn lost_poses(section: &mut Section, runs: &[Run]) {
    let width =
        |k: usize| Sample::of(runs.iter().map(|r| of(&r.walls[k], "west", "east", Measure::Distance)));
    let opposite = |k: usize| {
        Sample::of(runs.iter().map(|r| {
            let pair = |a, b| of(&r.walls[k], a, b, Measure::Angle);
            (pair("west", "east") + pair("south", "north")) / 2.0
        }))
    };
    section.claims.extend([
        claim(
            "lost poses: error of the room's width (6.33 m)",
            width(1).mean(),
            0.02,
            "m",
            3,
            "issue; paper: 0.02 m",
        ),
        claim("lost poses: angle of opposite walls", opposite(1).mean(), 0.7, "°", 2, "issue; paper: 1°"),
    ]);
    section.body += &format!(
        "| … its width | | 1 T | | | {} | {} | | | | |\n| … its opposite walls | | 2 A | {} | {} | | | | | | |\n",
        width(0).with_interval(3),
        width(1).with_interval(3),
        opposite(0).with_interval(2),
        opposite(1).with_interval(2),
    );
}

/// The inconsistency of 3,000 poses and 1.5 M points.
fn speed(section: &mut Section) -> Result<()> {
    let large = big::map()?.map;
    let end = large.observations.starts[LARGE_POSES] as usize;
    // As many returns as 1.5 M, by leaving every so many out.
    let mut map = SlamMap {
        poses: large.poses[..LARGE_POSES].to_vec(),
        robot_from_laser: large.robot_from_laser,
        ..SlamMap::default()
    };
    let repeat = (1.5e6 / end as f64).max(1.0);
    let mut kept = 0.0;
    for pose in 0..LARGE_POSES {
        for k in large.observations.range(pose) {
            kept += repeat;
            while kept >= 1.0 {
                kept -= 1.0;
                let range_m = f64::from(large.observations.ranges_m[k]);
                map.observations.push(large.observations.point(k), large.observations.normal(k), range_m);
            }
        }
        map.observations.end_pose();
    }
    let mut seconds = Vec::new();
    for _ in 0..5 {
        let start = std::time::Instant::now();
        inconsistency_m2(&map)?;
        seconds.push(start.elapsed().as_secs_f64());
    }
    let seconds = Sample::of(seconds);
    section.body += &format!(
        "Time to measure {LARGE_POSES} poses with {:.2} M points ({end} returns of the large map, some of them twice), two cores shared with other work: {} s (median, \
         smallest–largest of 5).\n",
        map.observations.len() as f64 / 1e6,
        seconds.with_range(2)
    );
    section.claims.push(claim(
        "inconsistency of 3,000 poses, 1.5 M points: median time",
        seconds.median(),
        2.0,
        "s",
        2,
        "issue",
    ));
    Ok(())
}
