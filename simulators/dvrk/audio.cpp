#include "dvrk/audio.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::dvrk {
namespace {

double within(double value, double low, double high, const char* otherwise, const EventPublisher& publisher) noexcept {
  const double allowed = std::clamp(value, low, high);
  if (allowed != value) publisher.message(Topic::warning, otherwise);
  return allowed;
}

}  // namespace

void Audio::set_volume(double volume, const EventPublisher& publisher) noexcept {
  if (!std::isfinite(volume)) return publisher.message(Topic::warning, "set_volume needs a finite number");
  volume_ = std::clamp(volume, 0.0, 1.0);
  Text words("volume set to ");
  words << std::lround(100.0 * volume_) << "%";
  publisher.message(Topic::status, words);
  publisher.value(Topic::volume, volume_);
}

void Audio::beep(const JointVector& values, const EventPublisher& publisher) const noexcept {
  const Eigen::Index n = values.size();
  if (n < 1 || n > 3 || !values.allFinite()) {
    return publisher.message(Topic::error, "beep expect up to 3 values (duration, frequency, volume)");
  }
  const double duration = within(values[0], 0.1, 60.0, "beep, duration must be between 0.1 and 60s", publisher);
  const double frequency = n > 1 ? values[1] : 3000.0;
  const double volume =
      n > 2 ? within(values[2], 0.0, 1.0, "beep, volume must be between 0 and 1", publisher) : volume_;
  Text words("beep, ");
  words << duration << " s, " << frequency << " Hz, volume " << volume;
  publisher.message(Topic::status, words);
}

void Audio::say(const Text& words, const EventPublisher& publisher) noexcept {
  Text told("says: ");
  told << words.view();
  publisher.message(Topic::status, told);
}

}  // namespace palpate::dvrk
