//! The direction of the grid, the bends that forbid it, and walks whose start is unknown.

use hitl_slam::geometry::{Pose2, Vec2};
use hitl_slam::pedestrian::align::find_starts;
use hitl_slam::pedestrian::bend::{harmful_bend, harmful_curve};
use hitl_slam::pedestrian::grid::{group_direction, long_direction};
use hitl_slam::pedestrian::random::Key;
use hitl_slam::pedestrian::{OdometryNoise, Options, Start};
use hitl_slam::simulate::walkers::{Route, Scenario, Settings, gait};

use crate::support::Dice;

/// Tracks of six walkers: 4 m down, `first_m` along, then on at an angle, each with its own drift.
fn tracks(bend_deg: f64, seed: u64) -> Vec<Vec<Vec2>> {
    let mut dice = Dice::new(seed);
    let walker = |_| {
        let rate = dice.normal(0.002);
        let (mut at, mut error, mut track) = (Vec2::zeros(), 0.0, vec![Vec2::zeros()]);
        for k in 0..60 {
            let heading = if k < 6 {
                -90.0_f64
            } else if k < 26 {
                0.0
            } else {
                bend_deg
            };
            error += rate * 0.7 + dice.normal(0.001);
            let (s, c) = (heading.to_radians() + error).sin_cos();
            at += Vec2::new(c, s) * 0.7;
            track.push(at);
        }
        track
    };
    (0..6).map(walker).collect()
}

#[test]
fn the_group_direction_is_that_of_the_corridor_modulo_a_right_angle() {
    for turn in [-0.6, 0.0, 0.3, 0.7] {
        let turn_pose = Pose2::new(0.0, 0.0, turn);
        let turned: Vec<Vec<Vec2>> = tracks(0.0, 3)
            .iter()
            .map(|t| t[..20].iter().map(|p| turn_pose.transform_point(*p)).collect())
            .collect();
        let direction = group_direction(turned.iter().map(|t| (t.as_slice(), 0.7))).unwrap();
        assert!((direction.angle_rad - turn).abs() < 0.03, "{direction:?}, expected {turn}");
        assert!(direction.concentration > 0.95);
    }
}

#[test]
fn a_small_bend_of_the_building_is_noticed_and_drift_is_not_taken_for_one() {
    let found = |bend_deg, seed| {
        let tracks = tracks(bend_deg, seed);
        harmful_bend(&tracks.iter().map(Vec::as_slice).collect::<Vec<_>>())
    };
    for seed in 1..=20 {
        assert_eq!(found(0.0, seed), None, "seed {seed}");
        for bend_deg in [-5.0, 4.0, 6.0] {
            let bend =
                found(bend_deg, seed).unwrap_or_else(|| panic!("seed {seed}: {bend_deg}° not noticed"));
            assert!((bend.angle_rad.to_degrees() - bend_deg).abs() < 2.0, "{bend:?}");
            assert!((bend.at_m - 18.2).abs() < 3.0, "{bend:?}");
        }
        assert_eq!(found(90.0, seed), None, "a right angle does no harm");
    }
}

#[test]
fn where_a_corridor_begins_to_curve_is_noticed_and_steady_drift_is_not_taken_for_it() {
    let found = |scenario: Scenario, radius_m, seed| {
        let settings = Settings { seed, radius_m, ..Settings::default() };
        let simulation = scenario.run(&settings, &[]).unwrap();
        let walks = simulation.walks.iter().zip(&simulation.starts);
        let tracks: Vec<Vec<Vec2>> =
            walks.map(|(w, s)| w.track(*s).iter().map(|p| p.translation()).collect()).collect();
        harmful_curve(&tracks.iter().map(Vec::as_slice).collect::<Vec<_>>())
    };
    for seed in 1..=20 {
        for scenario in [Scenario::Six, Scenario::Opposite, Scenario::OneSided] {
            assert_eq!(found(scenario, 100.0, seed), None, "{scenario}, seed {seed}");
        }
        for radius_m in [-200.0, -150.0, 150.0, 200.0] {
            // The corridor starts after 4 m and curves after 10 m more.
            let curve = found(Scenario::Curve, radius_m, seed);
            let curve = curve.unwrap_or_else(|| panic!("seed {seed}: {radius_m} m not noticed"));
            assert!((9.0..26.0).contains(&curve.at_m), "seed {seed}, {radius_m} m: {curve:?}");
            assert!((0.4..1.6).contains(&(radius_m * curve.rate_rad_per_m)), "{radius_m} m: {curve:?}");
        }
    }
}

