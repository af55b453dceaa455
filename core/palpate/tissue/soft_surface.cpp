#include "palpate/tissue/soft_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include "palpate/types/index.hpp"

namespace palpate::tissue {
namespace {

constexpr double kFade = 0.1, kRamp = 0.3;  // [s] of the force to zero after a divergence, and back
constexpr double kPublish = 0.016;          // [s] shortest time between two published surfaces
constexpr double kMotion = 3e-3;            // [s] time constant of the velocity of a sphere
constexpr double kFastest = 0.5;            // [m/s] largest velocity that a sphere is taken to keep for a period
constexpr double kStalled = 0.05;           // [s] delay of the thread beside after which the force fades
constexpr double kSettle = 3e-3;            // [s] time constant of the share of the force that gives no energy
constexpr double kMostBridge = 4.0;         // of the force of one shape over that of the next
constexpr double kResting = 1e-9;           // [m] a shorter motion in a tick is rounding
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
      seen_(tables_->rest->triangles().size() / 3, 0),
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
      seen_(tables_->rest->triangles().size() / 3, 0),
      published_(shape_.vertices) {}

std::shared_ptr<scene::Surface> SoftSurface::at_rest() const {
  return std::shared_ptr<SoftSurface>(new SoftSurface(*this, id(), period_));
}

std::shared_ptr<SoftSurface> SoftSurface::in_cycle() const {
  return std::shared_ptr<SoftSurface>(new SoftSurface(*this, id(), 0.0));
}

/// Where a sphere meets the surface as it is.
const SoftSurface::Met& SoftSurface::meet(const scene::SpherePlace& place) const noexcept {
  const Vec3 centre = place.p_OC + (place.radius - place.depth) * place.normal;
  const double same = 1e-9 * place.radius;
  for (const Met& met : met_)
    if (met.found && met.radius == place.radius && (met.centre - centre).cwiseAbs().maxCoeff() < same) return met;
  Met& met = met_[next_met_];
  next_met_ = (next_met_ + 1) % kMet;
  met.found = true;
  met.centre = centre;
  met.radius = place.radius;
  const scene::BvhHit hit = mesh_->impl().closest(place.p_OC, std::numeric_limits<double>::infinity(), -1);
  met.at = {};
  if (hit.triangle < 0) return met;
  const bool before = place.sphere >= 0 && place.sphere < kSpheres && motion_[to_index(place.sphere)].known;
  const Motion* const last = before ? &motion_[to_index(place.sphere)] : nullptr;
  // The point of the proxy can lie on another side of the body than the dent that the sphere has made.
  const double any = std::numeric_limits<double>::infinity();
  const std::array starts{hit.triangle, last != nullptr ? last->heaviest : -1,
                          mesh_->impl().closest(centre, any, hit.triangle).triangle};
  met.patch.gather(*tables_, mesh_->impl(), centre, place.radius, last != nullptr ? last->axis : place.normal, starts,
                   seen_, ++round_);
  if (period_ > 0.0) met.patch.turn_with_triangles();
  for (int k = 0; k < met.patch.vertices(); ++k)
    x_[to_index(k)] = Vec3(&mesh_->impl().vertices[3 * to_index(met.patch.vertex(k))]);
  met.at = met.patch.meet(*tables_, centre, x_.data(), pull_.data(), met.share.data());
  met.law = law_of(met);
  return met;
}

LocalLaw SoftSurface::law_of(const Met& met) const noexcept {
  const DepthModuli::Felt felt = tables_->moduli.at(met.patch.all(), met.share.data(), met.radius);
  const double yield = Spreading::widened(met.at.yield, tables_->edge, std::sqrt(kSoftness) * met.radius);
  return {felt.pressed, met.radius, yield / felt.spread, felt.growth};
}

/// Value of the local law, which also gives way for a body that steps less often than the cycle.
LocalLaw::Value SoftSurface::value_of(const Met& met, int sphere) const noexcept {
  if (period_ == 0.0) return met.law.at(met.at.depth);
  const auto begin = shape_.yield.begin(), end = begin + shape_.touches;
  const auto found = std::find_if(begin, end, [&](const Yield& y) { return y.sphere == sphere; });
  return found != end ? met.law.since(met.at.depth, found->length, found->energy)
                      : met.law.since(met.at.depth, 0.0, 0.0);
}

/// Force of the Prony springs of the near field [N].
double SoftSurface::viscous_force(int sphere, double elastic) const noexcept {
  double sum = 0.0;
  const auto& terms = body().data().prony;
  for (std::size_t i = 0; i < terms.size() && sphere >= 0 && sphere < kSpheres; ++i)
    sum += terms[i].g * (elastic - memory_[to_index(sphere)][i]);
  return sum;
}

scene::Response SoftSurface::respond(const scene::SpherePlace& at) const noexcept {
  scene::Response out;
  const Met& met = meet(at);
  if (!(met.at.depth > 0.0)) return out;
  const LocalLaw::Value value = value_of(met, at.sphere);
  const bool bridged = at.sphere >= 0 && at.sphere < kSpheres && motion_[to_index(at.sphere)].known;
  const double share = share_ * passive_ * (bridged ? motion_[to_index(at.sphere)].bridge : 1.0),
               slope = met.at.push.norm();
  const double force = share * slope * std::max(value.force + viscous_force(at.sphere, value.force), 0.0);
  out.depth = met.at.depth;
  out.normal = met.at.push / slope;
  if (bridged) out.normal = (out.normal + motion_[to_index(at.sphere)].turn).normalized();
  if (bridged) out.carries = motion_[to_index(at.sphere)].carries, out.carried = motion_[to_index(at.sphere)].carried;
  out.force = force;
  out.stiffness = force / met.at.depth;
  out.tangent = share * slope * slope * instantaneous_ * value.tangent;
  out.stored = share * value.stored;
  for (int k = 0; k < met.patch.vertices(); ++k)
    out.velocity += met.share[to_index(k)] * Vec3(&shape_.velocity[3 * to_index(met.patch.vertex(k))]);
  return out;
}

Vec3 SoftSurface::velocity(const Vec3& p) const noexcept {
  const scene::BvhHit hit = mesh_->impl().closest(p, std::numeric_limits<double>::infinity(), -1);
  Vec3 out = Vec3::Zero();
  if (hit.triangle < 0) return out;
  const double b[3] = {1.0 - hit.v - hit.w, hit.v, hit.w};
  for (int k = 0; k < 3; ++k)
    out += b[k] * Vec3(&shape_.velocity[3 * to_index(mesh_->triangles()[to_index(3 * hit.triangle + k)])]);
  return out;
}

void SoftSurface::advance(std::span<const scene::SurfaceLoad> loads, double dt) noexcept {
  press_.dt = dt;
  press_.ticks = std::max(1, static_cast<int>(std::lround(period_ / dt)));
  take(loads);
  relax(dt);
  if (period_ > 0.0) {
    withhold(dt);
    for (Motion& m : motion_) {
      const double step = 1.0 / std::max(m.bridging--, 1);
      m.bridge += step * (1.0 - m.bridge);
      m.turn *= 1.0 - step;
      m.carries = false;
    }
    if (exchange(dt)) {
      bridge(loads);
      carry();
    }
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

/// Takes the motion of a sphere: its velocity, smoothed, and the energy that it puts in, by the trapezoidal rule over
/// the last tick.
void SoftSurface::observe(const scene::SurfaceLoad& load, const Met& met, Touch& touch) noexcept {
  if (touch.sphere < 0 || touch.sphere >= kSpheres) return;
  Motion& m = motion_[to_index(touch.sphere)];
  if (m.known) {
    Vec3 moved = met.centre - m.centre;
    if (moved.cwiseAbs().maxCoeff() < kResting) moved.setZero();
    given_ += 0.5 * (m.force + load.force).dot(moved);
    m.velocity += press_.dt / (kMotion + press_.dt) * (moved / press_.dt - m.velocity);
  } else {
    m.velocity.setZero();
    m.bridge = 1.0;
    m.turn.setZero();
  }
  m.centre = met.centre;
  m.force = load.force;
  m.axis = met.patch.axis();
  m.heaviest = met.patch.heaviest(met.share.data());
  const double speed = m.velocity.norm();
  if (period_ > 0.0) touch.velocity = speed > kFastest ? Vec3(kFastest / speed * m.velocity) : m.velocity;
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
    const Met& met = meet(load.at);
    if (!(met.at.depth > 0.0) || press_.touches == kMaxTouches || !load.force.allFinite()) continue;
    Touch& touch = press_.touch[to_index(press_.touches)];
    touch.patch = met.patch;
    touch.law = met.law;
    touch.sphere = load.at.sphere;
    touch.centre = met.centre;
    touch.velocity.setZero();
    observe(load, met, touch);
    if (touch.sphere < kSpheres) seen[to_index(touch.sphere)] = true;
    const LocalLaw::Value value = value_of(met, touch.sphere);
    stored_ += value.stored;
    touch.normal = met.at.push.normalized();
    if (touch.sphere >= 0 && touch.sphere < kSpheres) {
      motion_[to_index(touch.sphere)].felt = met.at.push.norm() * value.force;
      motion_[to_index(touch.sphere)].normal = touch.normal;
    }
    elastic_[to_index(press_.touches++)] = value.force;
    const double elastic = touch.law.at(met.at.depth).force;
    touch.viscous = viscous_force(load.at.sphere, elastic) - elastic * (instantaneous_ - 1.0);
    const scene::Response felt = respond(load.at);
    touch.secant = felt.stiffness;
    touch.force = load.force + load.force_to_come - felt.force * felt.normal;
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
bool SoftSurface::exchange(double dt) noexcept {
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
  if (overdue_ < -0.5 * dt) return false;
  const Shape& newest = shapes_.read();
  if (newest.number != press_.number) return false;
  shape_ = newest;
  show();
  waiting_ = false;
  return true;
}

/// Leads the force of each sphere, with its direction, over from the shape before to the new one within a period.
void SoftSurface::bridge(std::span<const scene::SurfaceLoad> loads) noexcept {
  for (const scene::SurfaceLoad& load : loads) {
    if (load.at.sphere < 0 || load.at.sphere >= kSpheres) continue;
    Motion& m = motion_[to_index(load.at.sphere)];
    const Met& met = meet(load.at);
    const double now = met.at.push.norm() * value_of(met, load.at.sphere).force;
    const bool leads = m.known && now > 0.0;
    m.bridge = leads ? std::clamp(m.bridge * m.felt / now, 0.0, kMostBridge) : 1.0;
    m.turn = leads ? Vec3((m.normal + m.turn).normalized() - met.at.push.normalized()) : Vec3::Zero();
    m.bridging = press_.ticks;
  }
}

/// Takes the motion of the surface under each sphere to the new shape. It is the one by which the body's own step has
/// changed the friction: that of another point would answer as a spring that acts a period late, and swing.
void SoftSurface::carry() noexcept {
  for (int i = 0; i < shape_.touches; ++i) {
    const Yield& y = shape_.yield[to_index(i)];
    if (y.sphere < 0 || y.sphere >= kSpheres) continue;
    motion_[to_index(y.sphere)].carries = true;
    motion_[to_index(y.sphere)].carried = y.moved;
  }
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
void SoftSurface::show() noexcept {
  mesh_->move(shape_.vertices);
  for (Met& met : met_) met.found = false;
}

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
