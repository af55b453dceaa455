// A subscriber for rare messages that also receives latched ones. A message latched before the subscription arrives
// only with transient-local durability, and a transient-local subscription receives nothing from a volatile publisher.
// This subscriber therefore starts as volatile, and adds a transient-local one once it finds a latching publisher.
#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "rcl/subscription.hpp"

namespace palpate::ros {

/// The search of a LatchedSubscriber of any message.
class LatchingSearch {
 public:
  virtual ~LatchingSearch() = default;
  /// Looks for a latching publisher on the topic. Call it from a thread that may allocate, but not from the spinner's.
  virtual void find_latching_publisher() = 0;
};

template <class Msg>
class LatchedSubscriber final : public LatchingSearch {
 public:
  using Callback = std::function<void(const Msg&)>;

  /// The callback gets each message once and the messages of a publisher in their order, in the thread of the node's
  /// spinner. Latched messages that were sent more than `oldest` [s] ago are ignored. `depth`: most latched messages of
  /// a publisher [-].
  LatchedSubscriber(Node& node, std::string topic, Callback callback,
                    double oldest = std::numeric_limits<double>::infinity(), std::size_t depth = 1)
      : node_(node),
        topic_(std::move(topic)),
        callback_(std::move(callback)),
        oldest_(oldest),
        depth_(depth),
        plain_(node_, topic_, [this](const Msg& message, const Info& info) { pass(message, info); }, Qos{}) {}

  void find_latching_publisher() override {
    if (latched_ || plain_.publishers() == 0) return;
    const auto ends = node_.publishers(topic_);
    if (std::any_of(ends.begin(), ends.end(), [](const Endpoint& e) { return e.reliable && e.transient_local; })) {
      latched_.emplace(
          node_, topic_,
          [this](const Msg& message, const Info& info) {
            if (age(info) <= oldest_) pass(message, info);
          },
          Qos{.depth = depth_, .transient_local = true});
    }
  }
  [[nodiscard]] const std::string& topic() const noexcept { return topic_; }

 private:
  struct Newest {
    Gid publisher{};
    std::uint64_t sequence = 0;
  };
  static constexpr std::size_t kPublishers = 64;  // publishers whose newest message is remembered [-]

  static double age(const Info& info) {
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    return 1e-9 *
           static_cast<double>(std::chrono::duration_cast<std::chrono::nanoseconds>(now).count() - info.source_ns);
  }
  void pass(const Msg& message, const Info& info) {
    if (is_new(info)) callback_(message);
  }
  /// True unless the message, or a later one of its publisher, has been passed on already.
  bool is_new(const Info& info) {
    if (info.sequence == RMW_MESSAGE_INFO_SEQUENCE_NUMBER_UNSUPPORTED) return true;
    const auto same = [&](const Newest& one) { return one.publisher == info.publisher; };
    const auto found = std::find_if(newest_.begin(), newest_.end(), same);
    if (found != newest_.end())
      return std::exchange(found->sequence, std::max(found->sequence, info.sequence)) < info.sequence;
    if (newest_.size() == kPublishers) newest_.erase(newest_.begin());
    newest_.push_back({info.publisher, info.sequence});
    return true;
  }

  Node& node_;
  std::string topic_;
  Callback callback_;
  double oldest_;
  std::size_t depth_;
  std::vector<Newest> newest_;
  Subscription<Msg> plain_;
  std::optional<Subscription<Msg>> latched_;
};

}  // namespace palpate::ros
