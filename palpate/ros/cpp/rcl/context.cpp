#include "rcl/context.hpp"

#include <rcl/init.h>
#include <rcl/init_options.h>

#include <cstdlib>
#include <string_view>

#include "rcl/status.hpp"

namespace palpate::ros {
namespace {

/// Sets the discovery range in the environment, where rcl reads it; the variable was renamed after Humble. The default
/// is this machine; `network` widens it to the subnet.
void set_range(bool network) {
  if (network) {
    if (const char* range = std::getenv("ROS_AUTOMATIC_DISCOVERY_RANGE");
        range && std::string_view(range) == "LOCALHOST")
      setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET", 1);
    unsetenv("ROS_LOCALHOST_ONLY");
    return;
  }
#if __has_include(<rmw/discovery_options.h>)
  if (const char* range = std::getenv("ROS_AUTOMATIC_DISCOVERY_RANGE"); !range || std::string_view(range) != "OFF")
    setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST", 1);
  unsetenv("ROS_LOCALHOST_ONLY");  // deprecated in these releases, but it would take precedence
  unsetenv("ROS_STATIC_PEERS");    // addresses of other machines
#else
  setenv("ROS_LOCALHOST_ONLY", "1", 1);
#endif
}

}  // namespace

Context::Context(const ContextOptions& options)
    : context_(rcl_get_zero_initialized_context()), network_(options.network), priority_(options.priority) {
  set_range(network_);
  rcl_init_options_t init = rcl_get_zero_initialized_init_options();
  check(rcl_init_options_init(&init, rcl_get_default_allocator()), "prepare ROS");
  std::vector<const char*> words{"palpate", "--ros-args"};
  for (const std::string& argument : options.arguments) words.push_back(argument.c_str());
  rcl_ret_t answer = RCL_RET_OK;
  if (options.domain >= 0) answer = rcl_init_options_set_domain_id(&init, static_cast<std::size_t>(options.domain));
  if (answer == RCL_RET_OK) answer = rcl_init(static_cast<int>(words.size()), words.data(), &init, &context_);
  const Status started = status(answer, "start ROS (domain, discovery range and arguments come from the environment)");
  if (rcl_init_options_fini(&init) != RCL_RET_OK) rcl_reset_error();
  if (!started) throw Error(started.problem);
}

Context::~Context() {
  if (rcl_shutdown(&context_) != RCL_RET_OK) rcl_reset_error();
  if (rcl_context_fini(&context_) != RCL_RET_OK) rcl_reset_error();
}

std::size_t Context::domain() {
  std::size_t domain = 0;
  check(rcl_context_get_domain_id(&context_, &domain), "read the domain id");
  return domain;
}

}  // namespace palpate::ros
