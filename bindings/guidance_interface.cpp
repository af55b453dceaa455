// What a loop and a scene's file know of guidance: options, frames, and fixtures without their kinds.
#include <nanobind/eigen/dense.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "bindings.hpp"
#include "convert.hpp"
#include "doc.hpp"
#include "palpate/guidance/interface/stage.hpp"
#include "palpate/scene/frame.hpp"
#include "types.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using guidance::LawOptions;
using guidance::Policy;
using guidance::Ramp;
using guidance::RoleOptions;

Twist twist(const Eigen::VectorXd& V, const char* name) {
  if (V.size() != 6 || !V.allFinite())
    throw std::invalid_argument(std::string(name) + " must be six finite numbers: linear [m/s] over angular [rad/s]");
  return {V.head<3>(), V.tail<3>()};
}

void bind_frames(nb::module_& m) {
  nb::class_<scene::Frame>(m, "Frame", "A frame to which a geometry is attached.")
      .def(
          "at",
          [](const scene::Frame& frame, double t) -> Tuple<Matrix4, Vec6> {
            const scene::FrameState s = frame.at(t);
            Vec6 V;
            V << s.V_WF.v, s.V_WF.w;
            return nb::make_tuple(to_matrix(s.X_WF), V);
          },
          nb::arg("t"),
          "(X_WF (4, 4), V_WF (6,)) at t [s]: pose, and velocity of its origin [m/s] over angular velocity [rad/s].");
  nb::class_<scene::MotionFrame, scene::Frame>(m, "MotionFrame", "A frame that moves like an object of the scene.")
      .def(
          "__init__",
          [](scene::MotionFrame* self, const Matrix4& X_WF, scene::Motion motion) {
            new (self) scene::MotionFrame(to_pose(X_WF, "X_WF"), std::move(motion));
          },
          nb::arg("X_WF") = Matrix4(Matrix4::Identity()), nb::arg("motion") = scene::Motion{},
          "X_WF (4, 4): pose at rest; motion: motion from that pose.");
  nb::class_<scene::LiveFrame, scene::Frame>(m, "LiveFrame",
                                             "A frame whose poses come from outside the loop, such as from a tracker.")
      .def(nb::init<>())
      .def(
          "set", [](scene::LiveFrame& frame, const Matrix4& X_WF) { frame.set(to_pose(X_WF, "X_WF")); },
          nb::arg("X_WF"),
          "Sets the pose X_WF (4, 4); the velocity follows from successive poses. Call it from one thread only.")
      .def(
          "set",
          [](scene::LiveFrame& frame, const Matrix4& X_WF, const VectorArg& V_WF) {
            frame.set(scene::FrameState{to_pose(X_WF, "X_WF"), twist(V_WF.values, "V_WF")});
          },
          nb::arg("X_WF"), nb::arg("V_WF"),
          "Sets the pose X_WF (4, 4) and the velocity V_WF (6,): linear [m/s] over angular [rad/s].")
      .def_prop_ro("has_pose", &scene::LiveFrame::has_pose, "True once a pose has been received.");
}

constexpr std::array kRamps = {"pedal", "distance", "time", "force"};  // in the order of Ramp::By

Ramp::By by_name(const std::string& name) {
  for (std::size_t i = 0; i < kRamps.size(); ++i) {
    if (name == kRamps[i]) return static_cast<Ramp::By>(i);
  }
  throw std::invalid_argument("a ramp goes by 'pedal', 'distance', 'time' or 'force'; got '" + name + "'");
}

