// A publisher of one message type on one topic.
#pragma once

#include <rcl/publisher.h>

#include <cstdint>
#include <optional>
#include <rosidl_typesupport_cpp/message_type_support.hpp>
#include <string>

#include "rcl/node.hpp"
#include "rcl/qos.hpp"
#include "rcl/qos_event.hpp"
#include "rcl/status.hpp"

namespace palpate::ros {

template <class Msg>
class Publisher {
 public:
  Publisher(Node& node, const std::string& topic, Qos qos = {})
      : node_(node), topic_(topic), publisher_(rcl_get_zero_initialized_publisher()) {
    rcl_publisher_options_t options = rcl_publisher_get_default_options();
    options.qos = qos.profile();
    const auto* type = rosidl_typesupport_cpp::get_message_type_support_handle<Msg>();
    check(rcl_publisher_init(&publisher_, node.get(), type, topic.c_str(), &options), "publish " + topic);
    event_.emplace(node, topic, [this](rcl_event_t* event) {
      return rcl_publisher_event_init(event, &publisher_, RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS);
    });
  }
  ~Publisher() {
    event_.reset();
    if (rcl_publisher_fini(&publisher_, node_.get()) != RCL_RET_OK) rcl_reset_error();
  }
  Publisher(const Publisher&) = delete;
  Publisher& operator=(const Publisher&) = delete;

  /// Publishes a message; from any thread, but only one at a time. It may make a system call, so call it after the
  /// computation of a cycle.
  Status publish(const Msg& message) const {
    return status(rcl_publish(&publisher_, &message, nullptr), "publish " + topic_);
  }
  /// Waits at most `ns` [ns] until all reliable subscribers have acknowledged all messages.
  void flush(std::int64_t ns) const noexcept {
    if (rcl_publisher_wait_for_all_acked(&publisher_, ns) != RCL_RET_OK) rcl_reset_error();
  }
  /// Number of matched subscriptions [-]; 0 if the query fails.
  [[nodiscard]] std::size_t listeners() const noexcept {
    std::size_t count = 0;
    if (rcl_publisher_get_subscription_count(&publisher_, &count) != RCL_RET_OK) rcl_reset_error();
    return count;
  }
  [[nodiscard]] std::string topic() const { return rcl_publisher_get_topic_name(&publisher_); }

 private:
  Node& node_;
  std::string topic_;
  rcl_publisher_t publisher_;
  std::optional<QosEvent> event_;
};

}  // namespace palpate::ros
