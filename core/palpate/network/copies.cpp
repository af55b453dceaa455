#include "palpate/network/copies.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::network {
namespace {

constexpr double kLeastWide = 0.1, kMostWide = 0.2, kLeastBelow = 0.01;  // [-] differences of friction between copies
constexpr std::uint64_t kPerturbedEvery = 4;  // [ticks] between two contacts of the perturbed copies

}  // namespace

Copies::Copy::Copy(const scene::Object& object, double radius)
    : scene{{object}, 0, {}}, tool("proxy", {.radius = radius, .objects = 1}) {}

Copies::Copies(const scene::Object& object, double radius) : X_WO_(object.X_WO) {
  for (auto& copy : copies_) copy = std::make_unique<Copy>(object, radius);
}

const Vec3& Copies::touch(std::size_t copy, const Guess& guess, double mu) noexcept {
  scene::Object& object = copies_[copy]->scene.objects.front();
  const Vec3 before = object.X_WO.p;
  object.X_WO.p = X_WO_.p + guess.shift;
  object.correction = object.X_WO.p - before;
  object.material.K.setConstant(guess.K);
  object.material.mu = object.material.mu_static = mu;
  const ContactSet& found = copies_[copy]->tool.step(copies_[copy]->scene, &p_, t_);
  touching_ += found.size > 0;
  F_[copy] = found.size > 0 ? spring_force(found.contact[0]) : Vec3(Vec3::Zero());
  if (copy == 0 && found.size > 0) contact_ = found.contact[0];
  return F_[copy];
}

const Prediction& Copies::step(const Estimator& estimator, const Vec3& p, double t) noexcept {
  if (std::abs(t - t_) > kApart) reset();
  const ModelEstimate now = estimator.estimate();
  if (touching_ == 0) {
    wide_ = std::clamp(2.0 * estimator.sd_mu(), kLeastWide, kMostWide);
    mu_ = now.mu;
  }
  p_ = p;
  t_ = t;
  const Guess guess = estimator.guess(0, 0);
  const bool all = ticks_++ % kPerturbedEvery == 0;
  const int before = touching_;
  touching_ = 0;
  prediction_.F = touch(0, guess, mu_);
  prediction_.touching = touching_ > 0;
  prediction_.across = false;
  if (!all) {
    touching_ = std::max(touching_, before);
    return prediction_;
  }
  for (int j = 0; j < kAcross; ++j) {
    const auto k = static_cast<std::size_t>(j);
    prediction_.above[k] = touch(3 + 2 * k, estimator.guess(j, 1), mu_);
    prediction_.below[k] = touch(4 + 2 * k, estimator.guess(j, -1), mu_);
  }
  touch(1, guess, mu_ + wide_);
  touch(2, guess, std::max(mu_ - wide_, 0.0));
  prediction_.across = touching_ == static_cast<int>(copies_.size());
  interpolate(now.mu);
  return prediction_;
}

// Forces at the estimated friction.
void Copies::interpolate(double mu) noexcept {
  const double below = std::min(wide_, mu_);
  const Vec3 more = (F_[1] - F_[0]) / wide_, less = below > kLeastBelow ? Vec3((F_[0] - F_[2]) / below) : more;
  const double away = std::clamp(mu - mu_, -2.0 * wide_, 2.0 * wide_);
  prediction_.per_mu = away >= 0.0 ? more : less;
  prediction_.bend = more - less;
  const Vec3 change = away * prediction_.per_mu;
  prediction_.F += change;
  for (Vec3& F : prediction_.above) F += change;
  for (Vec3& F : prediction_.below) F += change;
}

}  // namespace palpate::network
