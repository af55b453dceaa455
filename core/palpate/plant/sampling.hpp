// Sampling limits of the simulated drives and encoders.
#pragma once

namespace palpate::plant {

/// Shortest period between two steps of a drive or an encoder [s]. It sets the length of the delay lines.
inline constexpr double kShortestPeriod = 1e-5;

}  // namespace palpate::plant
