//! Steps as they arrive: FootSLAM line by line, causal, and never in two ways.

use hitl_slam::geometry::{Pose2, Vec2};
use hitl_slam::pedestrian::live::{Event, Live, Position, Settings};
use hitl_slam::pedestrian::successive::{self, Mode};
use hitl_slam::pedestrian::{GridChoice, Options, Start, Step, Walk};
use hitl_slam::simulate::walkers::{self, Scenario, Simulation};

fn simulate(scenario: Scenario, seed: u64, walkers: usize) -> Simulation {
    let settings = walkers::Settings { seed, walkers, minutes: 3.0, ..walkers::Settings::default() };
    scenario.run(&settings, &[]).unwrap()
}

fn settings(simulation: &Simulation, options: Options) -> Settings {
    Settings {
        options,
        start: Start { pose: simulation.starts[0], ..Start::default() },
        ..Settings::default()
    }
}

fn few() -> Options {
    Options { particles: 500, ..Options::default() }
}

/// The steps of all walks by time.
fn interleaved(walks: &[Walk]) -> Vec<(&str, Step)> {
    let mut steps: Vec<(&str, Step)> =
        walks.iter().flat_map(|w| w.steps.iter().map(|s| (w.name.as_str(), *s))).collect();
    steps.sort_by(|a, b| a.1.time_s.total_cmp(&b.1.time_s));
    steps
}

fn follow(live: &mut Live, steps: &[(&str, Step)]) -> Vec<Position> {
    let mut take = |&(name, step): &(&str, Step)| {
        let position = live.step(name, step).unwrap();
        live.settle();
        position
    };
    steps.iter().map(&mut take).collect()
}

/// Distance of the end of a walker's path from where it truly was.
fn last_error_m(simulation: &Simulation, name: &str, path: &[Vec2]) -> f64 {
    let walk = simulation.walks.iter().find(|w| w.name == name).unwrap();
    *hitl_slam::pedestrian::metrics::errors_m(walk, path, &simulation.truth).last().unwrap()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[test]
fn one_walker_on_a_fixed_grid_is_footslam_bit_for_bit() {
    for seed in 1..=3 {
        let simulation = simulate(Scenario::Loops, seed, 1);
        let options = Options { grid: GridChoice::Fixed(0.2), seed, ..few() };
        let settings = settings(&simulation, options);
        let whole =
            successive::run(&simulation.walks, settings.start, false, &Mode::FootSlam, &options, &mut |_| ())
                .unwrap();
        let mut live = Live::new(&settings).unwrap();
        let positions = follow(&mut live, &interleaved(&simulation.walks));
        let means: Vec<Pose2> = positions.iter().map(|p| p.mean).collect();
        assert_eq!(means, whole.estimates[0].mean[1..], "seed {seed}");
        let sigmas: Vec<f64> = positions.iter().map(|p| p.sigma_m).collect();
        assert_eq!(sigmas, whole.estimates[0].sigma_m[1..]);
    }
}

#[test]
fn no_position_depends_on_what_comes_later_or_on_the_number_of_threads() {
    let simulation = simulate(Scenario::Six, 4, 0);
    let settings = settings(&simulation, few());
    let steps = interleaved(&simulation.walks);
    let run = |steps: &[(&str, Step)], threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| follow(&mut Live::new(&settings).unwrap(), steps))
    };
    let all = run(&steps, 1);
    for count in [1, 77, 200, 301] {
        assert_eq!(run(&steps[..count], 3), all[..count], "the first {count} steps");
    }
}

#[test]
fn a_walker_who_comes_late_profits_from_those_who_went_before() {
    // Drifts of ±3, ±2, ±1 m: what the others' maps have in common is the corridor.
    let (mut with, mut alone) = (Vec::new(), Vec::new());
    for seed in 1..=3 {
        let simulation = simulate(Scenario::Opposite, seed, 0);
        let settings = settings(&simulation, Options { seed, ..few() });
        for late in &simulation.walks {
            let others: Vec<Walk> =
                simulation.walks.iter().filter(|w| w.name != late.name).cloned().collect();
            for (earlier, errors) in [(interleaved(&others), &mut with), (Vec::new(), &mut alone)] {
                let mut live = Live::new(&settings).unwrap();
                follow(&mut live, &earlier);
                let steps = interleaved(std::slice::from_ref(late));
                let start = simulation.starts[0].translation();
                let path = follow(&mut live, &steps).iter().map(|p| p.mean.translation()).collect::<Vec<_>>();
                errors.push(last_error_m(&simulation, &late.name, &[vec![start], path].concat()));
            }
        }
    }
    let (with, alone) = (mean(&with), mean(&alone));
    assert!(with < 0.8 * alone, "{with:.2} m with the others' maps, {alone:.2} m without");
}

