//! The paper's two experiments, and what arithmetic alone gives.

use super::*;

/// End errors of all walkers and seeds.
#[derive(Default)]
pub struct Ends3 {
    pub best: Vec<f64>,
    pub mean: Vec<f64>,
    pub pdr: Vec<f64>,
    /// Mean over walkers / mean over walkers of PDR, per seed.
    pub ratio: Vec<f64>,
    fall_backs: usize,
}

pub fn ends(scenario: Scenario, settings: Settings, mode: &Mode, options: Options) -> Ends3 {
    let one = |seed: u64| {
        let simulation = scenario.run(&Settings { seed, ..settings }, &[]).expect("a scenario");
        let outcome = run(&simulation, mode, &Options { seed, ..options });
        let last = |(walk, estimate): (&Walk, &Estimate)| {
            errors(&simulation, walk, estimate, simulation.starts[0]).map(|e| e[e.len() - 1])
        };
        let lasts: Vec<[f64; 3]> = simulation.walks.iter().zip(&outcome.estimates).map(last).collect();
        (lasts, outcome.fall_back.is_some())
    };
    let mut all = Ends3::default();
    for (lasts, fell_back) in (1..=SEEDS).into_par_iter().map(one).collect::<Vec<_>>() {
        all.fall_backs += usize::from(fell_back);
        let [best, mean_, pdr] = [0, 1, 2].map(|k| lasts.iter().map(|l| l[k]).collect::<Vec<f64>>());
        all.ratio.push(mean(&mean_) / mean(&pdr));
        all.best.extend(best);
        all.mean.extend(mean_);
        all.pdr.extend(pdr);
    }
    all
}

pub fn row(text: &mut String, name: &str, e: &Ends3) {
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

pub const HEAD: &str = "| case | PDR, m | weighted mean, m | best particle, m | mean/PDR | worst seed's mean/PDR | fell back |\n|---|---|---|---|---|---|---|\n";

pub fn chapter(text: &mut String) -> Vec<Claim> {
    let options = Options { iterations: 3, particles: particles(), ..Options::default() };
    text.push_str("\n## Experiment 2: successive, ends at 14, 24, 34 m and the end; error at the end (GTP3)\n\n3 iterations a round; median [quartiles] over 6 walkers × 10 seeds. The last columns: mean over walkers against PDR.\n\n");
    text.push_str(HEAD);
    let (mut worst_mean, mut worst_best) = (0.0_f64, 0.0_f64);
    for turn_deg in [-30.0, -15.0, -7.0, -4.0, 0.0, 7.0, 15.0, 30.0] {
        let e = ends(Scenario::Six, Settings { turn_deg, ..Settings::default() }, &rounds(), options);
        row(text, &format!("aligned, world turned by {turn_deg}°"), &e);
        worst_mean = worst_mean.max(quantile(&e.mean, 0.5));
        worst_best = worst_best.max(quantile(&e.best, 0.5));
    }
    let regrid = Options { grid: GridChoice::Regrid, ..options };
    row(text, "regrid (isotropic)", &ends(Scenario::Six, Settings::default(), &rounds(), regrid));
    for deg in [-30.0, -15.0, -7.0, -4.0, 0.0, 7.0, 15.0, 30.0_f64] {
        let fixed = Options { grid: GridChoice::Fixed(deg.to_radians()), ..options };
        row(text, &format!("fixed at {deg}°"), &ends(Scenario::Six, Settings::default(), &rounds(), fixed));
    }
    oracles(text);
    text.push_str("\n## Experiment 1: FeetSLAM once on the whole walks\n\nMedian error of the weighted mean over walkers and seeds at the marked points, m.\n\n| grid | x = 10 m | 20 m | 30 m | end | PDR at the end |\n|---|---|---|---|---|---|\n");
    let mut growth = f64::NAN;
    for (name, grid) in [
        ("regrid", GridChoice::Regrid),
        ("fixed at 15°", GridChoice::Fixed(15f64.to_radians())),
        ("aligned", GridChoice::Aligned),
    ] {
        let one = |seed: u64| {
            let simulation =
                Scenario::Six.run(&Settings { seed, ..Settings::default() }, &[]).expect("a scenario");
            let outcome = run(&simulation, &Mode::FeetSlam, &Options { seed, grid, ..options });
            let at = |(walk, estimate): (&Walk, &Estimate)| {
                let [_, mean, pdr] = errors(&simulation, walk, estimate, simulation.starts[0]);
                [mean[2], mean[3], mean[4], mean[5], pdr[5]]
            };
            simulation.walks.iter().zip(&outcome.estimates).map(at).collect::<Vec<_>>()
        };
        let all: Vec<[f64; 5]> = (1..=SEEDS).into_par_iter().map(one).collect::<Vec<_>>().concat();
        let at = |k: usize| all.iter().map(|e| e[k]).collect::<Vec<f64>>();
        if grid == GridChoice::Regrid {
            growth = quantile(&at(0), 0.5) / quantile(&at(3), 0.5);
        }
        let cells: Vec<String> = (0..5).map(|k| median(&at(k))).collect();
        let _ = writeln!(text, "| {name} | {} |", cells.join(" | "));
        eprintln!("experiment 1 {name}: {}", cells.join(" | "));
    }
    let paper = "the paper: about 0.5 m";
    vec![
        claim(
            "Experiment 2, aligned: weighted mean's error at the end, median, at the worst of 8 angles",
            worst_mean,
            0.5,
            "m",
            paper,
        ),
        claim(
            "Experiment 2, aligned: best particle's error at the end, median, at the worst of 8 angles",
            worst_best,
            0.5,
            "m",
            paper,
        ),
        claim(
            "Experiment 1, isotropic: median error after 10 m as a share of that at the end",
            growth,
            0.5,
            "",
            "it grows along the corridor",
        ),
    ]
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
