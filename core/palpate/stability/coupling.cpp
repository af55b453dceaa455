#include "palpate/stability/coupling.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

namespace palpate::stability {

Coupling::Coupling(const CouplingOptions& options, double dt) : options_(options), dt_(dt) {
  if (!(options.stiffness >= 0.0 && std::isfinite(options.stiffness))) {
    throw std::invalid_argument("stability.coupling_stiffness = " + std::to_string(options.stiffness) +
                                ": must be 0 N/m (none) or more, and finite");
  }
  if (!(options.damping >= 0.0 && std::isfinite(options.damping))) {
    throw std::invalid_argument("stability.coupling_damping = " + std::to_string(options.damping) +
                                ": must be 0 N s/m or more, and finite");
  }
}

Wrench Coupling::step(const Wrench& F, double K) noexcept {
  if (options_.stiffness == 0.0) return F;
  const double both = options_.stiffness + K;
  const double kept = options_.damping > 0.0 ? std::exp(-both * dt_ / options_.damping) : 0.0;
  y_ = F.f / both + kept * (y_ - F.f / both);
  const double size = F.f.squaredNorm();
  const double share = size > 0.0 ? std::max(1.0 - K * F.f.dot(y_) / size, 0.0) : 1.0;
  return {share > 0.0 ? Vec3(F.f - K * y_) : Vec3(Vec3::Zero()), share * F.t};
}

double Coupling::lag(double K) const noexcept {
  if (options_.stiffness == 0.0) return 0.0;
  return -K * options_.damping / (options_.stiffness * (K + options_.stiffness));
}

}  // namespace palpate::stability
