#include "palpate/guidance/priorities.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "palpate/guidance/authority.hpp"
#include "palpate/guidance/law/profile.hpp"
#include "palpate/types/ldlt.hpp"
#include "palpate/types/so3.hpp"

namespace palpate::guidance {
namespace {

constexpr double kLeftOver = 1e-3;      // fraction of a wrench against a fixture of higher priority that is left
constexpr double kPriorityStep = 1e-6;  // [m] step of the differences

/// The force of a law at rest, relative to that of its spring [0-1]: it falls to zero towards the end of its range.
double acts(const Law& law, const Constraint& c) noexcept {
  const double K = c.rotational ? law.turning_stiffness() : law.stiffness();
  if (!(K > 0.0) || !(law.most(c) > 0.0)) return 1.0;  // a damper has no force at rest
  const Wrench F = law.force(c, {}).F;
  const double f = c.rotational ? F.t.norm() / c.gradient.t.norm()
                                : std::sqrt((F.f.squaredNorm() + F.t.squaredNorm()) /
                                            (c.gradient.f.squaredNorm() + c.gradient.t.squaredNorm()));
  return std::min(f / std::min(K * c.violation(), law.most(c)), 1.0);
}

}  // namespace

void Priorities::begin(const Pose& X_WT) noexcept {
  X0_ = X_ = X_WT;
  J_.setIdentity();
  moves_ = edited_ = false;
  drift_ = {};
  M_.setIdentity();
  b_.setZero();
  dM_.fill(Mat6::Zero());
  db_.fill(Vec6::Zero());
}

Priorities::Term Priorities::term(const FixtureStates& states, int i, const Pose& X, const Input& in) noexcept {
  Term out;
  const Constraint at = states.evaluate(i, X, in);
  if (!at.one_sided()) return out;
  const Vec6 gradient = row(at);
  const double length = gradient.norm();
  if (!(length > 0.0)) return out;
  const double violation = -at.gap / length;
  out.a = gradient / length;
  out.turns = at.rotational || at.gradient.t != Vec3::Zero();
  if (!(violation > 0.0)) return out;
  const double authority = states.authority_at(i, at.gap), rate = -at.gap_rate_of_fixture / length;
  out.share = authority * std::min(violation / kDampingRamp, 1.0) * acts(*states.fixture(i).law, at);
  out.c = std::max(0.5 * violation, violation - 0.5 * kDampingRamp);
  out.c_rate = violation < kDampingRamp ? 0.5 * rate : rate;
  out.share_rate = violation < kDampingRamp ? authority * rate / kDampingRamp : 0.0;
  return out;
}

void Priorities::add(const FixtureStates& states, int i, const Input& in) noexcept {
  const Term at = term(states, i, X0_, in);
  const FixtureState& now = states[i];
  edited_ |= now.edited || ((now.rise > 0.0 || now.falls) && earns_credit(states.fixture(i).policy));
  if (!(at.share > 0.0)) return;
  moves_ = true;
  const double room = 1.0 + kLeftOver - at.share, w = at.share / room;
  M_ += w * at.a * at.a.transpose();
  b_ += w * at.c * at.a;
  const auto differ = [this, &at, w, room](int k, const Vec6& da, double dc, double ds) {
    const double dw = (1.0 + kLeftOver) / (room * room) * ds;
    dM_[to_index(k)] += dw * at.a * at.a.transpose() + w * (da * at.a.transpose() + at.a * da.transpose());
    db_[to_index(k)] += (dw * at.c + w * dc) * at.a + w * at.c * da;
  };
  differ(kTime, Vec6::Zero(), at.c_rate, at.share_rate);
  const int directions = at.turns ? 6 : 3;
  for (int k = 0; k < directions; ++k) {
    const Vec6 step = kPriorityStep * Vec6::Unit(k);
    const Term after = term(states, i, displaced(X0_, step), in), before = term(states, i, displaced(X0_, -step), in);
    if (!(after.a.dot(before.a) > 0.5)) continue;  // the gradient jumps
    differ(k, Vec6((after.a - before.a) / (2.0 * kPriorityStep)), (after.c - before.c) / (2.0 * kPriorityStep),
           (after.share - before.share) / (2.0 * kPriorityStep));
  }
}

void Priorities::solve() noexcept {
  if (!moves_) return;
  const Vec6 d = solve_ldlt(M_, b_);
  const auto derivative = [this, &d](int k) { return solve_ldlt(M_, Vec6(db_[to_index(k)] - dM_[to_index(k)] * d)); };
  Mat6 D;
  for (int k = 0; k < 6; ++k) D.col(k) = derivative(k);
  const Vec6 drift = derivative(kTime);
  const Vec3 turn = d.tail<3>() / kLength;
  const Mat3 turning = rotation_vector_derivative(turn).inverse();
  drift_ = {drift.head<3>(), turning * drift.tail<3>() / kLength};
  J_ = D;
  J_.bottomRows<3>() = turning * D.bottomRows<3>();
  J_.topLeftCorner<3, 3>() += Mat3::Identity();
  J_.bottomRightCorner<3, 3>() += rotation_by(turn);
  J_.topRightCorner<3, 3>() *= kLength;
  J_.bottomLeftCorner<3, 3>() /= kLength;
  X_ = displaced(X0_, d);
  if (J_.allFinite() && d.allFinite() && drift.allFinite()) return;
  X_ = X0_;
  drift_ = {};
  J_.setIdentity();
}

}  // namespace palpate::guidance
