#include "haptics/console_link.hpp"

#include <rcl/graph.h>

#include <algorithm>
#include <chrono>
#include <geometry_msgs/msg/pose_stamped.hpp>
#include <limits>

namespace palpate::ros {
namespace {

constexpr auto kPollInterval = std::chrono::milliseconds(50);  // interval of the polls of the graph
constexpr int kReportPolls = 20;                               // polls during which a state report is awaited
constexpr int kNamelessPolls = 20;  // polls until a publisher without a node name counts as foreign

constexpr double kAnyAge = std::numeric_limits<double>::infinity();  // of latched messages
constexpr int kTap = 2;  // buttons[0] of a Joy after a quick tap of a pedal, which is up again

std_msgs::msg::Bool bool_message(bool on) {
  std_msgs::msg::Bool message;
  message.data = on;
  return message;
}

/// True if the name of a teleoperation contains the arm: MTMR_PSM1 and MTML_MTMR_ECM contain MTMR.
bool names_arm(const std::string& teleop, const std::string& arm) {
  return ("_" + teleop + "_").find("_" + arm + "_") != std::string::npos;
}

/// "two nodes publish TOPIC: A and B"; empty for one publisher or none.
std::string several(const std::string& topic, const std::vector<Endpoint>& ends) {
  if (ends.size() < 2) return {};
  std::string words = ends.size() == 2 ? "two" : ends.size() == 3 ? "three" : std::to_string(ends.size());
  words += " nodes publish " + topic + ": ";
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const bool named = ends[i].node.find("NODE_NAME_UNKNOWN") == std::string::npos;
    words += (i == 0 ? "" : i + 1 < ends.size() ? ", " : " and ") + (named ? ends[i].node : "one without a name");
  }
  return words;
}

/// Names of all topics in the graph; empty if the query fails.
std::vector<std::string> topics(Node& node) {
  rcutils_allocator_t allocator = rcutils_get_default_allocator();
  rcl_names_and_types_t found = rcl_get_zero_initialized_names_and_types();
  std::vector<std::string> names;
  if (rcl_get_topic_names_and_types(node.get(), &allocator, false, &found) == RCL_RET_OK) {
    for (std::size_t i = 0; i < found.names.size; ++i) names.emplace_back(found.names.data[i]);
  }
  if (rcl_names_and_types_fini(&found) != RCL_RET_OK) rcl_reset_error();
  return names;
}

}  // namespace

ConsoleLink::Teleop::Teleop(Node& node, const std::string& name, ConsoleLink& console)
    : name(name),
      following_sub(node, "/" + name + "/following",
                    [this](const std_msgs::msg::Bool& message) { following = message.data; }),
      state_sub(node, "/" + name + "/current_state", [this, &console](const std_msgs::msg::String& message) {
        const bool on = message.data != "DISABLED";
        this->reported = true;
        if (on && console.names_.own_teleop()) console.set(kOther, true);
        if (on != enabled.exchange(on)) console.report(this->name + " is " + message.data);
      }) {}

