#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <limits>
#include <memory>
#include <string>
#include <utility>

#include "bindings.hpp"
#include "convert.hpp"
#include "palpate/guidance/frame.hpp"
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
using guidance::Ramp;
using guidance::RoleOptions;

constexpr std::array kRamps = {"pedal", "distance", "time", "force"};  // as in Ramp::By

Ramp::By by_name(const std::string& name) {
  for (std::size_t i = 0; i < kRamps.size(); ++i) {
    if (name == kRamps[i]) return static_cast<Ramp::By>(i);
  }
  throw std::invalid_argument("ramp by '" + name + "': must be pedal, distance, time or force");
}

Twist to_twist(const VectorArg& V, const char* name) {
  const Wrench both = wrench(V.values, name);
  return {both.f, both.t};
}

void bind_options(nb::module_& m) {
  nb::class_<RoleOptions>(m, "GuidanceRoleOptions", "Of all roles of guidance; each reads what concerns it.")
      .def(nb::init<>())
      .def_rw("margin", &RoleOptions::margin, "guide: free play; forbid, keep-in: kept clear [m]")
      .def_rw("angle", &RoleOptions::angle, "orient: free tilt [rad]")
      .def_rw("axis", &RoleOptions::axis, "orient, rcm: of the tool, in T, what points or slides (3,)")
      .def_rw("target", &RoleOptions::target,
              nb::for_getter(nb::sig("def target(self) -> typing.Literal['axis', 'normal', 'frame']")),
              nb::for_setter(nb::sig("def target(self, name: typing.Literal['axis', 'normal', 'frame'], /) -> None")),
              "orient: 'axis', 'normal' or 'frame' of the geometry")
      .def_rw("speed", &RoleOptions::speed, "limit: of the tool, 0: none [m/s]")
      .def_rw("force", &RoleOptions::force, "limit: of what it touches on the tool, 0: none [N]");
  nb::class_<LawOptions>(m, "GuidanceLawOptions", "Of all laws of guidance; each reads what concerns it.")
      .def(nb::init<>())
      .def_rw("K", &LawOptions::K, "stiffness, on the tool's side [N/m]")
      .def_rw("B", &LawOptions::B, "damping [N s/m]")
      .def_rw("K_turn", &LawOptions::K_turn, "of an angle [N m/rad]")
      .def_rw("B_turn", &LawOptions::B_turn, "of an angle [N m s/rad]")
      .def_rw("force", &LawOptions::force, "potential, optimise: most that it pulls [N]")
      .def_rw("moment", &LawOptions::moment, "the same of an angle [N m]")
      .def_rw("range", &LawOptions::range, "potential: attracts or repels from so far [m]")
      .def_rw("range_turn", &LawOptions::range_turn, "the same of an angle [rad]")
      .def_rw("ratio", &LawOptions::ratio, "admittance: speed across what is free per speed along it, 0.01-1");
  nb::class_<Ramp>(m, "Ramp", "Fades with what is measured: 0 at `start`, 1 at `end`.")
      .def(
          "__init__",
          [](Ramp* self, const std::string& by, double start, double end) { new (self) Ramp{by_name(by), start, end}; },
          "by"_a = "pedal", "start"_a = 0.0, "end"_a = 1.0)
      .def_prop_ro(
          "by", [](const Ramp& r) { return std::string(kRamps[static_cast<std::size_t>(r.by)]); },
          "'pedal' [0-1], 'distance' [m, rad], 'time' since it was engaged [s], 'force' of the operator [N]")
      .def_ro("start", &Ramp::from)
      .def_ro("end", &Ramp::to);
  nb::class_<Policy>(m, "Policy", "How much of a fixture counts.")
      .def(nb::init<>())
      .def_rw("hard", &Policy::hard, "the tool's goal is corrected as well")
      .def_rw("authority", &Policy::authority, "0-1, times the ramps")
      .def_rw("priority", &Policy::priority, "a lower one never pulls against a higher one")
      .def_rw("engage", &Policy::engage, "takes part once |gap| is below [m, rad]")
      .def_rw("release", &Policy::release, "until it is above [m, rad]")
      .def_rw("rise", &Policy::rise, "shortest time for its authority from 0 to 1 [s]")
      .def_rw("fall", &Policy::fall, "and back [s]")
      .def_rw("ramps", &Policy::ramps, "a copy; assign it whole");
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
  m.def("guidance_roles", &guidance::roles, "Names of the roles there are.");
  m.def("guidance_laws", &guidance::laws, "Names of the laws there are.");
  nb::class_<Fixture>(m, "Fixture", "A geometry, a role, a law and a policy (core/palpate/guidance/fixture.hpp).")
      .def(
          "__init__",
          [](Fixture* self, std::string name, std::shared_ptr<Geometry> geometry, const std::string& role,
             const RoleOptions& role_options, const std::string& law, const LawOptions& law_options,
             const Policy& policy, bool on, double patience) {
            new (self) Fixture{std::move(name),
                               std::move(geometry),
                               guidance::make_role(role, role_options),
                               guidance::make_law(law, law_options),
                               policy,
                               on,
                               {},
                               patience};
            if (self->geometry) self->geometry->add_live(self->frames);
          },
          "name"_a, "geometry"_a, "role"_a, "role_options"_a = RoleOptions{}, "law"_a = "spring",
          "law_options"_a = LawOptions{}, "policy"_a = Policy{}, "on"_a = true,
          "patience"_a = std::numeric_limits<double>::infinity(),
          "patience: a live frame that it is attached to told no longer ago than this, or it fades out [s].")
      .def_ro("name", &Fixture::name)
      .def_prop_ro("role", [](const Fixture& f) { return std::string(f.role->name()); })
      .def_prop_ro("law", [](const Fixture& f) { return std::string(f.law->name()); })
      .def_ro("policy", &Fixture::policy)
      .def_ro("on", &Fixture::on)
      .def_prop_ro(
          "stiffness", [](const Fixture& f) { return f.law->stiffness(); }, "the steepest of its law [N/m]")
      .def_prop_ro(
          "damping", [](const Fixture& f) { return f.law->damping(); }, "the most of its law [N s/m]")
      .def_prop_ro(
          "turning_stiffness", [](const Fixture& f) { return f.law->turning_stiffness(); }, "[N m/rad]")
      .def_prop_ro(
          "turning_damping", [](const Fixture& f) { return f.law->turning_damping(); }, "[N m s/rad]")
      .def("ask", &evaluate, "X_WT"_a, "t"_a = 0.0, "V_WT"_a = Vec6(Vec6::Zero()), "F_T_W"_a = Vec3(Vec3::Zero()),
           "stiffness"_a = 0.0,
           "What its role wants of a tool at X_WT (4, 4) (gap, along (6,), drift, free (3, 3), attracts, turns, "
           "speed), and its law's answer to a motion V_WT (6,): wrench F (6,), energy U [J], damping B (3, 3) and the "
           "part F_of_B of F. Authority and other fixtures left aside.");
  nb::class_<Fixtures>(m, "Fixtures", "A list of fixtures: immutable, swapped whole.")
      .def(
          "__init__",
          [](Fixtures* self, const std::vector<Fixture*>& fixtures, std::shared_ptr<guidance::LiveFrame> tool) {
            Fixtures list;
            list.tool = std::move(tool);
            for (const Fixture* f : fixtures) {
              if (f == nullptr) throw std::invalid_argument("guidance: a fixture of the list is None");
              list.fixture.push_back(*f);
            }
            guidance::check(list);
            new (self) Fixtures(std::move(list));
          },
          "fixtures"_a = std::vector<Fixture*>{}, "tool"_a.none() = nb::none(),
          "tool: a frame that is told at every tick where the tool is.")
      .def("__len__", [](const Fixtures& list) { return list.fixture.size(); })
      .def("list", [](const Fixtures& list) { return list.fixture; }, "The fixtures, in their order.");
}

