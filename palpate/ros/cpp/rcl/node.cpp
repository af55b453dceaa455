#include "rcl/node.hpp"

#include <rcl/graph.h>

#include <algorithm>
#include <cstdio>

#include "rcl/status.hpp"

namespace palpate::ros {
namespace {

using Ask = decltype(&rcl_get_publishers_info_by_topic);

std::vector<Endpoint> endpoints(const rcl_node_t* node, const std::string& topic, Ask ask) {
  rcutils_allocator_t allocator = rcutils_get_default_allocator();
  rcl_topic_endpoint_info_array_t found = rcl_get_zero_initialized_topic_endpoint_info_array();
  check(ask(node, &allocator, topic.c_str(), false, &found), "ask who uses " + topic);
  std::vector<Endpoint> ends;
  for (std::size_t i = 0; i < found.size; ++i) {
    const rmw_topic_endpoint_info_t& info = found.info_array[i];
    const std::string space = info.node_namespace;
    Endpoint end{.node = (space == "/" ? "" : space) + "/" + info.node_name,
                 .type = info.topic_type,
                 .reliable = info.qos_profile.reliability == RMW_QOS_POLICY_RELIABILITY_RELIABLE,
                 .transient_local = info.qos_profile.durability == RMW_QOS_POLICY_DURABILITY_TRANSIENT_LOCAL};
    std::copy_n(info.endpoint_gid, end.gid.size(), end.gid.begin());
    ends.push_back(std::move(end));
  }
  if (rcl_topic_endpoint_info_array_fini(&found, &allocator) != RCL_RET_OK) rcl_reset_error();
  return ends;
}

}  // namespace

Node::Node(std::shared_ptr<Context> context, const std::string& name, const std::string& space, OnProblem on_problem)
    : context_(std::move(context)),
      node_(rcl_get_zero_initialized_node()),
      woken_(rcl_get_zero_initialized_guard_condition()),
      on_problem_(std::move(on_problem)) {
  rcl_node_options_t options = rcl_node_get_default_options();
  options.enable_rosout = false;
  check(rcl_node_init(&node_, name.c_str(), space.c_str(), context_->get(), &options), "start the node " + name);
  const Status woken =
      status(rcl_guard_condition_init(&woken_, context_->get(), rcl_guard_condition_get_default_options()),
             "start the node " + name);
  if (woken) return;
  if (rcl_node_fini(&node_) != RCL_RET_OK) rcl_reset_error();
  throw Error(woken.problem);
}

Node::~Node() {
  if (rcl_guard_condition_fini(&woken_) != RCL_RET_OK) rcl_reset_error();
  if (rcl_node_fini(&node_) != RCL_RET_OK) rcl_reset_error();
}

std::vector<Endpoint> Node::publishers(const std::string& topic) const {
  return endpoints(&node_, topic, &rcl_get_publishers_info_by_topic);
}

std::vector<Endpoint> Node::subscribers(const std::string& topic) const {
  return endpoints(&node_, topic, &rcl_get_subscriptions_info_by_topic);
}

void Node::problem(const std::string& words) const noexcept {
  try {
    if (on_problem_)
      on_problem_(words);
    else
      std::fprintf(stderr, "warning: %s\n", words.c_str());
  } catch (...) {  // a problem with telling a problem is nobody's to tell
  }
}

/// Holds the entities: waits until the spinner is between two rounds.
std::unique_lock<std::mutex> Node::interrupt() {
  ++visitors_;
  if (rcl_trigger_guard_condition(&woken_) != RCL_RET_OK) rcl_reset_error();
  std::unique_lock<std::mutex> lock(entities_mutex_);
  --visitors_;
  return lock;
}

void Node::add(Entity& entity) {
  const auto lock = interrupt();
  entities_.push_back(&entity);
}

void Node::remove(Entity& entity) noexcept {
  const auto lock = interrupt();
  std::erase(entities_, &entity);
}

}  // namespace palpate::ros