ConsoleLink::ConsoleLink(std::shared_ptr<Context> context, const HapticNames& names, std::vector<std::string> writers,
                         const loop::CrtkOptions& device)
    : names_(names),
      writers_(std::move(writers)),
      absolute_frame_(!device.tip_frame),
      needs_frame_(device.needs_state),
      node_(std::move(context), names.node() + "_console", names.space,
            [this](const std::string& words) { report(words); }),
      absolute_(node_, names.of_leader("body/set_cf_orientation_absolute")),
      gravity_(node_, names.of_leader("use_gravity_compensation")),
      absolute_sub_(node_, absolute_.topic(),
                    [this](const std_msgs::msg::Bool& message) {
                      if (message.data != absolute_frame_)
                        restore(absolute_, absolute_frame_, "turned the wrench frame");
                    }),
      gravity_sub_(node_, gravity_.topic(),
                   [this](const std_msgs::msg::Bool& message) {
                     if (!message.data) restore(gravity_, true, "switched off the gravity compensation");
                   }),
      leader_(
          node_, names.of_leader("operating_state"),
          [this](const auto& message) { state(kLeader, names_.leader, message); }, kAnyAge, 1, Sources::one),
      operator_(
          node_, "/" + names.console + "/operator_present",
          [this](const Joy& message) { joy(kOperator, message, true); }, kAnyAge, 1, Sources::one),
      clutch_(
          node_, "/" + names.console + "/clutch", [this](const Joy& message) { joy(kClutch, message, false); }, kAnyAge,
          1, Sources::one),
      camera_(
          node_, "/" + names.console + "/camera", [this](const Joy& message) { joy(kCamera, message, false); }, kAnyAge,
          1, Sources::one),
      spinner_(node_) {
  set(kNoFrameSubscriber, needs_frame_);  // until a subscriber is found
  if (!names.follower.empty()) {
    follower_.emplace(
        node_, names.of_follower("operating_state"),
        [this](const auto& message) { state(kFollower, names_.follower, message); }, kAnyAge, 1, Sources::one);
  }
  if (names.own_teleop()) {
    set(kFollowing, true);
    set(kOther, true);  // until the search finds no other teleoperation
  } else {
    following_.emplace(
        node_, "/" + names.teleop + "/following", [this](const std_msgs::msg::Bool& message) { follow(message.data); },
        kAnyAge, 1, Sources::one);
    scale_sub_.emplace(
        node_, "/" + names.teleop + "/scale", [this](const std_msgs::msg::Float64& message) { scale_ = message.data; },
        kAnyAge, 1, Sources::one);
    states_.insert(states_.end(), {&*following_, &*scale_sub_});
  }
  states_.insert(states_.end(), {&leader_, &operator_, &clutch_, &camera_});
  if (follower_) states_.push_back(&*follower_);
  for (const LatchingSearch* state : states_) inputs_.emplace(state->topic(), "");
  for (const std::string& topic : names.measured()) inputs_.emplace(topic, "");
  for (const std::string& arm : {names.leader, names.follower}) {
    if (arm.empty()) continue;
    const std::string topic = "/" + arm + "/set_base_frame";
    base_subs_.push_back(std::make_unique<Subscription<geometry_msgs::msg::PoseStamped>>(
        node_, topic,
        [this, arm, topic](const geometry_msgs::msg::PoseStamped&, const Info&) { base_frame(arm, topic); }));
  }
  poller_ = std::thread([this] { poll_graph(); });
}

ConsoleLink::~ConsoleLink() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  woken_.notify_all();
  poller_.join();
  spinner_.stop();
}

loop::CrtkGates ConsoleLink::gates() noexcept {
  const unsigned g = gates_.load(std::memory_order_relaxed);
  loop::CrtkGates gates;
  gates.following = (g & kFollowing) != 0;
  gates.operator_present = (g & kOperator) != 0;
  gates.clutch = (g & (kClutch | kCamera)) != 0;
  gates.camera = (g & kCamera) != 0;
  gates.leader_enabled = (g & kLeader) != 0;
  gates.follower_enabled = (g & kFollower) != 0;
  gates.second_writer = (g & kWriter) != 0;
  gates.other_teleop = (g & kOther) != 0;
  gates.two_sources = (g & kSources) != 0 || contested();
  gates.base_moved = (g & kBase) != 0;
  gates.frame_unsure = frame_changed_.exchange(false, std::memory_order_relaxed) || (g & kNoFrameSubscriber) != 0;
  return gates;
}

std::vector<std::string> ConsoleLink::take_events() {
  const std::lock_guard lock(mutex_);
  return std::exchange(events_, {});
}

void ConsoleLink::report(std::string words) {
  const std::lock_guard lock(mutex_);
  if (events_.size() < 100) events_.push_back(std::move(words));
}

bool ConsoleLink::set(Gate gate, bool on) noexcept {
  const unsigned before = on ? gates_.fetch_or(gate) : gates_.fetch_and(~static_cast<unsigned>(gate));
  return ((before & gate) != 0) != on;
}

// The wrench frame is set again before each start of a force. The dVRK's camera teleoperation makes the frame absolute
// without a message on any topic, and other programs may change it, too.
void ConsoleLink::follow(bool on) {
  if (on) make_ready();
  set(kFollowing, on);
}

void ConsoleLink::joy(Gate gate, const Joy& message, bool allows) {
  const int button = message.buttons.empty() ? 0 : message.buttons[0];
  if (button == kTap && gate == kClutch) ++taps_;
  pedal(gate, button != 0 && button != kTap, allows);
}

