#include "terms.h"

#include <ceres/autodiff_cost_function.h>
#include <ceres/jet.h>

#include <stdexcept>
#include <utility>

#include "residuals.h"

namespace hitl::ceres_backend {
namespace {

std::vector<double> Copy(const rust::Vec<double>& from) { return {from.begin(), from.end()}; }

// ρ(s) = s / (1 + s/c²), which Ceres lacks.
class GemanMcClureLoss final : public ceres::LossFunction {
 public:
  explicit GemanMcClureLoss(double scale) : squared_(scale * scale) {}

  void Evaluate(double s, double rho[3]) const override {
    const double d = 1.0 + s / squared_;
    rho[0] = s / d;
    rho[1] = 1.0 / (d * d);
    rho[2] = -2.0 / (squared_ * d * d * d);
  }

 private:
  double squared_;
};

std::unique_ptr<ceres::LossFunction> MakeLoss(const Loss& loss) {
  switch (loss.kind) {
    case 0:
      return nullptr;
    case 1:
      return std::make_unique<ceres::HuberLoss>(loss.scale);
    case 2:
      return std::make_unique<ceres::CauchyLoss>(loss.scale);
    case 3:
      return std::make_unique<GemanMcClureLoss>(loss.scale);
    default:
      throw std::invalid_argument("unknown loss");
  }
}

// R5 as a whole: r = scale·√(mean + ε²) over every pose of X and both ends. The sum over a pose's
// points is differentiated automatically; the poses are chained by hand, since a Jet over all of
// them would cost their number squared.
class FitCost final : public ceres::CostFunction {
 public:
  FitCost(const Problem& problem, const Fit& fit) : problem_(problem), fit_(fit) {
    for (std::size_t k = 0; k < fit.count; ++k) {
      mutable_parameter_block_sizes()->push_back(3);
      count_ += static_cast<double>(Sum(k).count);
    }
    mutable_parameter_block_sizes()->push_back(2);
    mutable_parameter_block_sizes()->push_back(2);
    set_num_residuals(1);
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    using Jet = ceres::Jet<double, 7>;  // Pose, start, end.
    const double* start = blocks[fit_.count];
    const double* end = blocks[fit_.count + 1];
    std::vector<Eigen::Matrix<double, 7, 1>> slopes(jacobians == nullptr ? 0 : fit_.count);
    double sum = 0.0;
    for (std::size_t k = 0; k < fit_.count; ++k) {
      const double* pose = blocks[k];
      if (jacobians == nullptr) {
        sum += Sum(k)(pose, start, end);
        continue;
      }
      const Jet pose_jet[3] = {Jet(pose[0], 0), Jet(pose[1], 1), Jet(pose[2], 2)};
      const Jet start_jet[2] = {Jet(start[0], 3), Jet(start[1], 4)};
      const Jet end_jet[2] = {Jet(end[0], 5), Jet(end[1], 6)};
      const Jet part = Sum(k)(pose_jet, start_jet, end_jet);
      sum += part.a;
      slopes[k] = part.v;
    }
    const ceres::Jet<double, 1> root =
        fit_.scale * GuardedRoot(ceres::Jet<double, 1>(sum, 0) / count_, problem_.epsilon_m);
    residuals[0] = root.a;
    if (jacobians == nullptr) return true;
    Eigen::Matrix<double, 4, 1> by_ends = Eigen::Matrix<double, 4, 1>::Zero();
    for (std::size_t k = 0; k < fit_.count; ++k) {
      by_ends += root.v[0] * slopes[k].tail<4>();
      if (jacobians[k] != nullptr) {
        Eigen::Map<Eigen::Vector3d> by_pose(jacobians[k]);
        by_pose = root.v[0] * slopes[k].head<3>();
      }
    }
    for (int which = 0; which < 2; ++which) {
      double* jacobian = jacobians[fit_.count + static_cast<std::size_t>(which)];
      if (jacobian != nullptr) {
        Eigen::Map<Eigen::Vector2d> by_end(jacobian);
        by_end = by_ends.segment<2>(2 * which);
      }
    }
    return true;
  }

 private:
  SquaredDistances Sum(std::size_t k) const {
    const FitSighting& sighting = problem_.fit_sightings[fit_.first + k];
    return {problem_.fit_points.data() + 2 * sighting.first, sighting.count};
  }

  const Problem& problem_;
  const Fit& fit_;
  double count_ = 0.0;
};

// Takes over nothing: the functor refers to a term of the problem, which outlives it.
template <int kRows, int... kSizes, typename Functor, typename... Block>
Term Differentiated(const Functor& functor, std::unique_ptr<ceres::LossFunction> loss,
                    Block... blocks) {
  using Cost = ceres::AutoDiffCostFunction<Functor, kRows, kSizes...>;
  return {std::make_unique<Cost>(new Functor(functor)), std::move(loss), {blocks...}};
}

}  // namespace

Blocks::Blocks(const Problem& problem)
    : poses(Copy(problem.poses)), segments(Copy(problem.segments)), ends(Copy(problem.ends)) {}

std::vector<Term> MakeTerms(const Problem& problem, Blocks& blocks) {
  std::vector<Term> terms;
  for (const Relative& t : problem.relatives) {
    terms.push_back(Differentiated<3, 3, 3>(RelativeResidual{t}, MakeLoss(t.loss), blocks.Pose(t.i),
                                            blocks.Pose(t.j)));
  }
  for (const Sighting& t : problem.sightings) {
    terms.push_back(Differentiated<3, 3, 3>(SightingResidual{t}, nullptr, blocks.Pose(t.pose),
                                            blocks.Segment(t.segment)));
  }
  for (const Point& t : problem.points) {
    terms.push_back(Differentiated<1, 3, 3>(PointResidual{t}, nullptr, blocks.Pose(t.pose),
                                            blocks.Segment(t.segment)));
  }
  for (const Tie& t : problem.ties) {
    terms.push_back(Differentiated<1, 3, 3>(TieResidual{t}, nullptr, blocks.Pose(t.pose),
                                            blocks.Segment(t.segment)));
  }
  for (const Relation& t : problem.relations) {
    terms.push_back(Differentiated<3, 3, 3>(RelationResidual{t}, MakeLoss(t.loss),
                                            blocks.Segment(t.a), blocks.Segment(t.b)));
  }
  for (const Fit& t : problem.fits) {
    Term term{std::make_unique<FitCost>(problem, t), nullptr, {}};
    for (std::size_t k = 0; k < t.count; ++k) {
      term.blocks.push_back(blocks.Pose(problem.fit_sightings[t.first + k].pose));
    }
    term.blocks.push_back(blocks.End(t.segment, 0));
    term.blocks.push_back(blocks.End(t.segment, 1));
    terms.push_back(std::move(term));
  }
  for (const Relation& t : problem.paper_relations) {
    terms.push_back(Differentiated<1, 2, 2, 2, 2>(
        PaperRelationResidual{t, problem.epsilon_m}, MakeLoss(t.loss), blocks.End(t.a, 0),
        blocks.End(t.a, 1), blocks.End(t.b, 0), blocks.End(t.b, 1)));
  }
  return terms;
}

}  // namespace hitl::ceres_backend
