// Impedance control (Eqs 2-5 and 9): compensates Coriolis forces and, if shape_inertia is set, shapes the inertia of
// the handle.
//
//   Lambda a + Gamma v + eta = F_motors + F_hand,   desired: m a = F_H + F_hand   (shape_inertia), or Lambda a = ...
//   =>  F_motors = F_H + Gamma v + eta  [+ (Lambda / m - 1)(F_H + F_hand)]
//
// The term eta is tau_gravity. Reducing the felt inertia below that of the arm requires the measured force of the hand.
#include "palpate/torque/law.hpp"

namespace palpate::torque {
namespace {

class Impedance final : public ControlLaw {
 public:
  explicit Impedance(const ControlLawOptions& options) : options_(options) {}

  Wrench step(const ControlLawInput& in) noexcept override {
    if (!options_.shape_inertia) return in.Gamma_v;
    const Vec3 F = in.F_H_L + in.F_hand_L;
    return in.Gamma_v + inertia(in, F / options_.virtual_mass) - Wrench{F, Vec3::Zero()};
  }

  [[nodiscard]] bool needs_load_cell() const noexcept override { return options_.shape_inertia; }
  [[nodiscard]] bool removes_friction() const noexcept override { return options_.shape_inertia; }
  [[nodiscard]] Vec3 neglected_force(const ControlLawInput& in, const Vec3& a) const noexcept override {
    return options_.shape_inertia ? Vec3(Vec3::Zero()) : inertia(in, a).f;
  }

 private:
  ControlLawOptions options_;
};

}  // namespace

std::unique_ptr<ControlLaw> make_impedance(const ControlLawOptions& options, double /*dt*/) {
  return std::make_unique<Impedance>(options);
}

}  // namespace palpate::torque
