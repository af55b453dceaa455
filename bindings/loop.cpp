#include <nanobind/eigen/dense.h>
#include <nanobind/stl/string.h>

#include <memory>

#include "bindings.hpp"
#include "convert.hpp"
#include "palpate/arm/all_terms.hpp"
#include "palpate/loop/realtime.hpp"
#include "palpate/loop/tick.hpp"
#include "palpate/types/arms.hpp"
#include "timing.hpp"
#include "types.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using loop::Tick;

void bind_table(nb::module_& m) {
  m.attr("TICK_BYTES") = sizeof(Tick);
  m.def(
      "signals",
      [] {
        using Row = Tuple<nb::str, int, int, nb::str, nb::str, nb::str, bool, nb::str>;
        nb::typed<nb::list, Row> rows;
        for (const loop::Signal& s : loop::signals()) {
          rows.append(nb::make_tuple(s.name, s.offset, s.size, s.unit, s.frame, s.doc, s.deterministic, s.stage));
        }
        return rows;
      },
      "The table of signals: (name, byte offset, doubles, unit, frame, doc, deterministic, stage) per row.");
  m.def(
      "status_words",
      [] {
        nb::typed<nb::list, Tuple<nb::str, int, nb::str>> rows;
        for (const StatusWords& s : status_words()) {
          rows.append(nb::make_tuple(s.name, s.bit, s.words));
        }
        return rows;
      },
      "The bits of the signal `status`, the gravest first: (name, bit, words) per row.");
}

void bind_controls(nb::module_& m) {
  nb::class_<Controls>(m, "Controls", "What a person may change while it runs.")
      .def(nb::init<>())
      .def_rw("following", &Controls::following, "the tool follows the hand, the hand is given forces")
      .def_rw("clutch", &Controls::clutch, "pedal pressed: the hand moves freely, the tool stays")
      .def_rw("paused", &Controls::paused, "simulated time stands still")
      .def_rw("hold", &Controls::hold, "the simulated hand waits where its path is")
      .def_rw("stiffness_scale", &Controls::stiffness_scale, "times every object's stiffness")
      .def_rw("damping_scale", &Controls::damping_scale, "times every object's damping")
      .def_rw("guidance", &Controls::guidance, "pedal of guidance, 0-1, for fixtures that fade with it")
      .def_rw("p_hand_offset_W", &Controls::p_hand_offset_W, "added to the hand's intended position, (3,) [m]");
}

/// The control of a cycle's compute time: Pinocchio's computeAllTerms of both arms and nothing else.
class BareDynamics {
 public:
  BareDynamics(arm::AllTerms& leader, arm::AllTerms& follower) : leader_(leader), follower_(follower) {}

  void run(const Eigen::MatrixXd& q_leader, const Eigen::MatrixXd& v_leader, const Eigen::MatrixXd& q_follower) {
    if (q_leader.rows() != leader_.n() || v_leader.rows() != leader_.n() || q_follower.rows() != follower_.n() ||
        v_leader.cols() != q_leader.cols() || q_follower.cols() != q_leader.cols()) {
      throw std::invalid_argument("q_leader, v_leader and q_follower need a row per joint and a column per tick");
    }
    const Eigen::VectorXd at_rest = Eigen::VectorXd::Zero(follower_.n());
    Eigen::VectorXd q, v, q_f;
    for (Eigen::Index i = 0; i < q_leader.cols(); ++i) {
      q = q_leader.col(i);
      v = v_leader.col(i);
      q_f = q_follower.col(i);
      const std::int64_t begin = loop::now_ns();
      leader_.compute(q, v);
      follower_.compute(q_f, at_rest);
      time_->add(loop::now_ns() - begin);
    }
  }
  [[nodiscard]] const loop::Histogram& time() const { return *time_; }

 private:
  arm::AllTerms& leader_;
  arm::AllTerms& follower_;
  std::unique_ptr<loop::Histogram> time_ = std::make_unique<loop::Histogram>();
};

void bind_control(nb::module_& m) {
  nb::class_<BareDynamics>(m, "BareDynamics", "Times Pinocchio's computeAllTerms of both arms, once a column.")
      .def(nb::init<arm::AllTerms&, arm::AllTerms&>(), "leader"_a, "follower"_a, nb::keep_alive<1, 2>(),
           nb::keep_alive<1, 3>())
      .def("run", &BareDynamics::run, "q_leader"_a, "v_leader"_a, "q_follower"_a,
           "A column per tick: (n, k), (n, k) and (m, k) [rad, m; rad/s, m/s].")
      .def("timing", [](const BareDynamics& self) { return percentiles(self.time()); }, "p50, p99, p999, max [us].");
}

void bind_realtime(nb::module_& m) {
  using loop::BareLoop;
  using loop::RealTimeOptions;
  nb::class_<RealTimeOptions>(m, "RealTimeOptions", "What the real-time thread may ask of the system.")
      .def(nb::init<>())
      .def_rw("allow_priority", &RealTimeOptions::allow_priority, "SCHED_FIFO and locked memory")
      .def_rw("allow_affinity", &RealTimeOptions::allow_affinity, "one core for the loop")
      .def_rw("priority", &RealTimeOptions::priority, "of SCHED_FIFO, 1..99")
      .def_rw("spin_us", &RealTimeOptions::spin_us, "last stretch before a deadline awaited awake [us]");

  nb::class_<BareLoop>(m, "BareLoop", "A loop that only keeps time: what the machine itself can do.")
      .def(nb::init<double, loop::RealTimeOptions>(), "rate"_a, "options"_a = loop::RealTimeOptions{})
      .def("start", &BareLoop::start, nb::call_guard<nb::gil_scoped_release>())
      .def("stop", &BareLoop::stop, nb::call_guard<nb::gil_scoped_release>())
      .def(
          "timing", [](const BareLoop& self) { return punctuality(self.thread()); },
          "lateness_us, slack_us, ticks, missed_ticks, scheduler.");
}

}  // namespace

void bind_loop(nb::module_& m) {
  bind_table(m);
  bind_controls(m);
  bind_realtime(m);
  bind_control(m);
}

}  // namespace palpate::bindings
