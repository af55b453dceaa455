#include "palpate/network/unknown.hpp"

#include <memory>

#include "palpate/scene/primitives.hpp"
#include "palpate/types/so3.hpp"

namespace palpate::network {
namespace {

constexpr double kTouched = 0.1;  // [N] force that is no noise
constexpr int kTicks = 5;         // for which it lasts before a plane begins
constexpr double kAlong = 5e-4;   // [m] standard deviation of the first place along the normal
constexpr double kTilt = 0.25;    // [rad] of the first normal, which is the direction of the force
constexpr double kBends = 0.1;    // [rad^2/m] variance of the tilt per motion along the surface
constexpr double kSags = 2e-7;    // [m^2/m] variance of the place per motion along the surface

}  // namespace

scene::Object Unknown::object(const EstimatorOptions& options) {
  scene::Object out;
  out.name = "unknown surface";
  out.surface = std::make_shared<scene::Sphere>(kRound);
  out.material.K.setConstant(options.K);
  return out;
}

void Unknown::seek(const Vec3& p, const Vec3& F, bool known, scene::Object& object, Estimator& estimator,
                   Copies& copies) noexcept {
  if (exists_ && (p - touched_).norm() > kPlaneReach) exists_ = false;
  const double force = F.norm();
  felt_ = !exists_ && !known && force > kTouched ? felt_ + 1 : 0;
  if (felt_ < kTicks) return;
  exists_ = true;
  felt_ = 0;
  touched_ = last_ = p;
  EstimatorOptions o = options_;
  o.normal = F / force;
  o.sd_K = o.K;
  o.sd_along = kAlong;
  o.sd_place = kTilt * kRound;
  estimator = Estimator(o);
  object.X_WO.p = p - (kRound + radius_ - force / o.K) * o.normal;
  copies.place(object.X_WO.p);
  copies.reset();
}

void Unknown::follow(const Vec3& p, const Vec3& F, scene::Object& object, Estimator& estimator,
                     Copies& copies) noexcept {
  const Vec3 shift = estimator.recentre(), before = p - object.X_WO.p;
  const double distance = before.norm();
  const Vec3 normal = before / distance;
  const double along = shift.dot(normal);
  const Vec3 after = (before - (shift - along * normal)).normalized();
  object.X_WO.p = p - (distance - along) * after;
  estimator.turn(rotation_between(normal, after));
  copies.place(object.X_WO.p);
  exists_ = estimator.moved() == 0;  // another surface: it begins anew
  if (F.norm() < kTouched) return;
  touched_ = p;
  const Vec3 moved = p - last_;
  const double aside = (moved - after * after.dot(moved)).norm();
  last_ = p;
  estimator.wander(kSags * aside, kBends * kRound * kRound * aside);
}

void Unknown::describe(ModelEstimate& estimate, const scene::Object& object) const noexcept {
  estimate.normal = (last_ - object.X_WO.p).normalized();
  estimate.shift = object.X_WO.p + kRound * estimate.normal;
}

}  // namespace palpate::network
