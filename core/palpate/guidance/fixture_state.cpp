#include "palpate/guidance/fixture_state.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>

namespace palpate::guidance {
namespace {

bool finite(const Constraint& c) noexcept {
  return !std::isnan(c.gap) && !std::isnan(c.speed_limit) && c.gradient.f.allFinite() && c.gradient.t.allFinite() &&
         std::isfinite(c.gap_rate_of_fixture) && c.free.allFinite();
}

constexpr double kFarGap = 1e3;  // [m, rad] for a gap that is infinite

}  // namespace

double FixtureState::allowed() const noexcept { return std::max(slack, (1.0 - authority) * constraint.violation()); }

double factor(const Ramp& ramp, double measured) noexcept {
  return std::clamp((measured - ramp.from) / (ramp.to - ramp.from), 0.0, 1.0);
}

double factor_by_distance(const Policy& policy, double gap) noexcept {
  double product = 1.0;
  for (const Ramp& ramp : policy.ramps) {
    if (ramp.by == Ramp::By::distance) product *= factor(ramp, std::min(std::abs(gap), kFarGap));
  }
  return product;
}

double FixtureStates::authority_at(int i, double gap) const noexcept {
  const FixtureState& now = (*this)[i];
  const double here = factor_by_distance(fixture(i).policy, now.policy_gap);
  return here > 0.0 ? now.authority / here * factor_by_distance(fixture(i).policy, gap) : now.authority;
}

void FixtureStates::take(const FixtureList& fixtures) noexcept {
  const int before = size();
  std::swap(old_, state_);
  list_ = fixtures.fixtures();
  tool_ = fixtures.tool.get();
  for (int i = 0; i < size(); ++i) {
    const std::uint64_t key = std::hash<std::string>{}(fixture(i).name);
    const auto* end = old_.cbegin() + before;
    const auto* old = std::find_if(old_.cbegin(), end, [key](const FixtureState& s) { return s.key == key; });
    FixtureState& now = (*this)[i];
    now = old != end ? *old : FixtureState{};
    now.key = key;
    now.needs_slack = now.edited = true;
  }
}

void FixtureStates::begin(const Input& in) noexcept {
  if (tool_ != nullptr) tool_->set({in.tool.X_WT, in.goal.V_WT});
  for (int i = 0; i < size(); ++i) {
    for (const auto& frame : fixture(i).frames) frame->see(in.t);
  }
}

Constraint FixtureStates::evaluate(int i, const Pose& X_WT, const Input& in) const noexcept {
  const ToolForce& tool_force = in.tool_force;
  const Constraint c =
      guidance::evaluate(fixture(i), {X_WT, in.tool.X_WT.p, tool_force.F_T_W.f, tool_force.stiffness}, in.t);
  return finite(c) ? c : Constraint{};
}

}  // namespace palpate::guidance
