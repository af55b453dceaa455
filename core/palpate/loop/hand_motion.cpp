#include "palpate/loop/hand_motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>

#include "palpate/types/random.hpp"

namespace palpate::loop {
namespace {

constexpr double kOpenHand = 0.6;        // [rad] default pinch angle
constexpr double kPinchRate = 3.0;       // [rad/s] at which a hand pinches that is told an angle
constexpr double kGlideFrequency = 8.0;  // [rad/s] of the critically damped transition to another path
constexpr double kGlideSpeed = 0.25;     // [m/s] largest speed of that transition
constexpr double kGlideEnd = 1e-18;      // [m], [m/s] rest of a transition that no position of a hand can show
constexpr int kSinusoids = 5;            // number of sinusoids of a tremor

/// Share of a minimum-jerk motion that is done after the share s of its time.
double minimum_jerk(double s) noexcept { return s * s * s * (10.0 - 15.0 * s + 6.0 * s * s); }

/// Index of the first time after t; times.size() if there is none. Tries `guess` first.
std::size_t first_after(const std::vector<double>& times, double t, std::size_t guess) noexcept {
  if (guess > 0 && guess < times.size() && times[guess - 1] <= t && t < times[guess]) return guess;
  return static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), t) - times.begin());
}

}  // namespace

HandPath::HandPath(std::vector<double> times, std::vector<Vec3> positions_W, std::vector<double> grippers,
                   std::vector<double> grip_times)
    : times_(std::move(times)),
      positions_(std::move(positions_W)),
      grippers_(std::move(grippers)),
      grip_times_(grip_times.empty() && !grippers_.empty() ? times_ : std::move(grip_times)) {
  const auto wrong = [](std::size_t i, const std::string& what) {
    throw std::invalid_argument("hand path: way point " + std::to_string(i) + ": " + what);
  };
  if (times_.size() != positions_.size() || (!grippers_.empty() && grippers_.size() != grip_times_.size())) {
    throw std::invalid_argument("hand path: " + std::to_string(times_.size()) + " times, " +
                                std::to_string(positions_.size()) + " positions, " + std::to_string(grippers_.size()) +
                                " pinch angles: give one of each per way point (pinch angles may be left out)");
  }
  for (std::size_t i = 0; i < grippers_.size(); ++i) {
    if (!std::isfinite(grippers_[i]) || !std::isfinite(grip_times_[i]) ||
        (i > 0 && grip_times_[i] <= grip_times_[i - 1])) {
      wrong(i, "its pinch angle or time is not finite, or its time is not after the one before");
    }
  }
  for (std::size_t i = 0; i < times_.size(); ++i) {
    if (!std::isfinite(times_[i]) || !positions_[i].allFinite()) wrong(i, "not finite");
    if (i > 0 && times_[i] <= times_[i - 1]) {
      wrong(i, "time " + std::to_string(times_[i]) + " s is not after the one before (" +
                   std::to_string(times_[i - 1]) + " s)");
    }
  }
}

// The velocity at a way point.
Vec3 HandPath::velocity(std::size_t i) const noexcept {
  if (i == 0 || i + 1 >= times_.size()) return Vec3::Zero();
  const Vec3 a = (positions_[i] - positions_[i - 1]) / (times_[i] - times_[i - 1]);
  const Vec3 b = (positions_[i + 1] - positions_[i]) / (times_[i + 1] - times_[i]);
  if (!(a.dot(b) > 0.0)) return Vec3::Zero();
  return 2.0 * a.dot(b) / (a + b).squaredNorm() * (a + b);
}

HandPath::Point HandPath::at(double t, Cursor& cursor) const noexcept {
  const double gripper = pinch(t, cursor.grip);
  if (times_.empty()) return {Vec3::Zero(), Vec3::Zero(), gripper};
  const std::size_t after = cursor.point = first_after(times_, t, cursor.point);
  if (after == 0) return {positions_.front(), Vec3::Zero(), gripper};
  if (after == times_.size()) return {positions_.back(), Vec3::Zero(), gripper};
  // The quintic from one way point to the next, in powers of the share s of the time that has passed: positions and
  // velocities of both ends, zero acceleration. Kept for an hour of way points, quintics would fill 24 MB.
  const std::size_t before = after - 1;
  const double T = times_[after] - times_[before], per_time = 1.0 / T, s = (t - times_[before]) * per_time;
  const double s2 = s * s, s3 = s2 * s, s4 = s2 * s2, s5 = s3 * s2;
  const Vec3 start = positions_[before], whole = positions_[after] - start;
  const Vec3 power1 = T * velocity(before), b = T * velocity(after);
  const Vec3 power3 = 10.0 * whole - 6.0 * power1 - 4.0 * b, power4 = -15.0 * whole + 8.0 * power1 + 7.0 * b,
             power5 = 6.0 * whole - 3.0 * power1 - 3.0 * b;
  return {start + s * power1 + (s3 * power3 + s4 * power4 + s5 * power5),
          per_time * (power1 + (3.0 * s2) * power3 + (4.0 * s3) * power4 + (5.0 * s4) * power5), gripper};
}

