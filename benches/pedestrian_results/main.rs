//! `cargo bench --bench pedestrian_results`: writes docs/RESULTS-pedestrian.md and docs/img/pedestrian-*.png.
//!
//! Ten seeds, 10,000 particles unless a line says otherwise. Takes some minutes on two cores.

mod buildings;

use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

use hitl_slam::geometry::{Pose2, Vec2};
use hitl_slam::io;
use hitl_slam::pedestrian::feetslam::Snapshot;
use hitl_slam::pedestrian::footslam::Estimate;
use hitl_slam::pedestrian::picture::HexPicture;
use hitl_slam::pedestrian::successive::{self, Ends, Mode, Outcome};
use hitl_slam::pedestrian::{GridChoice, Options, Start, TransitionMap, Walk, metrics};
use hitl_slam::simulate::walkers::{Scenario, Settings, Simulation};

const SEEDS: u64 = 10;

/// `-- --quick`: fewer particles and cases, for a busy machine; the page says so.
fn is_quick() -> bool {
    std::env::args().any(|a| a == "--quick")
}

/// Particles of the corridor experiments.
fn particles() -> usize {
    if is_quick() { 2_000 } else { 10_000 }
}

fn rounds() -> Mode {
    Mode::Successive(Ends::Lengths(vec![14.0, 24.0, 34.0]))
}

fn run(simulation: &Simulation, mode: &Mode, options: &Options) -> Outcome {
    run_seen(simulation, mode, options, &mut |_| ())
}

fn run_seen(
    simulation: &Simulation,
    mode: &Mode,
    options: &Options,
    see: &mut dyn FnMut(&Snapshot),
) -> Outcome {
    let start = Start { pose: simulation.starts[0], ..Start::default() };
    successive::run(&simulation.walks, start, false, mode, options, see).expect("simulated walks are fine")
}

fn positions(poses: &[Pose2]) -> Vec<Vec2> {
    poses.iter().map(|p| p.translation()).collect()
}

/// Errors at every true position: best particle, weighted mean, dead reckoning.
fn errors(simulation: &Simulation, walk: &Walk, estimate: &Estimate, start: Pose2) -> [Vec<f64>; 3] {
    [estimate.best.clone(), positions(&estimate.mean), positions(&walk.track(start))]
        .map(|path| metrics::errors_m(walk, &path, &simulation.truth))
}

fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[((sorted.len() - 1) as f64 * share).round() as usize]
}

fn median(values: &[f64]) -> String {
    format!("{:.2} [{:.2}–{:.2}]", quantile(values, 0.5), quantile(values, 0.25), quantile(values, 0.75))
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// End errors of all walkers and seeds.
#[derive(Default)]
struct Ends3 {
    best: Vec<f64>,
    mean: Vec<f64>,
    pdr: Vec<f64>,
    /// Mean over walkers / mean over walkers of PDR, per seed.
    ratio: Vec<f64>,
    fall_backs: usize,
}

fn ends(scenario: Scenario, settings: Settings, mode: &Mode, options: Options) -> Ends3 {
    let mut all = Ends3::default();
    for seed in 1..=SEEDS {
        let simulation = scenario.run(&Settings { seed, ..settings }, &[]).expect("a scenario");
        let outcome = run(&simulation, mode, &Options { seed, ..options });
        all.fall_backs += usize::from(outcome.fall_back.is_some());
        let from = all.mean.len();
        for (walk, estimate) in simulation.walks.iter().zip(&outcome.estimates) {
            let last = errors(&simulation, walk, estimate, simulation.starts[0]).map(|e| e[e.len() - 1]);
            all.best.push(last[0]);
            all.mean.push(last[1]);
            all.pdr.push(last[2]);
        }
        all.ratio.push(mean(&all.mean[from..]) / mean(&all.pdr[from..]));
    }
    all
}

fn row(text: &mut String, name: &str, e: &Ends3) {
    let worst = quantile(&e.ratio, 1.0);
    let _ = writeln!(
        text,
        "| {name} | {} | {} | {} | {:.2} | {:.2} | {}/{SEEDS} |",
        median(&e.pdr),
        median(&e.mean),
        median(&e.best),
        mean(&e.mean) / mean(&e.pdr),
        worst,
        e.fall_backs
    );
    eprintln!(
        "{name}: pdr {} mean {} best {} worst {worst:.2}",
        median(&e.pdr),
        median(&e.mean),
        median(&e.best)
    );
}

const HEAD: &str = "| case | PDR, m | weighted mean, m | best particle, m | mean/PDR | worst seed's mean/PDR | fell back |\n|---|---|---|---|---|---|---|\n";

fn peak_mb() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let kib = status.lines().find(|l| l.starts_with("VmHWM:")).and_then(|l| l.split_whitespace().nth(1));
    kib.and_then(|k| k.parse::<f64>().ok()).unwrap_or(f64::NAN) * 1024.0 / 1e6
}

