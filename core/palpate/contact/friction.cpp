#include "palpate/contact/friction.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::contact {
namespace {

// While the anchor is dragged by the share 1 - c of the lag, its normal turns by the share 1 - c^8 towards that of the
// surface. A steady slip then has a normal force that differs by k |s|^2 / (8 rho) from that without friction, with the
// distance rho of the tool from the centre of curvature.
double eighth_power(double c) {
  const double c2 = c * c, c4 = c2 * c2;
  return c4 * c4;
}

Vec3 across(const Vec3& v, const Vec3& normal) { return v - normal * normal.dot(v); }

/// Friction over normal load, times the depth: slip begins where it exceeds a coefficient times the depth. A lag that
/// pulls the tool into the surface also takes away some of the load.
double effort(const Vec3& lag, const Vec3& normal, double mu) {
  return across(lag, normal).norm() + mu * std::max(-normal.dot(lag), 0.0);
}

}  // namespace

const Vec3& Friction::step(const Load& load) noexcept {
  if (!(load.k > 0.0 && load.depth > 0.0)) {
    release();
    lag_.setZero();
    return lag_;
  }
  if (!touching_) {
    touching_ = true;
    slipping_ = false;
    lag_.setZero();
    anchor_normal_ = load.normal;
  } else {
    // r keeps k |s|^2; the mean makes the work of a tick exact to third order.
    const double r = k_ == load.k ? 1.0 : std::sqrt(k_ / load.k);
    lag_ = r * lag_ - 0.5 * (1.0 + r) * across(load.x - x_, anchor_normal_);
  }
  x_ = load.x;
  k_ = load.k;
  slip(load);
  return lag_;
}

/// Decides between sticking and slipping, and shortens the lag to the slip limit.
void Friction::slip(const Load& load) noexcept {
  const double mu = load.mu, mu_static = std::max(mu, load.mu_static);
  const double found = effort(lag_, load.normal, mu_static);
  if (!slipping_) {
    if (found <= mu_static * load.depth) return;
    slipping_ = true;
    mu_slip_ = mu_static;
  } else if (found < std::max(mu - 0.5 * (mu_static - mu), 0.5 * mu) * load.depth) {
    slipping_ = false;
    return;
  }
  mu_slip_ = std::clamp(mu_slip_ - kBreakAway * load.dt / (load.k * load.depth), mu, mu_static);
  const double limit = mu_slip_ * load.depth;
  if (found <= limit) return;
  const double longest2 = lag_.squaredNorm();
  turn_towards(load.normal, 1.0 - eighth_power(limit / found));
  const double turned = effort(lag_, load.normal, mu_static), length2 = lag_.squaredNorm();
  if (!(turned > 0.0)) return;
  const double shorter = limit / turned;  // turned across another normal the lag may be short enough already
  lag_ *= shorter * shorter * length2 < longest2 ? shorter : std::sqrt(longest2 / length2);
}

/// Turns the anchor's normal by `share` of the way towards `normal`. The lag keeps its part across the new one.
void Friction::turn_towards(const Vec3& normal, double share) noexcept {
  const Vec3 between = anchor_normal_ + share * (normal - anchor_normal_);
  const double length2 = between.squaredNorm();
  if (!(length2 > 0.0)) return;  // opposite normals, half-way
  anchor_normal_ = between / std::sqrt(length2);
  lag_ = across(lag_, anchor_normal_);
}

}  // namespace palpate::contact
