#include "palpate/contact/proxy.hpp"

#include <algorithm>
#include <cstddef>
#include <stdexcept>

#include "palpate/scene/pulling.hpp"
#include "palpate/types/index.hpp"

namespace palpate::contact {
namespace {

// Share of the tool's motion by which a proxy may move away from it: the smooth distance to a mesh is not exact.
constexpr double kAway = 0.02;

}  // namespace

void Proxy::reset() noexcept {
  for (int i = 0; i < object_count_; ++i) state_[to_index(i)] = ProxyState();
  object_count_ = 0;
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
  const int objects = std::min(static_cast<int>(scene.objects.size()), scene::kMaxObjects);
  for (int i = 0; i < objects; ++i) touch(scene.objects[to_index(i)], i, scene.objects[to_index(i)].pose(t), p_WT);
  for (int i = objects; i < object_count_; ++i) state_[to_index(i)] = ProxyState();
  object_count_ = objects;
  return set_;
}

/// A proxy that slides on a surface to the place nearest to the tool never comes farther away from the tool than if it
/// had stayed. Where the surface found by other triangles, or by another patch of them, is farther, it would give the
/// tool energy: the proxy then stays where it was. Returns true if it stays.
bool Proxy::keep_nearer(ProxyState& state, const scene::Surface& surface, const Vec3& p_OT,
                        ObjectProxy::ProxyContact& touch) noexcept {
  const bool known = state.surface == &surface && surface.deformable() == nullptr;
  const Vec3 stay = state.p_OP - p_OT;
  const double depth = stay.norm(), moved = (p_OT - state.p_OT).norm();
  const bool stays = known && touch.touching && touch.delta.norm() > depth * (1.0 + 1e-9) + kAway * moved;
  if (stays) touch = {depth > 0.0, stay, depth > 0.0 ? Vec3(stay / depth) : touch.normal, depth};
  state.surface = &surface;
  state.p_OT = p_OT;
  state.p_OP = touch.touching ? Vec3(p_OT + touch.delta) : p_OT;
  return stays;
}

void Proxy::touch(const scene::Object& object, int index, const Pose& X_WO, const Vec3& p_WT) noexcept {
  ProxyState& state = state_[to_index(index)];
  const Vec3 p_OT = X_WO.R.transpose() * (p_WT - X_WO.p);
  const scene::Surface& surface = *object.surface;
  ObjectProxy::ProxyContact touch = surface.mesh()
                                        ? state.proxy.step(*surface.mesh(), p_OT, options_.radius, options_.release)
                                        : state.field.step(surface, p_OT, options_.radius, options_.release);
  const bool started_inside = surface.mesh() ? state.proxy.started_inside() : state.field.started_inside();
  set_.started_inside |= started_inside;
  if (started_inside) state.surface = nullptr;  // a proxy that was just put outside may be far from the tool
  const bool stays = surface.mesh() != nullptr && keep_nearer(state, surface, p_OT, touch);
  if (!touch.touching || set_.size == kMaxContacts) return;

  Contact& c = set_.contact[to_index(set_.size++)];
  c = Contact();
  c.object = index;
  c.normal = X_WO.R * touch.normal;
  c.delta_x = X_WO.R * touch.delta;
  c.p_proxy = p_WT + c.delta_x;
  c.depth = touch.depth;
  if (!object.regions.empty() && !object.material_at(p_OT - options_.radius * touch.normal).dK.isZero(0.0)) {
    const Mat3 dn = stays            ? Mat3((touch.normal * touch.normal.transpose() - Mat3::Identity()) / touch.depth)
                    : surface.mesh() ? state.proxy.normal_gradient(touch.normal, p_OT, options_.radius)
                                     : state.field.normal_gradient(touch.normal, p_OT);
    c.dn = X_WO.R * dn * X_WO.R.transpose();
  }
  if (surface.deformable() != nullptr) c.carried = X_WO.R * state.proxy.carried();
}

}  // namespace palpate::contact