#[test]
fn closed_rounds_bring_walkers_who_walk_together_nearer_to_the_truth() {
    let (mut with, mut without) = (Vec::new(), Vec::new());
    for seed in 1..=3 {
        let simulation = simulate(Scenario::Six, seed, 0);
        let settings = settings(&simulation, Options { seed, ..few() });
        let steps = interleaved(&simulation.walks);
        for rounds in [true, false] {
            let mut live = Live::new(&settings).unwrap();
            let (mut taken, mut closed) = (std::collections::BTreeMap::new(), 0);
            for &(name, step) in &steps {
                live.step(name, step).unwrap();
                live.settle();
                *taken.entry(name).or_insert(0) += 1;
                let least = taken.values().min().copied().unwrap_or(0);
                if rounds && taken.len() == 6 && closed < 4 && least >= [20, 34, 49, 60][closed] {
                    closed += 1;
                    (0..5).for_each(|_| drop(live.round()));
                }
            }
            let (walks, outcome) = live.outcome();
            let errors = walks.iter().zip(&outcome.estimates).map(|(walk, e)| {
                last_error_m(
                    &simulation,
                    &walk.name,
                    &e.mean.iter().map(|p| p.translation()).collect::<Vec<_>>(),
                )
            });
            if rounds { &mut with } else { &mut without }.extend(errors);
        }
    }
    let (with, without) = (mean(&with), mean(&without));
    assert!(with < 0.6 * without, "{with:.2} m with, {without:.2} m without");
}

#[test]
fn the_grid_turns_to_the_walkers_once_they_have_gone_far_enough_or_prefers_no_direction() {
    let simulation = Scenario::Six
        .run(&walkers::Settings { seed: 2, turn_deg: 20.0, ..walkers::Settings::default() }, &[])
        .unwrap();
    let settings = settings(&simulation, few());
    let mut live = Live::new(&settings).unwrap();
    let mut turned = Vec::new();
    for (name, step) in interleaved(&simulation.walks) {
        live.step(name, step).unwrap();
        turned.extend(live.settle());
    }
    let [Event::Grid { angle_rad, fall_back: None }] = &turned[..] else { panic!("{turned:?}") };
    assert!((angle_rad.to_degrees() - 20.0).abs() < 3.0, "{}°", angle_rad.to_degrees());

    let settings = Settings { options: few(), ..Settings::default() };
    let mut live = Live::new(&settings).unwrap();
    let mut events = Vec::new();
    for k in 0..40 {
        // Round and round.
        let step = Step { time_s: f64::from(k), forward_m: 0.7, left_m: 0.0, turn_rad: 0.3 };
        live.step("dizzy", step).unwrap();
        events.extend(live.settle());
    }
    assert!(matches!(events[..], [Event::Grid { fall_back: Some(_), .. }]), "{events:?}");
}

#[test]
fn a_step_that_cannot_be_is_refused_and_changes_nothing() {
    let settings = Settings { options: few(), ..Settings::default() };
    let step = |time_s: f64, forward_m: f64| Step { time_s, forward_m, left_m: 0.0, turn_rad: 0.1 };
    let good = [step(1.0, 0.7), step(2.0, 0.7), step(9.5, 0.6)];
    let mut plain = Live::new(&settings).unwrap();
    let expected = follow(&mut plain, &good.map(|s| ("a", s)));
    let mut live = Live::new(&settings).unwrap();
    let mut found = Vec::new();
    for step_ in good {
        found.push(live.step("a", step_).unwrap());
        live.settle();
        for (bad, words) in
            [(step(step_.time_s, 0.7), "expected a later time"), (step(99.0, 5.1), "steps missing")]
        {
            let message = live.step("a", bad).unwrap_err();
            assert!(message.contains(words), "{message}");
        }
        assert!(live.begin("a", Pose2::IDENTITY).is_err(), "a start after the first step");
    }
    assert_eq!(found, expected);
    // Another's clock is its own: earlier than a's is fine.
    live.begin("b", Pose2::new(3.0, 4.0, 0.0)).unwrap();
    let b = live.step("b", step(0.5, 0.7)).unwrap();
    assert!((b.mean.translation() - Vec2::new(3.7, 4.0)).norm() < 0.1);
}

#[test]
fn who_leaves_the_window_of_hexagons_is_named_once() {
    let settings = Settings { options: Options { hex_radius_m: 0.2, ..few() }, ..Settings::default() };
    let mut live = Live::new(&settings).unwrap();
    let mut strayed = Vec::new();
    for k in 0..90 {
        live.step("far", Step { time_s: f64::from(k), forward_m: 0.7, left_m: 0.0, turn_rad: 0.0 }).unwrap();
        let events = live.settle();
        strayed.extend(events.into_iter().filter(|e| matches!(e, Event::Strayed { .. })).map(|e| (k, e)));
    }
    let [(k, Event::Strayed { walker, window_m })] = &strayed[..] else { panic!("{strayed:?}") };
    assert_eq!(walker, "far");
    let reached_m = 0.7 * f64::from(k + 1);
    assert!((reached_m - window_m[0] / 2.0).abs() < 3.0, "{reached_m} m of {window_m:?}");
}
