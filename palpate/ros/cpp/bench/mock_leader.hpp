// A mock CRTK leader for benchmarks and tests. It publishes commanded motions at an exact rate and logs every received
// wrench. Tests inject network faults: lost, repeated, reordered, delayed or falsified messages.
#pragma once

#include <atomic>
#include <crtk_msgs/msg/operating_state.hpp>
#include <cstdint>
#include <deque>
#include <geometry_msgs/msg/pose_stamped.hpp>
#include <geometry_msgs/msg/twist_stamped.hpp>
#include <geometry_msgs/msg/wrench_stamped.hpp>
#include <memory>
#include <mutex>
#include <optional>
#include <random>
#include <sensor_msgs/msg/joint_state.hpp>
#include <std_msgs/msg/bool.hpp>
#include <string>
#include <vector>

#include "bench/log.hpp"
#include "palpate/loop/realtime.hpp"
#include "palpate/types/spatial.hpp"
#include "rcl/publisher.hpp"
#include "rcl/spinner.hpp"
#include "rcl/subscription.hpp"

namespace palpate::ros {

struct MockLeaderOptions {
  std::string leader = "MTMR", teleop = "MTMR_PSM1";
  std::string wrench = "/MTMR_PSM1/following/mtm/body/servo_cf";  ///< topic of the wrenches on the leader
  double rate = 1000.0;                                           ///< rate of the published states [Hz]
  bool reliable = true;
  bool echo = false;  ///< half a period after each state, send a wrench to /palpate_there; it returns on /palpate_back
  std::uint64_t seed = 1;
};

/// Faults injected into the published messages.
struct MessageFaults {
  double drop = 0.0, twice = 0.0, swap = 0.0;  ///< fractions of lost, repeated and reordered messages [-]
  double delay = 0.0;                          ///< time from stamp to publication [s]
  double clock = 0.0;                          ///< clock offset added to the stamps [s]
  bool not_finite = false;                     ///< NaN in the position
  bool no_rotation = false;                    ///< a quaternion of zeros
  bool zero_stamp = false;                     ///< stamp 0, which marks invalid data
  bool wrong_length = false;                   ///< joint states of three joints and of none, in turn
  bool silent = false;                         ///< nothing is published, as with a disconnected cable
};

/// A received wrench.
struct ReceivedWrench {
  double t = 0.0;                    ///< time of arrival on the monotonic clock [s]
  double wall = 0.0;                 ///< time of arrival [s since 1970]
  double stamp = 0.0;                ///< stamp in the header [s since 1970]
  double f[3] = {}, torque[3] = {};  ///< force [N], torque [N m]
  double writer = 0.0;               ///< index of the publisher in the order of first arrival: 0, 1, ...
  double absolute = 0.0;             ///< 1: a dVRK arm would read it in the axes of measured_cp's frame; 0: of its tip
  double sequence = 0.0;             ///< number of messages that the publisher has sent, this one included
};

/// A received setting of the wrench frame.
struct FrameSetting {
  double t = 0.0;         ///< time of arrival on the monotonic clock [s]
  double absolute = 0.0;  ///< as in ReceivedWrench
};

class MockLeader {
 public:
  MockLeader(std::shared_ptr<Context> context, const MockLeaderOptions& options);
  ~MockLeader();
  MockLeader(const MockLeader&) = delete;
  MockLeader& operator=(const MockLeader&) = delete;

  void start();
  void stop();
  /// Moves smoothly from the present position to `p` [m] within `seconds` [s].
  void move_to(const Vec3& p, double seconds);
  /// Adds a sinusoidal motion of `amplitude` [m] at `frequency` [Hz] to the commanded position.
  void swing(const Vec3& amplitude, double frequency);
  /// Sets the orientation at once: quaternion x y z w.
  void turn_to(const Eigen::Vector4d& quat);
  void inject(const MessageFaults& faults);
  void set_state(const std::string& state, bool homed);
  void follow(bool on);

  // Logs since the construction; times on the monotonic clock [s].
  [[nodiscard]] std::vector<double> sent() const { return sent_.all(); }  ///< time of publication of each state
  [[nodiscard]] std::vector<ReceivedWrench> wrenches() const { return wrenches_.all(); }  ///< every received wrench
  [[nodiscard]] std::vector<double> echoes() const { return echoes_.all(); }  ///< round-trip times of the echo [s]
  [[nodiscard]] std::vector<FrameSetting> frame_settings() const {
    return frame_settings_.all();
  }  ///< received settings of the wrench frame
  [[nodiscard]] bool absolute() const noexcept { return absolute_; }
  [[nodiscard]] bool gravity_compensation() const noexcept {
    return gravity_compensation_;
  }  ///< true while gravity compensation is on
  [[nodiscard]] std::uint64_t pings() const noexcept { return pings_; }
  [[nodiscard]] std::size_t listeners() const noexcept { return pose_.listeners(); }
  [[nodiscard]] std::size_t writers() const noexcept { return wrench_.publishers(); }
  [[nodiscard]] const loop::Punctuality& punctuality() const noexcept { return clock_.punctuality(); }
  [[nodiscard]] std::string scheduler() const { return clock_.scheduler(); }

 private:
  using Pose = geometry_msgs::msg::PoseStamped;
  struct Late {
    double due;
    Pose pose;
  };
  bool tick(const loop::Wake& wake);
  [[nodiscard]] double writer(const Gid& publisher);
  [[nodiscard]] Vec3 position(double t) const;
  void send(double t);
  void send_joints(double stamp, const MessageFaults& faults);
  void ping();

  MockLeaderOptions options_;
  Node node_;
  Publisher<Pose> pose_;
  Publisher<geometry_msgs::msg::TwistStamped> twist_;
  Publisher<sensor_msgs::msg::JointState> joints_;
  Publisher<crtk_msgs::msg::OperatingState> state_;
  Publisher<std_msgs::msg::Bool> following_;
  std::optional<Publisher<geometry_msgs::msg::WrenchStamped>> there_;
  std::atomic<bool> absolute_{false}, gravity_compensation_{true};  // initial settings of a dVRK arm
  Subscription<std_msgs::msg::Bool> absolute_sub_, gravity_sub_;
  Subscription<geometry_msgs::msg::WrenchStamped> wrench_;
  std::optional<Subscription<geometry_msgs::msg::WrenchStamped>> back_;
  loop::RealTimeThread clock_;

  mutable std::mutex mutex_;  // guards the settings below
  MessageFaults faults_;
  Vec3 from_, to_, amplitude_;
  Eigen::Vector4d quat_{0.0, 0.0, 0.0, 1.0};
  double begin_ = 0.0, seconds_ = 0.0, frequency_ = 0.0;
  Log<double> sent_, echoes_;
  Log<ReceivedWrench> wrenches_;
  Log<FrameSetting> frame_settings_;
  std::vector<Gid> writers_;

  std::mt19937_64 random_;
  std::deque<Late> late_;
  std::optional<Pose> held_;
  std::int64_t tick_ = 0;
  std::atomic<std::uint64_t> pings_{0};
  Pose message_;
  geometry_msgs::msg::TwistStamped twist_message_;
  sensor_msgs::msg::JointState joints_message_;
  geometry_msgs::msg::WrenchStamped ping_;
  std::optional<Spinner> spinner_;  // declared last, so that it stops first
};

}  // namespace palpate::ros
