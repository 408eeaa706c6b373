//! Time and memory; every line is measured in a process of its own.

use std::process::Command;

use hitl_slam::pedestrian::feetslam::Group;

use super::*;

/// What a child process measured.
struct Measured {
    particle_steps: f64,
    wall_s: f64,
    cpu_s: f64,
    peak_mb: f64,
}

impl Measured {
    fn ns(&self) -> f64 {
        self.cpu_s * 1e9 / self.particle_steps
    }
}

pub fn speed(text: &mut String) -> Vec<Claim> {
    text.push_str("\n## Speed and memory\n\nExperiment 2, 10 iterations, 10,000 particles, six walkers; the best of three runs by CPU time.\n\n| threads | particle-steps | wall, s | CPU, s | CPU ns per particle-step | peak RSS, MB |\n|---|---|---|---|---|---|\n");
    let mut claims = Vec::new();
    for threads in [2, 1] {
        let best = (0..3)
            .map(|_| measure(&["speed", &threads.to_string()]))
            .min_by(|a, b| a.cpu_s.total_cmp(&b.cpu_s));
        let Some(m) = best else { continue };
        let _ = writeln!(
            text,
            "| {threads} | {:.1} M | {:.2} | {:.2} | {:.1} | {:.0} |",
            m.particle_steps / 1e6,
            m.wall_s,
            m.cpu_s,
            m.ns(),
            m.peak_mb
        );
        if threads == 2 {
            claims.push(claim(
                "Experiment 2 with 10 iterations on two cores",
                m.wall_s,
                5.0,
                "s",
                "five seconds",
            ));
            claims.push(claim("Experiment 2 with 10 iterations: peak RSS", m.peak_mb, 50.0, "MB", "50 MB"));
        } else {
            claims.push(claim(
                "CPU time of a particle-step on one core",
                m.ns(),
                60.0,
                "ns",
                "60 ns (naive: 640)",
            ));
        }
    }
    claims
}

pub fn many(text: &mut String) -> Vec<Claim> {
    if !plan().exists() {
        text.push_str("\nMany walkers: skipped: ../shared is absent.\n");
        return Vec::new();
    }
    text.push_str("\n## Many walkers\n\nNYU19, 10 minutes each, known starts, FeetSLAM with 1 iteration, 1,000 particles, two threads.\n\n| walkers | particle-steps | wall, s | CPU, s | CPU ns per particle-step | peak RSS, MB |\n|---|---|---|---|---|---|\n");
    let all: Vec<(usize, Measured)> =
        [15, 30, 60].into_iter().map(|n| (n, measure(&["many", &n.to_string()]))).collect();
    for (walkers, m) in &all {
        let _ = writeln!(
            text,
            "| {walkers} | {:.0} M | {:.1} | {:.1} | {:.0} | {:.0} |",
            m.particle_steps / 1e6,
            m.wall_s,
            m.cpu_s,
            m.ns(),
            m.peak_mb
        );
    }
    let (few, many) = (&all[0].1, &all[2].1);
    vec![
        claim(
            "CPU time of a particle-step with 60 walkers / with 15",
            many.ns() / few.ns(),
            1.25,
            "",
            "linear with walkers",
        ),
        claim("60 walkers × 10 minutes: peak RSS", many.peak_mb, 200.0, "MB", "ours"),
    ]
}

fn plan() -> std::path::PathBuf {
    page::project("../shared/data/amrl_maps/NYU19.vectormap.txt")
}

/// Runs this program as a child and reads its one line.
fn measure(job: &[&str]) -> Measured {
    let program = std::env::current_exe().expect("this program");
    let output = Command::new(program).arg("--child").args(job).output().expect("a child");
    let line = String::from_utf8_lossy(&output.stdout).into_owned();
    let numbers: Vec<f64> = line.split_whitespace().filter_map(|f| f.parse().ok()).collect();
    let &[particle_steps, wall_s, cpu_s, peak_mb] = numbers.as_slice() else {
        panic!("{job:?}: {line}{}", String::from_utf8_lossy(&output.stderr));
    };
    eprintln!("{job:?}: {wall_s:.2} s, {:.1} CPU ns, {peak_mb:.0} MB", cpu_s * 1e9 / particle_steps);
    Measured { particle_steps, wall_s, cpu_s, peak_mb }
}

/// The child's side.
pub fn child(job: &[&str]) {
    let number = |text: &str| text.parse().expect("a number");
    let threads = |count| rayon::ThreadPoolBuilder::new().num_threads(count).build().expect("threads");
    let begun = Instant::now();
    let before_ms = cpu::milliseconds();
    let particle_steps = match *job {
        ["speed", count] => {
            let simulation = Scenario::Six.run(&Settings::default(), &[]).expect("a scenario");
            threads(number(count)).install(|| run(&simulation, &rounds(), &Options::default())).particle_steps
        }
        ["many", count] => threads(2).install(|| many_walkers(number(count))),
        _ => panic!("found the job {job:?}"),
    };
    let (wall_s, cpu_s) = (begun.elapsed().as_secs_f64(), (cpu::milliseconds() - before_ms) / 1e3);
    println!("{particle_steps} {wall_s} {cpu_s} {}", peak_mb());
}

fn many_walkers(walkers: usize) -> u64 {
    let walls = io::floor_plan::read(&plan()).expect("walls").value;
    let settings = Settings { walkers, ..Settings::default() };
    let simulation = Scenario::Building.run(&settings, &walls).expect("a building");
    let options = Options { particles: 1_000, iterations: 1, ..Options::default() };
    let mut group = Group::new(&simulation.walks, Start::default(), &options).expect("walks");
    group.move_starts(&simulation.starts);
    let steps: Vec<usize> = simulation.walks.iter().map(|w| w.steps.len()).collect();
    group.round(0, 0, &steps, &mut |_| ()).expect("a round");
    group.particle_steps
}

fn peak_mb() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let kib = status.lines().find(|l| l.starts_with("VmHWM:")).and_then(|l| l.split_whitespace().nth(1));
    kib.and_then(|k| k.parse::<f64>().ok()).unwrap_or(f64::NAN) * 1024.0 / 1e6
}
