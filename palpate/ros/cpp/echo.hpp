// Sends every wrench of one topic back on another, with real-time priority where allowed. It measures the round-trip
// time of ROS itself.
#pragma once

#include <atomic>
#include <cstdint>
#include <geometry_msgs/msg/wrench_stamped.hpp>
#include <memory>
#include <string>

#include "palpate/loop/realtime.hpp"
#include "rcl/publisher.hpp"
#include "rcl/spinner.hpp"
#include "rcl/subscription.hpp"

namespace palpate::ros {

class Echo {
 public:
  using Wrench = geometry_msgs::msg::WrenchStamped;

  Echo(std::shared_ptr<Context> context, const std::string& from, const std::string& to)
      : node_(std::move(context), "palpate_echo"),
        publisher_(node_, to),
        subscription_(node_, from,
                      [this](const Wrench& wrench, const Info&) {
                        if (const Status sent = publisher_.publish(wrench); !sent) node_.problem(sent.problem);
                        ++count_;
                      }),
        spinner_(node_, {.in_thread = [] { loop::schedule({.allow_affinity = false}); }, .after = {}, .direct = true}) {
  }

  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }

 private:
  Node node_;
  std::atomic<std::uint64_t> count_{0};
  Publisher<Wrench> publisher_;
  Subscription<Wrench> subscription_;
  Spinner spinner_;  // declared last, so that it stops first
};

}  // namespace palpate::ros
