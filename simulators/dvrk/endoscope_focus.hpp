// The focus motor of the endoscope, with the states and commands of mtsDaVinciEndoscopeFocus: one direction at a time,
// and none while it is locked.
#pragma once

#include "dvrk/outbox.hpp"

namespace palpate::dvrk {

/// The focus motor.
class EndoscopeFocus {
 public:
  explicit EndoscopeFocus(Outbox& out) : publisher_({Kind::focus, 0}, "endoscope_focus", out) {}

  void start() noexcept;                        ///< publishes the first states
  bool apply(const Command& command) noexcept;  ///< applies a command; false if it is none of its own
  void run(double t) noexcept { publisher_.at(t); }
  void focus_in(bool on) noexcept { focus(in_, out_, Topic::focusing_in, on); }
  void focus_out(bool on) noexcept { focus(out_, in_, Topic::focusing_out, on); }

 private:
  void focus(bool& mine, bool other, Topic topic, bool on) noexcept;
  void lock(bool on) noexcept;

  EventPublisher publisher_;
  bool locked_ = false, in_ = false, out_ = false;
};

}  // namespace palpate::dvrk
