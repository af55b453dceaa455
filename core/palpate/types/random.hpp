// Random numbers that are the same on every machine. Standard libraries differ in the numbers that their
// std::uniform_real_distribution generates.
#pragma once

#include <cmath>
#include <numbers>
#include <random>

namespace palpate {

/// Uniformly distributed number in [0, 1) with 53 random bits.
[[nodiscard]] inline double uniform(std::mt19937_64& random) noexcept {
  return static_cast<double>(random() >> 11) * 0x1p-53;
}

/// Number with the standard normal distribution, by Box and Muller.
[[nodiscard]] inline double gauss(std::mt19937_64& random) noexcept {
  const double r = std::sqrt(-2.0 * std::log1p(-uniform(random)));
  return r * std::cos(2.0 * std::numbers::pi * uniform(random));
}

}  // namespace palpate
