#include "palpate/arm/arm.hpp"

#include <nanobind/ndarray.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bindings.hpp"
#include "convert.hpp"
#include "doc.hpp"
#include "palpate/arm/serial.hpp"
#include "types.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using arm::Arm;

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

void require_rows(const Matrix& q, Eigen::Index n) {
  if (q.cols() != n) {
    throw std::invalid_argument("q must have shape (k, " + std::to_string(n) + "), a row per pose; got (" +
                                std::to_string(q.rows()) + ", " + std::to_string(q.cols()) + ")");
  }
}

/// Pose of each link in each row of q (k, links, 4, 4).
nb::ndarray<nb::numpy, double, nb::ndim<4>> link_poses(Arm& a, const Matrix& q) {
  require_rows(q, a.n());
  const auto k = static_cast<std::size_t>(q.rows()), links = a.link_names().size();
  auto values = std::make_unique<double[]>(k * links * 16);
  double* next = values.get();
  for (Eigen::Index row = 0; row < q.rows(); ++row) {
    for (const Pose& X : a.link_poses(q.row(row).transpose())) {
      Eigen::Map<RowMat4>{next} = to_matrix(X);
      next += 16;
    }
  }
  double* data = values.release();
  nb::capsule owner(data, [](void* p) noexcept { delete[] static_cast<double*>(p); });
  return {data, {k, links, 4, 4}, owner};
}

/// Phi of every pose (k, n, m), in C order.
nb::ndarray<nb::numpy, double, nb::ndim<3>> gravity_columns(Arm& a, const arm::GravityTerms& terms, const Matrix& q) {
  const Eigen::Index n = a.n(), m = terms.columns(n);
  require_rows(q, n);
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
          "joints"_a, "centres"_a, "length"_a,
          "Indices of the joints J (d,), from zero; centres z (c, d) and lengths l (d,) [rad, m].")
      .def_ro("joints", &arm::Field::joints, "Indices of the joints (d,), from zero."_doc)
      .def_ro("centres", &arm::Field::centres, "Centres of the Gaussians (c, d) [rad, m]."_doc)
      .def_ro("length", &arm::Field::length, "Length scales of the Gaussians (d,) [rad, m]."_doc);
  nb::class_<arm::GravityTerms>(m, "GravityTerms", "The columns of a gravity model: masses, powers of joints, fields.")
      .def(
          "__init__",
          [](arm::GravityTerms* self, bool masses, int degree, const std::vector<arm::Field>& fields) {
            new (self) arm::GravityTerms{masses, degree, fields};
          },
          "masses"_a = true, "degree"_a = -1, "fields"_a = std::vector<arm::Field>{},
          "masses: four columns per link; degree: of the polynomials, -1: none; fields: one column per centre.")
      .def_ro("masses", &arm::GravityTerms::masses,
              "True: four columns per link, for its mass and its first moments."_doc)
      .def_ro("degree", &arm::GravityTerms::degree, "Degree of the polynomial in each joint; -1: no polynomials."_doc)
      .def_ro("fields", &arm::GravityTerms::fields, "Gaussian fields; each has one column per centre."_doc);
}

void bind_ik(nb::module_& m) {
  nb::class_<arm::IkOptions>(m, "IkOptions", "When the inverse kinematics stops.")
      .def(nb::init<>())
      .def_rw("max_iterations", &arm::IkOptions::max_iterations, "Largest number of iterations."_doc)
      .def_rw("position_tolerance", &arm::IkOptions::position_tolerance,
              "Position error accepted as converged [m]."_doc)
      .def_rw("orientation_tolerance", &arm::IkOptions::orientation_tolerance,
              "Orientation error accepted as converged [rad]."_doc)
      .def_rw("damping", &arm::IkOptions::damping, "Smallest damping; the damping grows with the remaining error."_doc);
  nb::class_<arm::IkResult>(m, "IkResult", "Outcome of an inverse kinematics run.")
      .def_ro("converged", &arm::IkResult::converged, "True if both errors are within their tolerances."_doc)
      .def_ro("iterations", &arm::IkResult::iterations, "Number of iterations."_doc)
      .def_ro("position_error", &arm::IkResult::position_error, "Remaining position error [m]."_doc)
      .def_ro("orientation_error", &arm::IkResult::orientation_error, "Remaining orientation error [rad]."_doc)
      .def_ro("damping", &arm::IkResult::damping,
              "Damping of the last step; large near singularities and out of reach."_doc);
}

