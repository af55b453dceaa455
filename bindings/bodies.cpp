// Rigid bodies beside the loops: pointers into the arrays of an engine, which Python owns.
#include "palpate/loop/bodies.hpp"

#include <nanobind/ndarray.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <cstdint>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "bindings.hpp"
#include "convert.hpp"
#include "doc.hpp"
#include "palpate/loop/simulation.hpp"
#include "palpate/types/index.hpp"
#include "timing.hpp"
#include "types.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using loop::Bodies;
using loop::BodiesOptions;
using loop::BodyStates;
using loop::EngineBody;
using loop::EngineTool;
using loop::MovingBody;

/// The engine's array, which must have n numbers and stay where it is.
using Numbers = nb::ndarray<double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

double* pointer(const Numbers& array, std::size_t n, const char* name) {
  if (array.shape(0) != n) {
    throw std::invalid_argument(std::string("bodies: ") + name + " must have " + std::to_string(n) + " numbers");
  }
  return array.data();
}

/// Keeps a Python object as long as the pointer is copied.
std::shared_ptr<void> kept(nb::object owner) {
  return {new nb::object(std::move(owner)), [](void* held) {
            if (!nb::is_alive()) return;
            const nb::gil_scoped_acquire lock;
            delete static_cast<nb::object*>(held);
          }};
}

EngineBody engine_body(const Numbers& pose, const Numbers& velocity, const Numbers& load, const Vec3& com) {
  return {pointer(pose, 7, "pose"), pointer(velocity, 6, "velocity"), pointer(load, 6, "load"), com};
}

Fields states_of(Bodies& self) {
  const BodyStates at = self.states();
  const std::size_t n = self.options().bodies.size(), tools = self.options().tools.size();
  Eigen::Matrix<double, Eigen::Dynamic, 7, Eigen::RowMajor> poses(n, 7);
  Eigen::VectorXi lost(n);
  Eigen::MatrixXd grip(tools, n);
  for (std::size_t k = 0; k < n; ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    for (std::size_t i = 0; i < 7; ++i) poses(row, static_cast<Eigen::Index>(i)) = at.pose[k][i];
    lost[row] = at.lost[k];
    for (std::size_t tool = 0; tool < tools; ++tool) {
      const auto& force = at.grip[tool * to_index(loop::kMaxBodies) + k];
      grip(static_cast<Eigen::Index>(tool), row) = std::min(force[0], force[1]);
    }
  }
  Fields d;
  d["t"] = at.t;
  d["poses"] = poses;
  d["lost"] = lost;
  d["grip"] = grip;
  d["delivered"] = at.delivered;
  d["restarts"] = at.restarts;
  d["silences"] = self.silences();
  return d;
}

}  // namespace

