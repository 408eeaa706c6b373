//! Steps as they arrive: how long an answer takes, and what it is worth.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use hitl_slam::geometry::Vec2;
use hitl_slam::pedestrian::live::{Live, Settings};
use hitl_slam::pedestrian::{Options, Start, Step, Walk, metrics};
use hitl_slam::simulate::walkers::{self, Scenario, Simulation};

use super::{Claim, claim, cpu, mean, positions, quantile};

/// Runs of the same steps; of each step the fastest counts.
const REPEATS: usize = 3;
/// Steps of every walker at which rounds are closed: 14, 24, 34 m and the end.
const ROUNDS_AT: [usize; 4] = [20, 34, 49, 60];

fn settings(simulation: &Simulation, seed: u64, particles: usize) -> Settings {
    let options = Options { seed, particles, ..Options::default() };
    Settings {
        options,
        start: Start { pose: simulation.starts[0], ..Start::default() },
        ..Settings::default()
    }
}

fn interleaved(walks: &[Walk]) -> Vec<(&str, Step)> {
    let mut steps: Vec<(&str, Step)> =
        walks.iter().flat_map(|w| w.steps.iter().map(|s| (w.name.as_str(), *s))).collect();
    steps.sort_by(|a, b| a.1.time_s.total_cmp(&b.1.time_s));
    steps
}

/// The chapter.
pub fn chapter(text: &mut String) -> Vec<Claim> {
    let p99_ms = delays(text);
    gain(text);
    vec![claim(
        "Live: a step of 10,000 particles on one core, CPU time, p99 of the slowest run",
        p99_ms,
        3.0,
        "ms",
        "issue",
    )]
}

/// The largest p99 of an answer, ms.
fn delays(text: &mut String) -> f64 {
    let mut slowest_ms = 0.0_f64;
    text.push_str("\n## Live: time of a step\n\n`hitl feetslam live`, 10,000 particles a walker, one thread. Answer: from the step to its position. Settling: what comes after the answer (maps exchanged after every 20 steps of a walker, the grid turned once after 15 m). CPU time; the same steps three times, the fastest of each counts. Resuming: all steps of the run replayed.\n\n| run | steps | answer, median ms | p99 | most | settling, p99 ms | most | resuming, s |\n|---|---|---|---|---|---|---|---|\n");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    for (name, scenario, walkers, minutes) in [
        ("six walkers, 42 m", Scenario::Six, 0, 1.0),
        ("six walkers, 5 minutes of laps", Scenario::Loops, 6, 5.0),
        ("one walker, 30 minutes of laps", Scenario::Loops, 1, 30.0),
    ] {
        let simulation = scenario
            .run(&walkers::Settings { walkers, minutes, ..walkers::Settings::default() }, &[])
            .expect("a scenario");
        let (settings, steps) = (settings(&simulation, 1, 10_000), interleaved(&simulation.walks));
        let mut least = vec![[f64::INFINITY; 2]; steps.len()];
        let mut whole_s = f64::INFINITY;
        for _ in 0..REPEATS {
            let began = cpu::milliseconds();
            pool.install(|| {
                let mut live = Live::new(&settings).expect("settings");
                for (least, &(name, step)) in least.iter_mut().zip(&steps) {
                    let started = cpu::milliseconds();
                    live.step(name, step).expect("a step");
                    let answered = cpu::milliseconds();
                    live.settle();
                    least[0] = least[0].min(answered - started);
                    least[1] = least[1].min(cpu::milliseconds() - answered);
                }
            });
            whole_s = whole_s.min((cpu::milliseconds() - began) / 1e3);
        }
        let column = |k: usize| least.iter().map(|l| l[k]).collect::<Vec<f64>>();
        let (answer, settle) = (column(0), column(1));
        let _ = writeln!(
            text,
            "| {name} | {} | {:.2} | {:.2} | {:.2} | {:.2} | {:.0} | {whole_s:.1} |",
            steps.len(),
            quantile(&answer, 0.5),
            quantile(&answer, 0.99),
            quantile(&answer, 1.0),
            quantile(&settle, 0.99),
            quantile(&settle, 1.0)
        );
        slowest_ms = slowest_ms.max(quantile(&answer, 0.99));
    }
    slowest_ms
}

