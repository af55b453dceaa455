#include "palpate/arm/arm.hpp"

#include <nanobind/ndarray.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bindings.hpp"
#include "convert.hpp"
#include "palpate/arm/all_terms.hpp"
#include "palpate/arm/serial.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using arm::Arm;
using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

JointVector joints(const Arm& a, const VectorArg& values, const char* name) {
  return joint_vector(values, name, a.n());
}

Matrix4 fk(Arm& a, const VectorArg& q) {
  a.update(joints(a, q, "q"), JointVector::Zero(a.n()));
  return to_matrix(a.tip());
}

Matrix jacobian(Arm& a, const VectorArg& q) {
  a.update(joints(a, q, "q"), JointVector::Zero(a.n()));
  return a.jacobian();
}

std::pair<Vector, arm::IkResult> ik_from(Arm& a, const Matrix4& X_0T, const VectorArg& q0,
                                         const arm::IkOptions& options) {
  JointVector q = joints(a, q0, "q0");
  const arm::IkResult result = a.ik(to_pose(X_0T, "X_0T"), q, options);
  return {Vector(q), result};
}

std::vector<Matrix4> link_poses(Arm& a, const VectorArg& q) {
  std::vector<Matrix4> poses;
  for (const Pose& X : a.link_poses(joints(a, q, "q"))) poses.push_back(to_matrix(X));
  return poses;
}

/// Phi of every pose, one below the other: (k, n, m) in C order.
nb::ndarray<nb::numpy, double, nb::ndim<3>> gravity_columns(Arm& a, const arm::GravityTerms& terms, const Matrix& q) {
  const Eigen::Index n = a.n(), m = terms.columns(n);
  if (q.cols() != n) {
    throw std::invalid_argument("q must have shape (k, " + std::to_string(n) + "), a row per pose; got (" +
                                std::to_string(q.rows()) + ", " + std::to_string(q.cols()) + ")");
  }
  arm::GravityModel model(n, terms, Vector::Zero(m));
  const auto size = static_cast<std::size_t>(q.rows() * n * m);
  auto values = std::make_unique<double[]>(size);
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  for (Eigen::Index k = 0; k < q.rows(); ++k) {
    const JointVector pose = q.row(k).transpose();
    Eigen::Map<Rows>(values.get() + k * n * m, n, m) = model.columns(pose, a.gravity_regressor(pose));
  }
  double* data = values.release();
  nb::capsule owner(data, [](void* p) noexcept { delete[] static_cast<double*>(p); });
  return {data, {static_cast<std::size_t>(q.rows()), static_cast<std::size_t>(n), static_cast<std::size_t>(m)}, owner};
}

void bind_gravity(nb::module_& m) {
  nb::class_<arm::Field>(m, "Field", "A smooth potential of some joints: sum_c w_c exp(-|(q_J - z_c) / l|^2 / 2).")
      .def(
          "__init__",
          [](arm::Field* self, const std::vector<int>& joints, const Matrix& centres, const VectorArg& length) {
            new (self) arm::Field{joints, centres, length};
          },
          "joints"_a, "centres"_a, "length"_a, "Joints J from zero (d); centres z (c, d), lengths l (d) [rad, m].")
      .def_ro("joints", &arm::Field::joints)
      .def_ro("centres", &arm::Field::centres)
      .def_ro("length", &arm::Field::length);
  nb::class_<arm::GravityTerms>(m, "GravityTerms", "The columns of a gravity model: masses, powers of joints, fields.")
      .def(
          "__init__",
          [](arm::GravityTerms* self, bool masses, int degree, const std::vector<arm::Field>& fields) {
            new (self) arm::GravityTerms{masses, degree, fields};
          },
          "masses"_a = true, "degree"_a = -1, "fields"_a = std::vector<arm::Field>{})
      .def_ro("masses", &arm::GravityTerms::masses, "4 columns per link")
      .def_ro("degree", &arm::GravityTerms::degree, "of a polynomial per joint; -1: none")
      .def_ro("fields", &arm::GravityTerms::fields, "a column per centre");
}

void bind_ik(nb::module_& m) {
  nb::class_<arm::IkOptions>(m, "IkOptions", "Inverse kinematics: when to stop.")
      .def(nb::init<>())
      .def_rw("max_iterations", &arm::IkOptions::max_iterations)
      .def_rw("position_tolerance", &arm::IkOptions::position_tolerance, "[m]")
      .def_rw("orientation_tolerance", &arm::IkOptions::orientation_tolerance, "[rad]")
      .def_rw("damping", &arm::IkOptions::damping, "floor of the damping, which grows with the remaining error");
  nb::class_<arm::IkResult>(m, "IkResult", "How an inverse kinematics ended.")
      .def_ro("converged", &arm::IkResult::converged)
      .def_ro("iterations", &arm::IkResult::iterations)
      .def_ro("position_error", &arm::IkResult::position_error, "[m]")
      .def_ro("orientation_error", &arm::IkResult::orientation_error, "[rad]")
      .def_ro("damping", &arm::IkResult::damping, "of the last step; large near singularities and out of reach");
}

