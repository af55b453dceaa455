// The haptic node: it receives the state of a CRTK leader, steps the cycle and publishes the wrench, in the thread that
// receives the message.
#pragma once

#include <atomic>
#include <geometry_msgs/msg/pose_stamped.hpp>
#include <geometry_msgs/msg/twist_stamped.hpp>
#include <geometry_msgs/msg/wrench_stamped.hpp>
#include <memory>
#include <optional>
#include <sensor_msgs/msg/joint_state.hpp>
#include <string>
#include <vector>

#include "haptics/console_link.hpp"
#include "haptics/frame_name.hpp"
#include "haptics/heartbeat.hpp"
#include "haptics/names.hpp"
#include "palpate/loop/crtk_cycle.hpp"
#include "palpate/loop/front.hpp"
#include "palpate/loop/histogram.hpp"
#include "palpate/loop/realtime.hpp"
#include "rcl/publisher.hpp"
#include "rcl/spinner.hpp"
#include "rcl/subscription.hpp"

namespace palpate::ros {

struct HapticNodeOptions {
  HapticNames names;
  loop::CrtkOptions cycle;
  loop::RealTimeOptions realtime;
  std::string writer;    ///< unique name of the ROS node that publishes wrenches
  std::string guardian;  ///< unique name of the guardian's ROS node
  int beat_fd = -1;      ///< file descriptor of the Heartbeat shared with the guardian
};

/// Statistics of an input stream.
struct Stream {
  double rate = 0.0;                      ///< [Hz]
  double age = 0.0;                       ///< age of the last message at its arrival, from its stamp [s]
  double clock_offset = 0.0;              ///< of the sender's clock; negative: behind, or a delay [s]
  std::uint64_t taken = 0, left_out = 0;  ///< messages used; messages rejected [-]
};

class HapticNode {
 public:
  HapticNode(const std::shared_ptr<Context>& context, const HapticNodeOptions& options,
             std::optional<arm::Arm> follower, std::shared_ptr<const scene::Snapshot> scene);
  ~HapticNode();
  HapticNode(const HapticNode&) = delete;
  HapticNode& operator=(const HapticNode&) = delete;

  /// Puts the instrument among those of other nodes of this process (loop::CrtkCycle::join). Throws std::logic_error
  /// while the node runs.
  void join(std::shared_ptr<loop::Board> board, int index, std::vector<loop::ToolCapsule> capsules,
            contact::InstrumentLaw law);
  /// Puts the tool among rigid bodies (loop::CrtkCycle::join_bodies). Throws as join().
  void join_bodies(std::shared_ptr<loop::Bodies> bodies, int tool);
  void start();
  /// Reduces the force to zero, sends zero wrenches, waits for their acknowledgement (300 ms at most) and ends the
  /// threads. Does nothing if the node does not run.
  void stop() noexcept;
  [[nodiscard]] bool running() const noexcept { return spinner_ != nullptr; }

  /// Controls, scene and recorded ticks of the node, for any thread.
  [[nodiscard]] loop::Front& front() noexcept { return front_; }
  [[nodiscard]] const loop::Front& front() const noexcept { return front_; }
  /// Messages for the user since the last call, oldest first.
  [[nodiscard]] std::vector<std::string> take_events();

  [[nodiscard]] const loop::Histogram& cycle_time() const noexcept { return cycle_time_; }
  /// Time from the stamp of the leader's state until the wrench is handed to ROS.
  [[nodiscard]] const loop::Histogram& answer_time() const noexcept { return answer_time_; }
  [[nodiscard]] Stream leader() const noexcept {
    return {leader_rate_, leader_age_, leader_clock_, leader_taken_, leader_left_out_};
  }
  [[nodiscard]] std::uint64_t published() const noexcept { return published_; }
  /// Number of takeovers by the guardian [-].
  [[nodiscard]] std::uint32_t guarded() const noexcept { return beat_->taken; }
  [[nodiscard]] const std::string& scheduler() const noexcept { return scheduler_; }
  [[nodiscard]] const HapticNodeOptions& options() const noexcept { return options_; }

 private:
  using Pose = geometry_msgs::msg::PoseStamped;
  using Joints = sensor_msgs::msg::JointState;
  using Twist = geometry_msgs::msg::TwistStamped;

  void subscribe_all();
  [[nodiscard]] loop::ClockTime clock_time() const noexcept;
  std::int64_t after() noexcept;
  void step(std::int64_t begin) noexcept;
  void gate() noexcept;
  void take() noexcept;
  void command(const loop::CrtkOutput& out) noexcept;
  void update_stream_figures() noexcept;

  HapticNodeOptions options_;
  SharedHeartbeat beat_;
  ConsoleLink console_;
  Node node_, writer_;
  Publisher<geometry_msgs::msg::WrenchStamped> wrench_;
  std::optional<Publisher<Pose>> goal_;
  std::optional<Publisher<Joints>> jaw_;
  std::vector<std::unique_ptr<Entity>> subscriptions_;
  FrameName leader_frame_, follower_frame_;
  geometry_msgs::msg::WrenchStamped wrench_message_;
  Pose goal_message_;
  Joints jaw_message_;

  loop::CrtkCycle cycle_;
  loop::Front front_;
  std::int64_t t0_, period_, last_step_ = 0, came_ = 0;
  double stamp_ = 0.0;
  bool fresh_ = false, commanding_ = false;
  int tail_ = 0;  ///< zero wrenches still to be sent after the last command
  std::atomic<bool> stopping_{false}, force_is_zero_{false};

  loop::Histogram cycle_time_, answer_time_;
  std::atomic<double> leader_rate_{0.0}, leader_age_{0.0}, leader_clock_{0.0};
  std::atomic<std::uint64_t> leader_taken_{0}, leader_left_out_{0}, published_{0};
  std::string scheduler_ = "not started";
  std::unique_ptr<Spinner> spinner_;
  Spinner qos_spinner_{writer_};  ///< reports incompatible QoS of subscribers; declared last, so that it stops first
};

}  // namespace palpate::ros