/// Everything that one build of the recursion computes, as bytes, for tests that compare them.
nb::bytes recursion_by_kernel(const std::string& xml, const std::string& base_frame, const std::string& tip_frame,
                              const VectorArg& q, const VectorArg& v, const std::string& kernel) {
  const std::map<std::string, decltype(&arm::portable::chain_dynamics)> kernels = {
      {"avx512", &arm::avx512::chain_dynamics},
      {"avx2", &arm::avx2::chain_dynamics},
      {"portable", &arm::portable::chain_dynamics}};
  if (!kernels.contains(kernel)) throw nb::value_error("kernel must be 'avx512', 'avx2' or 'portable'");
  const arm::ChainLanes chain = arm::chain_lanes(xml, base_frame, tip_frame);
  alignas(64) Lanes q_lanes, v_lanes;
  pad(joint_vector(q, "q", chain.n), q_lanes);
  pad(joint_vector(v, "v", chain.n), v_lanes);
  arm::ChainState state;
  kernels.at(kernel)(chain, q_lanes, v_lanes, v_lanes, {0.2, 3e-4}, state);
  return nb::bytes(&state, sizeof state);
}

void bind_kernels(nb::module_& m) {
  m.def("recursion_by_kernel", &recursion_by_kernel, "xml"_a, "base_frame"_a, "tip_frame"_a, "q"_a, "v"_a, "kernel"_a,
        "All results of the recursion at (q, v, a = v) as bytes, by the build 'avx512', 'avx2' or 'portable' (tests).");
}

/// Construction, joints, links and limits.
void bind_model(nb::class_<Arm>& c) {
  c.def(
       "__init__",
       [](Arm* self, const std::string& xml, const std::string& base_frame, const std::string& tip_frame) {
         new (self) Arm(Arm::from_urdf(xml, base_frame, tip_frame));
       },
       "xml"_a, "base_frame"_a, "tip_frame"_a,
       "Makes an arm from the text of a URDF: the chain from base_frame to tip_frame.")
      .def(
          "__init__",
          [](Arm* self, const std::string& kind, const arm::Parameters& parameters) {
            new (self) Arm(arm::make_mechanism(kind, parameters));
          },
          "kind"_a, "parameters"_a,
          "Makes a device that has closed-form kinematics, such as 'delta', from its parameters by name.")
      .def_prop_ro("n", &Arm::n, "Number of joints.")
      .def_prop_ro("joint_names", &Arm::joint_names, "Names of the joints.")
      .def_prop_ro("link_names", &Arm::link_names, "Names of the links.")
      .def_prop_ro(
          "q_min", [](const Arm& a) -> Vector { return a.q_min(); }, "Lower joint limits (n,) [rad, m].")
      .def_prop_ro(
          "q_max", [](const Arm& a) -> Vector { return a.q_max(); }, "Upper joint limits (n,) [rad, m].")
      .def_prop_ro(
          "tau_max", [](const Arm& a) -> Vector { return a.tau_max(); }, "Torque limits of the drives (n,) [N m, N].")
      .def_prop_ro(
          "v_max", [](const Arm& a) -> Vector { return a.v_max(); }, "Speed limits of the joints (n,) [rad/s, m/s].")
      .def_prop_ro("orients", &Arm::orients, "True if the joints can orient the tip; False if they only position it.")
      .def_prop_ro(
          "segments",
          [](const Arm& a) {
            std::vector<std::pair<std::string, Vec3>> segments;
            for (const arm::Segment& s : a.segments()) segments.emplace_back(s.link, s.end);
            return segments;
          },
          "Line segments for drawing the arm: (name of the link, end of the segment in the link's axes (3,) [m]).");
}

/// Poses, Jacobian and inverse kinematics.
void bind_kinematics(nb::class_<Arm>& c) {
  c.def("fk", &fk, "q"_a, "Pose X_0T (4,4) of the tip in the base frame at q (n,) [rad, m].")
      .def("jacobian", &jacobian, "q"_a, "Jacobian (6,n) at the tip in base axes, linear rows over angular rows.")
      .def("ik_from", &ik_from, "X_0T"_a, "q0"_a, "options"_a = arm::IkOptions{},
           "One damped Newton run from q0 (n,): (q (n,), IkResult). palpate.Arm.ik restarts it and raises an error.")
      .def("link_poses_array", &link_poses, "q"_a,
           "Poses (k, links, 4, 4) in the base frame at each row of q (k, n), in the order of link_names.");
}

