// The messages of Haply's Inverse Service 3.0 to 3.5, as a client reads and writes them in its cycle.
#pragma once

#include <array>
#include <boost/json/parser.hpp>
#include <boost/json/static_resource.hpp>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace palpate::haply {

/// What one answer of the service says about a device and its grip.
struct Measured {
  std::array<double, 3> p{}, v{};               ///< position and velocity in the device's base [m, m/s]
  bool moving = true;                           ///< the velocity is in the answer
  std::array<double, 4> q{0.0, 0.0, 0.0, 1.0};  ///< orientation of the grip in that base: x, y, z, w
  bool a = false, b = false, c = false;         ///< buttons of the grip; of a Ruko grip down, up, right
  bool calibrated = true, ready = true;         ///< status of the device
  bool oriented = false, awake = true;          ///< the grip is in the answer; it does not sleep
  double battery = 1.0;                         ///< charge of the grip, 0 to 1 [-]
};

/// Result of reading an answer.
enum class Parsed : int {
  good,
  malformed,  ///< no valid JSON, or the numbers of the device are missing
  gone,       ///< the device is not in the answer
};

/// Kinds of events that concern a force.
enum class Event : int { none, sleep, battery, ebrake, ebrake_released, stall, disconnected, invalid, other };

/// Reads messages without an allocation: their values are in buffers of this object.
class Reader {
 public:
  /// device: its id. grip: the id of the grip, or "". list: the list of the messages in which the grip is.
  Reader(std::string device, std::string grip, std::string list);

  /// Reads an answer; `out` is complete if the result is `good`.
  Parsed read(std::string_view text, Measured& out) noexcept;
  /// Reads a message of the channel of events; `none` if it concerns another device.
  Event read_event(std::string_view text) noexcept;

 private:
  boost::json::value parse(std::string_view text) noexcept;

  // A value has 24 bytes, and the shortest text of a value has 2: no message of 64 kB needs more than these.
  static constexpr std::size_t kValues = 4u << 20, kStack = 2u << 20;
  std::string device_, grip_, list_;
  bool calibrated_ = true, ready_ = true;  ///< newest status; before a message has one, that of the checked inventory
  std::unique_ptr<unsigned char[]> values_, stack_;
  boost::json::static_resource memory_;
  boost::json::parser parser_;
};

/// A command of a force, formatted without an allocation.
class ForceMessage {
 public:
  /// id: that of the device as JSON, a text in its quotes or a number, as the service wrote it. vector: true for
  /// service 3.5, which calls the force `vector`; earlier ones call it `values`.
  ForceMessage(const std::string& id, bool vector);
  /// The text of a command with the force [N] in the axes of the base, until the next call.
  std::string_view text(double x, double y, double z) noexcept;

 private:
  std::array<char, 512> text_{};
  std::size_t head_;  ///< length of the part before the numbers
};

}  // namespace palpate::haply
