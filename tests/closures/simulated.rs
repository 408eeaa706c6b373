//! On simulated worlds, where the truth is known.

use std::f64::consts::FRAC_PI_2;
use std::sync::atomic::{AtomicBool, Ordering};

use hitl_slam::closures;
use hitl_slam::geometry::{Pose2, Vec2};
use hitl_slam::joint::Backend;
use hitl_slam::map::SlamMap;
use hitl_slam::simulate::Scenario;

use super::{corrector, reassociate, with_and_without};
use crate::pipeline::simulated;
use crate::support::{ate_m, largest_distance_m};

both_backends! {
    /// The loop's drift is within what its chain allows: no stroke is needed.
    fn a_loop_closes_without_a_stroke(backend: Backend) {
        for seed in [1, 2] {
            let s = simulated(Scenario::Loop, seed, 0.02);
            let (open, closed, report) = with_and_without(&s.map, &[], backend);
            assert!(ate_m(&open.poses, &s.truth) > 0.4);
            assert!(ate_m(&closed.poses, &s.truth) < 0.04, "seed {seed}: {} m", ate_m(&closed.poses, &s.truth));
            assert!(closed.automatic_factors.len() > 5 && !report.withdrawn, "{report:?}");
            assert!(closed.automatic_factors.iter().all(|a| !a.disagrees()));
            assert_eq!(closed.relative_factors, s.map.relative_factors, "what a map came with stays");
        }
    }
}

#[test]
fn both_back_ends_find_the_same() {
    if !crate::support::both_backends::ceres_or_skip() {
        return;
    }
    let s = simulated(Scenario::Loop, 5, 0.02);
    let (_, by_rust, _) = with_and_without(&s.map, &s.corrections[..1], Backend::Rust);
    let (_, by_ceres, _) = with_and_without(&s.map, &s.corrections[..1], Backend::Ceres);
    let names = |map: &SlamMap| map.automatic_factors.iter().map(|a| a.name()).collect::<Vec<_>>();
    assert_eq!(names(&by_rust), names(&by_ceres));
    assert!(largest_distance_m(&by_rust.poses, &by_ceres.poses) < 1e-4);
}

#[test]
fn strokes_do_not_become_worse_by_it() {
    // The same worlds with more seeds are in docs/RESULTS.md.
    for scenario in [Scenario::Loop, Scenario::Campus, Scenario::LostPoses, Scenario::OfficeBent] {
        let (mut without_m, mut with_m) = (0.0, 0.0);
        for seed in [1, 2, 3] {
            let s = simulated(scenario, seed, 0.02);
            let (without, with, report) = with_and_without(&s.map, &s.corrections, Backend::Rust);
            assert!(!report.withdrawn);
            without_m += ate_m(&without.poses, &s.truth) / 3.0;
            with_m += ate_m(&with.poses, &s.truth) / 3.0;
        }
        // Two millimetres: where strokes alone leave 8 mm, three seeds differ by that.
        assert!(with_m < without_m + 0.002, "{scenario:?}: {without_m} m became {with_m} m");
    }
}

#[test]
fn a_person_who_draws_badly_is_corrected_by_the_walls() {
    let (mut without_m, mut with_m) = (0.0, 0.0);
    for seed in [1, 2, 3] {
        let s = simulated(Scenario::Campus, seed, 0.05);
        let (without, with, _) = with_and_without(&s.map, &s.corrections, Backend::Rust);
        without_m += ate_m(&without.poses, &s.truth) / 3.0;
        with_m += ate_m(&with.poses, &s.truth) / 3.0;
    }
    assert!(with_m < 0.7 * without_m, "{without_m} m became {with_m} m");
}

