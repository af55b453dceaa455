// The simulated dVRK on ROS 2. The servo thread steps the robot, one thread publishes, one spinner receives commands,
// and another spinner answers queries.
//
//   topics ─► listen ─► ring of commands ─► robot.step() ─► mailboxes, ring of events ─► publish ─► topics
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "palpate/loop/realtime.hpp"
#include "palpate/loop/ring.hpp"
#include "palpate/types/mailbox.hpp"
#include "rcl/spinner.hpp"
#include "sim/commands.hpp"
#include "sim/events.hpp"
#include "sim/frames.hpp"
#include "sim/holders.hpp"
#include "sim/measures.hpp"
#include "sim/queries.hpp"
#include "sim/statistics.hpp"

namespace palpate::ros {

class Robot {
 public:
  /// `robot` and `twin` (which answers queries) must not be used by others during the lifetime of the object.
  /// `rate`: rate of the measured states [Hz], at most 1000; rounded so that a period is a whole number of ticks of
  /// 1/3000 s.
  Robot(const std::shared_ptr<Context>& context, dvrk::System& robot, dvrk::System& twin, double rate);
  ~Robot() { stop(); }
  Robot(const Robot&) = delete;
  Robot& operator=(const Robot&) = delete;

  /// Powers the arms off, publishes their states, and ends the threads.
  void stop();

  [[nodiscard]] double rate() const noexcept { return 1.0 / (dvrk::System::kTick * every_); }
  [[nodiscard]] const loop::RealTimeThread& servo() const noexcept { return servo_; }
  [[nodiscard]] std::uint64_t commands() const noexcept { return commands_received_; }
  /// Commands lost because the servo did not take them in time [-].
  [[nodiscard]] std::uint64_t dropped() const noexcept { return commands_.dropped(); }
  /// Number of times all measured states were published [-].
  [[nodiscard]] std::uint64_t rounds() const noexcept { return rounds_published_; }

 private:
  /// A state and the time of its measurement [ns since 1970].
  template <class State>
  struct Stamped {
    State state;
    std::int64_t time_ns = 0;
  };
  struct Happened {
    dvrk::Event event;
    std::int64_t time_ns = 0;
  };

  bool tick(const loop::Wake& wake) noexcept;
  void hand_over() noexcept;
  void publish() noexcept;
  void publish_round();
  void publish_frames(std::int64_t now);

  dvrk::System& robot_;
  int every_;  // ticks of the simulation between publications
  int steps_;  // ticks in a wake of the servo: the arms' controllers run in every second one
  Node node_, query_node_;
  Queries queries_;
  Events events_;
  Frames frames_;
  Statistics statistics_;
  Holders holders_;
  std::vector<std::unique_ptr<ArmMeasures>> arms_;
  std::vector<std::unique_ptr<TeleopMeasures>> teleops_;

  loop::Ring<dvrk::Command> commands_{1024};
  loop::Ring<Happened> happened_{4096};
  std::vector<std::unique_ptr<Mailbox<Stamped<dvrk::ArmState>>>> arm_states_;
  std::vector<std::unique_ptr<Mailbox<Stamped<dvrk::TeleopState>>>> teleop_states_;
  std::atomic<std::uint64_t> commands_received_{0}, rounds_published_{0};
  std::vector<Pose> bases_;  ///< of the arms, as told to the twin
  std::optional<Happened> unpublished_;
  std::atomic<std::uint32_t> rounds_{0};  // number of rounds handed to the publishing thread
  std::atomic<bool> ending_{false};
  int ticks_ = 0, ticks_left_ = -1, searches_ = 0;

  Subscriptions subscriptions_;
  std::unique_ptr<Spinner> spinner_, query_spinner_;
  std::thread publisher_;
  loop::RealTimeThread servo_;
};

}  // namespace palpate::ros
