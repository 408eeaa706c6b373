//! Where our solver's time goes, and what this machine would allow.

use std::hint::black_box;

use hitl_slam::io;
use hitl_slam::joint::{self, Options};
use hitl_slam::solver::kernel_gflops;

use crate::cpu;
use crate::graphs::path;
use crate::page::{Result, Section};

const ROUNDS: usize = 12;

/// GB/s of copying so many bytes, read and written, once they are where they fit.
fn copy_gb_per_s(bytes: usize) -> f64 {
    let from = vec![1u8; bytes];
    let mut to = vec![0u8; bytes];
    let mut best = f64::INFINITY;
    for _ in 0..20 {
        best = best.min(cpu::timed(|| black_box(&mut to).copy_from_slice(black_box(&from))).1);
    }
    2.0 * bytes as f64 / best * 1e-6
}

/// µs to touch a fresh page for the first time.
fn page_fault_us() -> f64 {
    const PAGES: usize = 16_384;
    let mut best = f64::INFINITY;
    for _ in 0..5 {
        let (_, ms) = cpu::timed(|| black_box(vec![1u8; 4096 * PAGES]));
        best = best.min(ms);
    }
    best * 1e3 / PAGES as f64
}

pub fn section() -> Result<Section> {
    let mut section =
        Section { title: "Where the solver's time goes", name: "profile", ..Section::default() };
    if !path("M3500").exists() {
        section.body = "skipped: the public graphs are absent\n".into();
        return Ok(section);
    }
    let (gflops, fault_us) = (kernel_gflops(), page_fault_us());
    section.body = format!(
        "`joint::profile_graph`: `hitl optimize` with our solver, stage by stage, wall clock, ms: the fastest of {ROUNDS} rounds, every round in fresh memory. Below the line: one pass of \
         each kind at the minimum, in warm memory, the fastest of {}. Floor of the factorisation: its multiplications and additions at the speed of the update kernel alone in the first cache \
         ({gflops:.1} GFlop/s on this machine, AVX2, without fused operations: docs/DECISIONS.md). Floor of the solve: the factor read twice at the speed of a copy of its size. A fresh page costs {fault_us:.2} µs here, \
         which the first pass over every array pays. Last row: all, had every factorisation and every solve with a kept factor taken no more than its floor, everything else as \
         measured. The aims that are missed ask for the times of the peers in Solvers side by side divided by 11 and 34 (M3500), 18 and 25 (city10000): where that is less than the last \
         row, no better kernel reaches it; the ordering, the linearisations and the fresh pages would have to shrink as well.\n\n",
        10 * ROUNDS
    );
    let mut columns = Vec::new();
    for name in ["INTEL", "M3500", "city10000"] {
        let map = io::g2o::read(&path(name))?.value;
        let p = joint::profile_graph(&map, &Options::default(), ROUNDS)?;
        let s = p.step;
        let bytes = 8 * s.factor_numbers;
        let speed = copy_gb_per_s(bytes);
        let floor_factor = s.factor_flops / gflops * 1e-6;
        let floor_solve = 2.0 * bytes as f64 / speed * 1e-6;
        let total = p.build_ms + p.order_ms + p.start_ms + p.iterate_ms;
        let (factorisations, solves) = p.passes;
        let above_floor =
            factorisations as f64 * (s.factor_ms - floor_factor) + solves as f64 * (s.solve_ms - floor_solve);
        let ms = |v: f64| format!("{v:.2}");
        let gain = format!("{:.1} GFlop/s", s.factor_flops / s.factor_ms * 1e-6);
        columns.push((
            name,
            vec![
                ms(p.build_ms),
                ms(p.order_ms),
                ms(p.start_ms),
                format!("{:.2} ({} + {} steps)", p.iterate_ms, p.steps.0, p.steps.1),
                ms(total),
                ms(s.linearise_ms),
                ms(s.gradient_ms),
                format!("{:.2} ({gain})", s.factor_ms),
                ms(s.solve_ms),
                format!("{:.2e}, {:.1} MB", s.factor_flops, bytes as f64 / 1e6),
                ms(floor_factor),
                format!("{floor_solve:.2} (at {speed:.0} GB/s)"),
                format!("{:.2} ({factorisations} and {solves} passes)", total - above_floor),
            ],
        ));
    }
    const ROWS: [&str; 13] = [
        "problem built and checked",
        "ordering, symbolic analysis",
        "linear start: two factorisations, two solves",
        "Gauss–Newton, last digits",
        "**all**",
        "one linearisation, H and g",
        "one gradient",
        "one factorisation, forward solve within",
        "one solve with a kept factor",
        "multiplications and additions, memory of a factor",
        "floor of the factorisation",
        "floor of the solve",
        "**all**, with these passes at their floors",
    ];
    let heads: String = columns.iter().map(|c| format!(" {} |", c.0)).collect();
    section.body += &format!("| stage |{heads}\n|---|{}\n", "---|".repeat(columns.len()));
    for (k, row) in ROWS.iter().enumerate() {
        let cells: String = columns.iter().map(|c| format!(" {} |", c.1[k])).collect();
        section.body += &format!("| {row} |{cells}\n");
    }
    Ok(section)
}
