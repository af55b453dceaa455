#include "palpate/contact/paper_alg1.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

namespace palpate::contact {
namespace {

double checked_rate(double rate) {
  if (!(rate > 0.0) || !std::isfinite(rate)) {
    throw std::invalid_argument("contact: collision_rate must be a positive rate in Hz, for example 250, got " +
                                std::to_string(rate));
  }
  return rate;
}

}  // namespace

PaperAlg1::PaperAlg1(const Options& options) : rate_(checked_rate(options.collision_rate)), surface_(options.radius) {}

void PaperAlg1::reset() noexcept {
  instant_ = -1.0;
  ++request_.epoch;
  shown_ = Answer{};
  set_.size = 0;
}

const ContactSet& PaperAlg1::step(const scene::Snapshot& scene, const Vec3& p_WT, const Vec3& v_WT, double t) noexcept {
  set_.size = 0;
  if (!p_WT.allFinite() || !v_WT.allFinite()) {
    return set_;
  }
  const double instant = std::floor(t * rate_ + 1e-6);  // a tick that is due within rounding is due
  if (instant != instant_) {
    instant_ = instant;
    const Answer& newest = answers_.read();
    shown_ = newest.epoch == request_.epoch ? newest : Answer{};
    request_.p_WT = p_WT;
    ++request_.number;
    requests_.write(request_);
  }
  for (int i = 0; i < shown_.size; ++i) {
    const Found& f = shown_.found[static_cast<std::size_t>(i)];
    const auto object = static_cast<std::size_t>(f.object);
    if (object >= scene.objects.size() || scene.objects[object].surface->id() != f.mesh) {
      continue;
    }
    const algorithm1::Deflection d = algorithm1::deflect(f.plane, p_WT, v_WT);
    const double depth = f.plane.n.dot(d.delta_x);
    if (depth > 0.0) {  // else released since the collision: exactly zero
      set_.contact[static_cast<std::size_t>(set_.size++)] = {
          f.object, p_WT + d.delta_x, f.plane.n, d.delta_x, depth, Vec3::Zero(), scene.objects[object].material};
    }
  }
  return set_;
}

void PaperAlg1::collide(const scene::Snapshot& scene) {
  surface_.prepare(scene);
  const Request request = requests_.read();
  if (request.number == answered_) {
    return;
  }
  answered_ = request.number;
  if (request.epoch != epoch_) {
    epoch_ = request.epoch;
    n_last_.clear();
  }
  Answer answer;
  answer.epoch = request.epoch;
  for (std::size_t i = 0; i < scene.objects.size() && answer.size < kMaxContacts; ++i) {
    const scene::Object& object = scene.objects[i];
    const std::uint64_t mesh = object.surface->id();
    const CollisionPoints points = surface_.collide(object, request.p_WT);
    if (points.size == 0) {
      n_last_.erase(mesh);
      continue;
    }
    Vec3& n_last = n_last_.try_emplace(mesh, Vec3::Zero()).first->second;
    const algorithm1::Plane plane = algorithm1::average(points, n_last, request.p_WT);
    n_last = plane.n;
    answer.found[static_cast<std::size_t>(answer.size++)] = {static_cast<int>(i), mesh, plane};
  }
  answers_.write(answer);
}

}  // namespace palpate::contact