void bind_bodies(nb::module_& m) {
  nb::class_<EngineBody>(m, "EngineBody", "Arrays of a free body inside an engine.")
      .def(
          "__init__",
          [](EngineBody* self, const Numbers& pose, const Numbers& velocity, const Numbers& load, const Vec3& com) {
            new (self) EngineBody(engine_body(pose, velocity, load, com));
          },
          "pose"_a, "velocity"_a, "load"_a, "com"_a,
          "pose (7,): position [m], quaternion w x y z, in W; velocity (6,): linear in W [m/s], angular in the body "
          "[rad/s]; load (6,): force [N], torque [N m] at the centre of mass, in W; com (3,) in the body [m].");
  nb::class_<EngineTool>(m, "EngineTool", "A virtual tool inside an engine.")
      .def(
          "__init__",
          [](EngineTool* self, const EngineBody& body, const std::vector<Numbers>& jaws,
             const std::vector<double>& ratios, const std::vector<Numbers>& grips, std::size_t bodies) {
            if (jaws.size() != ratios.size() || jaws.size() > 2 || grips.size() != jaws.size()) {
              throw std::invalid_argument("bodies: a tool has at most two jaws, each with a ratio and a grip");
            }
            EngineTool made;
            made.body = body;
            for (std::size_t i = 0; i < jaws.size(); ++i) {
              made.jaw[i] = pointer(jaws[i], 1, "jaw");
              made.jaw_ratio[i] = ratios[i];
              made.grip[i] = pointer(grips[i], 4 * bodies, "grip");
            }
            new (self) EngineTool(made);
          },
          "body"_a, "jaws"_a, "ratios"_a, "grips"_a, "bodies"_a,
          "jaws: goal (1,) of each jaw's drive [rad]; ratios: goal per jaw angle; grips: (4 * bodies,) contact of each "
          "jaw with each body, found and force (3,) [N].")
      .def(
          "add_link",
          [](EngineTool& self, const EngineBody& body, int link, const std::vector<bool>& joints, double share_w) {
            if (link < 0 || joints.size() > 32 || !(share_w >= 0.0)) {
              throw std::invalid_argument(
                  "bodies: a link is one of the arm, which has at most 32 joints, and its share is at least 0");
            }
            loop::EngineLink made{body, link, 0, share_w};
            for (std::size_t j = 0; j < joints.size(); ++j) made.joints |= joints[j] ? 1u << j : 0u;
            self.links.push_back(made);
          },
          "body"_a, "link"_a, "joints"_a, "share_w"_a,
          "Adds its shaft or wrist: a body of its own, coupled to a link of the arm; joints: whether each joint moves "
          "this link; share_w: its stiffness and damping against rotation, over those of a tool [-].");
  nb::class_<MovingBody>(m, "MovingBody", "A body that moves, and the spheres with which it touches the objects.")
      .def(
          "__init__",
          [](MovingBody* self, const EngineBody& body, std::vector<contact::ToolSphere> spheres) {
            if (spheres.size() > to_index(contact::kMaxSpheres)) {
              throw std::invalid_argument("bodies: a body has at most " + std::to_string(contact::kMaxSpheres) +
                                          " contact spheres");
            }
            new (self) MovingBody{body, std::move(spheres)};
          },
          "body"_a, "spheres"_a, "spheres: in the body's frame; none: the body passes through the objects.");
  nb::class_<BodiesOptions>(m, "BodiesOptions", "Engine and coupling of the rigid bodies.")
      .def(nb::init<>())
      .def(
          "set_engine",
          [](BodiesOptions& self, std::uintptr_t step, std::uintptr_t model, std::uintptr_t data,
             const std::vector<Numbers>& state, nb::object owner) {
            self.step = reinterpret_cast<void (*)(const void*, void*)>(step);
            self.model = reinterpret_cast<const void*>(model);
            self.data = reinterpret_cast<void*>(data);
            self.state.clear();
            for (const Numbers& some : state) self.state.push_back({some.data(), some.shape(0)});
            self.owner = kept(std::move(owner));
          },
          "step"_a, "model"_a, "data"_a, "state"_a, "owner"_a,
          "Addresses of the function step(model, data) and of its arguments; the arrays of the state, which return to "
          "their first values when one is not finite; the object that owns all this memory.")
      .def_rw("period", &BodiesOptions::period, "Step of the engine [s]."_doc)
      .def_rw("stiffness", &BodiesOptions::stiffness, "Stiffness of the coupling [N/m]."_doc)
      .def_rw("damping", &BodiesOptions::damping, "Damping of the coupling [N s/m]."_doc)
      .def_rw("stiffness_w", &BodiesOptions::stiffness_w, "Stiffness against rotation [N m/rad]."_doc)
      .def_rw("damping_w", &BodiesOptions::damping_w, "Damping against rotation [N m s/rad]."_doc)
      .def_rw("force_max", &BodiesOptions::force_max, "Largest force of the coupling's spring [N]."_doc)
      .def_rw("release", &BodiesOptions::release, "Distance at which a stuck virtual tool is put back [m]."_doc)
      .def_rw("low", &BodiesOptions::low, "Lowest corner of the field (3,) in W [m]."_doc)
      .def_rw("high", &BodiesOptions::high, "Highest corner of the field (3,) in W [m]."_doc)
      .def_rw("tools", &BodiesOptions::tools, "The virtual tools; assign the whole list."_doc)
      .def_rw("bodies", &BodiesOptions::bodies, "The bodies that move; assign the whole list."_doc);
  nb::class_<Bodies>(m, "Bodies", "Rigid bodies beside the loops: see bodies.hpp.")
      .def(nb::init<BodiesOptions, std::shared_ptr<const scene::Snapshot>>(), "options"_a, "snapshot"_a)
      .def("advance", &Bodies::advance, "dt"_a, "Lockstep: advances the engine by dt [s].")
      .def(
          "drive",
          [](Bodies& self, int tool, const Matrix4& X_WT, double jaw) {
            if (tool < 0 || to_index(tool) >= self.options().tools.size()) {
              throw std::invalid_argument("bodies: there is no tool " + std::to_string(tool));
            }
            const loop::ToolMotion motion{to_pose(X_WT, "X_WT"), Twist{}, jaw, true};
            self.write(tool, motion);
            const Wrench F = loop::coupling_wrench(self.options(), motion, self.read(tool));
            return std::make_tuple(F.f, F.t);
          },
          "tool"_a, "X_WT"_a, "jaw"_a,
          "For a tool without a loop: sets its pose (4, 4) and jaw angle [rad]; returns force (3,) [N] and torque (3,) "
          "[N m] of the coupling on it.")
      .def("start", &Bodies::start, nb::call_guard<nb::gil_scoped_release>(), "Steps the engine in a thread.")
      .def("stop", &Bodies::stop, nb::call_guard<nb::gil_scoped_release>(), "Ends the thread.")
      .def_prop_ro("running", &Bodies::running, "True while the thread runs.")
      .def("states", &states_of,
           "Newest states: t [s], poses (n, 7), lost (n,), grip (tools, n): force of the weaker jaw on each body [N], "
           "delivered: energy given to the engine by the couplings [J], restarts: how often its state was not finite, "
           "silences: how often a tool felt nothing since it stood still.")
      .def(
          "step_time", [](const Bodies& self) { return percentiles(self.step_time()); },
          "Compute time of the engine's steps [us]: p50, p99, p999, max.");
  m.attr("BODY_VELOCITY_DELAY") = loop::kVelocityDelay;
  m.attr("MAX_BODIES") = loop::kMaxBodies;
  m.attr("MAX_BODY_LINKS") = loop::kMaxBodyLinks;
}

}  // namespace palpate::bindings
