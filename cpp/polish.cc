#include "polish.h"

#include <ceres/crs_matrix.h>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <vector>

#include "hitl-slam/src/joint/ceres/bridge.rs.h"

namespace hitl::ceres_backend {
namespace {

// The same numbers as in src/solver/polish.rs; the reasons are there.
constexpr double kLongestStep = 1e-4;
constexpr double kShrinksTo = 0.9;
constexpr std::size_t kMostSteps = 20;

using Columns = Eigen::SparseMatrix<double>;
using Rows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

// Copies of blocks' numbers, to go back to.
std::vector<double> Numbers(const ceres::Problem& problem, const std::vector<double*>& blocks) {
  std::vector<double> numbers;
  for (const double* block : blocks) {
    numbers.insert(numbers.end(), block, block + problem.ParameterBlockSize(block));
  }
  return numbers;
}

void SetNumbers(const ceres::Problem& problem, const std::vector<double*>& blocks,
                const std::vector<double>& numbers) {
  std::size_t k = 0;
  for (double* block : blocks) {
    for (int row = 0; row < problem.ParameterBlockSize(block); ++row) block[row] = numbers[k++];
  }
}

}  // namespace

Polished Polish(const Options& options, ceres::Problem& problem, double cost) {
  Polished done{cost};
  std::vector<double*> blocks;
  problem.GetParameterBlocks(&blocks);
  ceres::Problem::EvaluateOptions free;
  for (double* block : blocks) {
    if (!problem.IsParameterBlockConstant(block)) free.parameter_blocks.push_back(block);
  }
  if (free.parameter_blocks.empty()) return done;

  const double highest = cost * (1.0 + options.polish_rise);
  double longest = kLongestStep;
  Eigen::SimplicialLLT<Columns> cholesky;
  while (done.steps < kMostSteps) {
    std::vector<double> gradient;
    ceres::CRSMatrix crs;
    if (!problem.Evaluate(free, nullptr, nullptr, &gradient, &crs)) break;
    const Eigen::Map<const Rows> jacobian(
        crs.num_rows, crs.num_cols, static_cast<Eigen::Index>(crs.values.size()), crs.rows.data(),
        crs.cols.data(), crs.values.data());
    const Columns hessian = Columns(jacobian.transpose()) * Columns(jacobian);
    if (done.steps == 0) cholesky.analyzePattern(hessian);
    cholesky.factorize(hessian);
    if (cholesky.info() != Eigen::Success) break;
    const Eigen::Map<const Eigen::VectorXd> g(gradient.data(),
                                              static_cast<Eigen::Index>(gradient.size()));
    const Eigen::VectorXd delta = cholesky.solve(-g);
    const double step = delta.lpNorm<Eigen::Infinity>();
    if (!delta.allFinite() || step > longest) break;

    const std::vector<double> before = Numbers(problem, free.parameter_blocks);
    std::vector<double> after = before;
    for (std::size_t k = 0; k < after.size(); ++k) after[k] += delta[static_cast<Eigen::Index>(k)];
    SetNumbers(problem, free.parameter_blocks, after);
    double after_cost = 0.0;
    const bool fine = problem.Evaluate(free, &after_cost, nullptr, nullptr, nullptr);
    if (!fine || !(after_cost <= highest)) {
      SetNumbers(problem, free.parameter_blocks, before);
      break;
    }
    done.cost = after_cost;
    ++done.steps;
    done.last_step = step;
    if (step <= options.polish_step) {
      done.settled = true;
      break;
    }
    longest = kShrinksTo * step;
  }
  return done;
}

}  // namespace hitl::ceres_backend
