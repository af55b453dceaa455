// Contact of two instruments: each is a set of capsules, and touching capsules push each other apart by a spring and a
// damper along the line between their nearest points.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "palpate/types/spatial.hpp"

namespace palpate::contact {

/// Maximum number of capsules of one instrument.
inline constexpr int kMaxCapsules = 8;

/// Maximum number of pairs of capsules of two instruments.
inline constexpr std::size_t kMaxCapsulePairs = std::size_t{kMaxCapsules} * kMaxCapsules;

/// A cylinder with round ends, in W.
struct Capsule {
  Vec3 a = Vec3::Zero(), b = Vec3::Zero();      ///< ends of its axis [m]
  Vec3 v_a = Vec3::Zero(), v_b = Vec3::Zero();  ///< velocities of the ends [m/s]
  double radius = 0.0;                          ///< [m]
};

/// An instrument as the other pairs see it.
struct Instrument {
  std::array<Capsule, kMaxCapsules> capsule;
  int size = 0;                ///< number of capsules; 0: the instrument is not known yet
  Vec3 p_WH = Vec3::Zero();    ///< position of the leader's handle that moves it [m]
  std::uint64_t sequence = 0;  ///< number of the publication
};

/// Nearest points of two line segments.
struct NearestPoints {
  double s = 0.0, t = 0.0;  ///< position along each segment, 0 at its first end, 1 at its second
  Vec3 p = Vec3::Zero();    ///< point on the first segment [m]
  Vec3 q = Vec3::Zero();    ///< point on the second segment [m]
};

/// Nearest points of the segments p0-p1 and q0-q1; either may be a single point. Ericson, Real-Time Collision
/// Detection, 2005, section 5.1.9.
[[nodiscard]] NearestPoints nearest_points(const Vec3& p0, const Vec3& p1, const Vec3& q0, const Vec3& q1) noexcept;

/// Spring and damper between two instruments.
struct InstrumentLaw {
  double stiffness = 500.0;  ///< [N/m]
  double damping = 1.0;      ///< [N s/m]
};

/// Force that one instrument applies to another, and the place where it acts.
struct Push {
  Vec3 F_A_W = Vec3::Zero();                        ///< force on the first instrument; the second receives -F_A_W [N]
  Vec3 p_WC = Vec3::Zero();                         ///< point where both forces act [m]
  double gap = 0.0;                                 ///< distance between the surfaces, negative while they overlap [m]
  Vec3 v_A_W = Vec3::Zero(), v_B_W = Vec3::Zero();  ///< velocities of both at the nearest points [m/s]
};

/// Contact of two capsules: F_A = (K depth - B v_rel . n)+ n, where n points from the second to the first capsule,
/// depth = -gap and v_rel is the velocity of the first relative to the second at the nearest points. The force pushes
/// and never pulls. The normal of the previous tick tells on which side the capsules met, so that thin instruments do
/// not snap through each other when their axes cross.
class CapsulePair {
 public:
  [[nodiscard]] Push step(const Capsule& A, const Capsule& B, const InstrumentLaw& law) noexcept;

 private:
  Vec3 normal_ = Vec3::Zero();  ///< of the previous tick while the capsules overlap; zero otherwise
};

/// Contact of two instruments: one CapsulePair for every pair of capsules.
class InstrumentPair {
 public:
  /// Forces of all touching capsules, and the smallest gap. `pushes` receives the touching ones; returns their number.
  int step(const Instrument& A, const Instrument& B, const InstrumentLaw& law,
           std::array<Push, kMaxCapsulePairs>& pushes, double& gap) noexcept;

 private:
  std::array<CapsulePair, kMaxCapsulePairs> pair_;
};

}  // namespace palpate::contact
