#include "palpate/guidance/fixture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "palpate/types/require.hpp"

namespace palpate::guidance {
namespace {

constexpr double kNear = 3e-3;  // [m] at this distance from its border or farther, a hard fixture is inactive: goals
                                // move far less in a period

struct RoleEntry {
  const char* name;
  std::shared_ptr<const Role> (*make)(const RoleOptions&);
};
struct LawEntry {
  const char* name;
  std::shared_ptr<const Law> (*make)(const LawOptions&);
};

/// A new role or law takes one file and one line here.
constexpr std::array kRoles = {RoleEntry{"guide", &make_guide},     RoleEntry{"forbid", &make_forbid},
                               RoleEntry{"keep-in", &make_keep_in}, RoleEntry{"orient", &make_orient},
                               RoleEntry{"limit", &make_limit},     RoleEntry{"rcm", &make_rcm}};
constexpr std::array kLaws = {LawEntry{"spring", &make_spring}, LawEntry{"potential", &make_potential},
                              LawEntry{"admittance", &make_admittance}, LawEntry{"optimise", &make_optimise}};

template <class Table>
std::vector<std::string> names(const Table& table) {
  std::vector<std::string> out;
  out.reserve(table.size());
  for (const auto& entry : table) out.emplace_back(entry.name);
  return out;
}

template <class Table, class Options>
auto make(const char* what, const Table& table, const std::string& name, const Options& options) {
  std::string known;
  for (const auto& entry : table) {
    if (name == entry.name) return entry.make(options);
    known += (known.empty() ? "" : ", ") + std::string(entry.name);
  }
  throw std::invalid_argument("guidance: no " + std::string(what) + " '" + name + "'; there are: " + known);
}

void check(const RoleOptions& o) {
  const std::string role = "role";
  require(role, o.margin >= 0.0 && std::isfinite(o.margin), "margin", o.margin, "must be 0 m or more, and finite");
  require(role, o.angle >= 0.0 && o.angle <= 3.2, "angle", o.angle, "must lie in 0..pi rad");
  require(role, o.axis.allFinite() && o.axis.norm() > 1e-9, "axis", o.axis.norm(), "must have a length");
  require(role, o.speed >= 0.0 && std::isfinite(o.speed), "speed", o.speed, "must be above 0 m/s (0: none)");
  require(role, o.force >= 0.0 && std::isfinite(o.force), "force", o.force, "must be above 0 N (0: none)");
}

void check(const LawOptions& o) {
  const std::string law = "law";
  const auto positive = [&](const char* key, double value, const char* remedy) {
    require(law, value >= 0.0 && std::isfinite(value), key, value, remedy);
  };
  positive("K", o.K, "must be 0 N/m or more, and finite");
  positive("B", o.B, "must be 0 N s/m or more, and finite");
  positive("K_turn", o.K_turn, "must be 0 N m/rad or more, and finite");
  positive("B_turn", o.B_turn, "must be 0 N m s/rad or more, and finite");
  positive("force", o.force, "must be 0 N or more, and finite");
  positive("moment", o.moment, "must be 0 N m or more, and finite");
  require(law, o.range > 0.0 && std::isfinite(o.range), "range", o.range, "must be above 0 m, for example 0.01");
  require(law, o.range_turn > 0.0 && o.range_turn <= 3.2, "range_turn", o.range_turn, "must lie in 0..pi rad");
  require(law, o.ratio >= 0.01 && o.ratio <= 1.0, "ratio", o.ratio, "must lie in 0.01..1: harder is policy `hard`");
}

/// Throws if the geometry lacks what the role needs: an inside, a point, an axis or a distance.
void check_role_fits(const Fixture& f, const std::string& whose) {
  if (!f.geometry || !f.role || !f.law) {
    throw std::invalid_argument(whose + " lacks its " + (!f.geometry ? "geometry" : !f.role ? "role" : "law"));
  }
  if (f.role->needs_solid() && !f.geometry->solid()) {
    throw std::invalid_argument(whose + ": role " + f.role->name() +
                                " needs a geometry with an inside; give the geometry a thickness, or a margin");
  }
  if (f.role->needs_point() && !f.geometry->is_point()) {
    throw std::invalid_argument(
        whose + ": role " + f.role->name() +
        " needs a point, the place that the shaft passes through; give it a geometry point: {at: "
        "...}");
  }
  if (f.role->needs_axis() && !f.geometry->has_axis()) {
    throw std::invalid_argument(whose + ": role " + f.role->name() +
                                " with target axis needs a geometry that has one; turn it (rpy_deg), give a line " +
                                "through the place, or take target normal: towards it");
  }
  const Policy& p = f.policy;
  const bool by_gap =
      p.engage < std::numeric_limits<double>::infinity() ||
      std::any_of(p.ramps.begin(), p.ramps.end(), [](const Ramp& r) { return r.by == Ramp::By::distance; });
  if (by_gap && !f.role->has_gap()) {
    throw std::invalid_argument(whose +
                                ": a limit of speed has no distance to engage or to ramp by; leave out engage, " +
                                "or ramp by pedal, time or force");
  }
}

void check_fixture(const Fixture& f) {
  const std::string whose = "guidance: fixture '" + f.name + "'";
  check_role_fits(f, whose);
  const Policy& p = f.policy;
  require(whose, p.authority >= 0.0 && p.authority <= 1.0, "authority", p.authority, "must lie in 0..1");
  require(whose, p.engage >= 0.0, "engage", p.engage, "must be 0 m or more");
  require(whose, p.release >= p.engage, "release", p.release, "must not be below engage");
  require(whose, p.rise >= 0.01 && std::isfinite(p.rise), "rise", p.rise, "must be 0.01 s or more: no steps");
  require(whose, p.fall >= 0.01 && std::isfinite(p.fall), "fall", p.fall, "must be 0.01 s or more: no steps");
  require(whose, f.timeout > 0.0, "timeout", f.timeout, "must be above 0 s");
  for (const Ramp& ramp : p.ramps) {
    require(whose, std::isfinite(ramp.from) && std::isfinite(ramp.to) && ramp.from != ramp.to, "ramp", ramp.to,
            "from and to must be finite, and not the same");
  }
}

}  // namespace

std::vector<std::string> roles() { return names(kRoles); }
std::vector<std::string> laws() { return names(kLaws); }

std::shared_ptr<const Role> make_role(const std::string& name, const RoleOptions& options) {
  check(options);
  return make("role", kRoles, name, options);
}

std::shared_ptr<const Law> make_law(const std::string& name, const LawOptions& options) {
  check(options);
  return make("law", kLaws, name, options);
}

double exact_within(const Fixture& fixture) noexcept {
  const Policy& policy = fixture.policy;
  double within = std::max(kNear, fixture.law->reach());
  if (std::isfinite(policy.release)) within = std::max(within, policy.release);
  for (const Ramp& ramp : policy.ramps) {
    if (ramp.by == Ramp::By::distance) within = std::max({within, std::abs(ramp.from), std::abs(ramp.to)});
  }
  return fixture.role->border() + within;
}

Constraint evaluate(const Fixture& fixture, const ToolQuery& tool, double t) noexcept {
  const Geometry& geometry = *fixture.geometry;
  QueryDerivatives derivatives;
  const Role::Needs needs = fixture.role->needs();
  if (needs == Role::Needs::normals) derivatives = geometry.normals(tool.X_WT, t);
  if (needs == Role::Needs::attitude_derivative) derivatives = geometry.attitude_derivative(tool.X_WT, t);
  const auto constraint_within = [&](double within) {
    return fixture.role->constraint(geometry.query(tool.X_WT, t, within), derivatives, tool);
  };
  const Constraint found = constraint_within(exact_within(fixture));
  return found.gap < 0.0 ? constraint_within(Geometry::kEverywhere) : found;  // a bound must not shorten a correction
}

void Fixtures::check() const {
  if (fixture.size() > static_cast<std::size_t>(kMaxFixtures)) {
    throw std::invalid_argument("guidance: " + std::to_string(fixture.size()) + " fixtures; at most " +
                                std::to_string(kMaxFixtures));
  }
  std::vector<std::string> seen;
  for (const Fixture& f : fixture) {
    check_fixture(f);
    if (std::find(seen.begin(), seen.end(), f.name) != seen.end()) {
      throw std::invalid_argument("guidance: two fixtures are named '" + f.name + "'; give each a name of its own");
    }
    seen.push_back(f.name);
  }
}

}  // namespace palpate::guidance
