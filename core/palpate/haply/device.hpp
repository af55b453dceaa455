// A Haply device behind the vendor's Inverse Service, as a driver of the core.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "palpate/haply/messages.hpp"
#include "palpate/haply/websocket.hpp"
#include "palpate/loop/driver.hpp"

namespace palpate::haply {

/// What is known of the device before the first reading.
struct Options {
  std::string device;        ///< id of the Inverse3 or Minverse
  std::string address;       ///< the same id as JSON, a text in its quotes or a number, as the service wrote it
  std::string grip, list;    ///< id of the grip, and its list in the messages; both empty without a grip
  bool vector = true;        ///< the service is 3.5 or later
  double rate = 2000.0;      ///< messages per second [Hz]
  double force_max = 3.0;    ///< the vendor publishes no limit [N]
  double workspace = 0.115;  ///< edge of the largest cube in the device's safe sphere [m]
};

/// The service answers each message with one state, and a force holds until the next message. So write() sends the
/// force, and the next read() takes the answer. While an answer is missing nothing but zero force is sent.
class Device final : public loop::Driver {
 public:
  static constexpr std::int64_t kSilent = 8'000'000;    ///< time of waiting after which the force is zero [ns]
  static constexpr std::int64_t kGone = 1'000'000'000;  ///< time without a valid state that ends the session [ns]
  static constexpr std::int64_t kUnplugged =
      100'000'000;  ///< time without the device in the answers that ends the session [ns]

  /// service: the connection, after its inventory. events: that of the events, or null.
  Device(Options options, std::shared_ptr<WebSocket> service, std::shared_ptr<WebSocket> events);
  ~Device() override;

  loop::Reading read(loop::DeviceState& state) noexcept override;
  bool write(const Wrench& F) noexcept override;
  [[nodiscard]] std::string why() const override;
  [[nodiscard]] std::vector<std::string> notices() const override;

  /// Number of answers so far.
  [[nodiscard]] std::uint64_t exchanges() const noexcept { return exchanges_.load(std::memory_order_relaxed); }
  /// Number of reads that found no answer to the message before, and waited for it.
  [[nodiscard]] std::uint64_t late() const noexcept { return late_.load(std::memory_order_relaxed); }

 private:
  /// What has happened, in the order of the words in device.cpp.
  enum Notice : unsigned {
    silent,
    malformed,
    uncalibrated,
    unready,
    asleep,
    battery_low,
    ebrake,
    stalled,
    other_event,
    invalid,
    grip_lost,
    vanished
  };
  enum Failure : int { none, closed, broken, gone, never };

  void take_events() noexcept;
  loop::Reading take_answer(loop::DeviceState& state) noexcept;
  WebSocket::Got receive_answer(std::int64_t end) noexcept;
  loop::Reading judge(const Measured& found, loop::DeviceState& state) noexcept;
  loop::Reading fail(Failure why) noexcept;
  void note(Notice what) noexcept { noted_.fetch_or(1u << what, std::memory_order_relaxed); }

  Options options_;
  std::shared_ptr<WebSocket> service_, events_;
  Reader reader_;
  ForceMessage command_;
  std::atomic_flag writing_ = ATOMIC_FLAG_INIT;
  std::atomic<int> unanswered_{0};  ///< messages without an answer
  std::atomic<bool> zero_{true};    ///< the last force that was sent is zero
  std::atomic<unsigned> noted_{0};  ///< bits of Notice
  std::atomic<int> failure_{none};
  std::atomic<std::uint64_t> exchanges_{0}, late_{0};
  bool waiting_ = false;                         ///< an answer is late: read() does not wait for it any more
  bool locked_ = false, dropped_ = false;        ///< the emergency brake is on; an event drops the force of this tick
  std::int64_t valid_;                           ///< time of the last valid state [ns]
  std::int64_t vanished_ = 0;                    ///< time since which the device is not in the answers; 0: it is [ns]
  std::array<double, 4> q_{0.0, 0.0, 0.0, 1.0};  ///< last orientation of the grip
};

}  // namespace palpate::haply