void bind_guidance_options(nb::module_& m) {
  nb::class_<RoleOptions>(m, "GuidanceRoleOptions", "Options of all guidance roles; each role reads its own.")
      .def(nb::init<>())
      .def_rw("margin", &RoleOptions::margin, "guide: free play; forbid, keep-in: clearance from the surface [m]."_doc)
      .def_rw("angle", &RoleOptions::angle, "orient: angle that the tool may tilt freely [rad]."_doc)
      .def_rw("axis", &RoleOptions::axis,
              "orient, rcm: axis of the tool, in T, that is oriented or slides through the point (3,)."_doc)
      .def_rw("target", &RoleOptions::target,
              nb::for_getter(nb::sig("def target(self) -> typing.Literal['axis', 'normal', 'frame']")),
              nb::for_setter(nb::sig("def target(self, name: typing.Literal['axis', 'normal', 'frame'], /) -> None")),
              "orient: target, the 'axis', the 'normal' or the whole 'frame' of the geometry."_doc)
      .def_rw("speed", &RoleOptions::speed, "limit: largest speed of the tool [m/s]; 0: no limit."_doc)
      .def_rw("force", &RoleOptions::force, "limit: largest contact force on the tool [N]; 0: no limit."_doc);
  nb::class_<LawOptions>(m, "GuidanceLawOptions", "Options of all guidance laws; each law reads its own.")
      .def(nb::init<>())
      .def_rw("K", &LawOptions::K, "Stiffness on the tool's side [N/m]."_doc)
      .def_rw("B", &LawOptions::B, "Damping [N s/m]."_doc)
      .def_rw("K_turn", &LawOptions::K_turn, "Rotational stiffness [N m/rad]."_doc)
      .def_rw("B_turn", &LawOptions::B_turn, "Rotational damping [N m s/rad]."_doc)
      .def_rw("force", &LawOptions::force, "potential, optimise: largest force [N]."_doc)
      .def_rw("moment", &LawOptions::moment, "potential, optimise: largest moment [N m]."_doc)
      .def_rw("range", &LawOptions::range, "potential: distance from which it attracts or repels [m]."_doc)
      .def_rw("range_turn", &LawOptions::range_turn, "potential: angle from which it attracts [rad]."_doc)
      .def_rw("ratio", &LawOptions::ratio,
              "admittance: speed in the constrained directions per speed in the free ones, 0.01-1 [-]."_doc);
  nb::class_<Ramp>(m, "Ramp",
                   "Scales the authority of a fixture with a measured value: 0 at `start`, 1 at `end`, linear between.")
      .def(
          "__init__",
          [](Ramp* self, const std::string& by, double start, double end) { new (self) Ramp{by_name(by), start, end}; },
          "by"_a = "pedal", "start"_a = 0.0, "end"_a = 1.0, "start may be larger than end.")
      .def_prop_ro(
          "by", [](const Ramp& r) { return std::string(kRamps[static_cast<std::size_t>(r.by)]); },
          "Measured value: 'pedal' [0-1], 'distance' [m, rad], 'time' since the fixture was engaged [s] or 'force' of "
          "the operator [N].")
      .def_ro("start", &Ramp::from, "Value at which the authority is 0."_doc)
      .def_ro("end", &Ramp::to, "Value at which the authority is 1."_doc);
  nb::class_<Policy>(m, "Policy", "When and with how much authority a fixture acts.")
      .def(nb::init<>())
      .def_rw("hard", &Policy::hard, "True: the tool's goal is corrected as well."_doc)
      .def_rw("authority", &Policy::authority, "Authority, 0-1; the ramps multiply it [-]."_doc)
      .def_rw("priority", &Policy::priority,
              "Priority; the force of a lower one never opposes that of a higher one."_doc)
      .def_rw("engage", &Policy::engage, "|gap| below which the fixture engages [m, rad]."_doc)
      .def_rw("release", &Policy::release, "|gap| above which the fixture disengages [m, rad]."_doc)
      .def_rw("rise", &Policy::rise, "Shortest time in which the authority rises from 0 to 1 [s]."_doc)
      .def_rw("fall", &Policy::fall, "Shortest time in which the authority falls from 1 to 0 [s]."_doc)
      .def_rw("ramps", &Policy::ramps, "Ramps that scale the authority. This is a copy: assign a whole list."_doc);
}

void bind_guidance_options_of_stage(nb::module_& m) {
  using guidance::Options;
  nb::class_<Options>(m, "GuidanceOptions", "Options of the stage `guidance`.")
      .def(nb::init<>())
      .def_rw("force_rate", &Options::force_rate,
              "Largest rate of the force change that no motion causes, such as after a switch or an edit [N/s]."_doc)
      .def_rw("moment_rate", &Options::moment_rate,
              "Largest rate of the moment change that no motion causes [N m/s]."_doc)
      .def_rw("return_speed", &Options::return_speed,
              "Speed at which the goal leaves a region that has just become forbidden [m/s]."_doc)
      .def_rw("reserve", &Options::reserve,
              "Distance that hard fixtures keep between the goal and their boundary [m]."_doc)
      .def_prop_rw(
          "servo_bandwidth", [](const Options& o) { return o.servo.bandwidth; },
          [](Options& o, double x) { o.servo.bandwidth = x; },
          "Bandwidth of the follower's servos [Hz]; 0: ideal; negative: that of the simulated follower.")
      .def_prop_rw(
          "servo_damping", [](const Options& o) { return o.servo.damping_ratio; },
          [](Options& o, double x) { o.servo.damping_ratio = x; }, "Damping ratio of the follower's servos [-].");
}

}  // namespace

void bind_guidance_interface(nb::module_& m) {
  m.attr("CONE_HALF_ANGLE") = guidance::kConeHalfAngle;
  bind_frames(m);
  bind_guidance_options(m);
  bind_guidance_options_of_stage(m);
  nb::class_<guidance::FixtureList>(m, "FixtureList", "Fixtures as a loop takes them; this base class has none.")
      .def(nb::init<std::shared_ptr<scene::LiveFrame>>(), "tool"_a.none() = nb::none(),
           "tool: a frame that receives the tool's pose at every tick.")
      .def("__len__", [](const guidance::FixtureList&) { return 0; });
}

}  // namespace palpate::bindings
