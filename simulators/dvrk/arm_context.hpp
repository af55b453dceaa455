// Data shared by the parts of an arm (state machine, controller, reporter): its specification, its simulated hardware,
// its outgoing messages and the state that it publishes.
#pragma once

#include <algorithm>
#include <memory>

#include "dvrk/body.hpp"
#include "dvrk/instrument.hpp"
#include "dvrk/outbox.hpp"

namespace palpate::dvrk {

/// Replaces NaN by 0 and clamps to +-1e6, so that products with a client's numbers stay finite.
template <typename Vector>
[[nodiscard]] Vector bounded(const Vector& x) noexcept {
  static constexpr double kMost = 1e6;
  return x.unaryExpr([](double value) { return value != value ? 0.0 : std::clamp(value, -kMost, kMost); });
}

/// Shared data of an arm.
struct ArmContext {
  /// Throws std::invalid_argument naming the arm, the option and the remedy.
  ArmContext(ArmSpec arm, Address at, Outbox& out);

  [[nodiscard]] Eigen::Index n() const noexcept { return model.n(); }
  [[nodiscard]] bool is_homed() const noexcept;
  [[nodiscard]] bool is_joint_ready() const noexcept { return powered && biased; }
  [[nodiscard]] bool is_cartesian_ready() const noexcept;

  /// Sets and publishes the operating state.
  void set_operating(State operating, bool is_busy) noexcept;
  /// The same for is_busy and is_homed alone; publishes only a change.
  void set_busy(bool is_busy) noexcept;
  // Publish a text.
  void error(const Text& words) noexcept;
  void warning(const Text& words) const noexcept { publisher.message(Topic::warning, words); }
  void status(const Text& words) const noexcept { publisher.message(Topic::status, words); }

  ArmSpec spec;
  arm::Arm model;
  std::unique_ptr<Body> body;
  EventPublisher publisher;
  Instrument instrument;
  Pose base_frame;  ///< pose of the arm's own base in the frame of measured_cp
  bool powered = false;
  bool biased = false;  ///< encoders have been biased from the potentiometers
  int errors = 0;       ///< number of errors reported so far
  Text last_error;
  ArmState state;  ///< published state
};

}  // namespace palpate::dvrk
