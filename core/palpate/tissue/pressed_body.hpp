// A soft body under contacts, as it steps: in the haptic cycle, or beside it on a thread of its own.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "palpate/tissue/body.hpp"
#include "palpate/tissue/local_law.hpp"
#include "palpate/tissue/patch.hpp"
#include "palpate/tissue/soft_tables.hpp"

namespace palpate::tissue {

inline constexpr int kMaxTouches = 32;  ///< contacts of a surface; further ones do not press the body

/// A contact on a body: a spring to the tool that follows the surface.
struct Touch {
  Patch patch;
  LocalLaw law{1.0, 1.0, 0.0};
  int sphere = 0;
  Vec3 centre = Vec3::Zero(), velocity = Vec3::Zero();  ///< of the sphere [m], [m/s]
  double viscous = 0.0;  ///< force of the Prony springs that remains when the elastic force vanishes [N]
  double secant = 0.0;   ///< stiffness along the surface [N/m]
  Vec3 normal = Vec3::Zero();
  Vec3 force = Vec3::Zero();  ///< force on the tool along the surface [N]
};

/// Contacts for some time to come.
struct Press {
  std::uint64_t number = 0;  ///< of this press, from 1
  double share = 1.0;        ///< of the forces that act
  int ticks = 1;             ///< for how many ticks
  double dt = 1e-3;          ///< length of a tick [s]
  int touches = 0;
  std::array<Touch, kMaxTouches> touch;

  Press() = default;
  Press(const Press& other) noexcept { *this = other; }
  /// Copies the used entries.
  Press& operator=(const Press& other) noexcept {
    number = other.number;
    share = other.share;
    ticks = other.ticks;
    dt = other.dt;
    touches = other.touches;
    std::copy_n(other.touch.begin(), touches, touch.begin());
    return *this;
  }
};

/// What a body gave way to a contact.
struct Yield {
  int sphere = -1;
  double length = 0.0;        ///< depth of the sphere in the undeformed solid, less that below the touched surface [m]
  double energy = 0.0;        ///< energy of the local law that the body stores instead [J]
  Vec3 moved = Vec3::Zero();  ///< motion of the vertices that held the contact at the beginning of the press [m]
};

/// A body after a press.
struct Shape {
  std::uint64_t number = 0;      ///< of the press
  std::vector<double> vertices;  ///< of the touched surface X + K u, 3 per vertex [m]
  std::vector<double> velocity;  ///< of these vertices [m/s]
  BodyEnergy energy;
  bool hurried = false;  ///< it takes more steps than usual, because it moves fast
  bool still = false;    ///< it diverged and stands still
  int touches = 0;
  std::array<Yield, kMaxTouches> yield;
};

/// A body with its guard against divergence.
class PressedBody {
 public:
  PressedBody(const Body& body, std::shared_ptr<const SoftTables> tables);
  /// Steps the body under a press and describes the result. Nothing allocates, locks or throws.
  void advance(const Press& press, Shape& out) noexcept;
  /// The body at rest.
  [[nodiscard]] Shape at_rest() const;

  [[nodiscard]] const Body& body() const noexcept { return body_; }
  /// Sets displacements and velocities (3n each), for tests of the guard.
  void set_state(std::span<const double> u, std::span<const double> v) noexcept { body_.set_state(u, v); }

 private:
  void step(const Press& press, double since) noexcept;
  void push(const Press& press, double since) noexcept;
  Meeting meet(const Touch& touch, double since) noexcept;
  [[nodiscard]] Vec3 moved(int touch, int vertices) const noexcept;
  void guard(double dt) noexcept;
  void describe(const Press& press, Shape& out) noexcept;
  void describe_surface(Shape& out) const noexcept;

  Body body_;
  std::shared_ptr<const SoftTables> tables_;
  double instantaneous_ = 1.0;                                         ///< 1 + sum of the Prony shares
  std::array<Vec3, kPatchVertices> x_, pull_;                          ///< of the vertices under a contact
  std::array<double, kPatchVertices> share_{};                         ///< of these vertices
  std::array<std::array<float, kPatchVertices>, kMaxTouches> held_{};  ///< shares at the beginning of a press
  std::array<Vec3, kMaxTouches> start_;                                ///< mean place of the vertices at that time [m]
  std::vector<double> safe_u_, zero_;                                  ///< displacements before the tick; zeros
  double safe_volume_ = 1.0;  ///< least det F before the last step of that tick [-]
  bool hurried_ = false;
  double still_ = 0.0, healthy_ = HUGE_VAL;  ///< time left of standing still; time since it ended [s]
};

}  // namespace palpate::tissue
