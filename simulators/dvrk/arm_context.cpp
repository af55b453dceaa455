#include "dvrk/arm_context.hpp"

#include <stdexcept>

namespace palpate::dvrk {
namespace {

ArmSpec checked(ArmSpec spec) {
  const Eigen::Index n = spec.model.n();
  const auto require = [&](const char* what, const JointVector& x, bool positive) {
    const bool good = x.size() == n && x.allFinite() && (!positive || (x.array() > 0.0).all());
    if (good) return;
    throw std::invalid_argument("dVRK arm " + spec.name + ": " + what + " needs " + std::to_string(n) +
                                " finite numbers" + (positive ? " above zero" : "") + ", one per joint; got " +
                                std::to_string(x.size()) + " (palpate.simulators.dvrk.arm() fills them)");
  };
  if (spec.kind == ArmKind::mtm && (n != 7 || !spec.dynamic)) {
    throw std::invalid_argument("dVRK arm " + spec.name + ": an MTM has 7 joints and is dynamic; got " +
                                std::to_string(n) + " joints");
  }
  if (spec.dynamic) {
    require("P", spec.P, true);
    require("D", spec.D, true);
  }
  require("tracking_error", spec.tracking_error, true);
  require("v_max", spec.v_max, true);
  require("a_max", spec.a_max, true);
  require("start", spec.start, false);
  require("home", spec.home, false);
  if (!(spec.jaw_min <= spec.jaw_max) ||
      (spec.kind == ArmKind::psm && !(spec.jaw_v_max > 0.0 && spec.jaw_a_max > 0.0))) {
    throw std::invalid_argument("dVRK arm " + spec.name + ": jaw_min must not be above jaw_max, and a PSM needs " +
                                "jaw_v_max and jaw_a_max above zero");
  }
  return spec;
}

}  // namespace

ArmContext::ArmContext(ArmSpec arm, Address at, Outbox& out)
    : spec(checked(std::move(arm))),
      model(spec.model),
      body(make_body(spec)),
      publisher(at, Text(spec.name), out),
      instrument(spec),
      base_frame(spec.base_frame) {
  const JointVector one = JointVector::Zero(1);
  state.gripper = {one, one, one};
  state.body_jacobian = state.spatial_jacobian = Jacobian::Zero(6, n());
}

bool ArmContext::is_homed() const noexcept {
  const bool tool = spec.kind == ArmKind::psm && instrument.tool_present();
  return powered && biased && (!tool || instrument.engaged());
}

bool ArmContext::is_cartesian_ready() const noexcept {
  return is_joint_ready() && (spec.kind != ArmKind::psm || instrument.engaged());
}

void ArmContext::set_operating(State operating, bool is_busy) noexcept {
  state.operating_state = {operating, is_homed(), is_busy};
  publisher.operating(state.operating_state);
}

void ArmContext::set_busy(bool is_busy) noexcept {
  const OperatingState& now = state.operating_state;
  if (now.is_busy != is_busy || now.is_homed != is_homed()) set_operating(now.state, is_busy);
}

void ArmContext::error(const Text& words) noexcept {
  ++errors;
  last_error = words;
  publisher.message(Topic::error, words);
}

}  // namespace palpate::dvrk
