//! `cargo bench --bench pedestrian_results`: writes docs/RESULTS-pedestrian.md and docs/img/pedestrian-*.png.
//!
//! Ten seeds, 10,000 particles unless a line says otherwise. Takes some minutes on two cores.

use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

use hitl_slam::geometry::{Pose2, Vec2};
use hitl_slam::io;
use hitl_slam::pedestrian::feetslam::Snapshot;
use hitl_slam::pedestrian::footslam::Estimate;
use hitl_slam::pedestrian::picture::HexPicture;
use hitl_slam::pedestrian::successive::{self, Ends, Mode, Outcome};
use hitl_slam::pedestrian::{GridChoice, Options, Start, TransitionMap, Walk, align, metrics};
use hitl_slam::simulate::walkers::{Scenario, Settings, Simulation};

const SEEDS: u64 = 10;

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
    text.push_str("\n## Speed and memory\n\nExperiment 2, 10 iterations, 10,000 particles, six walkers. The machine was shared with other builds.\n\n| threads | particle-steps | wall, s | ns per particle-step and thread | peak RSS, MB |\n|---|---|---|---|---|\n");
    for threads in [2, 1] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let mut best = f64::INFINITY;
        let mut steps = 0;
        for _ in 0..2 {
            let started = Instant::now();
            steps = pool.install(|| run(&simulation, &rounds(), &Options::default())).particle_steps;
            best = best.min(started.elapsed().as_secs_f64());
        }
        let ns = best * 1e9 * threads as f64 / steps as f64;
        let _ = writeln!(
            text,
            "| {threads} | {:.1} M | {best:.2} | {ns:.1} | {:.0} |",
            steps as f64 / 1e6,
            peak_mb()
        );
        eprintln!("{threads} threads: {best:.2} s, {ns:.1} ns");
    }
}