// The scene places the arm by the frame of measured_cp, which is another one now. Nothing tells when it is back.
void ConsoleLink::base_frame(const std::string& arm, const std::string& topic) {
  if (!set(kBase, true)) return;
  std::string who;
  for (const Endpoint& end : node_.publishers(topic)) who += (who.empty() ? "" : ", ") + end.node;
  report((who.empty() ? "somebody" : who) + " set another base frame of " + arm + " (set_base_frame): measured_cp is " +
         "not in the frame of the scene any more, no force. Mend: restart this node, with the scene's base for it");
}

// True if a state has several publishers now. They are not listened to, so what they said meanwhile is not known.
bool ConsoleLink::contested() const noexcept {
  for (const LatchingSearch* state : states_) {
    if (state->publishers() < 2) continue;
    contested_since_.store(true, std::memory_order_relaxed);
    return true;
  }
  return false;
}

// `allows`: the position of the pedal that allows a force; true means down.
void ConsoleLink::pedal(Gate gate, bool down, bool allows) {
  if (down == allows) make_ready();
  set(gate, down);
}

void ConsoleLink::make_ready() {
  const std::lock_guard lock(publishing_);
  for (const auto& [to, on] : {std::pair{&absolute_, absolute_frame_}, std::pair{&gravity_, true}}) {
    if (const Status sent = to->publish(bool_message(on)); !sent) report(sent.problem);
  }
}

// The arm may have read some wrenches in the wrong frame, so `frame_unsure` stops the force for a while.
void ConsoleLink::restore(Publisher<std_msgs::msg::Bool>& to, bool right, const char* words) {
  frame_changed_ = true;
  report(std::string("somebody ") + words + " of " + names_.leader + ": set back");
  const std::lock_guard lock(publishing_);
  if (const Status sent = to.publish(bool_message(right)); !sent) report(sent.problem);
}

void ConsoleLink::state(Gate gate, const std::string& arm, const crtk_msgs::msg::OperatingState& message) {
  // True if the leader moves under another program's command.
  const bool away = message.is_busy && gate == kLeader && names_.own_teleop();
  const bool on = message.state == "ENABLED" && message.is_homed && !away;
  if (set(gate, on)) {
    if (on && gate == kLeader) make_ready();
    report(arm + " is " + message.state + (message.is_homed ? "" : ", not homed") + (away ? ", busy" : ""));
  }
}

void ConsoleLink::poll_graph() {
  std::unique_lock lock(mutex_);
  while (!stop_) {
    lock.unlock();
    try {
      look();
    } catch (const std::exception& error) {
      report(error.what());
    }
    lock.lock();
    woken_.wait_for(lock, kPollInterval, [this] { return stop_; });
  }
}

void ConsoleLink::look() {
  absolute_sub_.find_latching_publisher(), gravity_sub_.find_latching_publisher();
  for (LatchingSearch* state : states_) state->find_latching_publisher();
  if (const std::size_t listeners = absolute_.listeners() + gravity_.listeners(); listeners != listeners_) {
    if (listeners > listeners_) make_ready();  // a new arm has subscribed
    listeners_ = listeners;
  }
  if (needs_frame_ && set(kNoFrameSubscriber, absolute_.listeners() == 0)) {
    report(absolute_.listeners() > 0
               ? names_.leader + " takes " + absolute_.topic()
               : "nobody listens to " + absolute_.topic() +
                     ": no force. Mend: start the arm, or --any-state for a device that has no such topic and takes "
                     "wrenches in the frame of measured_cp");
  }
  find_sources();
  find_listeners();
  find_writers();
  if (names_.own_teleop()) find_teleops();
}