Fields step(Guidance& self, double t, const Matrix4& X_WT_goal, const VectorArg& V_WT, const Matrix4& X_WT,
            bool engaged, const Vec3& F_T_W, double stiffness, double F_hand, double pedal, bool takes_damping) {
  guidance::Input in;
  in.t = t;
  in.goal = {to_pose(X_WT_goal, "X_WT_goal"), 0.0, to_twist(V_WT, "V_WT"), engaged};
  in.tool.X_WT = to_pose(X_WT, "X_WT");
  in.touch = {{F_T_W, Vec3::Zero()}, stiffness};
  in.handle.F_hand = F_hand;
  in.handle.takes_damping = takes_damping;
  in.pedal = pedal;
  const guidance::Output& out = self.step(in);
  Fields d;
  d["X_WT_goal"] = to_matrix(out.X_WT_goal);
  d["F_T_W"] = to_vector(out.on_tool.F);
  d["B_W"] = out.on_tool.B;
  d["strongest"] = out.strongest;
  d["gap"] = out.gap;
  d["correction"] = out.correction;
  d["status"] = out.status;
  return d;
}

void bind_stage(nb::module_& m) {
  using guidance::Options;
  nb::class_<Options>(m, "GuidanceOptions", "Of the stage `guidance`.")
      .def(nb::init<>())
      .def_rw("force_rate", &Options::force_rate, "of what no motion explains: a switch, an edit [N/s]")
      .def_rw("moment_rate", &Options::moment_rate, "the same of moments [N m/s]")
      .def_rw("return_speed", &Options::return_speed, "of a goal that has to leave a region just forbidden [m/s]")
      .def_rw("reserve", &Options::reserve, "hard fixtures keep the goal so far from the border [m]")
      .def_prop_rw(
          "servo_bandwidth", [](const Options& o) { return o.servo.bandwidth; },
          [](Options& o, double x) { o.servo.bandwidth = x; },
          "of the follower behind its goal; 0: at once; below zero: as simulated [Hz]")
      .def_prop_rw(
          "servo_damping", [](const Options& o) { return o.servo.damping_ratio; },
          [](Options& o, double x) { o.servo.damping_ratio = x; }, "of the same [-]");
  nb::class_<Guidance>(m, "Guidance", "The stage `guidance` by itself.")
      .def(nb::init<const Options&, double>(), "options"_a = Options{}, "dt"_a = 1e-3)
      .def("take", &Guidance::take, "fixtures"_a, nb::keep_alive<1, 2>(), "From now on these.")
      .def("step", &step, "t"_a, "X_WT_goal"_a, "V_WT"_a, "X_WT"_a, "engaged"_a = true, "F_T_W"_a = Vec3(Vec3::Zero()),
           "stiffness"_a = 0.0, "F_hand"_a = -1.0, "pedal"_a = 1.0, "takes_damping"_a = false,
           "One tick: X_WT_goal (4, 4), F_T_W (6,), B_W (3, 3), strongest, gap, correction (3,), status.")
      .def("authority", &Guidance::authority, "i"_a, "Of fixture i, ramped.")
      .def(
          "wrench", [](const Guidance& self, int i) { return to_vector(self.wrench(i)); }, "i"_a, "Of fixture i (6,).")
      .def("gap", &Guidance::gap, "i"_a, "Of fixture i [m, rad].");
}

/// Solves one program from scratch, or from the active rows of the one before.
Fields solve(Qp& qp, const Eigen::MatrixXd& A, const VectorArg& b, const VectorArg& y0, const std::vector<int>& ranks) {
  const Eigen::Index m = A.rows();
  if (A.cols() != Qp::kVars || b.values.size() != m || y0.values.size() != Qp::kVars ||
      (!ranks.empty() && static_cast<Eigen::Index>(ranks.size()) != m)) {
    throw std::invalid_argument("qp: A must have shape (m, 6), b (m,), y0 (6,), ranks (m,) or none");
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
    gave_way[i] = qp.gave_way(index[i]);
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
  bind_options(m);
  bind_fixture(m);
  bind_stage(m);
  nb::class_<Qp>(m, "Qp", "min |y - y0|^2 / 2 subject to A y >= b, in six variables (core/palpate/guidance/qp.hpp).")
      .def(nb::init<>())
      .def("solve", &solve, "A"_a, "b"_a, "y0"_a, "ranks"_a = std::vector<int>{},
           "y (6,), multipliers (m,), status 'solved', 'relaxed' or 'stopped', gave_way (m,), steps, and the index of "
           "each row (below zero: refused).");
}

}  // namespace palpate::bindings
