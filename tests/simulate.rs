//! The simulated worlds are what they claim to be: scans lie on walls, chains drift as stated, strokes lie on walls.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use hitl_slam::geometry::{Pose2, Segment, Vec2};
use hitl_slam::io::corrections;
use hitl_slam::map::{Mode, Observations, Stroke};
use hitl_slam::simulate::lidar::Lidar;
use hitl_slam::simulate::route::Route;
use hitl_slam::simulate::strokes::{Drawing, Piece, Scene};
use hitl_slam::simulate::world::World;
use hitl_slam::simulate::{Scenario, Settings, Simulation, Wall, run};

use crate::support::ate_m;

fn simulate(scenario: Scenario, change: impl FnOnce(&mut Settings)) -> Simulation {
    let mut settings = Settings::default();
    change(&mut settings);
    run(scenario, &settings).unwrap()
}

fn distance_m(segment: &Segment, p: Vec2) -> f64 {
    let (along, across) = segment.along_across(p);
    across.hypot((along.abs() - segment.half_length_m).max(0.0))
}

#[test]
fn a_ray_hits_the_wall_that_the_naive_search_finds() {
    let world = World::new(simulate(Scenario::Loop, |_| ()).walls);
    let naive = |origin: Vec2, direction: Vec2| {
        let ranges = world.walls().iter().filter_map(|wall| {
            let [p, q] = wall.segment.ends();
            let determinant = direction.perp(&(q - p));
            let range_m = (p - origin).perp(&(q - p)) / determinant;
            let share = (p - origin).perp(&direction) / determinant;
            (range_m >= 0.0 && (0.0..=1.0).contains(&share)).then_some(range_m)
        });
        ranges.filter(|&r| r <= 10.0).min_by(f64::total_cmp)
    };
    for k in 0..4_000 {
        // Inside, outside, on cell borders and along the axes.
        let origin = Vec2::new(f64::from(k % 83) - 41.0, f64::from(k % 61) * 0.7 - 21.0);
        let angle_rad = if k % 5 == 0 { f64::from(k % 4) * TAU / 4.0 } else { f64::from(k) * 0.731 };
        let direction = Vec2::new(angle_rad.cos(), angle_rad.sin());
        let (fast, slow) = (world.cast(origin, direction, 10.0), naive(origin, direction));
        assert_eq!(fast.map(|hit| hit.range_m), slow, "from {origin} along {direction}");
    }
}

#[test]
fn a_ray_exactly_along_an_axis_and_a_cell_border_still_ends() {
    let wall =
        Wall { name: "end".into(), segment: Segment::from_ends(Vec2::new(0.0, 0.0), Vec2::new(0.0, 5.0)) };
    let world = World::new(vec![wall]);
    let hit = world.cast(Vec2::new(3.0, 2.0), Vec2::new(-1.0, 0.0), 10.0).unwrap();
    assert_eq!((hit.range_m, hit.wall, hit.along_m), (3.0, 0, 2.0));
    assert_eq!(world.cast(Vec2::new(3.0, 2.0), Vec2::new(1.0, 0.0), 10.0), None);
    assert_eq!(World::new(Vec::new()).cast(Vec2::zeros(), Vec2::new(0.0, 1.0), 10.0), None);
}

#[test]
fn points_lie_on_the_first_wall_along_their_beam_within_the_range_noise() {
    for scenario in Scenario::ALL {
        let simulation = simulate(scenario, |_| ());
        let world = World::new(simulation.walls.clone());
        let observations = &simulation.map.observations;
        let (mut sum, mut count) = (0.0, 0.0);
        for pose in (0..simulation.truth.len()).step_by(7) {
            let laser = simulation.truth[pose].compose(simulation.map.robot_from_laser);
            for k in observations.range(pose) {
                let p = simulation.truth[pose].transform_point(observations.point(k));
                let range_m = (p - laser.translation()).norm();
                assert!((range_m - f64::from(observations.ranges_m[k])).abs() < 1e-5);
                let beam = (p - laser.translation()) / range_m;
                // A beam that grazes a corner may hit or miss it by rounding: a milliradian's worth is let pass.
                let error = [0.0, 1e-9, -1e-9]
                    .iter()
                    .filter_map(|turn| {
                        world.cast(laser.translation(), Pose2::new(0.0, 0.0, *turn).rotate(beam), 20.0)
                    })
                    .map(|hit| range_m - hit.range_m)
                    .min_by(|a, b| a.abs().total_cmp(&b.abs()))
                    .expect("a wall behind every point");
                assert!(error.abs() < 0.06, "{scenario}: pose {pose} sees {error} m past a wall");
                sum += error * error;
                count += 1.0;
            }
        }
        let rms_m = f64::sqrt(sum / count);
        assert!((rms_m - 0.01).abs() < 2e-4, "{scenario}: {rms_m}");
    }
}

