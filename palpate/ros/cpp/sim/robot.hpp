// The simulated dVRK on ROS 2. Three threads: the robot's own, at its servo's pace; one that publishes; one that
// listens.
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
#include "sim/measures.hpp"
#include "sim/queries.hpp"

namespace palpate::ros {

class Robot {
 public:
  /// `robot` and its `twin`, which answers queries, are nobody else's while this lives.
  /// `rate`: of what is measured [Hz]; up to 1000, rounded so that a period is a whole number of ticks.
  Robot(const std::shared_ptr<Context>& context, dvrk::System& robot, dvrk::System& twin, double rate);
  ~Robot() { stop(); }
  Robot(const Robot&) = delete;
  Robot& operator=(const Robot&) = delete;

  /// Powers the arms off, tells it, and ends the threads.
  void stop();

  [[nodiscard]] double rate() const noexcept { return 1.0 / (dvrk::System::kTick * every_); }
  [[nodiscard]] const loop::RealTimeThread& servo() const noexcept { return servo_; }
  [[nodiscard]] std::uint64_t commands() const noexcept { return commands_told_; }
  /// Commands that came faster than the servo took them.
  [[nodiscard]] std::uint64_t dropped() const noexcept { return commands_.dropped(); }
  /// How often everything that is measured was published.
  [[nodiscard]] std::uint64_t rounds() const noexcept { return rounds_told_; }

 private:
  /// A state with the time it was measured.
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

  dvrk::System& robot_;
  int every_;  // ticks between publications
  Node node_, query_node_;
  Queries queries_;
  Events events_;
  std::vector<std::unique_ptr<ArmMeasures>> arms_;
  std::vector<std::unique_ptr<TeleopMeasures>> teleops_;

  loop::Ring<dvrk::Command> commands_{1024};
  loop::Ring<Happened> happened_{4096};
  std::vector<std::unique_ptr<Mailbox<Stamped<dvrk::ArmState>>>> arm_states_;
  std::vector<std::unique_ptr<Mailbox<Stamped<dvrk::TeleopState>>>> teleop_states_;
  std::atomic<std::uint64_t> commands_told_{0}, rounds_told_{0};
  std::optional<Happened> untold_;
  std::atomic<std::uint32_t> rounds_{0};  // of what is to be published
  std::atomic<bool> ending_{false};
  int ticks_ = 0, ticks_left_ = -1;

  std::vector<std::unique_ptr<Entity>> subscriptions_;
  std::unique_ptr<Spinner> spinner_, query_spinner_;
  std::thread publisher_;
  loop::RealTimeThread servo_;
};

}  // namespace palpate::ros
