#include "palpate/guidance/priorities.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "palpate/guidance/law/profile.hpp"
#include "palpate/types/ldlt.hpp"
#include "palpate/types/so3.hpp"

namespace palpate::guidance {
namespace {

constexpr double kLeftOver = 1e-3;      // fraction of a wrench against a fixture of higher priority that is left
constexpr double kPriorityStep = 1e-6;  // [m] step of the differences

}  // namespace

void Priorities::begin(const Pose& X_WT) noexcept {
  X0_ = X_ = X_WT;
  J_.setIdentity();
  moves_ = false;
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
  out.share = states.authority_at(i, at.gap) * std::clamp(violation / kDampingRamp, 0.0, 1.0);
  out.c = std::max(0.5 * violation, violation - 0.5 * kDampingRamp);
  return out;
}

void Priorities::add(const FixtureStates& states, int i, const Input& in) noexcept {
  const Term at = term(states, i, X0_, in);
  if (!(at.share > 0.0)) return;
  moves_ = true;
  const double room = 1.0 + kLeftOver - at.share, w = at.share / room;
  M_ += w * at.a * at.a.transpose();
  b_ += w * at.c * at.a;
  const int directions = at.turns ? 6 : 3;
  for (int k = 0; k < directions; ++k) {
    const Vec6 step = kPriorityStep * Vec6::Unit(k);
    const Term after = term(states, i, displaced(X0_, step), in), before = term(states, i, displaced(X0_, -step), in);
    if (!(after.a.dot(before.a) > 0.5)) continue;  // the gradient jumps
    const Vec6 da = (after.a - before.a) / (2.0 * kPriorityStep);
    const double dc = (after.c - before.c) / (2.0 * kPriorityStep),
                 ds = (after.share - before.share) / (2.0 * kPriorityStep);
    const double dw = (1.0 + kLeftOver) / (room * room) * ds;
    const auto j = to_index(k);
    dM_[j] += dw * at.a * at.a.transpose() + w * (da * at.a.transpose() + at.a * da.transpose());
    db_[j] += (dw * at.c + w * dc) * at.a + w * at.c * da;
  }
}

void Priorities::solve() noexcept {
  if (!moves_) return;
  const Vec6 d = solve_ldlt(M_, b_);
  Mat6 D;
  for (int k = 0; k < 6; ++k) D.col(k) = solve_ldlt(M_, Vec6(db_[to_index(k)] - dM_[to_index(k)] * d));
  const Vec3 turn = d.tail<3>() / kLength;
  J_ = D;
  J_.bottomRows<3>() = rotation_vector_derivative(turn).inverse() * D.bottomRows<3>();
  J_.topLeftCorner<3, 3>() += Mat3::Identity();
  J_.bottomRightCorner<3, 3>() += rotation_by(turn);
  J_.topRightCorner<3, 3>() *= kLength;
  J_.bottomLeftCorner<3, 3>() /= kLength;
  X_ = displaced(X0_, d);
  if (J_.allFinite() && d.allFinite()) return;
  X_ = X0_;
  J_.setIdentity();
}

}  // namespace palpate::guidance
