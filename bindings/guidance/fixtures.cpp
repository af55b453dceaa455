#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <limits>
#include <memory>
#include <string>
#include <utility>

#include "convert.hpp"
#include "doc.hpp"
#include "guidance/bindings.hpp"
#include "palpate/guidance/guidance.hpp"
#include "types.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using guidance::Fixture;
using guidance::Fixtures;
using guidance::Geometry;
using guidance::Guidance;
using guidance::LawOptions;
using guidance::Policy;
using guidance::Qp;
using guidance::RoleOptions;

Twist to_twist(const VectorArg& V, const char* name) {
  const Wrench both = wrench(V.values, name);
  return {both.f, both.t};
}

Fields to_dict(const guidance::Constraint& c) {
  Fields out;
  out["gap"] = c.gap;
  out["along"] = to_vector(c.gradient);
  out["drift"] = c.gap_rate_of_fixture;
  out["free"] = c.free;
  out["attracts"] = c.attracts;
  out["turns"] = c.rotational;
  out["speed"] = c.speed_limit;
  return out;
}

/// The constraint of a tool at X_WT, and the force of the fixture's law.
Fields evaluate(const Fixture& f, const Matrix4& X_WT, double t, const VectorArg& V_WT, const Vec3& F_T_W,
                double stiffness) {
  const Pose X = to_pose(X_WT, "X_WT");
  const guidance::Constraint c = guidance::evaluate(f, {X, X.p, F_T_W, stiffness}, t);
  const guidance::ConstraintForce force = f.law->force(c, to_twist(V_WT, "V_WT"));
  Fields out = to_dict(c);
  out["F"] = to_vector(force.F);
  out["U"] = force.U;
  out["B"] = force.B;
  out["F_of_B"] = to_vector(force.F_of_B);
  return out;
}

void bind_fixture(nb::module_& m) {
  nb::class_<Fixture>(m, "Fixture",
                      "Virtual fixture: a geometry, a role, a law and a policy (core/palpate/guidance/fixture.hpp).")
      .def(
          "__init__",
          [](Fixture* self, std::string name, std::shared_ptr<Geometry> geometry, const std::string& role,
             const RoleOptions& role_options, const std::string& law, const LawOptions& law_options,
             const Policy& policy, bool on, double timeout) {
            new (self) Fixture{std::move(name),
                               std::move(geometry),
                               guidance::make_role(role, role_options),
                               guidance::make_law(law, law_options),
                               policy,
                               on,
                               {},
                               timeout};
            if (self->geometry) self->geometry->add_live(self->frames);
          },
          "name"_a, "geometry"_a, "role"_a, "role_options"_a = RoleOptions{}, "law"_a = "spring",
          "law_options"_a = LawOptions{}, "policy"_a = Policy{}, "on"_a = true,
          "timeout"_a = std::numeric_limits<double>::infinity(),
          "timeout: timeout of the live frames that carry the geometry [s]; without a newer pose the fixture fades "
          "out.")
      .def_ro("name", &Fixture::name, "Name, unique in its list."_doc)
      .def_prop_ro(
          "role", [](const Fixture& f) { return std::string(f.role->name()); }, "Name of the role.")
      .def_prop_ro(
          "law", [](const Fixture& f) { return std::string(f.law->name()); }, "Name of the law.")
      .def_ro("policy", &Fixture::policy, "When and with how much authority the fixture acts."_doc)
      .def_ro("on", &Fixture::on, "False: the fixture is switched off."_doc)
      .def_prop_ro(
          "stiffness", [](const Fixture& f) { return f.law->stiffness(); }, "Largest stiffness of the law [N/m].")
      .def_prop_ro(
          "damping", [](const Fixture& f) { return f.law->damping(); }, "Largest damping of the law [N s/m].")
      .def_prop_ro(
          "turning_stiffness", [](const Fixture& f) { return f.law->turning_stiffness(); },
          "Largest rotational stiffness of the law [N m/rad].")
      .def_prop_ro(
          "turning_damping", [](const Fixture& f) { return f.law->turning_damping(); },
          "Largest rotational damping of the law [N m s/rad].")
      .def("evaluate", &evaluate, "X_WT"_a, "t"_a = 0.0, "V_WT"_a = Vec6(Vec6::Zero()), "F_T_W"_a = Vec3(Vec3::Zero()),
           "stiffness"_a = 0.0,
           "The fixture's constraint on a tool at X_WT (4, 4), as a dict: gap [m, rad], its gradient `along` (6,), its "
           "rate `drift` caused by the fixture's own motion, the projector `free` (3, 3) on the free directions, "
           "attracts, turns (the gap is an angle), speed (limit [m/s]). Also the force of the law while the tool moves "
           "with V_WT (6,): wrench F (6,), stored energy U [J], damping B (3, 3) [N s/m] and the part F_of_B of F that "
           "is -B v. Authority and other fixtures are not considered.");
}

