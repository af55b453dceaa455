// Measures how regularly a leader's states arrive, in a thread like the haptic cycle's.
#pragma once

#include <time.h>

#include <array>
#include <geometry_msgs/msg/pose_stamped.hpp>
#include <limits>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "palpate/loop/realtime.hpp"
#include "rcl/spinner.hpp"
#include "rcl/subscription.hpp"

namespace palpate::ros {

class StreamMeter {
 public:
  using Pose = geometry_msgs::msg::PoseStamped;
  using Row = std::array<double, 2>;

  StreamMeter(std::shared_ptr<Context> context, const std::string& topic)
      : node_(std::move(context), "palpate_stream_meter"),
        subscription_(
            node_, topic, [this](const Pose& message, const Info&) { take(message); },
            Qos{.depth = 5, .reliable = false}),
        spinner_(node_, {.in_thread = [] { loop::schedule({.allow_affinity = false}); }, .after = {}, .direct = true}) {
  }

  /// Time of arrival on the monotonic clock and age of the stamp then, of each message so far [s]. The age is NaN where
  /// the stamp is zero, by which CRTK marks invalid data.
  [[nodiscard]] std::vector<Row> rows() const {
    const std::lock_guard lock(mutex_);
    return rows_;
  }

 private:
  void take(const Pose& message) {
    timespec wall{};
    clock_gettime(CLOCK_REALTIME, &wall);
    const auto& stamp = message.header.stamp;
    const bool valid = stamp.sec != 0 || stamp.nanosec != 0;
    const double age = valid ? static_cast<double>(wall.tv_sec - stamp.sec) +
                                   1e-9 * (static_cast<double>(wall.tv_nsec) - static_cast<double>(stamp.nanosec))
                             : std::numeric_limits<double>::quiet_NaN();
    const std::lock_guard lock(mutex_);
    if (rows_.size() < kRows) rows_.push_back({1e-9 * static_cast<double>(loop::now_ns()), age});
  }

  static constexpr std::size_t kRows = 100'000;
  mutable std::mutex mutex_;
  std::vector<Row> rows_;
  Node node_;
  Subscription<Pose> subscription_;
  Spinner spinner_;  // declared last, so that it stops first
};

}  // namespace palpate::ros
