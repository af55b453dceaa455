// Admittance control (Newman 1992): the measured force of the hand accelerates a virtual mass, and the arm tracks the
// position of this mass.
//
//   m x_a'' = F_hand + F_H - (b + B) x_a'                              virtual handle; B: damping matrix of guidance
//   F_motors = Lambda (x_a'' + 2 w (x_a' - x') + w^2 (x_a - x)) + Gamma v + eta     position loop, critically damped
//
// Friction and errors of the arm model disturb the position loop, but not the virtual dynamics that the hand feels. The
// felt dynamics are limited by the bandwidth of the position loop and by the noise of the load cell. Only the position
// is controlled: moments are rendered as by the stiffness law.
#include <algorithm>
#include <numbers>

#include "palpate/torque/law.hpp"

namespace palpate::torque {
namespace {

constexpr double kLead = 0.01;  // [m] largest lead of the virtual handle over an arm that is held back

class Admittance final : public ControlLaw {
 public:
  Admittance(const ControlLawOptions& options, double dt)
      : options_(options), dt_(dt), w_(2.0 * std::numbers::pi * options.servo_bandwidth) {}

  Wrench step(const ControlLawInput& in) noexcept override {
    if (!started_) {
      p_ = in.p_LH;
      v_ = in.v_LH;
      started_ = true;
    }
    const double m = options_.virtual_mass, b = options_.virtual_damping;
    const Vec3 v_before = v_;
    const Mat3 implicit_damping = (1.0 + dt_ * b / m) * Mat3::Identity() + dt_ / m * in.B_L;  // stable for any damping
    v_ = implicit_damping.inverse() * (v_ + dt_ / m * (in.F_hand_L + in.F_H_L));
    p_ += dt_ * v_;
    const double lead = (p_ - in.p_LH).norm();
    if (lead > kLead) p_ = in.p_LH + kLead / lead * (p_ - in.p_LH);
    const Vec3 a = (v_ - v_before) / dt_ + 2.0 * w_ * (v_ - in.v_LH) + w_ * w_ * (p_ - in.p_LH);
    return inertia(in, a) + in.Gamma_v - Wrench{in.F_H_L, Vec3::Zero()};
  }

  void reset() noexcept override { started_ = false; }
  [[nodiscard]] bool needs_load_cell() const noexcept override { return true; }
  [[nodiscard]] bool renders_damping() const noexcept override { return true; }
  [[nodiscard]] bool removes_friction() const noexcept override { return true; }
  [[nodiscard]] Vec3 neglected_force(const ControlLawInput& /*in*/, const Vec3& /*a*/) const noexcept override {
    return Vec3::Zero();
  }

 private:
  ControlLawOptions options_;
  double dt_, w_;
  bool started_ = false;
  Vec3 p_ = Vec3::Zero(), v_ = Vec3::Zero();
};

}  // namespace

std::unique_ptr<ControlLaw> make_admittance(const ControlLawOptions& options, double dt) {
  return std::make_unique<Admittance>(options, dt);
}

}  // namespace palpate::torque