// The pinch angle at the time t.
double HandPath::pinch(double t, std::size_t& cursor) const noexcept {
  if (grippers_.empty()) return kOpenHand;
  const std::size_t after = cursor = first_after(grip_times_, t, cursor);
  if (after == 0) return grippers_.front();
  if (after == grip_times_.size()) return grippers_.back();
  const double s = (t - grip_times_[after - 1]) / (grip_times_[after] - grip_times_[after - 1]);
  return grippers_[after - 1] + minimum_jerk(s) * (grippers_[after] - grippers_[after - 1]);
}

HandMotion::HandMotion(HandPath path, const Pose& X_WL, double tremor, std::uint64_t seed)
    : path_(std::move(path)), X_WL_(X_WL), X_LW_(X_WL.inverse()) {
  if (!(tremor >= 0.0 && tremor < 0.01)) {
    throw std::invalid_argument("tremor = " + std::to_string(tremor) + " m: must be between 0 and 0.01 m rms");
  }
  if (tremor == 0.0) {
    return;
  }
  std::mt19937_64 random(seed);
  for (int i = 0; i < kSinusoids; ++i) {
    Sinusoid sinusoid;
    sinusoid.omega = 2.0 * std::numbers::pi * (8.0 + 4.0 * uniform(random));
    sinusoid.amplitude = Vec3::Constant(tremor * std::sqrt(2.0 / kSinusoids));
    for (int axis = 0; axis < 3; ++axis) {
      sinusoid.phase[axis] = 2.0 * std::numbers::pi * uniform(random);
    }
    tremor_.push_back(sinusoid);
  }
}

void HandMotion::start(const Pose& X_LH) noexcept {
  target_.X_LH = X_LH;
  target_.gripper = path_.at(t_, cursor_).gripper;
  origin_ = X_WL_ * X_LH.p;
  gain_ = 0.0;
}

void HandMotion::follow(const mapping::Mapping& mapping, const Vec3& p_offset_W, bool paused, double t) noexcept {
  t_ = t;
  if (mapping.anchor_count() == 0) {
    return;  // the tool does not follow yet, so the hand waits
  }
  const Vec3 origin = path_.empty() ? origin_ : mapping.hand_position(Vec3::Zero());
  const double gain = path_.empty() ? gain_ : 1.0 / mapping.options().scale;
  const Vec3 offset = p_offset_W.allFinite() ? p_offset_W : offset_;
  if (origin == origin_ && gain == gain_ && offset == offset_ && paused == paused_) return;
  const HandPath::Point before = intended(t);
  origin_ = origin;
  gain_ = gain;
  offset_ = offset;
  if (paused && !paused_) {
    t_paused_ = t - pause_duration_;
  } else if (paused_ && !paused) {
    pause_duration_ = t - t_paused_;
  }
  paused_ = paused;
  const HandPath::Point after = intended(t);
  glide_ += before.p - after.p;
  v_glide_ += before.v - after.v;
}

void HandMotion::turn(const Mat3& R_WL) noexcept {
  const Mat3 R_change = R_WL * X_WL_.R.transpose();
  const Vec3 p_before = X_WL_ * target_.X_LH.p;
  X_WL_.R = R_WL;
  X_LW_ = X_WL_.inverse();
  glide_ += X_WL_ * target_.X_LH.p - p_before;
  v_glide_ = R_change * v_glide_;
}

HandPath::Point HandMotion::intended(double t) noexcept {
  HandPath::Point point = path_.at(paused_ ? t_paused_ : t - pause_duration_, cursor_);
  point.v *= paused_ ? 0.0 : 1.0;
  point.p = origin_ + offset_ + gain_ * point.p;
  point.v *= gain_;
  return point;
}

void HandMotion::glide(double dt) noexcept {
  if (glide_.isZero(0.0) && v_glide_.isZero(0.0)) return;
  const double w = kGlideFrequency;
  v_glide_ -= dt * (2.0 * w * v_glide_ + w * w * glide_);
  const double speed = v_glide_.norm();
  if (speed > kGlideSpeed) {
    v_glide_ *= kGlideSpeed / speed;
  }
  glide_ += dt * v_glide_;
  if (glide_.squaredNorm() < kGlideEnd * kGlideEnd && v_glide_.squaredNorm() < kGlideEnd * kGlideEnd) {
    glide_.setZero();  // it would decay to denormal numbers, which processors compute a hundred times slower
    v_glide_.setZero();
  }
}

const HandMotion::Target& HandMotion::step(double dt) noexcept {
  t_ += dt;
  glide(dt);
  steered_ += dt * v_steered_;

  HandPath::Point hand = intended(t_);
  hand.p += glide_ + steered_;
  hand.v += v_glide_ + v_steered_;
  for (const Sinusoid& sinusoid : tremor_) {
    const Vec3 angle = sinusoid.phase + Vec3::Constant(sinusoid.omega * t_);
    hand.p += sinusoid.amplitude.cwiseProduct(angle.array().sin().matrix());
    hand.v += sinusoid.omega * sinusoid.amplitude.cwiseProduct(angle.array().cos().matrix());
  }
  target_.X_LH.p = X_LW_ * hand.p;
  target_.V_LH.v = X_LW_.R * hand.v;
  if (std::isfinite(wanted_pinch_)) {
    target_.gripper += std::clamp(wanted_pinch_ - target_.gripper, -kPinchRate * dt, kPinchRate * dt);
  } else {
    target_.gripper = hand.gripper;
  }
  return target_;
}

}  // namespace palpate::loop
