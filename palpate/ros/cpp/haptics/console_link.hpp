// The gates of the cycle: conditions that allow or forbid a force, from the console, the arms' operating states and the
// ROS graph. Two threads update them, a spinner and a poll of the graph; the cycle reads them without waiting.
#pragma once

#include <atomic>
#include <condition_variable>
#include <crtk_msgs/msg/operating_state.hpp>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <sensor_msgs/msg/joy.hpp>
#include <std_msgs/msg/bool.hpp>
#include <std_msgs/msg/float64.hpp>
#include <std_msgs/msg/string.hpp>
#include <string>
#include <thread>
#include <vector>

#include "haptics/names.hpp"
#include "palpate/loop/crtk_cycle.hpp"
#include "rcl/latched_subscriber.hpp"
#include "rcl/publisher.hpp"
#include "rcl/spinner.hpp"

namespace palpate::ros {

class ConsoleLink {
 public:
  /// `writers`: full names of the nodes that may publish wrenches, which are this node's and the guardian's.
  /// `device`: the frame in which the leader takes wrenches, and whether it reports states.
  ConsoleLink(std::shared_ptr<Context> context, const HapticNames& names, std::vector<std::string> writers,
              const loop::CrtkOptions& device);
  ~ConsoleLink();
  ConsoleLink(const ConsoleLink&) = delete;
  ConsoleLink& operator=(const ConsoleLink&) = delete;

  /// The gates now. Called by the cycle: takes no lock and does not wait. An interference with the wrench frame since
  /// the last call sets `frame_unsure` once.
  [[nodiscard]] loop::CrtkGates gates() noexcept;
  /// Motion scale of the external teleoperation [-]; zero until a message with the scale has arrived.
  [[nodiscard]] double scale() const noexcept { return scale_.load(std::memory_order_relaxed); }

  /// Number of quick taps of the clutch pedal so far: each takes the shift of the tool against the hand back [-].
  [[nodiscard]] int taps() const noexcept { return taps_.load(std::memory_order_relaxed); }

  /// Messages for the user since the last call, oldest first.
  [[nodiscard]] std::vector<std::string> take_events();
  /// Adds a message for the user; at most 100 are kept. From any thread.
  void report(std::string words);

 private:
  enum Gate : unsigned {
    kFollowing = 1u,
    kOperator = 2u,
    kClutch = 4u,
    kLeader = 8u,
    kFollower = 16u,
    kWriter = 32u,
    kOther = 64u,
    kCamera = 128u,
    kNoFrameSubscriber = 256u,  ///< no subscriber for the topic that sets the wrench frame
    kSources = 512u,            ///< an input has several publishers
    kBase = 1024u               ///< somebody has set another base frame of an arm
  };
  using Joy = sensor_msgs::msg::Joy;
  /// Another teleoperation component that uses the same leader.
  struct Teleop {
    Teleop(Node& node, const std::string& name, ConsoleLink& console);
    [[nodiscard]] bool on() const noexcept { return enabled || following; }
    std::string name;
    /// States reported by the component; `enabled` is assumed until reported otherwise.
    std::atomic<bool> following{false}, enabled{true};
    std::atomic<bool> reported{false};  ///< true once the component has reported its state
    int polls = 0;                      ///< polls of the graph without a report
    LatchedSubscriber<std_msgs::msg::Bool> following_sub;
    LatchedSubscriber<std_msgs::msg::String> state_sub;
  };

  /// Sets a gate; returns true if its value has changed.
  bool set(Gate gate, bool on) noexcept;
  void follow(bool on);
  void state(Gate gate, const std::string& arm, const crtk_msgs::msg::OperatingState& message);
  void joy(Gate gate, const Joy& message, bool allows);
  void base_frame(const std::string& arm, const std::string& topic);
  [[nodiscard]] bool contested() const noexcept;
  void pedal(Gate gate, bool down, bool allows);
  void make_ready();
  void restore(Publisher<std_msgs::msg::Bool>& to, bool right, const char* words);
  void poll_graph();
  void look();
  void find_sources();
  void find_listeners();
  void find_writers();
  void find_teleops();

  HapticNames names_;
  std::vector<std::string> writers_;
  const bool absolute_frame_;  ///< wrenches in the axes of the base; otherwise in those of the tip
  const bool needs_frame_;     ///< no force while the topic of the wrench frame has no subscriber
  std::atomic<bool> frame_changed_{false};
  std::atomic<unsigned> gates_{0};
  std::atomic<double> scale_{0.0};
  std::atomic<int> taps_{0};
  std::mutex mutex_, publishing_;  // guard events_ and stop_; the publishers
  std::vector<std::string> events_;

  Node node_;
  Publisher<std_msgs::msg::Bool> absolute_, gravity_;
  LatchedSubscriber<std_msgs::msg::Bool> absolute_sub_, gravity_sub_;
  LatchedSubscriber<crtk_msgs::msg::OperatingState> leader_;
  std::optional<LatchedSubscriber<crtk_msgs::msg::OperatingState>> follower_;
  LatchedSubscriber<Joy> operator_, clutch_, camera_;
  std::optional<LatchedSubscriber<std_msgs::msg::Bool>> following_;
  std::optional<LatchedSubscriber<std_msgs::msg::Float64>> scale_sub_;
  std::vector<std::unique_ptr<Entity>> base_subs_;  ///< set_base_frame of the arms
  std::vector<LatchingSearch*> states_;             ///< subscriptions of states, of which each has one publisher
  std::map<std::string, std::string> inputs_;       ///< words about several publishers of each input, by its topic
  std::vector<Gid> receivers_;                      ///< subscriptions of the wrenches in the last poll
  bool searched_ = false;                           ///< the graph was polled once
  bool contested_before_ = false;                   ///< a state had several publishers, in the last poll or since
  mutable std::atomic<bool> contested_since_{false};
  std::list<Teleop> others_;
  std::size_t listeners_ = 0;
  int polls_ = 0;
  std::string other_;  ///< the last reported teleoperation that is on
  int nameless_ = 0;   ///< consecutive polls with a publisher whose node name is unknown
  Spinner spinner_;
  std::condition_variable woken_;
  bool stop_ = false;
  std::thread poller_;
};

}  // namespace palpate::ros
