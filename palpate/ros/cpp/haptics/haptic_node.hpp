// The haptic node: a CRTK leader's state comes in, the cycle steps, the wrench goes out, in one thread.
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

#include "haptics/console.hpp"
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
  std::string writer;    ///< name of the node that writes wrenches, unlike any other
  std::string guardian;  ///< and of the one that guards it
  int beat_fd = -1;
};

/// What people may want to know of a stream.
struct Stream {
  double rate = 0.0;  ///< [Hz]
  double age = 0.0;   ///< of the last stamp when it came [s]
  std::uint64_t taken = 0, left_out = 0;
};

class HapticNode {
 public:
  HapticNode(const std::shared_ptr<Context>& context, const HapticNodeOptions& options,
             std::optional<arm::Arm> follower, std::shared_ptr<const scene::Snapshot> scene);
  ~HapticNode();
  HapticNode(const HapticNode&) = delete;
  HapticNode& operator=(const HapticNode&) = delete;

  void start();
  /// The force to zero, the last wrench that is sent is zero, and it has arrived. Does nothing when it does not run.
  void stop() noexcept;
  [[nodiscard]] bool running() const noexcept { return spinner_ != nullptr; }

  /// How people steer the node and read its ticks, from any thread.
  [[nodiscard]] loop::Front& front() noexcept { return front_; }
  [[nodiscard]] const loop::Front& front() const noexcept { return front_; }
  /// What has happened since the last call, in words.
  [[nodiscard]] std::vector<std::string> news() { return console_.news(); }

  [[nodiscard]] const loop::Histogram& cycle_time() const noexcept { return cycle_time_; }
  /// From the stamp of the leader's state to the wrench handed to ROS.
  [[nodiscard]] const loop::Histogram& answer_time() const noexcept { return answer_time_; }
  [[nodiscard]] Stream leader() const noexcept { return {leader_rate_, leader_age_, leader_taken_, leader_left_out_}; }
  [[nodiscard]] std::uint64_t published() const noexcept { return published_; }
  [[nodiscard]] std::uint32_t guarded() const noexcept { return beat_->taken; }
  [[nodiscard]] const std::string& scheduler() const noexcept { return scheduler_; }
  [[nodiscard]] const HapticNodeOptions& options() const noexcept { return options_; }

 private:
  using Pose = geometry_msgs::msg::PoseStamped;
  using Joints = sensor_msgs::msg::JointState;
  using Twist = geometry_msgs::msg::TwistStamped;

  void listen();
  [[nodiscard]] loop::Moment moment() const noexcept;
  std::int64_t after() noexcept;
  void step(std::int64_t begin) noexcept;
  void gate() noexcept;
  void take() noexcept;
  void command(const loop::CrtkOutput& out) noexcept;
  void tell_stream() noexcept;

  HapticNodeOptions options_;
  SharedHeartbeat beat_;
  Console console_;
  Node node_, writer_;
  Publisher<geometry_msgs::msg::WrenchStamped> wrench_;
  std::optional<Publisher<Pose>> goal_;
  std::optional<Publisher<Joints>> jaw_;
  std::vector<std::unique_ptr<Entity>> subscriptions_;
  geometry_msgs::msg::WrenchStamped wrench_message_;
  Pose goal_message_;
  Joints jaw_message_;

  loop::CrtkCycle cycle_;
  loop::Front front_;
  std::int64_t t0_, period_, last_step_ = 0, came_ = 0;
  double stamp_ = 0.0;
  bool fresh_ = false, commanding_ = false;
  int tail_ = 0;  ///< zeros still to be sent after the last command
  std::atomic<bool> stopping_{false}, quiet_{false};

  loop::Histogram cycle_time_, answer_time_;
  std::atomic<double> leader_rate_{0.0}, leader_age_{0.0};
  std::atomic<std::uint64_t> leader_taken_{0}, leader_left_out_{0}, published_{0};
  std::string scheduler_ = "not started";
  std::unique_ptr<Spinner> spinner_;
  Spinner told_{writer_};  ///< that a listener's quality of service does not fit; last: it stops first
};

}  // namespace palpate::ros
