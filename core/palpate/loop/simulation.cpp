#include "palpate/loop/simulation.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <thread>

namespace palpate::loop {
namespace {

constexpr double kMaxCatchUp = 0.05;  // [s] longest gap in real time for which the simulated world is stepped

SimulationOptions checked(SimulationOptions o, const arm::Arm& leader, const arm::Arm& follower) {
  const auto fits = [](JointVector& q, const arm::Arm& arm, const char* name) {
    if (q.size() != arm.n()) {
      throw std::invalid_argument(std::string(name) + " has " + std::to_string(q.size()) + " joints, the arm has " +
                                  std::to_string(arm.n()));
    }
    for (int i = 0; i < arm.n(); ++i) {
      if (!(q[i] >= arm.q_min()[i] && q[i] <= arm.q_max()[i])) {
        throw std::invalid_argument(std::string(name) + ": joint " + arm.joint_names()[static_cast<std::size_t>(i)] +
                                    " = " + std::to_string(q[i]) + " is outside its limits " +
                                    std::to_string(arm.q_min()[i]) + " .. " + std::to_string(arm.q_max()[i]));
      }
    }
  };
  fits(o.q_leader0, leader, "q_leader0");
  fits(o.q_follower0, follower, "q_follower0");
  if (!(o.plant_rate >= o.rate && o.plant_rate <= 100000.0)) {
    throw std::invalid_argument("plant_rate = " + std::to_string(o.plant_rate) +
                                " Hz: must be at least the cycle's rate and at most 100000 Hz, for example 10000");
  }
  if (o.guidance.servo.bandwidth < 0.0) o.guidance.servo = {o.follower.bandwidth, o.follower.damping_ratio};
  o.leader.loop_delay = o.loop_delay;  // plant::Leader checks their values
  o.leader.loop_jitter = o.loop_jitter;
  o.leader.seed = o.seed;
  return o;
}

/// The contact of a driven follower's tip with the objects, by the method `proxy`; null for a follower without drives.
std::unique_ptr<contact::Tool> make_tool_contact(const SimulationOptions& o) {
  if (!o.follower.driven) return nullptr;
  contact::Options tip = o.contact;
  tip.spheres.clear();
  tip.real_objects = true;
  return std::make_unique<contact::Tool>("proxy", tip);
}

}  // namespace

Simulation::Simulation(const SimulationOptions& options, arm::Arm leader, arm::Arm leader_model,
                       const arm::Arm& follower, std::shared_ptr<const scene::Snapshot> scene, HandPath path)
    : options_(checked(options, leader, follower)),
      cycle_(options_, std::move(leader_model), follower),
      leader_(leader, options_.leader, options_.hand),
      follower_(follower, options_.follower),
      tool_contact_(make_tool_contact(options_)),
      hand_(std::move(path), options_.X_WL, options_.tremor, options_.seed),
      substeps_(static_cast<int>(std::ceil(options_.plant_rate / options_.rate - 1e-9))),
      plant_dt_(1.0 / (options_.rate * substeps_)),
      leader_model_(leader),
      follower_model_(follower),
      thread_(options_.realtime),
      front_(cycle_.contact(), std::move(scene), options_.rate, options_.guidance) {
  leader.update(options_.q_leader0, JointVector::Zero(leader.n()));
  hand_.start(leader.tip());
  leader_.pinch(hand_.pinch());
  leader_.reset(options_.q_leader0);
  follower_.reset(options_.q_follower0, options_.mapping.jaw_start);
  in_.scene = &front_.scene();
  if (tool_contact_) tool_contact_->check(front_.scene());
  if (options_.source != force::Source::contact && !options_.follower.driven) {
    throw std::invalid_argument(
        "force source: an estimate needs the torques of the follower's drives; make the follower driven");
  }
  front_.collide();
}

std::size_t Simulation::run(std::size_t n, Tick* rows, const Vec3* hand_W) {
  const std::lock_guard lock(driver_);
  if (running()) {
    throw std::logic_error("the simulation runs in real time: stop() it before run()");
  }
  std::size_t done = 0;
  for (take(false); done < n && !in_.controls.paused; take(false)) {
    if (hand_W != nullptr) hand_.steer(hand_W[done], 1.0 / options_.rate);
    rows[done++] = tick(0.0);
    if (advances_) {
      publish();
      bodies_->advance(1.0 / options_.rate);
    }
    if (cycle_.contact().asynchronous()) {
      cycle_.contact().collide(front_.scene());
    }
  }
  hand_.stop_steering();
  if (done > 0) front_.show(rows[done - 1]);
  return done;
}

void Simulation::join(std::shared_ptr<Board> board, int index, std::vector<ToolCapsule> capsules,
                      contact::InstrumentLaw law) {
  const std::lock_guard lock(driver_);
  if (running()) throw std::logic_error("the simulation runs in real time: stop() it before join()");
  const int links = static_cast<int>(follower_model_.link_names().size());
  in_world_ = std::make_unique<InWorld>(std::move(board), index, std::move(capsules), law, links);
  publish();
}

void Simulation::join_bodies(std::shared_ptr<Bodies> bodies, int tool) {
  const std::lock_guard lock(driver_);
  if (running()) throw std::logic_error("the simulation runs in real time: stop() it before join_bodies()");
  bodies_ = std::move(bodies);
  advances_ = bodies_->options().tools.size() == 1;
  body_port_ = std::make_unique<BodyPort>(bodies_, tool, follower_model_);
  publish();
}

void Simulation::publish() noexcept {
  if (!in_world_ && !body_port_) return;
  const LeaderState& leader = leader_.measured();
  const FollowerState& follower = follower_.measured();
  const bool known = leader.q.size() == leader_model_.n() && follower.q.size() == follower_model_.n() &&
                     leader.q.allFinite() && follower.q.allFinite() && std::isfinite(follower.jaw);
  if (!known) return;
  follower_model_.update(follower.q, JointVector::Zero(follower_model_.n()));
  if (body_port_) {
    body_port_->publish(options_.X_WB * follower_model_.tip(), follower.jaw, options_.rate, follower_model_,
                        options_.X_WB);
  }
  if (!in_world_) return;
  leader_model_.update(leader.q, JointVector::Zero(leader_model_.n()));
  in_world_->publish({options_.X_WL * leader_model_.tip().p, options_.X_WB * follower_model_.tip(), options_.X_WB,
                      &follower_model_, follower.jaw, options_.rate});
}

void Simulation::attach(std::shared_ptr<RemoteEnd> remote) {
  const std::lock_guard lock(driver_);
  if (running()) throw std::logic_error("the simulation runs in real time: stop() it before attach()");
  link_.attach(std::move(remote));
  const FollowerState& follower = follower_.measured();
  if (follower.q.size() != follower_model_.n() || !follower.q.allFinite()) return;
  follower_model_.update(follower.q, JointVector::Zero(follower_model_.n()));
  link_.begin(options_.X_WB * follower_model_.tip(), follower.jaw);
}

void Simulation::watch_stages() {
  const std::lock_guard lock(driver_);
  if (running()) throw std::logic_error("the simulation runs in real time: stop() it before watch_stages()");
  stages_ = std::make_unique<StageClock>();
  cycle_.watch(stages_.get());
}

void Simulation::start() {
  const std::lock_guard lock(driver_);
  front_.open();
  thread_.start(options_.rate, [this](const Wake& w) { return wake(w); });
  front_.start_threads(options_.contact.collision_rate);
}

void Simulation::stop() {
  const std::lock_guard lock(driver_);
  thread_.stop();
  front_.stop_threads();
}

bool Simulation::wake(const Wake& w) noexcept {
  // During missed periods the drives held their last torque and the simulated world continued.
  const auto most = static_cast<std::int64_t>(kMaxCatchUp * options_.rate);
  for (std::int64_t i = 0; !in_.controls.paused && i < std::min(w.missed, most); ++i) {
    plant();
  }
  take(w.stopping);
  if (const std::int64_t stall = stall_ns_.exchange(0); stall > 0) {
    std::this_thread::sleep_for(std::chrono::nanoseconds(stall));
  }
  if (in_.controls.paused) {
    return true;
  }
  const Tick& tick = this->tick(1e-3 * static_cast<double>(w.lateness_ns));
  publish();
  front_.show(tick);
  front_.keep(tick);
  const auto zero = [](const double (&x)[3]) { return x[0] == 0.0 && x[1] == 0.0 && x[2] == 0.0; };
  const bool quiet = zero(tick.F_H_L) && zero(tick.t_H_L);
  return !(w.stopping && quiet && !cycle_.moves());
}

// Takes the controls, scene and fixtures that were set since the last tick.
void Simulation::take(bool stopping) noexcept {
  in_.controls = front_.take_controls();
  if (stopping) {
    in_.controls.following = false;
    in_.controls.paused = false;
  }
  if (!cycle_.moves()) front_.take_motion();
  in_.motion = &front_.motion();
  in_.order = front_.take_order();
  in_.order.stop |= stopping;
  turn_hand();
  const bool other = front_.take_scene(now());
  in_.scene = &front_.scene();
  if (other) {
    cycle_.forget_contacts();
    if (tool_contact_) tool_contact_->reset();
  }
  if (front_.take_fixtures()) cycle_.take(front_.fixtures());
}

// The simulated hand sees the picture: it moves in the axes in which the mapping reads it.
void Simulation::turn_hand() noexcept {
  const Eigen::Vector4d& q = in_.controls.quat_WL;
  if (q == quat_WL_) return;
  quat_WL_ = q;
  hand_.turn(q.isZero() ? options_.X_WL.R : Mat3(Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized()));
}

const Tick& Simulation::tick(double lateness_us) noexcept {
  in_.t = now();
  in_.leader = leader_.measured();
  in_.follower = follower_.measured();
  hand_.follow(cycle_.mapping(), in_.controls.p_hand_offset_W, in_.controls.hand_paused, in_.t);
  hand_.grip(in_.controls.hand_pinch);
  const HandMotion::Target& hand = hand_.step(0.0);

  const std::int64_t begin = now_ns();
  meet();
  reach_out();
  CycleOutput& out = cycle_.step(in_);
  const std::int64_t spent = now_ns() - begin;
  cycle_time_.add(spent);

  Tick& tick = out.tick;
  const Vec3& F_cell_L = in_.leader.F_cell_L;
  for (int i = 0; i < 3; ++i) {
    tick.F_cell_L[i] = F_cell_L[i];
    tick.p_hand_L[i] = hand.X_LH.p[i];
    tick.F_touch_W[i] = F_touch_W_[i];
  }
  tick.status |= leader_.hand_slipped() ? kHandSlipped : 0u;
  front_.record(tick);
  if (in_world_ || body_port_) on_tool_.record(tick);
  tick.cycle_us = 1e-3 * static_cast<double>(spent);
  tick.lateness_us = lateness_us;
  if (!faulty_ && (tick.status & (kLeaderStale | kFollowerStale | kNotFinite)) != 0) {
    faulty_ = true;
    fault_.write(tick);
  }

  if (link_.attached()) link_.remember(tick, cycle_.mapping().energy_ratio());
  leader_.command(out.leader);
  follower_.command(out.follower);
  plant();
  return tick;
}

// Wrench of the other instruments on the tool. A follower without drives renders it to the hand; a driven follower is
// pushed by it, and the hand feels it through the estimated force.
void Simulation::meet() noexcept {
  if (!in_world_ && !body_port_) return;
  if (in_world_) {
    on_tool_ = in_world_->step();
  } else {
    const Pose X_WO = on_tool_.X_WO;
    on_tool_ = OnTool{};
    on_tool_.X_WO = X_WO;
  }
  if (body_port_) on_tool_.add(body_port_->step(follower_model_));
  in_.X_WO = on_tool_.holding == Holding::carries ? &on_tool_.X_WO : nullptr;
  if (tool_contact_) return;
  in_.F_others_W = on_tool_.F_T_W;
  in_.K_others = on_tool_.stiffness;
  in_.power_others = on_tool_.power;
}

// Takes objects and force from the other end of a link.
void Simulation::reach_out() noexcept {
  if (!link_.attached()) return;
  const RemoteTick* felt = link_.step(in_.t);
  in_.controls.hold_all |= felt == nullptr || !felt->linked;
  in_.F_others_W = tool_contact_ ? Wrench{} : on_tool_.F_T_W;
  if (felt == nullptr) return;
  if (felt->scene != nullptr) in_.scene = felt->scene;
  in_.F_others_W.f += felt->F;
}

// Steps the simulated world by one period of the cycle.
void Simulation::plant() noexcept {
  for (int i = 0; i < substeps_; ++i) {
    const HandMotion::Target& hand = hand_.step(plant_dt_);
    leader_.pinch(hand.gripper);
    leader_.step(plant_dt_, hand.X_LH, hand.V_LH);
    follower_.step(plant_dt_, touch(in_.t + i * plant_dt_));
  }
  ++k_;
}

// Wrench of the objects on the tool of a driven follower, in B. It is the same contact law as for virtual contact, here
// applied to the simulated body at the plant's rate.
Wrench Simulation::touch(double t) noexcept {
  if (!tool_contact_) return {};
  const plant::FollowerDrives& drives = *follower_.drives();
  const Pose& X_WB = options_.X_WB;
  const Vec3 p_WT = X_WB * drives.tip().p;
  const Twist V_BT = drives.twist();
  const ContactSet& contacts = tool_contact_->step(*in_.scene, &p_WT, t);
  const force::ForceTerms terms = force::step(contacts, {X_WB.R * V_BT.v, X_WB.R * V_BT.w},
                                              in_.controls.stiffness_scale, in_.controls.damping_scale);
  F_touch_W_ = terms.F;
  const Wrench F_T_W = Wrench{terms.F, terms.torque} + on_tool_.F_T_W;
  return {X_WB.R.transpose() * F_T_W.f, X_WB.R.transpose() * F_T_W.t};
}

std::string Simulation::fault() {
  const std::lock_guard lock(fault_readers_);
  const Tick& tick = fault_.read();
  const std::uint64_t status = tick.status;
  if (status == 0) {
    const std::string thrown = front_.collider_fault();
    return thrown.empty() ? thrown : "contact method " + options_.method + ": " + thrown;
  }
  std::ostringstream words;
  words << "at t = " << tick.t << " s";
  words << ((status & kNotFinite) != 0 ? ", a number was not finite, or beyond a million" : "");
  words << ((status & kLeaderStale) != 0 ? ", the leader's state was older than stale_after or invalid" : "");
  words << ((status & kFollowerStale) != 0 ? ", the follower's state was older than stale_after or invalid" : "");
  words << ": the force went to zero, gravity stayed compensated. Last leader joints";
  for (const double q : tick.q) {
    words << ' ' << q;
  }
  words << " rad, follower joints";
  for (const double q : tick.q_follower) {
    words << ' ' << q;
  }
  words << ", force on the hand (L) " << tick.F_H_L[0] << ' ' << tick.F_H_L[1] << ' ' << tick.F_H_L[2] << " N";
  return words.str();
}

}  // namespace palpate::loop
