// A fixture: a geometry, a role that says what is wanted of the tool there, a law that says how the hand is told, and a
// policy that says how much of it counts. Roles and laws know no shape; a list of fixtures is immutable, swapped whole.
#pragma once

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "palpate/guidance/geometry.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::guidance {

/// Fixtures of a list, at most.
inline constexpr int kMaxFixtures = 128;

/// What a role is told of the tool. All in W.
struct Tool {
  Pose X_WT;                    ///< where it is, or is to be
  Vec3 p_touch = Vec3::Zero();  ///< where it is, and feels [m]
  Vec3 F_T_W = Vec3::Zero();    ///< what it touches does to it there [N]
  double stiffness = 0.0;       ///< of what it touches, along that force; 0 when it is not known [N/m]
};

/// What a role wants: one number that shall not be below zero, and its slope.
struct Want {
  /// Below zero by how much it is not as wanted [m; rad when it turns]; infinity: nothing is wanted.
  double gap = std::numeric_limits<double>::infinity();
  /// Its whole gradient: d gap = along.f . dp + along.t . turn. Where it turns a moment, of length one, or less where
  /// it is less sure what to turn to; the force beside it is there because what is aimed at goes with the place.
  Wrench along;
  double drift = 0.0;            ///< of the gap while the tool stands still: the fixture moves [m/s, rad/s]
  Vec3 spin = Vec3::Zero();      ///< of the fixture [rad/s]
  Mat3 free = Mat3::Identity();  ///< projector on the directions that are left to the hand
  bool attracts = false;         ///< wants the tool there (guide, orient, rcm), not away from there
  bool turns = false;            ///< of an angle
  double speed = std::numeric_limits<double>::infinity();  ///< most that the tool may have here [m/s]

  /// Takes the drift from the geometry that carries all of it along: d gap = along . (motion of the tool - its own).
  void carried_by(const Query& query, const Vec3& p_WT) noexcept {
    drift = -along.f.dot(query.velocity + query.spin.cross(p_WT - query.point)) - along.t.dot(query.spin);
    spin = query.spin;
  }
  /// How much is wrong [m, rad].
  [[nodiscard]] double wrong() const noexcept { return gap < 0.0 ? -gap : 0.0; }
  /// What a damper works against: how fast the gap grows while the tool moves so; of an angle by its turning alone, for
  /// by the square of the aim's slope a damper of the place would be too hard.
  [[nodiscard]] double rate(const Twist& V_WT) const noexcept {
    return turns ? along.t.dot(V_WT.w - spin) : along.f.dot(V_WT.v) + along.t.dot(V_WT.w) + drift;
  }
};

/// What a role turns a geometry's answer into. Stateless, so that it may be asked about any place.
class Role {
 public:
  virtual ~Role() = default;
  /// around: of it what the role needs.
  [[nodiscard]] virtual Want want(const Query& query, const Around& around, const Tool& tool) const noexcept = 0;
  [[nodiscard]] virtual const char* name() const noexcept = 0;
  /// What it aims at goes with the tool's place: it is told how.
  enum class Needs { nothing, normals, turns };
  [[nodiscard]] virtual Needs needs() const noexcept { return Needs::nothing; }
  /// It needs a geometry that has an inside.
  [[nodiscard]] virtual bool needs_solid() const noexcept { return false; }
  /// It needs a geometry that is one place.
  [[nodiscard]] virtual bool needs_point() const noexcept { return false; }
  /// It needs a geometry that has an axis.
  [[nodiscard]] virtual bool needs_axis() const noexcept { return false; }
  /// It has a gap: a policy can go by it.
  [[nodiscard]] virtual bool has_gap() const noexcept { return true; }
};

/// Of all roles; each reads what concerns it.
struct RoleOptions {
  double margin = 0.0;          ///< guide: free play around; forbid: kept clear outside; keep_in: kept clear inside [m]
  double angle = 0.0;           ///< orient: free tilt [rad]
  Vec3 axis = Vec3::UnitZ();    ///< orient, rcm: of the tool, in T: what points, or slides, along
  std::string target = "axis";  ///< orient: the geometry's `axis`, its `normal` (against it), or its whole `frame`
  double speed = 0.0;           ///< limit: of the tool [m/s]; 0: none
  double force = 0.0;           ///< limit: of what it touches, on the tool [N]; 0: none. Neither: a workspace
};

/// What a law answers. All in W, on the tool.
struct Pull {
  Wrench F;               ///< [N, N m]
  Mat3 B = Mat3::Zero();  ///< damping that F holds by directions: an admittance master may take it as such [N s/m]
  Wrench F_of_B;          ///< the part of F that is - B v
  double U = 0.0;         ///< energy that it stores [J]
};