/// Everything that one build of the recursion computes, as bytes, for tests that compare the two.
nb::bytes recursion_by_kernel(const std::string& xml, const std::string& base_frame, const std::string& tip_frame,
                              const VectorArg& q, const VectorArg& v, const std::string& kernel) {
  if (kernel != "avx2" && kernel != "portable") throw nb::value_error("kernel must be 'avx2' or 'portable'");
  const arm::ChainLanes chain = arm::chain_lanes(xml, base_frame, tip_frame);
  alignas(64) Lanes q_lanes, v_lanes;
  pad(joint_vector(q, "q", chain.n), q_lanes);
  pad(joint_vector(v, "v", chain.n), v_lanes);
  const auto dynamics = kernel == "avx2" ? &arm::avx2::chain_dynamics : &arm::portable::chain_dynamics;
  arm::ChainState state;
  dynamics(chain, q_lanes, v_lanes, v_lanes, state);
  return nb::bytes(&state, sizeof state);
}

void bind_all_terms(nb::module_& m) {
  nb::class_<arm::AllTerms>(m, "AllTerms", "Pinocchio's dynamics of the same URDF: a judge and a control.")
      .def(nb::init<const std::string&, const std::string&, const std::string&>(), "xml"_a, "base_frame"_a,
           "tip_frame"_a)
      .def(
          "compute",
          [](arm::AllTerms& self, const VectorArg& q, const VectorArg& v) {
            self.compute(joint_vector(q, "q", self.n()), joint_vector(v, "v", self.n()));
            return nb::make_tuple(self.M(), self.bias(), self.G(), self.J());
          },
          "q"_a, "v"_a, "(M (n,n), C v + G (n,), G (n,), J (6,n) at the tip in base axes) by computeAllTerms.");
  m.def("recursion_by_kernel", &recursion_by_kernel, "xml"_a, "base_frame"_a, "tip_frame"_a, "q"_a, "v"_a, "kernel"_a,
        "All results of the recursion at (q, v, a = v) as bytes, by the build 'avx2' or 'portable' (tests).");
}

}  // namespace

