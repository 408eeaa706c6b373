//! `cargo bench --bench timing` (= `make bench`): time of every stage on simulated maps, with criterion's statistics.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use hitl_slam::geometry::Pose2;
use hitl_slam::map::SlamMap;
use hitl_slam::pipeline::{Corrector, Options};
use hitl_slam::simulate::{self, Scenario, Settings, Simulation};
use hitl_slam::{copslam, interpret, io, joint};

/// Seed 1 of either scenario and its number of poses.
fn simulations() -> [(usize, Simulation); 2] {
    [Scenario::Loop, Scenario::Campus].map(|scenario| {
        let simulation = simulate::run(scenario, &Settings::default()).expect("the scenario runs");
        (simulation.map.poses.len(), simulation)
    })
}

fn corrector(map: &SlamMap) -> Corrector {
    Corrector::new(map.clone(), Options::default()).expect("a map that can be corrected")
}

fn stages(c: &mut Criterion) {
    let [(_, small), (poses, large)] = simulations();

    let map = &large.map;
    let reach = interpret::Reach::new(&map.observations);
    let stroke = interpret::in_world(map, &map.poses, &large.corrections[0].a).expect("a stroke on the map");
    let options = interpret::Options::default();
    c.bench_function(&format!("interpret one stroke/{poses}"), |b| {
        b.iter(|| interpret::catch(&map.observations, &map.poses, &reach, black_box(stroke), &options));
    });

    let variances = &copslam::chain_variances(map)[..2999];
    let chain = &map.poses[..3000];
    let target = chain[2999].compose(Pose2::new(1.0, -0.5, 0.1));
    c.bench_function("copslam/3000", |b| {
        let distribute = |mut poses: Vec<Pose2>| {
            copslam::distribute(&mut poses, variances, black_box(target));
            poses
        };
        b.iter_batched(|| chain.to_vec(), distribute, BatchSize::SmallInput);
    });

    for s in [&small, &large] {
        let poses = s.map.poses.len();
        // All corrections' factors at once, from the poses that the odometry gave.
        let mut done = corrector(&s.map);
        for correction in &s.corrections {
            done.apply(correction).expect("strokes on the map");
        }
        let factors = done.into_map().human_factors;
        c.bench_function(&format!("joint optimize, all corrections/{poses}"), |b| {
            let start = || (s.map.poses.clone(), factors.clone());
            let optimize = |(mut poses, mut factors): (Vec<Pose2>, Vec<_>)| {
                joint::optimize(&s.map, &mut poses, &mut factors, &joint::Options::default())
            };
            b.iter_batched(start, optimize, BatchSize::LargeInput);
        });
        c.bench_function(&format!("whole correction/{poses}"), |b| {
            let apply = |mut corrector: Corrector| corrector.apply(&s.corrections[0]).map(|_| corrector);
            b.iter_batched(|| corrector(&s.map), apply, BatchSize::LargeInput);
        });
    }
}

fn files(c: &mut Criterion) {
    let [_, (poses, large)] = simulations();
    let folder = std::env::temp_dir().join(format!("hitl-slam-timing-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a scratch folder");
    let text = folder.join("map.stfs.covars");
    let native = folder.join("map.npz");
    let graph = folder.join("map.g2o");
    for path in [&text, &native, &graph] {
        io::write_map(path, &large.map).expect("the map can be written");
    }
    c.bench_function(&format!("load stfs.covars/{poses}"), |b| b.iter(|| io::stfs::read(black_box(&text))));
    c.bench_function(&format!("load g2o/{poses}"), |b| b.iter(|| io::g2o::read(black_box(&graph))));
    c.bench_function(&format!("load npz/{poses}"), |b| b.iter(|| io::native::read(black_box(&native))));
    let _ = std::fs::remove_dir_all(&folder);
}

/// The whole suite takes about a minute.
fn quick() -> Criterion {
    let times = Criterion::default().sample_size(20).warm_up_time(Duration::from_millis(500));
    times.measurement_time(Duration::from_secs(3)).without_plots()
}

criterion_group! { name = all; config = quick(); targets = stages, files }
criterion_main!(all);
