// The last digits, where the cost cannot show progress any more: twin of src/solver/polish.rs.
#ifndef HITL_CPP_POLISH_H_
#define HITL_CPP_POLISH_H_

#include <ceres/problem.h>

#include <cstddef>

namespace hitl::ceres_backend {

struct Options;

// What the steps did.
struct Polished {
  double cost;             // At the end.
  std::size_t steps = 0;   // Taken.
  double last_step = 0.0;  // Its largest entry.
  bool settled = false;    // True if that was within the tolerance.
};

// Undamped Gauss-Newton steps on Ceres' own residuals and Jacobians, while they are small, shrink,
// and leave the cost the same up to rounding.
Polished Polish(const Options& options, ceres::Problem& problem, double cost);

}  // namespace hitl::ceres_backend

#endif  // HITL_CPP_POLISH_H_
