// Stiffness control with gravity compensation (Eq 13): the rendered force and nothing else. The paper's law.
#include "palpate/torque/law.hpp"

namespace palpate::torque {
namespace {

class Stiffness final : public Law {
 public:
  Wrench step(const LawInput& /*in*/) noexcept override { return {}; }
  /// Eq 9 without its first two terms: that is what "slow motion" (section 2.4) leaves out.
  [[nodiscard]] Vec3 neglected(const LawInput& in, const Vec3& a) const noexcept override {
    return inertia(in, a).f + in.Gamma_v.f;
  }
};

}  // namespace

std::unique_ptr<Law> make_stiffness(const LawOptions& /*options*/, double /*dt*/) {
  return std::make_unique<Stiffness>();
}

}  // namespace palpate::torque
