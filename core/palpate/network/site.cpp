#include "palpate/network/site.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "palpate/types/require.hpp"
#include "palpate/types/so3.hpp"

namespace palpate::network {
namespace {

constexpr double kNear = 0.85;          // share of the cap from which no step goes deeper
constexpr double kRetreat = 0.05;       // [m/s] speed with which the goal leaves a force above that share
constexpr double kNearEnough = 5e-4;    // [m] distance at which the tool counts as aligned
constexpr double kTurnedEnough = 0.05;  // [rad] the same of its orientation
constexpr double kPlayMargin = 2e-3;    // [s] beyond the 99th percentile of the age
constexpr double kMeasurable = 0.05;    // [N] smaller forces are noise
constexpr double kFar = 0.05;           // [m] farther objects are not touched
constexpr double kClose = 0.01;         // [m] distance within which contacts are computed
constexpr double kSure = 3.0;           // [standard deviations] by which a surface may be nearer than estimated
constexpr double kBrake = 2e-3;         // [m] distance beyond that from which the tool approaches slowly
constexpr double kCreep = 2e-3;         // [m/s] speed near a surface that costs nothing worth counting
constexpr double kDisagrees = 0.3;      // [N] margin from which the site reports that the model does not fit
constexpr double kFarthest = 100.0;     // [m] no tool is farther away
constexpr double kFastest = 100.0;      // [m/s] or faster
constexpr double kStrongest = 1000.0;   // [N] or pushed by more

/// True if sensors can measure this; false for NaN.
bool possible(const SiteInput& in) noexcept {
  return in.X.p.norm() < kFarthest && in.X.R.allFinite() && std::isfinite(in.jaw) && in.v.norm() < kFastest &&
         in.F.norm() < kStrongest;
}

}  // namespace

Site::Site(const SiteOptions& options, scene::Snapshot scene)
    : options_(options),
      scene_(std::move(scene)),
      unknown_(options.estimator, options.radius),
      account_(options.allowance) {
  require("remote", options.force_cap > 0.0, "force_cap", options.force_cap, "must be above 0 N");
  require("remote", options.mass > 0.0, "mass", options.mass, "must be above 0 kg");
  require("remote", options.speed > 0.0 && options.catch_up > 0.0, "speed", options.speed, "must be above 0 m/s");
  require("remote", options.turn > 0.0, "turn", options.turn, "must be above 0 rad/s");
  if (options.planes) scene_.objects.push_back(Unknown::object(options.estimator));
  for (const scene::Object& object : scene_.objects) {
    EstimatorOptions o = options.estimator;
    o.K = object.material.K.mean();
    o.sd_K = o.K;
    estimators_.emplace_back(o);
    const bool rigid = object.surface->deformable() == nullptr;
    copies_.push_back(rigid ? std::make_unique<Copies>(object, options.radius) : nullptr);
  }
}

void Site::receive(const Datagram& d, double now) noexcept {
  peer_.receive(d, now);
  playout_.add(d);
}

void Site::forget_operator() noexcept {
  peer_ = Peer{};
  playout_ = Playout{};
  port_ = Port{};
  account_ = options_.allowance;
  hand_in_ = 0.0;
  aligning_ = true;
}

const SiteGoal& Site::step(const SiteInput& in, double dt) noexcept {
  peer_.step(in.t);
  if (!possible(in)) {  // a sensor failed: the goal rests
    goal_.v.setZero();
    goal_.flags = kHolding;
    aligning_ = true;
    return goal_;
  }
  if (!started_) {
    goal_.X = in.X;
    goal_.jaw = in.jaw;
    in_ = in;
    port_.carried();
    aligning_ = started_ = true;
  }
  book(in);
  learn(in);
  follow(in, dt);
  in_ = in;
  return goal_;
}

// The account: what the hand has put in since the last tick, less the work of the tool on the tissue. Mode passivity
// leaves out what the tissue has returned, since the hand may have it.
void Site::book(const SiteInput& in) noexcept {
  const auto spent = [this] { return options_.mode == Mode::passivity ? port_.out() : -port_.net(); };
  const double before = spent();
  port_.step(-0.5 * (in.F + in_.F), in.X.p);
  account_ -= spent() - before;
  if (peer_.known()) {
    const double received = std::max(peer_.newest().energy_in, hand_in_);
    account_ += received - hand_in_;
    hand_in_ = received;
  }
  account_ = std::min(account_, options_.capacity);
}

// Shows the nearest object and the measured force to its estimator.
void Site::learn(const SiteInput& in) noexcept {
  near_ = Near{};
  nearest_ = -1;
  Touch touch;
  const std::size_t known = scene_.objects.size() - (options_.planes ? 1 : 0);
  for (std::size_t i = 0; i < known; ++i) consider(i, in, touch);
  if (options_.planes) {
    unknown_.seek(in.X.p, in.F, near_.gap < near_.unsure + kBrake, scene_.objects[known], estimators_[known],
                  *copies_[known]);
    if (unknown_.exists()) consider(known, in, touch);
  }
  if (nearest_ >= 0) tell(static_cast<std::size_t>(nearest_), in, touch);
}

// Takes an object as the nearest one if it is.
void Site::consider(std::size_t i, const SiteInput& in, Touch& touch) noexcept {
  const scene::Object& object = scene_.objects[i];
  if (!object.is_virtual) return;
  const Pose X_WO = object.pose(in.t);
  const ModelEstimate now = estimators_[i].estimate();
  const Vec3 p_O = X_WO.inverse() * (in.X.p - now.shift);  // the surface is asked where the object is believed to be
  const scene::Nearest c = object.surface->nearest(p_O);
  const double gap = signed_distance(c, p_O) - options_.radius;
  if (!(std::abs(gap) < std::min(std::abs(near_.gap), kFar))) return;
  nearest_ = static_cast<int>(i);
  const Vec3 n = X_WO.R * c.normal;
  const Vec3 v = object.motion.velocity(in.X.p, in.t);
  touch = {-gap - n.dot(now.shift), n, in.v - v, in.F};
  near_ = {gap, kSure * now.sd_shift, n, v, now.K + now.sd_K};
}

// Shows a touch of the object to its estimator.
void Site::tell(std::size_t i, const SiteInput& in, Touch touch) noexcept {
  Prediction prediction;
  if (copies_[i] != nullptr && std::abs(near_.gap) < kClose) {
    prediction = copies_[i]->step(estimators_[i], in.X.p, in.t);
    const Contact& c = copies_[i]->contact();
    if (prediction.touching) {
      touch.normal = c.normal;
      touch.depth = c.depth - c.normal.dot(estimators_[i].estimate().shift);
    }
  }
  if (!estimators_[i].step(touch, prediction)) return;
  touched_ = nearest_;
  if (options_.planes && i + 1 == scene_.objects.size())
    unknown_.follow(in.X.p, in.F, scene_.objects[i], estimators_[i], *copies_[i]);
}

// A step of the goal that comes near to a surface no faster than the account can pay for the tool's kinetic energy.
Vec3 Site::slowed(const Vec3& step, double dt) const noexcept {
  if (options_.mode == Mode::direct || near_.gap > near_.unsure + kBrake) return step;
  const double most = std::max(std::sqrt(2.0 * std::max(account_, 0.0) / options_.mass), kCreep);
  const double towards = -near_.normal.dot(step - near_.v * dt);
  return towards > most * dt ? Vec3(step + (towards - most * dt) * near_.normal) : step;
}

// Energy that the tool spends on the tissue until it rests at the goal, `left` deeper than now: by the force now, by
// its growth on the way, and by the speed of the tool.
double Site::pending(const SiteInput& in, const Vec3& out, double left) const noexcept {
  const double speed = std::max(-out.dot(in.v - near_.v), 0.0);
  return (in.F.norm() + 0.5 * near_.K * left) * left + 0.5 * options_.mass * speed * speed;
}

// The largest part of a step of the goal that force and energy allow.
Vec3 Site::allowed(const Vec3& step, const SiteInput& in, double dt) noexcept {
  const double F = in.F.norm();
  if (F < kMeasurable) return step;
  const Vec3 out = in.F / F;
  Vec3 result = step;
  const double near = kNear * options_.force_cap, deeper = -out.dot(step), soft = 0.1 * options_.force_cap;
  const double left = std::max(-out.dot(goal_.X.p - in.X.p), 0.0), cost = pending(in, out, left);
  const bool saves = options_.mode != Mode::direct;
  if (deeper > 0.0) {
    const double more = (F + near_.K * (left + 0.5 * deeper)) * deeper;
    double share = saves ? std::clamp((account_ - cost) / more, 0.0, 1.0) : 1.0;
    share = std::min(share, std::clamp((near - F) / soft, 0.0, 1.0));
    if (share < 1.0) goal_.flags |= kLimited;
    result += (1.0 - share) * deeper * out;
  }
  // Mode passivity counts no returns, so there a retreat only saves what is still pending.
  const double account = options_.mode == Mode::passivity ? std::max(account_, 0.0) : account_;
  const double owed = saves ? std::max(cost - account, 0.0) / options_.allowance : 0.0;
  if (F > near || owed > 0.0) {
    result += out * kRetreat * dt * std::clamp(std::max((F - near) / soft, owed), 0.0, 1.0);
    goal_.flags |= kLimited;
  }
  return result;
}

// Moves the goal towards the played motion.
void Site::follow(const SiteInput& in, double dt) noexcept {
  const Arrivals& arrivals = peer_.arrivals();
  const double now = peer_.clock().known() ? peer_.peer_time(in.t) : (peer_.known() ? peer_.newest().t : 0.0);
  played_ = playout_.step(now, arrivals.p99() + kPlayMargin, dt);
  goal_.flags = 0;
  const bool drives = !playout_.empty() && peer_.clock().known() && !peer_.lost() && (played_.flags & kEngaged) != 0;
  const Vec3 before = goal_.X.p;
  if (drives) {
    Vec3 step = played_.X.p - goal_.X.p;
    const double most = (aligning_ ? options_.catch_up : options_.speed) * dt;
    if (step.norm() > most) step *= most / step.norm();
    goal_.X.p += allowed(slowed(step, dt), in, dt);
    const Vec3 turn = rotation_vector(played_.X.R * goal_.X.R.transpose());
    const double angle = turn.norm(), most_turn = options_.turn * dt;
    goal_.X.R = angle > most_turn ? Mat3(rotation_by(turn * (most_turn / angle)) * goal_.X.R) : played_.X.R;
    goal_.jaw += std::clamp(played_.jaw - goal_.jaw, -most_turn, most_turn);
    if (((played_.X.p - goal_.X.p).norm() < kNearEnough && angle < kTurnedEnough) || (goal_.flags & kLimited) != 0)
      aligning_ = false;
  } else {
    goal_.flags |= kHolding;
    goal_.X.p += allowed(Vec3::Zero(), in, dt);
    aligning_ = true;
  }
  goal_.v = (goal_.X.p - before) / dt;
  goal_.flags |= aligning_ ? 0u : kAligned;
}

Datagram Site::send() const noexcept {
  Datagram d;
  d.X = in_.X;
  d.v = in_.v;
  d.jaw = in_.jaw;
  d.F = in_.F;
  d.energy_in = port_.in();
  d.energy_out = port_.out();
  d.play_delay = std::max(playout_.delay(), 0.0);
  d.flags = goal_.flags;
  if (touched_ >= 0) {
    d.model = estimators_[static_cast<std::size_t>(touched_)].estimate();
    d.model.object = static_cast<std::uint16_t>(touched_);
    if (options_.planes && touched_ + 1 == static_cast<int>(scene_.objects.size()))
      unknown_.describe(d.model, scene_.objects.back());
    if (d.model.margin > kDisagrees) d.flags |= kUnmodelled;
  }
  peer_.stamp(d, in_.t);
  return d;
}

}  // namespace palpate::network
