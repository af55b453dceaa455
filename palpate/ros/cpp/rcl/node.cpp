#include "rcl/node.hpp"

#include <rcl/graph.h>
#include <sched.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include "rcl/status.hpp"

namespace palpate::ros {
namespace {

constexpr std::size_t kProblems = 1000;  // number of different messages kept for repetition counts

using Query = decltype(&rcl_get_publishers_info_by_topic);

std::vector<Endpoint> endpoints(const rcl_node_t* node, const std::string& topic, Query query) {
  rcutils_allocator_t allocator = rcutils_get_default_allocator();
  rcl_topic_endpoint_info_array_t found = rcl_get_zero_initialized_topic_endpoint_info_array();
  check(query(node, &allocator, topic.c_str(), false, &found), "list the endpoints of " + topic);
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

/// Gives SCHED_FIFO to the middleware's threads that deliver messages and hold publishers' locks, where the system
/// allows it. At normal priority a busy machine delays a real-time loop behind them by tens of milliseconds (measured).
/// Only these threads are raised, by their names in Fast DDS since 2.12: its asynchronous senders wait for other
/// threads without sleeping and would starve them at this priority. Returns the number of threads found.
int raise_named(int priority) {
  const sched_param wanted{.sched_priority = priority};
  int found = 0;
  std::error_code none;
  for (std::filesystem::directory_iterator task("/proc/self/task", none), end; task != end; task.increment(none)) {
    std::string name;
    std::getline(std::ifstream(task->path() / "comm") >> std::ws, name);
    for (const char* receiver : {"dds.shm.", "dds.udp.", "dds.tcp", "dds.ev."}) {
      if (!name.starts_with(receiver)) continue;
      ++found;
      const auto thread = static_cast<pid_t>(std::strtol(task->path().filename().c_str(), nullptr, 10));
      sched_setscheduler(thread, SCHED_FIFO, &wanted);  // if refused, the thread keeps its priority
    }
  }
  return found;
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
  raise_receivers();
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

// A thread gets its name only once it runs, so the search repeats until the number of threads stays the same.
void Node::raise_receivers() const {
  if (context_->priority() <= 0) return;
  constexpr auto kPause = std::chrono::milliseconds(5);
  for (int before = -1, found = 0, looks = 0; found != before && looks < 20; ++looks) {
    before = found;
    std::this_thread::sleep_for(kPause);
    found = raise_named(context_->priority());
  }
}

std::vector<Endpoint> Node::subscribers(const std::string& topic) const {
  return endpoints(&node_, topic, &rcl_get_subscriptions_info_by_topic);
}

// Repetitions within a second are counted; the count is reported with the next message.
void Node::problem(const std::string& words) const noexcept {
  try {
    std::string message = words;
    {
      const std::lock_guard<std::mutex> lock(problems_mutex_);
      const auto now = std::chrono::steady_clock::now();
      Told& before = problems_[words];
      if (before.times > 0 && now - before.at < std::chrono::seconds(1)) {
        ++before.times;
        return;
      }
      if (before.times > 1) message += " (" + std::to_string(before.times) + " times)";
      before = {now, 1};
      if (problems_.size() > kProblems) problems_.clear();
    }
    if (on_problem_)
      on_problem_(message);
    else
      std::fprintf(stderr, "warning: %s\n", message.c_str());
  } catch (...) {  // a failure to report a problem cannot be reported
  }
}

/// Locks the list of entities: wakes the spinner and waits until it is between two rounds.
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
