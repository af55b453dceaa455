// The state that both ends send each other, newest first and never again, and its bytes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "palpate/types/spatial.hpp"

namespace palpate::network {

/// Version of the packet's layout; other versions are refused.
inline constexpr std::uint8_t kVersion = 2;
/// Bytes of a packet before encryption.
inline constexpr std::size_t kPacketSize = 6 * 8 + 27 * 4 + 3 * 4 + 4;

/// Bits of Datagram::flags.
enum Flag : std::uint32_t {
  kEngaged = 1u << 0,     ///< operator: the hand drives the remote tool
  kOutage = 1u << 1,      ///< the sender has missed packets of the receiver for longer than kGrace
  kAligned = 1u << 2,     ///< site: the tool is where the operator's motion wants it
  kHolding = 1u << 3,     ///< site: the tool holds its position
  kLimited = 1u << 4,     ///< site: force or energy limits keep the tool from its goal
  kUnmodelled = 1u << 5,  ///< site: the measured force disagrees with the model by more than its margin
};

/// Distance from its last touch beyond which a plane is not believed [m].
inline constexpr double kPlaneReach = 0.03;

/// What the site has learnt about one object.
struct ModelEstimate {
  /// Index of the object in the scene; their number: the plane of a surface that the scene does not have; 0xffff: none.
  std::uint16_t object = 0xffff;
  Vec3 shift = Vec3::Zero();   ///< displacement from its place in the scene; of a plane: a point on it, in W [m]
  Vec3 normal = Vec3::Zero();  ///< outward unit normal of a plane, in W; zero: an object of the scene
  double K = 0.0, B = 0.0;     ///< stiffness [N/m], damping [N s/m] along the normal
  double mu = 0.0;             ///< friction coefficient [-]
  double sd_K = 0.0;           ///< standard deviation of K [N/m]
  double sd_shift = 0.0;       ///< standard deviation of the shift along the touched normal [m]
  double margin = 0.0;         ///< rms of the measured force minus that of this estimate [N]
};

/// The state of one end at one moment, in W.
struct Datagram {
  double t = 0.0;           ///< clock of the sender [s]
  double t_peer = 0.0;      ///< clock of the receiver in its newest packet that the sender has [s]
  double t_received = 0.0;  ///< clock of the sender when that packet arrived [s]
  Pose X;                   ///< pose of the tool: the goal (operator) or the measured one (site)
  Vec3 v = Vec3::Zero();    ///< its velocity [m/s]
  double jaw = 0.0;         ///< [rad]
  Vec3 F = Vec3::Zero();    ///< force: rendered on the hand (operator), of the environment on the tool (site) [N]
  double energy_in = 0.0;   ///< energy that the sender's port has taken from hand or environment, without returns [J]
  double energy_out = 0.0;  ///< energy that it has given to them [J]
  double play_delay = 0.0;  ///< site: delay at which the operator's motion is played, on the operator's clock [s]
  std::uint32_t flags = 0;  ///< bits of Flag
  ModelEstimate model;      ///< site
};

using Bytes = std::array<std::uint8_t, kPacketSize>;

/// The bytes of a datagram, little-endian; docs/network-packets.md has the layout.
[[nodiscard]] Bytes encode(const Datagram& datagram) noexcept;
/// Reads a datagram; false for another length or version, a number that is not finite or impossibly large, or a
/// quaternion that is no rotation. `out` is then unchanged.
[[nodiscard]] bool decode(std::span<const std::uint8_t> bytes, Datagram& out) noexcept;

/// Refuses numbers that were seen before or are older than the window (RFC 6479 describes such a window).
class ReplayWindow {
 public:
  /// True if the number is new; it then counts as seen. Only to be called for authenticated packets.
  bool accept(std::uint64_t number) noexcept {
    if (number > newest_) {
      const std::uint64_t by = number - newest_;
      if (by >= kWindow) {
        seen_.fill(0);
      } else {
        for (std::uint64_t i = 1; i <= by; ++i) clear(newest_ + i);
      }
      newest_ = number;
    } else if (number == 0 || newest_ - number >= kWindow || get(number)) {
      return false;
    }
    seen_[(number / 64) % seen_.size()] |= 1ull << (number % 64);
    return true;
  }

 private:
  static constexpr std::uint64_t kWindow = 4096;  ///< packets: 4 s at 1 kHz
  [[nodiscard]] bool get(std::uint64_t n) const noexcept {
    return ((seen_[(n / 64) % seen_.size()] >> (n % 64)) & 1u) != 0;
  }
  void clear(std::uint64_t n) noexcept { seen_[(n / 64) % seen_.size()] &= ~(1ull << (n % 64)); }
  std::array<std::uint64_t, kWindow / 64> seen_{};
  std::uint64_t newest_ = 0;
};

}  // namespace palpate::network
