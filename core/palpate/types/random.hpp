// Random numbers that are the same on every machine: those of std::uniform_real_distribution differ between libraries.
#pragma once

#include <random>

namespace palpate {

/// Uniform in [0, 1), of 53 bits.
[[nodiscard]] inline double uniform(std::mt19937_64& random) noexcept {
  return static_cast<double>(random() >> 11) * 0x1p-53;
}

}  // namespace palpate