fn speed(text: &mut String) {
    let simulation = Scenario::Six.run(&Settings::default(), &[]).expect("a scenario");
    text.push_str("\n## Speed and memory\n\nExperiment 2, 10 iterations, 10,000 particles, six walkers. The machine was shared with other builds (load 7 on two cores), hence the CPU column.\n\n| threads | particle-steps | wall, s | CPU, s | CPU ns per particle-step | peak RSS, MB |\n|---|---|---|---|---|---|\n");
    for threads in [2, 1] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let (started, cpu) = (Instant::now(), cpu_s());
        let steps = pool.install(|| run(&simulation, &rounds(), &Options::default())).particle_steps;
        let (wall, cpu) = (started.elapsed().as_secs_f64(), cpu_s() - cpu);
        let ns = cpu * 1e9 / steps as f64;
        let _ = writeln!(
            text,
            "| {threads} | {:.1} M | {wall:.2} | {cpu:.2} | {ns:.1} | {:.0} |",
            steps as f64 / 1e6,
            peak_mb()
        );
        eprintln!("{threads} threads: {wall:.2} s, {ns:.1} CPU ns");
    }
}

/// CPU time of this process, seconds (100 ticks a second on Linux).
fn cpu_s() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after_name = stat.rsplit(')').next().unwrap_or_default();
    after_name.split_whitespace().skip(11).take(2).filter_map(|v| v.parse::<f64>().ok()).sum::<f64>() / 100.0
}

fn experiments(text: &mut String) {
    let options = Options { iterations: 3, particles: particles(), ..Options::default() };
    text.push_str("\n## Experiment 2: successive, ends at 14, 24, 34 m and the end; error at the end (GTP3)\n\n3 iterations a round; median [quartiles] over 6 walkers × 10 seeds. The last columns: mean over walkers against PDR.\n\n");
    text.push_str(HEAD);
    for turn_deg in [-30.0, -4.0, 15.0] {
        let e = ends(Scenario::Six, Settings { turn_deg, ..Settings::default() }, &rounds(), options);
        row(text, &format!("aligned, world turned by {turn_deg}°"), &e);
    }
    let regrid = Options { grid: GridChoice::Regrid, ..options };
    row(text, "regrid (isotropic)", &ends(Scenario::Six, Settings::default(), &rounds(), regrid));
    for deg in [-30.0, -15.0, -7.0, -4.0, 0.0, 7.0, 15.0, 30.0_f64] {
        let fixed = Options { grid: GridChoice::Fixed(deg.to_radians()), particles: 2_000, ..options };
        row(
            text,
            &format!("fixed at {deg}° (2,000 particles)"),
            &ends(Scenario::Six, Settings::default(), &rounds(), fixed),
        );
    }
    oracles(text);
    text.push_str("\n## Experiment 1: FeetSLAM once on the whole walks\n\nMedian error of the weighted mean over walkers and seeds at the marked points, m.\n\n| grid | x = 10 m | 20 m | 30 m | end | PDR at the end |\n|---|---|---|---|---|---|\n");
    for (name, grid) in [
        ("regrid", GridChoice::Regrid),
        ("fixed at 15°", GridChoice::Fixed(0.2618)),
        ("aligned", GridChoice::Aligned),
    ] {
        let mut at: [Vec<f64>; 5] = Default::default();
        for seed in 1..=SEEDS {
            let simulation =
                Scenario::Six.run(&Settings { seed, ..Settings::default() }, &[]).expect("a scenario");
            let outcome = run(&simulation, &Mode::FeetSlam, &Options { seed, grid, ..options });
            for (walk, estimate) in simulation.walks.iter().zip(&outcome.estimates) {
                let [_, mean, pdr] = errors(&simulation, walk, estimate, simulation.starts[0]);
                (0..4).for_each(|k| at[k].push(mean[k + 2]));
                at[4].push(pdr[5]);
            }
        }
        let cells: Vec<String> = at.iter().map(|v| median(v)).collect();
        let _ = writeln!(text, "| {name} | {} |", cells.join(" | "));
        eprintln!("experiment 1 {name}: {}", cells.join(" | "));
    }
}

