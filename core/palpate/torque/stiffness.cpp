// Stiffness control with gravity compensation (Eq 13), the control law of the paper: only the rendered force.
#include "palpate/torque/law.hpp"

namespace palpate::torque {
namespace {

class Stiffness final : public ControlLaw {
 public:
  Wrench step(const ControlLawInput& /*in*/) noexcept override { return {}; }
  /// The first two terms of Eq 9 (inertia and Coriolis forces), which the assumption of slow motion (section 2.4)
  /// neglects.
  [[nodiscard]] Vec3 neglected_force(const ControlLawInput& in, const Vec3& a) const noexcept override {
    return inertia(in, a).f + in.Gamma_v.f;
  }
};

}  // namespace

std::unique_ptr<ControlLaw> make_stiffness(const ControlLawOptions& /*options*/, double /*dt*/) {
  return std::make_unique<Stiffness>();
}

}  // namespace palpate::torque
