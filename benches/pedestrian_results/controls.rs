//! Where a straight-corridor prior could do harm.

use super::experiments::{HEAD, ends, row};
use super::*;

pub fn chapter(text: &mut String) -> Vec<Claim> {
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
    for bend in [1.0, 2.0, 3.0, 4.0, 5.0, -1.0, -2.0, -3.0, -4.0, -5.0] {
        cases.push((format!("long leg off by {bend}°"), Scenario::Corner, corner(bend, 10.0)));
    }
    for bend in [-7.0, 7.0, 20.0, 45.0, 90.0] {
        cases.push((format!("corner of {bend}° at 20 m"), Scenario::Corner, corner(bend, 20.0)));
    }
    for radius in [100.0, 200.0, -100.0, -150.0, -200.0, -300.0, -400.0] {
        cases.push((format!("curve of {radius} m"), Scenario::Curve, curve(radius)));
    }
    let mut worst = (0.0, String::new());
    for (name, scenario, settings) in cases {
        let e = ends(scenario, settings, &rounds(), options);
        row(text, &name, &e);
        let ratio = quantile(&e.ratio, 1.0);
        if ratio > worst.0 {
            worst = (ratio, name);
        }
    }
    let what = format!("Worst seed of the worst control ({}): mean error / that of PDR", worst.1);
    vec![claim(what, worst.0, 1.1, "", "never worse than PDR by more than 10 %")]
}
