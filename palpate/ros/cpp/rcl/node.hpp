// A ROS 2 node, with its publishers, subscriptions and services.
#pragma once

#include <rcl/guard_condition.h>
#include <rcl/node.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>
#include <vector>

#include "rcl/context.hpp"
#include "rcl/entity.hpp"

namespace palpate::ros {

/// Identifier of a publisher or subscription, unique on the network.
using Gid = std::array<std::uint8_t, RMW_GID_STORAGE_SIZE>;

/// A publisher or subscription of a topic, as the ROS graph reports it.
struct Endpoint {
  std::string node;  ///< full name
  std::string type;  ///< such as geometry_msgs/msg/WrenchStamped
  Gid gid{};
  bool reliable = false, transient_local = false;
};

class Node {
 public:
  using OnProblem = std::function<void(const std::string&)>;

  /// `on_problem` is called from any thread with each error at run time; without it, errors go to the standard error.
  Node(std::shared_ptr<Context> context, const std::string& name, const std::string& space = "",
       OnProblem on_problem = {});
  ~Node();
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  [[nodiscard]] rcl_node_t* get() noexcept { return &node_; }
  [[nodiscard]] Context& context() noexcept { return *context_; }
  [[nodiscard]] std::string name() const { return rcl_node_get_fully_qualified_name(&node_); }
  /// All publishers or subscriptions of a topic (full name) in the network. Allocates, so a cycle must not call it.
  [[nodiscard]] std::vector<Endpoint> publishers(const std::string& topic) const;
  [[nodiscard]] std::vector<Endpoint> subscribers(const std::string& topic) const;
  /// Gives the middleware's receiving threads the priority of the context, where the system allows it. Call it again
  /// after adding publishers and subscriptions, as they may start further threads.
  void raise_receivers() const;
  /// Reports an error from any thread; the same text at most once a second.
  void problem(const std::string& words) const noexcept;

  /// Add or remove an entity while a spinner runs; not allowed within a callback of that spinner.
  void add(Entity& entity);
  void remove(Entity& entity) noexcept;

 private:
  friend class Spinner;
  std::unique_lock<std::mutex> interrupt();

  std::shared_ptr<Context> context_;
  rcl_node_t node_;
  rcl_guard_condition_t woken_;
  OnProblem on_problem_;
  struct Told {
    std::chrono::steady_clock::time_point at;
    int times = 0;
  };
  mutable std::mutex problems_mutex_;
  mutable std::unordered_map<std::string, Told> problems_;
  std::mutex entities_mutex_;
  std::atomic<int> visitors_{0};  // number of threads that wait for entities_; the spinner lets them in first
  std::vector<Entity*> entities_;
};

}  // namespace palpate::ros