/// How the hand is told. Stateless.
class Law {
 public:
  virtual ~Law() = default;
  /// V_WT: of the tool as the hand moves it.
  [[nodiscard]] virtual Pull pull(const Want& want, const Twist& V_WT) const noexcept = 0;
  [[nodiscard]] virtual const char* name() const noexcept = 0;
  /// The steepest that its force rises with the deviation, and with the speed: what has to be stable.
  [[nodiscard]] virtual double stiffness() const noexcept = 0;          ///< [N/m]
  [[nodiscard]] virtual double damping() const noexcept = 0;            ///< [N s/m]
  [[nodiscard]] virtual double turning_stiffness() const noexcept = 0;  ///< [N m/rad]
  [[nodiscard]] virtual double turning_damping() const noexcept = 0;    ///< [N m s/rad]
  /// Its deviation is found for all such fixtures together, by the optimisation.
  [[nodiscard]] virtual bool jointly() const noexcept { return false; }
};

/// Of all laws; each reads what concerns it.
struct LawOptions {
  double K = 400.0;         ///< stiffness, on the tool's side: the hand feels scale * force_scale * K [N/m]
  double B = 2.0;           ///< damping against the direction that is wanted [N s/m]
  double K_turn = 0.5;      ///< the same of an angle [N m/rad]
  double B_turn = 0.005;    ///< [N m s/rad]
  double force = 3.0;       ///< most that it pulls: potential, optimise [N]
  double moment = 0.05;     ///< the same of an angle [N m]
  double range = 0.01;      ///< potential: attracts from so far, repels from so far [m]
  double range_turn = 0.5;  ///< the same of an angle [rad]
  double ratio = 0.1;       ///< admittance: of the motion that is not free to the free one, under the same force [0-1]
};

/// Fades with something that is measured: 0 at `from`, 1 at `to`, a straight line between; either may be the larger.
struct Ramp {
  enum class By {
    pedal,     ///< Controls::guidance, 0-1
    distance,  ///< of the tool from what is wanted, |gap| [m, rad]
    time,      ///< since it was engaged [s]
    force,     ///< of the operator: of a load cell, or else what the fixture would pull with [N]
  };
  By by = By::pedal;
  double from = 0.0, to = 1.0;
};

/// How much of a fixture counts.
struct Policy {
  bool hard = false;       ///< the tool's goal is corrected as well: with authority 1 the tool does not go there
  double authority = 1.0;  ///< 0-1, times the ramps
  int priority = 0;        ///< a lower one never pulls against a higher one; hard ones come first
  double engage = std::numeric_limits<double>::infinity();   ///< takes part once |gap| is below [m, rad] ...
  double release = std::numeric_limits<double>::infinity();  ///< ... until it is above
  double rise = 0.2;  ///< shortest time in which its authority goes from 0 to 1 [s] ...
  double fall = 0.2;  ///< ... and back
  std::vector<Ramp> ramps;
};

struct Fixture {
  std::string name;  ///< unique in its list: an edited fixture of the same name goes on where the old one was
  GeometryPtr geometry;
  std::shared_ptr<const Role> role;
  std::shared_ptr<const Law> law;
  Policy policy;
  bool on = true;
  LiveFrames frames;  ///< that the geometry is attached to: never told, the fixture counts for nothing ...
  double patience = std::numeric_limits<double>::infinity();  ///< ... and told longer ago than this, too [s]
};

/// What a fixture wants of a tool at time t [s], whatever its policy.
[[nodiscard]] Want ask(const Fixture& fixture, const Tool& tool, double t) noexcept;

struct Fixtures {
  std::vector<Fixture> fixture;
  std::shared_ptr<LiveFrame> tool;  ///< told at every tick where the tool is, for what is attached to it; may be null
};

/// Names of the roles and laws there are.
std::vector<std::string> roles();
std::vector<std::string> laws();
/// Throws std::invalid_argument naming what cannot be, or the names there are.
[[nodiscard]] std::shared_ptr<const Role> make_role(const std::string& name, const RoleOptions& options);
[[nodiscard]] std::shared_ptr<const Law> make_law(const std::string& name, const LawOptions& options);
/// Throws std::invalid_argument naming the fixture, the value and the mend.
void check(const Fixtures& fixtures);

// The tables' entries; each has a file of its own.
[[nodiscard]] std::shared_ptr<const Role> make_guide(const RoleOptions& options);
[[nodiscard]] std::shared_ptr<const Role> make_forbid(const RoleOptions& options);
[[nodiscard]] std::shared_ptr<const Role> make_keep_in(const RoleOptions& options);
[[nodiscard]] std::shared_ptr<const Role> make_orient(const RoleOptions& options);
[[nodiscard]] std::shared_ptr<const Role> make_limit(const RoleOptions& options);
[[nodiscard]] std::shared_ptr<const Role> make_rcm(const RoleOptions& options);
[[nodiscard]] std::shared_ptr<const Law> make_spring(const LawOptions& options);
[[nodiscard]] std::shared_ptr<const Law> make_potential(const LawOptions& options);
[[nodiscard]] std::shared_ptr<const Law> make_admittance(const LawOptions& options);
[[nodiscard]] std::shared_ptr<const Law> make_optimise(const LawOptions& options);

}  // namespace palpate::guidance
