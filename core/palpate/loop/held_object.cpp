#include "palpate/loop/held_object.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "palpate/types/so3.hpp"

namespace palpate::loop {
namespace {

constexpr double kSettles = 0.02;  // share by which a rod that was handed over moves into its new grip in a tick [-]
constexpr double kOpens = 2e-4;    // gap between a jaw and the rod at which the jaws have let it go [m]

/// X with its displacement and its rotation reduced by a share.
Pose reduced(const Pose& X, double share) noexcept {
  const Eigen::AngleAxisd turn = angle_axis(X.R);
  return {Eigen::AngleAxisd((1.0 - share) * turn.angle(), turn.axis()).toRotationMatrix(), (1.0 - share) * X.p};
}

}  // namespace

HeldObject::HeldObject(const RodOptions& options) : options_(options), X_WO_(options.X_WO) {
  const bool finite = options.a.allFinite() && options.b.allFinite() && std::isfinite(options.radius);
  if (!finite || options.radius < 0.0 || !(options.stiffness >= 0.0 && std::isfinite(options.stiffness)) ||
      !(options.hold >= 0.0 && std::isfinite(options.hold))) {
    throw std::invalid_argument(
        "graspable: ends, radius, stiffness and hold must be finite, the last three not below 0");
  }
  own_.X_WO = X_WO_;
}

// True if the jaws hold the rod at X_WO. A grip closes when a jaw of each side touches the rod, which lies between
// them.
bool HeldObject::holds(std::span<const Jaw> jaws, const Pose& X_WO) const noexcept {
  std::array<double, 2> gap{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  std::array<Vec3, 2> away{Vec3::Zero(), Vec3::Zero()};
  const Vec3 a = X_WO * options_.a, b = X_WO * options_.b;
  for (const Jaw& jaw : jaws) {
    const contact::NearestPoints near = contact::nearest_points(a, b, jaw.capsule.a, jaw.capsule.b);
    const Vec3 offset = near.q - near.p;
    const auto side = static_cast<std::size_t>(jaw.side);
    if (const double d = offset.norm() - options_.radius - jaw.capsule.radius; d < gap[side]) {
      gap[side] = d;
      away[side] = offset;
    }
  }
  const double widest = std::max(gap[0], gap[1]);
  return own_.holds ? widest <= kOpens : widest <= 0.0 && away[0].dot(away[1]) < 0.0;
}

void HeldObject::step(const Pose& X_WT, std::span<const Jaw> jaws, std::span<const Grip> others,
                      std::uint64_t order) noexcept {
  const auto first = [](const Grip& a, const Grip& b) {
    return (a.holds ? a.since : ~0ull) < (b.holds ? b.since : ~0ull);
  };
  const auto earliest = std::min_element(others.begin(), others.end(), first);
  const bool carried = earliest != others.end() && earliest->holds && (!own_.holds || earliest->since < own_.since);
  for (const Grip& other : others) {
    if (other.moved > own_.moved && holding_ != Holding::carries) {
      own_.moved = other.moved;
      X_WO_ = other.X_WO;
    }
  }
  const bool held = holds(jaws, own_.holds ? X_WT * X_TO_ : X_WO_);
  const Holding before = holding_;
  holding_ = !held ? Holding::none : carried ? Holding::holds_too : Holding::carries;
  if (held && !own_.holds) own_.since = order;
  if (held && !own_.holds) {
    X_TO_ = X_WT.inverse() * X_WO_;
    slack_ = Pose{};
  }
  own_.holds = held;
  const Pose at = held ? X_WT * X_TO_ : X_WO_;
  if (holding_ == Holding::carries) {
    // The rod does not jump when the first grip opens: the second one carries it from where it is.
    slack_ = before == Holding::holds_too ? at.inverse() * X_WO_ : reduced(slack_, kSettles);
    X_WO_ = at * slack_;
    own_.moved = order;
  }
  own_.X_WO = X_WO_;
  own_.a_W = at * options_.a;
  own_.b_W = at * options_.b;
}

void HeldObject::pull(std::span<const Grip> others) noexcept {
  F_W_ = {};
  stiffness_ = 0.0;
  if (!own_.holds) return;
  for (const Grip& other : others) {
    if (!other.holds) continue;
    for (const auto& [mine, theirs] : {std::pair{own_.a_W, other.a_W}, std::pair{own_.b_W, other.b_W}}) {
      Vec3 F = 0.5 * options_.stiffness * (theirs - mine);
      if (const double norm = F.norm(); norm > 0.5 * options_.hold) F *= 0.5 * options_.hold / norm;
      F_W_.f += F;
      F_W_.t += (0.5 * (mine + theirs)).cross(F);
    }
    stiffness_ += options_.stiffness;
  }
}

}  // namespace palpate::loop
