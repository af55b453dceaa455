// A connection of this process to ROS 2.
#pragma once

#include <rcl/context.h>

#include <string>
#include <vector>

namespace palpate::ros {

struct ContextOptions {
  bool network = false;                ///< talk to other machines; otherwise only within this one
  int domain = -1;                     ///< ROS_DOMAIN_ID; -1: the one of the environment
  int priority = 79;                   ///< SCHED_FIFO of the middleware's receiving threads, where allowed; 0: none
  std::vector<std::string> arguments;  ///< as behind `--ros-args`: remaps, enclave
};

/// Lives as long as anything made from it. Other threads may use it.
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
