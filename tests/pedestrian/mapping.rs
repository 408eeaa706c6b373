//! FootSLAM, FeetSLAM and successive mapping on small versions of the experiments (docs/RESULTS-pedestrian.md has the
//! full ones).

use hitl_slam::geometry::Vec2;
use hitl_slam::pedestrian::footslam::{self, Estimate, Pass};
use hitl_slam::pedestrian::hex::HexGrid;
use hitl_slam::pedestrian::random::Key;
use hitl_slam::pedestrian::successive::{self, Ends, Mode, Outcome};
use hitl_slam::pedestrian::{GridChoice, Layout, Options, Start, metrics};
use hitl_slam::simulate::walkers::{Scenario, Settings, Simulation};

fn rounds() -> Mode {
    Mode::Successive(Ends::Lengths(vec![14.0, 24.0, 34.0]))
}

fn simulate(scenario: Scenario, settings: Settings) -> Simulation {
    scenario.run(&settings, &[]).unwrap()
}

fn run(simulation: &Simulation, mode: &Mode, options: &Options) -> Outcome {
    let start = Start { pose: simulation.starts[0], ..Start::default() };
    successive::run(&simulation.walks, start, false, mode, options, &mut |_| ()).unwrap()
}

fn small() -> Options {
    Options { particles: 1_000, iterations: 2, ..Options::default() }
}

/// Errors of the weighted means and of dead reckoning at each walker's last true position.
fn last_errors(simulation: &Simulation, outcome: &Outcome) -> (Vec<f64>, Vec<f64>) {
    let last = |walk: &hitl_slam::pedestrian::Walk, path: &[Vec2]| {
        *metrics::errors_m(walk, path, &simulation.truth).last().unwrap()
    };
    let walks = || simulation.walks.iter().zip(&outcome.estimates).zip(&simulation.starts);
    let mean = |((walk, e), _): ((_, &hitl_slam::pedestrian::footslam::Estimate), _)| {
        last(walk, &e.mean.iter().map(|p| p.translation()).collect::<Vec<_>>())
    };
    let pdr = |((walk, _), start): ((&hitl_slam::pedestrian::Walk, _), &hitl_slam::geometry::Pose2)| {
        last(walk, &walk.track(*start).iter().map(|p| p.translation()).collect::<Vec<_>>())
    };
    (walks().map(mean).collect(), walks().map(pdr).collect())
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[test]
fn successive_mapping_on_the_aligned_grid_ends_within_half_a_metre_however_the_world_is_turned() {
    for turn_deg in [-30.0, -4.0, 0.0, 7.0, 15.0] {
        let mut errors = Vec::new();
        for seed in 1..=2 {
            let simulation = simulate(Scenario::Six, Settings { seed, turn_deg, ..Settings::default() });
            errors.extend(last_errors(&simulation, &run(&simulation, &rounds(), &small())).0);
        }
        let median = median(errors);
        assert!(median <= 0.5, "{turn_deg}°: {median} m");
    }
}

#[test]
fn no_control_is_much_worse_than_dead_reckoning() {
    let corner = |bend_deg| (Scenario::Corner, Settings { bend_deg, bend_at_m: 10.0, ..Settings::default() });
    let curve = |radius_m| (Scenario::Curve, Settings { radius_m, ..Settings::default() });
    let plain = |scenario| (scenario, Settings::default());
    for (scenario, settings) in [
        plain(Scenario::Opposite),
        plain(Scenario::OneSided),
        plain(Scenario::Rooms),
        corner(-4.0),
        corner(3.0),
        corner(20.0),
        corner(90.0),
        curve(100.0),
    ] {
        let simulation = simulate(scenario, settings);
        let (errors, pdr) = last_errors(&simulation, &run(&simulation, &rounds(), &small()));
        let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
        assert!(mean(&errors) <= 1.1 * mean(&pdr), "{scenario} {settings:?}: {errors:?} {pdr:?}");
    }
}

#[test]
fn one_walker_alone_in_fresh_ground_is_dead_reckoning() {
    let simulation = simulate(Scenario::Six, Settings { walkers: 1, ..Settings::default() });
    let options = Options { particles: 4_000, grid: GridChoice::Regrid, ..Options::default() };
    let (errors, pdr) = last_errors(&simulation, &run(&simulation, &Mode::FootSlam, &options));
    assert!((errors[0] - pdr[0]).abs() < 0.3, "{errors:?} {pdr:?}");
}

#[test]
fn laps_keep_the_error_bounded_where_dead_reckoning_drifts_away() {
    let (mut pdr_m, mut rms_m) = (0.0_f64, Vec::new());
    for seed in 1..=3 {
        let simulation = simulate(Scenario::Loops, Settings { seed, minutes: 8.0, ..Settings::default() });
        let options = Options { particles: 2_000, islands: 4, seed, ..Options::default() };
        let outcome = run(&simulation, &Mode::FootSlam, &options);
        let walk = &simulation.walks[0];
        let track: Vec<Vec2> = walk.track(simulation.starts[0]).iter().map(|p| p.translation()).collect();
        let errors = |path: &[Vec2]| metrics::errors_m(walk, path, &simulation.truth);
        pdr_m = pdr_m.max(errors(&track).into_iter().fold(0.0, f64::max));
        let off = errors(&outcome.estimates[0].best);
        rms_m.push((off.iter().map(|e| e * e).sum::<f64>() / off.len() as f64).sqrt());
        let walls = metrics::crossed_wall_ratio(&outcome.total, &simulation.walls);
        assert!(walls < 0.3, "seed {seed}: {walls}");
    }
    assert!(pdr_m > 7.0 && rms_m.iter().all(|&e| e < 1.5), "dead reckoning {pdr_m} m, FootSLAM {rms_m:?} m");
}

#[test]
fn of_several_islands_the_most_central_path_is_kept_and_the_mean_is_that_of_all_but_those_astray() {
    let simulation = simulate(Scenario::Loops, Settings { minutes: 3.0, ..Settings::default() });
    let (walk, start) = (&simulation.walks[0], Start { pose: simulation.starts[0], ..Start::default() });
    let grid = HexGrid { radius_m: 0.5, angle_rad: 0.1, origin: Vec2::zeros() };
    let layout = Layout::around(&grid, walk.track(start.pose).iter().map(|p| p.translation())).unwrap();
    let options = Options { particles: 1_000, islands: 5, ..Options::default() };
    let pass = |options, key| Pass {
        steps: &walk.steps,
        start,
        grid,
        layout,
        prior: None,
        options,
        key,
        sampled_paths: 10,
        parallel: true,
    };
    let kept = footslam::run_islands(&pass(&options, Key::new(4)));
    let share = Options { particles: 200, ..options };
    let islands: Vec<Estimate> = (0..5).map(|k| footslam::run(&pass(&share, Key::new(4).with(k)))).collect();
    let off = |a: &Estimate| -> f64 {
        islands.iter().flat_map(|b| a.best.iter().zip(&b.best)).map(|(p, q)| (p - q).norm()).sum()
    };
    let offs: Vec<f64> = islands.iter().map(off).collect();
    let central = (0..5).min_by(|&a, &b| offs[a].total_cmp(&offs[b])).unwrap();
    assert_eq!(Estimate { mean: Vec::new(), sigma_m: Vec::new(), ..kept.clone() }, {
        let island = islands[central].clone();
        Estimate { mean: Vec::new(), sigma_m: Vec::new(), ..island }
    });
    let counting: Vec<&Estimate> =
        islands.iter().zip(&offs).filter(|(_, o)| **o <= 2.0 * offs[central]).map(|(e, _)| e).collect();
    for (k, pose) in kept.mean.iter().enumerate() {
        let sum: Vec2 = counting.iter().map(|e| e.mean[k].translation()).sum();
        assert!((pose.translation() - sum / counting.len() as f64).norm() < 1e-9);
        let widest = counting.iter().map(|e| e.sigma_m[k]).fold(f64::INFINITY, f64::min);
        assert!(kept.sigma_m[k] >= 0.999 * widest, "step {k}");
    }
    assert!(offs.iter().any(|&o| o > 1.1 * offs[central]), "{offs:?}: the test says little");
}

#[test]
fn neither_the_number_of_threads_nor_the_order_of_the_walks_changes_a_bit() {
    let simulation = simulate(Scenario::Rooms, Settings { walkers: 3, ..Settings::default() });
    let with_threads = |threads: usize, simulation: &Simulation| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(simulation, &rounds(), &Options { particles: 2_500, ..small() }))
    };
    let one = with_threads(1, &simulation);
    let mut backwards = simulation.clone();
    backwards.walks.reverse();
    for (threads, simulation) in [(2, &simulation), (5, &simulation), (3, &backwards)] {
        let mut other = with_threads(threads, simulation);
        if simulation.walks[0].name != "w1" {
            other.estimates.reverse();
        }
        assert_eq!(one.estimates, other.estimates, "{threads} threads");
        assert_eq!(one.total, other.total);
    }
}

