// From the bridge's plain structs to what Ceres takes: blocks of doubles and a cost function with a
// loss for every term.
#ifndef HITL_CPP_TERMS_H_
#define HITL_CPP_TERMS_H_

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>

#include <memory>
#include <vector>

#include "hitl-slam/src/joint/ceres/bridge.rs.h"

namespace hitl::ceres_backend {

// A private copy of the unknowns: Ceres works on it, the caller's stay as they are.
struct Blocks {
  explicit Blocks(const Problem& problem);

  double* Pose(std::size_t k) { return &poses[3 * k]; }
  double* Segment(std::size_t k) { return &segments[3 * k]; }
  // which: 0 start, 1 end.
  double* End(std::size_t segment, std::size_t which) { return &ends[4 * segment + 2 * which]; }

  std::vector<double> poses;
  std::vector<double> segments;
  std::vector<double> ends;
};

// A term of the objective: ½ρ(‖r‖²) of some blocks, all different.
struct Term {
  std::unique_ptr<ceres::CostFunction> cost;
  std::unique_ptr<ceres::LossFunction> loss;  // Null: none.
  std::vector<double*> blocks;
};

// Every term, in the order of TermKind in src/joint/problem.rs. They refer to `problem` and to
// `blocks`.
std::vector<Term> MakeTerms(const Problem& problem, Blocks& blocks);

}  // namespace hitl::ceres_backend

#endif  // HITL_CPP_TERMS_H_
