// A fixture: a geometry, a role that makes a constraint on the tool from it, a law that makes a force from the
// constraint, and a policy that sets the fixture's authority. Roles and laws do not depend on the shape. A list of
// fixtures is immutable and replaced as a whole.
#pragma once

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "palpate/guidance/constraint.hpp"
#include "palpate/guidance/geometry.hpp"
#include "palpate/guidance/interface/stage.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::guidance {

/// Largest number of fixtures in a list.
inline constexpr int kMaxFixtures = 128;

/// Makes a constraint from a geometry. Stateless, so that it may be evaluated at any pose.
class Role {
 public:
  virtual ~Role() = default;
  /// The constraint for a tool, from the query at its pose. around: the derivatives that needs() selects, else zero.
  [[nodiscard]] virtual Constraint constraint(const Query& query, const QueryDerivatives& derivatives,
                                              const ToolQuery& tool) const noexcept = 0;
  /// Name under which make_role() finds the role.
  [[nodiscard]] virtual const char* name() const noexcept = 0;
  /// Derivatives with respect to the tool's position that the constraint needs: none, those of Geometry::normals(), or
  /// that of Geometry::attitude_derivative().
  enum class Needs { nothing, normals, attitude_derivative };
  [[nodiscard]] virtual Needs needs() const noexcept { return Needs::nothing; }
  /// True if the role needs a geometry that has an inside.
  [[nodiscard]] virtual bool needs_solid() const noexcept { return false; }
  /// True if the role needs a geometry that is a single point.
  [[nodiscard]] virtual bool needs_point() const noexcept { return false; }
  /// True if the role needs a geometry that has an axis.
  [[nodiscard]] virtual bool needs_axis() const noexcept { return false; }
  /// Distance from the geometry at which the constraint's border lies, if the constraint depends on the geometry by
  /// this border alone and is inactive far from it; infinity for other constraints [m].
  [[nodiscard]] virtual double border() const noexcept { return std::numeric_limits<double>::infinity(); }
  /// True if the constraint has a gap, by which a policy can engage the fixture or ramp its authority.
  [[nodiscard]] virtual bool has_gap() const noexcept { return true; }
};

/// Makes a force from a constraint. Stateless.
class Law {
 public:
  virtual ~Law() = default;
  /// Force on a tool with the commanded velocity V_WT, for the constraint c.
  [[nodiscard]] virtual ConstraintForce force(const Constraint& c, const Twist& V_WT) const noexcept = 0;
  /// Name under which make_law() finds the law.
  [[nodiscard]] virtual const char* name() const noexcept = 0;
  /// Largest derivative of the force with respect to the violation (stiffness) and to the speed (damping), for the
  /// stability analysis.
  [[nodiscard]] virtual double stiffness() const noexcept = 0;          ///< [N/m]
  [[nodiscard]] virtual double damping() const noexcept = 0;            ///< [N s/m]
  [[nodiscard]] virtual double turning_stiffness() const noexcept = 0;  ///< [N m/rad]
  [[nodiscard]] virtual double turning_damping() const noexcept = 0;    ///< [N m s/rad]
  /// Distance before the border of a repelling role at which the force begins [m].
  [[nodiscard]] virtual double reach() const noexcept { return 0.0; }
  /// Largest force or moment of the law [N, N m].
  [[nodiscard]] virtual double most(const Constraint& /*c*/) const noexcept {
    return std::numeric_limits<double>::infinity();
  }
  /// True if one quadratic program finds the violations of all fixtures with such a law together.
  [[nodiscard]] virtual bool solves_jointly() const noexcept { return false; }
};

/// A geometry with its role, law and policy.
struct Fixture {
  std::string name;  ///< unique in its list; an edited fixture takes over the state of the one with the same name
  GeometryPtr geometry;
  std::shared_ptr<const Role> role;
  std::shared_ptr<const Law> law;
  Policy policy;
  bool on = true;     ///< false: switched off, the authority falls to zero
  LiveFrames frames;  ///< live frames that carry the geometry; the authority is zero until each has a pose
  double timeout = std::numeric_limits<double>::infinity();  ///< timeout: with an older pose the authority is zero [s]
};

/// True for a soft fixture whose violation a program finds together with others (Law::solves_jointly).
[[nodiscard]] inline bool has_joint_law(const Fixture& f) noexcept { return !f.policy.hard && f.law->solves_jointly(); }

/// Distance from the fixture's geometry within which its constraint is exact; farther away a lower bound of the
/// distance suffices, because the constraint is inactive there [m].
[[nodiscard]] double exact_within(const Fixture& fixture) noexcept;
/// The fixture's constraint at time t [s], whatever its policy.
[[nodiscard]] Constraint evaluate(const Fixture& fixture, const ToolQuery& tool, double t) noexcept;

/// A list of fixtures, immutable while the stage uses it.
struct Fixtures final : FixtureList {
  std::vector<Fixture> fixture;

  [[nodiscard]] const Fixtures* fixtures() const noexcept override { return this; }
  [[nodiscard]] std::unique_ptr<Stage> make_stage(const Options& options, double dt) const override;
  void check() const override;
};

/// Names of the available roles and laws.
std::vector<std::string> roles();
std::vector<std::string> laws();
/// A role or a law by its name. Throws std::invalid_argument naming the bad value, or the available names.
[[nodiscard]] std::shared_ptr<const Role> make_role(const std::string& name, const RoleOptions& options);
[[nodiscard]] std::shared_ptr<const Law> make_law(const std::string& name, const LawOptions& options);
// The single roles and laws, for make_role() and make_law(); each has a file of its own.
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
