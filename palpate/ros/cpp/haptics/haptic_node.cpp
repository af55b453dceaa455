#include "haptics/haptic_node.hpp"

#include <time.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <future>
#include <stdexcept>
#include <thread>
#include <utility>

namespace palpate::ros {
namespace {

using loop::now_ns;

constexpr double kOverdue = 1.5;           // periods without a leader state after which the cycle steps anyway [-]
constexpr std::int64_t kBeat = 3'000'000;  // longest interval of the heartbeats, also without steps [ns]
constexpr int kTail = 5;                   // zero wrenches sent after the last command [-]
constexpr std::int64_t kGuardianAway = 50'000'000;  // age of the guardian's last check at which it counts as dead [ns]
constexpr auto kLonely = std::chrono::milliseconds(300);  // timeout of the ramp-down and of the acknowledgements
constexpr Qos kNewest{.depth = 5, .reliable = false};     // QoS of states, compatible with every publisher

double wall_now() noexcept {
  timespec t{};
  clock_gettime(CLOCK_REALTIME, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

template <class Msg>
double stamp_of(const Msg& message) noexcept {
  return message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec;
}

Vec3 vector(const geometry_msgs::msg::Point& p) noexcept { return {p.x, p.y, p.z}; }
Vec3 vector(const geometry_msgs::msg::Vector3& v) noexcept { return {v.x, v.y, v.z}; }
Eigen::Vector4d quaternion(const geometry_msgs::msg::Quaternion& q) noexcept { return {q.x, q.y, q.z, q.w}; }

void fill(geometry_msgs::msg::Vector3& to, const Vec3& from) noexcept {
  to.x = from.x(), to.y = from.y(), to.z = from.z();
}

template <class Header>
void stamp(Header& header, double wall) noexcept {
  const double whole = std::floor(wall);
  header.stamp.sec = static_cast<std::int32_t>(whole);
  header.stamp.nanosec = static_cast<std::uint32_t>(1e9 * (wall - whole));
}

}  // namespace

HapticNode::HapticNode(const std::shared_ptr<Context>& context, const HapticNodeOptions& options,
                       std::optional<arm::Arm> follower, std::shared_ptr<const scene::Snapshot> scene)
    : options_(options),
      beat_(options.beat_fd),
      console_(context, options.names, {"/" + options.writer, "/" + options.guardian}, options.cycle),
      node_(context, options.names.node(), options.names.space,
            [this](const std::string& words) { console_.report(words); }),
      writer_(context, options.writer, "", [this](const std::string& words) { console_.report(words); }),
      wrench_(writer_, options.names.wrench()),
      cycle_(options.cycle, std::move(follower)),
      front_(cycle_.contact(), std::move(scene), options.cycle.rate, options.cycle.guidance),
      t0_(now_ns()),
      period_(static_cast<std::int64_t>(std::llround(1e9 / options.cycle.rate))) {
  const HapticNames& names = options.names;
  if (names.own_teleop() && !names.follower.empty()) {
    goal_.emplace(writer_, names.of_follower("servo_cp"));
    jaw_.emplace(writer_, names.of_follower("jaw/servo_jp"));
    jaw_message_.name = {"jaw"};
    jaw_message_.position.resize(1);
  }
  cycle_.set_scene(front_.scene());
  front_.collide();
  subscribe_all();
}

HapticNode::~HapticNode() {
  stop();
  subscriptions_.clear();
}

// The order matters: among messages that arrive together the leader's pose is taken last, and then the cycle steps.
void HapticNode::subscribe_all() {
  const HapticNames& names = options_.names;
  const auto subscribe = [this]<class Msg>(const std::string& topic, void (*take)(HapticNode&, const Msg&)) {
    subscriptions_.push_back(std::make_unique<Subscription<Msg>>(
        node_, topic, [this, take](const Msg& message, const Info&) { take(*this, message); }, kNewest));
  };
  if (!names.follower.empty()) {
    subscribe.operator()<Pose>(names.of_follower("measured_cp"), [](HapticNode& self, const Pose& m) {
      if (!self.follower_frame_.check(m.header.frame_id)) self.cycle_.report(kBaseMoved);
      self.cycle_.follower_pose(stamp_of(m), vector(m.pose.position), quaternion(m.pose.orientation),
                                self.clock_time());
    });
    subscribe.operator()<Joints>(names.of_follower("measured_js"), [](HapticNode& self, const Joints& m) {
      self.cycle_.follower_joints(stamp_of(m), m.position.data(), m.position.size(), self.clock_time());
    });
    subscribe.operator()<Joints>(names.of_follower("jaw/measured_js"), [](HapticNode& self, const Joints& m) {
      self.cycle_.jaw(stamp_of(m), m.position.data(), m.position.size());
    });
  }
  subscribe.operator()<Joints>(names.of_leader("measured_js"), [](HapticNode& self, const Joints& m) {
    self.cycle_.leader_joints(stamp_of(m), m.position.data(), m.position.size());
  });
  subscribe.operator()<Joints>(names.of_leader("gripper/measured_js"), [](HapticNode& self, const Joints& m) {
    self.cycle_.gripper(stamp_of(m), m.position.data(), m.position.size());
  });
  subscribe.operator()<Twist>(names.of_leader("measured_cv"), [](HapticNode& self, const Twist& m) {
    self.cycle_.leader_twist(stamp_of(m), {vector(m.twist.linear), vector(m.twist.angular)}, self.clock_time());
  });
  subscribe.operator()<Pose>(names.of_leader("measured_cp"), [](HapticNode& self, const Pose& m) {
    if (!self.leader_frame_.check(m.header.frame_id)) self.cycle_.report(kBaseMoved);
    self.stamp_ = stamp_of(m);
    self.came_ = now_ns();
    self.cycle_.leader_pose(self.stamp_, vector(m.pose.position), quaternion(m.pose.orientation), self.clock_time());
    self.fresh_ = true;
  });
}

std::vector<std::string> HapticNode::take_events() {
  std::vector<std::string> events = console_.take_events();
  const HapticNames& names = options_.names;
  for (std::string words :
       {leader_frame_.words(names.of_leader("measured_cp")), follower_frame_.words(names.of_follower("measured_cp"))}) {
    if (!words.empty()) events.push_back(std::move(words));
  }
  return events;
}

void HapticNode::join(std::shared_ptr<loop::Board> board, int index, std::vector<loop::ToolCapsule> capsules,
                      contact::InstrumentLaw law) {
  if (running()) throw std::logic_error("the node runs: join() its instrument to the others before start()");
  cycle_.join(std::move(board), index, std::move(capsules), law);
}

void HapticNode::join_bodies(std::shared_ptr<loop::Bodies> bodies, int tool) {
  if (running()) throw std::logic_error("the node runs: join_bodies() before start()");
  cycle_.join_bodies(std::move(bodies), tool);
}

void HapticNode::start() {
  if (running()) return;
  stopping_ = force_is_zero_ = false;
  front_.open();
  auto granted = std::make_shared<std::promise<std::string>>();
  std::future<std::string> words = granted->get_future();
  SpinnerOptions options;
  options.in_thread = [this, granted] {
    loop::RealTimeOptions wanted = options_.realtime;
    wanted.allow_affinity = false;  // the middleware's own threads deliver the messages
    granted->set_value(loop::schedule(wanted));
  };
  options.after = [this] { return after(); };
  options.direct = true;
  spinner_ = std::make_unique<Spinner>(node_, std::move(options));
  scheduler_ = words.get();
  front_.start_threads(options_.cycle.contact.collision_rate);
}

void HapticNode::stop() noexcept {
  if (!running()) return;
  stopping_ = true;
  const auto end = std::chrono::steady_clock::now() + kLonely;
  while (!force_is_zero_ && std::chrono::steady_clock::now() < end)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  spinner_->stop();
  spinner_.reset();
  front_.stop_threads();
  wrench_message_.wrench = geometry_msgs::msg::Wrench();
  stamp(wrench_message_.header, wall_now());
  if (commanding_) {
    for (int i = 0; i < 3; ++i) {
      if (!wrench_.publish(wrench_message_)) break;
      published_.fetch_add(1, std::memory_order_relaxed);
    }
    wrench_.flush(std::chrono::nanoseconds(kLonely).count());
  }
  beat_->finished = 1;
}

loop::ClockTime HapticNode::clock_time() const noexcept {
  return {1e-9 * static_cast<double>(now_ns() - t0_), wall_now()};
}

// Called after each round of messages: steps if a new leader state has arrived or is overdue. Returns the time until
// the next call [ns].
std::int64_t HapticNode::after() noexcept {
  const std::int64_t now = now_ns();
  const auto overdue = static_cast<std::int64_t>(kOverdue * static_cast<double>(period_));
  if (fresh_ || now - last_step_ >= overdue) step(now);
  beat_->node.store(now_ns(), std::memory_order_relaxed);
  return std::min(last_step_ + overdue - now_ns(), kBeat);
}

void HapticNode::step(std::int64_t begin) noexcept {
  take();
  gate();
  const bool answered = std::exchange(fresh_, false);
  const loop::CrtkOutput& out = cycle_.step(clock_time());
  const std::int64_t spent = now_ns() - begin;
  cycle_time_.add(spent);
  command(out);
  if (const double took = wall_now() - stamp_; answered && out.command && took >= 0.0 && took < 1.0) {
    answer_time_.add(static_cast<std::int64_t>(1e9 * took));  // only plausible times, as stamps may be wrong
  }
  loop::Tick tick = out.tick;
  tick.cycle_us = 1e-3 * static_cast<double>(spent);
  tick.lateness_us = answered ? 1e-3 * static_cast<double>(begin - came_) : 0.0;
  front_.record(tick);
  front_.keep(tick);
  front_.show(tick);
  update_stream_figures();
  force_is_zero_ = stopping_ && out.F.f.isZero(0.0) && out.F.t.isZero(0.0);
  last_step_ = begin;
}

// Takes the controls, scene and fixtures that were changed since the last step.
void HapticNode::take() noexcept {
  Controls controls = front_.take_controls();
  if (stopping_) controls.following = false;
  controls.take_back_requests += console_.taps();
  cycle_.set_controls(controls);
  if (front_.take_scene(clock_time().t)) cycle_.forget_contacts();
  cycle_.set_scene(front_.scene());
  if (front_.take_fixtures()) cycle_.take(front_.fixtures());
  if (const double scale = console_.scale(); scale != 0.0) cycle_.set_scale(scale);
}

// Checks the guardian first: after a takeover the arm has received zero wrenches, so the cycle restarts at zero force.
void HapticNode::gate() noexcept {
  loop::CrtkGates gates = console_.gates();
  const std::uint32_t taken = beat_->taken;
  if (beat_->seen != taken) {
    cycle_.reset_wrench();
    gates.guarded = true;
    beat_->seen = taken;
  }
  const bool guardian_unheard =
      beat_->listeners == 0 && wrench_.listeners() > 0;  // the guardian's zero wrenches would not arrive
  gates.guarded = gates.guarded || guardian_unheard || now_ns() - beat_->guardian > kGuardianAway;
  gates.no_listener = wrench_.listeners() == 0;
  for (const auto& subscription : subscriptions_) gates.two_sources |= subscription->publishers() > 1;
  cycle_.set_gates(gates);
}

void HapticNode::command(const loop::CrtkOutput& out) noexcept {
  // Several zero wrenches follow the last command, because any single message may be lost.
  commanding_ = out.command || tail_ > 0;
  if (out.command) tail_ = kTail;
  beat_->commanding.store(commanding_ ? 1 : 0, std::memory_order_relaxed);
  if (commanding_) {
    // This process may have been suspended since gate(); the guardian has then taken over, and only zero may be sent.
    const bool aside = beat_->taken != beat_->seen;
    fill(wrench_message_.wrench.force, aside ? Vec3::Zero() : out.F.f);
    fill(wrench_message_.wrench.torque, aside ? Vec3::Zero() : out.F.t);
    stamp(wrench_message_.header, wall_now());
    if (wrench_.publish(wrench_message_)) {
      published_.fetch_add(1, std::memory_order_relaxed);
      if (!out.command) --tail_;
    }
  }
  if (out.move && goal_ && jaw_) {
    const Eigen::Quaterniond turn(out.X_BT_goal.R);
    auto& pose = goal_message_.pose;
    pose.position.x = out.X_BT_goal.p.x(), pose.position.y = out.X_BT_goal.p.y(), pose.position.z = out.X_BT_goal.p.z();
    pose.orientation.x = turn.x(), pose.orientation.y = turn.y(), pose.orientation.z = turn.z();
    pose.orientation.w = turn.w();
    stamp(goal_message_.header, wall_now());
    jaw_message_.header = goal_message_.header;
    jaw_message_.position[0] = out.jaw;
    if (!goal_->publish(goal_message_) || !jaw_->publish(jaw_message_)) return;
  }
}

void HapticNode::update_stream_figures() noexcept {
  const loop::Watch& leader = cycle_.leader();
  leader_rate_.store(leader.period() > 0.0 ? 1.0 / leader.period() : 0.0, std::memory_order_relaxed);
  leader_age_.store(leader.age(), std::memory_order_relaxed);
  leader_clock_.store(leader.clock_offset(), std::memory_order_relaxed);
  leader_taken_.store(leader.accepted(), std::memory_order_relaxed);
  leader_left_out_.store(leader.ignored(), std::memory_order_relaxed);
}

}  // namespace palpate::ros
