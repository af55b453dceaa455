// The whole thing: hand, leader and follower simulated around the haptic cycle, in lockstep or in real time.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "palpate/contact/tool.hpp"
#include "palpate/loop/cycle.hpp"
#include "palpate/loop/front.hpp"
#include "palpate/loop/hand_motion.hpp"
#include "palpate/loop/histogram.hpp"
#include "palpate/loop/realtime.hpp"
#include "palpate/plant/follower.hpp"
#include "palpate/plant/hand.hpp"
#include "palpate/plant/leader.hpp"
#include "palpate/types/mailbox.hpp"

namespace palpate::loop {

struct SimulationOptions : CycleOptions {
  double plant_rate = 10000.0;  ///< servo periods per second, at least; rounded up to a multiple of `rate` [Hz]
  double loop_delay = 0.0;      ///< from command to torque, of the force term [s]
  double loop_jitter = 0.0;     ///< on top of it: uniform from 0 to this, of each command anew, order kept [s]
  std::uint64_t seed = 0;       ///< of the hand's tremor, the load cell's noise and the jitter
  double tremor = 0.0;          ///< 8-12 Hz trembling of the hand, rms per axis [m]
  JointVector q_leader0;        ///< where the leader starts, at rest [rad]
  JointVector q_follower0;      ///< where the follower starts [rad, m]
  plant::LeaderOptions leader;
  plant::HandOptions hand;
  plant::FollowerOptions follower;
  RealTimeOptions realtime;
};

class Simulation {  // NOLINT(clang-analyzer-optin.performance.Padding): there is one, and this order reads best
 public:
  /// leader: the arm as it is; leader_model: as the controller believes it is. Throws std::invalid_argument naming an
  /// option that cannot be.
  Simulation(const SimulationOptions& options, arm::Arm leader, arm::Arm leader_model, const arm::Arm& follower,
             std::shared_ptr<const scene::Snapshot> scene, HandPath path);
  ~Simulation() { stop(); }
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  /// Lockstep: n ticks as fast as the machine can, into rows[0..n). Fewer when paused. Deterministic.
  /// hand_W: where the hand is to be at the end of each tick beside its path, n points in W [m]; it stays where it is
  /// without. Calls may be short: an operator looks at the rows and leads the hand on.
  std::size_t run(std::size_t n, Tick* rows, const Vec3* hand_W = nullptr);

  /// Real time: a thread of its own from here on. Stopping ramps the force to zero first and keeps gravity compensated.
  void start();
  void stop();
  [[nodiscard]] bool running() const noexcept { return thread_.running(); }
  /// How people steer the simulation and read its ticks, from any thread.
  [[nodiscard]] Front& front() noexcept { return front_; }
  [[nodiscard]] const Front& front() const noexcept { return front_; }
  /// The first tick at which an arm's state became stale or a number was not finite, in words; empty when there was
  /// none. From any thread.
  [[nodiscard]] std::string fault();

  /// Times the stages of the cycle from now on; not while it runs in real time. Costs about a quarter of a
  /// microsecond a tick.
  void watch_stages();
  /// None before watch_stages().
  [[nodiscard]] const StageClock* stages() const noexcept { return stages_.get(); }
  [[nodiscard]] const Histogram& cycle_time() const noexcept { return cycle_time_; }
  [[nodiscard]] const RealTimeThread& thread() const noexcept { return thread_; }
  [[nodiscard]] const SimulationOptions& options() const noexcept { return options_; }

 private:
  void take(bool stopping) noexcept;
  void tick(double lateness_us) noexcept;
  void plant() noexcept;
  Wrench touch(double t) noexcept;
  bool wake(const Wake& wake) noexcept;

  SimulationOptions options_;
  Cycle cycle_;
  plant::Leader leader_;
  plant::Follower follower_;
  std::unique_ptr<contact::Tool> touched_;  ///< what a driven follower meets; none otherwise
  Vec3 F_touch_W_ = Vec3::Zero();
  HandMotion hand_;
  int substeps_;
  double plant_dt_;
  std::uint64_t k_ = 0;  ///< ticks since the start: t = k / rate, so that time has no rounding of its own
  CycleInput in_;
  Tick tick_{};

  RealTimeThread thread_;
  Front front_;
  Histogram cycle_time_;
  std::unique_ptr<StageClock> stages_;
  std::mutex driver_;         ///< one caller at a time runs, starts or stops
  std::mutex fault_readers_;  ///< one caller at a time reads the fault
  Mailbox<Tick> fault_;
  bool faulty_ = false;
};

}  // namespace palpate::loop
