#include "dvrk/instrument.hpp"

#include <algorithm>

namespace palpate::dvrk {
namespace {

constexpr double kServoSpeed = 12.0;  // [rad/s] of the jaw's servo

JointVector one(double x) noexcept { return JointVector::Constant(1, x); }

}  // namespace

Instrument::Instrument(const ArmSpec& spec)
    : q_min_(spec.jaw_min),
      q_max_(spec.jaw_max),
      v_max_(spec.jaw_v_max),
      a_max_(spec.jaw_a_max),
      tau_max_(spec.jaw_tau_max),
      tool_(!spec.tool_type.empty()),
      type_(spec.tool_type) {
  measured_ = setpoint_ = {one(0.0), one(0.0), one(0.0)};
}

void Instrument::set_adapter_present(bool present, const EventPublisher& publisher) noexcept {
  adapter_ = present;
  publisher.message(Topic::status, present ? "sterile adapter present" : "sterile adapter removed");
  if (!present) engaged_ = false;
  newly_mounted_ = newly_mounted_ || present;
}

void Instrument::set_tool_present(bool present, const EventPublisher& publisher) noexcept {
  if (present == tool_) return;
  tool_ = newly_mounted_ = present;
  engaged_ = false;
  publisher.message(Topic::status, present ? "tool present" : "tool removed");
  if (!present || !type_.empty()) return;
  publisher.message(Topic::warning, "tool type requested from user");
  publisher.publish(Topic::tool_type_request);
}

void Instrument::set_tool_type(const Text& type, const EventPublisher& publisher) noexcept {
  type_ = type;
  publisher.text(Topic::tool_type, type_);
}

void Instrument::engage(const EventPublisher& publisher) noexcept {
  if (!can_engage()) return;
  engaged_ = true;
  newly_mounted_ = false;
  hold();
  publisher.message(Topic::status, "tool engaged");
  publisher.text(Topic::tool_type, type_);
}

void Instrument::servo_jp(double q) noexcept {
  path_.stop();
  by_torque_ = false;
  setpoint_.q[0] = std::clamp(q, q_min_, q_max_);
}

void Instrument::move_jp(double q, double ratio_v, double ratio_a) noexcept {
  by_torque_ = false;
  path_.start(setpoint_.q, path_.active() ? path_.v() : one(0.0), one(std::clamp(q, q_min_, q_max_)),
              one(ratio_v * v_max_), one(ratio_a * a_max_));
}

void Instrument::servo_jf(double tau) noexcept {
  path_.stop();
  by_torque_ = true;
  setpoint_.tau[0] = std::clamp(tau, -tau_max_, tau_max_);
}

void Instrument::hold() noexcept { servo_jp(measured_.q[0]); }

bool Instrument::run(double dt, bool powered) noexcept {
  const double before = measured_.q[0];
  bool arrived = false;
  if (!powered || !engaged_) {
    hold();
  } else if (path_.active()) {
    path_.step(dt);
    setpoint_.q = path_.q();
    arrived = path_.done();
  } else if (by_torque_) {
    const double tau = setpoint_.tau[0];
    setpoint_.q[0] = tau < 0.0 ? q_min_ : tau > 0.0 ? q_max_ : before;
  }
  setpoint_.v = path_.active() ? path_.v() : one(0.0);
  const double reach = kServoSpeed * dt;
  measured_.q[0] = before + std::clamp(setpoint_.q[0] - before, -reach, reach);
  measured_.v[0] = (measured_.q[0] - before) / dt;
  measured_.tau[0] = by_torque_ ? setpoint_.tau[0] : 0.0;
  return arrived;
}

}  // namespace palpate::dvrk
