#include "dvrk/arm.hpp"

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
                                std::to_string(x.size()) + " (palpate.dvrk.arm() fills them)");
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

Arm::Arm(ArmSpec spec, Address at, Outbox& out)
    : spec_(checked(std::move(spec))),
      model_(spec_.model),
      body_(make_body(spec_)),
      voice_(at, Text(spec_.name), out),
      instrument_(spec_),
      pinch_(kGripperOpen),
      n_(model_.n()),
      base_frame_(spec_.base_frame) {
  const JointVector zero = JointVector::Zero(n_);
  goal_q_ = goal_v_ = goal_tau_ = servo_tau_ = zero;
  order_.q = order_.v = order_.tau = zero;
  state_.gripper = {JointVector::Constant(1, pinch_), JointVector::Zero(1), JointVector::Zero(1)};
  state_.body_jacobian = state_.spatial_jacobian = Jacobian::Zero(6, n_);
  path_.start(zero, zero, zero, spec_.v_max, spec_.a_max);
  path_.stop();
  measure();
}

void Arm::start() noexcept {
  operating(State::DISABLED, false);
  set_desired(Phase::disabled);
  voice_.value(Topic::ratio, 1.0);
  voice_.value(Topic::ratio_v, 1.0);
  voice_.value(Topic::ratio_a, 1.0);
  if (spec_.kind == ArmKind::mtm) voice_.flag(Topic::orientation_locked, false);
}

void Arm::step(double dt) noexcept { body_->step(dt, around_); }

// As the real component: measure, go on in the state machine, order. Commands come in between two periods.
void Arm::run(double t, double dt) noexcept {
  voice_.at(t);
  if (!body_->truth().q.allFinite()) {
    body_->reset(spec_.start);
    fault("the simulated joints were not finite: the arm is where it started");
  }
  measure();
  if (spec_.kind == ArmKind::mtm) gripper_.run(pinch_, dt, voice_);
  run_phase(dt);
  if (spec_.kind == ArmKind::psm && instrument_.run(dt, phase_ == Phase::homed)) stop_jaw();
  body_->command(order_);
}

void Arm::stop_jaw() noexcept {
  voice_.flag(Topic::goal_reached, true);
  busy(path_.active());
}

}  // namespace palpate::dvrk
