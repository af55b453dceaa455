#include "sim/events.hpp"

#include <crtk_msgs/msg/operating_state.hpp>
#include <rcl_interfaces/msg/log.hpp>
#include <sensor_msgs/msg/joy.hpp>
#include <std_msgs/msg/bool.hpp>
#include <std_msgs/msg/empty.hpp>
#include <std_msgs/msg/float64.hpp>
#include <std_msgs/msg/string.hpp>

#include "convert.hpp"
#include "rcl/publisher.hpp"
#include "sim/commands.hpp"

namespace palpate::ros {

struct Events::TopicPublisher {
  TopicPublisher() = default;
  virtual ~TopicPublisher() = default;
  TopicPublisher(const TopicPublisher&) = delete;
  TopicPublisher& operator=(const TopicPublisher&) = delete;
  virtual Status publish(const dvrk::Event& event, std::int64_t time_ns) = 0;
};

namespace {

using dvrk::Event;
using dvrk::Payload;

/// Valid UTF-8 for every client: each invalid byte, such as one of a truncated character, becomes a question mark.
std::string letters(std::string_view bytes) {
  std::string text(bytes);
  for (std::size_t i = 0; i < text.size();) {
    const auto first = static_cast<unsigned char>(text[i]);
    const std::size_t n = first < 0x80   ? 1
                          : first < 0xC2 ? 0
                          : first < 0xE0 ? 2
                          : first < 0xF0 ? 3
                          : first < 0xF5 ? 4
                                         : 0;
    bool whole = n > 0 && i + n <= text.size();
    for (std::size_t k = 1; whole && k < n; ++k) whole = (static_cast<unsigned char>(text[i + k]) & 0xC0) == 0x80;
    if (!whole) text[i] = '?';
    i += whole ? n : 1;
  }
  return text;
}

// ---- Functions that copy an event into each message type.

void write(const Event&, std::int64_t, std_msgs::msg::Empty&) {}
void write(const Event& e, std::int64_t, std_msgs::msg::Bool& m) { m.data = e.flag; }
void write(const Event& e, std::int64_t, std_msgs::msg::Float64& m) { m.data = e.value; }
void write(const Event& e, std::int64_t, std_msgs::msg::String& m) { m.data = letters(e.text.view()); }
void write(const Event& e, std::int64_t time_ns, sensor_msgs::msg::Joy& m) {
  m.header.stamp = stamp(time_ns);
  m.buttons.assign(1, e.button);
}
void write(const Event& e, std::int64_t time_ns, crtk_msgs::msg::OperatingState& m) {
  m.header.stamp = stamp(time_ns);
  m.state = dvrk::name_of(e.operating_state.state);
  m.is_homed = e.operating_state.is_homed;
  m.is_busy = e.operating_state.is_busy;
}

template <class Msg>
struct EventPublisher final : Events::TopicPublisher {
  EventPublisher(Node& node, const std::string& topic, bool latched)
      : publisher(node, topic, latched ? kLatched : Qos{}) {}
  Status publish(const Event& event, std::int64_t time_ns) override {
    write(event, time_ns, message);
    return publisher.publish(message);
  }
  Publisher<Msg> publisher;
  Msg message;
};

std::unique_ptr<Events::TopicPublisher> make_publisher(Node& node, const std::string& topic,
                                                       const dvrk::TopicEntry& entry) {
  switch (entry.payload) {
    case Payload::none:
      return std::make_unique<EventPublisher<std_msgs::msg::Empty>>(node, topic, entry.latched);
    case Payload::flag:
      return std::make_unique<EventPublisher<std_msgs::msg::Bool>>(node, topic, entry.latched);
    case Payload::value:
      return std::make_unique<EventPublisher<std_msgs::msg::Float64>>(node, topic, entry.latched);
    case Payload::text:
      return std::make_unique<EventPublisher<std_msgs::msg::String>>(node, topic, entry.latched);
    case Payload::button:
      return std::make_unique<EventPublisher<sensor_msgs::msg::Joy>>(node, topic, entry.latched);
    case Payload::operating:
      return std::make_unique<EventPublisher<crtk_msgs::msg::OperatingState>>(node, topic, entry.latched);
    default:
      throw Error("no message carries the event " + topic);
  }
}

}  // namespace

/// The log of the ROS network, with the quality of service that rclcpp gives it.
struct Events::Log {
  explicit Log(Node& node) : publisher(node, "/rosout", Qos{.depth = 1000, .transient_local = true}) {
    message.name = "dvrk";
  }
  Publisher<rcl_interfaces::msg::Log> publisher;
  rcl_interfaces::msg::Log message;
};

Events::Events(Node& node, const dvrk::System& robot) : node_(node), log_(std::make_unique<Log>(node)) {
  for (const dvrk::TopicEntry& entry : dvrk::topics()) {
    for (const dvrk::Address& at : robot.components(entry.kind, entry.arms)) {
      const std::string topic = robot.component_name(at) + "/" + std::string(entry.name);
      publishers_[{at.kind, at.index, entry.topic}] = make_publisher(node, topic, entry);
    }
  }
}

Events::~Events() = default;

bool Events::publish(const dvrk::Event& event, std::int64_t time_ns) {
  const auto found = publishers_.find({event.from.kind, event.from.index, event.topic});
  if (found == publishers_.end()) return true;
  const Status published = found->second->publish(event, time_ns);
  if (!published) node_.problem(published.problem);
  if (published) log(event, time_ns);
  return static_cast<bool>(published);
}

// As on the real robot, where status, warning and error are also entries of the log.
void Events::log(const dvrk::Event& event, std::int64_t time_ns) {
  using Log = rcl_interfaces::msg::Log;
  auto& m = log_->message;
  switch (event.topic) {
    case dvrk::Topic::status:
      m.level = Log::INFO;
      break;
    case dvrk::Topic::warning:
      m.level = Log::WARN;
      break;
    case dvrk::Topic::error:
      m.level = Log::ERROR;
      break;
    default:
      return;
  }
  m.stamp = stamp(time_ns);
  m.msg = letters(event.text.view());
  if (const Status sent = log_->publisher.publish(m); !sent) node_.problem(sent.problem);
}

}  // namespace palpate::ros
