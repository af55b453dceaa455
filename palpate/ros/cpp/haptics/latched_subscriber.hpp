// A subscriber for rare messages that also receives latched ones. A message latched before the subscription arrives
// only with transient-local durability, and a transient-local subscription receives nothing from a volatile publisher.
// This subscriber therefore starts as volatile, and adds a transient-local one once it finds a latching publisher.
#pragma once

#include <algorithm>
#include <functional>
#include <optional>
#include <string>

#include "rcl/subscription.hpp"

namespace palpate::ros {

template <class Msg>
class LatchedSubscriber {
 public:
  using Callback = std::function<void(const Msg&)>;

  LatchedSubscriber(Node& node, std::string topic, Callback callback)
      : node_(node),
        topic_(std::move(topic)),
        callback_(std::move(callback)),
        plain_(node_, topic_, forward(), Qos{}) {}

  /// Looks for a latching publisher on the topic. Call it from a thread that may allocate, but not from the spinner's.
  void find_latching_publisher() {
    if (latched_) return;
    const auto ends = node_.publishers(topic_);
    if (std::any_of(ends.begin(), ends.end(), [](const Endpoint& e) { return e.reliable && e.transient_local; })) {
      latched_.emplace(node_, topic_, forward(), kLatched);
    }
  }
  [[nodiscard]] const std::string& topic() const noexcept { return topic_; }

 private:
  typename Subscription<Msg>::Callback forward() {
    return [this](const Msg& message, const Info&) { callback_(message); };
  }

  Node& node_;
  std::string topic_;
  Callback callback_;
  Subscription<Msg> plain_;
  std::optional<Subscription<Msg>> latched_;
};

}  // namespace palpate::ros
