// A subscription to one message type on one topic.
#pragma once

#include <rcl/subscription.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <rosidl_typesupport_cpp/message_type_support.hpp>
#include <string>

#include "rcl/node.hpp"
#include "rcl/qos.hpp"
#include "rcl/qos_event.hpp"
#include "rcl/status.hpp"

namespace palpate::ros {

/// Source and times of a message.
struct Info {
  std::int64_t source_ns = 0;    ///< time of sending on the publisher's clock [ns since 1970]
  std::int64_t received_ns = 0;  ///< time of arrival on this machine's clock [ns since 1970]
  Gid publisher{};               ///< identifier of the publisher
  std::uint64_t sequence = 0;    ///< number of messages that the publisher has sent, this one included
};

template <class Msg>
class Subscription final : public Entity {
 public:
  /// Called with each message, in the thread of the spinner or of the middleware. The message is valid only during the
  /// call.
  using Callback = std::function<void(const Msg&, const Info&)>;

  Subscription(Node& node, const std::string& topic, Callback callback, Qos qos = {})
      : node_(node),
        topic_(topic),
        callback_(std::move(callback)),
        subscription_(rcl_get_zero_initialized_subscription()) {
    rcl_subscription_options_t options = rcl_subscription_get_default_options();
    options.qos = qos.profile();
    const auto* type = rosidl_typesupport_cpp::get_message_type_support_handle<Msg>();
    check(rcl_subscription_init(&subscription_, node.get(), type, topic.c_str(), &options), "listen to " + topic);
    event_.emplace(node, topic, [this](rcl_event_t* event) {
      return rcl_subscription_event_init(event, &subscription_, RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS);
    });
    node_.add(*this);
  }
  ~Subscription() override {
    node_.remove(*this);
    set_receiver(nullptr);
    event_.reset();
    if (rcl_subscription_fini(&subscription_, node_.get()) != RCL_RET_OK) rcl_reset_error();
  }

  [[nodiscard]] std::size_t publishers() const noexcept override {
    std::size_t count = 0;
    if (rcl_subscription_get_publisher_count(&subscription_, &count) != RCL_RET_OK) rcl_reset_error();
    return count;
  }
  [[nodiscard]] std::string topic() const { return rcl_subscription_get_topic_name(&subscription_); }

  void count(Count& count) const noexcept override { ++count.subscriptions; }
  rcl_ret_t watch(rcl_wait_set_t& set) noexcept override {
    return rcl_wait_set_add_subscription(&set, &subscription_, &place_);
  }
  void work(const rcl_wait_set_t& set) override {
    if (set.subscriptions[place_]) take();
  }
  bool set_receiver(Receiver* receiver) noexcept override {
    return set_receiver_by(receiver, [this](auto call, const void* self) {
      return rcl_subscription_set_on_new_message_callback(&subscription_, call, self);
    });
  }
  void take() override {
    for (;;) {
      rmw_message_info_t received = rmw_get_zero_initialized_message_info();
      const rcl_ret_t answer = rcl_take(&subscription_, &message_, &received, nullptr);
      if (answer == RCL_RET_SUBSCRIPTION_TAKE_FAILED) return rcl_reset_error();  // no further messages
      if (const Status taken = status(answer, "read " + topic_); !taken) return node_.problem(taken.problem);
      Info info{.source_ns = received.source_timestamp, .received_ns = received.received_timestamp};
      info.sequence = received.publication_sequence_number;
      std::copy_n(received.publisher_gid.data, info.publisher.size(), info.publisher.begin());
      callback_(message_, info);
    }
  }

 private:
  Node& node_;
  std::string topic_;
  Callback callback_;
  rcl_subscription_t subscription_;
  std::optional<QosEvent> event_;
  Msg message_{};
  std::size_t place_ = 0;
};

}  // namespace palpate::ros
