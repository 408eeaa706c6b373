//! What the maps are worth: entropy, walls, ways.

use super::*;

pub fn chapter(text: &mut String) -> Vec<Claim> {
    text.push_str(
        "\n## The maps\n\nMedian over seeds. Entropy of a step out of a hexagon (at most 2.58 bit); share of the crossings whose way from \
         centre to centre goes through a wall; share within 1 m of a true way (precision); share of the true ways' hexagons with at \
         least half a crossing (recall).\n\n| walks | entropy, bit | through walls | precision | recall |\n|---|---|---|---|---|\n",
    );
    let short = Options { iterations: 3, particles: particles(), ..Options::default() };
    let plain = Settings::default();
    let lapping = Settings { minutes: 10.0, ..plain };
    let mut recall = f64::NAN;
    for (name, scenario, settings, mode, options) in [
        ("six walkers, dead reckoning's map (FootSLAM alone)", Scenario::Six, plain, Mode::FootSlam, short),
        ("six walkers, Experiment 1", Scenario::Six, plain, Mode::FeetSlam, short),
        ("six walkers, Experiment 2", Scenario::Six, plain, rounds(), short),
        ("three enter a room, Experiment 2", Scenario::Rooms, plain, rounds(), short),
        ("10 minutes of laps, FootSLAM", Scenario::Loops, lapping, Mode::FootSlam, Options::default()),
    ] {
        let one = |seed: u64| {
            let simulation = scenario.run(&Settings { seed, ..settings }, &[]).expect("a scenario");
            let map = run(&simulation, &mode, &Options { seed, ..options }).total;
            let ways: Vec<Vec<Vec2>> =
                simulation.walks.iter().flat_map(|w| metrics::true_ways(w, &simulation.truth)).collect();
            let coverage = metrics::coverage(&map, &ways, metrics::NEAR_A_WAY_M, metrics::A_WAY);
            let walls = metrics::crossed_wall_ratio(&map, &simulation.walls);
            [metrics::entropy_bits(&map, options.alpha), walls, coverage.precision, coverage.recall]
        };
        let all: Vec<[f64; 4]> = (1..=SEEDS).into_par_iter().map(one).collect();
        let at = |k: usize| quantile(&all.iter().map(|m| m[k]).collect::<Vec<_>>(), 0.5);
        let percent = |k: usize| format!("{:.1} %", 100.0 * at(k));
        let _ =
            writeln!(text, "| {name} | {:.2} | {} | {} | {} |", at(0), percent(1), percent(2), percent(3));
        if mode == rounds() && scenario == Scenario::Six {
            recall = 1.0 - at(3).min(at(2));
        }
    }
    vec![claim(
        "Experiment 2: what the map lacks in precision or recall of the true ways",
        recall,
        0.1,
        "",
        "ours",
    )]
}