#[test]
fn normals_are_unit_vectors_towards_the_laser_and_mostly_those_of_the_wall() {
    let simulation = simulate(Scenario::Loop, |_| ());
    let observations = &simulation.map.observations;
    let (mut known, mut right) = (0.0, 0.0);
    for pose in (0..simulation.truth.len()).step_by(13) {
        for k in observations.range(pose) {
            let normal = observations.normal(k);
            if normal == Vec2::zeros() {
                continue;
            }
            assert!((normal.norm() - 1.0).abs() < 1e-6);
            assert!(
                normal.dot(&(observations.point(k) - simulation.map.robot_from_laser.translation())) <= 1e-6
            );
            let p = simulation.truth[pose].transform_point(observations.point(k));
            let near = |w: &&Wall| distance_m(&w.segment, p) < 0.05;
            let in_world = simulation.truth[pose].rotate(normal);
            known += 1.0;
            right += f64::from(
                simulation.walls.iter().filter(near).any(|w| w.segment.normal().dot(&in_world).abs() > 0.95),
            );
        }
    }
    assert!(known > 0.9 * (observations.len() as f64 / 13.0));
    assert!(right > 0.85 * known, "{right} of {known}");
}

#[test]
fn the_robot_drives_smoothly_and_never_through_a_wall() {
    for scenario in Scenario::ALL {
        let simulation = simulate(scenario, |_| ());
        let world = World::new(simulation.walls.clone());
        for pair in simulation.truth.windows(2) {
            let step = pair[0].between(pair[1]);
            let length_m = step.translation().norm();
            assert!((0.18..0.23).contains(&length_m), "{scenario}: {length_m}");
            assert!(step.theta_rad.abs() < 0.5);
            let way = (pair[1].translation() - pair[0].translation()) / length_m;
            assert_eq!(world.cast(pair[0].translation(), way, length_m), None, "{scenario}: {pair:?}");
        }
    }
}

#[test]
fn the_loop_drifts_as_stated_for_twenty_seeds() {
    for seed in 1..=20 {
        let simulation = simulate(Scenario::Loop, |s| s.seed = seed);
        let (truth, poses) = (&simulation.truth, &simulation.map.poses);
        assert_eq!((truth.len(), poses.len()), (650, 650));
        let end = truth[649].between(poses[649]);
        let (end_m, end_deg) = (end.translation().norm(), end.theta_rad.to_degrees().abs());
        assert!((1.3..2.5).contains(&end_m), "seed {seed}: {end_m} m");
        assert!((6.0..8.0).contains(&end_deg), "seed {seed}: {end_deg}°");
        let ate_m = ate_m(poses, truth);
        assert!((0.3..0.8).contains(&ate_m), "seed {seed}: ATE {ate_m} m");
    }
}

#[test]
fn the_campus_has_more_than_3000_poses_and_drifts_as_stated() {
    for seed in 1..=5 {
        let simulation = simulate(Scenario::Campus, |s| s.seed = seed);
        assert!(simulation.truth.len() > 3_000);
        let ate_m = ate_m(&simulation.map.poses, &simulation.truth);
        assert!((1.5..3.5).contains(&ate_m), "seed {seed}: ATE {ate_m} m");
    }
}

#[test]
fn without_drift_the_map_is_the_truth() {
    let simulation = simulate(Scenario::Loop, |s| s.drift = 0.0);
    for (truth, pose) in simulation.truth.iter().zip(&simulation.map.poses) {
        assert!((truth.translation() - pose.translation()).norm() < 1e-9);
    }
}

