#include "palpate/scene/material.hpp"

#include <algorithm>

namespace palpate::scene {

double Region::weight(const Vec3& p_O, Vec3& slope) const noexcept {
  slope.setZero();
  const Vec3 from = p_O - centre;
  const Vec3 off = from - from.cwiseMax(-half).cwiseMin(half);  // vector from the nearest point of the box
  const double length = off.norm(), x = std::clamp((length - radius) / blend, 0.0, 1.0);
  if (length > 0.0) slope = -6.0 * x * (1.0 - x) / (blend * length) * off;
  return 1.0 - x * x * (3.0 - 2.0 * x);
}

void LocalMaterial::blend(const Region& region, const Vec3& p_O) noexcept {
  Vec3 slope;
  const double w = region.weight(p_O, slope);
  if (w == 0.0) return;
  const Material& to = region.material;
  dK = (1.0 - w) * dK + (to.K - material.K) * slope.transpose();
  material.K += w * (to.K - material.K);
  material.B += w * (to.B - material.B);
  const double held = std::max(material.mu, material.mu_static), held_to = std::max(to.mu, to.mu_static);
  material.mu += w * (to.mu - material.mu);
  material.mu_static = held + w * (held_to - held);
}

}  // namespace palpate::scene
