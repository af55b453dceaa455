// From the robot's events to topics: the core's table says which and what, this says how.
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
  /// `time_ns`: when it happened [ns since 1970]. Answers whether it was told.
  bool publish(const dvrk::Event& event, std::int64_t time_ns);

  struct Teller;  ///< of one topic

 private:
  using Key = std::tuple<dvrk::Kind, int, dvrk::Topic>;
  Node& node_;
  std::map<Key, std::unique_ptr<Teller>> tellers_;
};

}  // namespace palpate::ros
