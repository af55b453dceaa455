// A fixture: a geometry, a role that makes a constraint on the tool from it, a law that makes a force from the
// constraint, and a policy that sets the fixture's authority. Roles and laws know no shape; a list of fixtures is
// immutable and swapped whole.
#pragma once

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "palpate/guidance/constraint.hpp"
#include "palpate/guidance/geometry.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::guidance {

/// Fixtures of a list, at most.
inline constexpr int kMaxFixtures = 128;

/// Makes a constraint from a geometry. Stateless, so that it may be evaluated at any pose.
class Role {
 public:
  virtual ~Role() = default;
  /// around: holds what needs() asks for.
  [[nodiscard]] virtual Constraint constraint(const Query& query, const Around& around,
                                              const ToolQuery& tool) const noexcept = 0;
  [[nodiscard]] virtual const char* name() const noexcept = 0;
  /// How the target direction changes with the tool's place, where the role depends on it.
  enum class Needs { nothing, normals, turns };
  [[nodiscard]] virtual Needs needs() const noexcept { return Needs::nothing; }
  /// Needs a geometry that has an inside.
  [[nodiscard]] virtual bool needs_solid() const noexcept { return false; }
  /// Needs a geometry that is a single point.
  [[nodiscard]] virtual bool needs_point() const noexcept { return false; }
  /// Needs a geometry that has an axis.
  [[nodiscard]] virtual bool needs_axis() const noexcept { return false; }
  /// Its constraint has a gap, by which a policy may engage or ramp.
  [[nodiscard]] virtual bool has_gap() const noexcept { return true; }
};

/// Options of all roles; each reads its own.
struct RoleOptions {
  double margin = 0.0;          ///< guide: free play around; forbid: kept clear outside; keep_in: kept clear inside [m]
  double angle = 0.0;           ///< orient: free tilt [rad]
  Vec3 axis = Vec3::UnitZ();    ///< orient, rcm: of the tool, in T: what points, or slides, along
  std::string target = "axis";  ///< orient: the geometry's `axis`, its `normal` (against it), or its whole `frame`
  double speed = 0.0;           ///< limit: of the tool [m/s]; 0: none
  double force = 0.0;           ///< limit: of what it touches, on the tool [N]; 0: none. Neither: a workspace
};

/// Makes a force from a constraint. Stateless.
class Law {
 public:
  virtual ~Law() = default;
  /// V_WT: commanded velocity of the tool.
  [[nodiscard]] virtual ConstraintForce force(const Constraint& c, const Twist& V_WT) const noexcept = 0;
  [[nodiscard]] virtual const char* name() const noexcept = 0;
  /// Largest slope of the force over the violation, and over the speed, for the study of stability.
  [[nodiscard]] virtual double stiffness() const noexcept = 0;          ///< [N/m]
  [[nodiscard]] virtual double damping() const noexcept = 0;            ///< [N s/m]
  [[nodiscard]] virtual double turning_stiffness() const noexcept = 0;  ///< [N m/rad]
  [[nodiscard]] virtual double turning_damping() const noexcept = 0;    ///< [N m s/rad]
  /// The violation is found for all such fixtures together, by the quadratic program.
  [[nodiscard]] virtual bool jointly() const noexcept { return false; }
};

/// Options of all laws; each reads its own.
struct LawOptions {
  double K = 400.0;         ///< stiffness, on the tool's side: the hand feels scale * force_scale * K [N/m]
  double B = 2.0;           ///< damping against the gradient [N s/m]
  double K_turn = 0.5;      ///< the same of an angle [N m/rad]
  double B_turn = 0.005;    ///< [N m s/rad]
  double force = 3.0;       ///< largest force: potential, optimise [N]
  double moment = 0.05;     ///< the same of an angle [N m]
  double range = 0.01;      ///< potential: attracts from so far, repels from so far [m]
  double range_turn = 0.5;  ///< the same of an angle [rad]
  double ratio = 0.1;       ///< admittance: of the motion that is not free to the free one, under the same force [0-1]
};

/// Scales the authority with a measured value: 0 at `from`, 1 at `to`, linear between; either may be the larger.
struct Ramp {
  enum class By {
    pedal,     ///< Controls::guidance, 0-1
    distance,  ///< |gap| [m, rad]
    time,      ///< since the fixture was engaged [s]
    force,     ///< of the operator, by a load cell; without one the force of the fixture's law [N]
  };
  By by = By::pedal;
  double from = 0.0, to = 1.0;
};

/// How much authority a fixture has.
struct Policy {
  bool hard = false;  ///< the tool's goal is corrected as well: with authority 1 the tool never violates the constraint
  double authority = 1.0;  ///< 0-1, times the ramps
  int priority = 0;        ///< a lower one never pushes against a higher one; hard fixtures come first
  double engage = std::numeric_limits<double>::infinity();   ///< engages once |gap| is below [m, rad] ...
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
  LiveFrames frames;  ///< live frames that carry the geometry; before the first pose arrives the authority is zero
  double patience = std::numeric_limits<double>::infinity();  ///< timeout of their poses, then too [s]
};

/// The fixture's constraint at time t [s], whatever its policy.
[[nodiscard]] Constraint evaluate(const Fixture& fixture, const ToolQuery& tool, double t) noexcept;

struct Fixtures {
  std::vector<Fixture> fixture;
  std::shared_ptr<LiveFrame>
      tool;  ///< receives the tool's pose at every tick, for geometries attached to it; may be null
};

/// Names of the available roles and laws.
std::vector<std::string> roles();
std::vector<std::string> laws();
/// Throws std::invalid_argument naming the bad value, or the available names.
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
