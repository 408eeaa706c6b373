//! The only door to C++: plain structs and two functions. Nothing here is public, no Rust code runs behind it.
//!
//! The structs mirror [`crate::joint::problem`]; cxx generates their C++ twins. Enums travel as numbers, see
//! `convert.rs` and `cpp/terms.cc`.

// SAFETY: cxx checks both sides of the bridge against each other when they are compiled; the functions take and return
// only owned data and shared references, which C++ does not keep.
#[allow(unsafe_code)]
#[cxx::bridge(namespace = "hitl::ceres_backend")]
pub(super) mod ffi {
    /// 0 none, 1 Huber, 2 Cauchy, 3 Geman–McClure.
    struct Loss {
        kind: u8,
        scale: f64,
    }

    struct Relative {
        i: usize,
        j: usize,
        measured: [f64; 3],
        sqrt_information: [f64; 9],
        loss: Loss,
    }

    struct Sighting {
        pose: usize,
        segment: usize,
        mean: [f64; 2],
        scatter_root: [f64; 3],
        count: f64,
        scale: f64,
    }

    struct Point {
        pose: usize,
        segment: usize,
        point: [f64; 2],
        scale: f64,
    }

    struct Tie {
        pose: usize,
        segment: usize,
        mean: [f64; 2],
        along: f64,
        scale: f64,
    }

    /// Modes 0 colocation, 1 collinear, 2 perpendicular, 3 parallel.
    struct Relation {
        mode: u8,
        a: usize,
        b: usize,
        offset_scale: f64,
        angle_scale: f64,
        loss: Loss,
    }

    /// Its sightings are `fit_sightings[first..first + count]`.
    struct Fit {
        segment: usize,
        first: usize,
        count: usize,
        scale: f64,
    }

    /// Its points are (x, y) number `first..first + count` of `fit_points`.
    struct FitSighting {
        pose: usize,
        first: usize,
        count: usize,
    }

    /// A joint problem. Poses and segments are three numbers each, ends two, points two.
    struct Problem {
        poses: Vec<f64>,
        segments: Vec<f64>,
        ends: Vec<f64>,
        held: Vec<usize>,
        relatives: Vec<Relative>,
        sightings: Vec<Sighting>,
        points: Vec<Point>,
        ties: Vec<Tie>,
        relations: Vec<Relation>,
        fits: Vec<Fit>,
        fit_sightings: Vec<FitSighting>,
        fit_points: Vec<f64>,
        paper_relations: Vec<Relation>,
        epsilon_m: f64,
    }

    struct Evaluation {
        residuals: Vec<f64>,
        jacobians: Vec<f64>,
        losses: Vec<f64>,
        cost: f64,
    }

    /// trust_region: 0 Levenberg–Marquardt, 1 dogleg, 2 subspace dogleg. linear_solver: 0 sparse normal Cholesky by
    /// SuiteSparse, 1 by Eigen, 2 dense normal Cholesky, 3 dense QR. `polish_step`: where the steps after Ceres' own
    /// end; `polish_rise`: how much they may change the cost, a share of it.
    struct Options {
        trust_region: u8,
        linear_solver: u8,
        max_accepted_steps: usize,
        function_tolerance: f64,
        gradient_tolerance: f64,
        parameter_tolerance: f64,
        initial_radius: f64,
        polish_step: f64,
        polish_rise: f64,
    }

    struct Iteration {
        cost: f64,
        gradient_max: f64,
        step_norm: f64,
        radius: f64,
        successful: bool,
    }

    /// termination: Ceres' own number; `usable` false: the blocks are empty.
    struct Solution {
        usable: bool,
        termination: u8,
        message: String,
        poses: Vec<f64>,
        segments: Vec<f64>,
        ends: Vec<f64>,
        initial_cost: f64,
        final_cost: f64,
        iterations: Vec<Iteration>,
        polish_steps: usize,
        polish_last_step: f64,
        polish_settled: bool,
        preprocess_ms: f64,
        minimize_ms: f64,
        total_ms: f64,
        log: Vec<String>,
    }

    unsafe extern "C++" {
        include!("hitl-slam/cpp/ceres_backend.h");

        fn evaluate(problem: &Problem) -> Result<Evaluation>;
        fn solve(problem: &Problem, options: &Options) -> Result<Solution>;
    }
}
