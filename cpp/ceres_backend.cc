#include "ceres_backend.h"

#include <ceres/ceres.h>

#include <array>
#include <chrono>
#include <stdexcept>

#include "log_capture.h"
#include "polish.h"
#include "terms.h"

#if CERES_VERSION_MAJOR < 2 || (CERES_VERSION_MAJOR == 2 && CERES_VERSION_MINOR < 1)
#error "Ceres 2.1 or newer is needed"
#endif

namespace hitl::ceres_backend {
namespace {

// The numbers that src/joint/ceres/linked.rs knows.
static_assert(ceres::CONVERGENCE == 0 && ceres::FAILURE == 2);

constexpr double kMilliseconds = 1e3;

// Rows and columns of the bridge's padded residuals and Jacobians.
constexpr int kPadded = 3;

void AddTerm(Term term, ceres::Problem& to) {
  to.AddResidualBlock(term.cost.release(), term.loss.release(), term.blocks);
}

// Ceres' view of the terms: blocks that no term touches do not appear in it.
void Fill(const Problem& problem, Blocks& blocks, std::vector<Term> terms, ceres::Problem& to) {
  for (Term& term : terms) AddTerm(std::move(term), to);
  for (const std::size_t held : problem.held) {
    double* pose = blocks.Pose(held);
    if (to.HasParameterBlock(pose)) to.SetParameterBlockConstant(pose);
  }
}

void AppendTerm(const Term& term, Evaluation& to) {
  const std::vector<int>& sizes = term.cost->parameter_block_sizes();
  const int rows = term.cost->num_residuals();
  std::array<double, kPadded> r{};
  std::vector<std::array<double, kPadded * kPadded>> jacobians(sizes.size());
  std::vector<double*> pointers;
  for (auto& jacobian : jacobians) pointers.push_back(jacobian.data());
  if (!term.cost->Evaluate(term.blocks.data(), r.data(), pointers.data())) {
    throw std::runtime_error("a term cannot be evaluated");
  }
  double squared = 0.0;
  for (const double row : r) {
    to.residuals.push_back(row);
    squared += row * row;
  }
  for (std::size_t k = 0; k < jacobians.size(); ++k) {
    for (int row = 0; row < kPadded; ++row) {
      for (int column = 0; column < kPadded; ++column) {
        const bool there = row < rows && column < sizes[k];
        to.jacobians.push_back(
            there ? jacobians[k][static_cast<std::size_t>(row * sizes[k] + column)] : 0.0);
      }
    }
  }
  double rho[3] = {squared, 1.0, 0.0};
  if (term.loss != nullptr) term.loss->Evaluate(squared, rho);
  to.losses.push_back(rho[0]);
  to.losses.push_back(rho[1]);
}

ceres::TrustRegionStrategyType Strategy(std::uint8_t trust_region) {
  return trust_region == 0 ? ceres::LEVENBERG_MARQUARDT : ceres::DOGLEG;
}

void SetLinearSolver(std::uint8_t linear_solver, ceres::Solver::Options& to) {
  switch (linear_solver) {
    case 0:
      to.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
      to.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
      return;
    case 1:
      to.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
      to.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
      return;
    case 2:
      to.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
      return;
    case 3:
      to.linear_solver_type = ceres::DENSE_QR;
      return;
    default:
      throw std::invalid_argument("unknown linear solver");
  }
}

// Counts accepted steps, as our own solver's limit does; Ceres' own counts refused ones too.
class StopAfter final : public ceres::IterationCallback {
 public:
  explicit StopAfter(std::size_t most) : most_(most) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& row) override {
    if (row.iteration > 0 && row.step_is_successful) ++accepted_;
    return accepted_ >= most_ ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

 private:
  std::size_t most_;
  std::size_t accepted_ = 0;
};

ceres::Solver::Options SolverOptions(const Options& options) {
  constexpr int kManySteps = 1000;
  ceres::Solver::Options o;
  o.trust_region_strategy_type = Strategy(options.trust_region);
  o.dogleg_type = options.trust_region == 2 ? ceres::SUBSPACE_DOGLEG : ceres::TRADITIONAL_DOGLEG;
  SetLinearSolver(options.linear_solver, o);
  o.max_num_iterations = kManySteps;
  o.max_num_consecutive_invalid_steps = 20;
  o.function_tolerance = options.function_tolerance;
  o.gradient_tolerance = options.gradient_tolerance;
  o.parameter_tolerance = options.parameter_tolerance;
  o.initial_trust_region_radius = options.initial_radius;
  o.logging_type = ceres::SILENT;
  o.minimizer_progress_to_stdout = false;
  o.num_threads = 1;  // LogCapture and results that do not depend on the machine rely on it.
  return o;
}

void CopyTo(const std::vector<double>& from, rust::Vec<double>& to) {
  to.reserve(from.size());
  for (const double v : from) to.push_back(v);
}

}  // namespace

Evaluation evaluate(const Problem& problem) {
  const LogCapture log;
  Blocks blocks(problem);
  std::vector<Term> terms = MakeTerms(problem, blocks);
  Evaluation evaluation{};
  for (const Term& term : terms) AppendTerm(term, evaluation);
  ceres::Problem whole;
  Fill(problem, blocks, std::move(terms), whole);
  if (!whole.Evaluate(ceres::Problem::EvaluateOptions(), &evaluation.cost, nullptr, nullptr,
                      nullptr)) {
    throw std::runtime_error("the problem cannot be evaluated");
  }
  return evaluation;
}

Solution solve(const Problem& problem, const Options& options) {
  const LogCapture log;
  ceres::Solver::Options solver_options = SolverOptions(options);
  std::string refusal;
  if (!solver_options.IsValid(&refusal)) throw std::invalid_argument(refusal);
  StopAfter stop_after(options.max_accepted_steps);
  solver_options.callbacks.push_back(&stop_after);

  Blocks blocks(problem);
  ceres::Problem whole;
  Fill(problem, blocks, MakeTerms(problem, blocks), whole);
  ceres::Solver::Summary summary;
  ceres::Solve(solver_options, &whole, &summary);

  Solution solution{};
  double polish_ms = 0.0;
  // Not where a limit or a failure stopped it.
  if (summary.termination_type == ceres::CONVERGENCE) {
    const auto start = std::chrono::steady_clock::now();
    const Polished polished = Polish(options, whole, summary.final_cost);
    solution.polish_steps = polished.steps;
    solution.polish_last_step = polished.last_step;
    solution.polish_settled = polished.settled;
    summary.final_cost = polished.cost;
    const std::chrono::duration<double, std::milli> taken =
        std::chrono::steady_clock::now() - start;
    polish_ms = taken.count();
  }
  solution.usable = summary.IsSolutionUsable();
  solution.termination = static_cast<std::uint8_t>(summary.termination_type);
  solution.message = summary.message;
  if (solution.usable) {
    CopyTo(blocks.poses, solution.poses);
    CopyTo(blocks.segments, solution.segments);
    CopyTo(blocks.ends, solution.ends);
  }
  solution.initial_cost = summary.initial_cost;
  solution.final_cost = summary.final_cost;
  for (const ceres::IterationSummary& row : summary.iterations) {
    solution.iterations.push_back({row.cost, row.gradient_max_norm, row.step_norm,
                                   row.trust_region_radius, row.step_is_successful});
  }
  solution.preprocess_ms = summary.preprocessor_time_in_seconds * kMilliseconds;
  solution.minimize_ms = summary.minimizer_time_in_seconds * kMilliseconds + polish_ms;
  solution.total_ms = summary.total_time_in_seconds * kMilliseconds + polish_ms;
  for (const std::string& line : log.Lines()) solution.log.push_back(line);
  return solution;
}

}  // namespace hitl::ceres_backend
