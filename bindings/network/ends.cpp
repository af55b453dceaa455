#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>

#include "convert.hpp"
#include "doc.hpp"
#include "network/bindings.hpp"
#include "palpate/network/instrument.hpp"
#include "palpate/network/operator.hpp"
#include "palpate/network/site.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using network::Datagram;
using network::EndOptions;
using network::Estimator;
using network::EstimatorOptions;
using network::Instrument;
using network::InstrumentOptions;
using network::LocalModel;
using network::Mode;
using network::ModelUpdate;
using network::Operator;
using network::OperatorOptions;
using network::Peer;
using network::Site;
using network::SiteGoal;
using network::SiteInput;
using network::SiteOptions;
using network::UpdateOptions;

void bind_options(nb::module_& m) {
  nb::enum_<Mode>(m, "Mode", "What crosses the network between hand and remote tool.")
      .value("model", Mode::model, "Parameters of a local model.")
      .value("passivity", Mode::passivity, "The measured force, as far as the energies of both ports allow.")
      .value("direct", Mode::direct, "The measured force, without any limit.");
  nb::class_<EstimatorOptions>(m, "EstimatorOptions", "What the estimator assumes before the first touch.")
      .def(nb::init<>())
      .def_rw("K", &EstimatorOptions::K, "Assumed stiffness [N/m]."_doc)
      .def_rw("sd_K", &EstimatorOptions::sd_K, "Its standard deviation [N/m]."_doc)
      .def_rw("sd_place", &EstimatorOptions::sd_place, "Standard deviation of the place along each axis [m]."_doc)
      .def_rw("sd_force", &EstimatorOptions::sd_force, "Noise of the measured force [N]."_doc)
      .def_rw("sd_model", &EstimatorOptions::sd_model, "Error of the linear law, share of the force [-]."_doc)
      .def_rw("most_shift", &EstimatorOptions::most_shift, "Largest displacement that is believed [m]."_doc);
  nb::class_<UpdateOptions>(m, "UpdateOptions", "Limits of updates of the local model.")
      .def(nb::init<>())
      .def_rw("tank", &UpdateOptions::tank, "Energy in the tank at the start [J]."_doc)
      .def_rw("capacity", &UpdateOptions::capacity, "Most energy that the tank keeps [J]."_doc)
      .def_rw("force_rate", &UpdateOptions::force_rate, "Largest change of the force by an update [N/s]."_doc)
      .def_rw("speed", &UpdateOptions::speed, "Largest speed of a surface that is updated [m/s]."_doc)
      .def_rw("least_sure", &UpdateOptions::least_sure, "Largest relative deviation of a stiffness taken [-]."_doc);
  nb::class_<EndOptions>(m, "EndOptions", "What both ends have alike.")
      .def_rw("mode", &EndOptions::mode, "Mode."_doc)
      .def_rw("radius", &EndOptions::radius, "Radius of the tool's sphere [m]."_doc)
      .def_rw("planes", &EndOptions::planes, "Surfaces that the scene does not have are felt as planes."_doc)
      .def_rw("drag", &EndOptions::drag, "Damping of the hand in the mode passivity [N s/m]."_doc);
  nb::class_<SiteOptions, EndOptions>(m, "SiteOptions", "Options of the follower's end.")
      .def(nb::init<>())
      .def_rw("force_cap", &SiteOptions::force_cap, "Largest force on the tissue [N]."_doc)
      .def_rw("mass", &SiteOptions::mass, "Of the tool [kg]."_doc)
      .def_rw("speed", &SiteOptions::speed, "Largest speed of the tool's goal [m/s]."_doc)
      .def_rw("catch_up", &SiteOptions::catch_up, "The same while the tool aligns [m/s]."_doc)
      .def_rw("turn", &SiteOptions::turn, "Largest angular speed of the goal, and of the jaw [rad/s]."_doc)
      .def_rw("allowance", &SiteOptions::allowance, "Energy that may be spent in advance [J]."_doc)
      .def_rw("estimator", &SiteOptions::estimator, "Options of the estimator."_doc);
  nb::class_<InstrumentOptions>(m, "InstrumentOptions", "A simulated instrument.")
      .def(nb::init<>())
      .def_rw("mass", &InstrumentOptions::mass, "[kg]."_doc)
      .def_rw("bandwidth", &InstrumentOptions::bandwidth, "Natural frequency of its servo [Hz]."_doc)
      .def_rw("drive_cap", &InstrumentOptions::drive_cap, "Largest force of its drives [N]."_doc)
      .def_rw("noise", &InstrumentOptions::noise, "Standard deviation of the measured force [N]."_doc)
      .def_rw("quantum", &InstrumentOptions::quantum, "Resolution of the measured position [m]."_doc)
      .def_rw("substeps", &InstrumentOptions::substeps, "Per tick."_doc);
}

