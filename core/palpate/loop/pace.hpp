// The pace along a planned motion: how an override of the speed, a pause and a stop change it.
#pragma once

namespace palpate::loop {

/// Speed along a motion relative to the plan: 0 rests, 1 is as planned. It changes by 1 within the stop time at most,
/// so that the goal never jumps, stays on the path, and rests within the stop time after a stop:
///   |pace' - pace| <= dt / T,   progress = (pace + pace') / 2 dt
class Pace {
 public:
  /// stop_time: T, time in which a motion at full pace comes to rest [s]. Throws std::invalid_argument unless it is
  /// above zero.
  explicit Pace(double stop_time);

  /// One period dt [s] towards the wanted pace; returns the progress along the motion [s].
  double step(double wanted, double dt) noexcept;
  /// Rests at once; for the end of a motion, where the plan itself rests.
  void reset() noexcept { value_ = 0.0; }
  /// The largest pace from which the motion rests within `left` [s] along it.
  [[nodiscard]] double limit(double left) const noexcept;
  [[nodiscard]] double value() const noexcept { return value_; }
  [[nodiscard]] double stop_time() const noexcept { return stop_time_; }

 private:
  double stop_time_;
  double value_ = 0.0;
};

}  // namespace palpate::loop
