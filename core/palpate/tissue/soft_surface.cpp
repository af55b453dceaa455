#include "palpate/tissue/soft_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include "palpate/scene/smooth.hpp"
#include "palpate/types/index.hpp"

namespace palpate::tissue {
namespace {

constexpr double kFade = 0.1, kRamp = 0.3;  // [s] of the force to zero after a divergence, and back
constexpr double kPublish = 0.016;          // [s] shortest time between two published surfaces
constexpr double kMotion = 3e-3;            // [s] time constant of the velocity of a sphere
constexpr double kFastest = 0.5;            // [m/s] largest velocity that a sphere is taken to keep for a period
constexpr double kStalled = 0.05;           // [s] delay of the thread beside after which the force fades
constexpr double kSettle = 3e-3;            // [s] time constant of the share of the force that gives no energy
constexpr double kLongest = 0.05;           // [s] longest period

double checked_period(double period) {
  if (!(period >= 0.0 && period <= kLongest))
    throw std::invalid_argument("tissue: period = " + std::to_string(period) +
                                " s must be from 0 (in the cycle) to 0.05, for example 0.004");
  return period;
}

}  // namespace

SoftSurface::SoftSurface(const Body& body, double width, double period, std::uint64_t continues)
    : Surface(continues),
      tables_(std::make_shared<SoftTables>(body.data(), width)),
      period_(checked_period(period)),
      pressed_(body, tables_),
      mesh_(tables_->rest->movable()),
      shape_(pressed_.at_rest()),
      made_(shape_),
      shapes_(shape_),
      published_(shape_.vertices) {
  for (const PronyTerm& term : body.data().prony) instantaneous_ += term.g;
}

SoftSurface::SoftSurface(const SoftSurface& from, std::uint64_t id, double period)
    : Surface(id),
      tables_(from.tables_),
      period_(period),
      instantaneous_(from.instantaneous_),
      patient_(from.patient_),
      pressed_(from.body(), tables_),
      mesh_(tables_->rest->movable()),
      shape_(pressed_.at_rest()),
      made_(shape_),
      shapes_(shape_),
      published_(shape_.vertices) {}

std::shared_ptr<scene::Surface> SoftSurface::at_rest() const {
  return std::shared_ptr<SoftSurface>(new SoftSurface(*this, id(), period_));
}

std::shared_ptr<SoftSurface> SoftSurface::in_cycle() const {
  return std::shared_ptr<SoftSurface>(new SoftSurface(*this, id(), 0.0));
}

// The touched surface is X + K u between the vertices, with the roundness that it has at rest. A contact method may see
// it rounder, because a dent of a few facets looks round to it; the depth is corrected by the difference.
SoftSurface::Site SoftSurface::locate(const scene::SpherePlace& place) const noexcept {
  const scene::BvhHit hit = mesh_->impl().closest(place.p_OC, std::numeric_limits<double>::infinity(), -1);
  Site site{{hit.triangle, hit.v, hit.w}, place.depth};
  if (hit.triangle < 0) return site;
  const Vec3 facet = mesh_->impl().position(site.at), rest = tables_->rest->impl().position(site.at);
  const scene::SmoothPoint round = scene::smooth_at(tables_->rest->impl(), site.at, rest);
  const double height = round.found ? -round.distance : 0.0;
  const double higher = place.normal.dot(facet - place.p_OC) + height;
  site.depth = std::clamp(place.depth + higher, 0.5 * place.depth, 1.5 * place.depth);
  return site;
}

LocalLaw SoftSurface::law_at(const scene::SurfacePoint& at, double radius) const noexcept {
  const double b[3] = {at.u(), at.v, at.w};
  const DepthModuli::Felt felt = tables_->moduli.at(&tables_->rest->triangles()[to_index(3 * at.triangle)], at, radius);
  return {felt.pressed, radius, tables_->spreading.yield(at.triangle, b) / felt.spread, felt.growth};
}

/// Value of the local law, which also gives way for a body that steps less often than the cycle.
LocalLaw::Value SoftSurface::value_at(const Site& site, const LocalLaw& law, int sphere) const noexcept {
  if (period_ == 0.0) return law.at(site.depth);
  const auto begin = shape_.yield.begin(), end = begin + shape_.touches;
  const auto found = std::find_if(begin, end, [&](const Yield& y) { return y.sphere == sphere; });
  return found != end ? law.since(site.depth, found->length, found->energy) : law.since(site.depth, 0.0, 0.0);
}

/// Force of the Prony springs of the near field [N].
double SoftSurface::viscous_force(int sphere, double elastic) const noexcept {
  double sum = 0.0;
  const auto& terms = body().data().prony;
  for (std::size_t i = 0; i < terms.size() && sphere < kSpheres; ++i)
    sum += terms[i].g * (elastic - memory_[to_index(sphere)][i]);
  return sum;
}

scene::Response SoftSurface::respond(const scene::SpherePlace& at) const noexcept {
  scene::Response out;
  if (!(at.depth > 0.0)) return out;
  const Site site = locate(at);
  if (site.at.triangle < 0) return out;
  const LocalLaw::Value value = value_at(site, law_at(site.at, at.radius), at.sphere);
  const double share = share_ * passive_;
  const double force = share * std::max(value.force + viscous_force(at.sphere, value.force), 0.0);
  out.force = force;
  out.stiffness = force / at.depth;
  out.tangent = share * instantaneous_ * value.tangent;
  out.stored = share * value.stored;
  const double b[3] = {site.at.u(), site.at.v, site.at.w};
  for (int k = 0; k < 3; ++k)
    out.velocity += b[k] * Vec3(&shape_.velocity[3 * to_index(mesh_->triangles()[to_index(3 * site.at.triangle + k)])]);
  return out;
}

void SoftSurface::advance(std::span<const scene::SurfaceLoad> loads, double dt) noexcept {
  press_.dt = dt;
  press_.ticks = std::max(1, static_cast<int>(std::lround(period_ / dt)));
  take(loads);
  relax(dt);
  if (period_ > 0.0) {
    withhold(dt);
    exchange(dt);
  } else {
    pressed_.advance(press_, shape_);
    show();
  }
  ramp(dt);
  publish(dt);
}

void SoftSurface::remember(std::span<const scene::SurfaceLoad> loads, double dt) noexcept {
  press_.dt = dt;
  take(loads);
  relax(dt);
}

void SoftSurface::follow(const Shape& shape, double dt) noexcept {
  shape_ = shape;
  show();
  ramp(dt);
  publish(dt);
}

/// Rate at which a sphere moves against the normal, smoothed; 0 at a new contact.
double SoftSurface::approach(const scene::SpherePlace& at, double dt) noexcept {
  if (at.sphere >= kSpheres || period_ == 0.0) return 0.0;
  Motion& m = motion_[to_index(at.sphere)];
  const Vec3 p_OS = at.p_OC - at.depth * at.normal;  // up to the radius along the normal
  if (m.known) {
    const double rate = -at.normal.dot(p_OS - m.p_OS) / dt;
    m.rate += dt / (kMotion + dt) * (rate - m.rate);
  } else {
    m.rate = 0.0;
  }
  m.p_OS = p_OS;
  m.known = true;
  return std::clamp(m.rate, -kFastest, kFastest);
}

/// Adds up the energy that a sphere puts in, by the trapezoidal rule over the last tick.
void SoftSurface::observe(const scene::SurfaceLoad& load) noexcept {
  if (load.at.sphere >= kSpheres) return;
  Motion& m = motion_[to_index(load.at.sphere)];
  const Vec3 centre = load.at.p_OC + (load.at.radius - load.at.depth) * load.at.normal;
  if (m.known) given_ += 0.5 * (m.force + load.force).dot(centre - m.centre);
  m.centre = centre;
  m.force = load.force;
}

/// Chooses the share of the force of the next tick from the energies of this one.
void SoftSurface::withhold(double dt) noexcept {
  const double body = shape_.energy.potential, all = body + stored_;
  put_in_ -= given_;
  if (press_.touches == 0) put_in_ = std::min(put_in_, body + shape_.energy.kinetic);  // what was lost is not kept
  const bool limited = given_ > 0.0 && all > 0.0;
  const double goal = limited ? std::clamp(put_in_ / all, 0.0, 1.0) : 1.0;
  passive_ += dt / (kSettle + dt) * (goal - passive_);
}

/// Turns loads into touches.
void SoftSurface::take(std::span<const scene::SurfaceLoad> loads) noexcept {
  press_.touches = 0;
  given_ = stored_ = 0.0;
  std::array<bool, kSpheres> seen{};
  for (const scene::SurfaceLoad& load : loads) {
    const Site site = locate(load.at);
    if (site.at.triangle < 0 || press_.touches == kMaxTouches || !load.force.allFinite()) continue;
    Touch& touch = press_.touch[to_index(press_.touches)];
    touch.at = site.at;
    touch.law = law_at(site.at, load.at.radius);
    touch.sphere = load.at.sphere;
    touch.depth = site.depth;
    if (period_ > 0.0) observe(load);
    touch.approach = approach(load.at, press_.dt);
    if (touch.sphere < kSpheres) seen[to_index(touch.sphere)] = true;
    const LocalLaw::Value value = value_at(site, touch.law, touch.sphere);
    stored_ += value.stored;
    elastic_[to_index(press_.touches++)] = value.force;
    const double elastic = touch.law.at(touch.depth).force;
    touch.viscous = viscous_force(load.at.sphere, elastic) - elastic * (instantaneous_ - 1.0);
    touch.secant = touch.depth > 0.0 ? std::max(load.force.dot(load.at.normal), 0.0) / touch.depth : 0.0;
    touch.normal = load.at.normal;
    touch.force = load.force - load.at.normal * load.at.normal.dot(load.force);
  }
  for (std::size_t s = 0; s < seen.size(); ++s) motion_[s].known = seen[s];
}

/// Advances the viscous memory of the near fields; spheres without contact forget.
void SoftSurface::relax(double dt) noexcept {
  const auto& terms = body().data().prony;
  for (int s = 0; s < kSpheres && !terms.empty(); ++s) {
    double elastic = 0.0;
    for (int i = 0; i < press_.touches; ++i)
      if (press_.touch[to_index(i)].sphere == s) elastic = elastic_[to_index(i)];
    for (std::size_t i = 0; i < terms.size(); ++i) {
      double& q = memory_[to_index(s)][i];
      q += -std::expm1(-dt / terms[i].tau) * (elastic - q);
    }
  }
}

/// Hands over the contacts at the first tick of a period, and takes the shape at the last one, or later.
void SoftSurface::exchange(double dt) noexcept {
  if (!waiting_) {
    ++press_.number;
    presses_.write(press_);
    overdue_ = -press_.ticks * dt;
    waiting_ = true;
    if (patient_) handed_over_ = std::chrono::steady_clock::now();
  }
  overdue_ += dt;
  if (!beside_.load(std::memory_order_relaxed)) work();
  if (patient_ && std::abs(overdue_) < 0.5 * dt) wait_for_thread();
  late_ = overdue_ > 0.5 * dt;
  if (overdue_ < -0.5 * dt) return;
  const Shape& newest = shapes_.read();
  if (newest.number != press_.number) return;
  shape_ = newest;
  show();
  waiting_ = false;
}

/// In the tick in which a shape is due: takes part in its work, or waits for it, if the loop is ahead of real time.
void SoftSurface::wait_for_thread() noexcept {
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - handed_over_;
  if (elapsed.count() > 0.5 * period_) return;
  while (shapes_.read().number != press_.number)
    if (!work()) std::this_thread::yield();
}

bool SoftSurface::work() noexcept {
  if (working_.exchange(true, std::memory_order_acquire)) return false;
  const Press& press = presses_.read();
  const bool fresh = press.number != made_.number;
  if (fresh) {
    pressed_.advance(press, made_);
    shapes_.write(made_);
  }
  working_.store(false, std::memory_order_release);
  return fresh;
}

/// Moves the touched surface.
void SoftSurface::show() noexcept { mesh_->move(shape_.vertices); }

/// Removes the force while the body stands still or its thread is stalled, and restores it afterwards.
void SoftSurface::ramp(double dt) noexcept {
  const bool stalled = late_ && overdue_ > kStalled;
  share_ = shape_.still || stalled ? std::max(share_ - dt / kFade, 0.0) : std::min(share_ + dt / kRamp, 1.0);
  press_.share = share_ * passive_;
  frozen_ = shape_.still || (frozen_ && share_ < 1.0);
}

void SoftSurface::publish(double dt) noexcept {
  unpublished_ += dt;
  if (unpublished_ < kPublish) return;
  unpublished_ = 0.0;
  published_.write(shape_.vertices);
}

scene::DeformableState SoftSurface::state() const noexcept {
  return {shape_.energy.potential, shape_.energy.kinetic, shape_.hurried, frozen_, late_};
}

}  // namespace palpate::tissue
