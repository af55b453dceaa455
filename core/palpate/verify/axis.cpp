#include "palpate/verify/axis.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <span>
#include <stdexcept>
#include <string>

#include "palpate/types/low_pass.hpp"
#include "palpate/types/random.hpp"
#include "palpate/verify/axis_motion.hpp"

namespace palpate::verify {
namespace {

constexpr double kFar = 1.0;                      // [m] beyond it the axis has diverged
constexpr double kPeriods = 4.0;                  // periods of the slowest mode in a run without a given duration
constexpr double kShortest = 0.5, kFirst = 30.0;  // bounds of that length before it is doubled [s]
constexpr int kDoublings = 5;                     // largest number of times that the duration is doubled
constexpr std::size_t kFewest = 16;               // smallest number of cycles that can be judged
constexpr double kSettled = 0.02;                 // settling band as a fraction of the rest position

void require(bool good, const char* name, double value, const char* remedy) {
  if (!good) {
    throw std::invalid_argument("axis " + std::string(name) + " = " + std::to_string(value) + ": " + remedy);
  }
}

void check(const AxisOptions& o) {
  const auto not_negative = [](const char* name, double value) {
    require(value >= 0.0 && std::isfinite(value), name, value, "must be 0 or more, and finite");
  };
  require(o.mass > 0.0 && std::isfinite(o.mass), "mass", o.mass, "must be above 0 kg");
  require(o.rate >= 10.0 && o.rate <= 1e5, "rate", o.rate, "must lie in 10..100000 Hz");
  require(o.delay >= 0.0 && o.jitter >= 0.0 && o.delay + o.jitter <= 1.0, "delay + jitter", o.delay + o.jitter,
          "neither may be below zero, nor both together above 1 s");
  require(o.force_max > 0.0, "force_max", o.force_max, "must be above 0 N");
  require(o.rate_max > 0.0, "rate_max", o.rate_max, "must be above 0 N/s");
  not_negative("damping", o.damping);
  not_negative("coulomb", o.coulomb);
  not_negative("quantum", o.quantum);
  not_negative("velocity_cutoff", o.velocity_cutoff);
  not_negative("K", o.K);
  not_negative("B", o.B);
  not_negative("hand_mass", o.hand_mass);
  not_negative("hand_damping", o.hand_damping);
  require(o.hand_stiffness == 0.0 || (o.hand_stiffness >= 1e-3 && std::isfinite(o.hand_stiffness)), "hand_stiffness",
          o.hand_stiffness, "must be 0 (no spring), or 0.001 N/m and more");
}

/// The controller: computes the force of the wall once per cycle.
class Controller {
 public:
  explicit Controller(const AxisOptions& o)
      : o_(o), dt_(1.0 / o.rate), share_(low_pass_coefficient(o.velocity_cutoff, dt_)) {}

  /// Initialises the velocity filter for an axis at rest at x.
  void start(double x) noexcept { x_ = measured(x); }

  double step(double x_true, AxisStage* stage) noexcept {
    const double x = measured(x_true);
    v_ += share_ * ((x - x_) / dt_ - v_);
    x_ = x;
    double F = o_.bilateral || x > 0.0 ? -(o_.K * x + o_.B * v_) : 0.0;
    if (!o_.bilateral) F = std::min(F, 0.0);  // a wall never pulls
    F = std::clamp(F, -o_.force_max, o_.force_max);
    F = std::clamp(F, F_ - o_.rate_max * dt_, F_ + o_.rate_max * dt_);
    if (stage != nullptr) F = stage->step(F, x, dt_);
    return F_ = F;
  }

 private:
  [[nodiscard]] double measured(double x) const noexcept {
    return o_.quantum > 0.0 ? std::nearbyint(x / o_.quantum) * o_.quantum : x;
  }

  const AxisOptions& o_;
  double dt_, share_;
  double x_ = 0.0, v_ = 0.0, F_ = 0.0;
};

/// The transmission line: commands in flight, each with the cycle of its arrival and the time from the cycle's
/// beginning.
class TransmissionLine {
 public:
  explicit TransmissionLine(const AxisOptions& o)
      : o_(o), random_(o.seed), ring_(static_cast<std::size_t>((o.delay + o.jitter) * o.rate) + 4) {}

  void send(std::size_t cycle, double F) noexcept {
    double late = o_.delay * o_.rate;  // [cycles]
    if (o_.jitter > 0.0) late += o_.jitter * o_.rate * uniform(random_);
    const double whole = std::floor(late + 1e-9);
    Command now{cycle + static_cast<std::size_t>(whole), std::max(late - whole, 0.0) / o_.rate, F};
    if (size_ > 0) {  // commands do not overtake each other
      const Command& last = ring_[(head_ + size_ - 1) % ring_.size()];
      if (now.cycle < last.cycle || (now.cycle == last.cycle && now.after < last.after)) {
        now.cycle = last.cycle, now.after = last.after;
      }
    }
    ring_[(head_ + size_++) % ring_.size()] = now;
  }

  struct Command {
    std::size_t cycle = 0;
    double after = 0.0, F = 0.0;  ///< [s], [N]
  };
  /// The next command that arrives in this cycle, or null.
  const Command* take(std::size_t cycle) noexcept {
    if (size_ == 0 || ring_[head_].cycle > cycle) return nullptr;
    const Command* next = &ring_[head_];
    head_ = (head_ + 1) % ring_.size();
    --size_;
    return next;
  }

