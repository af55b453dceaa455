#include "palpate/loop/bodies.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "palpate/force/force.hpp"
#include "palpate/types/index.hpp"
#include "palpate/types/so3.hpp"

namespace palpate::loop {
namespace {

constexpr double kFastest = 2.0;      // [m/s] a faster tool has jumped, and its velocity is not known
constexpr int kMostSteps = 20;        // of the engine at once, after which it gives up catching up
constexpr double kPushes = 20.0;      // [N] largest force of an object of the scene on a body
constexpr double kTipLength = 0.1;    // [m] motion of the tip that counts as much as a radian
constexpr double kStuckJoint = 2e-3;  // [m] singular value of the tip's Jacobian below which a joint counts as stuck
constexpr double kHuge = 1e10;        // a larger number of the engine's state is none

bool finite(const double* x, std::size_t n) noexcept {
  return std::all_of(x, x + n, [](double v) { return std::abs(v) <= kHuge; });
}

Pose pose_of(const EngineBody& body) noexcept {
  const double* x = body.pose;
  return {Eigen::Quaterniond(x[3], x[4], x[5], x[6]).normalized().toRotationMatrix(), {x[0], x[1], x[2]}};
}

void set_pose(const EngineBody& body, const Pose& X) noexcept {
  const Eigen::Quaterniond q(X.R);
  const double x[7] = {X.p.x(), X.p.y(), X.p.z(), q.w(), q.x(), q.y(), q.z()};
  std::copy(std::begin(x), std::end(x), body.pose);
  std::fill(body.velocity, body.velocity + 6, 0.0);
}

Twist velocity_of(const EngineBody& body, const Mat3& R) noexcept {
  return {Vec3(body.velocity[0], body.velocity[1], body.velocity[2]),
          R * Vec3(body.velocity[3], body.velocity[4], body.velocity[5])};
}

/// Puts a wrench about the body's origin on it.
void load(const EngineBody& body, const Mat3& R, const Wrench& F) noexcept {
  const Vec3 t = F.t - (R * body.com).cross(F.f);
  for (int i = 0; i < 3; ++i) {
    body.load[i] = F.f[i];
    body.load[3 + i] = t[i];
  }
}

void require(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(std::string("bodies: ") + what);
}

/// Number of a link of a tool among all that are coupled.
std::size_t coupled(std::size_t tool, std::size_t link) noexcept { return to_index(kMaxBodyTools) * (1 + link) + tool; }

BodiesOptions checked(BodiesOptions o) {
  require(o.step != nullptr && o.model != nullptr && o.data != nullptr, "there is no engine");
  require(o.bodies.size() <= to_index(kMaxBodies), "more than 48 bodies move");
  require(!o.tools.empty() && o.tools.size() <= to_index(kMaxBodyTools), "1 to 4 tools are possible");
  require(o.period >= 1e-4 && o.period <= 0.02, "the period must be between 0.1 and 20 ms");
  for (const double x : {o.stiffness, o.damping, o.stiffness_w, o.damping_w, o.force_max, o.release}) {
    require(x >= 0.0 && std::isfinite(x), "the values of the coupling must be finite and at least 0");
  }
  for (const EngineTool& tool : o.tools) {
    require(tool.links.size() <= to_index(kMaxBodyLinks), "a tool has at most 2 links that touch bodies");
  }
  return o;
}

}  // namespace

Wrench coupling_wrench(const BodiesOptions& o, const ToolMotion& tool, const VirtualTool& at, double share_w) noexcept {
  Vec3 spring = o.stiffness * (at.X_WV.p - tool.X_WT.p);
  if (const double norm = spring.norm(); norm > o.force_max) spring *= o.force_max / norm;
  const Vec3 turned = rotation_vector(at.X_WV.R * tool.X_WT.R.transpose());
  return {spring + o.damping * (at.V_WV.v - tool.V_WT.v),
          share_w * (o.stiffness_w * turned + o.damping_w * (at.V_WV.w - tool.V_WT.w))};
}

Wrench carried_to_tip(const arm::Arm& arm, const Vec3& p_S, std::uint32_t joints, const Wrench& F_S) noexcept {
  const Vec3 t = F_S.t + (p_S - arm.tip().p).cross(F_S.f);  // about the tip, if the link moved with it
  Vec6 F;
  F << F_S.f, t / kTipLength;
  Vec6 moved = Vec6::Zero();
  Mat6 all = kStuckJoint * kStuckJoint * Mat6::Identity();
  for (int j = 0; j < arm.n(); ++j) {
    Vec6 J = arm.jacobian().col(j);
    J.tail<3>() *= kTipLength;
    all += J * J.transpose();
    if ((joints >> static_cast<unsigned>(j) & 1u) != 0) moved += J * J.dot(F);
  }
  const Vec6 F_T = all.ldlt().solve(moved);
  return {F_T.head<3>(), kTipLength * F_T.tail<3>()};
}

void ToolMotion::move(const Pose& X, double rate) noexcept {
  const Vec3 v = rate * (X.p - X_WT.p);
  const Vec3 w = rate * rotation_vector(X.R * X_WT.R.transpose());
  if (known && v.norm() < kFastest) {
    V_WT.v += kVelocityFilter * (v - V_WT.v);
    V_WT.w += kVelocityFilter * (w - V_WT.w);
  } else {
    V_WT = Twist{};
  }
  X_WT = X;
  known = true;
}

Bodies::Bodies(BodiesOptions options, std::shared_ptr<const scene::Snapshot> scene)
    : options_(checked(std::move(options))),
      scene_(std::move(scene)),
      thread_({.allow_affinity = false, .priority = 70, .spin_us = 0.0}) {
  for (const MovingBody& one : options_.bodies) {
    start_.emplace_back();
    std::copy(one.body.pose, one.body.pose + 7, start_.back().begin());
    touch_.emplace_back();
    if (one.spheres.empty()) continue;
    contact::Options touching;
    touching.radius = one.spheres.front().radius;
    touching.spheres.assign(one.spheres.begin() + 1, one.spheres.end());
    touch_.back() = std::make_unique<contact::Tool>("proxy", touching);
    touch_.back()->check(*scene_);
  }
  for (const EngineNumbers& some : options_.state) first_.emplace_back(some.at, some.at + some.size);
  publish();
}

void Bodies::advance(double dt) noexcept {
  due_ += dt;
  for (int i = 0; due_ >= options_.period * (1.0 - 1e-9); ++i) {
    due_ -= options_.period;
    if (i < kMostSteps) step();
  }
}

void Bodies::start() {
  if (running()) return;
  thread_.start(1.0 / options_.period, [this](const Wake& wake) {
    advance(options_.period * static_cast<double>(1 + wake.missed));
    return !wake.stopping;
  });
}

void Bodies::stop() { thread_.stop(); }

BodyStates Bodies::states() {
  const std::lock_guard lock(readers_);
  return shown_.read();
}

// One step of the engine under the couplings of all tools and the objects of the scene.
void Bodies::step() noexcept {
  const std::int64_t begin = now_ns();
  for (std::size_t k = 0; k < options_.tools.size(); ++k) {
    const EngineTool& tool = options_.tools[k];
    drive(tool.body, k, 1.0);
    for (std::size_t i = 0; i < tool.links.size(); ++i) drive(tool.links[i].body, coupled(k, i), tool.links[i].share_w);
    for (std::size_t i = 0; i < 2; ++i) {
      if (tool.jaw[i] != nullptr && placed_[k]) *tool.jaw[i] = tool.jaw_ratio[i] * to_engine_[k].read().jaw;
    }
  }
  for (std::size_t k = 0; k < options_.bodies.size(); ++k) press(k);
  options_.step(options_.model, options_.data);
  if (sound()) {
    for (std::size_t k = 0; k < options_.bodies.size(); ++k) bring_back(k);
  } else {
    restart();
  }
  states_.t += options_.period;
  publish();
  step_time_.add(now_ns() - begin);
}

// Drives a virtual tool, or link, by its coupling. One that is stuck far away, or whose tool jumped, is put back to it.
void Bodies::drive(const EngineBody& body, std::size_t k, double share_w) noexcept {
  ToolMotion to = to_engine_[k].read();
  if (!to.known) return;
  to.X_WT.p -= due_ * to.V_WT.v;  // of several steps in a tick, each sees the tool at its own end
  to.X_WT.R = rotation_by(-due_ * to.V_WT.w) * to.X_WT.R;
  const bool away = !((pose_of(body).p - to.X_WT.p).norm() <= options_.release);
  if (!placed_[k] || away) {
    set_pose(body, to.X_WT);
    placed_[k] = true;
  }
  // The engine itself adds -(damping + period stiffness) times the velocity at the end of its step, so here the virtual
  // tool counts as at rest. The tool is where it is at the end of this step; against the virtual tool at its begin, a
  // moving one would come to rest one step ahead of it, and this lead would push the hand with K v period.
  VirtualTool at = seen(body, k);
  const Twist V = std::exchange(at.V_WV, Twist{});
  const BodiesOptions& o = options_;
  const Wrench F = coupling_wrench(o, to, at, share_w);
  load(body, at.X_WV.R, {-F.f, -F.t});
  const Vec3 f = -F.f - (o.damping + o.period * o.stiffness) * V.v;
  const Vec3 t = -F.t - share_w * (o.damping_w + o.period * o.stiffness_w) * V.w;
  states_.delivered += o.period * (f.dot(V.v) + t.dot(V.w));
}

// Presses a body against the objects of the scene, by the contact stage of the tools.
void Bodies::press(std::size_t k) noexcept {
  if (!touch_[k]) return;
  const MovingBody& one = options_.bodies[k];
  const Pose X = pose_of(one.body);
  const Twist V = velocity_of(one.body, X.R);
  std::array<Vec3, contact::kMaxSpheres> centres;
  for (std::size_t s = 0; s < one.spheres.size(); ++s) centres[s] = X * one.spheres[s].centre(0.0);
  const ContactSet& contacts = touch_[k]->step(*scene_, centres.data(), states_.t);
  const Vec3 arm = centres[0] - X.p;  // the force stage takes the first sphere for the tool's origin
  const force::ForceTerms terms = force::step(contacts, {V.v + V.w.cross(arm), V.w}, 1.0, 1.0);
  Wrench F{terms.F, terms.torque + arm.cross(terms.F)};
  if (const double norm = F.f.norm(); norm > kPushes) F = {F.f * (kPushes / norm), F.t * (kPushes / norm)};
  load(one.body, X.R, F);
}

// A body that left the field returns to its start.
void Bodies::bring_back(std::size_t k) noexcept {
  const EngineBody& body = options_.bodies[k].body;
  const Vec3 p(body.pose[0], body.pose[1], body.pose[2]);
  const bool inside = (p.array() >= options_.low.array()).all() && (p.array() <= options_.high.array()).all();
  if (inside) return;
  std::copy(start_[k].begin(), start_[k].end(), body.pose);
  std::fill(body.velocity, body.velocity + 6, 0.0);
  ++states_.lost[k];
  if (touch_[k]) touch_[k]->reset();
}

bool Bodies::sound() const noexcept {
  return std::all_of(options_.state.begin(), options_.state.end(),
                     [](const EngineNumbers& some) { return finite(some.at, some.size); });
}

// What is not finite spreads through the engine's solver and stays, in jaws and threads too: all begins anew.
void Bodies::restart() noexcept {
  ++states_.restarts;
  for (std::size_t k = 0; k < options_.bodies.size(); ++k) {
    const EngineBody& body = options_.bodies[k].body;
    states_.lost[k] += finite(body.pose, 7) && finite(body.velocity, 6) ? 0 : 1;
    if (touch_[k]) touch_[k]->reset();
  }
  for (std::size_t i = 0; i < first_.size(); ++i) std::copy(first_[i].begin(), first_[i].end(), options_.state[i].at);
  placed_.fill(false);
}

VirtualTool Bodies::seen(const EngineBody& body, std::size_t number) const noexcept {
  VirtualTool at;
  at.t = states_.t;
  at.X_WV = pose_of(body);
  at.V_WV = velocity_of(body, at.X_WV.R);
  at.known = placed_[number];
  if (number >= to_index(kMaxBodyTools)) return at;
  double strongest = 0.0;
  for (std::size_t k = 0; k < options_.bodies.size(); ++k) {
    const auto& [a, b] = states_.grip[number * to_index(kMaxBodies) + k];
    if (const double both = std::min(a, b); both > strongest) {
      strongest = both;
      at.holds = static_cast<int>(k);
    }
  }
  if (at.holds >= 0) at.X_WO = pose_of(options_.bodies[to_index(at.holds)].body);
  return at;
}

void Bodies::publish() noexcept {
  for (std::size_t k = 0; k < options_.bodies.size(); ++k) {
    std::copy(options_.bodies[k].body.pose, options_.bodies[k].body.pose + 7, states_.pose[k].begin());
  }
  for (std::size_t n = 0; n < options_.tools.size(); ++n) {
    for (std::size_t k = 0; k < options_.bodies.size(); ++k) {
      for (std::size_t jaw = 0; jaw < 2; ++jaw) {
        const double* found = options_.tools[n].grip[jaw];
        states_.grip[n * to_index(kMaxBodies) + k][jaw] =
            found == nullptr ? 0.0 : std::hypot(found[4 * k + 1], found[4 * k + 2], found[4 * k + 3]);
      }
    }
    to_loop_[n].write(seen(options_.tools[n].body, n));
    for (std::size_t i = 0; i < options_.tools[n].links.size(); ++i) {
      to_loop_[coupled(n, i)].write(seen(options_.tools[n].links[i].body, coupled(n, i)));
    }
  }
  shown_.write(states_);
}

BodyPort::BodyPort(std::shared_ptr<Bodies> bodies, int tool, const arm::Arm& arm)
    : bodies_(std::move(bodies)), tool_(static_cast<std::size_t>(tool)) {
  require(tool >= 0 && tool_ < bodies_->options().tools.size(), "there is no such tool");
  for (const EngineLink& one : this->tool().links) {
    require(one.link >= 0 && one.link < static_cast<int>(arm.link_names().size()), "the arm has no such link");
  }
}

void BodyPort::publish(const Pose& X_WT, double jaw, double rate, const arm::Arm& arm, const Pose& X_WA) noexcept {
  if (rate > 0.0) silent_ += 1.0 / rate;
  motion_.move(X_WT, rate);
  motion_.jaw = jaw;
  bodies_->write(tool_, motion_);
  X_WA_ = X_WA;
  for (std::size_t i = 0; i < tool().links.size(); ++i) {
    links_[i].move(X_WA * arm.link_pose(tool().links[i].link), rate);
    bodies_->write(coupled(tool_, i), links_[i]);
  }
}

const BodyContact& BodyPort::step(const arm::Arm& arm) noexcept {
  out_ = BodyContact{};
  const VirtualTool& at = bodies_->read(tool_);
  if (at.t != std::exchange(heard_, at.t)) silent_ = 0.0;
  if (!at.known || !motion_.known) return out_;
  if (const bool before = std::exchange(quiet_, silent_ > kEngineSilent); quiet_ && !before) bodies_->count_silence();
  if (quiet_) return out_;
  const BodiesOptions& o = bodies_->options();
  out_.F_T_W = coupling_wrench(o, motion_, at);
  out_.F_held_W = out_.F_T_W.f;
  out_.stiffness = o.stiffness;
  out_.holds = at.holds;
  out_.X_WO = at.X_WO;
  for (std::size_t i = 0; i < tool().links.size(); ++i) add_link(i, arm);
  return out_;
}

// Adds the wrench of a link's coupling, as the tip feels it.
void BodyPort::add_link(std::size_t i, const arm::Arm& arm) noexcept {
  const EngineLink& link = tool().links[i];
  const VirtualTool& at = bodies_->read(coupled(tool_, i));
  const ToolMotion& to = links_[i];
  if (!at.known || !to.known) return;
  const BodiesOptions& o = bodies_->options();
  const Wrench F = coupling_wrench(o, to, at, link.share_w);
  const Mat3& R = X_WA_.R;
  const Vec3 p = R.transpose() * (to.X_WT.p - X_WA_.p);
  const Wrench F_T = carried_to_tip(arm, p, link.joints, {R.transpose() * F.f, R.transpose() * F.t});
  out_.F_T_W = out_.F_T_W + Wrench{R * F_T.f, R * F_T.t};
  out_.stiffness += o.stiffness;
}

}  // namespace palpate::loop
