//! The two systems meet: walks corrected by a person, and a corrected robot as a walker.

use std::fmt::Write as _;

use hitl_slam::front_end::{WalkOptions, map_of_walks};
use hitl_slam::geometry::{Pose2, Vec2, wrap_angle};
use hitl_slam::io::walks_of_map;
use hitl_slam::map::{Correction, Mode, SlamMap, Stroke};
use hitl_slam::pedestrian::random::Key;
use hitl_slam::pedestrian::successive::{self, Mode as Mapping};
use hitl_slam::pedestrian::{Options, Start, TruthPoint, Walk, metrics};
use hitl_slam::pipeline::{self, Corrector};
use hitl_slam::simulate::walkers::{self, Route, Scenario, Simulation, gait};

use super::{Claim, SEEDS, claim, mean, positions, quantile};

/// The chapter.
pub fn chapter(text: &mut String) -> Vec<Claim> {
    let share = corrected_walks(text);
    robots(text);
    vec![claim(
        "Walks corrected by a person: mean error at the end over that of dead reckoning",
        share,
        0.4,
        "",
        "ours",
    )]
}

/// Errors at the end of every walker of a map of walks.
fn end_errors(simulation: &Simulation, map: &SlamMap) -> Vec<f64> {
    let all = map.trajectory().poses;
    let pieces = walks_of_map::pieces(map);
    let error = |(walk, piece): (&Walk, &Vec<usize>)| {
        let path: Vec<Vec2> = piece.iter().map(|&k| all[k].translation()).collect();
        metrics::errors_m(walk, &path, &simulation.truth).last().copied().unwrap_or(f64::NAN)
    };
    simulation.walks.iter().zip(&pieces).map(error).collect()
}

/// A stroke along a walker's path from one step to another, drawn with 5 cm of noise.
fn stroke(map: &SlamMap, walker: usize, steps: [usize; 2], key: Key) -> Stroke {
    let piece = &walks_of_map::pieces(map)[walker];
    let poses = map.trajectory().poses;
    let noise = |k: u64| Vec2::new(key.normal(2 * k), key.normal(2 * k + 1)) * 0.05;
    Stroke::World([0, 1].map(|k| poses[piece[steps[k]]].translation() + noise(k as u64)))
}

/// Mean error after all corrections over that before.
fn corrected_walks(text: &mut String) -> f64 {
    let mut means = Vec::new();
    text.push_str("\n## Walks corrected by a person\n\nThe paper's six walkers as one map (`hitl import w1.csv … -o map.npz`), ten seeds, strokes drawn with 5 cm of noise, drawing accuracy 0.3 m, σ of a footprint 0.2 m. *Straight*: in each walk, the corridor's beginning (7–14 m) and its end (32–40 m) are collinear. *Same*: a piece of the first walker's corridor (21–31 m) and of each other's are collinear. Error at the end of the walks, metres.\n\n| | corrections | refused | median | mean | worst |\n|---|---|---|---|---|---|\n");
    let cases: [(&str, bool, bool); 4] = [
        ("dead reckoning", false, false),
        ("same", false, true),
        ("straight", true, false),
        ("straight, then same", true, true),
    ];
    for (name, straight, same) in cases {
        let (mut errors, mut count, mut refused) = (Vec::new(), 0, 0);
        for seed in 1..=SEEDS {
            let simulation = Scenario::Six
                .run(&walkers::Settings { seed, ..walkers::Settings::default() }, &[])
                .expect("a scenario");
            let map = map_of_walks(&simulation.walks, &WalkOptions::starting(&simulation.starts[..1]))
                .expect("walks");
            let mut options = pipeline::Options::default();
            options.interpret.drawing_sigma_m = 0.3;
            options.joint.observation_sigma_m = 0.2;
            let mut corrector = Corrector::new(map, options).expect("a map");
            let walkers = simulation.walks.len();
            let mut wanted = Vec::new();
            if straight {
                wanted.extend((0..walkers).map(|j| ([j, j], [[10, 20], [46, 58]])));
            }
            if same {
                wanted.extend((1..walkers).map(|j| ([0, j], [[30, 45], [30, 45]])));
            }
            for (number, (who, steps)) in wanted.iter().enumerate() {
                let key = Key::new(seed).with(number as u64);
                let side = |k: usize| stroke(corrector.map(), who[k], steps[k], key.with(k as u64));
                let correction = Correction {
                    id: format!("c{number}"),
                    mode: Mode::Collinear,
                    a: side(0),
                    b: side(1),
                    weight: 1.0,
                    enabled: true,
                };
                let report = corrector.apply(&correction).expect("strokes on the map");
                refused += usize::from(!report.accepted());
            }
            count = wanted.len();
            errors.extend(end_errors(&simulation, corrector.map()));
        }
        let _ = writeln!(
            text,
            "| {name} | {count} | {refused} of {} | {:.2} | {:.2} | {:.2} |",
            count as u64 * SEEDS,
            quantile(&errors, 0.5),
            mean(&errors),
            quantile(&errors, 1.0)
        );
        means.push(mean(&errors));
    }
    means[means.len() - 1] / means[0]
}

