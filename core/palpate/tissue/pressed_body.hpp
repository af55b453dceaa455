// A soft body under contacts, as it steps: in the haptic cycle, or beside it on a thread of its own.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "palpate/tissue/body.hpp"
#include "palpate/tissue/local_law.hpp"
#include "palpate/tissue/soft_tables.hpp"

namespace palpate::tissue {

inline constexpr int kMaxTouches = 64;  ///< contacts of a surface; further ones do not press the body

/// A contact on a body: a spring to the tool that follows the surface.
struct Touch {
  scene::SurfacePoint at;
  LocalLaw law{1.0, 1.0, 0.0};
  int sphere = 0;
  double depth = 0.0;     ///< of the sphere below the touched surface [m]
  double approach = 0.0;  ///< rate at which the sphere moves against the normal [m/s]
  double viscous = 0.0;   ///< force of the Prony springs that remains when the elastic force vanishes [N]
  double secant = 0.0;    ///< stiffness along the surface [N/m]
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
};

/// What a body gave way to a contact.
struct Yield {
  int sphere = -1;
  double length = 0.0;  ///< depth of the sphere in the undeformed solid, less that below the touched surface [m]
  double energy = 0.0;  ///< energy of the local law that the body stores instead [J]
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
  [[nodiscard]] double depth_of(const Touch& touch, const Vec3& moved, double since) const noexcept;
  void guard(double dt) noexcept;
  void describe(const Press& press, Shape& out) const noexcept;
  void describe_surface(Shape& out) const noexcept;

  Body body_;
  std::shared_ptr<const SoftTables> tables_;
  double instantaneous_ = 1.0;  ///< 1 + sum of the Prony shares
  std::array<Vec3, kMaxTouches> start_;
  std::vector<double> safe_u_, zero_;  ///< displacements before the tick; zeros
  double safe_volume_ = 1.0;           ///< least det F before the last step of that tick [-]
  bool hurried_ = false;
  double still_ = 0.0, healthy_ = HUGE_VAL;  ///< time left of standing still; time since it ended [s]
};

}  // namespace palpate::tissue
