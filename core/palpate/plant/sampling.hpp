// How finely the simulated drives and encoders can be sampled.
#pragma once

namespace palpate::plant {

/// Shortest period between two steps of a drive or an encoder [s]; delay lines have room for as many.
inline constexpr double kShortestPeriod = 1e-5;

}  // namespace palpate::plant
