// Counts the messages of any topics and measures their ages, without decoding them.
#pragma once

#include <rosidl_runtime_c/message_type_support_struct.h>

#include <memory>
#include <string>
#include <vector>

#include "rcl/context.hpp"
#include "rcl/node.hpp"
#include "rcl/spinner.hpp"

namespace palpate::ros {

class TopicMeter {
 public:
  struct Topic {
    std::string name;
    const rosidl_message_type_support_t* type = nullptr;
    bool stamped = false;  ///< the message begins with a std_msgs/Header
    bool latched = false;  ///< late subscribers receive the last message
  };
  struct Heard {
    std::vector<double> arrivals;  ///< monotonic time of each message [s]
    std::vector<double> ages;      ///< arrival after the header's stamp, of messages with a stamp [s]
  };

  TopicMeter(std::shared_ptr<Context> context, const std::string& name);
  ~TopicMeter();

  /// Listen to these topics from now on, and no longer to others.
  void listen(const std::vector<Topic>& topics);
  /// What was heard of each topic since; ends listening.
  std::vector<Heard> take();

 private:
  class Ear;
  Node node_;
  std::vector<std::unique_ptr<Ear>> ears_;
  Spinner spinner_;  // declared last, so that it stops first
};

}  // namespace palpate::ros
