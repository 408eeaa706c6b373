//! Whether the covariances of the scan matcher are honest: errors of the chain against the relations, normalised by what its
//! factors say and by the relations' own noise, by time span.

use std::collections::HashMap;
use std::fmt::Write;

use hitl_slam::geometry::Pose2;
use hitl_slam::io;
use hitl_slam::map::{Relation, SlamMap};
use hitl_slam::metrics;
use nalgebra::{Matrix3, Vector3};

use crate::effort;
use crate::page::{Claim, Result, Section, project};
use crate::runs;

/// Ends of the spans, seconds.
const SPANS_S: [f64; 4] = [10.0, 30.0, 120.0, f64::INFINITY];
/// Median of χ² with 3 degrees of freedom.
const MEDIAN_CHI2: f64 = 2.366;
/// A span is judged by itself from so many independent errors on.
const FEWEST: f64 = 15.0;

pub fn section() -> Result<Section> {
    let mut section =
        Section { title: "Calibration of the chain", name: "calibration", ..Section::default() };
    section.body = INTRODUCTION.into();
    for (name, log, relations) in runs::REAL_LOGS {
        let [log, relations] = [log, relations].map(project);
        if !log.exists() {
            let _ = writeln!(section.body, "| {name} | skipped: ../shared is absent | | | | | |");
            continue;
        }
        let map = effort::scan_matched(&io::carmen::read(&log)?.value)?;
        let relations = io::relations::read(&relations)?.value;
        let (position_m, heading_rad, triangles) = noise(&relations);
        // A log's stamps need not ascend.
        let mut clock: Vec<(f64, usize)> =
            map.scans.iter().enumerate().map(|(k, s)| (s.stamp_s, k)).collect();
        clock.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut by_span: [Vec<(f64, &Relation)>; 4] = Default::default();
        for relation in &relations {
            let Some(chi2) = chi2(&map, &clock, relation, (position_m, heading_rad)) else { continue };
            let span_s = (relation.stamp_2_s - relation.stamp_1_s).abs();
            let span = SPANS_S.iter().position(|&to| span_s < to).unwrap_or(3);
            by_span[span].push((chi2, relation));
        }
        let _ = write!(
            section.body,
            "| {name} | {:.3} m, {:.2}° ({triangles}) ",
            position_m,
            heading_rad.to_degrees()
        );
        let per_degree = |sum: f64, count: usize| sum / (3 * count) as f64;
        let (mut sum, mut count, mut worst) = (0.0, 0, 1.0_f64);
        for values in &mut by_span {
            values.sort_by(|a, b| a.0.total_cmp(&b.0));
            let Some(median) = values.get(values.len() / 2).map(|m| m.0 / MEDIAN_CHI2) else {
                section.body.push_str("| – ");
                continue;
            };
            let of_span = values.iter().map(|v| v.0).sum::<f64>();
            let mean = per_degree(of_span, values.len());
            let independent = independent(values);
            let _ = write!(section.body, "| {mean:.2}, {median:.2} ({}; {independent:.1}) ", values.len());
            if independent >= FEWEST {
                worst = worst.max(mean).max(1.0 / mean);
            }
            (sum, count) = (sum + of_span, count + values.len());
        }
        let all = per_degree(sum, count);
        let _ = write!(section.body, "| {all:.2} ");
        worst = worst.max(all).max(1.0 / all);
        section.body.push_str("|\n");
        section.claims.push(Claim {
            what: format!(
                "{name}, scan-matched chain: χ² per degree of freedom, or one over it, the worse of all relations and of any span that can be judged"
            ),
            measured: worst,
            bound: 2.0,
            unit: "",
            decimals: 2,
            why: "issue: 0.5 to 2",
        });
    }
    Ok(section)
}

/// How many independent errors have a mean square that scatters as much as that of these: n² / Σ ρ². Errors of a chain add up
/// along it, so those of two relations correlate by the time that both span, over the geometric mean of their own.
fn independent(values: &[(f64, &Relation)]) -> f64 {
    let spans: Vec<(f64, f64)> =
        values.iter().map(|(_, r)| (r.stamp_1_s.min(r.stamp_2_s), r.stamp_1_s.max(r.stamp_2_s))).collect();
    let mut sum = 0.0;
    for (k, &(from, to)) in spans.iter().enumerate() {
        sum += 1.0;
        for &(start, end) in &spans[..k] {
            let common = to.min(end) - from.max(start);
            if common > 0.0 {
                sum += 2.0 * common * common / ((to - from) * (end - start));
            }
        }
    }
    (spans.len() * spans.len()) as f64 / sum
}