void bind_fixture_list(nb::module_& m) {
  nb::class_<Fixtures, guidance::FixtureList>(m, "Fixtures",
                                              "An immutable list of fixtures; guidance replaces it as a whole.")
      .def(
          "__init__",
          [](Fixtures* self, const std::vector<Fixture*>& fixtures, std::shared_ptr<scene::LiveFrame> tool) {
            Fixtures list;
            list.tool = std::move(tool);
            for (const Fixture* f : fixtures) {
              if (f == nullptr) throw std::invalid_argument("guidance: a fixture of the list is None");
              list.fixture.push_back(*f);
            }
            list.check();
            new (self) Fixtures(std::move(list));
          },
          "fixtures"_a = std::vector<Fixture*>{}, "tool"_a.none() = nb::none(),
          "tool: a frame that receives the tool's pose at every tick, for geometries attached to the tool.")
      .def("__len__", [](const Fixtures& list) { return list.fixture.size(); })
      .def("list", [](const Fixtures& list) { return list.fixture; }, "The fixtures, in order.");
}

Fields step(Guidance& self, double t, const Matrix4& X_WT_goal, const VectorArg& V_WT, const Matrix4& X_WT,
            bool engaged, const Vec3& F_T_W, double stiffness, double F_hand, double pedal, bool renders_damping) {
  guidance::Input in;
  in.t = t;
  in.goal = {to_pose(X_WT_goal, "X_WT_goal"), 0.0, to_twist(V_WT, "V_WT"), engaged};
  in.tool.X_WT = to_pose(X_WT, "X_WT");
  in.tool_force = {{F_T_W, Vec3::Zero()}, stiffness};
  in.handle.F_hand = F_hand;
  in.handle.renders_damping = renders_damping;
  in.pedal = pedal;
  const guidance::Output& out = self.step(in);
  Fields d;
  d["X_WT_goal"] = to_matrix(out.X_WT_goal);
  d["J_goal"] = out.J_goal;
  d["F_T_W"] = to_vector(out.on_tool.F);
  d["B_W"] = out.on_tool.B;
  d["strongest"] = out.strongest;
  d["gap"] = out.gap;
  d["correction"] = out.correction;
  d["status"] = out.status;
  return d;
}

