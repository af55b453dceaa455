#include "palpate/collision/collision_method.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace palpate::collision {
namespace {

double checked_rate(double rate) {
  if (!(rate > 0.0) || !std::isfinite(rate)) {
    throw std::invalid_argument("contact: collision_rate must be a positive rate in Hz, for example 250, got " +
                                std::to_string(rate));
  }
  return rate;
}

}  // namespace

CollisionMethod::CollisionMethod(const contact::Options& options, MakeRule make_rule)
    : rate_(checked_rate(options.collision_rate)),
      radius_(options.radius),
      surface_(options.radius),
      make_rule_(make_rule) {}

void CollisionMethod::reset() noexcept {
  collision_index_ = -1.0;
  ++request_.epoch;
  current_answer_ = Answer{};
  set_.size = 0;
}

const ContactSet& CollisionMethod::step(const scene::Snapshot& scene, const Vec3& p_WT, const Vec3& v_WT,
                                        double t) noexcept {
  set_.size = 0;
  if (!p_WT.allFinite() || !v_WT.allFinite()) {
    return set_;
  }
  const double collision_index = std::floor(t * rate_ + 1e-6);  // 1e-6 tolerates rounding of t * rate
  if (collision_index != collision_index_) {
    collision_index_ = collision_index;
    const Answer& newest = answers_.read();
    current_answer_ = newest.epoch == request_.epoch ? newest : Answer{};
    post(scene, p_WT, v_WT, t);
  }
  for (int i = 0; i < current_answer_.size; ++i) {
    const ContactPlane& f = current_answer_.planes[static_cast<std::size_t>(i)];
    const auto index = static_cast<std::size_t>(f.object);
    if (index >= scene.objects.size() || scene.objects[index].surface->id() != f.mesh) {
      continue;
    }
    const Pose X_WO = scene.objects[index].pose(t);
    const Mat3& R_WO = X_WO.R;
    const Vec3 p_OT = R_WO.transpose() * (p_WT - X_WO.p);
    const algorithm1::Deflection d = algorithm1::deflect(f.plane, p_OT, R_WO.transpose() * v_WT);
    const double depth = f.plane.n.dot(d.delta_x);
    if (depth > 0.0) {  // otherwise the tool has left the plane since the collision: no contact
      const Vec3 delta_x = R_WO * d.delta_x;
      set_.contact[static_cast<std::size_t>(set_.size++)] = {.object = f.object,
                                                             .p_proxy = p_WT + delta_x,
                                                             .normal = R_WO * f.plane.n,
                                                             .delta_x = delta_x,
                                                             .depth = depth};
    }
  }
  return set_;
}

// Requests the collisions of this instant.
void CollisionMethod::post(const scene::Snapshot& scene, const Vec3& p_WT, const Vec3& v_WT, double t) noexcept {
  request_.objects = std::min(scene.objects.size(), request_.X_WO.size());
  for (std::size_t i = 0; i < request_.objects; ++i) {
    const scene::Object& object = scene.objects[i];
    request_.X_WO[i] = object.pose(t);
    request_.v_OT[i] = request_.X_WO[i].R.transpose() * (v_WT - object.motion.velocity(p_WT, t));
  }
  request_.p_WT = p_WT;
  ++request_.number;
  requests_.write(request_);
}

void CollisionMethod::check(const scene::Snapshot& scene) const {
  if (scene.objects.size() > Request{}.X_WO.size()) {
    throw std::invalid_argument("contact: the paper's methods take at most " + std::to_string(kMaxContacts) +
                                " objects, and the scene has " + std::to_string(scene.objects.size()) +
                                "; use method proxy or penalty");
  }
  for (const scene::Object& object : scene.objects) {
    if (object.surface->deformable() != nullptr) {
      throw std::invalid_argument("contact: object '" + object.name +
                                  "' is soft, and the paper's methods index its triangles once; use method proxy or "
                                  "penalty");
    }
    if (!object.surface->mesh()) {
      throw std::invalid_argument("contact: object '" + object.name +
                                  "' has no triangles, and the paper's methods find collisions of triangles; use "
                                  "method proxy or penalty, or a mesh");
    }
  }
}

void CollisionMethod::collide(const scene::Snapshot& scene) {
  surface_.prepare(scene);
  std::erase_if(rules_, [&scene](const auto& rule) {
    const auto& [index, mesh] = rule.first;
    return index >= scene.objects.size() || scene.objects[index].surface->id() != mesh;
  });
  const Request request = requests_.read();
  if (request.number == answered_) {
    return;
  }
  answered_ = request.number;
  if (request.epoch != epoch_) {
    epoch_ = request.epoch;
    rules_.clear();
  }
  Answer answer;
  answer.epoch = request.epoch;
  const std::size_t objects = std::min(scene.objects.size(), request.objects);
  for (std::size_t i = 0; i < objects && answer.size < kMaxContacts; ++i) {
    const scene::Object& object = scene.objects[i];
    const std::uint64_t mesh = object.surface->id();
    std::unique_ptr<NormalRule>& rule = rules_[{i, mesh}];
    if (!rule) {
      rule = make_rule_();
    }
    const Vec3 p_OT = request.X_WO[i].R.transpose() * (request.p_WT - request.X_WO[i].p);
    const CollisionPoints points = surface_.collide(object, p_OT);
    if (points.size == 0) {
      rule->free(request.v_OT[i]);
      continue;
    }
    const algorithm1::GrownPlane plane = rule->touch({points, p_OT, radius_});
    answer.planes[static_cast<std::size_t>(answer.size++)] = {static_cast<int>(i), mesh, plane};
  }
  answers_.write(answer);
}

}  // namespace palpate::collision
