#include "palpate/network/model_update.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/types/require.hpp"

namespace palpate::network {
namespace {

constexpr int kHalvings = 12;  // of a step that is not allowed
constexpr double kLag = 0.02;  // [s] time constant of parameters that no limit holds back

double energy(double K, double depth) noexcept { return depth > 0.0 ? 0.5 * K * depth * depth : 0.0; }

}  // namespace

ModelUpdate::ModelUpdate(const UpdateOptions& options, const ModelEstimate& now)
    : options_(options), now_(now), tank_(options.tank) {
  require("remote", options.tank >= 0.0, "tank", options.tank, "must be 0 J or more");
  require("remote", options.capacity >= options.tank, "capacity", options.capacity, "must not be below the tank [J]");
  require("remote", options.force_rate > 0.0, "force_rate", options.force_rate, "must be above 0 N/s");
}

const ModelEstimate& ModelUpdate::step(const ModelEstimate& goal, const Held& held, double dt) noexcept {
  tank_ = std::min(tank_ + std::max(held.dissipated, 0.0), options_.capacity);
  const double share = dt / (kLag + dt);
  now_.mu += share * (goal.mu - now_.mu);
  now_.B += share * (goal.B - now_.B);
  now_.sd_K = goal.sd_K;
  now_.sd_shift = goal.sd_shift;
  now_.margin = goal.margin;
  const bool sure = goal.K > 0.0 && goal.sd_K < options_.least_sure * goal.K;
  Vec3 ds = share * (goal.shift - now_.shift);
  if (const double most = options_.speed * dt; ds.norm() > most) ds *= most / ds.norm();
  double dK = sure ? share * (goal.K - now_.K) : 0.0, part = 1.0;
  const double U = energy(now_.K, held.depth), F = now_.K * std::max(held.depth, 0.0);
  for (int i = 0; i < kHalvings; ++i, part *= 0.5) {
    const double depth = held.depth + part * ds.dot(held.normal), K = now_.K + part * dK;
    const double dU = energy(K, depth) - U, dF = K * std::max(depth, 0.0) - F;
    if (std::abs(dF) > options_.force_rate * dt || dU > tank_) continue;
    now_.shift += part * ds;
    now_.K = K;
    tank_ = std::min(tank_ - dU, options_.capacity);
    paid_ += dU;
    break;
  }
  return now_;
}

}  // namespace palpate::network