// Looks for inputs with several publishers. While a state has several, it counts as unknown; then it is asked again.
void ConsoleLink::find_sources() {
  bool found = false;
  for (auto& [topic, before] : inputs_) {
    const std::vector<Endpoint> ends = node_.publishers(topic);
    std::string words = several(topic, ends);
    found = found || !words.empty();
    if (words == before) continue;
    if (!words.empty()) {
      report(words + ": no force until one is left");
    } else {
      report(topic + " has one publisher again" + (ends.empty() ? "" : ": " + ends[0].node));
    }
    before = std::move(words);
  }
  set(kSources, found);
  const bool contest = contested();
  if (contest || contested_since_.exchange(false)) {
    for (const Gate gate : {kOperator, kLeader, kFollower}) set(gate, false);
    if (!names_.own_teleop()) set(kFollowing, false);
    contested_before_ = true;
  }
  if (!contest && std::exchange(contested_before_, false)) {
    for (LatchingSearch* state : states_) state->forget();
  }
}

// An arm whose subscription was replaced between two polls has lost its last wrench: the force begins at zero again.
void ConsoleLink::find_listeners() {
  std::vector<Gid> now;
  for (const Endpoint& end : node_.subscribers(names_.wrench())) now.push_back(end.gid);
  const auto stays = [&](const Gid& one) { return std::find(now.begin(), now.end(), one) != now.end(); };
  if (!now.empty() && !receivers_.empty() && std::none_of(receivers_.begin(), receivers_.end(), stays)) {
    frame_changed_ = true;
    report("another subscription receives " + names_.wrench() + " now: the force begins at zero");
  }
  if (now.empty() != receivers_.empty() || !searched_) {
    report(now.empty() ? "nobody listens to " + names_.wrench() + ": no force"
                       : names_.wrench() + " has a listener: the force begins at zero");
  }
  searched_ = true;
  receivers_ = std::move(now);
}

// Looks for other publishers on the topics that this node commands. The arm obeys the newest message, so it would
// switch between two publishers at their full rate.
void ConsoleLink::find_writers() {
  std::vector<std::string> commanded{names_.wrench()};
  if (!names_.own_teleop()) commanded.push_back(names_.of_leader("body/servo_cf"));
  if (names_.own_teleop() && !names_.follower.empty()) commanded.push_back(names_.of_follower("servo_cp"));
  std::string found;
  bool nameless = false;
  for (const std::string& topic : commanded) {
    for (const Endpoint& end : node_.publishers(topic)) {
      const bool named =
          end.node.find("NODE_NAME_UNKNOWN") == std::string::npos;  // discovery reports an endpoint before its node
      const bool ours = std::find(writers_.begin(), writers_.end(), end.node) != writers_.end();
      nameless = nameless || !named;
      if (named ? !ours : nameless_ >= kNamelessPolls)
        found = (named ? end.node : "a program without ROS") + " writes to " + topic;
    }
  }
  nameless_ = nameless ? std::min(nameless_ + 1, kNamelessPolls) : 0;
  if (set(kWriter, !found.empty())) report(found.empty() ? "nobody else writes to the arm any more" : found + ", too");
}

// Looks for other teleoperations of the same leader. An active one commands the leader and sends its own wrench.
void ConsoleLink::find_teleops() {
  const std::string end = "/current_state";
  for (const std::string& topic : topics(node_)) {
    if (!topic.ends_with(end)) continue;
    const std::string name = topic.substr(1, topic.size() - 1 - end.size());
    if (name == names_.leader || !names_arm(name, names_.leader)) continue;
    const auto same = [&](const Teleop& teleop) { return teleop.name == name; };
    if (std::none_of(others_.begin(), others_.end(), same)) others_.emplace_back(node_, name, *this);
  }
  std::string on;
  bool hearing = std::exchange(polls_, std::min(polls_ + 1, kReportPolls)) < kReportPolls;
  for (Teleop& teleop : others_) {
    teleop.following_sub.find_latching_publisher(), teleop.state_sub.find_latching_publisher();
    if (!teleop.on()) continue;
    on = teleop.name + (teleop.reported ? " is on" : " does not tell its state, which counts as on");
    hearing = hearing || (!teleop.reported && teleop.polls++ < kReportPolls);
  }
  const bool free = on.empty() && !hearing;
  if (free && (gates_ & kOther) != 0) make_ready();  // the camera teleoperation changes the wrench frame
  set(kOther, !free);
  if (!hearing && on != other_ && !on.empty()) {
    report("another teleoperation of " + names_.leader + ", " + on +
           ", and ours is asked for: nothing is sent. Mend: disable it, or --teleop NAME to work with it");
  }
  if (!hearing) other_ = on;
}

}  // namespace palpate::ros
