#include "palpate/network/palpation.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/types/require.hpp"

namespace palpate::network {
namespace {

constexpr double kNoticed = 0.2;  // share of the wanted force that is noticed as contact

}  // namespace

Palpation::Palpation(const PalpationOptions& options) : options_(options), aim_(Vec3::Zero()) {
  require("palpation", !options.places.empty(), "places", 0.0, "must be at least one");
  require("palpation", options.force > 0.0, "force", options.force, "must be above 0 N");
  require("palpation", options.speed > 0.0, "speed", options.speed, "must be above 0 m/s");
  require("palpation", options.approach > 0.0, "approach", options.approach, "must be above 0 m/s");
  aim_ = options.places.front();
}

// Moves the aim to a goal; true once it is there.
bool Palpation::approach(const Vec3& goal, double most) noexcept {
  const Vec3 away = goal - aim_;
  const double distance = away.norm();
  aim_ += distance > most ? Vec3(away * (most / distance)) : away;
  return distance <= most;
}

double Palpation::felt_then(double force, double dt) {
  if (felt_.empty()) felt_.assign(std::max<std::size_t>(1, static_cast<std::size_t>(options_.reaction / dt)), 0.0);
  const double then = felt_[next_];
  felt_[next_] = force;
  next_ = (next_ + 1) % felt_.size();
  return then;
}

const Vec3& Palpation::step(const Vec3& F, bool linked, double dt) {
  const double force = felt_then(F.norm(), dt);
  if (done()) return aim_;
  const Vec3& place = options_.places[place_];
  if (!linked && phase_ != Phase::up) phase_ = Phase::move;
  switch (phase_) {
    case Phase::move:
      if (approach(place, options_.speed * dt) && linked) phase_ = Phase::down;
      break;
    case Phase::down:
      aim_.z() -= options_.approach * dt;
      held_ = 0.0;
      if (force > kNoticed * options_.force) phase_ = Phase::press;
      break;
    case Phase::press: {
      const double lacks = options_.force - force;
      aim_.z() -= std::clamp(options_.gain * lacks, -options_.approach, options_.approach) * dt;
      held_ = std::abs(lacks) <= options_.within * options_.force ? held_ + dt : 0.0;
      if (held_ >= options_.hold) phase_ = Phase::up;
      break;
    }
    case Phase::up:
      if (!approach(place, options_.speed * dt)) break;
      ++place_;
      phase_ = Phase::move;
      break;
  }
  return aim_;
}

}  // namespace palpate::network
