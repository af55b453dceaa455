#include "palpate/contact/proxy.hpp"

#include <algorithm>
#include <cstddef>

namespace palpate::contact {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace

void Proxy::reset() noexcept {
  for (Memory& memory : memory_) memory = Memory();
  set_ = ContactSet();
  running_ = false;
}

const ContactSet& Proxy::step(const scene::Snapshot& scene, const Vec3& p_WT, const Vec3& /*v_WT*/, double t) noexcept {
  const double dt = running_ ? t - t_ : 0.0;
  t_ = t;
  running_ = true;
  set_.size = 0;
  set_.started_inside = false;
  const int objects = std::min(static_cast<int>(scene.objects.size()), kMaxObjects);
  for (int i = 0; i < objects; ++i) {
    const scene::Object& object = scene.objects[at(i)];
    Memory& memory = memory_[at(i)];
    const Vec3 p_OT = object.X_WO.R.transpose() * (p_WT - object.X_WO.p);
    touch(object, i, memory, p_OT, dt);
    memory.X_WO = object.X_WO;
    memory.seen = true;
  }
  for (int i = objects; i < kMaxObjects; ++i) memory_[at(i)] = Memory();
  return set_;
}

void Proxy::touch(const scene::Object& object, int index, Memory& memory, const Vec3& p_OT, double dt) noexcept {
  const scene::Surface& surface = *object.surface;
  const ObjectProxy::Touch touch = surface.mesh() ? memory.proxy.step(*surface.mesh(), p_OT, options_.radius)
                                                  : memory.field.step(surface, p_OT, options_.radius);
  set_.started_inside |= surface.mesh() ? memory.proxy.started_inside() : memory.field.started_inside();
  if (!touch.touching) {
    memory.touching = false;
    return;
  }
  // Coulomb: the lag behind the frictionless proxy, in the tangent plane, within the cone.
  const Vec3 p_OP = p_OT + touch.delta;
  Vec3 lag = memory.touching ? Vec3(memory.p_lag - p_OP) : Vec3::Zero();
  lag -= touch.normal * touch.normal.dot(lag);
  const double most = object.material.mu * touch.depth, length = lag.norm();
  if (length > most) lag *= most / length;
  memory.p_lag = p_OP + lag;
  memory.touching = true;
  if (set_.size == kMaxContacts) return;

  const Mat3& R_WO = object.X_WO.R;
  Contact& c = set_.contact[at(set_.size++)];
  c.object = index;
  c.normal = R_WO * touch.normal;
  c.delta_x = R_WO * (touch.delta + lag);
  c.p_proxy = object.X_WO * memory.p_lag;
  c.depth = touch.depth;
  c.material = object.material;
  c.v_surface.setZero();
  if (memory.seen && dt > 0.0) c.v_surface = (object.X_WO * p_OP - memory.X_WO * p_OP) / dt;
}

}  // namespace palpate::contact
