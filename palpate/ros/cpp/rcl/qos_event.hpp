// Reports an incompatible quality of service between this end of a topic and another one. No message would arrive, and
// ROS reports no error by itself.
#pragma once

#include <rcl/event.h>

#include <string>

#include "rcl/node.hpp"
#include "rcl/status.hpp"

namespace palpate::ros {

[[nodiscard]] inline const char* policy_name(rmw_qos_policy_kind_t policy) noexcept {
  switch (policy) {
    case RMW_QOS_POLICY_RELIABILITY:
      return "reliability";
    case RMW_QOS_POLICY_DURABILITY:
      return "durability";
    case RMW_QOS_POLICY_DEADLINE:
      return "deadline";
    case RMW_QOS_POLICY_LIVELINESS:
      return "liveliness";
    default:
      return "history or another policy";
  }
}

class QosEvent final : public Entity {
 public:
  /// `init` makes the event of a publisher or a subscription. Without support in the middleware nothing is reported.
  template <class Init>
  QosEvent(Node& node, std::string topic, Init init)
      : node_(node),
        topic_(std::move(topic)),
        event_(rcl_get_zero_initialized_event()),
        known_(init(&event_) == RCL_RET_OK) {
    if (known_)
      node_.add(*this);
    else
      rcl_reset_error();
  }
  ~QosEvent() override {
    if (!known_) return;
    node_.remove(*this);
    set_receiver(nullptr);
    if (rcl_event_fini(&event_) != RCL_RET_OK) rcl_reset_error();
  }

  void count(Count& count) const noexcept override { ++count.events; }
  rcl_ret_t watch(rcl_wait_set_t& set) noexcept override { return rcl_wait_set_add_event(&set, &event_, &place_); }
  void work(const rcl_wait_set_t& set) override {
    if (set.events[place_]) take();
  }
  // If a subscription has an arrival callback, its event needs one, too. Fast DDS uses one wait condition for both, and
  // messages that are not taken in the wait set would keep the condition true.
  bool set_receiver(Receiver* receiver) noexcept override {
    return set_receiver_by(receiver,
                           [this](auto call, const void* self) { return rcl_event_set_callback(&event_, call, self); });
  }
  void take() override {
    rmw_qos_incompatible_event_status_t status{0, 0, RMW_QOS_POLICY_INVALID};
    if (rcl_take_event(&event_, &status) != RCL_RET_OK) return rcl_reset_error();
    node_.problem(topic_ + ": the other end's " + policy_name(status.last_policy_kind) +
                  " does not fit ours, so nothing arrives. Mend: the same quality of service on both sides");
  }

 private:
  Node& node_;
  std::string topic_;
  rcl_event_t event_;
  bool known_;
  std::size_t place_ = 0;
};

}  // namespace palpate::ros