void bind_learning(nb::module_& m) {
  nb::class_<Estimator>(m, "Estimator", "Place, stiffness, damping and friction of a touched object.")
      .def(nb::init<const EstimatorOptions&>(), "options"_a)
      .def(
          "step",
          [](Estimator& self, double depth, const Vec3& normal, const Vec3& v, const Vec3& F) {
            self.step({depth, normal, v, F});
          },
          "depth"_a, "normal"_a, "v"_a, "F"_a,
          "One tick: depth below the surface of the scene [m], outward normal (3,), velocity relative to the surface "
          "(3,) [m/s], measured force (3,) [N].")
      .def_prop_ro("estimate", &Estimator::estimate, "The estimate.")
      .def_prop_ro("moved", &Estimator::moved, "Number of times that the object was found moved.");
  nb::class_<ModelUpdate>(m, "ModelUpdate", "Parameters that approach an estimate without kick and free energy.")
      .def(nb::init<const UpdateOptions&, const network::ModelEstimate&>(), "options"_a, "now"_a)
      .def(
          "step",
          [](ModelUpdate& self, const network::ModelEstimate& goal, double depth, const Vec3& normal, double dt,
             double dissipated) { return self.step(goal, {depth, normal, dissipated}, dt); },
          "goal"_a, "depth"_a, "normal"_a, "dt"_a = 1e-3, "dissipated"_a = 0.0,
          "One tick towards a goal with the tool at this depth [m] and outward normal (3,); the parameters to render.")
      .def_prop_ro("now", &ModelUpdate::now, "The parameters to render.")
      .def_prop_ro("tank", &ModelUpdate::tank, "Energy in the tank [J].")
      .def_prop_ro("paid", &ModelUpdate::paid, "Energy that updates have added to the springs [J].");
  nb::class_<LocalModel>(m, "LocalModel", "The objects of a scene with parameters that arrive over the network.")
      .def(nb::init<const UpdateOptions&, scene::Snapshot, bool>(), "options"_a, "scene"_a, "planes"_a = false)
      .def("take", &LocalModel::take, "estimate"_a, "Takes an estimate as the goal of its object.")
      .def("step", &LocalModel::step, "p"_a, "v"_a, "F"_a, "radius"_a, "t"_a, "dt"_a,
           "Updates for a tool with this radius at p (3,) [m] with velocity v (3,) [m/s] and contact force F (3,) [N], "
           "at the time t of the scene, dt after the last one [s].")
      .def("synchronise", &LocalModel::synchronise, "ahead"_a,
           "Moving objects are shown ahead of the time that step() is given, where the loop's clock is not the site's "
           "[s].")
      .def_prop_ro("scene", &LocalModel::scene, "The objects as they are rendered.")
      .def("rendered", &LocalModel::rendered, "i"_a, "The parameters of object i as they are rendered.")
      .def_prop_ro("updates", &LocalModel::updates, "The updates of all objects, in order.");
}

/// A copy of a scene, its objects displaced, with another stiffness unless it is 0.
scene::Snapshot displaced(scene::Snapshot scene, const Vec3& shift, double stiffness) {
  for (scene::Object& object : scene.objects) {
    object.X_WO.p += shift;
    if (stiffness > 0.0) object.material.K.setConstant(stiffness);
  }
  return scene;
}

/// A copy of a scene in which no tool feels the objects with these names.
scene::Snapshot concealed(scene::Snapshot scene, const std::vector<std::string>& names) {
  for (scene::Object& object : scene.objects) {
    if (std::find(names.begin(), names.end(), object.name) != names.end()) object.is_virtual = false;
  }
  return scene;
}