#[test]
fn every_mode_and_option_runs_and_repeats_itself() {
    let simulation = simulate(Scenario::Six, Settings { walkers: 2, ..Settings::default() });
    let base = Options { particles: 200, iterations: 1, ..Options::default() };
    for options in [
        base,
        Options { own_map_in_prior: true, ..base },
        Options { window_m: Some(12.0), ..base },
        Options { gain: 0.3, gain_schedule: hitl_slam::pedestrian::GainSchedule::Annealed, ..base },
        Options { grid: GridChoice::Fixed(0.2), converged_below: 0.9, ..base },
        Options { grid: GridChoice::Regrid, iterations: 0, ..base },
    ] {
        for mode in
            [Mode::FootSlam, Mode::FeetSlam, rounds(), Mode::Successive(Ends::Times(vec![20.0, 40.0]))]
        {
            let (a, b) = (run(&simulation, &mode, &options), run(&simulation, &mode, &options));
            assert_eq!(a.estimates, b.estimates);
            for (walk, e) in simulation.walks.iter().zip(&a.estimates) {
                let n = walk.steps.len() + 1;
                assert_eq!([e.best.len(), e.mean.len(), e.sigma_m.len()], [n; 3], "{options:?} {mode:?}");
                assert!(e.mean.iter().all(|p| p.is_finite()));
            }
        }
    }
}

#[test]
fn options_out_of_range_are_named() {
    let simulation = simulate(Scenario::Six, Settings { walkers: 1, ..Settings::default() });
    for (options, name) in [
        (Options { particles: 1, ..small() }, "particles"),
        (Options { alpha: f64::NAN, ..small() }, "alpha"),
        (Options { hex_radius_m: 0.0, ..small() }, "hexagon radius"),
        (Options { iterations: 11, ..small() }, "iterations"),
        (Options { particles: 6, islands: 4, ..small() }, "particles of an island: found 1, expected"),
    ] {
        let result = successive::run(
            &simulation.walks,
            Start::default(),
            false,
            &Mode::FeetSlam,
            &options,
            &mut |_| (),
        );
        assert!(crate::support::message(result).starts_with(name));
    }
}
