#include "dvrk/trajectory.hpp"

#include "convert.hpp"
#include "dvrk/bindings.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {

void bind_trajectory(nb::module_& m) {
  using dvrk::Trajectory;
  using Vector = Eigen::VectorXd;
  nb::class_<Trajectory>(m, "Trajectory", "Point-to-point motion of joints that start and come to rest together.")
      .def(nb::init<>())
      .def(
          "start",
          [](Trajectory& t, const Vector& q, const Vector& v, const Vector& goal, const Vector& v_max,
             const Vector& a_max) {
            const Eigen::Index n = q.size();
            t.start(joint_vector(q, "q"), joint_vector(v, "v", n), joint_vector(goal, "goal", n),
                    joint_vector(v_max, "v_max", n), joint_vector(a_max, "a_max", n));
          },
          "q"_a, "v"_a, "goal"_a, "v_max"_a, "a_max"_a,
          "Plans from (q, v) to rest at goal within v_max and a_max; all (n,) [rad, m, s].")
      .def("step", &Trajectory::step, "dt"_a, "Advances by dt [s].")
      .def_prop_ro(
          "q", [](const Trajectory& t) -> Vector { return t.q(); }, "Joint positions (n,) [rad, m].")
      .def_prop_ro(
          "v", [](const Trajectory& t) -> Vector { return t.v(); }, "Joint velocities (n,) [rad/s, m/s].")
      .def_prop_ro("done", &Trajectory::done, "True once the joints rest at the goal.")
      .def_prop_ro("duration", &Trajectory::duration, "Duration of the whole motion [s].");
}

}  // namespace palpate::bindings