#[test]
fn the_result_is_the_same_however_the_map_is_turned() {
    let s = simulated(Scenario::Loop, 3, 0.02);
    let (_, upright, _) = with_and_without(&s.map, &s.corrections[..1], Backend::Rust);
    for angle in [0.4, FRAC_PI_2, 2.3, -3.1] {
        let by = Pose2::new(-20.0, 35.0, angle);
        let mut turned = s.map.clone();
        for pose in &mut turned.poses {
            *pose = by.compose(*pose);
        }
        let (_, found, _) = with_and_without(&turned, &s.corrections[..1], Backend::Rust);
        let back: Vec<Pose2> = found.poses.iter().map(|p| by.inverse().compose(*p)).collect();
        let off_m = largest_distance_m(&back, &upright.poses);
        assert!(off_m < 1e-3, "turned by {angle}: {off_m} m");
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let s = simulated(Scenario::Loop, 6, 0.02);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| with_and_without(&s.map, &s.corrections, Backend::Rust).1)
    };
    let bits =
        |map: &SlamMap| map.poses.iter().flat_map(|p| p.to_array().map(f64::to_bits)).collect::<Vec<_>>();
    let one = on(1);
    for threads in [2, 3] {
        let many = on(threads);
        assert_eq!(bits(&one), bits(&many), "{threads} threads");
        assert_eq!(one.automatic_factors, many.automatic_factors);
    }
}

#[test]
fn a_place_that_looks_different_the_second_time_is_named_and_not_matched() {
    let s = simulated(Scenario::Loop, 2, 0.02);
    let (_, closed, _) = with_and_without(&s.map, &[], Backend::Rust);
    let first_back = closed.automatic_factors.iter().map(|a| a.factor.j).min().expect("the loop closes");
    // From where the robot came back on it saw nothing but noise.
    let mut map = s.map.clone();
    let mut dice = crate::support::Dice::new(4);
    for p in map.observations.range(first_back - 20).start..map.observations.len() {
        map.observations.points[p] = dice.point(6.0);
        let normal = Vec2::new(dice.normal(1.0), dice.normal(1.0)).normalize();
        map.observations.normals[p] = [normal.x as f32, normal.y as f32];
    }
    let mut corrector = corrector(&map, Backend::Rust);
    let report = reassociate(&mut corrector);
    assert!(corrector.map().automatic_factors.is_empty());
    let pass = report.near_passes.first().expect("the robot did come back");
    assert!(pass.j >= first_back - 20 && pass.i < pass.j && pass.inliers < 0.55, "{pass:?}");
}

#[test]
fn along_a_corridor_a_match_says_nothing() {
    let s = simulated(Scenario::Campus, 1, 0.02);
    let (_, closed, _) = with_and_without(&s.map, &s.corrections, Backend::Rust);
    let weak: Vec<_> = closed.automatic_factors.iter().filter(|a| a.weak_rad.is_some()).collect();
    assert!(!weak.is_empty() && weak.len() < closed.automatic_factors.len());
    for a in weak {
        // The weak direction is given in the frame of i, the information in that of j as matched.
        let bearing_rad = a.weak_rad.expect("weak") - a.factor.i_from_j.theta_rad;
        let v = nalgebra::Vector3::new(bearing_rad.cos(), bearing_rad.sin(), 0.0);
        let sigma_m = (v.transpose() * a.factor.information.covariance() * v)[0].sqrt();
        assert!(sigma_m > 1.0, "{}: {sigma_m} m", a.name());
    }
}

#[test]
fn a_cancelled_search_leaves_the_map_as_it_was_and_progress_comes_to_its_end() {
    let s = simulated(Scenario::Loop, 1, 0.02);
    let mut map = s.map.clone();
    let (options, joint) = (closures::Options::default(), Default::default());
    let cancelled = AtomicBool::new(false);
    let stop = |p: closures::Progress| cancelled.store(p.round == 1, Ordering::Relaxed);
    let found = closures::reassociate(&mut map, &joint, &options, &stop, &cancelled).expect("a sound map");
    assert!(found.is_none() && map == s.map);
    let furthest = std::sync::Mutex::new((0, 0));
    let watch = |p: closures::Progress| {
        let mut furthest = furthest.lock().expect("a lock");
        *furthest = (*furthest).max((p.done, p.pairs));
    };
    let never = AtomicBool::new(false);
    closures::reassociate(&mut map, &joint, &options, &watch, &never).expect("a sound map").expect("done");
    let (done, pairs) = *furthest.lock().expect("a lock");
    assert!(done == pairs && pairs > 0, "{done} of {pairs}");
}
