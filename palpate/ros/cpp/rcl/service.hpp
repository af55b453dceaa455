// Server and client of a service.
#pragma once

#include <rcl/client.h>
#include <rcl/graph.h>
#include <rcl/service.h>

#include <chrono>
#include <functional>
#include <mutex>
#include <rosidl_typesupport_cpp/service_type_support.hpp>
#include <string>
#include <unordered_map>

#include "rcl/node.hpp"
#include "rcl/status.hpp"

namespace palpate::ros {

/// A server, which answers each request in the spinner's thread.
template <class Srv>
class Service final : public Entity {
 public:
  using Callback = std::function<void(const typename Srv::Request&, typename Srv::Response&)>;

  Service(Node& node, const std::string& name, Callback callback)
      : node_(node), name_(name), callback_(std::move(callback)), service_(rcl_get_zero_initialized_service()) {
    const rcl_service_options_t options = rcl_service_get_default_options();
    const auto* type = rosidl_typesupport_cpp::get_service_type_support_handle<Srv>();
    check(rcl_service_init(&service_, node.get(), type, name.c_str(), &options), "offer the service " + name);
    node_.add(*this);
  }
  ~Service() override {
    node_.remove(*this);
    if (rcl_service_fini(&service_, node_.get()) != RCL_RET_OK) rcl_reset_error();
  }

  void count(Count& count) const noexcept override { ++count.services; }
  rcl_ret_t watch(rcl_wait_set_t& set) noexcept override { return rcl_wait_set_add_service(&set, &service_, &place_); }
  void work(const rcl_wait_set_t& set) override {
    if (!set.services[place_]) return;
    for (;;) {
      typename Srv::Request request;
      rmw_service_info_t info{};
      const rcl_ret_t answer = rcl_take_request_with_info(&service_, &info, &request);
      if (answer == RCL_RET_SERVICE_TAKE_FAILED) return rcl_reset_error();
      if (const Status taken = status(answer, "read a request of " + name_); !taken)
        return node_.problem(taken.problem);
      typename Srv::Response response;
      callback_(request, response);
      const Status sent =
          status(rcl_send_response(&service_, &info.request_id, &response), "send the response of " + name_);
      if (!sent) node_.problem(sent.problem);
    }
  }

 private:
  Node& node_;
  std::string name_;
  Callback callback_;
  rcl_service_t service_;
  std::size_t place_ = 0;
};

/// A client. The response arrives by a callback in the spinner's thread; without a response the callback is not called.
template <class Srv>
class Client final : public Entity {
 public:
  using Callback = std::function<void(const typename Srv::Response&)>;

  Client(Node& node, const std::string& name) : node_(node), name_(name), client_(rcl_get_zero_initialized_client()) {
    const rcl_client_options_t options = rcl_client_get_default_options();
    const auto* type = rosidl_typesupport_cpp::get_service_type_support_handle<Srv>();
    check(rcl_client_init(&client_, node.get(), type, name.c_str(), &options), "use the service " + name);
    node_.add(*this);
  }
  ~Client() override {
    node_.remove(*this);
    if (rcl_client_fini(&client_, node_.get()) != RCL_RET_OK) rcl_reset_error();
  }

  /// True if a server offers the service.
  [[nodiscard]] bool available() const noexcept {
    bool available = false;
    if (rcl_service_server_is_available(node_.get(), &client_, &available) != RCL_RET_OK) rcl_reset_error();
    return available;
  }
  Status call(const typename Srv::Request& request, Callback callback) {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::int64_t number = 0;
    Status sent = status(rcl_send_request(&client_, &request, &number), "send a request to " + name_);
    if (sent) waiting_[number] = std::move(callback);
    return sent;
  }

  void count(Count& count) const noexcept override { ++count.clients; }
  rcl_ret_t watch(rcl_wait_set_t& set) noexcept override { return rcl_wait_set_add_client(&set, &client_, &place_); }
  void work(const rcl_wait_set_t& set) override {
    if (!set.clients[place_]) return;
    for (;;) {
      typename Srv::Response response;
      rmw_service_info_t info{};
      const rcl_ret_t answer = rcl_take_response_with_info(&client_, &info, &response);
      if (answer == RCL_RET_CLIENT_TAKE_FAILED) return rcl_reset_error();
      if (const Status taken = status(answer, "read an answer of " + name_); !taken)
        return node_.problem(taken.problem);
      if (const Callback callback = waiting(info.request_id.sequence_number)) callback(response);
    }
  }

 private:
  Callback waiting(std::int64_t number) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto found = waiting_.extract(number);
    return found ? std::move(found.mapped()) : Callback{};
  }

  Node& node_;
  std::string name_;
  rcl_client_t client_;
  std::size_t place_ = 0;
  std::mutex mutex_;
  std::unordered_map<std::int64_t, Callback> waiting_;
};

}  // namespace palpate::ros
