//! Random joint problems: unstructured ones that touch every term kind, and solvable ones.

use hitl_slam::geometry::{Information, Pose2, Scatter, Vec2, wrap_angle};
use hitl_slam::joint::problem::*;
use hitl_slam::map::Mode;
use hitl_slam::solver::Loss;
use nalgebra::Matrix3;

use super::dice::Dice;

/// U of a random Ω that is far from diagonal.
pub fn sqrt_information(dice: &mut Dice, weight: f64) -> [f64; 9] {
    let a = Matrix3::from_fn(|_, _| dice.normal(1.0));
    let omega = (a * a.transpose() + Matrix3::identity() * 0.1) * weight * weight;
    let u = Information::new(omega).unwrap().sqrt();
    std::array::from_fn(|k| u[(k / 3, k % 3)])
}

pub fn loss(dice: &mut Dice) -> Loss {
    let c = dice.uniform(0.2, 3.0);
    match dice.index(4) {
        0 => Loss::None,
        1 => Loss::Huber(c),
        2 => Loss::Cauchy(c),
        _ => Loss::GemanMcClure(c),
    }
}

fn measured(i: [f64; 3], j: [f64; 3], dice: &mut Dice, noise: f64) -> [f64; 3] {
    let z = Pose2::from_array(i).between(Pose2::from_array(j));
    [z.x_m + dice.normal(noise), z.y_m + dice.normal(noise), wrap_angle(z.theta_rad + dice.normal(noise))]
}

fn scatter_of(points: &[[f64; 2]]) -> Scatter {
    Scatter::of(points.iter().map(|p| Vec2::new(p[0], p[1])))
}

/// Poses anywhere, with `copies` terms of one kind between them.
pub fn of_kind(kind: TermKind, copies: usize, dice: &mut Dice) -> JointProblem {
    let mut p = JointProblem { held: (0..6).collect(), ..Default::default() };
    p.poses = (0..6).map(|_| block(dice)).collect();
    p.segments = (0..4).map(|_| block(dice)).collect();
    p.ends = (0..4).map(|_| [dice.point(5.0), dice.point(5.0)]).collect();
    for _ in 0..copies {
        let (pose, segment) = (dice.index(6), dice.index(4));
        let other = (segment + 1 + dice.index(3)) % 4;
        let scale = dice.uniform(0.5, 30.0);
        match kind {
            TermKind::Relative => {
                let j = (pose + 1 + dice.index(5)) % 6;
                p.relatives.push(RelativeTerm {
                    i: pose,
                    j,
                    measured: measured(p.poses[pose], p.poses[j], dice, 0.4),
                    sqrt_information: sqrt_information(dice, 10.0),
                    loss: loss(dice),
                });
            }
            TermKind::Sighting => {
                let points: Vec<[f64; 2]> = (0..1 + dice.index(8)).map(|_| dice.point(8.0)).collect();
                let s = scatter_of(&points);
                p.sightings.push(SightingTerm {
                    pose,
                    segment,
                    mean: s.mean.into(),
                    scatter_root: s.root,
                    count: s.count as f64,
                    scale,
                });
            }
            TermKind::Point => p.points.push(PointTerm { pose, segment, point: dice.point(8.0), scale }),
            TermKind::Tie => {
                let along = dice.uniform(-3.0, 3.0);
                p.ties.push(TieTerm { pose, segment, mean: dice.point(8.0), along, scale });
            }
            TermKind::Fit => {
                let mut sightings: Vec<FitSighting> = (0..6)
                    .map(|pose| FitSighting {
                        pose,
                        points: (0..1 + dice.index(5)).map(|_| dice.point(8.0)).collect(),
                    })
                    .collect();
                sightings.retain(|_| dice.index(3) > 0);
                if !sightings.is_empty() {
                    p.fits.push(FitTerm { segment, sightings, scale });
                }
            }
            TermKind::Relation | TermKind::PaperRelation => {
                let term = RelationTerm {
                    mode: Mode::ALL[dice.index(4)],
                    a: segment,
                    b: other,
                    offset_scale: scale,
                    angle_scale: dice.uniform(0.5, 100.0),
                    loss: loss(dice),
                };
                if kind == TermKind::Relation { &mut p.relations } else { &mut p.paper_relations }.push(term);
            }
        }
    }
    p
}

