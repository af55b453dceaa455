#include "topic_meter.hpp"

#include <rcl/subscription.h>
#include <rmw/serialized_message.h>

#include <chrono>
#include <cstdint>
#include <new>
#include <utility>

#include "rcl/qos.hpp"
#include "rcl/status.hpp"

namespace palpate::ros {
namespace {

constexpr std::size_t kDepth = 1000;  // messages that wait for the thread [-]

/// Seconds of a clock's present time.
template <class Clock>
double now() {
  return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

/// Stamp of a serialised header [s since 1970]: four bytes of CDR, then seconds and nanoseconds; 0: no stamp.
double stamp(const rmw_serialized_message_t& message) {
  if (message.buffer_length < 12) return 0.0;
  const auto word = [&](std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      const bool little = message.buffer[1] & 1;
      value |= static_cast<std::uint32_t>(message.buffer[at + k]) << 8 * (little ? k : 3 - k);
    }
    return value;
  };
  return static_cast<std::int32_t>(word(4)) + 1e-9 * word(8);
}

}  // namespace

class TopicMeter::Ear final : public Entity {
 public:
  Ear(Node& node, const Topic& topic)
      : node_(node),
        stamped_(topic.stamped),
        subscription_(rcl_get_zero_initialized_subscription()),
        message_(rmw_get_zero_initialized_serialized_message()) {
    rcl_subscription_options_t options = rcl_subscription_get_default_options();
    // Best effort, so that no publisher waits for this subscription; only latched messages need reliability.
    options.qos = Qos{.depth = kDepth, .reliable = topic.latched, .transient_local = topic.latched}.profile();
    check(rcl_subscription_init(&subscription_, node.get(), topic.type, topic.name.c_str(), &options),
          "listen to " + topic.name);
    const rcutils_allocator_t allocator = rcutils_get_default_allocator();
    if (rmw_serialized_message_init(&message_, 0, &allocator) != RMW_RET_OK) throw std::bad_alloc();
    node_.add(*this);
  }
  ~Ear() override {
    node_.remove(*this);
    if (rcl_subscription_fini(&subscription_, node_.get()) != RCL_RET_OK) rcl_reset_error();
    if (rmw_serialized_message_fini(&message_) != RMW_RET_OK) rcl_reset_error();
  }

  void count(Count& count) const noexcept override { ++count.subscriptions; }
  rcl_ret_t watch(rcl_wait_set_t& set) noexcept override {
    return rcl_wait_set_add_subscription(&set, &subscription_, &place_);
  }
  void work(const rcl_wait_set_t& set) override {
    if (set.subscriptions[place_]) take();
  }
  void take() override {
    while (rcl_take_serialized_message(&subscription_, &message_, nullptr, nullptr) == RCL_RET_OK) {
      heard.arrivals.push_back(now<std::chrono::steady_clock>());
      const double sent = stamped_ ? stamp(message_) : 0.0;
      if (sent != 0.0) heard.ages.push_back(now<std::chrono::system_clock>() - sent);
    }
    rcl_reset_error();
  }

  Heard heard;

 private:
  Node& node_;
  bool stamped_;
  rcl_subscription_t subscription_;
  rmw_serialized_message_t message_;
  std::size_t place_ = 0;
};

TopicMeter::TopicMeter(std::shared_ptr<Context> context, const std::string& name)
    : node_(std::move(context), name), spinner_(node_) {}

TopicMeter::~TopicMeter() { spinner_.stop(); }

void TopicMeter::listen(const std::vector<Topic>& topics) {
  ears_.clear();
  for (const Topic& topic : topics) ears_.push_back(std::make_unique<Ear>(node_, topic));
}

std::vector<TopicMeter::Heard> TopicMeter::take() {
  std::vector<Heard> heard;
  heard.reserve(ears_.size());
  for (const auto& ear : ears_) node_.remove(*ear);  // their messages are not taken any more
  for (const auto& ear : ears_) heard.push_back(std::move(ear->heard));
  ears_.clear();
  return heard;
}

}  // namespace palpate::ros