#[test]
fn the_map_is_valid_and_its_factors_explain_its_poses_but_not_quite_the_truth() {
    for scenario in Scenario::ALL {
        let simulation = simulate(scenario, |_| ());
        let map = &simulation.map;
        map.validate("simulated").unwrap();
        assert!(map.stamps_s.as_ref().unwrap().windows(2).all(|w| w[0] < w[1]));
        for f in &map.relative_factors {
            assert_eq!(f.j, f.i + 1);
            assert!(f.chi2(map.poses[f.i], map.poses[f.j]) < 1e-12);
            assert!(f.information.matrix()[(1, 2)].abs() > 0.0, "the lever arm couples y and heading");
        }
        let count = map.relative_factors.len() as f64;
        let at_truth = |f: &hitl_slam::map::RelativeFactor| {
            let [x, y, theta] = f.residual(simulation.truth[f.i], simulation.truth[f.j]);
            [x, y + 0.5 * theta, theta]
        };
        // The step that failed is not noise.
        let sound = map.relative_factors.iter().filter(|f| at_truth(f)[2].abs() < 0.3);
        let white_m = sound.map(|f| at_truth(f)[1].powi(2)).sum::<f64>() / count;
        assert!((white_m.sqrt() - 0.001).abs() < 1e-4, "sideways noise beside the lever arm's: {white_m}");
    }
}

#[test]
fn the_covariance_of_the_whole_chain_covers_the_drift_of_its_end() {
    // All but the one whose odometry fails without saying so.
    for scenario in Scenario::ALL.into_iter().filter(|s| *s != Scenario::OfficeKick) {
        let simulation = simulate(scenario, |_| ());
        let sigma_rad = simulation
            .map
            .relative_factors
            .iter()
            .map(|f| f.information.covariance()[(2, 2)])
            .sum::<f64>()
            .sqrt();
        let last = simulation.truth.len() - 1;
        let end_rad = simulation.truth[last].between(simulation.map.poses[last]).theta_rad.abs();
        assert!((0.7..1.4).contains(&(end_rad / sigma_rad)), "{scenario}: {end_rad} rad at σ {sigma_rad}");
    }
}

#[test]
fn strokes_without_drawing_noise_lie_on_their_walls_and_relate_as_they_say() {
    for scenario in Scenario::ALL {
        let simulation = simulate(scenario, |s| s.drawing_noise_m = 0.0);
        for correction in &simulation.corrections {
            let [a, b] = [&correction.a, &correction.b].map(|stroke| {
                let Stroke::Pose { pose, points } = stroke else { panic!("not anchored to a pose") };
                let [p, q] = points.map(|p| simulation.truth[*pose].transform_point(p));
                let on = |w: &Wall| distance_m(&w.segment, p) < 1e-3 && distance_m(&w.segment, q) < 1e-3;
                assert!(simulation.walls.iter().any(on), "{scenario} {}", correction.id);
                Segment::from_ends(p, q)
            });
            for length_m in [a, b].map(|s| 2.0 * s.half_length_m) {
                assert!((1.0..4.0).contains(&length_m), "{scenario} {}: {length_m} m", correction.id);
            }
            let sin = a.direction().perp(&b.direction()).abs();
            let across_m = a.along_across(b.centre).1.abs();
            let apart_m = (b.centre - a.centre).norm();
            assert!(match correction.mode {
                Mode::Colocation => apart_m < 1e-3 && sin < 1e-6,
                Mode::Collinear => across_m < 1e-3 && sin < 1e-6,
                Mode::Parallel => sin < 1e-6,
                Mode::Perpendicular => (sin - 1.0).abs() < 1e-6,
            });
        }
    }
}

#[test]
fn every_wall_has_a_name_of_its_own() {
    for scenario in Scenario::ALL {
        let walls = simulate(scenario, |_| ()).walls;
        let names: std::collections::BTreeSet<&str> = walls.iter().map(|w| w.name.as_str()).collect();
        assert_eq!(names.len(), walls.len());
    }
}

#[test]
fn the_scenarios_use_all_four_modes() {
    let mut modes: Vec<Mode> = Vec::new();
    for (scenario, count) in [(Scenario::Loop, 3), (Scenario::Campus, 4)] {
        let corrections = simulate(scenario, |_| ()).corrections;
        assert_eq!(corrections.len(), count);
        modes.extend(corrections.iter().map(|c| c.mode));
    }
    assert!(Mode::ALL.iter().all(|mode| modes.contains(mode)));
}

