// Publishes the periodic topics of an arm or a teleoperation component.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "dvrk/system.hpp"
#include "rcl/node.hpp"

namespace palpate::ros {

/// Publishers of the measured states of one arm. Invalid values are published with a zero stamp.
class ArmMeasures {
 public:
  ArmMeasures(Node& node, const std::string& name, dvrk::ArmKind kind, const std::vector<std::string>& joints);
  ~ArmMeasures();
  /// Publishes the state measured at `time_ns` [ns since 1970], on topics that have subscribers.
  void publish(const dvrk::ArmState& state, std::int64_t time_ns);

  struct TopicPublisher;  ///< publisher of one topic

 private:
  Node& node_;
  std::vector<std::unique_ptr<TopicPublisher>> publishers_;
  std::int64_t looked_ns_ = 0;
};

/// Publishers of the periodic states of one teleoperation component.
class TeleopMeasures {
 public:
  TeleopMeasures(Node& node, const std::string& name);
  ~TeleopMeasures();
  void publish(const dvrk::TeleopState& state, std::int64_t time_ns);

 private:
  struct TopicPublisher;
  Node& node_;
  std::unique_ptr<TopicPublisher> alignment_;
};

}  // namespace palpate::ros