/// What arithmetic alone gives: the mean of the walkers, their median.
fn oracles(text: &mut String) {
    let (mut average, mut middle) = (Vec::new(), Vec::new());
    for seed in 1..=SEEDS {
        let simulation =
            Scenario::Six.run(&Settings { seed, ..Settings::default() }, &[]).expect("a scenario");
        let ends: Vec<Vec2> = simulation
            .walks
            .iter()
            .map(|w| w.track(simulation.starts[0])[w.steps.len()].translation())
            .collect();
        let truth = simulation.truth[simulation.truth.len() - 1].position;
        let axis = |k: usize| ends.iter().map(|p| p[k]).collect::<Vec<f64>>();
        average.push((Vec2::new(mean(&axis(0)), mean(&axis(1))) - truth).norm());
        middle.push((Vec2::new(quantile(&axis(0), 0.5), quantile(&axis(1), 0.5)) - truth).norm());
    }
    let _ = writeln!(
        text,
        "\nOracles without any filter: mean of the six walkers {} m, median of the six {} m.",
        median(&average),
        median(&middle)
    );
}

fn controls(text: &mut String) {
    text.push_str("\n## Controls (Experiment 2, aligned grid with its fall-back, 3 iterations)\n\n");
    text.push_str(HEAD);
    let options = Options { iterations: 3, particles: particles(), ..Options::default() };
    let corner = |bend_deg, bend_at_m| Settings { bend_deg, bend_at_m, ..Settings::default() };
    let curve = |radius_m| Settings { radius_m, ..Settings::default() };
    let plain = Settings::default();
    let mut cases = vec![
        ("one walker (e = +4 m)".to_owned(), Scenario::Six, Settings { walkers: 1, ..plain }),
        ("opposite drifts".to_owned(), Scenario::Opposite, plain),
        ("all +3 m".to_owned(), Scenario::OneSided, plain),
        ("three enter a room".to_owned(), Scenario::Rooms, plain),
    ];
    for bend in [2.0, 4.0, -1.0, -2.0, -3.0, -4.0, -5.0] {
        cases.push((format!("long leg off by {bend}°"), Scenario::Corner, corner(bend, 10.0)));
    }
    for bend in [20.0, 45.0, 90.0] {
        cases.push((format!("corner of {bend}° at 20 m"), Scenario::Corner, corner(bend, 20.0)));
    }
    for radius in [100.0, -100.0, -200.0] {
        cases.push((format!("curve of {radius} m"), Scenario::Curve, curve(radius)));
    }
    for (name, scenario, settings) in cases {
        row(text, &name, &ends(scenario, settings, &rounds(), options));
    }
}

fn laps(text: &mut String) {
    text.push_str("\n## FootSLAM with revisits: 30 minutes of laps (36 m × 18 m ring and cross passage), one walker\n\n| seed | PDR, worst m | best particle, median m | worst m | weighted mean, median m | worst m | s |\n|---|---|---|---|---|---|---|\n");
    for seed in 1..=if is_quick() { 4 } else { SEEDS } {
        let settings = Settings { seed, minutes: 30.0, ..Settings::default() };
        let simulation = Scenario::Loops.run(&settings, &[]).expect("a scenario");
        let started = Instant::now();
        let outcome = run(&simulation, &Mode::FootSlam, &Options { seed, ..Options::default() });
        let seconds = started.elapsed().as_secs_f64();
        let [best, mean, pdr] =
            errors(&simulation, &simulation.walks[0], &outcome.estimates[0], simulation.starts[0]);
        let q = quantile;
        let _ = writeln!(
            text,
            "| {seed} | {:.1} | {:.2} | {:.2} | {:.2} | {:.2} | {seconds:.1} |",
            q(&pdr, 1.0),
            q(&best, 0.5),
            q(&best, 1.0),
            q(&mean, 0.5),
            q(&mean, 1.0)
        );
        eprintln!(
            "laps {seed}: pdr {:.1} best {:.2}/{:.2} {seconds:.1} s",
            q(&pdr, 1.0),
            q(&best, 0.5),
            q(&best, 1.0)
        );
        if seed == 1 {
            let paths = |path: Vec<Vec2>| vec![path];
            let picture = |file: &str, title: &str, maps, paths| {
                save(
                    file,
                    &HexPicture { title: title.into(), maps, walls: &simulation.walls, paths, width_px: 900 },
                );
            };
            let track = positions(&simulation.walks[0].track(simulation.starts[0]));
            picture(
                "pedestrian-laps-before.png",
                "30 minutes of laps: dead reckoning",
                Vec::new(),
                paths(track),
            );
            let map = vec![(String::new(), &outcome.total)];
            picture(
                "pedestrian-laps-after.png",
                "FootSLAM: best particle and map",
                map,
                paths(outcome.estimates[0].best.clone()),
            );
        }
    }
}

