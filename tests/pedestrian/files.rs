//! Walks, truth and walls as files; bad input with its exact message; standstills and times.

use hitl_slam::geometry::Vec2;
use hitl_slam::io::{floor_plan, walk};
use hitl_slam::pedestrian::walk::Standstill;
use hitl_slam::pedestrian::{Step, Walk};
use hitl_slam::simulate::walkers::{Scenario, Settings};

use crate::support::{Scratch, message, shared};

const HEADER: &str = "time_s,forward_m,left_m,turn_rad\n";

#[test]
fn walks_truth_and_walls_come_back_as_they_were_written() {
    let scratch = Scratch::new("walks");
    let simulation = Scenario::Rooms.run(&Settings::default(), &[]).unwrap();
    let paths: Vec<_> = simulation.walks.iter().map(|w| scratch.path(&format!("{}.csv", w.name))).collect();
    for (walk, path) in simulation.walks.iter().zip(&paths) {
        walk::write(path, walk).unwrap();
    }
    assert_eq!(walk::read_all(&paths).unwrap().value, simulation.walks);
    walk::write_truth(&scratch.path("truth.csv"), &simulation.truth).unwrap();
    assert_eq!(walk::read_truth(&scratch.path("truth.csv")).unwrap().value, simulation.truth);
    floor_plan::write(&scratch.path("walls.csv"), &simulation.walls).unwrap();
    let read = floor_plan::read(&scratch.path("walls.csv")).unwrap().value;
    assert_eq!(read.len(), simulation.walls.len());
    for (a, b) in read.iter().zip(&simulation.walls) {
        assert!(a.ends().iter().zip(b.ends()).all(|(p, q)| (p - q).norm() < 1e-12));
    }
}

#[test]
fn further_columns_are_allowed_if_they_are_named_with_their_unit() {
    let scratch = Scratch::new("walk-columns");
    let fine = "time_s,forward_m,left_m,turn_rad,height_m\n1,0.7,0,0.1,3\n";
    let read = walk::read(&scratch.file("a.csv", fine)).unwrap().value;
    let step = Step { time_s: 1.0, forward_m: 0.7, left_m: 0.0, turn_rad: 0.1 };
    assert_eq!(read, Walk { name: "a".into(), steps: vec![step] });
}

#[test]
fn bad_walks_are_named_by_file_and_line() {
    let scratch = Scratch::new("bad-walks");
    let cases = [
        ("", "w.csv: found an empty file, expected the header time_s,forward_m,left_m,turn_rad"),
        ("a,b\n", "w.csv:1: found the header 'a,b', expected time_s,forward_m,left_m,turn_rad"),
        (
            "time_s,forward_m,left_m,turn_rad,mood\n",
            "w.csv:1: found the column 'mood', expected further columns to be named with their unit, such as height_m",
        ),
        (HEADER, "w.csv: found no step, expected at least one line below the header"),
        (&format!("{HEADER}1,0.7,0\n"), "w.csv:2: found 3 fields, expected 4"),
        (&format!("{HEADER}1,0.7,0,0\n2,,0,0\n"), "w.csv:3: forward_m: found '', expected a finite number"),
        (&format!("{HEADER}1,0.7,NaN,0\n"), "w.csv:2: left_m: found 'NaN', expected a finite number"),
        (&format!("{HEADER}1,0.7,0,inf\n"), "w.csv:2: turn_rad: found 'inf', expected a finite number"),
        (
            &format!("{HEADER}2,0.7,0,0\n2,0.7,0,0\n"),
            "w.csv:3: time_s: found 2 after 2, expected a later time",
        ),
        (
            &format!("{HEADER}1,9,0,0\n"),
            "w.csv:2: found a step of 9.0 m, expected at most 5 m: are steps missing?",
        ),
    ];
    for (content, expected) in cases {
        assert_eq!(message(walk::read(&scratch.file("w.csv", content))), expected);
    }
    let truth = "walker,time_s,x_m,y_m\na,1,0,0\nb,0,0,0\na,1,0,0\n";
    let expected = "t.csv:4: time_s: found 1 after 1 of 'a', expected a later time";
    assert_eq!(message(walk::read_truth(&scratch.file("t.csv", truth))), expected);
}

#[test]
fn two_walkers_of_the_same_name_are_refused() {
    let scratch = Scratch::new("same-name");
    std::fs::create_dir_all(scratch.path("other")).unwrap();
    let step = format!("{HEADER}1,0.7,0,0\n");
    let paths = [scratch.file("w.csv", &step), scratch.file("other/w.csv", &step)];
    let expected = "w.csv: found a second walker with the name 'w', expected different file names";
    assert_eq!(message(walk::read_all(&paths)), expected);
}

fn steps(times: &[f64]) -> Walk {
    let step = |&time_s: &f64| Step { time_s, forward_m: 0.7, left_m: 0.0, turn_rad: 0.0 };
    Walk { name: "w".into(), steps: times.iter().map(step).collect() }
}

#[test]
fn a_pause_of_two_seconds_is_a_standstill_and_the_walker_is_there_during_it() {
    let walk = steps(&[0.6, 1.2, 1.8, 5.4, 6.0, 7.5]);
    let pause = Standstill { from_s: 1.8, to_s: 5.4 - walk.typical_step_s(), steps_before: 3 };
    assert_eq!(walk.standstills(), [pause]);
    let track: Vec<Vec2> = walk.track(Default::default()).iter().map(|p| p.translation()).collect();
    for (time_s, x_m) in
        [(-3.0, 0.0), (0.6, 0.7), (0.9, 1.05), (3.0, 2.1), (4.7, 2.1), (5.4, 2.8), (99.0, 4.2)]
    {
        let x = walk.position_at(&track, time_s).unwrap().x;
        assert!((x - x_m).abs() < 1e-9, "at {time_s} s: {x}, expected {x_m}");
    }
}

#[test]
fn steps_without_motion_are_a_standstill_too() {
    let mut walk = steps(&[0.6, 1.2, 1.8, 2.4, 3.0, 3.6, 4.2, 4.8]);
    walk.steps[2..6].iter_mut().for_each(|s| s.forward_m = 0.0);
    let found = walk.standstills();
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].steps_before, 2);
    assert!((found[0].from_s - 1.2).abs() < 1e-9 && (found[0].to_s - 3.6).abs() < 1e-9, "{found:?}");
}

#[test]
fn the_marked_points_of_a_simulated_walk_are_recognised() {
    let simulation = Scenario::Six.run(&Settings::default(), &[]).unwrap();
    for walk in &simulation.walks {
        // The pause at the very end has no step after it.
        let marks = simulation.truth.iter().filter(|t| t.walker == walk.name).count();
        assert_eq!(walk.standstills().len(), marks - 2, "{}", walk.name);
    }
}

#[test]
fn people_can_walk_in_the_shared_buildings() {
    let Some(folder) = shared("amrl_maps") else { return };
    let walls = floor_plan::read(&folder.join("NYU19.vectormap.txt")).unwrap().value;
    let settings = Settings { minutes: 2.0, walkers: 2, ..Settings::default() };
    let simulation = Scenario::Building.run(&settings, &walls).unwrap();
    for (walk, start) in simulation.walks.iter().zip(&simulation.starts) {
        assert!(*walk.lengths_m().last().unwrap() > 100.0);
        assert!(start.is_finite());
    }
}
