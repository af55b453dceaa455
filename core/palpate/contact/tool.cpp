#include "palpate/contact/tool.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>

#include "palpate/scene/deformable.hpp"
#include "palpate/types/index.hpp"

namespace palpate::contact {

namespace {

constexpr double kNormalError = 1e-3;  // angle between a normal and the gradient of the distance [rad]
constexpr double kRounding = 1e-9;     // of a stored energy

/// Shortens the springs of a contact of a sphere at p_WS to a share.
void shorten(Contact& c, const Vec3& p_WS, double share) noexcept {
  if (share == 1.0) return;
  c.delta_x *= share;
  c.lag *= share;
  c.F_grad_K *= share;
  c.depth *= share;
  c.stretch *= share;
  c.p_proxy = p_WS + c.delta_x;
}

/// Correction of the place of an object in this tick, across the normal of a contact with it and in O [m].
Vec3 corrected(const Contact& c, const scene::Object& object, const Pose& X_WO) noexcept {
  return X_WO.R.transpose() * (object.correction - c.normal * c.normal.dot(object.correction));
}

}  // namespace

Tool::Tool(std::string_view method, const Options& options)
    : real_objects_(options.real_objects), objects_(options.objects) {
  if (options.spheres.size() >= kMaxSpheres) {
    throw std::invalid_argument("contact: " + std::to_string(options.spheres.size()) +
                                " spheres beside the one on the tip; a tool has at most " +
                                std::to_string(kMaxSpheres - 1));
  }
  Options one = options;
  one.spheres.clear();
  methods_.push_back(make_method(method, one));
  radius_[0] = options.radius;
  for (const ToolSphere& sphere : options.spheres) {
    if (!sphere.p.allFinite() || !sphere.hinge.allFinite() || !sphere.axis.allFinite()) {
      throw std::invalid_argument("contact: sphere " + std::to_string(methods_.size()) + " has no finite place");
    }
    one.sphere = static_cast<int>(methods_.size());
    radius_[methods_.size()] = one.radius = sphere.radius;
    methods_.push_back(make_method(method, one));
  }
  if (methods_.front()->has_friction()) {
    rubbing_.resize(methods_.size() * to_index(objects_));
    springs_.resize(rubbing_.size());
  }
}

void Tool::reset() noexcept {
  for (const auto& method : methods_) method->reset();
  running_ = false;
  ++tick_;  // ends every contact with friction
}

void Tool::collide(const scene::Snapshot& scene) {
  for (const auto& method : methods_) method->collide(scene);
}

void Tool::check(const scene::Snapshot& scene) const {
  if (scene.objects.size() > to_index(objects_)) {
    throw std::invalid_argument("contact: the scene has " + std::to_string(scene.objects.size()) +
                                " objects, and this loop was made for at most " + std::to_string(objects_) +
                                "; start it with a scene of that size, or set ContactOptions.objects");
  }
  methods_.front()->check(scene);
}

const ContactSet& Tool::step(const scene::Snapshot& scene, const Vec3* p_WS, double t) noexcept {
  set_.size = 0;
  set_.started_inside = false;
  ++tick_;
  const double rate = running_ && t > t_ ? 1.0 / (t - t_) : 0.0;
  for (int s = 0; s < size(); ++s) {
    if (!p_WS[s].allFinite()) continue;  // unknown position: the sphere has no contact, and its method keeps its state
    const Vec3 v_WS = running_ ? Vec3((p_WS[s] - last_[to_index(s)]) * rate) : Vec3::Zero();
    last_[to_index(s)] = p_WS[s];
    const ContactSet& found = methods_[to_index(s)]->step(scene, p_WS[s], v_WS, t);
    set_.started_inside |= found.started_inside;
    for (int i = 0; i < found.size; ++i) {
      const scene::Object& object = scene.objects[to_index(found.contact[to_index(i)].object)];
      if (!(real_objects_ ? object.is_real : object.is_virtual)) continue;
      const bool room = set_.size < kMaxContacts;
      Contact& c = room ? set_.contact[to_index(set_.size++)] : spare_;
      c = found.contact[to_index(i)];
      c.sphere = s;
      c.p_TS = p_WS[s] - p_WS[0];
      complete(c, object, t);
      if (!rubbing_.empty()) rub(c, p_WS[s], object, t);
      if (!springs_.empty()) keep_energy(c, p_WS[s], object, t);
      if (!room) keep_if_stronger(c);
    }
  }
  t_ = t;
  jump_ = {};
  running_ = true;
  return set_;
}

/// Adds the fields that do not depend on the method: contact point, surface velocity and material.
void Tool::complete(Contact& c, const scene::Object& object, double t) const noexcept {
  c.p_C = c.p_proxy - radius_[to_index(c.sphere)] * c.normal;
  c.v_surface = object.motion.velocity(c.p_C, t);
  if (object.surface->deformable() != nullptr) return respond(c, object, t);
  if (object.regions.empty()) {
    c.material = object.material;
    return press_along_normal(c);
  }
  const Pose X_WO = object.pose(t);
  // The sphere's deepest point selects the material. It moves with the tool by I - r dn.
  const double r = radius_[to_index(c.sphere)];
  const scene::LocalMaterial local = object.material_at(X_WO.inverse() * (c.p_C - c.delta_x));
  c.material = local.material;
  const Vec3 slope = X_WO.R * (local.dK.transpose() * c.delta_x.cwiseAbs2());
  c.F_grad_K = -0.5 * (slope - r * c.dn.transpose() * slope);
  press_along_normal(c);
}

/// Replaces an anisotropic stiffness by k = n^T K n in all directions. The energy 1/2 k d^2 also changes where the
/// normal turns, which causes a force.
void Tool::press_along_normal(Contact& c) const noexcept {
  Vec3& K = c.material.K;
  if ((K[0] == K[1] && K[1] == K[2]) || methods_.front()->stiff_along_axes()) return;
  const Vec3 K_n = K.cwiseProduct(c.normal);
  c.F_grad_K -= c.delta_x.squaredNorm() * (c.dn.transpose() * K_n);
  K.setConstant(c.normal.dot(K_n));
}

/// Adds the friction, which holds the tool and its proxy back.
void Tool::rub(Contact& c, const Vec3& p_WS, const scene::Object& object, double t) noexcept {
  Rubbing& state = rubbing_[to_index(c.sphere * objects_ + c.object)];
  const bool begins = state.tick + 1 != tick_ || state.surface != object.surface->id() || !state.rubs;
  if (begins) state = Rubbing();
  state.surface = object.surface->id();
  state.rubs = c.material.mu > 0.0 || c.material.mu_static > 0.0;
  state.tick = tick_;
  if (!state.rubs) return;
  const Material& m = c.material;
  // The stiffness varies under the tool on tissue and at regions. Elsewhere only an edit changes it, and the lag stays.
  const bool varies = !object.regions.empty() || object.surface->deformable() != nullptr;
  const double k = c.normal.dot(m.K.cwiseProduct(c.normal)), dt = running_ ? std::max(t - t_, 0.0) : 0.0;
  const Pose X_WO = object.pose(t);
  const SphereMotion sphere{X_WO.R.transpose() * (p_WS - X_WO.p), X_WO.R.transpose() * c.normal};
  const scene::Deformable* const soft = object.surface->deformable();
  const double period = soft != nullptr ? soft->period() : 0.0;
  const int ticks = period > 0.0 && dt > 0.0 ? static_cast<int>(std::lround(period / dt)) : 0;
  const bool beside = ticks > 0 && !begins;
  const Vec3 carried = X_WO.R.transpose() * c.carried - corrected(c, object, X_WO);
  state.friction.carry(beside ? follow(state, carried, sphere.x, ticks) : carried);
  const Vec3& lag = state.friction.step({.x = sphere.x,
                                         .normal = sphere.normal,
                                         .depth = c.depth,
                                         .k = varies || !(k > 0.0) ? k : 1.0,
                                         .mu = m.mu,
                                         .mu_static = m.mu_static,
                                         .dt = varies || !(k > 0.0) ? dt : dt / k});
  const Vec3 felt = beside ? lead(state, c, sphere, lag, ticks) : lag;
  c.lag = X_WO.R * felt;
  c.lag_to_come = X_WO.R * (lag - felt);
  state.x = sphere.x;
  state.felt = felt;
  c.delta_x += c.lag;
  c.p_proxy += c.lag;
}

/// Keeps the energy of a contact where its surface jumps. It is that of an object of stiffness 1, so that edits of the
/// material do not count as jumps. A soft body answers for its own energy; clouds are left as they are, since their
/// noise would count as jumps and take force.
void Tool::keep_energy(Contact& c, const Vec3& p_WS, const scene::Object& object, double t) noexcept {
  const double k = object.material.K.mean();
  if (object.surface->deformable() != nullptr || !object.surface->is_exact() || !(k > 0.0)) return;
  Spring& s = springs_[to_index(c.sphere * objects_ + c.object)];
  const Pose X_WO = object.pose(t);
  const Vec3 x = X_WO.R.transpose() * (p_WS - X_WO.p), F = X_WO.R.transpose() * spring_force(c) / k;
  const double stored = spring_energy(c) / k;
  const Vec3 jumped = X_WO.R.transpose() * (jump_.v + jump_.w.cross(c.p_TS));
  const bool begins = s.tick + 1 != tick_ || s.surface != object.surface.get();
  if (begins && jumped.isZero(0.0)) {
    s.rest.start(stored);
  } else {
    if (begins) {  // the tool has jumped into the object
      s.rest.start(0.0);
      s.x = x - jumped;
      s.F.setZero();
    }
    // The force between both positions lies between those at them, unless the surface jumps.
    // A correction of the place does no work against friction, which keeps its anchor.
    const Vec3 dx = x - s.x - jumped;
    const double kept = (X_WO.R.transpose() * c.lag).dot(corrected(c, object, X_WO));
    const double before = -s.F.dot(dx) - kept, now = -F.dot(dx) - kept;
    const double inexact = kNormalError * F.norm() * dx.norm() + kRounding * stored;
    shorten(c, p_WS, s.rest.step(stored, std::min(before, now), std::max(before, now), inexact));
  }
  s.surface = object.surface.get();
  s.tick = tick_;
  s.x = x;
  s.F = F;
}

/// Motion of a surface that steps beside the cycle: its shape moves once in so many ticks, by `shape`. In between it is
/// taken to go on as in the period before, but not faster than the sphere; the next shape corrects that.
Vec3 Tool::follow(Rubbing& state, const Vec3& shape, const Vec3& x, int ticks) noexcept {
  const double moved = (x - state.x).norm(), fastest = state.rate.norm();
  state.step = fastest > moved ? Vec3(moved / fastest * state.rate) : state.rate;
  state.foreseen += state.step;
  if (shape.isZero(0.0)) return state.step;
  const Vec3 correction = shape - state.foreseen;
  state.foreseen.setZero();
  state.rate = shape / ticks;
  return state.step + correction;
}

/// Lag that is felt on such a surface: where a shape corrects the motion, the lag goes on as if it had not, and then
/// approaches that of the friction within a period.
Vec3 Tool::lead(Rubbing& state, const Contact& c, const SphereMotion& sphere, const Vec3& lag, int ticks) noexcept {
  if (!c.carried.isZero(0.0)) {
    const Vec3 moved = sphere.x - state.x - state.step;
    Vec3 goes_on = state.felt - (moved - sphere.normal.dot(moved) * sphere.normal);
    const double longest = std::max(lag.norm(), state.felt.norm()), length = goes_on.norm();
    if (state.friction.slipping() && length > longest) goes_on *= longest / length;
    state.to_come = lag - goes_on;
    state.leading = ticks;
  }
  state.to_come *= state.leading > 0 ? (state.leading - 1.0) / state.leading : 0.0;
  state.leading = std::max(state.leading - 1, 0);
  const Vec3 felt = lag - state.to_come;
  const double longest = std::max(c.material.mu, c.material.mu_static) * c.depth, length = felt.norm();
  return length > longest ? Vec3(longest / length * felt) : felt;
}

/// Stiffness, energy and velocity of a surface that deforms. Damping and friction are those of the object.
void Tool::respond(Contact& c, const scene::Object& object, double t) const noexcept {
  const Pose X_WO = object.pose(t);
  const double radius = radius_[to_index(c.sphere)];
  const Vec3 p_WC = c.p_proxy - c.delta_x - (radius - c.depth) * c.normal;  // where the sphere without friction touches
  const scene::Response response = object.surface->deformable()->respond(
      {X_WO.inverse() * p_WC, X_WO.R.transpose() * c.normal, c.depth, radius, c.sphere});
  c.material = object.material;
  c.material.K.setConstant(response.stiffness);
  c.stored = response.stored;
  c.stiffening = response.stiffness > 0.0 ? response.tangent / response.stiffness : 1.0;
  c.v_surface += X_WO.R * response.velocity;
  if (response.carries) c.carried = X_WO.R * response.carried;
}

/// Replaces the weakest contact of a full set by `c`, if `c` is stronger.
void Tool::keep_if_stronger(const Contact& c) noexcept {
  const auto weaker = [](const Contact& a, const Contact& b) {
    return a.depth * a.material.K.sum() < b.depth * b.material.K.sum();
  };
  Contact& weakest = *std::min_element(set_.contact.begin(), set_.contact.end(), weaker);
  if (weaker(weakest, c)) weakest = c;
}

}  // namespace palpate::contact
