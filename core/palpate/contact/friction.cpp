#include "palpate/contact/friction.hpp"

#include <algorithm>

namespace palpate::contact {

Vec3 Friction::step(const Vec3& p, const Vec3& normal, double depth, double mu, double mu_static) noexcept {
  if (!touching_) {
    touching_ = true;
    slipping_ = false;
    anchor_ = p;
  }
  Vec3 lag = anchor_ - p;
  lag -= normal * normal.dot(lag);
  const double length = lag.norm();
  const double mu_stick = std::max(mu, mu_static), mu_restick = std::max(mu - 0.5 * (mu_stick - mu), 0.5 * mu);
  slipping_ = slipping_ ? length >= mu_restick * depth : length > mu_stick * depth;
  if (slipping_ && length > mu * depth) lag *= mu * depth / length;
  anchor_ = p + lag;
  return lag;
}

}  // namespace palpate::contact