void bind_guidance_stage(nb::module_& m) {
  using guidance::Options;
  nb::class_<Guidance>(m, "Guidance", "The stage `guidance` outside a loop.")
      .def(nb::init<const Options&, double>(), "options"_a = Options{}, "dt"_a = 1e-3, "dt: period of the cycle [s].")
      .def("take", &Guidance::take, "fixtures"_a, nb::keep_alive<1, 2>(),
           "Replaces the fixtures from the next step on.")
      .def("step", &step, "t"_a, "X_WT_goal"_a, "V_WT"_a, "X_WT"_a, "engaged"_a = true, "F_T_W"_a = Vec3(Vec3::Zero()),
           "stiffness"_a = 0.0, "F_hand"_a = -1.0, "pedal"_a = 1.0, "takes_damping"_a = false,
           "One tick, as a dict: corrected goal X_WT_goal (4, 4), its derivative J_goal (6, 6) with respect to the "
           "mapped "
           "goal, wrench of the fixtures F_T_W (6,) [N, N m], damping "
           "B_W (3, 3) [N s/m], index `strongest` of the fixture with the largest force (-1: none), its gap [m, rad], "
           "correction (3,) of the goal [m], status bits.")
      .def("authority", &Guidance::authority, "i"_a, "Authority of fixture i at the last step, ramps included [-].")
      .def(
          "wrench", [](const Guidance& self, int i) { return to_vector(self.wrench(i)); }, "i"_a,
          "Wrench of fixture i on the tool at the last step (6,) [N, N m].")
      .def("gap", &Guidance::gap, "i"_a, "Gap of fixture i at the last step [m, rad].");
}

/// Solves one program; the rows that were active in the previous solution are tried first.
Fields solve(Qp& qp, const Eigen::MatrixXd& A, const VectorArg& b, const VectorArg& y0, const std::vector<int>& ranks) {
  const Eigen::Index m = A.rows();
  if (A.cols() != Qp::kVars || b.values.size() != m || y0.values.size() != Qp::kVars ||
      (!ranks.empty() && static_cast<Eigen::Index>(ranks.size()) != m)) {
    throw std::invalid_argument(
        "the quadratic program needs A of shape (m, 6), b (m,), y0 (6,) and ranks (m,) or none; got A (" +
        std::to_string(m) + ", " + std::to_string(A.cols()) + "), b (" + std::to_string(b.values.size()) + ",), y0 (" +
        std::to_string(y0.values.size()) + ",), " + std::to_string(ranks.size()) + " ranks");
  }
  qp.clear();
  std::vector<int> index;
  for (Eigen::Index i = 0; i < m; ++i) {
    const int rank = ranks.empty() ? 0 : ranks[static_cast<std::size_t>(i)];
    index.push_back(qp.add(A.row(i).transpose(), b.values[i], rank));
  }
  const Qp::Status status = qp.solve(y0.values);
  Eigen::VectorXd multipliers = Eigen::VectorXd::Zero(m);
  std::vector<bool> gave_way(static_cast<std::size_t>(m), false);
  for (std::size_t i = 0; i < index.size(); ++i) {
    if (index[i] < 0) continue;
    multipliers[static_cast<Eigen::Index>(i)] = qp.multiplier(index[i]);
    gave_way[i] = qp.dropped(index[i]);
  }
  constexpr std::array kStatus = {"solved", "relaxed", "stopped"};
  Fields out;
  out["status"] = kStatus[static_cast<std::size_t>(status)];
  out["y"] = qp.y();
  out["multipliers"] = multipliers;
  out["gave_way"] = gave_way;
  out["steps"] = qp.steps();
  out["rows"] = index;
  return out;
}

}  // namespace

void bind_fixtures(nb::module_& m) {
  m.def("guidance_roles", &guidance::roles, "Names of the available roles.");
  m.def("guidance_laws", &guidance::laws, "Names of the available laws.");
  bind_fixture(m);
  bind_fixture_list(m);
  bind_guidance_stage(m);
  nb::class_<Qp>(m, "Qp",
                 "Solves min |y - y0|^2 / 2 subject to A y >= b in six variables (core/palpate/guidance/qp.hpp).")
      .def(nb::init<>())
      .def("solve", &solve, "A"_a, "b"_a, "y0"_a, "ranks"_a = std::vector<int>{},
           "Solution as a dict: y (6,), multipliers (m,), status 'solved', 'relaxed' or 'stopped', gave_way (m,) for "
           "rows that were relaxed, number of steps, and the index of each row (negative: rejected).");
}

}  // namespace palpate::bindings