/// σ of a relation's position (per axis) and heading, from triangles a → b → c against a → c, errors taken as independent;
/// and their number. Means of absolute values, which a few plainly wrong relations hardly move.
fn noise(relations: &[Relation]) -> (f64, f64, usize) {
    let key = |a: f64, b: f64| (a.to_bits(), b.to_bits());
    let known: HashMap<_, Pose2> =
        relations.iter().map(|r| (key(r.stamp_1_s, r.stamp_2_s), r.first_from_second)).collect();
    let (mut positions_m, mut headings_rad, mut count) = (0.0, 0.0, 0);
    for first in relations {
        for second in relations.iter().filter(|r| r.stamp_1_s == first.stamp_2_s) {
            let Some(whole) = known.get(&key(first.stamp_1_s, second.stamp_2_s)) else { continue };
            let error = whole.between(first.first_from_second.compose(second.first_from_second));
            positions_m += error.translation().norm();
            headings_rad += error.theta_rad.abs();
            count += 1;
        }
    }
    // Means of the Rayleigh and of the half-normal distribution.
    let of = |sum: f64, mean: f64| sum / f64::from(count.max(1)) / 3_f64.sqrt() / mean;
    (of(positions_m, 1.2533), of(headings_rad, 0.7979), count as usize)
}

/// χ² of a relation's error under the chain's own covariance and the relation's noise.
fn chi2(
    map: &SlamMap,
    clock: &[(f64, usize)],
    relation: &Relation,
    (position_m, heading_rad): (f64, f64),
) -> Option<f64> {
    let scan = |stamp_s: f64| {
        let after = clock.partition_point(|c| c.0 < stamp_s);
        let near = &clock[after.saturating_sub(1)..(after + 1).min(clock.len())];
        let gap = |c: &&(f64, usize)| (c.0 - stamp_s).abs();
        let nearest = near.iter().rev().min_by(|a, b| gap(a).total_cmp(&gap(b)))?;
        (gap(&nearest) <= metrics::DEFAULT_TOLERANCE_S).then(|| &map.scans[nearest.1])
    };
    let (first, second) = (scan(relation.stamp_1_s)?, scan(relation.stamp_2_s)?);
    let [first_pose, second_pose] = [first, second].map(|s| map.poses[s.parent].compose(s.parent_from_robot));
    let estimate = first_pose.between(second_pose);
    let error = relation.first_from_second.between(estimate);
    let noise = [position_m, position_m, heading_rad].map(|s| s * s);
    let mut covariance = Matrix3::from_diagonal(&Vector3::from(noise));
    let (from, to) = (first.parent.min(second.parent), first.parent.max(second.parent));
    for factor in map.relative_factors.iter().filter(|f| f.i >= from && f.j <= to && f.j == f.i + 1) {
        // Of the step, in the frame of the later scan.
        let ad = adjoint(second_pose.between(map.poses[factor.j]));
        covariance += ad * factor.information.covariance() * ad.transpose();
    }
    let e = Vector3::from(error.to_array());
    Some(e.dot(&covariance.cholesky()?.solve(&e)))
}

/// Ad(T): a small motion in the inner frame, as one in the outer frame.
fn adjoint(t: Pose2) -> Matrix3<f64> {
    let (s, c) = t.theta_rad.sin_cos();
    Matrix3::new(c, -s, t.y_m, s, c, -t.x_m, 0.0, 0.0, 1.0)
}

const INTRODUCTION: &str = "\
Scan-matched chains, no closure. Errors of the chain against the relations, each normalised by the covariance of all its factors between the two \
scans, propagated along the chain, with the relations' own noise added (from triangles of relations, no map involved: σ per axis and of the heading, number of \
triangles). χ² per degree of freedom: 1 would be calibrated. By time span: mean of χ²/3, median (over the median of χ²₃; some relations are plainly \
wrong, 0.4 m in 0.4 s), and in brackets the relations and how many independent errors they amount to: errors of a chain add up, so relations over \
the same minutes share them. The claim is on the mean over all relations, and over every span of 15 independent errors or more; the \
others hold too few to judge a covariance by (3 errors of 3 degrees of freedom scatter from 0.3 to 2.1).\n\n\
| log | noise of the relations | below 10 s | 10–30 s | 30–120 s | over 120 s | all |\n|---|---|---|---|---|---|---|\n";
