#include "palpate/contact/proxy.hpp"

#include <algorithm>
#include <cstddef>
#include <stdexcept>

#include "palpate/scene/deformable.hpp"
#include "palpate/scene/pulling.hpp"
#include "palpate/types/index.hpp"

namespace palpate::contact {

void Proxy::reset() noexcept {
  for (int i = 0; i < object_count_; ++i) state_[to_index(i)] = ProxyState();
  object_count_ = 0;
  near_.reset();
  set_ = ContactSet();
}

void Proxy::check(const scene::Snapshot& scene) const {
  for (const scene::Object& object : scene.objects) {
    const auto pull = scene::strongest_pull(object);
    if (pull) throw std::invalid_argument(scene::words(object, *pull));
  }
}

void Proxy::record_path(std::vector<Vec3>* path) {
  for (ProxyState& state : state_) state.proxy.record_path(path);
}

const ContactSet& Proxy::step(const scene::Snapshot& scene, const Vec3& p_WT, const Vec3& /*v_WT*/, double t) noexcept {
  set_.size = 0;
  set_.started_inside = false;
  ++tick_;
  near_.step(scene, p_WT, [&](int i) noexcept {
    return touch(scene.objects[to_index(i)], i, scene.objects[to_index(i)].pose(t), p_WT);
  });
  for (int i = near_.objects(); i < object_count_; ++i) state_[to_index(i)] = ProxyState();
  object_count_ = near_.objects();
  return set_;
}

namespace {

/// True if the stiffness at p_O [m] depends on the position or the normal, so that the derivative of the normal
/// matters.
bool turns_force(const scene::Object& object, const Vec3& p_O) noexcept {
  const Vec3& K = object.material.K;
  if (object.regions.empty()) return K[0] != K[1] || K[1] != K[2];
  const scene::LocalMaterial local = object.material_at(p_O);
  return !local.dK.isZero(0.0) || local.material.K.minCoeff() < local.material.K.maxCoeff();
}

}  // namespace

/// A surface that deforms determines depth and normal itself, over the whole sphere; the proxy keeps the side.
ObjectProxy::ProxyContact Proxy::on_soft(const scene::Deformable& soft, const ObjectProxy::ProxyContact& touch,
                                         const Vec3& p_OT) const noexcept {
  const double radius = options_.radius;
  const scene::Response met =
      soft.respond({p_OT - (radius - touch.depth) * touch.normal, touch.normal, touch.depth, radius, options_.sphere});
  if (!(met.depth > 0.0)) return {};
  return {true, met.depth * met.normal, met.normal, met.depth, met.depth};
}

/// Adds the contact with an object, if there is one. Returns the distance that the tool may move before the object has
/// to be examined again [m].
double Proxy::touch(const scene::Object& object, int index, const Pose& X_WO, const Vec3& p_WT) noexcept {
  ProxyState& state = state_[to_index(index)];
  const Vec3 p_OT = X_WO.R.transpose() * (p_WT - X_WO.p);
  const scene::Surface& surface = *object.surface;
  if (state.tick + 1 != tick_) {  // the tool was free of the object since then
    const Vec3 p_OT_before = state.X_WO.R.transpose() * (near_.before() - state.X_WO.p);
    if (surface.mesh()) {
      state.proxy.follow(p_OT_before);
    } else {
      state.field.follow(surface, p_OT_before);
    }
  }
  state.tick = tick_;
  state.X_WO = X_WO;
  ObjectProxy::ProxyContact touch = surface.mesh()
                                        ? state.proxy.step(*surface.mesh(), p_OT, options_.radius, options_.release)
                                        : state.field.step(surface, p_OT, options_.radius, options_.release);
  if (touch.touching && surface.deformable() != nullptr) touch = on_soft(*surface.deformable(), touch, p_OT);
  set_.started_inside |= surface.mesh() ? state.proxy.started_inside() : state.field.started_inside();
  if (!touch.touching) return surface.mesh() ? state.proxy.free_way(p_OT, options_.radius) : state.field.free_way(p_OT);
  if (set_.size == kMaxContacts) return 0.0;

  Contact& c = set_.contact[to_index(set_.size++)];
  c = Contact();
  c.object = index;
  c.normal = X_WO.R * touch.normal;
  c.delta_x = X_WO.R * touch.delta;
  c.p_proxy = p_WT + c.delta_x;
  c.depth = touch.depth;
  c.stretch = touch.stretch;
  if (turns_force(object, p_OT - options_.radius * touch.normal)) {
    const Mat3 dn = surface.mesh() ? state.proxy.normal_gradient(touch.normal, p_OT, options_.radius)
                                   : state.field.normal_gradient(touch.normal, p_OT);
    c.dn = X_WO.R * dn * X_WO.R.transpose();
  }
  if (surface.deformable() != nullptr) c.carried = X_WO.R * state.proxy.carried();
  return 0.0;
}

}  // namespace palpate::contact