 private:
  const AxisOptions& o_;
  std::mt19937_64 random_;
  std::vector<Command> ring_;
  std::size_t head_ = 0, size_ = 0;
};

struct Window {
  double low, high, mean;
  [[nodiscard]] double amplitude() const noexcept { return 0.5 * (high - low); }
};

Window window(const std::vector<double>& x, std::size_t from, std::size_t to) noexcept {
  Window w{x[from], x[from], 0.0};
  for (std::size_t i = from; i < to; ++i) {
    w.low = std::min(w.low, x[i]), w.high = std::max(w.high, x[i]);
    w.mean += x[i] / static_cast<double>(to - from);
  }
  return w;
}

double rest_floor(const AxisOptions& o) noexcept { return std::max(kAxisQuanta * o.quantum, kAxisUnfelt); }

/// Index of the cycle from which the hand's path is constant.
std::size_t path_end(const std::vector<double>& path) noexcept {
  std::size_t end = path.size();
  while (end > 0 && path[end - 1] == path.back()) --end;
  return end;
}

SwingJudgement judge_from(const AxisOptions& o, const std::vector<double>& x, std::size_t from) noexcept {
  const std::span<const double> all(x);
  return judge_swing(all.subspan(std::min(from, x.size())), 1.0 / o.rate, slowest_period(o), rest_floor(o));
}

/// True if a longer run would be judged the same. A swing whose amplitude grows or stays the same over all windows
/// lasts; one whose amplitude falls may end at rest or in a limit cycle.
bool is_final(const SwingJudgement& judged) noexcept {
  return judged.swing == Swing::rests ||
         (judged.swing == Swing::lasts && judged.windows == kSwingWindows && judged.change > -kSwingLost);
}

/// Evaluates the positions at the cycles.
void describe(const AxisOptions& o, const std::vector<double>& x, AxisResult& out) noexcept {
  const double floor = rest_floor(o);
  const std::size_t n = x.size(), late = n - n / 4;
  out.peak = *std::max_element(x.begin(), x.end());
  if (n < kFewest || out.diverged) return;
  const Window now = window(x, late, n);
  out.amplitude = now.amplitude();
  out.rest = now.mean;
  out.overshoot = now.mean > 0.0 ? (out.peak - now.mean) / now.mean : 0.0;
  std::size_t up = 0, last = 0;
  for (std::size_t i = late + 1; i < n; ++i) up += x[i - 1] < now.mean && x[i] >= now.mean ? 1 : 0;
  out.frequency = static_cast<double>(up) * o.rate / static_cast<double>(n - late);
  for (std::size_t i = 0; i < n; ++i) {
    if (std::abs(x[i] - now.mean) > std::max(kSettled * std::abs(now.mean), floor)) last = i + 1;
  }
  out.settling = static_cast<double>(last) / o.rate;
}

}  // namespace

double slowest_period(const AxisOptions& o) noexcept {
  const double k = o.hand_stiffness > 0.0 && !o.bilateral ? o.hand_stiffness : o.K + o.hand_stiffness;
  return k > 0.0 ? 2.0 * std::numbers::pi * std::sqrt((o.mass + o.hand_mass) / k) : 0.0;
}

Axis::Axis(const AxisOptions& options) : options_(options) { check(options_); }

AxisResult Axis::run(const AxisMotion& motion, AxisStage* stage, std::vector<AxisRow>* rows) {
  const AxisOptions& o = options_;
  const double given = motion.duration.value_or(1.0);
  require(given > 0.0 && given <= 1e4, "duration", given, "must lie in 0..10000 s");
  AxisMass body(o.mass + o.hand_mass, o.damping + o.hand_damping, o.hand_stiffness, o.coulomb);
  body.x = motion.x0, body.v = motion.v0;
  Controller controller(o);
  controller.start(body.x);
  TransmissionLine line(o);
  const double dt = 1.0 / o.rate;
  const std::size_t moved = path_end(motion.path);
  const double first = std::clamp(kPeriods * slowest_period(o), kShortest, kFirst);
  std::size_t n = motion.duration
                      ? static_cast<std::size_t>(std::ceil(given * o.rate))
                      : std::max(motion.path.size(), moved + static_cast<std::size_t>(std::ceil(first * o.rate)));
  const auto path = [&](std::size_t k) {
    return motion.path.empty() ? 0.0 : motion.path[std::min(k, motion.path.size() - 1)];
  };
  std::vector<double> x;
  x.reserve(n);
  AxisResult out;
  double acting = 0.0;
  int doublings = motion.duration ? 0 : kDoublings;
  SwingJudgement judged;
  for (std::size_t k = 0; k < n && !out.diverged; ++k) {
    x.push_back(body.x);
    const double F = controller.step(body.x, stage);
    if (rows != nullptr) rows->push_back({static_cast<double>(k) * dt, body.x, body.v, F, out.energy_port});
    line.send(k, F);
    const double p = path(k), w = (path(k + 1) - p) / dt;
    double at = 0.0;
    const auto go = [&](double until) {
      if (until <= at) return;
      const double before = body.x;
      body.step(until - at, acting + motion.push + o.hand_damping * w, p + w * at, w);
      out.energy_port -= acting * (body.x - before);
      out.energy_min = std::min(out.energy_min, out.energy_port);
      at = until;
    };
    while (const TransmissionLine::Command* arrived = line.take(k)) {
      go(arrived->after);
      acting = arrived->F;
    }
    go(dt);
    out.diverged = !(std::abs(body.x) < kFar);
    if (k + 1 < n) continue;
    judged = judge_from(o, x, moved);
    if (doublings-- > 0 && !is_final(judged)) n = moved + 2 * (n - moved);
  }
  out.swing = out.diverged ? Swing::lasts : judged.swing;
  out.oscillates = out.swing == Swing::lasts;
  out.growth = out.diverged ? 0.0 : judged.growth;
  out.duration = static_cast<double>(x.size()) * dt;
  describe(o, x, out);
  return out;
}

}  // namespace palpate::verify
