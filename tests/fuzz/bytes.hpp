// Reads values from the bytes of a fuzzer: mostly moderate numbers, sometimes extreme ones. After the end all are zero.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "palpate/types/spatial.hpp"

namespace fuzz {

/// Ends the process with the violated condition, as the fuzzer expects it.
inline void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "violated: %s\n", what);
  std::abort();
}

class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : at_(data), end_(data + size) {}

  [[nodiscard]] bool empty() const { return at_ == end_; }
  std::uint8_t byte() { return empty() ? std::uint8_t{0} : *at_++; }
  /// Index below n.
  std::size_t below(std::size_t n) { return byte() % n; }
  /// A number in [-size, size) on a grid of 256, which makes coincidences likely; in one of 64 cases any double.
  double number(double size) {
    const std::uint8_t first = byte();
    if (first != 77 || below(4) != 0) return size * (first - 128) / 128.0;
    std::uint8_t raw[8];
    for (std::uint8_t& b : raw) b = byte();
    double out = 0.0;
    std::memcpy(&out, raw, sizeof(out));
    return out;
  }
  palpate::Vec3 vector(double size) {
    const double x = number(size), y = number(size);
    return {x, y, number(size)};
  }

 private:
  const std::uint8_t *at_, *end_;
};

}  // namespace fuzz