#[test]
fn equal_seeds_give_equal_runs_and_each_noise_has_its_own_stream() {
    let nominal = simulate(Scenario::Loop, |_| ());
    let lines = |s: &Simulation| s.corrections.iter().map(corrections::to_json_line).collect::<Vec<_>>();
    let again = simulate(Scenario::Loop, |_| ());
    assert_eq!(format!("{nominal:?}"), format!("{again:?}"));

    let drawn = simulate(Scenario::Loop, |s| s.drawing_noise_m = 0.05);
    assert_eq!(drawn.map, nominal.map);
    assert_ne!(lines(&drawn), lines(&nominal));

    let ranged = simulate(Scenario::Loop, |s| s.range_noise_m = 0.02);
    assert_eq!(ranged.map.poses, nominal.map.poses);
    assert_ne!(ranged.map.observations, nominal.map.observations);

    let blurred = simulate(Scenario::Loop, |s| s.range_noise_m = 0.5);
    assert_eq!(lines(&blurred), lines(&nominal), "the person chooses the same scans");

    let bent = simulate(Scenario::Loop, |s| s.drift = 2.0);
    assert_eq!(bent.map.observations, nominal.map.observations);
    assert_eq!(lines(&bent), lines(&nominal));

    let other = simulate(Scenario::Loop, |s| s.seed = 2);
    assert_ne!(other.map.poses, nominal.map.poses);
}

#[test]
fn settings_that_make_no_sense_are_bad_input() {
    for value in [-0.1, 101.0, f64::NAN, f64::INFINITY] {
        let settings = Settings { drift: value, ..Settings::default() };
        let error = run(Scenario::Loop, &settings).unwrap_err();
        assert!(error.to_string().starts_with("drift: found"), "{error}");
    }
    assert!("lop".parse::<Scenario>().unwrap_err().to_string().contains("expected one of loop, campus"));
}

#[test]
fn a_correction_is_one_line_of_json_as_the_contract_has_it() {
    let corrections = simulate(Scenario::Loop, |_| ()).corrections;
    let line: serde_json::Value = serde_json::from_str(&corrections::to_json_line(&corrections[0])).unwrap();
    assert_eq!(line["mode"], "colocation");
    assert_eq!(line["id"], "c1");
    assert!(line["a"]["pose"].is_u64() && line["b"]["points"][1][0].is_f64());
}

#[test]
fn a_piece_is_drawn_on_the_visit_that_was_asked_for_and_refused_where_there_was_none() {
    let wall =
        Wall { name: "long".into(), segment: Segment::from_ends(Vec2::new(0.0, 0.0), Vec2::new(20.0, 0.0)) };
    let world = World::new(vec![wall]);
    // Past the wall, away from it, and past it again.
    let way = [(0.0, 1.0), (40.0, 1.0), (40.0, 30.0), (-5.0, 30.0), (-5.0, 2.0), (20.0, 2.0)];
    let truth = Route::through(&way.map(|(x, y)| Vec2::new(x, y)), 1.0).poses(900);
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let (mut observations, mut seen) = (Observations::default(), Vec::new());
    let lidar = Lidar::half_circle(5.0);
    for &pose in &truth {
        lidar.scan(&world, pose, 0.0, &mut random, &mut observations, &mut seen);
    }
    let scene = Scene { world: &world, truth: &truth, observations: &observations, seen: &seen };
    let piece = |visit| Piece::part("long", [8.0, 10.0], visit);
    let draw = |second, random: &mut ChaCha8Rng| {
        let drawing = Drawing::new(Mode::Colocation, piece(0), piece(second));
        scene.draw(&[drawing], 0.0, random)
    };
    let correction = draw(1, &mut random).unwrap().remove(0);
    for (stroke, y_m) in [(correction.a, 1.0), (correction.b, 2.0)] {
        let Stroke::Pose { pose, points } = stroke else { panic!("not anchored to a pose") };
        assert!((truth[pose].y_m - y_m).abs() < 1e-9, "the robot was {} m from the wall", truth[pose].y_m);
        for (p, x_m) in points.into_iter().zip([8.0, 10.0]) {
            assert!((truth[pose].transform_point(p) - Vec2::new(x_m, 0.0)).norm() < 1e-9);
        }
    }
    assert!(draw(2, &mut random).is_err());
}

#[test]
fn a_route_ends_where_it_should_and_turns_no_tighter_than_asked() {
    let corners = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (2.0, 4.0)].map(|(x, y)| Vec2::new(x, y));
    let route = Route::through(&corners, 1.5);
    let poses = route.poses(400);
    let step_m = route.length_m() / 399.0;
    assert!((poses[399].translation() - corners[3]).norm() < 1e-9);
    for pair in poses.windows(2) {
        assert!(pair[0].between(pair[1]).theta_rad.abs() <= step_m / 1.5 + 1e-9);
        assert!((pair[1].translation() - pair[0].translation()).norm() <= step_m + 1e-9);
    }
}
