// The residuals R1…R6 as functors for automatic differentiation: twins of src/joint/factors, in the
// same order and with the same rows. Formulas: docs/MATH.md. They neither throw nor print.
#ifndef HITL_CPP_RESIDUALS_H_
#define HITL_CPP_RESIDUALS_H_

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "hitl-slam/src/joint/ceres/bridge.rs.h"
#include "jets.h"

namespace hitl::ceres_backend {

// Numbers of the modes as they cross the bridge.
inline constexpr std::uint8_t kColocation = 0;
inline constexpr std::uint8_t kCollinear = 1;
inline constexpr std::uint8_t kPerpendicular = 2;

// R1: U·[Rzᵀ(Riᵀ(tj − ti) − tz); wrap(θj − θi − θz)], UᵀU = Ω. Blocks: pose i, pose j.
struct RelativeResidual {
  const Relative& term;

  template <typename T>
  bool operator()(const T* i, const T* j, T* r) const {
    const double* z = term.measured.data();
    const Vec2<T> along = Along(T(i[2] + z[2]));
    const Vec2<double> along_z = Along(z[2]);
    const Vec2<double> t_z{z[0], z[1]};
    const Vec2<T> d{j[0] - i[0], j[1] - i[1]};
    const T e[3] = {Dot(along, d) - Dot(along_z, t_z),
                    Dot(QuarterTurn(along), d) - Dot(QuarterTurn(along_z), t_z),
                    WrapAngle(T(j[2] - i[2] - z[2]))};
    const double* u = term.sqrt_information.data();
    for (int row = 0; row < 3; ++row) {
      r[row] = u[3 * row] * e[0] + u[3 * row + 1] * e[1] + u[3 * row + 2] * e[2];
    }
    return true;
  }
};

// R2, all points of a pose: scale·[W·Rᵀn̂; √n·n̂·(R m + t − c)]. Blocks: pose, segment.
struct SightingResidual {
  const Sighting& term;

  template <typename T>
  bool operator()(const T* pose, const T* segment, T* r) const {
    const Vec2<T> normal = QuarterTurn(Along(segment[2]));
    const Vec2<T> normal_in_robot = QuarterTurn(Along(T(segment[2] - pose[2])));
    const Vec2<T> offset =
        Transform(pose, term.mean[0], term.mean[1]) - Vec2<T>{segment[0], segment[1]};
    const auto& w = term.scatter_root;
    r[0] = term.scale * (w[0] * normal_in_robot.x + w[1] * normal_in_robot.y);
    r[1] = term.scale * (w[2] * normal_in_robot.y);
    r[2] = term.scale * std::sqrt(term.count) * Dot(normal, offset);
    return true;
  }
};

// R2, one point: scale·n̂·(R q + t − c). Blocks: pose, segment.
struct PointResidual {
  const Point& term;

  template <typename T>
  bool operator()(const T* pose, const T* segment, T* r) const {
    const Vec2<T> offset =
        Transform(pose, term.point[0], term.point[1]) - Vec2<T>{segment[0], segment[1]};
    r[0] = term.scale * Dot(QuarterTurn(Along(segment[2])), offset);
    return true;
  }
};

// R3: scale·(û·(R m + t − c) − τ). Blocks: pose, segment.
struct TieResidual {
  const Tie& term;

  template <typename T>
  bool operator()(const T* pose, const T* segment, T* r) const {
    const Vec2<T> offset =
        Transform(pose, term.mean[0], term.mean[1]) - Vec2<T>{segment[0], segment[1]};
    r[0] = term.scale * (Dot(Along(segment[2]), offset) - term.along);
    return true;
  }
};

// R4: offset and sin Δφ (perpendicular: cos Δφ), each over its σ. Blocks: segment a, segment b.
struct RelationResidual {
  const Relation& term;

  template <typename T>
  bool operator()(const T* a, const T* b, T* r) const {
    using std::cos;
    using std::sin;
    const Vec2<T> d{b[0] - a[0], b[1] - a[1]};
    const Vec2<T> along = Along(a[2]);
    const Vec2<T> normal = QuarterTurn(along);
    const T turn = b[2] - a[2];
    r[0] = T(0.0);
    r[1] = T(0.0);
    if (term.mode == kColocation) {
      r[0] = term.offset_scale * Dot(along, d);
      r[1] = term.offset_scale * Dot(normal, d);
    } else if (term.mode == kCollinear) {
      r[0] = term.offset_scale * Dot(normal, d);
    }
    r[2] = term.angle_scale * (term.mode == kPerpendicular ? cos(turn) : sin(turn));
    return true;
  }
};

// The sum of R5: squared distances of one pose's points to the segment, ends included. Blocks:
// pose, start, end.
struct SquaredDistances {
  const double* points;
  std::size_t count;

  template <typename T>
  T operator()(const T* pose, const T* start, const T* end) const {
    const Vec2<T> e0{start[0], start[1]};
    const Vec2<T> w = Vec2<T>{end[0], end[1]} - e0;
    const T length_squared = Dot(w, w);
    T sum(0.0);
    for (std::size_t k = 0; k < count; ++k) {
      const Vec2<T> q = Transform(pose, points[2 * k], points[2 * k + 1]) - e0;
      T share(0.0);
      if (Value(length_squared) > 0.0) share = Dot(q, w) / length_squared;
      if (Value(share) < 0.0) share = T(0.0);
      if (Value(share) > 1.0) share = T(1.0);
      const Vec2<T> gap = q - w * share;
      sum += Dot(gap, gap);
    }
    return sum;
  }
};

// R6: the paper's R_p. Blocks: start and end of a, start and end of b.
struct PaperRelationResidual {
  const Relation& term;
  double epsilon;

  template <typename T>
  bool operator()(const T* a0, const T* a1, const T* b0, const T* b1, T* r) const {
    const Vec2<T> w_a{a1[0] - a0[0], a1[1] - a0[1]};
    const Vec2<T> w_b{b1[0] - b0[0], b1[1] - b0[1]};
    const Vec2<T> along_a = w_a * (1.0 / GuardedRoot(Dot(w_a, w_a), epsilon));
    const Vec2<T> along_b = w_b * (1.0 / GuardedRoot(Dot(w_b, w_b), epsilon));
    const Vec2<T> d{(b0[0] + b1[0] - a0[0] - a1[0]) / 2.0, (b0[1] + b1[1] - a0[1] - a1[1]) / 2.0};
    const T cosine = Dot(along_a, along_b);
    r[0] = term.angle_scale * (term.mode == kPerpendicular ? cosine : 1.0 - cosine);
    if (term.mode == kColocation) {
      r[0] += term.offset_scale * GuardedRoot(Dot(d, d), epsilon);
    } else if (term.mode == kCollinear) {
      const T offset = Dot(d, QuarterTurn(along_a));
      r[0] += term.offset_scale * GuardedRoot(T(offset * offset), epsilon);
    }
    return true;
  }
};

}  // namespace hitl::ceres_backend

#endif  // HITL_CPP_RESIDUALS_H_