void bind_peer(nb::module_& m) {
  m.def("concealed", &concealed, "scene"_a, "names"_a,
        "A copy of a scene in which no tool feels the objects with these names.");
  m.def(
      "displaced", &displaced, "scene"_a, "shift"_a, "stiffness"_a = 0.0,
      "A copy of a scene with all objects displaced by shift (3,) [m], and with another stiffness [N/m]; 0: as it is.");
  nb::class_<network::Port>(m, "Port", "Work of a force on a measured position, taken and given apart.")
      .def(nb::init<>())
      .def("step", &network::Port::step, "F"_a, "x"_a, "One tick: force (3,) [N], position (3,) [m].")
      .def_prop_ro("taken", &network::Port::in, "Energy taken, without returns [J].")
      .def_prop_ro("given", &network::Port::out, "Energy given [J]: what was taken less the exact net.");
  nb::class_<Peer>(m, "Peer", "The other end: its clock, the ages of its packets, outages.")
      .def(nb::init<>())
      .def("receive", &Peer::receive, "datagram"_a, "now"_a,
           "A datagram that arrived at the own time `now` [s]; True if it is newer than all before.")
      .def("step", &Peer::step, "now"_a, "One tick at the own time [s].")
      .def("stamp", &Peer::stamp, "datagram"_a, "now"_a, "Fills in the times of a datagram that leaves now [s].")
      .def("peer_time", &Peer::peer_time, "now"_a, "The peer's time at the own time `now` [s].")
      .def_prop_ro("newest", &Peer::newest, "The newest datagram.")
      .def_prop_ro("known", &Peer::known, "True once a datagram has arrived.")
      .def_prop_ro("outage", &Peer::outage, "True while packets are missing.")
      .def_prop_ro("lost", &Peer::lost, "True once an outage has lasted, in either direction.")
      .def_prop_ro("clock", &Peer::clock, "The peer's clock.")
      .def_prop_ro("arrivals", &Peer::arrivals, "Ages of the newest packet.");
}

void bind_site(nb::module_& m) {
  nb::class_<SiteInput>(m, "SiteInput", "State of the tool at the site, in W.")
      .def(nb::init<>())
      .def_rw("t", &SiteInput::t, "Own clock, the time of the scene [s]."_doc)
      .def_prop_rw(
          "X", [](const SiteInput& s) -> Matrix4 { return to_matrix(s.X); },
          [](SiteInput& s, const Matrix4& X) { s.X = to_pose(X, "X"); }, "Measured pose (4, 4) [m]."_doc)
      .def_rw("v", &SiteInput::v, "Measured velocity (3,) [m/s]."_doc)
      .def_rw("jaw", &SiteInput::jaw, "[rad]."_doc)
      .def_rw("F", &SiteInput::F, "Measured force of the environment on the tool (3,) [N]."_doc);
  nb::class_<SiteGoal>(m, "SiteGoal", "What the tool shall do.")
      .def_prop_ro(
          "X", [](const SiteGoal& g) -> Matrix4 { return to_matrix(g.X); }, "Pose (4, 4) [m].")
      .def_ro("v", &SiteGoal::v, "Velocity (3,) [m/s]."_doc)
      .def_ro("jaw", &SiteGoal::jaw, "[rad]."_doc)
      .def_ro("flags", &SiteGoal::flags, "Bits FLAG_*."_doc);
  nb::class_<Site>(m, "Site", "The follower's end of a link.")
      .def(nb::init<const SiteOptions&, scene::Snapshot>(), "options"_a, "scene"_a)
      .def("receive", &Site::receive, "datagram"_a, "now"_a, "A datagram that arrived at the own time `now` [s].")
      .def("step", &Site::step, "state"_a, "dt"_a, "One tick, dt after the last one [s]; the goal of the tool.",
           nb::rv_policy::copy)
      .def("forget_operator", &Site::forget_operator, "A new operator comes; what was learnt is kept.")
      .def("rest", &Site::rest, "The tool was moved by others: the goal begins where it is measured next.")
      .def("send", &Site::send, "The datagram that leaves now.")
      .def_prop_ro("peer", &Site::peer, "The operator's end.")
      .def_prop_ro(
          "play_delay", [](const Site& s) { return s.playout().delay(); }, "Delay of the motion [s].")
      .def_prop_ro("account", &Site::account, "Energy that the tool may still spend [J].");
  nb::class_<Instrument>(m, "Instrument", "A simulated instrument that touches the objects of a scene.")
      .def(nb::init<const InstrumentOptions&, double, scene::Snapshot, std::uint64_t>(), "options"_a, "radius"_a,
           "world"_a, "seed"_a = 0)
      .def(
          "place", [](Instrument& self, const Vec3& p) { self.place({Mat3::Identity(), p}); }, "p"_a,
          "Places the tool at p (3,) [m], at rest.")
      .def("step", &Instrument::step, "goal"_a, "t"_a, "dt"_a, "One tick with this goal from the time t on [s].")
      .def("measure", &Instrument::measure, "t"_a, "What the sensors report at the time t [s].")
      .def_prop_ro("force", &Instrument::force, "True force of the tissue (3,) [N].")
      .def_prop_ro("x", &Instrument::x, "True position (3,) [m].")
      .def_prop_ro("largest", &Instrument::largest, "Largest force of the tissue so far [N].");
}

}  // namespace

void bind_ends(nb::module_& m) {
  bind_options(m);
  bind_learning(m);
  bind_peer(m);
  bind_site(m);
}

}  // namespace palpate::bindings
