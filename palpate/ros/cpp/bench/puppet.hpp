// A CRTK leader that is none: it moves as told, at an exact rate, and notes every wrench it is sent. What a bench
// measures with, and what tests spoil: a network that loses, doubles, turns round, delays or falsifies.
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

#include "bench/notes.hpp"
#include "palpate/loop/realtime.hpp"
#include "palpate/types/spatial.hpp"
#include "rcl/publisher.hpp"
#include "rcl/spinner.hpp"
#include "rcl/subscription.hpp"

namespace palpate::ros {

struct PuppetOptions {
  std::string leader = "MTMR", teleop = "MTMR_PSM1";
  std::string wrench = "/MTMR_PSM1/following/mtm/body/servo_cf";  ///< topic that it is pushed by
  double rate = 1000.0;                                           ///< of its states [Hz]
  bool reliable = true;
  bool echo = false;  ///< half a period later each time, send a wrench to /palpate_there and await it on /palpate_back
  std::uint64_t seed = 1;
};

/// What happens to its messages on the way.
struct Spoil {
  double drop = 0.0, twice = 0.0, swap = 0.0;  ///< shares of the messages [-]
  double delay = 0.0;                          ///< sent so much after their stamp [s]
  double clock = 0.0;                          ///< added to stamps [s]
  bool not_finite = false;                     ///< NaN in the position
  bool no_rotation = false;                    ///< a quaternion of zeros
  bool zero_stamp = false;                     ///< the sender says: not valid
  bool wrong_length = false;                   ///< joint states of three joints, then of none
  bool silent = false;                         ///< nothing is sent: the cable is out
};

/// A wrench as it came.
struct Felt {
  double t = 0.0;      ///< on our monotonic clock [s]
  double wall = 0.0;   ///< since 1970 [s]
  double stamp = 0.0;  ///< of its header [s]
  double f[3] = {}, torque[3] = {};
  double writer = 0.0;    ///< 0 for the first who wrote, 1 for the next, ...
  double absolute = 0.0;  ///< 1: a dVRK arm would read it in the axes of measured_cp's frame, 0: in those of its tip
  double sequence = 0.0;  ///< how many its writer had sent, this one included
};

/// How its wrenches are to be read, as it was told.
struct Flag {
  double t = 0.0;         ///< [s]
  double absolute = 0.0;  ///< as in Felt
};

class Puppet {
 public:
  Puppet(std::shared_ptr<Context> context, const PuppetOptions& options);
  ~Puppet();
  Puppet(const Puppet&) = delete;
  Puppet& operator=(const Puppet&) = delete;

  void start();
  void stop();
  /// Goes there from where it is, softly, within `seconds`.
  void move_to(const Vec3& p, double seconds);
  /// Goes round and round: `amplitude` [m] at `frequency` [Hz] about where it was told to be.
  void swing(const Vec3& amplitude, double frequency);
  /// The wrist turns, at once: quaternion x y z w.
  void turn_to(const Eigen::Vector4d& quat);
  void spoil(const Spoil& spoil);
  void set_state(const std::string& state, bool homed);
  void follow(bool on);

  // What it noted since it started; times on the monotonic clock [s].
  [[nodiscard]] std::vector<double> sent() const { return sent_.all(); }      ///< when each state was published
  [[nodiscard]] std::vector<Felt> felt() const { return felt_.all(); }        ///< every wrench
  [[nodiscard]] std::vector<double> echoes() const { return echoes_.all(); }  ///< there and back [s]
  [[nodiscard]] std::vector<Flag> flags() const { return flags_.all(); }      ///< body/set_cf_orientation_absolute
  [[nodiscard]] bool absolute() const noexcept { return absolute_; }
  [[nodiscard]] bool carried() const noexcept { return carried_; }  ///< by its gravity compensation
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
  [[nodiscard]] Vec3 place(double t) const;
  void send(double t);
  void send_joints(double stamp, const Spoil& spoil);
  void ping();

  PuppetOptions options_;
  Node node_;
  Publisher<Pose> pose_;
  Publisher<geometry_msgs::msg::TwistStamped> twist_;
  Publisher<sensor_msgs::msg::JointState> joints_;
  Publisher<crtk_msgs::msg::OperatingState> state_;
  Publisher<std_msgs::msg::Bool> following_;
  std::optional<Publisher<geometry_msgs::msg::WrenchStamped>> there_;
  std::atomic<bool> absolute_{false}, carried_{true};  // as a dVRK arm begins
  Subscription<std_msgs::msg::Bool> absolute_told_, carried_told_;
  Subscription<geometry_msgs::msg::WrenchStamped> wrench_;
  std::optional<Subscription<geometry_msgs::msg::WrenchStamped>> back_;
  loop::RealTimeThread clock_;

  mutable std::mutex mutex_;  // what people set
  Spoil spoil_;
  Vec3 from_, to_, amplitude_;
  Eigen::Vector4d quat_{0.0, 0.0, 0.0, 1.0};
  double begin_ = 0.0, seconds_ = 0.0, frequency_ = 0.0;
  Notes<double> sent_, echoes_;
  Notes<Felt> felt_;
  Notes<Flag> flags_;
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
  std::optional<Spinner> spinner_;  // last: it stops first
};

}  // namespace palpate::ros
