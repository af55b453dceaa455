#include "palpate/contact/capsules.hpp"

#include <algorithm>
#include <limits>

#include "palpate/types/index.hpp"

namespace palpate::contact {
namespace {

constexpr double kPoint = 1e-12;  // [m^2] squared length below which a segment is a point

/// t that minimises the distance from q0 + t (q1 - q0) to p, within the segment.
double nearest_on(const Vec3& p, const Vec3& q0, const Vec3& e, double ee) noexcept {
  return ee > kPoint ? std::clamp(e.dot(p - q0) / ee, 0.0, 1.0) : 0.0;
}

}  // namespace

NearestPoints nearest_points(const Vec3& p0, const Vec3& p1, const Vec3& q0, const Vec3& q1) noexcept {
  const Vec3 d = p1 - p0, e = q1 - q0, r = p0 - q0;
  const double dd = d.squaredNorm(), ee = e.squaredNorm();
  NearestPoints out;
  if (dd > kPoint) {
    const double de = d.dot(e), cross = dd * ee - de * de;
    if (ee > kPoint && cross > 1e-12 * dd * ee) {  // not parallel: nearest point of the two lines
      out.s = std::clamp((de * e.dot(r) - d.dot(r) * ee) / cross, 0.0, 1.0);
    }
    out.t = nearest_on(p0 + out.s * d, q0, e, ee);
    out.s = nearest_on(q0 + out.t * e, p0, d, dd);
  } else {
    out.t = nearest_on(p0, q0, e, ee);
  }
  out.p = p0 + out.s * d;
  out.q = q0 + out.t * e;
  return out;
}

Push CapsulePair::step(const Capsule& A, const Capsule& B, const InstrumentLaw& law) noexcept {
  const NearestPoints near = nearest_points(A.a, A.b, B.a, B.b);
  const Vec3 apart = near.p - near.q;
  const double distance = apart.norm(), reach = A.radius + B.radius;
  Vec3 n = distance > 1e-9 ? Vec3(apart / distance) : normal_;
  double along = distance;
  if (n.dot(normal_) < 0.0) {  // the axes have crossed since the last tick
    n = -n;
    along = -distance;
  }
  Push push;
  push.gap = along - reach;
  push.p_WC = 0.5 * (near.p + near.q) + 0.5 * (B.radius - A.radius) * n;
  if (!(push.gap < 0.0) || n.isZero(0.0)) {
    normal_.setZero();
    return push;
  }
  normal_ = n;
  const Vec3 v_A = A.v_a + near.s * (A.v_b - A.v_a), v_B = B.v_a + near.t * (B.v_b - B.v_a);
  push.v_A_W = v_A;
  push.v_B_W = v_B;
  push.F_A_W = std::max(0.0, -law.stiffness * push.gap - law.damping * (v_A - v_B).dot(n)) * n;
  return push;
}

int InstrumentPair::step(const Instrument& A, const Instrument& B, const InstrumentLaw& law,
                         std::array<Push, kMaxCapsulePairs>& pushes, double& gap) noexcept {
  gap = std::numeric_limits<double>::infinity();
  int found = 0;
  for (int i = 0; i < A.size; ++i) {
    for (int j = 0; j < B.size; ++j) {
      const Push push = pair_[to_index(i * kMaxCapsules + j)].step(A.capsule[to_index(i)], B.capsule[to_index(j)], law);
      gap = std::min(gap, push.gap);
      if (push.gap < 0.0) pushes[to_index(found++)] = push;
    }
  }
  return found;
}

}  // namespace palpate::contact