#[test]
fn a_long_walk_tells_the_direction_of_its_corridors_better_than_its_first_metres_do() {
    let square = |errors: &[f64]| (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    for turn_deg in [0.0, -40.0] {
        let (mut long, mut short) = (Vec::new(), Vec::new());
        for seed in 1..=40 {
            let settings = Settings { seed, turn_deg, minutes: 5.0, ..Settings::default() };
            let simulation = Scenario::Loops.run(&settings, &[]).unwrap();
            let track: Vec<Vec2> =
                simulation.walks[0].track(simulation.starts[0]).iter().map(|p| p.translation()).collect();
            let off = |angle_rad: f64| (angle_rad.to_degrees() - turn_deg + 45.0).rem_euclid(90.0) - 45.0;
            let found = long_direction([(track.as_slice(), 0.7)].into_iter(), &OdometryNoise::default());
            let found = found.unwrap();
            assert!(found.concentration > 0.95, "{found:?}");
            long.push(off(found.angle_rad));
            short.push(off(group_direction([(&track[..22], 0.7)].into_iter()).unwrap().angle_rad));
        }
        let (long, short) = (square(&long), square(&short));
        assert!(long < 0.6 && long < 0.8 * short, "{turn_deg}: {long}° and {short}°");
    }
    let track: Vec<Vec2> = (0..40).map(|k| Vec2::new(0.7 * f64::from(k), 0.0)).collect();
    let none = long_direction([(track.as_slice(), 0.7)].into_iter(), &OdometryNoise::default());
    assert_eq!(none, None, "28 m are not long");
}

#[test]
fn walkers_with_unknown_starts_are_found_and_a_stranger_is_left_out() {
    let route = |corners: &[[f64; 2]]| Route {
        points: corners.iter().map(|&[x, y]| Vec2::new(x, y)).collect(),
        marked: Vec::new(),
    };
    let way = [
        [0.0, 0.0],
        [20.0, 0.0],
        [20.0, 8.0],
        [32.0, 8.0],
        [32.0, -6.0],
        [32.0, 8.0],
        [20.0, 8.0],
        [20.0, 0.0],
        [0.0, 0.0],
    ];
    let shared = route(&way);
    let winding =
        route(&[[0.0, 0.0], [6.0, 0.0], [9.0, 5.0], [7.0, 11.0], [13.0, 14.0], [12.0, 20.0], [18.0, 24.0]]);
    let walk = |name: &str, route: &Route, k| gait::walk(name, route, &gait::Drift::STEADY, 0, Key::new(k)).0;
    let mut walks = vec![walk("first", &shared, 1), walk("late", &shared, 2), walk("stranger", &winding, 3)];
    // What each walker calls the start is elsewhere for the others: the second one joins 30 steps down the way.
    let start = Start { pose: Pose2::new(2.0, 1.0, 0.7), ..Start::default() };
    let late = 30;
    let true_start = walks[1].track(start.pose)[late];
    walks[1].steps.drain(..late);
    let options = Options { particles: 1_500, ..Options::default() };
    let found = find_starts(&walks, start, &options).unwrap();
    assert_eq!(found.placed, [true, true, false], "{found:?}");
    let off = true_start.between(found.starts[1]);
    assert!(off.translation().norm() < 1.0 && off.theta_rad.abs() < 0.08, "{off:?}");
}
