//! Malformed problems are refused before any solver sees them, by both back ends in the same words: Ceres would end
//! the process on some.

use hitl_slam::joint::problem::JointProblem;
use hitl_slam::joint::{Backend, Options, ceres};
use hitl_slam::solver::Loss;

use crate::support::dice::Dice;
use crate::support::problems;

/// One thing wrong with a problem of every kind of term.
fn spoil(p: &mut JointProblem, dice: &mut Dice) {
    let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY][dice.index(3)];
    let not_positive = [0.0, -1.0, bad][dice.index(3)];
    let n = p.poses.len();
    let beyond = [n, n + 1, usize::MAX, 1 << 40][dice.index(4)];
    let k = dice.index(3);
    match dice.index(33) {
        0 => p.poses[k][dice.index(3)] = bad,
        1 => p.segments[k][dice.index(3)] = bad,
        2 => p.ends[k][dice.index(2)][dice.index(2)] = bad,
        3 => p.ends[k][0] = p.ends[k][1],
        4 => p.held.clear(),
        5 => p.held = vec![2, 1],
        6 => p.held = vec![1, 1],
        7 => p.held = vec![beyond],
        8 => p.relatives[k].i = beyond,
        9 => p.relatives[k].j = p.relatives[k].i,
        10 => p.relatives[k].measured[dice.index(3)] = bad,
        11 => p.relatives[k].sqrt_information[4 * dice.index(3)] = not_positive,
        12 => p.relatives[k].sqrt_information[[3, 6, 7][dice.index(3)]] = 0.5,
        13 => p.relatives[k].loss = Loss::Cauchy(not_positive),
        14 => p.sightings[k].pose = beyond,
        15 => p.sightings[k].segment = beyond,
        16 => p.sightings[k].count = not_positive,
        17 => p.sightings[k].scatter_root[dice.index(3)] = bad,
        18 => p.sightings[k].scale = not_positive,
        19 => p.points[k].segment = beyond,
        20 => p.points[k].point[dice.index(2)] = bad,
        21 => p.ties[k].pose = beyond,
        22 => p.ties[k].along = bad,
        23 => p.relations[k].a = p.relations[k].b,
        24 => p.relations[k].offset_scale = not_positive,
        25 => p.fits[k].sightings.clear(),
        26 => p.fits[k].sightings[0].points.clear(),
        27 => {
            let twice = p.fits[k].sightings[0].clone();
            p.fits[k].sightings.push(twice);
        }
        28 => p.fits[k].sightings[0].points[0][0] = bad,
        29 => p.fits[k].segment = beyond,
        30 => p.paper_relations[k].b = beyond,
        31 => p.paper_relations[k].loss = Loss::Huber(not_positive),
        _ => p.poses.push([0.0; 3]), // In no part with a held pose.
    }
}

/// Three terms or more of every kind; every pose held but three.
fn sound(dice: &mut Dice) -> JointProblem {
    let mut p = problems::of_kind(hitl_slam::joint::problem::TermKind::Relative, 8, dice);
    for kind in problems::KINDS {
        let more = problems::of_kind(kind, 12, dice);
        p.sightings.extend(more.sightings);
        p.points.extend(more.points);
        p.ties.extend(more.ties);
        p.relations.extend(more.relations);
        p.fits.extend(more.fits);
        p.paper_relations.extend(more.paper_relations);
    }
    p
}

#[test]
fn ten_thousand_malformed_problems_are_refused_by_both_in_the_same_words() {
    let mut dice = Dice::new(31);
    let (ours, theirs) = (Options::default(), Options { backend: Backend::Ceres, ..Options::default() });
    let problems: Vec<JointProblem> = (0..50).map(|_| sound(&mut dice)).collect();
    assert!(problems.iter().all(|p| p.validate().is_ok()));
    for round in 0..10_000 {
        let mut problem = problems[round % problems.len()].clone();
        spoil(&mut problem, &mut dice);
        let refusals = [
            Backend::Rust.solve(&mut problem.clone(), &ours).unwrap_err().to_string(),
            Backend::Ceres.solve(&mut problem.clone(), &theirs).unwrap_err().to_string(),
            ceres::evaluate(&problem).unwrap_err().to_string(),
        ];
        assert!(refusals[0].starts_with("joint problem: "), "{}", refusals[0]);
        assert!(refusals.iter().all(|r| *r == refusals[0]), "{refusals:?}");
    }
}

both_backends! {
    /// Legal to the letter, hopeless in numbers: whatever comes of it, the process lives and no number is lost.
    fn extreme_numbers_end_in_a_report(backend: Backend) {
        let mut dice = Dice::new(37);
        for round in 0..300 {
            let mut p = sound(&mut dice);
            p.held = vec![0, 1, 2];
            let size = 10f64.powi(dice.index(300) as i32 - 150);
            match round % 5 {
                0 => p.poses[4][dice.index(2)] = size,
                1 => p.relatives[0].sqrt_information = [size, 0.0, 0.0, 0.0, size, 0.0, 0.0, 0.0, size],
                2 => p.sightings[0].scale = size,
                3 => p.ends[0] = [[0.0, 0.0], [size.max(1e-4), 0.0]],
                _ => p.relations[0].angle_scale = size,
            }
            if p.validate().is_err() {
                continue; // A pose without a way to a held one.
            }
            let report = backend.solve(&mut p, &Options::default()).unwrap();
            assert!(report.final_cost <= report.initial_cost || !report.initial_cost.is_finite());
            assert!(p.blocks().iter().flatten().all(|v| v.is_finite()), "{report:?}");
        }
    }
}
