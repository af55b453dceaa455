#include "sim/commands.hpp"

#include <crtk_msgs/msg/cartesian_impedance.hpp>
#include <crtk_msgs/msg/cartesian_state.hpp>
#include <crtk_msgs/msg/string_stamped.hpp>
#include <geometry_msgs/msg/pose_stamped.hpp>
#include <geometry_msgs/msg/wrench_stamped.hpp>
#include <sensor_msgs/msg/joint_state.hpp>
#include <sensor_msgs/msg/joy.hpp>
#include <std_msgs/msg/bool.hpp>
#include <std_msgs/msg/empty.hpp>
#include <std_msgs/msg/float64.hpp>
#include <std_msgs/msg/float64_multi_array.hpp>
#include <std_msgs/msg/string.hpp>

#include "convert.hpp"

namespace palpate::ros {
namespace {

using dvrk::Command;
using dvrk::Payload;

// A latched command that is older belongs to another session and is ignored, so that a robot that starts again
// does not move by itself [s]. Clients queue up to ten.
constexpr double kOldest = 5.0;
constexpr std::size_t kKept = 10;

// ---- Functions that copy the payload of each message type into a command.

void read(const std_msgs::msg::Empty&, Command&) {}
void read(const std_msgs::msg::Bool& m, Command& c) { c.flag = m.data; }
void read(const std_msgs::msg::Float64& m, Command& c) { c.value = m.data; }
void read(const std_msgs::msg::Float64MultiArray& m, Command& c) { c.position = dvrk::joints(m.data); }
void read(const std_msgs::msg::String& m, Command& c) { c.text = std::string_view(m.data); }
void read(const crtk_msgs::msg::StringStamped& m, Command& c) { c.text = std::string_view(m.string); }
void read(const sensor_msgs::msg::Joy& m, Command& c) { c.button = m.buttons.empty() ? 0 : m.buttons.front(); }
void read(const geometry_msgs::msg::PoseStamped& m, Command& c) { c.X = pose_of(m.pose); }
void read(const geometry_msgs::msg::Quaternion& m, Command& c) { c.X.R = rotation_of(m); }
void read(const geometry_msgs::msg::WrenchStamped& m, Command& c) { c.F = wrench_of(m.wrench); }
void read(const sensor_msgs::msg::JointState& m, Command& c) {
  c.position = dvrk::joints(m.position);
  c.velocity = dvrk::joints(m.velocity);
  c.effort = dvrk::joints(m.effort);
}
void read(const crtk_msgs::msg::CartesianState& m, Command& c) {
  c.X = pose_of(m.pose);
  c.V = twist_of(m.twist);
  c.F = wrench_of(m.wrench);
  c.pose_is_valid = m.pose_is_valid.data;
  c.twist_is_valid = m.twist_is_valid.data;
  c.wrench_is_valid = m.wrench_is_valid.data;
}
dvrk::HalfPlane half_plane(const crtk_msgs::msg::CartesianImpedanceHalfPlaneGains& m) {
  return {vector_of(m.p), vector_of(m.d), vector_of(m.bias), vector_of(m.deadband)};
}
void read(const crtk_msgs::msg::CartesianImpedance& m, Command& c) {
  c.impedance = {.R_force = rotation_of(m.force_orientation),
                 .p_force = vector_of(m.force_position),
                 .R_torque = rotation_of(m.torque_orientation),
                 .position_positive = half_plane(m.position_positive),
                 .position_negative = half_plane(m.position_negative),
                 .orientation_positive = half_plane(m.orientation_positive),
                 .orientation_negative = half_plane(m.orientation_negative)};
}

template <class Msg>
std::unique_ptr<Entity> reader(Node& node, const std::string& topic, const Command& command,
                               const OnCommand& on_command) {
  const std::string full = "/" + topic;
  return std::make_unique<Subscription<Msg>>(node, topic,
                                             [command, on_command, full](const Msg& message, const Info& info) {
                                               Command filled = command;
                                               read(message, filled);
                                               on_command(filled, full, info.publisher);
                                             });
}

std::unique_ptr<Entity> reader(Node& node, const std::string& topic, const dvrk::VerbEntry& verb,
                               const Command& command, const OnCommand& on_command) {
  switch (verb.payload) {
    case Payload::none:
      return reader<std_msgs::msg::Empty>(node, topic, command, on_command);
    case Payload::flag:
      return reader<std_msgs::msg::Bool>(node, topic, command, on_command);
    case Payload::value:
      return reader<std_msgs::msg::Float64>(node, topic, command, on_command);
    case Payload::button:
      return reader<sensor_msgs::msg::Joy>(node, topic, command, on_command);
    case Payload::numbers:
      return reader<std_msgs::msg::Float64MultiArray>(node, topic, command, on_command);
    case Payload::joints:
      return reader<sensor_msgs::msg::JointState>(node, topic, command, on_command);
    case Payload::pose:
      return reader<geometry_msgs::msg::PoseStamped>(node, topic, command, on_command);
    case Payload::rotation:
      return reader<geometry_msgs::msg::Quaternion>(node, topic, command, on_command);
    case Payload::wrench:
      return reader<geometry_msgs::msg::WrenchStamped>(node, topic, command, on_command);
    case Payload::cartesian:
      return reader<crtk_msgs::msg::CartesianState>(node, topic, command, on_command);
    case Payload::impedance:
      return reader<crtk_msgs::msg::CartesianImpedance>(node, topic, command, on_command);
    case Payload::text:
      return reader<std_msgs::msg::String>(node, topic, command, on_command);
    case Payload::operating:
      break;
  }
  throw Error("no message carries the command " + topic);
}

template <class Msg>
std::unique_ptr<LatchingSearch> latched(Node& node, const std::string& topic, const Command& command,
                                        const OnCommand& on_command) {
  const auto take = [command, on_command, topic](const Msg& message) {
    Command filled = command;
    read(message, filled);
    on_command(filled, topic, Gid{});
  };
  return std::make_unique<LatchedSubscriber<Msg>>(node, topic, take, kOldest, kKept);
}

/// The subscription of a command that CRTK's clients latch; nullptr for other commands.
std::unique_ptr<LatchingSearch> setting_reader(Node& node, const std::string& topic, const dvrk::VerbEntry& verb,
                                               const Command& command, const OnCommand& on_command) {
  if (verb.name == "state_command") return latched<crtk_msgs::msg::StringStamped>(node, topic, command, on_command);
  if (verb.name == "use_gravity_compensation" || verb.name == "body/set_cf_orientation_absolute")
    return latched<std_msgs::msg::Bool>(node, topic, command, on_command);
  if (verb.name == "trajectory_j/set_ratio") return latched<std_msgs::msg::Float64>(node, topic, command, on_command);
  return nullptr;
}

}  // namespace

Subscriptions listen(Node& node, const dvrk::System& robot, const OnCommand& on_command) {
  Subscriptions subscriptions;
  for (const dvrk::VerbEntry& verb : dvrk::verbs()) {
    for (const dvrk::Address& at : robot.components(verb.kind, verb.arms)) {
      Command command;
      command.to = at;
      command.verb = verb.verb;
      const std::string topic = robot.component_name(at) + "/" + std::string(verb.name);
      if (auto setting = setting_reader(node, "/" + topic, verb, command, on_command)) {
        subscriptions.settings.push_back(std::move(setting));
      } else {
        subscriptions.motions.push_back(reader(node, topic, verb, command, on_command));
      }
    }
  }
  return subscriptions;
}

}  // namespace palpate::ros
