// Audio of the system: volume, beeps and speech, with the checks of the real component. The simulation has no speaker;
// it reports each sound as a status message.
#pragma once

#include "dvrk/outbox.hpp"

namespace palpate::dvrk {

/// Reports volume, beeps and speech.
class Audio {
 public:
  /// Sets the volume, clipped to 0..1.
  void set_volume(double volume, const EventPublisher& publisher) noexcept;
  /// values: duration [s], frequency [Hz] and volume 0..1; the defaults of the last two are 3 kHz and the volume set.
  void beep(const JointVector& values, const EventPublisher& publisher) const noexcept;
  static void say(const Text& words, const EventPublisher& publisher) noexcept;
  [[nodiscard]] double volume() const noexcept { return volume_; }

 private:
  double volume_ = 0.5;
};

}  // namespace palpate::dvrk
