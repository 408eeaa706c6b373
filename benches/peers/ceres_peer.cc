// Ceres on a g2o file: `ceres_peer sample|tuned GRAPH REPEATS POSES`.
//
// sample: as examples/slam/pose_graph_2d of Ceres does it: every coordinate a block of its own,
// automatic differentiation, Levenberg-Marquardt, SPARSE_NORMAL_CHOLESKY on SuiteSparse. Two
// departures, so that the minimum is that of the g2o convention: the information is turned into the
// example's residual frame, and its root is Lᵀ (the example takes L, right for diagonal ones alone).
// tuned: the best found: poses as blocks of three, analytic Jacobians, SUBSPACE_DOGLEG,
// EIGEN_SPARSE.
//
// Prints `cpu_ms iterations load_ms`, the fastest of REPEATS solves: ordering and symbolic analysis
// are in it, reading and building the problem are not. Writes the final poses, a line `x y theta`
// each.
#include <ceres/ceres.h>
#include <glog/logging.h>

#include <cmath>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace {

struct Pose {
  double x, y, yaw;
};

struct Constraint {
  int i, j;
  double x, y, yaw;
  Eigen::Matrix3d root;  // UᵀU = Ω in the frame of Raᵀ(b − a) − z.
};

double Milliseconds() {
  timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

template <typename T>
T Normalize(const T& angle) {
  const T two_pi(2.0 * M_PI);
  return angle - two_pi * ceres::floor((angle + T(M_PI)) / two_pi);
}

// Word by word from a stream into a map, as the example does.
void Read(const std::string& file, std::map<int, Pose>& poses,
          std::vector<Constraint>& constraints) {
  std::ifstream in(file);
  std::string tag;
  while (in.good()) {
    in >> tag;
    if (tag == "VERTEX_SE2") {
      int id;
      Pose p;
      in >> id >> p.x >> p.y >> p.yaw;
      p.yaw = Normalize(p.yaw);
      poses[id] = p;
    } else if (tag == "EDGE_SE2") {
      Constraint c;
      double xx, xy, xt, yy, yt, tt;
      in >> c.i >> c.j >> c.x >> c.y >> c.yaw >> xx >> xy >> xt >> yy >> yt >> tt;
      c.yaw = Normalize(c.yaw);
      Eigen::Matrix3d omega, turn = Eigen::Matrix3d::Identity();
      omega << xx, xy, xt, xy, yy, yt, xt, yt, tt;
      turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(c.yaw).toRotationMatrix();
      c.root = (turn * omega * turn.transpose()).llt().matrixU();
      constraints.push_back(c);
    } else {
      std::cerr << "unknown tag " << tag << "\n";
      std::exit(1);
    }
    in >> std::ws;
  }
}

struct SampleError {
  const Constraint& c;

  template <typename T>
  bool operator()(const T* xa, const T* ya, const T* ta, const T* xb, const T* yb, const T* tb,
                  T* r) const {
    using std::cos;
    using std::sin;
    const T dx = *xb - *xa, dy = *yb - *ya, cosine = cos(*ta), sine = sin(*ta);
    Eigen::Map<Eigen::Matrix<T, 3, 1>> residual(r);
    residual << cosine * dx + sine * dy - c.x, cosine * dy - sine * dx - c.y,
        Normalize(T(*tb - *ta - c.yaw));
    residual = c.root.template cast<T>() * residual;
    return true;
  }
};

struct AnglePlus {
  template <typename T>
  bool Plus(const T* x, const T* delta, T* out) const {
    *out = Normalize(T(*x + *delta));
    return true;
  }
  template <typename T>
  bool Minus(const T* y, const T* x, T* out) const {
    *out = Normalize(T(*y - *x));
    return true;
  }
};

class AnalyticError final : public ceres::SizedCostFunction<3, 3, 3> {
 public:
  explicit AnalyticError(const Constraint& c) : c_(c) {}

  bool Evaluate(double const* const* p, double* r, double** jacobians) const override {
    const double *a = p[0], *b = p[1];
    const double dx = b[0] - a[0], dy = b[1] - a[1], c = std::cos(a[2]), s = std::sin(a[2]);
    const double u = c * dx + s * dy, v = c * dy - s * dx;
    Eigen::Map<Eigen::Vector3d> residual(r);
    residual = c_.root * Eigen::Vector3d(u - c_.x, v - c_.y, Normalize(b[2] - a[2] - c_.yaw));
    if (jacobians == nullptr) return true;
    const auto set = [this](double* to, const Eigen::Matrix3d& jacobian) {
      Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> block(to);
      block = c_.root * jacobian;
    };
    Eigen::Matrix3d by_b;
    by_b << c, s, 0, -s, c, 0, 0, 0, 1;
    if (jacobians[0] != nullptr) {
      Eigen::Matrix3d by_a = -by_b;
      by_a(0, 2) = v;
      by_a(1, 2) = -u;
      set(jacobians[0], by_a);
    }
    if (jacobians[1] != nullptr) set(jacobians[1], by_b);
    return true;
  }

 private:
  const Constraint& c_;
};

ceres::Solver::Summary Solve(bool tuned, const std::vector<Constraint>& constraints,
                             std::map<int, Pose>& poses, double& cpu_ms) {
  ceres::Problem problem;
  for (const Constraint& c : constraints) {
    Pose &a = poses.at(c.i), &b = poses.at(c.j);
    if (tuned) {
      problem.AddResidualBlock(new AnalyticError(c), nullptr, &a.x, &b.x);
    } else {
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<SampleError, 3, 1, 1, 1, 1, 1, 1>(new SampleError{c}),
          nullptr, &a.x, &a.y, &a.yaw, &b.x, &b.y, &b.yaw);
    }
  }
  Pose& first = poses.begin()->second;
  if (tuned) {
    problem.SetParameterBlockConstant(&first.x);
  } else {
    for (auto& [id, pose] : poses) {
      problem.SetManifold(&pose.yaw, new ceres::AutoDiffManifold<AnglePlus, 1, 1>());
    }
    for (double* held : {&first.x, &first.y, &first.yaw}) problem.SetParameterBlockConstant(held);
  }
  ceres::Solver::Options options;
  options.max_num_iterations = 100;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.logging_type = ceres::SILENT;
  if (tuned) {
    options.trust_region_strategy_type = ceres::DOGLEG;
    options.dogleg_type = ceres::SUBSPACE_DOGLEG;
    options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  }
  ceres::Solver::Summary summary;
  const double begin = Milliseconds();
  ceres::Solve(options, &problem, &summary);
  cpu_ms = Milliseconds() - begin;
  return summary;
}

}  // namespace

int main(int count, char** arguments) {
  google::InitGoogleLogging(arguments[0]);
  if (count != 5) {
    std::cerr << "usage: ceres_peer sample|tuned GRAPH REPEATS POSES\n";
    return 2;
  }
  const bool tuned = std::string(arguments[1]) == "tuned";
  const double begin = Milliseconds();
  std::map<int, Pose> start;
  std::vector<Constraint> constraints;
  Read(arguments[2], start, constraints);
  const double load_ms = Milliseconds() - begin;
  double fastest = std::numeric_limits<double>::infinity();
  std::map<int, Pose> poses;
  ceres::Solver::Summary summary;
  for (int repeat = 0; repeat < std::atoi(arguments[3]); ++repeat) {
    poses = start;
    double cpu_ms = 0.0;
    summary = Solve(tuned, constraints, poses, cpu_ms);
    fastest = std::min(fastest, cpu_ms);
  }
  std::ofstream out(arguments[4]);
  out << std::setprecision(17);
  for (const auto& [id, p] : poses) out << p.x << ' ' << p.y << ' ' << p.yaw << '\n';
  std::cout << fastest << ' ' << summary.iterations.size() - 1 << ' ' << load_ms << "\n";
  return 0;
}