fn experiments(text: &mut String) {
    let options = Options { iterations: 3, ..Options::default() };
    text.push_str("\n## Experiment 2: successive, ends at 14, 24, 34 m and the end; error at the end (GTP3)\n\n3 iterations a round; median [quartiles] over 6 walkers × 10 seeds. The last columns: mean over walkers against PDR.\n\n");
    text.push_str(HEAD);
    for turn_deg in [-30.0, -15.0, -4.0, 7.0, 20.0] {
        let e = ends(Scenario::Six, Settings { turn_deg, ..Settings::default() }, &rounds(), options);
        row(text, &format!("aligned, world turned by {turn_deg}°"), &e);
    }
    let regrid = Options { grid: GridChoice::Regrid, ..options };
    row(text, "regrid (isotropic)", &ends(Scenario::Six, Settings::default(), &rounds(), regrid));
    for deg in [-30.0, -22.0, -15.0, -7.0, -4.0, 0.0, 4.0, 7.0, 15.0, 22.0, 30.0_f64] {
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
    let options = Options { iterations: 3, ..Options::default() };
    let corner = |bend_deg, bend_at_m| Settings { bend_deg, bend_at_m, ..Settings::default() };
    let curve = |radius_m| Settings { radius_m, ..Settings::default() };
    let plain = Settings::default();
    let mut cases = vec![
        ("one walker (e = +4 m)".to_owned(), Scenario::Six, Settings { walkers: 1, ..plain }),
        ("opposite drifts".to_owned(), Scenario::Opposite, plain),
        ("all +3 m".to_owned(), Scenario::OneSided, plain),
        ("three enter a room".to_owned(), Scenario::Rooms, plain),
    ];
    for bend in [1.0, 3.0, 5.0, -1.0, -2.0, -3.0, -4.0, -5.0] {
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
    for seed in 1..=SEEDS {
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
    let options = Options { iterations: 3, ..Options::default() };
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

/// Rigid motion that takes `from` to `to` best (least squares).
fn fit(from: &[Vec2], to: &[Vec2]) -> (Vec2, f64) {
    let centre = |v: &[Vec2]| v.iter().sum::<Vec2>() / v.len() as f64;
    let (a, b) = (centre(from), centre(to));
    let (mut dot, mut cross) = (0.0, 0.0);
    for (p, q) in from.iter().zip(to) {
        dot += (p - a).dot(&(q - b));
        cross += (p - a).perp(&(q - b));
    }
    (b - a, cross.atan2(dot))
}

fn alignment(text: &mut String) {
    let Some(folder) = Some(Path::new("../shared/data/amrl_maps")).filter(|p| p.exists()) else {
        text.push_str("\nAlignment and many walkers: skipped: ../shared is absent.\n");
        return;
    };
    text.push_str("\n## Unknown start frames\n\nFour walkers for 10 minutes in real floor plans, the last one where nobody else goes; 4,000 particles, then 3 joint iterations. Off: the rigid misfit of a walker's path against the truth, less that of the first walker's (position of the path's middle, and turn).\n\n| building | seed | walkers placed | off, m / ° | stranger |\n|---|---|---|---|---|\n");
    let (mut good, mut placed, mut all, mut strangers) = (0, 0, 0, 0);
    for building in ["GHC7", "NSH3", "AHG2", "NYU19"] {
        let walls = io::walls::read(&folder.join(format!("{building}.vectormap.txt"))).expect("walls").value;
        for seed in 1..=3 {
            let settings = Settings { seed, walkers: 4, minutes: 10.0, strangers: 1, ..Settings::default() };
            let simulation = Scenario::Building.run(&settings, &walls).expect("a building");
            let options = Options { particles: 4_000, iterations: 3, seed, ..Options::default() };
            let start = Start { pose: simulation.starts[0], ..Start::default() };
            let Ok(outcome) =
                successive::run(&simulation.walks, start, true, &Mode::FeetSlam, &options, &mut |_| ())
            else {
                continue;
            };
            let misfit = |j: usize| {
                let walk = &simulation.walks[j];
                let own: Vec<_> = simulation.truth.iter().filter(|t| t.walker == walk.name).collect();
                let truth: Vec<Vec2> = own.iter().map(|t| t.position).collect();
                let path: Vec<Vec2> = own
                    .iter()
                    .filter_map(|t| walk.position_at(&outcome.estimates[j].best, t.stamp_s))
                    .collect();
                fit(&path, &truth)
            };
            let first = misfit(0);
            let mut cells = Vec::new();
            for j in 1..3 {
                all += 1;
                if outcome.takes_part[j] {
                    let (shift, turn) = misfit(j);
                    let (off, deg) = ((shift - first.0).norm(), (turn - first.1).to_degrees().abs());
                    placed += 1;
                    good += usize::from(off <= 0.5 && deg <= 2.0);
                    cells.push(format!("{off:.2} / {deg:.1}"));
                } else {
                    cells.push("left out".into());
                }
            }
            strangers += usize::from(outcome.takes_part[3]);
            let out = if outcome.takes_part[3] { "forced in" } else { "left out" };
            let _ = writeln!(
                text,
                "| {building} | {seed} | {} of 2 | {} | {out} |",
                outcome.takes_part[1..3].iter().filter(|t| **t).count(),
                cells.join(", ")
            );
            eprintln!("{building} {seed}: {} {out}", cells.join(", "));
        }
    }
    let _ = writeln!(
        text,
        "\nWithin 0.5 m and 2°: {good} of {all} walkers with shared ways ({placed} placed); strangers forced in: {strangers} of 12."
    );
    let _ = align::ln_gamma(1.0);
    many(text, folder);
}

fn many(text: &mut String, folder: &Path) {
    text.push_str("\n## Many walkers (NYU19, 10 minutes each, known start, 1 iteration, 1,000 particles, two threads)\n\n| walkers | particle-steps | wall, s | ns per particle-step | peak RSS, MB |\n|---|---|---|---|---|\n");
    let walls = io::walls::read(&folder.join("NYU19.vectormap.txt")).expect("walls").value;
    for walkers in [15, 30, 60] {
        let simulation =
            Scenario::Building.run(&Settings { walkers, ..Settings::default() }, &walls).expect("a building");
        let options = Options { particles: 1_000, iterations: 1, ..Options::default() };
        let started = Instant::now();
        let outcome = run(&simulation, &Mode::FeetSlam, &options);
        let seconds = started.elapsed().as_secs_f64();
        let ns = seconds * 1e9 / outcome.particle_steps as f64;
        let _ = writeln!(
            text,
            "| {walkers} | {:.0} M | {seconds:.1} | {ns:.0} | {:.0} |",
            outcome.particle_steps as f64 / 1e6,
            peak_mb()
        );
        eprintln!("{walkers} walkers: {seconds:.1} s");
    }
}

fn main() {
    let started = Instant::now();
    let mut text = String::from(
        "# Results: pedestrians\n\nWritten by `cargo bench --bench pedestrian_results`; every number is from simulated walks (`hitl feetslam simulate`), seeds 1–10, 10,000 particles unless a line says otherwise. Read docs/MATH-pedestrian.md, \"What the aligned grid is\", before quoting any of the small numbers: they come from a straight-corridor prior and not from the map.\n",
    );
    speed(&mut text);
    experiments(&mut text);
    controls(&mut text);
    laps(&mut text);
    alignment(&mut text);
    figures();
    let _ = writeln!(
        text,
        "\n![rounds](img/pedestrian-rounds.png)\n![iterations](img/pedestrian-iterations.png)\n![before](img/pedestrian-before.png)\n![after](img/pedestrian-after.png)\n![laps, before](img/pedestrian-laps-before.png)\n![laps, after](img/pedestrian-laps-after.png)\n\nThe whole page took {:.0} s.",
        started.elapsed().as_secs_f64()
    );
    io::atomic::write(Path::new("docs/RESULTS-pedestrian.md"), |out| out.write_all(text.as_bytes()))
        .expect("docs can be written");
}
