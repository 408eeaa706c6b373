// Small plane geometry on doubles and on ceres::Jet alike.
#ifndef HITL_CPP_JETS_H_
#define HITL_CPP_JETS_H_

#include <ceres/jet.h>

#include <cmath>

namespace hitl::ceres_backend {

// A vector in the plane.
template <typename T>
struct Vec2 {
  T x;
  T y;
};

template <typename T>
Vec2<T> operator+(const Vec2<T>& a, const Vec2<T>& b) {
  return {a.x + b.x, a.y + b.y};
}

template <typename T>
Vec2<T> operator-(const Vec2<T>& a, const Vec2<T>& b) {
  return {a.x - b.x, a.y - b.y};
}

template <typename T>
Vec2<T> operator*(const Vec2<T>& a, const T& k) {
  return {a.x * k, a.y * k};
}

template <typename T>
T Dot(const Vec2<T>& a, const Vec2<T>& b) {
  return a.x * b.x + a.y * b.y;
}

// The unit vector at an angle.
template <typename T>
Vec2<T> Along(const T& angle) {
  using std::cos;
  using std::sin;
  return {cos(angle), sin(angle)};
}

// A vector turned by +90°.
template <typename T>
Vec2<T> QuarterTurn(const Vec2<T>& v) {
  return {-v.y, v.x};
}

// A constant point taken from a pose's frame to the world.
template <typename T>
Vec2<T> Transform(const T* pose, double x, double y) {
  using std::cos;
  using std::sin;
  const T c = cos(pose[2]);
  const T s = sin(pose[2]);
  return {c * x - s * y + pose[0], s * x + c * y + pose[1]};
}

// The number without its derivatives.
inline double Value(double x) { return x; }
template <typename T, int N>
double Value(const ceres::Jet<T, N>& x) {
  return x.a;
}

// The same direction in (−π, π]; step for step the twin of wrap_angle in src/geometry/angle.rs.
template <typename T>
T WrapAngle(const T& angle) {
  constexpr double kPi = 3.14159265358979323846;
  const double value = Value(angle);
  if (value > -kPi && value <= kPi) return angle;
  const T wrapped = angle - T(2.0 * kPi * std::round(value / (2.0 * kPi)));
  return Value(wrapped) <= -kPi ? wrapped + T(2.0 * kPi) : wrapped;
}

// √(s + ε²) for s ≥ 0: a root that can be differentiated at zero.
template <typename T>
T GuardedRoot(const T& s, double epsilon) {
  using std::sqrt;
  return sqrt(s + T(epsilon * epsilon));
}

}  // namespace hitl::ceres_backend

#endif  // HITL_CPP_JETS_H_
