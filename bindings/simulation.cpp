#include "palpate/loop/simulation.hpp"

#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "bindings.hpp"
#include "convert.hpp"
#include "doc.hpp"
#include "front.hpp"
#include "palpate/loop/device_cycle.hpp"
#include "timing.hpp"
#include "types.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using loop::Cycle;
using loop::CycleOptions;
using loop::HandPath;
using loop::Simulation;
using loop::SimulationOptions;
using loop::Tick;

Table run(Simulation& self, std::size_t n_ticks, const std::optional<Rows3>& hand_W) {
  std::vector<Vec3> offsets;
  if (hand_W) {
    if (static_cast<std::size_t>(hand_W->rows()) != n_ticks || !hand_W->allFinite()) {
      throw std::invalid_argument("hand_W must have shape (" + std::to_string(n_ticks) +
                                  ", 3), a finite point for each tick; got shape (" + std::to_string(hand_W->rows()) +
                                  ", 3)");
    }
    for (Eigen::Index i = 0; i < hand_W->rows(); ++i) offsets.emplace_back(hand_W->row(i));
  }
  std::vector<Tick> ticks(n_ticks);
  {
    nb::gil_scoped_release release;
    ticks.resize(self.run(n_ticks, ticks.data(), hand_W ? offsets.data() : nullptr));
  }
  return to_rows(std::move(ticks));
}

std::uint64_t execute(Simulation& self, const Eigen::MatrixXd& q, const Eigen::MatrixXd& v, double dt,
                      const Eigen::VectorXd& levers, double pace, double until, double guard) {
  loop::PlannedMotion motion;
  motion.dt = dt;
  motion.q = q.transpose();
  motion.v = v.transpose();
  motion.levers = joint_vector(levers, "levers");
  return self.front().execute(std::move(motion), {0, pace, until, false, guard});
}

void order(Simulation& self, std::uint64_t motion, double pace, double until, bool stop, double guard) {
  self.front().set_order({motion, pace, until, stop, guard});
}

/// Lockstep of several simulations in one world: every tick is computed for all of them, from the instruments as they
/// were before it. Ends early while one of them is paused.
std::vector<Table> run_in_turns(const std::vector<Simulation*>& pairs, std::size_t n_ticks) {
  std::vector<std::vector<Tick>> ticks(pairs.size(), std::vector<Tick>(n_ticks));
  std::size_t done = 0;
  {
    nb::gil_scoped_release release;
    const auto is_paused = [](const Simulation* pair) { return pair->paused(); };
    while (done < n_ticks && std::none_of(pairs.begin(), pairs.end(), is_paused)) {
      for (std::size_t i = 0; i < pairs.size(); ++i) pairs[i]->run(1, &ticks[i][done]);
      for (Simulation* pair : pairs) pair->publish();
      if (loop::Bodies* bodies = pairs.front()->shared_bodies()) bodies->advance(1.0 / pairs.front()->options().rate);
      ++done;
    }
  }
  std::vector<Table> rows;
  for (std::vector<Tick>& one : ticks) {
    one.resize(done);
    rows.push_back(to_rows(std::move(one)));
  }
  return rows;
}

Fields timing(const Simulation& self) {
  Fields d = punctuality(self.thread());
  d["cycle_us"] = percentiles(self.cycle_time());
  d["ticks"] = self.cycle_time().count();
  if (const loop::StageClock* clock = self.stages()) {
    nb::dict stages;
    for (std::size_t i = 0; i < loop::kStageNames.size(); ++i) {
      stages[loop::kStageNames[i]] = percentiles(clock->time(i));
    }
    d["stages"] = stages;
  }
  return d;
}

HandPath hand_path(std::vector<double> times, const Rows3& p, std::vector<double> grippers,
                   std::vector<double> grip_times) {
  std::vector<Vec3> positions;
  positions.reserve(static_cast<std::size_t>(p.rows()));
  for (Eigen::Index i = 0; i < p.rows(); ++i) {
    positions.emplace_back(p.row(i));
  }
  return {std::move(times), std::move(positions), std::move(grippers), std::move(grip_times)};
}

template <typename Class, typename Struct>
void pose_field(Class& c, const char* name, Pose Struct::* field, const char* doc) {
  using Bound = typename Class::Type;  // may be a class derived from Struct
  c.def_prop_rw(
      name, [field](const Bound& s) { return to_matrix(s.*field); },
      [field, name](Bound& s, const Matrix4& m) { s.*field = to_pose(m, name); }, doc);
}

