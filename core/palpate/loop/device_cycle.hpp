// The haptic cycle for a device in anybody's loop: each step takes one measured state and returns one wrench.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "palpate/loop/crtk_cycle.hpp"
#include "palpate/loop/front.hpp"
#include "palpate/loop/histogram.hpp"
#include "palpate/loop/link.hpp"

namespace palpate::loop {

/// Reason for which a state of the device was not used.
enum class DeviceFault : int {
  none = 0,
  not_finite,           ///< a number is NaN, infinite, or impossibly large
  not_rigid,            ///< the upper left 3 x 3 of the pose is no rotation matrix, or the last row is not 0 0 0 1
  left_handed,          ///< the axes of the pose are orthonormal but left-handed: one axis has the wrong sign
  time_not_increasing,  ///< the time did not increase since the last step
  gap,                  ///< the last step is too long ago
  too_often,            ///< the mean interval between steps is too short for the rate of the cycle
  driver_failed,        ///< reported by report_failure()
};

/// Measured state of a device.
struct DeviceState {
  double t = 0.0;                 ///< time on any clock that increases steadily [s]
  std::array<double, 16> X_LH{};  ///< pose of the handle in the device's base, row by row [m]
  std::optional<std::array<double, 6>> V_LH = std::nullopt;  ///< its velocity, if measured [m/s, rad/s]
  double gripper = 0.0;                                      ///< pinch angle, 0 = closed [rad]
  bool clutch = false;                                       ///< the clutch button is pressed
  std::uint32_t buttons = 0;                                 ///< bits of PALPATE_BUTTON_... in driver.h
};

/// A straight path of the handle in the device's base, from one to another.
struct Glide {
  using End = Eigen::Matrix<double, 7, 1>;  ///< displacement [m], rotation vector [rad], pinch angle [rad]
  double t = 0.0;                           ///< time before the first step [s]
  double dt = 0.0;                          ///< time between two steps [s]
  int steps = 0;
  End from, to;

  /// State of the device after step k of `steps`.
  [[nodiscard]] DeviceState at(int k) const noexcept;
};

/// The wrench is finite and below its caps at every step. It is zero in the same step if a number of the state is
/// invalid, because the position of the hand is then unknown. It ramps to zero within `release` if the time does not
/// increase, and is zero in the first step after a gap. After a fault it returns by a ramp, `settle` later.
class DeviceCycle {
 public:
  /// follower: model of the virtual follower. Throws std::invalid_argument naming an invalid option.
  DeviceCycle(CrtkOptions options, arm::Arm follower, std::shared_ptr<const scene::Snapshot> scene);
  ~DeviceCycle() { stop(); }
  DeviceCycle(const DeviceCycle&) = delete;
  DeviceCycle& operator=(const DeviceCycle&) = delete;

  /// Allocates the queue of ticks and starts the thread of the collision queries.
  void start();
  void stop();

  /// Puts the tool among the instruments of other cycles, which push it from the next step on. Throws
  /// std::invalid_argument naming an invalid value.
  void join(std::shared_ptr<Board> board, int index, std::vector<ToolCapsule> capsules, contact::InstrumentLaw law) {
    cycle_.join(std::move(board), index, std::move(capsules), law);
  }
  /// Puts the tool among rigid bodies, from the next step on; the owner of the engine advances it.
  void join_bodies(std::shared_ptr<Bodies> bodies, int tool) { cycle_.join_bodies(std::move(bodies), tool); }

  /// Lets the hand feel what this end of a link renders, from the next step on; null: the objects of the cycle. Not to
  /// be called while the cycle runs.
  void attach(std::shared_ptr<RemoteEnd> remote) noexcept {
    link_.attach(std::move(remote));
    cycle_.push(Vec3::Zero());
  }

  /// One step; returns the wrench on the hand, in the axes of the device's base [N, N m]. No allocation, no exception.
  const Wrench& step(const DeviceState& state) noexcept;
  /// Sets the wrench to zero and records it: the device cannot be read. Advances the clock by one period.
  const Wrench& report_failure() noexcept;

  /// False: the hand is let go, and the wrench ramps to zero.
  void allow_force(bool allowed) noexcept { gates_.following = allowed; }

  /// Torque on the operator's fingers after the last step, positive when it opens them; within the cap of the options
  /// `stability`, and zero at once after a fault [N m].
  [[nodiscard]] double gripper_torque() const noexcept { return tau_gripper_; }
  /// Why the state of the last step was not used.
  [[nodiscard]] DeviceFault fault() const noexcept { return fault_; }
  /// Bits of Status of the last step.
  [[nodiscard]] std::uint64_t status() const noexcept { return status_; }
  /// Mean time between steps; 0: unknown [s].
  [[nodiscard]] double period() const noexcept { return steps_ > 1 ? period_ : 0.0; }
  [[nodiscard]] Front& front() noexcept { return front_; }
  [[nodiscard]] const Front& front() const noexcept { return front_; }
  [[nodiscard]] const CrtkOptions& options() const noexcept { return cycle_.options(); }
  /// Compute time of a step.
  [[nodiscard]] const Histogram& cycle_time() const noexcept { return cycle_time_; }

 private:
  DeviceFault check_time(double t) noexcept;
  void take() noexcept;
  void reach_out(Controls& controls) noexcept;
  void feed(const DeviceState& state) noexcept;
  const Wrench& advance() noexcept;

  CrtkCycle cycle_;
  Front front_;
  Link link_;
  CrtkGates gates_;
  Histogram cycle_time_;
  DeviceFault fault_ = DeviceFault::none;
  std::uint64_t status_ = 0, steps_ = 0;
  double clock_ = 0.0;   ///< time of the cycle: the time of the caller where that increases [s]
  double ahead_ = 0.0;   ///< time by which failures have advanced the clock beyond that of the caller [s]
  double t_ = 0.0;       ///< time of the last state [s]
  double period_ = 0.0;  ///< running mean of the time between steps [s]
  bool clutch_ = false;  ///< clutch button of the last valid state
  Wrench F_;
  double tau_gripper_ = 0.0;
};

/// Steps several cycles of one world in turns, each along a path with equally many steps. Writes the largest force on
/// each hand to felt [N]. bodies: advanced after each turn; null without rigid bodies.
void glide(std::span<const std::shared_ptr<DeviceCycle>> cycles, std::span<const Glide> paths, Bodies* bodies,
           std::span<double> felt) noexcept;

}  // namespace palpate::loop