/// Mean error of a walk over the truth points.
fn error_m(walk: &Walk, path: &[Vec2], truth: &[TruthPoint]) -> f64 {
    mean(&metrics::errors_m(walk, path, truth))
}

fn robots(text: &mut String) {
    text.push_str("\n## A corrected robot as a walker\n\n`hitl simulate loop`: a robot's two laps; its map by odometry, and after its corrections (`hitl correct`), each as a walk (`hitl export … -o robot.csv`). Three people go the same way with heading drifts of 6, −4 and 8 °/min. FeetSLAM, 2,000 particles, ten seeds; mean error along the whole way, metres; median [worst] over seeds.\n\n| walks given | the robot's own walk, as given | people, dead reckoning | people, after |\n|---|---|---|---|\n");
    let mut rows: Vec<(&str, [Vec<f64>; 3])> = vec![
        ("people only", Default::default()),
        ("people and the robot's odometry", Default::default()),
        ("people and the corrected robot", Default::default()),
    ];
    for seed in 1..=SEEDS {
        let settings = hitl_slam::simulate::Settings { seed, ..Default::default() };
        let run =
            hitl_slam::simulate::run(hitl_slam::simulate::Scenario::Loop, &settings).expect("a scenario");
        let mut corrector = Corrector::new(run.map.clone(), pipeline::Options::default()).expect("a map");
        run.corrections.iter().for_each(|c| drop(corrector.apply(c).expect("strokes on the map")));
        let route = route(&run.truth);
        let people: Vec<(Walk, Vec<TruthPoint>)> = [6.0f64, -4.0, 8.0]
            .iter()
            .enumerate()
            .map(|(k, deg_per_min)| {
                let rate_rad_per_m = deg_per_min.to_radians() / 60.0 * gait::STEP_S / gait::STEP_M;
                let drift = gait::Drift { rate_rad_per_m, ..gait::Drift::STEADY };
                gait::walk(&format!("person{k}"), &route, &drift, 5, Key::new(seed).with(k as u64))
            })
            .collect();
        let truth_of_robot: Vec<TruthPoint> = stamps(&run.map)
            .iter()
            .zip(&run.truth)
            .skip(1)
            .map(|(&stamp_s, p)| TruthPoint { walker: "robot".into(), stamp_s, position: p.translation() })
            .collect();
        for (k, (_, columns)) in rows.iter_mut().enumerate() {
            let mut walks: Vec<Walk> = people.iter().map(|p| p.0.clone()).collect();
            if let Some(map) = [None, Some(&run.map), Some(corrector.map())][k] {
                let (robot, _) = walks_of_map::walks(map).expect("a walk").remove(0);
                let robot = facing(Walk { name: "robot".into(), ..robot }, run.truth[0], route.start());
                columns[0].push(error_m(&robot, &positions(&robot.track(route.start())), &truth_of_robot));
                walks.push(robot);
            }
            let options = Options { seed, particles: 2_000, iterations: 4, ..Options::default() };
            let start = Start { pose: route.start(), ..Start::default() };
            let outcome = successive::run(&walks, start, false, &Mapping::FeetSlam, &options, &mut |_| ())
                .expect("walks");
            let over = |path: &dyn Fn(usize) -> Vec<Vec2>| {
                mean(
                    &people.iter().enumerate().map(|(j, (w, t))| error_m(w, &path(j), t)).collect::<Vec<_>>(),
                )
            };
            columns[1].push(over(&|j| positions(&people[j].0.track(start.pose))));
            columns[2].push(over(&|j| positions(&outcome.estimates[j].mean)));
        }
    }
    for (name, columns) in &rows {
        let cell = |values: &Vec<f64>| match values.is_empty() {
            true => "–".to_owned(),
            false => format!("{:.2} [{:.2}]", quantile(values, 0.5), quantile(values, 1.0)),
        };
        let _ = writeln!(
            text,
            "| {name} | {} | {} | {} |",
            cell(&columns[0]),
            cell(&columns[1]),
            cell(&columns[2])
        );
    }
}

fn stamps(map: &SlamMap) -> Vec<f64> {
    map.stamps_s.clone().unwrap_or_else(|| (0..map.poses.len()).map(|k| k as f64).collect())
}

/// A walk that began at `old`, for a start at the same place with another heading.
fn facing(mut walk: Walk, old: Pose2, new: Pose2) -> Walk {
    if let Some(first) = walk.steps.first_mut() {
        let turn = Pose2::new(0.0, 0.0, old.theta_rad - new.theta_rad);
        let moved = turn.rotate(Vec2::new(first.forward_m, first.left_m));
        (first.forward_m, first.left_m) = (moved.x, moved.y);
        first.turn_rad = wrap_angle(first.turn_rad + turn.theta_rad);
    }
    walk
}

/// The robot's true way as a walker goes it: corners at least half a metre apart.
fn route(truth: &[Pose2]) -> Route {
    let mut points: Vec<Vec2> = Vec::new();
    for p in truth.iter().map(|p| p.translation()) {
        if points.last().is_none_or(|last| (p - last).norm() >= 0.5) {
            points.push(p);
        }
    }
    Route { points, marked: Vec::new() }
}
