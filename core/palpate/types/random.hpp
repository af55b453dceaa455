// Random numbers that are the same on every machine. Standard libraries differ in the numbers that their
// std::uniform_real_distribution generates.
#pragma once

#include <random>

namespace palpate {

/// Uniformly distributed number in [0, 1) with 53 random bits.
[[nodiscard]] inline double uniform(std::mt19937_64& random) noexcept {
  return static_cast<double>(random() >> 11) * 0x1p-53;
}

}  // namespace palpate
