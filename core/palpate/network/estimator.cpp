#include "palpate/network/estimator.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/types/require.hpp"

namespace palpate::network {
namespace {

constexpr double kFelt = 0.06;      // [N] smaller forces are no contact
constexpr double kMissing = 0.2;    // [N] predicted force from which a contact that is not felt tells something
constexpr double kSliding = 0.001;  // [m/s] slower tools may stick
constexpr double kFriction = 0.3;   // [-] standard deviation of an unknown friction coefficient
constexpr double kSticks = 5.0;     // [-] factor of that error where the tool may stick
constexpr double kUneven = 0.05;    // [-] error of the tangential law: sticking, facets
constexpr double kSurprise = 5.0;   // [standard deviations]
constexpr int kSurprised = 25;      // [ticks]
constexpr int kRest = 60;           // [ticks] after a surprise, until the next
constexpr double kForget = 0.01;    // weight of a new residual
constexpr double kLeast = 1.0;      // [N/m] smallest stiffness
// Random walk of theta per tick: stiffness 2 N/m, place 2 um and damping .05 N s/m in the square root of a second.
constexpr double kWalkK = 4.0 * 1e-3, kWalkPlace = 4e-12 * 1e-3, kWalkB = 2.5e-3 * 1e-3, kWalkMu = 1e-4 * 1e-3;

}  // namespace

Estimator::Estimator(const EstimatorOptions& options) : options_(options) {
  require("remote", options.K > 0.0, "stiffness", options.K, "must be above 0 N/m");
  require("remote", options.sd_force > 0.0, "sd_force", options.sd_force, "must be above 0 N");
  theta_ << options.K, 0.0, 0.0, 0.0, 0.0, 0.0;
  const double place = options.K * options.sd_place;
  Vec variance;
  variance << options.sd_K * options.sd_K, place * place, place * place, place * place, 1.0, kFriction * kFriction;
  P_ = variance.asDiagonal();
}

Estimator::Vec Estimator::row(const Touch& t) noexcept {
  Vec h;
  h << t.depth, t.normal, -t.v.dot(t.normal), 0.0;
  return h;
}

double Estimator::predicted(const Touch& touch) const noexcept { return std::max(row(touch).dot(theta_), 0.0); }

bool Estimator::step(const Touch& touch) noexcept {
  if (!touch.F.allFinite() || !std::isfinite(touch.depth) || !touch.v.allFinite()) return false;
  const Vec h = row(touch);
  const double measured = touch.F.dot(touch.normal), prior = h.dot(theta_);
  const bool felt = measured > kFelt;
  if (!felt && prior <= kMissing) return false;  // both agree that there is no contact, within the noise
  normal_ = touch.normal;
  const double z = felt ? measured : 0.0;
  const double sd = felt ? options_.sd_force + options_.sd_model * measured : kMissing / 2.0;
  const double innovation = z - prior, S = h.dot(P_ * h) + sd * sd;
  residual2_ += kForget * (innovation * innovation - residual2_);
  rest_ = std::max(rest_ - 1, 0);
  const bool surprise = innovation * innovation > kSurprise * kSurprise * S;
  surprised_ = surprise && rest_ == 0 ? surprised_ + 1 : std::max(surprised_ - 1, 0);
  if (surprised_ >= kSurprised) forget_place();
  if (felt) {
    measure(h, innovation, sd);
    rub(touch, measured);
  } else {
    recede(touch.normal, prior);
  }
  const double place = theta_[0] * theta_[0] * kWalkPlace;
  P_.diagonal() += (Vec() << kWalkK, place, place, place, kWalkB, kWalkMu).finished();
  P_ = (0.5 * (P_ + P_.transpose())).eval();
  return true;
}

// Updates theta by one scalar measurement with the row h and this standard deviation.
void Estimator::measure(const Vec& h, double innovation, double sd) noexcept {
  const Vec Ph = P_ * h;
  const Vec gain = Ph / (h.dot(Ph) + sd * sd);
  theta_ += gain * innovation;
  theta_[0] = std::max(theta_[0], kLeast);
  theta_[4] = std::max(theta_[4], 0.0);
  theta_[5] = std::clamp(theta_[5], 0.0, 2.0);
  P_ -= gain * Ph.transpose();
}

// The tool is where the estimate has a contact of the force `prior`, and feels nothing: the surface is no nearer than
// the tool. A bound is no measurement: it moves the place, and leaves all variances, stiffness, damping and friction.
void Estimator::recede(const Vec3& normal, double prior) noexcept {
  Vec h = Vec::Zero();
  h.segment<3>(1) = normal;
  const Vec Ph = P_ * h;
  const double share = prior / (h.dot(Ph) + 0.25 * kMissing * kMissing);
  theta_.segment<3>(1) -= share * Ph.segment<3>(1);
}

// The object has moved: its place is as unknown as most_shift allows, and its stiffness is kept.
void Estimator::forget_place() noexcept {
  surprised_ = 0;
  rest_ = kRest;
  ++moved_;
  const double place = theta_[0] * 0.5 * options_.most_shift;
  P_.block<1, 3>(0, 1).setZero();
  P_.block<3, 1>(1, 0).setZero();
  P_.block<3, 3>(1, 1) += Mat3::Identity() * place * place;
}

// Friction and the place across the normal, from the tangential force of a sliding tool.
void Estimator::rub(const Touch& touch, double F_normal) noexcept {
  const Vec3 slip = touch.v - touch.normal * touch.normal.dot(touch.v);
  const double speed = slip.norm();
  if (speed < kSliding || F_normal < 4.0 * kFelt) return;
  const Vec3 along = slip / speed, across = touch.normal.cross(along);
  const double sd = kUneven + options_.sd_force / F_normal;
  for (const Vec3& e : {along, across}) {
    const double K = theta_[0];
    Vec h = Vec::Zero();
    h.segment<3>(1) = -(touch.dn.transpose() * e) / K;
    h[5] = -along.dot(e);
    const Vec3 away = theta_.segment<3>(1) / K - touch.shift;
    const double predicted = h[5] * theta_[5] - e.dot(touch.dn * away);
    const double innovation = touch.F.dot(e) / F_normal - predicted;
    const bool may_stick = h[5] < -0.5 && innovation > 0.0;  // less than the full friction
    measure(h, innovation, may_stick ? kSticks * sd : sd);
  }
}

ModelEstimate Estimator::estimate() const noexcept {
  ModelEstimate out;
  out.K = theta_[0];
  out.B = theta_[4];
  out.shift = theta_.segment<3>(1) / theta_[0];
  const double most = options_.most_shift;
  if (out.shift.norm() > most) out.shift *= most / out.shift.norm();
  out.mu = theta_[5];
  out.sd_K = std::sqrt(std::max(P_(0, 0), 0.0));
  // Along the last normal: d(K shift . n) - shift . n dK, divided by K.
  Vec g = Vec::Zero();
  g.segment<3>(1) = normal_;
  g[0] = -out.shift.dot(normal_);
  out.sd_shift = std::sqrt(std::max(g.dot(P_ * g), 0.0)) / theta_[0];
  out.margin = std::sqrt(residual2_);
  return out;
}

}  // namespace palpate::network
