#include "palpate/verify/swing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace palpate::verify {
namespace {

using Record = std::span<const double>;

double amplitude(Record x) noexcept {
  const auto [low, high] = std::minmax_element(x.begin(), x.end());
  return 0.5 * (*high - *low);
}

/// Longest time between two upward crossings of the mean [samples]; 0 for fewer than two crossings.
std::size_t longest_period(Record x) noexcept {
  const double mean = std::accumulate(x.begin(), x.end(), 0.0) / static_cast<double>(x.size());
  std::size_t longest = 0, before = 0;
  for (std::size_t i = 1; i < x.size(); ++i) {
    if (x[i - 1] >= mean || x[i] < mean) continue;
    if (before > 0) longest = std::max(longest, i - before);
    before = i;
  }
  return longest;
}

/// True if x crosses the middle of its range twice or more. A drift or a creep crosses it once.
bool turns_back(Record x) noexcept {
  const auto [low, high] = std::minmax_element(x.begin(), x.end());
  const double middle = 0.5 * (*low + *high);
  std::size_t crossings = 0;
  for (std::size_t i = 1; i < x.size(); ++i) crossings += (x[i - 1] < middle) != (x[i] < middle) ? 1 : 0;
  return crossings >= 2;
}

struct Trend {
  double slope, error;
};

/// Regression line of y over its index: slope and standard error of the slope, for three values or more.
Trend trend(Record y) noexcept {
  const auto n = static_cast<double>(y.size());
  const double middle = 0.5 * (n - 1.0), mean = std::accumulate(y.begin(), y.end(), 0.0) / n;
  double xx = 0.0, xy = 0.0, yy = 0.0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    const double dx = static_cast<double>(i) - middle, dy = y[i] - mean;
    xx += dx * dx, xy += dx * dy, yy += dy * dy;
  }
  return {xy / xx, std::sqrt(std::max(yy - xy * xy / xx, 0.0) / (n - 2.0) / xx)};
}

/// True if the amplitudes of the windows fall significantly along their trend. logs: logarithms of the amplitudes.
bool falls(Record logs, const Trend& line) noexcept {
  const std::size_t n = logs.size();
  const auto largest = [&](std::size_t from, std::size_t to) {
    return *std::max_element(logs.begin() + static_cast<std::ptrdiff_t>(from),
                             logs.begin() + static_cast<std::ptrdiff_t>(to));
  };
  return line.slope + kSwingErrors * line.error < 0.0 && line.slope * static_cast<double>(n - 1) < -kSwingLost &&
         largest(n - n / 3, n) < largest(n / 3, n - n / 3);
}

}  // namespace

const char* swing_name(Swing swing) noexcept {
  constexpr std::array kNames = {"rests", "decays", "lasts", "undecided"};
  return kNames[static_cast<std::size_t>(swing)];
}

SwingJudgement judge_swing(Record x, double dt, double period, double floor) noexcept {
  SwingJudgement out;
  const Record watched = x.subspan(static_cast<std::size_t>(kSwingTransient * static_cast<double>(x.size())));
  if (watched.size() < 2 * kSwingFewest) return out;
  const std::size_t given = static_cast<std::size_t>(std::ceil(period / dt));
  const std::size_t slowest = std::max({given, longest_period(watched), std::size_t{2}});
  out.period = static_cast<double>(slowest) * dt;
  const std::size_t end = std::min(std::max(slowest, watched.size() / 4), watched.size());
  if (given <= watched.size() && amplitude(watched.last(end)) <= floor) {
    out.swing = Swing::rests;
    return out;
  }
  const std::size_t n = std::min(kSwingWindows, watched.size() / slowest);
  if (n < kSwingFewest) return out;
  std::array<double, kSwingWindows> logs{};
  std::size_t swinging = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t from = i * watched.size() / n, to = (i + 1) * watched.size() / n;
    const Record window = watched.subspan(from, to - from);
    logs[i] = std::log(std::max(amplitude(window), floor));
    swinging += turns_back(window) ? 1 : 0;
  }
  out.windows = n;
  const Record amplitudes = Record(logs).first(n);
  const Trend line = trend(amplitudes);
  out.change = line.slope * static_cast<double>(n - 1);
  out.growth = line.slope * static_cast<double>(n) / (static_cast<double>(watched.size()) * dt);
  out.swing = 2 * swinging < n || falls(amplitudes, line) ? Swing::decays : Swing::lasts;
  return out;
}

}  // namespace palpate::verify