constexpr std::array kForceSources = {"contact", "estimate", "both"};  // in the order of force::Source

std::string source_name(const CycleOptions& o) { return kForceSources[static_cast<std::size_t>(o.source)]; }

void set_source(CycleOptions& o, const std::string& name) {
  const auto* at = std::find(kForceSources.begin(), kForceSources.end(), name);
  if (at == kForceSources.end()) {
    throw std::invalid_argument("force source must be 'contact', 'estimate' or 'both'; got '" + name + "'");
  }
  o.source = static_cast<force::Source>(at - kForceSources.begin());
}

void bind_simulation_options(nb::module_& m) {
  nb::class_<CycleOptions> cycle(m, "CycleOptions", "Options of the haptic cycle and its stages.");
  cycle.def(nb::init<>())
      .def_rw("rate", &CycleOptions::rate, "Rate of the haptic cycle [Hz]."_doc)
      .def_rw("method", &CycleOptions::method, "Name of the contact method."_doc)
      .def_rw("contact", &CycleOptions::contact, "Options of the stage `contact`."_doc)
      .def_rw("mapping", &CycleOptions::mapping, "Options of the stage `mapping`."_doc)
      .def_rw("guidance", &CycleOptions::guidance, "Options of the stage `guidance`."_doc)
      .def_prop_rw("source", &source_name, &set_source, "Source of the force: 'contact', 'estimate' or 'both'.")
      .def_rw("estimate", &CycleOptions::estimate, "Options of the force estimate."_doc)
      .def_rw("stability", &CycleOptions::stability, "Options of the stage `stability`."_doc)
      .def_rw("torque", &CycleOptions::torque, "Options of the stage `torque`."_doc);
  pose_field(cycle, "X_WL", &CycleOptions::X_WL, "Pose of the leader base in the world (4, 4).");
  pose_field(cycle, "X_WB", &CycleOptions::X_WB, "Pose of the follower base in the world (4, 4).");

  nb::class_<SimulationOptions, CycleOptions> simulation(
      m, "SimulationOptions", "Options of the haptic cycle and of the simulated devices around it.");
  simulation.def(nb::init<>())
      .def_rw("plant_rate", &SimulationOptions::plant_rate, "Smallest rate of the simulated servos [Hz]."_doc)
      .def_rw("loop_delay", &SimulationOptions::loop_delay,
              "Delay from the command to the torque, of the force term only [s]."_doc)
      .def_rw("loop_jitter", &SimulationOptions::loop_jitter,
              "Additional random delay of each command, uniform in 0..loop_jitter [s]."_doc)
      .def_rw("seed", &SimulationOptions::seed,
              "Seed of the hand's tremor, of the load cell's noise and of the jitter."_doc)
      .def_rw("tremor", &SimulationOptions::tremor, "Tremor of the hand at 8-12 Hz, rms per axis [m]."_doc)
      .def_rw("leader", &SimulationOptions::leader, "Parameters of the simulated leader."_doc)
      .def_rw("hand", &SimulationOptions::hand, "Impedance of the simulated hand."_doc)
      .def_rw("follower", &SimulationOptions::follower, "Parameters of the simulated follower."_doc)
      .def_rw("realtime", &SimulationOptions::realtime, "Options of the real-time thread."_doc);
  joint_field(simulation, "q_leader0", &SimulationOptions::q_leader0,
              "Initial joint positions of the leader (n,) [rad].");
  joint_field(simulation, "q_follower0", &SimulationOptions::q_follower0,
              "Initial joint positions of the follower (n,) [rad, m].");
}

