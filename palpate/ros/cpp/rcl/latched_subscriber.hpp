// A subscriber for rare messages that also receives latched ones. A message latched before the subscription arrives
// only with transient-local durability, and a transient-local subscription receives nothing from a volatile publisher.
// This subscriber therefore has a volatile subscription, and a transient-local one until each latching publisher has
// delivered what it had latched. The latter must not stay: a volatile publisher that comes later would be warned by its
// middleware that no messages will be sent.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <limits>
#include <mutex>
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
  [[nodiscard]] virtual const std::string& topic() const noexcept = 0;
  /// Number of publishers of the topic that are matched now [-]. From any thread, without a wait.
  [[nodiscard]] virtual std::size_t publishers() const noexcept = 0;
  /// Forgets what was received, so that a latched message arrives again. From the thread of find_latching_publisher().
  virtual void forget() = 0;
};

/// How many publishers a LatchedSubscriber listens to.
enum class Sources {
  any,  ///< all of them
  one,  ///< none while there are several: their messages could contradict each other
};

template <class Msg>
class LatchedSubscriber final : public LatchingSearch {
 public:
  using Callback = std::function<void(const Msg&)>;

  /// The callback gets each message once and the messages of a publisher in their order, in the thread of the node's
  /// spinner. Latched messages that were sent more than `oldest` [s] ago are ignored. `depth`: most latched messages of
  /// a publisher [-].
  LatchedSubscriber(Node& node, std::string topic, Callback callback,
                    double oldest = std::numeric_limits<double>::infinity(), std::size_t depth = 1,
                    Sources sources = Sources::any)
      : node_(node),
        topic_(std::move(topic)),
        callback_(std::move(callback)),
        oldest_(oldest),
        depth_(depth),
        sources_(sources),
        plain_(node_, topic_, [this](const Msg& message, const Info& info) { pass(message, info); }, Qos{}) {}

  void find_latching_publisher() override {
    if (!awaits_latched()) {
      latched_.reset();
    } else if (!latched_) {
      latched_.emplace(
          node_, topic_,
          [this](const Msg& message, const Info& info) {
            note_delivery(info.publisher);
            if (age(info) <= oldest_) pass(message, info);
          },
          Qos{.depth = depth_, .transient_local = true});
    }
  }
  [[nodiscard]] const std::string& topic() const noexcept override { return topic_; }
  [[nodiscard]] std::size_t publishers() const noexcept override { return plain_.publishers(); }
  void forget() override {
    forget_ = true;
    latched_.reset();
    const std::lock_guard lock(mutex_);
    latching_.clear();
  }

 private:
  using Clock = std::chrono::steady_clock;
  struct Newest {
    Gid publisher{};
    std::uint64_t sequence = 0;
  };
  /// A latching publisher.
  struct Latching {
    Gid publisher{};
    Clock::time_point found;  ///< time at which it was found
    bool delivered = false;   ///< what it had latched has arrived
  };
  // A publisher that delivers nothing had latched nothing. Fast DDS repeats what was lost after 3 s.
  static constexpr auto kPatience = std::chrono::milliseconds(3500);
  static constexpr std::size_t kPublishers = 64;  // publishers whose newest message is remembered [-]

  static double age(const Info& info) {
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    return 1e-9 *
           static_cast<double>(std::chrono::duration_cast<std::chrono::nanoseconds>(now).count() - info.source_ns);
  }
  /// True if a latching publisher has not delivered yet.
  bool awaits_latched() {
    std::vector<Latching> now;
    const std::vector<Endpoint> ends = plain_.publishers() > 0 ? node_.publishers(topic_) : std::vector<Endpoint>{};
    const std::lock_guard lock(mutex_);
    for (const Endpoint& end : ends) {
      if (!end.reliable || !end.transient_local) continue;
      const auto known = std::find_if(latching_.begin(), latching_.end(),
                                      [&](const Latching& one) { return one.publisher == end.gid; });
      now.push_back(known != latching_.end() ? *known : Latching{end.gid, Clock::now()});
    }
    latching_ = std::move(now);
    return std::any_of(latching_.begin(), latching_.end(),
                       [](const Latching& one) { return !one.delivered && Clock::now() - one.found < kPatience; });
  }
  void note_delivery(const Gid& publisher) {
    const std::lock_guard lock(mutex_);
    for (Latching& one : latching_) one.delivered = one.delivered || one.publisher == publisher;
  }
  void pass(const Msg& message, const Info& info) {
    if (forget_.exchange(false)) newest_.clear();
    if (sources_ == Sources::one && plain_.publishers() > 1) return;
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
  Sources sources_;
  std::atomic<bool> forget_{false};
  std::vector<Newest> newest_;
  std::mutex mutex_;  ///< guards latching_
  std::vector<Latching> latching_;
  Subscription<Msg> plain_;
  std::optional<Subscription<Msg>> latched_;
};

}  // namespace palpate::ros
