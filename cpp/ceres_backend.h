// The two functions behind the bridge of src/joint/ceres/bridge.rs. See README.md for the contract.
#ifndef HITL_CPP_CERES_BACKEND_H_
#define HITL_CPP_CERES_BACKEND_H_

#include <exception>

#include "rust/cxx.h"

namespace hitl::ceres_backend {

struct Problem;
struct Options;
struct Evaluation;
struct Solution;

// Residuals, Jacobians and losses of every term where it stands.
Evaluation evaluate(const Problem& problem);

// Minimises a copy of the problem. Throws std::invalid_argument for options that Ceres refuses.
Solution solve(const Problem& problem, const Options& options);

}  // namespace hitl::ceres_backend

namespace rust::behavior {

// Every exception becomes a Rust error; cxx's own version lets those that are not std::exception
// end the process.
template <typename Try, typename Fail>
static void trycatch(Try&& func, Fail&& fail) noexcept try {
  func();
} catch (const std::exception& e) {
  fail(e.what());
} catch (...) {
  fail("unknown C++ exception");
}

}  // namespace rust::behavior

#endif  // HITL_CPP_CERES_BACKEND_H_
