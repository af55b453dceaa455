// What the system would play: volume, beeps and speech, checked as the real component checks them. There is no speaker
// here: what is played is said in a status.
#pragma once

#include "dvrk/outbox.hpp"

namespace palpate::dvrk {

class Audio {
 public:
  /// 0 to 1, clipped.
  void set_volume(double volume, const Voice& voice) noexcept;
  /// duration [s], frequency [Hz], volume 0..1; those left out: 0.3 s, 3 kHz, as set.
  void beep(const JointVector& values, const Voice& voice) const noexcept;
  static void say(const Text& words, const Voice& voice) noexcept;
  [[nodiscard]] double volume() const noexcept { return volume_; }

 private:
  double volume_ = 0.5;
};

}  // namespace palpate::dvrk