void bind_haptic_cycle(nb::module_& m) {
  nb::class_<Cycle>(m, "Cycle", "The haptic cycle, from measured states to commanded torques.")
      .def(nb::init<const CycleOptions&, arm::Arm, arm::Arm>(), "options"_a, "leader_model"_a, "follower"_a,
           "leader_model: the controller's model of the leader; follower: the model of the follower.")
      .def(
          "step",
          [](Cycle& self, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& v, double gripper,
             const Eigen::VectorXd& q_follower, double jaw, const scene::Snapshot& scene, const Controls& controls,
             std::optional<double> t_leader, std::optional<double> t_follower, bool leader_valid, bool follower_valid,
             const std::optional<Vec3>& F_cell_L, const std::optional<Eigen::VectorXd>& v_follower,
             const std::optional<Eigen::VectorXd>& tau_follower) -> Tuple<Array, Eigen::VectorXd, double> {
            loop::CycleInput in;
            in.t = t;
            in.leader = {t_leader.value_or(t), joint_vector(q, "q"), joint_vector(v, "v"), gripper, leader_valid};
            in.leader.has_load_cell = F_cell_L.has_value();
            in.leader.F_cell_L = F_cell_L.value_or(Vec3::Zero());
            in.follower = {t_follower.value_or(t), joint_vector(q_follower, "q_follower"), jaw, follower_valid, {}, {}};
            if (v_follower) in.follower.v = joint_vector(*v_follower, "v_follower");
            if (tau_follower) in.follower.tau = joint_vector(*tau_follower, "tau_follower");
            in.controls = controls;
            in.scene = &scene;
            const loop::CycleOutput& out = self.step(in);
            const FollowerCommand& f = out.follower;
            return nb::make_tuple(to_row(out.tick), f.valid ? Eigen::VectorXd(f.q) : Eigen::VectorXd(), f.jaw);
          },
          "t"_a, "q"_a, "v"_a, "gripper"_a, "q_follower"_a, "jaw"_a, "scene"_a, "controls"_a = Controls{},
          "t_leader"_a = nb::none(), "t_follower"_a = nb::none(), "leader_valid"_a = true, "follower_valid"_a = true,
          "F_cell_L"_a = nb::none(), "v_follower"_a = nb::none(), "tau_follower"_a = nb::none(),
          "One tick at t [s]: (row of signals, commanded joint positions of the follower (n,) [rad, m], empty for no "
          "command, commanded jaw angle [rad]). The stamps t_leader and t_follower default to t.");
}

void bind_running(nb::module_& m) {
  nb::class_<HandPath>(
      m, "HandPath",
      "Intended tool path in W through way points; the hand rests only at the ends and where it reverses.")
      .def(
          "__init__",
          [](HandPath* self, std::vector<double> times, const Rows3& positions_W,
             const std::optional<std::vector<double>>& grippers, const std::optional<std::vector<double>>& grip_times) {
            new (self) HandPath(hand_path(std::move(times), positions_W, grippers.value_or(std::vector<double>{}),
                                          grip_times.value_or(std::vector<double>{})));
          },
          "times"_a, "positions_W"_a, "grippers"_a = nb::none(), "grip_times"_a = nb::none(),
          "times (n,) [s], positions_W (n, 3) [m], grippers (m,) [rad] or None, grip_times (m,) [s]; None: times.")
      .def(
          "at",
          [](const HandPath& self, double t) {
            HandPath::Cursor cursor;
            const HandPath::Point point = self.at(t, cursor);
            return std::make_tuple(point.p, point.v, point.gripper);
          },
          "t"_a, "(position (3,) [m], velocity (3,) [m/s], gripper angle [rad]) at t [s].");

  nb::class_<loop::RemoteEnd>(m, "RemoteEnd", "The operator's end of a link, for Simulation.attach().");
  nb::class_<Simulation> simulation(m, "Simulation",
                                    "A simulation of hand, leader and follower around the haptic cycle.");
  bind_front(simulation);
  bind_together(simulation);
  simulation
      .def(nb::init<const SimulationOptions&, arm::Arm, arm::Arm, const arm::Arm&,
                    std::shared_ptr<const scene::Snapshot>, HandPath>(),
           "options"_a, "leader_plant"_a, "leader_model"_a, "follower"_a, "snapshot"_a, "hand_path"_a,
           "leader_plant: the simulated leader; leader_model: the controller's model of the leader.")
      .def("run", &run, "n_ticks"_a, "hand_W"_a = nb::none(),
           "Runs n_ticks in lockstep and returns their rows (n, TICK_BYTES/8); fewer rows while paused. hand_W "
           "(n_ticks, 3): offset of the hand from its path at the end of each tick, in W [m]. An operator model may "
           "run a few ticks, look at the rows and choose the next offsets.")
      .def("start", &Simulation::start, nb::call_guard<nb::gil_scoped_release>(),
           "Starts the loop in real time, in its own thread.")
      .def("stop", &Simulation::stop, nb::call_guard<nb::gil_scoped_release>(),
           "Ramps the force to zero and ends the thread.")
      .def_prop_ro("running", &Simulation::running, "True while the real-time thread runs.")
      .def("execute", &execute, "q"_a, "v"_a, "dt"_a, "levers"_a, "pace"_a = 1.0, "until"_a = 0.0, "guard"_a = 1.0,
           "Gives the follower a planned motion: positions q (K, n) [rad, m] and velocities v (K, n) at equal times dt "
           "[s]; levers (n,): motion of the tip per motion of each joint. Returns its number. See order().")
      .def("order", &order, "motion"_a, "pace"_a, "until"_a, "stop"_a = false, "guard"_a = 1.0,
           "Orders about the motion of this number: pace 0..1, the time until which it is known to be free [s], stop "
           "for good, and the contact force that stops it [N].")
      .def("attach", &Simulation::attach, "remote"_a.none(),
           "Lets the hand feel what this end of a link renders; None: the objects of the loop.")
      .def("watch_stages", &Simulation::watch_stages,
           "Measures each stage of the cycle from now on; timing()['stages'][name] has p50, p99, p999 and max [us].")
      .def("stall", &Simulation::stall, "seconds"_a,
           "For tests of isolation: the real-time loop sleeps once in its next tick [s].")
      .def("timing", &timing,
           "Timing so far: cycle_us and lateness_us {p50, p99, p999, max}, slack_us {p50, p01, p001}, ticks, "
           "missed_ticks, scheduler.")
      .def(
          "fault",
          [](Simulation& self) {
            std::string words = self.fault();
            return words.empty() ? std::optional<std::string>{} : std::optional(std::move(words));
          },
          "Description of the first fault, with the last states; None without a fault.");
}

}  // namespace

