#include "palpate/guidance/interface/options.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

#include "palpate/types/require.hpp"

namespace palpate::guidance {

void check(const Options& options) {
  require("guidance", options.force_rate > 0.0 && std::isfinite(options.force_rate), "force_rate", options.force_rate,
          "must be above 0 N/s, and finite; for example 20");
  require("guidance", options.moment_rate > 0.0 && std::isfinite(options.moment_rate), "moment_rate",
          options.moment_rate, "must be above 0 N m/s, and finite; for example 0.35");
  require("guidance", options.return_speed > 0.0 && std::isfinite(options.return_speed), "return_speed",
          options.return_speed, "must be above 0 m/s, and finite; for example 0.05");
  require("guidance", options.reserve >= 0.0 && options.reserve < 0.01, "reserve", options.reserve,
          "must lie in 0..0.01 m");
  if (!std::isfinite(options.servo.bandwidth) || !(options.servo.damping_ratio > 0.0)) {
    throw std::invalid_argument(
        "guidance.servo: bandwidth = " + std::to_string(options.servo.bandwidth) +
        " Hz must be finite (0: at once), damping_ratio = " + std::to_string(options.servo.damping_ratio) + " above 0");
  }
}

}  // namespace palpate::guidance
