// What an arm or a teleop tells at every period, one topic a row.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "dvrk/system.hpp"
#include "rcl/node.hpp"

namespace palpate::ros {

/// The measures of one arm. What is not valid goes out with a zero stamp.
class ArmMeasures {
 public:
  ArmMeasures(Node& node, const std::string& name, dvrk::ArmKind kind, const std::vector<std::string>& joints);
  ~ArmMeasures();
  /// `time_ns`: when it was measured [ns since 1970].
  void publish(const dvrk::ArmState& state, std::int64_t time_ns);

  struct Teller;  ///< of one topic

 private:
  Node& node_;
  std::vector<std::unique_ptr<Teller>> tellers_;
  std::int64_t looked_ns_ = 0;
};

/// The same of a teleop.
class TeleopMeasures {
 public:
  TeleopMeasures(Node& node, const std::string& name);
  ~TeleopMeasures();
  void publish(const dvrk::TeleopState& state, std::int64_t time_ns);

 private:
  struct Teller;
  Node& node_;
  std::unique_ptr<Teller> alignment_;
};

}  // namespace palpate::ros