fn save(file: &str, picture: &HexPicture) {
    let path = Path::new("docs/img").join(file);
    io::atomic::write(&path, |out| out.write_all(&picture.draw().to_png())).expect("docs/img can be written");
}

fn figures() {
    let simulation = Scenario::Six.run(&Settings::default(), &[]).expect("a scenario");
    let (mut rounds_maps, mut iteration_maps) = (Vec::new(), Vec::new());
    let options = Options { iterations: 3, particles: particles(), ..Options::default() };
    let outcome = run_seen(&simulation, &rounds(), &options, &mut |s| {
        rounds_maps.truncate(s.round);
        rounds_maps.push(s.total.clone());
    });
    let regrid = Options { grid: GridChoice::Fixed(0.2618), ..options };
    run_seen(&simulation, &Mode::FeetSlam, &regrid, &mut |s| iteration_maps.push(s.total.clone()));
    let named = |name: &str, maps: &[TransitionMap], first: usize| -> Vec<(String, TransitionMap)> {
        maps.iter().enumerate().map(|(k, m)| (format!("{name} {}", k + first), m.clone())).collect()
    };
    let walls = simulation.walls.as_slice();
    let draw = |file: &str, title: &str, maps: &[(String, TransitionMap)], paths: Vec<Vec<Vec2>>| {
        let maps = maps.iter().map(|(n, m)| (n.clone(), m)).collect();
        save(file, &HexPicture { title: title.into(), maps, walls, paths, width_px: 900 });
    };
    draw(
        "pedestrian-rounds.png",
        "Experiment 2 (Fig. 5): total map after each round",
        &named("round", &rounds_maps, 1),
        Vec::new(),
    );
    draw(
        "pedestrian-iterations.png",
        "Experiment 1 (Fig. 3), grid at 15°: total map",
        &named("iteration", &iteration_maps, 0),
        Vec::new(),
    );
    let tracks = simulation.walks.iter().map(|w| positions(&w.track(simulation.starts[0]))).collect();
    draw("pedestrian-before.png", "Dead reckoning of the six walkers (Fig. 2)", &[], tracks);
    let means = outcome.estimates.iter().map(|e| positions(&e.mean)).collect();
    draw("pedestrian-after.png", "Experiment 2: weighted means", &[], means);
}

fn main() {
    if std::env::args().any(|a| a == "--figures") {
        return figures();
    }
    let started = Instant::now();
    let mut text = String::from(
        "# Results: pedestrians\n\nWritten by `cargo bench --bench pedestrian_results`; every number is from simulated walks (`hitl feetslam simulate`), seeds 1–10, 10,000 particles unless a line says otherwise. Read docs/MATH-pedestrian.md, \"What the aligned grid is\", before quoting any of the small numbers: they come from a straight-corridor prior and not from the map.\n",
    );
    if is_quick() {
        text.push_str("\n**This page is a `--quick` run (the machine was busy): 2,000 particles in the corridor experiments and controls, 4 seeds of laps, 1 per building.** Without `--quick`: 10,000 particles, 10 seeds.\n");
    }
    figures();
    for section in [speed, experiments, laps, controls, buildings::alignment] {
        section(&mut text);
        write_page(&text);
    }
    let _ = writeln!(
        text,
        "\n![rounds](img/pedestrian-rounds.png)\n![iterations](img/pedestrian-iterations.png)\n![before](img/pedestrian-before.png)\n![after](img/pedestrian-after.png)\n![laps, before](img/pedestrian-laps-before.png)\n![laps, after](img/pedestrian-laps-after.png)\n\nThe whole page took {:.0} s.",
        started.elapsed().as_secs_f64()
    );
    write_page(&text);
}

fn write_page(text: &str) {
    let path = Path::new("docs/RESULTS-pedestrian.md");
    io::atomic::write(path, |out| out.write_all(text.as_bytes())).expect("docs can be written");
}