fn last_error_m(simulation: &Simulation, walk: &Walk, path: &[Vec2]) -> f64 {
    metrics::errors_m(walk, path, &simulation.truth).last().copied().unwrap_or(f64::NAN)
}

/// Errors at the end of all walkers, whose steps arrive interleaved; `rounds` are closed at each of [`ROUNDS_AT`].
fn together(simulation: &Simulation, settings: &Settings, rounds: usize) -> Vec<f64> {
    let mut live = Live::new(settings).expect("settings");
    let (mut taken, mut closed) = (BTreeMap::new(), 0);
    for (name, step) in interleaved(&simulation.walks) {
        live.step(name, step).expect("a step");
        live.settle();
        *taken.entry(name).or_insert(0) += 1;
        let least = taken.values().min().copied().unwrap_or(0);
        if taken.len() == simulation.walks.len() && closed < ROUNDS_AT.len() && least >= ROUNDS_AT[closed] {
            closed += 1;
            (0..rounds).for_each(|_| drop(live.round()));
        }
    }
    let (walks, outcome) = live.outcome();
    walks
        .iter()
        .zip(&outcome.estimates)
        .map(|(w, e)| last_error_m(simulation, w, &positions(&e.mean)))
        .collect()
}

/// Error at the end of each walker as it was told then, after all the others (or nobody) had been there.
fn late(simulation: &Simulation, settings: &Settings, after_others: bool) -> Vec<f64> {
    let one = |late: &Walk| {
        let mut live = Live::new(settings).expect("settings");
        let others: Vec<Walk> = match after_others {
            true => simulation.walks.iter().filter(|w| w.name != late.name).cloned().collect(),
            false => Vec::new(),
        };
        let mut path = vec![simulation.starts[0].translation()];
        for (name, step) in interleaved(&others).into_iter().chain(interleaved(std::slice::from_ref(late))) {
            let position = live.step(name, step).expect("a step");
            live.settle();
            if name == late.name {
                path.push(position.mean.translation());
            }
        }
        last_error_m(simulation, late, &path)
    };
    simulation.walks.iter().map(one).collect()
}

fn gain(text: &mut String) {
    text.push_str("\n## Live: error at the end\n\nThe paper's corridor (38 m), weighted mean, 2,000 particles, 10 seeds; median [mean] over walkers and seeds, metres. Drifts of `six`: +4.0 to −1.0 m, mostly to one side; of `opposite`: ±3, ±2, ±1 m. Rounds are closed (`{\"request\": \"round\"}`) when everybody has gone 14, 24, 34 m, and at the end.\n\n| | six | opposite |\n|---|---|---|\n");
    let columns: Vec<Vec<Vec<f64>>> = [Scenario::Six, Scenario::Opposite]
        .into_iter()
        .map(|scenario| {
            let mut rows = vec![Vec::new(); 6];
            for seed in 1..=super::SEEDS {
                let simulation = scenario
                    .run(&walkers::Settings { seed, ..walkers::Settings::default() }, &[])
                    .expect("a scenario");
                let settings = settings(&simulation, seed, 2_000);
                rows[0].extend(
                    simulation
                        .walks
                        .iter()
                        .map(|w| last_error_m(&simulation, w, &positions(&w.track(simulation.starts[0])))),
                );
                rows[1].extend(together(&simulation, &settings, 0));
                rows[2].extend(together(&simulation, &settings, 1));
                rows[3].extend(together(&simulation, &settings, 10));
                rows[4].extend(late(&simulation, &settings, false));
                rows[5].extend(late(&simulation, &settings, true));
            }
            rows
        })
        .collect();
    let names = [
        "dead reckoning",
        "all at once, no rounds",
        "all at once, one round at each end",
        "all at once, ten rounds at each end",
        "each alone",
        "each after the other five",
    ];
    for (k, name) in names.iter().enumerate() {
        let cell = |rows: &Vec<Vec<f64>>| format!("{:.2} [{:.2}]", quantile(&rows[k], 0.5), mean(&rows[k]));
        let _ = writeln!(text, "| {name} | {} | {} |", cell(&columns[0]), cell(&columns[1]));
    }
}
