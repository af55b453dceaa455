// Live objects: their options, their rate-limited motion, and the targets that a tracker sets.
#include <nanobind/eigen/dense.h>
#include <nanobind/stl/vector.h>

#include <cmath>
#include <string>
#include <vector>

#include "bindings.hpp"
#include "convert.hpp"
#include "doc.hpp"
#include "palpate/scene/approach.hpp"
#include "palpate/types/index.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using scene::Approach;
using scene::LiveOptions;

Twist to_twist(const Vec6& V, const char* name) {
  if (!V.allFinite()) throw std::invalid_argument(std::string(name) + " must be finite");
  return {V.head<3>(), V.tail<3>()};
}

LiveOptions options(double speed, double turn, double acceleration, double max_age, double fade, const Vec3& p_OC,
                    double gain) {
  for (const double x : {speed, turn, acceleration, max_age, gain})
    if (!(x > 0.0 && std::isfinite(x)))
      throw std::invalid_argument("live: speed, turn, acceleration, max_age and gain must be above 0, got " +
                                  std::to_string(x));
  if (!(fade >= 0.0 && std::isfinite(fade)) || !p_OC.allFinite())
    throw std::invalid_argument("live: fade must be 0 or more, and p_OC finite");
  return {speed, turn, acceleration, max_age, gain, fade, p_OC};
}

LiveTarget target(double t, const Matrix4& X_WO, const Vec6& V_WO, bool lost) {
  if (!std::isfinite(t)) throw std::invalid_argument("t must be finite, got " + std::to_string(t));
  return {t, to_pose(X_WO, "X_WO"), to_twist(V_WO, "V_WO"), lost};
}

void require_room(std::size_t n, const char* what) {
  if (n > to_index(kMaxLive))
    throw std::invalid_argument("live: " + std::to_string(n) + " " + what + ", at most " + std::to_string(kMaxLive));
}

void bind_targets(nb::module_& m) {
  nb::class_<LiveTargets>(m, "LiveTargets", "Poses that the live objects of a snapshot shall reach; tracked frames.")
      .def(nb::init<>())
      .def(
          "add",
          [](LiveTargets& self, double t, const Matrix4& X_WO, const Vec6& V_WO, bool lost) {
            require_room(to_index(self.objects) + 1, "objects");
            self.object[to_index(self.objects)] = target(t, X_WO, V_WO, lost);
            ++self.objects;
          },
          "t"_a, "X_WO"_a, "V_WO"_a = Vec6(Vec6::Zero()), "lost"_a = false,
          "Adds the target of the next live object: pose X_WO (4, 4) [m] at t [s], with the velocity V_WO (6,) of its "
          "origin and its angular velocity [m/s, rad/s]. lost: the pose is no longer trusted.")
      .def(
          "add_frame",
          [](LiveTargets& self, const Matrix4& X_WF, double t_seen, bool lost) {
            require_room(to_index(self.frames) + 1, "frames");
            self.frame[to_index(self.frames)] = {to_pose(X_WF, "X_WF"), t_seen, lost};
            ++self.frames;
          },
          "X_WF"_a, "t_seen"_a, "lost"_a,
          "Adds a tracked frame for the record: last good pose X_WF (4, 4) [m], its time [s], -inf if none was seen.");
  m.attr("MAX_LIVE") = kMaxLive;
}

}  // namespace

void bind_live(nb::module_& m) {
  const LiveOptions o;
  nb::class_<LiveOptions>(m, "LiveOptions", "Limits of the motion of an object whose pose is set live.")
      .def(
          "__init__",
          [](LiveOptions* self, double speed, double turn, double acceleration, double max_age, double fade,
             const Vec3& p_OC,
             double gain) { new (self) LiveOptions(options(speed, turn, acceleration, max_age, fade, p_OC, gain)); },
          "speed"_a = o.speed, "turn"_a = o.turn, "acceleration"_a = o.acceleration, "max_age"_a = o.max_age,
          "fade"_a = o.fade, "p_OC"_a = Vec3(Vec3::Zero()), "gain"_a = o.gain,
          "speed [m/s], turn [rad/s], acceleration [m/s^2]; max_age: age of the target above which it is lost [s]; "
          "fade: time in which the force of a lost object falls to zero [s]; p_OC: centre of rotation (3,) [m]; "
          "gain: speed per remaining displacement near the target [1/s].")
      .def_ro("speed", &LiveOptions::speed, "Largest speed of the centre [m/s]."_doc)
      .def_ro("max_age", &LiveOptions::max_age, "Age of the target above which it is lost [s]."_doc)
      .def_ro("fade", &LiveOptions::fade, "Time in which the force of a lost object falls to zero [s]."_doc);
  nb::class_<Approach>(m, "Approach", "Rate-limited motion of a live object towards its target.")
      .def(
          "__init__",
          [](Approach* self, const Matrix4& X_WO, double t) { (new (self) Approach)->reset(to_pose(X_WO, "X_WO"), t); },
          "X_WO"_a, "t"_a = 0.0, "At rest at X_WO (4, 4) [m] at the time t [s].")
      .def(
          "step",
          [](Approach& self, double t, const LiveOptions& limits, const Matrix4& X_WO, const Vec6& V_WO, bool lost,
             double t_target) { self.step(target(std::isnan(t_target) ? t : t_target, X_WO, V_WO, lost), limits, t); },
          "t"_a, "options"_a, "X_WO"_a, "V_WO"_a = Vec6(Vec6::Zero()), "lost"_a = false, "t_target"_a = NAN,
          "Moves to the time t [s] towards the pose X_WO (4, 4) [m], valid at t_target [s]; at t when left out.")
      .def_prop_ro(
          "X_WO", [](const Approach& self) { return to_matrix(self.X_WO()); }, "Pose (4, 4) [m].")
      .def_prop_ro(
          "v", [](const Approach& self) { return self.velocity().v; }, "Velocity of the centre (3,) [m/s].")
      .def_prop_ro(
          "w", [](const Approach& self) { return self.velocity().w; }, "Angular velocity (3,) [rad/s].")
      .def_prop_ro("lost", &Approach::lost, "True while the target is lost.")
      .def_prop_ro("share", &Approach::share, "Share of its stiffness that the object renders [-].");
  bind_targets(m);
}

}  // namespace palpate::bindings
