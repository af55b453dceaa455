#include "palpate/network/instrument.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "palpate/force/force.hpp"
#include "palpate/types/low_pass.hpp"
#include "palpate/types/random.hpp"
#include "palpate/types/require.hpp"

namespace palpate::network {
namespace {

constexpr double kLagCutoff = 10.0;  // [Hz] cutoff of the force that the servo compensates

}  // namespace

Instrument::Instrument(const InstrumentOptions& options, double radius, scene::Snapshot world, std::uint64_t seed)
    : options_(options), world_(std::move(world)), contact_("proxy", {.radius = radius}), random_(seed) {
  require("instrument", options.mass > 0.0, "mass", options.mass, "must be above 0 kg");
  require("instrument", options.bandwidth > 0.0, "bandwidth", options.bandwidth, "must be above 0 Hz");
  require("instrument", options.substeps >= 1, "substeps", options.substeps, "must be at least 1");
}

void Instrument::step(const SiteGoal& goal, double t, double dt) noexcept {
  const double h = dt / options_.substeps, w = 2.0 * std::numbers::pi * options_.bandwidth, m = options_.mass;
  const double lag = low_pass_coefficient(kLagCutoff, h);
  goal_ = goal;
  for (int i = 0; i < options_.substeps; ++i) {
    const double left = dt - i * h;  // the goal moves through the tick at its velocity
    const Vec3 at = goal.X.p - goal.v * left;
    Vec3 drive = m * (w * w * (at - x_) + 2.0 * w * (goal.v - v_)) - lagging_;
    if (drive.norm() > options_.drive_cap) drive *= options_.drive_cap / drive.norm();
    v_ += h / m * (drive + F_);
    const Vec3 dx = h * v_;
    x_ += dx;
    const ContactSet& contacts = contact_.step(world_, &x_, t + (i + 1) * h);
    const Vec3 F = force::step(contacts, {v_, Vec3::Zero()}, 1.0, 1.0).F;
    work_ -= 0.5 * (F + F_).dot(dx);
    F_ = F;
    lagging_ += lag * (F_ - lagging_);
    largest_ = std::max(largest_, F_.norm());
  }
}

SiteInput Instrument::measure(double t) noexcept {
  SiteInput out;
  out.t = t;
  out.X = goal_.X;
  const double q = options_.quantum;
  out.X.p = q > 0.0 ? Vec3(q * (x_ / q).array().round().matrix()) : x_;
  out.v = v_;
  out.jaw = goal_.jaw;
  out.F = F_;
  if (options_.noise > 0.0) out.F += options_.noise * Vec3(gauss(random_), gauss(random_), gauss(random_));
  return out;
}

}  // namespace palpate::network
