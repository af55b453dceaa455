// Publishes the events of the simulated robot. The core's table lists the topics and payloads.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "dvrk/system.hpp"
#include "rcl/node.hpp"

namespace palpate::ros {

class Events {
 public:
  Events(Node& node, const dvrk::System& robot);
  ~Events();
  /// Publishes an event that happened at `time_ns` [ns since 1970]. Returns false if publishing fails, which is also
  /// reported to the node.
  bool publish(const dvrk::Event& event, std::int64_t time_ns);

  struct TopicPublisher;  ///< publisher of one topic

 private:
  struct Log;
  void log(const dvrk::Event& event, std::int64_t time_ns);

  using Key = std::tuple<dvrk::Kind, int, dvrk::Topic>;
  Node& node_;
  std::unique_ptr<Log> log_;
  std::map<Key, std::unique_ptr<TopicPublisher>> publishers_;
};

}  // namespace palpate::ros