void bind_arm(nb::module_& m) {
  bind_all_terms(m);
  bind_ik(m);
  bind_gravity(m);
  nb::class_<Arm>(m, "Arm", "An arm: kinematics and dynamics in its base frame. See palpate.Arm.")
      .def(
          "__init__",
          [](Arm* self, const std::string& xml, const std::string& base_frame, const std::string& tip_frame) {
            new (self) Arm(Arm::from_urdf(xml, base_frame, tip_frame));
          },
          "xml"_a, "base_frame"_a, "tip_frame"_a, "From a URDF's text; the arm is the chain from base to tip.")
      .def(
          "__init__",
          [](Arm* self, const std::string& kind, const arm::Parameters& parameters) {
            new (self) Arm(arm::make_mechanism(kind, parameters));
          },
          "kind"_a, "parameters"_a, "A device with a closed form of its own, e.g. 'delta', from its numbers by name.")
      .def_prop_ro("n", &Arm::n, "Number of joints.")
      .def_prop_ro("joint_names", &Arm::joint_names)
      .def_prop_ro("link_names", &Arm::link_names)
      .def_prop_ro(
          "q_min", [](const Arm& a) -> Vector { return a.q_min(); }, "(n,) lower limits [rad, m]")
      .def_prop_ro(
          "q_max", [](const Arm& a) -> Vector { return a.q_max(); }, "(n,) upper limits [rad, m]")
      .def_prop_ro(
          "tau_max", [](const Arm& a) -> Vector { return a.tau_max(); }, "(n,) drive limits [N m, N]")
      .def_prop_ro(
          "v_max", [](const Arm& a) -> Vector { return a.v_max(); }, "(n,) speed limits [rad/s, m/s]")
      .def_prop_ro("orients", &Arm::orients, "Can its tip be turned at will? Otherwise it is placed only.")
      .def_prop_ro(
          "segments",
          [](const Arm& a) {
            std::vector<std::pair<std::string, Vec3>> segments;
            for (const arm::Segment& s : a.segments()) segments.emplace_back(s.link, s.end);
            return segments;
          },
          "The arm as sticks: (link, end in the link's axes (3,) [m]) each.")
      .def("fk", &fk, "q"_a, "X_0T (4,4): the tip in the base at q (n,) [rad, m].")
      .def("jacobian", &jacobian, "q"_a, "(6,n) at the tip in base axes, linear rows over angular rows.")
      .def(
          "gravity", [](Arm& a, const VectorArg& q) -> Vector { return a.gravity(joints(a, q, "q")); }, "q"_a,
          "G(q) = dP/dq (n,) that holds the masses up [N m, N].")
      .def(
          "elastic", [](Arm& a, const VectorArg& q) -> Vector { return a.elastic(joints(a, q, "q")); }, "q"_a,
          "What of holding (n,) is not of the masses: spring, cables [N m, N].")
      .def(
          "holding", [](Arm& a, const VectorArg& q) -> Vector { return a.holding(joints(a, q, "q")); }, "q"_a,
          "What holds the arm still (n,): the identified model, or gravity and counterbalance [N m, N].")
      .def(
          "bias",
          [](Arm& a, const VectorArg& q, const VectorArg& v) -> Vector {
            return a.bias(joints(a, q, "q"), joints(a, v, "v"));
          },
          "q"_a, "v"_a, "C(q, v) v + G(q) (n,) [N m, N].")
      .def(
          "inverse_dynamics",
          [](Arm& a, const VectorArg& q, const VectorArg& v, const VectorArg& acc) -> Vector {
            return a.inverse_dynamics(joints(a, q, "q"), joints(a, v, "v"), joints(a, acc, "a"));
          },
          "q"_a, "v"_a, "a"_a, "M a + C v + G (n,) [N m, N].")
      .def(
          "mass_matrix", [](Arm& a, const VectorArg& q) -> Matrix { return a.mass_matrix(joints(a, q, "q")); }, "q"_a,
          "M(q) (n,n), symmetric; rotor inertias are not in it.")
      .def(
          "dynamics",
          [](Arm& a, const VectorArg& q, const VectorArg& v) {
            const arm::Dynamics& d = a.dynamics(joints(a, q, "q"), joints(a, v, "v"));
            return nb::make_tuple(Matrix(d.M), Vector(d.bias), to_matrix(d.X_0T), Matrix(d.J), Vector(d.Jdot_v));
          },
          "q"_a, "v"_a, "(M (n,n), C v + G (n,), X_0T (4,4), J (6,n), dJ/dt v (6,)) in one go, as the plant uses them.")
      .def(
          "potential_energy", [](Arm& a, const VectorArg& q) { return a.potential_energy(joints(a, q, "q")); }, "q"_a,
          "P(q) of the masses [J].")
      .def(
          "elastic_energy", [](Arm& a, const VectorArg& q) { return a.elastic_energy(joints(a, q, "q")); }, "q"_a,
          "P(q) of spring and cables [J].")
      .def(
          "set_counterbalance",
          [](Arm& a, double torque, const VectorArg& along) {
            a.set_counterbalance({torque, joints(a, along, "along")});
          },
          "torque"_a, "along"_a, "A spring P = -torque sin(along . q): torque [N m], along (n,). 0 takes it away.")
      .def(
          "gravity_regressor",
          [](Arm& a, const VectorArg& q) -> Matrix { return a.gravity_regressor(joints(a, q, "q")).Y; }, "q"_a,
          "Y(q) (n,4n): gravity = Y Pi, Pi = (m, m c_x, m c_y, m c_z) of each link, c in its axes (Eqs 10-12).")
      .def_prop_ro("moments", &Arm::moments, "Pi of the model file (4n,) [kg, kg m].")
      .def("gravity_columns", &gravity_columns, "terms"_a, "q"_a,
           "Phi (k, n, m) of the terms at the poses q (k, n): holding = Phi theta.")
      .def("set_gravity_model", &Arm::set_gravity_model, "terms"_a, "theta"_a,
           "Hold the arm by an identified model, theta (m,), instead of masses and counterbalance.")
      .def("set_gravity", &Arm::set_gravity, "g_base"_a, "Gravity in base axes [m/s^2]; default (0, 0, -9.81).")
      .def(
          "with_scaled_masses",
          [](const Arm& a, const VectorArg& scale) { return a.with_scaled_masses(joints(a, scale, "scale")); },
          "scale"_a, "A copy whose link masses are multiplied by scale (n,): a controller's wrong model of the plant.")
      .def(
          "torque_regressor",
          [](Arm& a, const VectorArg& q, const VectorArg& v, const VectorArg& acc) {
            return a.torque_regressor(joints(a, q, "q"), joints(a, v, "v"), joints(a, acc, "a"));
          },
          "q"_a, "v"_a, "a"_a,
          "Y (n,10n) of M a + C v + G = Y pi, pi = (m, m c (3), I_xx, I_xy, I_yy, I_xz, I_yz, I_zz) per link.")
      .def_prop_ro("inertial_parameters", &Arm::inertial_parameters, "pi (10n,) of the links [kg, kg m, kg m^2].")
      .def(
          "with_inertial_parameters", [](const Arm& a, const VectorArg& pi) { return a.with_inertial_parameters(pi); },
          "pi"_a, "A copy made of other links alone, no counterbalance: pi (10n,); refuses what is no body's.")
      .def("ik_from", &ik_from, "X_0T"_a, "q0"_a, "options"_a = arm::IkOptions{},
           "One damped Newton run from q0: (q, IkResult). palpate.Arm.ik restarts and raises.")
      .def("link_poses_array", &link_poses, "q"_a, "X_0link (4,4) of every link, in link_names order.");
}

}  // namespace palpate::bindings
