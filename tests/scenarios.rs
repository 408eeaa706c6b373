//! What single scenarios claim of themselves.

use hitl_slam::geometry::{Segment, Vec2};
use hitl_slam::map::Mode;
use hitl_slam::simulate::{Scenario, Settings, Simulation, run};

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
fn no_scan_of_the_lost_poses_sees_two_parallel_walls() {
    let s = simulate(Scenario::LostPoses, |_| ());
    assert_eq!(s.truth.len(), 270);
    let mut lost = 0;
    for (pose, &world_from_robot) in s.truth.iter().enumerate() {
        let sees = |name: &str| {
            let wall = s.walls.iter().find(|w| w.name == name).unwrap();
            s.map.observations.range(pose).any(|k| {
                distance_m(&wall.segment, world_from_robot.transform_point(s.map.observations.point(k)))
                    < 0.05
            })
        };
        assert!(!(sees("west") && sees("east") || sees("south") && sees("north")), "pose {pose}");
        lost += usize::from(s.map.observations.range(pose).is_empty());
    }
    assert!(lost > 60, "only {lost} poses see no wall at all");
}

#[test]
fn the_office_loses_thirty_degrees_in_one_step_and_its_covariance_does_not_know() {
    let s = simulate(Scenario::OfficeKick, |_| ());
    let error_deg =
        |f: &hitl_slam::map::RelativeFactor| f.residual(s.truth[f.i], s.truth[f.j])[2].to_degrees().abs();
    let failed: Vec<_> = s.map.relative_factors.iter().filter(|f| error_deg(f) > 1.0).collect();
    assert_eq!(failed.len(), 1);
    assert!((error_deg(failed[0]) - 30.0).abs() < 0.5);
    let usual = s.map.relative_factors[0].information.covariance()[(2, 2)];
    assert!((failed[0].information.covariance()[(2, 2)] / usual - 1.0).abs() < 0.05);
}

#[test]
fn a_thorough_person_draws_what_the_scenario_asks_for_and_then_every_corridor_straight() {
    for (scenario, at_least) in [(Scenario::OfficeBent, 8), (Scenario::Campus, 30), (Scenario::LostPoses, 0)]
    {
        let plain = simulate(scenario, |_| ());
        let thorough = simulate(scenario, |s| s.thorough = true);
        let (own, more) = thorough.corrections.split_at(plain.corrections.len());
        assert_eq!(own, plain.corrections, "{scenario}: the same strokes, to the last digit");
        assert!(more.len() >= at_least, "{scenario}: {}", more.len());
        assert!(more.iter().all(|c| c.mode == Mode::Collinear));
        assert_eq!(thorough.map, plain.map);
    }
}
