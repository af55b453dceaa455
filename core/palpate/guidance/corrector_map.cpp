// The corrector's solution, linearised around the mapped goal.
#include <algorithm>
#include <array>
#include <cmath>

#include "palpate/guidance/corrector.hpp"

namespace palpate::guidance {
namespace {

constexpr double kSameBorder = 0.9998;  // cosine (1.1 degrees): rows of one fixture that are closer are one border
constexpr double kBendStep = 1e-6;      // [m] step of the differences of a border's normal
constexpr double kBefore = 1e-5;        // [m] distance before a target at which its constraint has a gradient

Vec6 scaled_gradient(const Constraint& c) noexcept {
  Vec6 g;
  g << c.gradient.f, c.gradient.t / kLength;
  return g;
}

bool turns(const Constraint& c) noexcept { return c.rotational || c.gradient.t != Vec3::Zero(); }

}  // namespace

void Corrector::linearise(const FixtureStates& states, const Input& in, bool at_tool) noexcept {
  bool curved = at_tool || map_.rows() > 1;
  for (int r = 0; r < map_.rows(); ++r) {
    ActiveRow& row = map_.row(r);
    row.g = row.a;
    if (row.fixture < 0) continue;
    const FixtureState& now = states[row.fixture];
    row.turns = turns(now.constraint);
    row.by_force = now.constraint.by_force;
    const double left = 1.0 - now.authority;
    if (!has_sides(now.constraint) && left > 0.0 && left * now.constraint.violation() > now.slack)
      row.b = left * scaled_gradient(now.constraint);
  }
  for (int r = 0; curved && r < map_.rows(); ++r) {
    ActiveRow& row = map_.row(r);
    const auto others = [&](int i) { return i != r && map_.row(i).fixture == row.fixture; };
    bool corner = row.fixture < 0;
    for (int i = 0; i < map_.rows(); ++i) corner |= others(i);
    if (!corner) bend(states, row, in);
  }
  const Vec6 y = displacement(in.goal.X_WT_goal, X_WT_);
  for (int r = 0; r < map_.rows(); ++r) {
    ActiveRow& row = map_.row(r);
    if (row.fixture < 0 || !has_sides(states[row.fixture].constraint)) continue;
    // The side that the row belongs to has moved the goal by the fraction `authority` of its violation.
    const FixtureState& now = states[row.fixture];
    const double left = 1.0 - now.authority;
    if (left > 0.0 && left / now.authority * row.a.dot(y) > now.slack) row.b = left * row.g;
  }
  map_.solve(y);
  if (held_) map_.hold();
}

// Collects the active rows of the last solution, those of one border or target merged into one row of their mean
// length.
void Corrector::collect_rows(const FixtureStates& states) noexcept {
  std::array<double, CorrectionMap::kRows> squares{};
  map_.clear();
  for (int r = 0; r < qp_.rows(); ++r) {
    const double lambda = qp_.multiplier(r);
    if (!(lambda > 0.0)) continue;
    const Vec6 a = qp_.row(r);
    const int fixture = fixture_of_[to_index(r)];
    int k = 0;
    for (; k < map_.rows(); ++k) {
      const ActiveRow& row = map_.row(k);
      if (fixture < 0 || row.fixture != fixture) continue;
      if (states[fixture].constraint.attracts || row.a.dot(a) > kSameBorder * row.a.norm() * a.norm()) break;
    }
    if (k == map_.rows()) {
      ActiveRow fresh;
      fresh.fixture = fixture;
      if (!map_.add(fresh)) continue;
    }
    ActiveRow& row = map_.row(k);
    row.lambda += lambda;
    row.a += lambda * a;  // the sum, until all rows are known
    squares[to_index(k)] += lambda * a.squaredNorm();
  }
  for (int k = 0; k < map_.rows(); ++k) {
    ActiveRow& row = map_.row(k);
    const double length = std::sqrt(squares[to_index(k)] / row.lambda), sum = row.a.norm();
    row.a *= sum > 0.0 ? length / sum : 0.0;
    row.lambda = sum / length;
    row.plain = row.a;
    row.plain_lambda = row.lambda;
  }
}

// Takes direction, gradient and curvature of the row's border at the corrected goal. A target (guide, orient, rcm) has
// no gradient at the target itself: it is evaluated a little before it.
void Corrector::bend(const FixtureStates& states, ActiveRow& row, const Input& in) const noexcept {
  const bool attracts = states[row.fixture].constraint.attracts;
  const Pose X = attracts ? displaced(X_WT_, -kBefore * row.a.normalized()) : X_WT_;
  const Constraint here = states.evaluate(row.fixture, X, in);
  if (!here.one_sided()) return;
  const Vec6 a = palpate::guidance::row(here);
  if (!(a.dot(row.a) > 0.5 * a.norm() * row.a.norm())) return;  // the border turns too fast
  const auto there = [&](const Vec6& step) -> Vec6 {
    const Constraint c = states.evaluate(row.fixture, displaced(X, step), in);
    return c.one_sided() ? palpate::guidance::row(c) : a;
  };
  row.lambda *= row.a.norm() / a.norm();
  row.a = a;
  row.g = scaled_gradient(here);
  if (turns(here)) {
    for (int k = 0; k < 6; ++k) {
      const Vec6 step = kBendStep * Vec6::Unit(k);
      row.H.col(k) = 0.5 / kBendStep * (there(step) - there(-step));
    }
    return;
  }
  const Vec6 unit = a.normalized();
  const Mat3 basis = basis_of(unit.head<3>());
  for (int k = 0; k < 2; ++k) {  // only motions along the border matter, and there the gradient only turns
    Vec6 along = Vec6::Zero();
    along.head<3>() = basis.col(k);
    const Vec6 turn = (there(kBendStep * along) - a) / kBendStep;
    row.H += (turn - unit.dot(turn) * unit) * along.transpose();
  }
}

}  // namespace palpate::guidance
