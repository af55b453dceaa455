// The jitter buffer: the operator's motion, played at a steady delay.
#pragma once

#include <array>
#include <cstddef>

#include "palpate/network/packet.hpp"

namespace palpate::network {

/// The operator's motion at one moment.
struct Played {
  Pose X;                 ///< pose of the tool in W
  Vec3 v = Vec3::Zero();  ///< velocity [m/s]
  double jaw = 0.0;       ///< [rad]
  unsigned flags = 0;     ///< bits of Flag
  bool late = false;      ///< true: no packet is new enough; the newest pose is held
  double stamp = 0.0;     ///< time on the operator's clock [s]
};

/// Keeps the last packets in the order of their sending, and interpolates between neighbours by a cubic with their
/// velocities. The delay follows its goal slowly, so that the motion is stretched by at most kStretch.
class Playout {
 public:
  /// Takes a packet; those older than the buffer are dropped.
  void add(const Datagram& d) noexcept;
  /// The motion at the operator's time `now` - delay; wanted: goal of the delay [s]; dt: time since the last tick [s].
  Played step(double now, double wanted, double dt) noexcept;
  [[nodiscard]] double delay() const noexcept { return delay_; }
  [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
  /// The newest packet.
  [[nodiscard]] const Datagram& newest() const noexcept { return at(0); }

 private:
  static constexpr std::size_t kSize = 2048;
  static constexpr double kStretch = 0.1;  ///< [-]
  static constexpr double kShrink = 0.01;  ///< [-] rate at which the delay falls
  static constexpr double kJump = 1.0;     ///< [s] larger differences of the delay are taken at once
  /// The packet i places before the newest one.
  [[nodiscard]] const Datagram& at(std::size_t i) const noexcept { return ring_[(head_ + kSize - i) % kSize]; }
  [[nodiscard]] Datagram& at(std::size_t i) noexcept { return ring_[(head_ + kSize - i) % kSize]; }

  std::array<Datagram, kSize> ring_{};
  std::size_t head_ = 0, size_ = 0;
  double delay_ = -1.0;  ///< negative: not yet known
};

}  // namespace palpate::network
