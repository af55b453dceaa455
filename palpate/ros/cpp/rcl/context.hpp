// A connection of this process to ROS 2.
#pragma once

#include <rcl/context.h>

#include <string>
#include <vector>

namespace palpate::ros {

struct ContextOptions {
  bool network = false;  ///< communicate with other machines; otherwise only within this one
  int domain = -1;       ///< ROS_DOMAIN_ID; -1: the value in the environment
  int priority = 79;     ///< SCHED_FIFO priority of the middleware's receiving threads, where allowed; 0: none
  std::vector<std::string> arguments;  ///< arguments after `--ros-args`: remaps, enclave
};

/// Nodes share its ownership, so it outlives them. Safe to use from several threads.
class Context {
 public:
  explicit Context(const ContextOptions& options = {});
  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  [[nodiscard]] rcl_context_t* get() noexcept { return &context_; }
  [[nodiscard]] bool network() const noexcept { return network_; }
  [[nodiscard]] std::size_t domain();
  [[nodiscard]] int priority() const noexcept { return priority_; }

 private:
  rcl_context_t context_;
  bool network_;
  int priority_;
};

}  // namespace palpate::ros
