#include "palpate/network/operator.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "palpate/force/force.hpp"
#include "palpate/network/estimator.hpp"
#include "palpate/stability/ledger.hpp"

namespace palpate::network {
namespace {

constexpr double kNothing = 0.03;  // [N] smaller wanted forces are not felt

ModelEstimate as_given(const scene::Object& object) {
  ModelEstimate out;
  out.K = object.material.K.mean();
  out.B = object.material.B.mean();
  out.mu = object.material.mu;
  return out;
}

// The scene, and the plane if it is wanted.
scene::Snapshot with_plane(scene::Snapshot scene, bool planes) {
  if (planes) scene.objects.push_back(LocalPlane::object());
  return scene;
}

}  // namespace

LocalModel::LocalModel(const UpdateOptions& options, scene::Snapshot scene, bool planes)
    : planes_(planes), given_(with_plane(std::move(scene), planes)), shown_(given_), plane_(options.force_rate) {
  for (const scene::Object& object : given_.objects) {
    goals_.push_back(as_given(object));
    updates_.emplace_back(options, goals_.back());
    rubbing_.emplace_back();
  }
  if (!planes) return;
  UpdateOptions of_shift = options;
  of_shift.force_rate *= LocalPlane::kShiftShare;
  updates_.back() = ModelUpdate(of_shift, goals_.back());
}

void LocalModel::take(const ModelEstimate& estimate) noexcept {
  if (estimate.object < goals_.size()) goals_[estimate.object] = estimate;
}

void LocalModel::synchronise(double ahead) noexcept {
  for (std::size_t i = 0; i < shown_.objects.size(); ++i) {
    shown_.objects[i].motion.t0 = given_.objects[i].motion.t0 - ahead;
  }
}

// Energy that friction has dissipated so far: the work of the tool against the force across the normal, less what its
// spring keeps. It is paid out where it has never been higher, so that no rocking of the spring pays; most: what
// Coulomb's law allows in this tick.
double LocalModel::Rubbing::step(const Vec3& across, const Vec3& v, double K, double most, double dt) noexcept {
  const double kept = across.squaredNorm() / (2.0 * K);
  total += -across.dot(v) * dt - (kept - kept_before);
  kept_before = kept;
  const double paid = std::clamp(total - highest, 0.0, most);
  highest = std::max(highest, total);
  return paid;
}

void LocalModel::step(const Vec3& p, const Vec3& v, const Vec3& F, double radius, double t, double dt) noexcept {
  for (std::size_t i = 0; i < updates_.size(); ++i) {
    scene::Object& object = shown_.objects[i];
    ModelEstimate goal = goals_[i];
    if (is_plane(i)) plane_.aim(p, F, radius, updates_[i].now().shift, dt, object, goal);
    const Pose X_WO = object.pose(t);
    const Vec3 p_O = X_WO.inverse() * p;
    const scene::Nearest c = object.surface->nearest(p_O);
    Held held{radius - signed_distance(c, p_O), X_WO.R * c.normal, 0.0};
    const ModelEstimate before = updates_[i].now();
    if (held.depth > 0.0) {
      const Vec3 relative = v - object.motion.velocity(p, t);
      const double along = held.normal.dot(relative);
      const Vec3 across = F - F.dot(held.normal) * held.normal;
      const double most = before.mu * before.K * held.depth * (relative - along * held.normal).norm() * dt;
      held.dissipated = before.B * along * along * dt + rubbing_[i].step(across, relative, before.K, most, dt);
    } else {
      rubbing_[i] = {};
    }
    const ModelEstimate& now = updates_[i].step(goal, held, dt);
    const Vec3 place = object.X_WO.p;
    object.X_WO.p = is_plane(i) ? Vec3(place + now.shift - before.shift) : Vec3(given_.objects[i].X_WO.p + now.shift);
    object.correction = object.X_WO.p - place;
    object.material.K = given_.objects[i].material.K * (now.K / given_.objects[i].material.K.mean());
    // A spring whose force is held for a tick gives energy away as a damping of -K dt / 2 would: this takes it back.
    object.material.B.setConstant(now.B + 0.5 * now.K * dt);
    object.material.mu = object.material.mu_static = now.mu;
  }
}

ModelEstimate LocalModel::rendered(std::size_t i) const noexcept {
  ModelEstimate out = updates_[i].now();
  if (is_plane(i) && !goals_[i].normal.isZero(0.0)) {
    out.shift = shown_.objects[i].X_WO.p;
    out.normal = shown_.objects[i].X_WO.R.col(2);
  }
  return out;
}

Operator::Operator(const OperatorOptions& options, scene::Snapshot scene)
    : options_(options),
      model_(options.update, std::move(scene), options.planes),
      contact_("proxy", {.radius = options.radius}),
      stability_(options.stability, 1.0 / options.rate) {}

void Operator::receive(const Datagram& d, double now) noexcept {
  if (peer_.receive(d, now)) model_.take(d.model);
}

const Vec3& Operator::step(const HandInput& in) noexcept {
  peer_.step(in.t);
  port_.step(F_, in.p);  // by the force that was rendered until now
  stability::Input wanted = options_.mode == Mode::model ? of_model(in) : of_force();
  free_ = wanted.commanded.F.f.norm() < kNothing;
  link();
  wanted.t = in.t;
  static_cast<Sample&>(wanted.handle) = {in.t, true};
  wanted.handle.X_LH.p = in.p;
  wanted.handle.V_LH.v = in.v;
  wanted.tool = {in.t, true};
  wanted.engaged = linked_ && in.engaged;
  F_ = stability_.step(wanted).F_H_L.f;
  if (options_.mode == Mode::passivity) {
    F_ = port_.affordable(F_, in.v, peer_.newest().energy_in, 1.0 / options_.rate);
    if (wanted.engaged) F_ -= options_.drag * in.v;
  }
  stability_.rendered({F_, Vec3::Zero()});
  in_ = in;
  return F_;
}

// The hand is let go once an outage has lasted, and taken again where it feels nothing and the site is aligned: a force
// that came back inside a surface would push the hand out with energy that it never put in.
void Operator::link() noexcept {
  const bool aligned = peer_.known() && (peer_.newest().flags & kAligned) != 0;
  linked_ = peer_.known() && !peer_.lost() && (linked_ || (aligned && free_));
}

stability::Input Operator::of_model(const HandInput& in) noexcept {
  const double dt = 1.0 / options_.rate, t = peer_.peer_time(in.t) + peer_.newest().play_delay;
  model_.step(in.p, in.v, F_contact_, options_.radius, t, dt);
  const ContactSet& contacts = contact_.step(model_.scene(), &in.p, t);
  const force::ForceTerms terms = force::step(contacts, {in.v, Vec3::Zero()}, 1.0, 1.0);
  F_contact_ = terms.F;
  stability::Input out;
  out.commanded.F.f = terms.F;
  out.stiffness = stability::stiffness_along(terms.F, contacts, 1.0);
  out.potential = out.present_potential = stability::spring_energy(contacts, 1.0);
  for (int i = 0; i < contacts.size; ++i) {
    const auto k = static_cast<std::size_t>(i);
    out.power += terms.F_contact[k].f.dot(contacts.contact[k].v_surface);
  }
  return out;
}

stability::Input Operator::of_force() const noexcept {
  stability::Input out;
  if (peer_.known()) out.commanded.F.f = peer_.newest().F;
  return out;
}

Datagram Operator::send() const noexcept {
  Datagram d;
  d.X.p = in_.p;
  d.v = in_.v;
  d.F = F_;
  d.energy_in = port_.in();
  d.energy_out = port_.out();
  // A measured force ends where the tool leaves the tissue, so the tool follows before the hand feels it again.
  const bool follows = linked_ || free_ || options_.mode != Mode::model;
  d.flags = in_.engaged && follows ? kEngaged : 0u;
  peer_.stamp(d, in_.t);
  return d;
}

}  // namespace palpate::network
