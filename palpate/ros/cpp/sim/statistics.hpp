// Publishes the statistics of the robot's threads under the names of cisst-ros: stats/COMPONENT/period_statistics.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "dvrk/system.hpp"
#include "rcl/node.hpp"
#include "sim/interval_meter.hpp"

namespace palpate::ros {

class Statistics {
 public:
  Statistics(Node& node, const dvrk::System& robot);
  ~Statistics();

  IntervalMeter servo;     ///< the thread that steps the arms and the teleoperations
  IntervalMeter publish;   ///< the thread that publishes states and events
  IntervalMeter commands;  ///< the thread that receives commands

  /// Publishes all of them at 5 Hz. In the publishing thread; `now` on the monotonic clock, `time_ns` since 1970 [ns].
  void send(std::int64_t now, std::int64_t time_ns);

 private:
  struct TopicPublisher;
  void add(const std::string& name, IntervalMeter& meter);

  Node& node_;
  std::vector<std::unique_ptr<TopicPublisher>> publishers_;
  std::int64_t sent_ = 0;
};

}  // namespace palpate::ros