void bind_simulation(nb::module_& m) {
  nb::class_<loop::RodOptions> rod(m, "RodOptions",
                                   "A rigid rod that jaws can hold and hand over; see held_object.hpp.");
  rod.def(nb::init<>())
      .def_rw("a", &loop::RodOptions::a, "One end of the axis in O (3,) [m]."_doc)
      .def_rw("b", &loop::RodOptions::b, "Its other end (3,) [m]."_doc)
      .def_rw("radius", &loop::RodOptions::radius, "Radius [m]; 0: there is no rod."_doc)
      .def_rw("stiffness", &loop::RodOptions::stiffness, "Stiffness of the spring between two grips [N/m]."_doc)
      .def_rw("hold", &loop::RodOptions::hold, "Largest force of this spring [N]."_doc);
  pose_field(rod, "X_WO", &loop::RodOptions::X_WO, "Pose in W at the start (4, 4).");
  nb::class_<loop::ToolCapsule>(m, "ToolCapsule", "A capsule of an instrument, between two points of its links.")
      .def(
          "__init__",
          [](loop::ToolCapsule* self, const contact::ToolSphere& a, const contact::ToolSphere& b, double radius) {
            if (!(radius > 0.0 && radius <= 0.1)) {
              throw std::invalid_argument("a capsule's radius must be above 0 and at most 0.1 m");
            }
            new (self) loop::ToolCapsule{a, b, radius};
          },
          "a"_a, "b"_a, "radius"_a, "a, b: ends of its axis; radius [m].");
  nb::class_<loop::Board>(m, "Board", "The world in which the instruments of several loops meet.")
      .def(nb::init<int, const loop::RodOptions&>(), "instruments"_a, "rod"_a = loop::RodOptions());
  bind_simulation_options(m);
  bind_haptic_cycle(m);
  bind_running(m);
  m.attr("MAX_INSTRUMENTS") = loop::kMaxInstruments;
  m.attr("MAX_CAPSULES") = contact::kMaxCapsules;
  m.def("run_in_turns", &run_in_turns, "simulations"_a, "n_ticks"_a,
        "Runs several simulations in lockstep, tick by tick, in this thread; returns the rows of each.");
  m.def(
      "nearest_points",
      [](const Vec3& p0, const Vec3& p1, const Vec3& q0, const Vec3& q1) {
        const contact::NearestPoints near = contact::nearest_points(p0, p1, q0, q1);
        return std::make_tuple(near.p, near.q);
      },
      "p0"_a, "p1"_a, "q0"_a, "q1"_a, "Nearest points (3,) [m] of the segments p0-p1 and q0-q1.");
}

}  // namespace palpate::bindings