pub const KINDS: [TermKind; 7] = [
    TermKind::Relative,
    TermKind::Sighting,
    TermKind::Point,
    TermKind::Tie,
    TermKind::Relation,
    TermKind::Fit,
    TermKind::PaperRelation,
];

fn block(dice: &mut Dice) -> [f64; 3] {
    [dice.uniform(-10.0, 10.0), dice.uniform(-10.0, 10.0), dice.heading()]
}

/// A noisy chain with loop closures and some human factors, started near its minimum: `smooth`, solvable.
/// `moments`: R2 by pose, else by point.
pub fn solvable(seed: u64, loss: Loss, moments: bool) -> JointProblem {
    let dice = &mut Dice::new(seed);
    let n = 20 + dice.index(20);
    let mut truth = vec![[1.0, -2.0, dice.heading()]];
    for _ in 1..n {
        let step = Pose2::new(dice.uniform(0.3, 1.0), dice.normal(0.05), dice.normal(0.4));
        truth.push(Pose2::from_array(truth[truth.len() - 1]).compose(step).to_array());
    }
    let mut p = JointProblem { held: vec![0], ..Default::default() };
    p.poses = truth
        .iter()
        .map(|t| [t[0] + dice.normal(0.1), t[1] + dice.normal(0.1), t[2] + dice.normal(0.03)])
        .collect();
    p.poses[0] = truth[0];
    let relative = |i: usize, j: usize, loss, dice: &mut Dice| RelativeTerm {
        i,
        j,
        measured: measured(truth[i], truth[j], dice, 0.01),
        sqrt_information: sqrt_information(dice, 50.0),
        loss,
    };
    for i in 1..n {
        let term = relative(i - 1, i, Loss::None, dice);
        p.relatives.push(term);
    }
    for _ in 0..n / 4 {
        let i = dice.index(n);
        let j = (i + 1 + dice.index(n - 1)) % n;
        let term = relative(i, j, loss, dice);
        p.relatives.push(term);
    }
    for factor in 0..3 {
        let mode = Mode::ALL[dice.index(4)];
        let wall = [dice.uniform(-5.0, 5.0), dice.uniform(-5.0, 5.0), dice.heading()];
        let turn = if mode == Mode::Perpendicular { std::f64::consts::FRAC_PI_2 } else { 0.0 };
        for side in 0..2 {
            let wall = [wall[0], wall[1], wall[2] + if side == 1 { turn } else { 0.0 }];
            let first = if side == 0 { factor } else { n - 6 + factor };
            for (pose, &at) in truth.iter().enumerate().skip(first).take(3) {
                add_sighting(&mut p, at, pose, wall, moments, dice);
            }
            p.segments.push([
                wall[0] + dice.normal(0.1),
                wall[1] + dice.normal(0.1),
                wall[2] + dice.normal(0.05),
            ]);
        }
        let (a, b) = (2 * factor, 2 * factor + 1);
        p.relations.push(RelationTerm { mode, a, b, offset_scale: 50.0, angle_scale: 100.0, loss });
    }
    p
}

/// Some points of a wall as one pose sees them, and their tie.
fn add_sighting(
    p: &mut JointProblem,
    truth: [f64; 3],
    pose: usize,
    wall: [f64; 3],
    moments: bool,
    dice: &mut Dice,
) {
    let segment = p.segments.len();
    let wall = Pose2::from_array(wall);
    let robot_from_world = Pose2::from_array(truth).inverse();
    let points: Vec<[f64; 2]> = (0..6 + dice.index(10))
        .map(|_| wall.transform_point(Vec2::new(dice.uniform(-1.0, 1.0), dice.normal(0.02))))
        .map(|q| robot_from_world.transform_point(q).into())
        .collect();
    let s = scatter_of(&points);
    if moments {
        p.sightings.push(SightingTerm {
            pose,
            segment,
            mean: s.mean.into(),
            scatter_root: s.root,
            count: s.count as f64,
            scale: 20.0,
        });
    } else {
        p.points.extend(points.iter().map(|&point| PointTerm { pose, segment, point, scale: 20.0 }));
    }
    let mean = Pose2::from_array(truth).transform_point(s.mean);
    let along = wall.inverse().transform_point(mean).x;
    p.ties.push(TieTerm { pose, segment, mean: s.mean.into(), along, scale: 10.0 });
}