/// Torques, inertia and energies.
void bind_dynamics(nb::class_<Arm>& c) {
  c.def(
       "gravity", [](Arm& a, const VectorArg& q) -> Vector { return a.gravity(joints(a, q, "q")); }, "q"_a,
       "Torques G(q) = dP/dq (n,) that balance the weight of the links [N m, N].")
      .def(
          "elastic", [](Arm& a, const VectorArg& q) -> Vector { return a.elastic(joints(a, q, "q")); }, "q"_a,
          "Torques (n,) that balance the counterbalance spring and the cables [N m, N].")
      .def(
          "holding", [](Arm& a, const VectorArg& q) -> Vector { return a.holding(joints(a, q, "q")); }, "q"_a,
          "Torques (n,) that hold the arm still, by the identified gravity model or by gravity and counterbalance [N "
          "m, N].")
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
          "Mass matrix M(q) (n,n), symmetric, without the rotor inertias.")
      .def(
          "dynamics",
          [](Arm& a, const VectorArg& q, const VectorArg& v) -> Tuple<Matrix, Vector, Matrix4, Matrix, Vector> {
            const arm::Dynamics& d = a.dynamics(joints(a, q, "q"), joints(a, v, "v"));
            return nb::make_tuple(Matrix(d.M), Vector(d.bias), to_matrix(d.X_0T), Matrix(d.J), Vector(d.Jdot_v));
          },
          "q"_a, "v"_a,
          "All terms that a simulated arm needs: (M (n,n), C v + G (n,), X_0T (4,4), J (6,n), dJ/dt v (6,)).")
      .def(
          "potential_energy", [](Arm& a, const VectorArg& q) { return a.potential_energy(joints(a, q, "q")); }, "q"_a,
          "Potential energy P(q) of the links' weight [J].")
      .def(
          "elastic_energy", [](Arm& a, const VectorArg& q) { return a.elastic_energy(joints(a, q, "q")); }, "q"_a,
          "Potential energy P(q) of the counterbalance spring and the cables [J].");
}

/// Counterbalance, and gravity with its regressor.
void bind_gravity_model(nb::class_<Arm>& c) {
  c.def(
       "set_counterbalance",
       [](Arm& a, double torque, const VectorArg& along) { a.set_counterbalance({torque, joints(a, along, "along")}); },
       "torque"_a, "along"_a,
       "Sets a spring with potential P = -torque sin(along . q): torque [N m], along (n,). Torque 0 removes the "
       "spring.")
      .def(
          "gravity_regressor",
          [](Arm& a, const VectorArg& q) -> Matrix { return a.gravity_regressor(joints(a, q, "q")).Y; }, "q"_a,
          "Regressor Y(q) (n,4n): gravity = Y Pi, Pi = (m, m c_x, m c_y, m c_z) of each link, c in the link's axes "
          "(Eqs 10-12).")
      .def_prop_ro("moments", &Arm::moments,
                   "Masses and first moments Pi of the links in the model file (4n,) [kg, kg m].")
      .def("gravity_columns", &gravity_columns, "terms"_a, "q"_a,
           "Columns Phi (k, n, m) of the terms at the joint positions q (k, n): holding = Phi theta.")
      .def("set_gravity_model", &Arm::set_gravity_model, "terms"_a, "theta"_a,
           "Replaces masses and counterbalance in holding() by an identified gravity model with parameters theta (m,).")
      .def("set_gravity", &Arm::set_gravity, "g_base"_a,
           "Sets the gravitational acceleration in base axes (3,) [m/s^2]; default (0, 0, -9.81).");
}

/// Copies with other inertial parameters, and their regressor.
void bind_inertial_parameters(nb::class_<Arm>& c) {
  c.def(
       "with_scaled_masses",
       [](const Arm& a, const VectorArg& scale) { return a.with_scaled_masses(joints(a, scale, "scale")); }, "scale"_a,
       "Copy whose link masses are multiplied by scale (n,), as an inexact model for a controller.")
      .def(
          "torque_regressor",
          [](Arm& a, const VectorArg& q, const VectorArg& v, const VectorArg& acc) {
            return a.torque_regressor(joints(a, q, "q"), joints(a, v, "v"), joints(a, acc, "a"));
          },
          "q"_a, "v"_a, "a"_a,
          "Regressor Y (n,10n): M a + C v + G = Y pi, pi = (m, m c (3), I_xx, I_xy, I_yy, I_xz, I_yz, I_zz) of each "
          "link.")
      .def_prop_ro("inertial_parameters", &Arm::inertial_parameters,
                   "Inertial parameters pi of the links (10n,) [kg, kg m, kg m^2].")
      .def(
          "with_inertial_parameters", [](const Arm& a, const VectorArg& pi) { return a.with_inertial_parameters(pi); },
          "pi"_a,
          "Copy with the inertial parameters pi (10n,) and without a counterbalance. Parameters that no rigid body can "
          "have raise ValueError.");
}

}  // namespace

void bind_arm(nb::module_& m) {
  bind_kernels(m);
  bind_ik(m);
  bind_gravity(m);
  nb::class_<Arm> c(m, "Arm", "Kinematics and dynamics of an arm in its base frame. See palpate.Arm.");
  bind_model(c);
  bind_kinematics(c);
  bind_dynamics(c);
  bind_gravity_model(c);
  bind_inertial_parameters(c);
}

}  // namespace palpate::bindings
