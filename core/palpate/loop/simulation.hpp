// The simulation: hand, leader and follower around the haptic cycle, in lockstep or in real time.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "palpate/contact/tool.hpp"
#include "palpate/loop/bodies.hpp"
#include "palpate/loop/cycle.hpp"
#include "palpate/loop/front.hpp"
#include "palpate/loop/hand_motion.hpp"
#include "palpate/loop/histogram.hpp"
#include "palpate/loop/instruments.hpp"
#include "palpate/loop/link.hpp"
#include "palpate/loop/realtime.hpp"
#include "palpate/plant/follower.hpp"
#include "palpate/plant/hand.hpp"
#include "palpate/plant/leader.hpp"
#include "palpate/types/mailbox.hpp"

namespace palpate::loop {

/// Options of the simulation.
struct SimulationOptions : CycleOptions {
  double plant_rate = 10000.0;  ///< smallest rate of the simulated world; rounded up to a multiple of `rate` [Hz]
  double loop_delay = 0.0;      ///< delay from command to torque, of the force term [s]
  double loop_jitter = 0.0;     ///< additional delay of each command, uniform from 0 to this; the order is kept [s]
  std::uint64_t seed = 0;       ///< of the hand's tremor, the load cell's noise and the jitter
  double tremor = 0.0;          ///< 8-12 Hz tremor of the hand, rms per axis [m]
  JointVector q_leader0;        ///< initial joint positions of the leader, at rest [rad]
  JointVector q_follower0;      ///< initial joint positions of the follower [rad, m]
  plant::LeaderOptions leader;
  plant::HandOptions hand;
  plant::FollowerOptions follower;
  RealTimeOptions realtime;
};

/// Hand, leader and follower, simulated around a haptic cycle.
class Simulation {  // NOLINT(clang-analyzer-optin.performance.Padding): a single object, ordered for readability
 public:
  /// leader: the simulated arm; leader_model: the controller's model of it. Throws std::invalid_argument naming an
  /// invalid option.
  Simulation(const SimulationOptions& options, arm::Arm leader, arm::Arm leader_model, const arm::Arm& follower,
             std::shared_ptr<const scene::Snapshot> scene, HandPath path);
  ~Simulation() { stop(); }
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  /// Lockstep: n ticks as fast as the machine can, into rows[0..n); fewer if paused. Returns their number.
  /// Deterministic. hand_W: offset of the hand from its path at the end of each tick, n vectors in W [m]; null keeps
  /// the offset. An operator model makes short calls, reads the rows and sets the next offsets. Throws std::logic_error
  /// in real time.
  std::size_t run(std::size_t n, Tick* rows, const Vec3* hand_W = nullptr);

  /// Real time: runs the loop in a thread. stop() first ramps the force to zero and keeps gravity compensated.
  void start();
  void stop();
  [[nodiscard]] bool running() const noexcept { return thread_.running(); }
  /// The interface for other threads: controls, scene, fixtures, ticks.
  [[nodiscard]] Front& front() noexcept { return front_; }
  [[nodiscard]] const Front& front() const noexcept { return front_; }
  /// Text about the first tick with a stale state or a number that is not finite, or else about an exception of the
  /// collider; empty without a fault. From any thread.
  [[nodiscard]] std::string fault();

  /// Puts the instrument among those of other simulations, which push it from the next tick on. Throws std::logic_error
  /// in real time.
  void join(std::shared_ptr<Board> board, int index, std::vector<ToolCapsule> capsules, contact::InstrumentLaw law);
  /// Puts the tool among rigid bodies, from the next tick on. If it is their only tool, run() advances the engine after
  /// each tick; the owner of several loops advances it itself. Throws std::logic_error in real time.
  void join_bodies(std::shared_ptr<Bodies> bodies, int tool);
  /// Null if run() advances them.
  [[nodiscard]] Bodies* shared_bodies() const noexcept { return advances_ ? nullptr : bodies_.get(); }
  /// Shows the instrument to the other simulations and to the bodies; a real-time loop does so after each tick.
  void publish() noexcept;
  /// Lets the hand feel what this end of a link renders, from the next tick on. Throws std::logic_error in real time.
  void attach(std::shared_ptr<RemoteEnd> remote);
  /// For tests of isolation: the loop sleeps once in its next tick [s].
  void stall(double seconds) noexcept { stall_ns_ = static_cast<std::int64_t>(1e9 * seconds); }
  /// True if simulated time stands still.
  [[nodiscard]] bool paused() const { return front_.controls().paused; }

  /// Measures the time of the stages from now on, which takes about 0.25 us per tick. Throws std::logic_error in real
  /// time.
  void watch_stages();
  /// Null before watch_stages().
  [[nodiscard]] const StageClock* stages() const noexcept { return stages_.get(); }
  /// Compute times of the haptic cycle.
  [[nodiscard]] const Histogram& cycle_time() const noexcept { return cycle_time_; }
  [[nodiscard]] const RealTimeThread& thread() const noexcept { return thread_; }
  [[nodiscard]] const SimulationOptions& options() const noexcept { return options_; }

 private:
  /// Time of the next tick [s].
  [[nodiscard]] double now() const noexcept { return static_cast<double>(k_) / options_.rate; }
  void take(bool stopping) noexcept;
  void turn_hand() noexcept;
  const Tick& tick(double lateness_us) noexcept;
  void plant() noexcept;
  void meet() noexcept;
  void reach_out() noexcept;
  Wrench touch(double t) noexcept;
  bool wake(const Wake& wake) noexcept;

  SimulationOptions options_;
  Cycle cycle_;
  plant::Leader leader_;
  plant::Follower follower_;
  std::unique_ptr<contact::Tool> tool_contact_;  ///< contact of a driven follower; null otherwise
  Vec3 F_touch_W_ = Vec3::Zero();
  HandMotion hand_;
  Eigen::Vector4d quat_WL_ = Eigen::Vector4d::Zero();  ///< Controls::quat_WL of the last tick
  int substeps_;
  double plant_dt_;
  std::uint64_t k_ = 0;  ///< ticks since the start; t = k / rate does not accumulate rounding errors
  CycleInput in_;
  arm::Arm leader_model_, follower_model_;  ///< at the positions that in_world_ has published
  std::unique_ptr<InWorld> in_world_;       ///< null without other instruments
  std::shared_ptr<Bodies> bodies_;          ///< null without rigid bodies
  bool advances_ = false;                   ///< run() advances the engine of bodies_
  std::unique_ptr<BodyPort> body_port_;
  Link link_;
  OnTool on_tool_;  ///< forces of the other instruments at this tick
  std::atomic<std::int64_t> stall_ns_{0};

  RealTimeThread thread_;
  Front front_;
  Histogram cycle_time_;
  std::unique_ptr<StageClock> stages_;
  std::mutex driver_;         ///< serialises run(), start() and stop()
  std::mutex fault_readers_;  ///< serialises fault()
  Mailbox<Tick> fault_;
  bool faulty_ = false;
};

}  // namespace palpate::loop
