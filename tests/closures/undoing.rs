//! Nothing is cemented: what was found goes when its cause goes, and what a person refuses stays away.

use std::sync::atomic::AtomicBool;

use hitl_slam::closures;
use hitl_slam::crosscheck;
use hitl_slam::geometry::Vec2;
use hitl_slam::joint::Backend;
use hitl_slam::map::{AutomaticFactor, Correction, Mode, SlamMap, Stroke};
use hitl_slam::pipeline::Options;
use hitl_slam::simulate::Scenario;

use super::{corrector, reassociate, with_and_without};
use crate::pipeline::simulated;
use crate::support::largest_distance_m;

/// Says of two places of one corridor, some metres apart, that they are the same.
fn wrong(s: &hitl_slam::simulate::Simulation) -> Correction {
    let mut c = s.corrections[0].clone();
    let (a, b) = (wall(&s.map, 200), wall(&s.map, 215));
    (c.id, c.mode, c.a, c.b) = ("wrong".into(), Mode::Colocation, a, b);
    c
}

/// A stretch of wall as pose `pose` saw it.
fn wall(map: &SlamMap, pose: usize) -> Stroke {
    let o = &map.observations;
    let nearest = o
        .range(pose)
        .filter(|&p| o.normal(p) != Vec2::zeros())
        .min_by(|&a, &b| o.ranges_m[a].total_cmp(&o.ranges_m[b]))
        .expect("a wall");
    let (at, n) = (o.point(nearest), o.normal(nearest));
    let along = Vec2::new(-n.y, n.x) * 0.7;
    Stroke::Pose { pose, points: [at - along, at + along] }
}

both_backends! {
    fn what_a_wrong_correction_caused_goes_with_it(backend: Backend) {
        let s = simulated(Scenario::Loop, 4, 0.02);
        let mut never = corrector(&s.map, backend);
        reassociate(&mut never);
        let mut corrector = corrector(&s.map, backend);
        let applied = corrector.apply(&wrong(&s)).expect("a stroke on the map");
        assert!(applied.accepted(), "{:?}", applied.rejection);
        reassociate(&mut corrector);
        let harm_m = largest_distance_m(&corrector.map().poses, &never.map().poses);
        assert!(harm_m > 0.3, "the wrong stroke bends the map: {harm_m} m");
        assert!(corrector.remove("wrong").expect("a sound map"));
        assert!(corrector.map().automatic_factors.is_empty() && corrector.map().human_factors.is_empty());
        let bare_m = largest_distance_m(&corrector.map().poses, &s.map.poses);
        assert!(bare_m < 1e-6, "back to the chain: {bare_m} m");
        reassociate(&mut corrector);
        let left_m = largest_distance_m(&corrector.map().poses, &never.map().poses);
        assert!(left_m < 1e-4, "{left_m} m of it are left");
    }
}

#[test]
fn doing_it_twice_changes_nothing() {
    let s = simulated(Scenario::Loop, 1, 0.02);
    let (_, once, _) = with_and_without(&s.map, &s.corrections[..1], Backend::Rust);
    let mut again = corrector(&once, Backend::Rust);
    reassociate(&mut again);
    assert!(largest_distance_m(&once.poses, &again.map().poses) < 1e-4);
    assert_eq!(once.automatic_factors.len(), again.map().automatic_factors.len());
}

#[test]
fn an_automatic_factor_is_removed_by_name_and_a_refused_one_does_not_come_back() {
    let s = simulated(Scenario::Loop, 1, 0.02);
    let mut corrector = corrector(&s.map, Backend::Rust);
    reassociate(&mut corrector);
    let all = corrector.map().automatic_factors.clone();
    let (name, pair) = (all[0].name(), (all[0].factor.i, all[0].factor.j));
    assert!(corrector.remove(&name).expect("a sound map"));
    assert!(!corrector.remove(&name).expect("a sound map"), "it is gone");
    let factors = |all: &[AutomaticFactor]| all.iter().map(|a| a.factor).collect::<Vec<_>>();
    let left = corrector.map().automatic_factors.clone();
    assert_eq!(factors(&left), factors(&all[1..]), "the others stay");
    let chi2 = |a: &AutomaticFactor| {
        a.factor.chi2(corrector.map().poses[a.factor.i], corrector.map().poses[a.factor.j])
    };
    assert!(left.iter().all(|a| a.chi2 == chi2(a)), "and are judged where the map now stands");
    let options = closures::Options { refused: vec![pair], ..Default::default() };
    corrector.reassociate(&options, &|_| {}, &AtomicBool::new(false)).expect("a sound map");
    let names: Vec<String> = corrector.map().automatic_factors.iter().map(|a| a.name()).collect();
    assert!(!names.contains(&name) && !names.is_empty(), "{names:?}");
}

#[test]
fn strokes_after_it_are_solved_together_with_what_it_found_and_both_solvers_agree() {
    if !crate::support::both_backends::ceres_or_skip() {
        return;
    }
    for seed in [1, 2] {
        let s = simulated(Scenario::Loop, seed, 0.02);
        let (_, closed, _) = with_and_without(&s.map, &s.corrections[..1], Backend::Rust);
        let mut second = s.corrections[1].clone();
        second.id = "second".into();
        let found = crosscheck::run(closed.clone(), &[second], &Options::default()).expect("both back ends");
        assert!(found.agree && found.corrections[0].rejected.is_none(), "{found:#?}");
        // The automatic factors are in the problem, under their own loss.
        let problem = hitl_slam::joint::build(&closed, &closed.poses, &[], &Options::default().joint);
        let extra = problem.relatives.len() - closed.relative_factors.len();
        assert_eq!(extra, closed.automatic_factors.len());
        let robust = problem.relatives.iter().filter(|r| r.loss.scale() == Some(4.0)).count();
        assert_eq!(robust, extra);
    }
}
