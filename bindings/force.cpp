#include "palpate/force/force.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/tuple.h>

#include <memory>
#include <optional>
#include <stdexcept>

#include "bindings.hpp"
#include "convert.hpp"
#include "doc.hpp"
#include "palpate/force/estimate.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

auto force_step(const Rows3& K, const Rows3& B, const Rows3& normal, const Rows3& delta_x, const Vec3& v_WT,
                const Rows3& v_surface, double stiffness_scale, double damping_scale, const Vec3& w_WT,
                const std::optional<Rows3>& p_TS) {
  const Eigen::Index n = normal.rows();
  if (n > kMaxContacts || K.rows() != n || B.rows() != n || delta_x.rows() != n || v_surface.rows() != n ||
      (p_TS && p_TS->rows() != n)) {
    throw std::invalid_argument("K, B, normal, delta_x, v_surface and p_TS must all have shape (n, 3), n <= " +
                                std::to_string(kMaxContacts));
  }
  ContactSet contacts;
  contacts.size = static_cast<int>(n);
  for (int i = 0; i < contacts.size; ++i) {
    Contact& c = contacts.contact[static_cast<std::size_t>(i)];
    c.object = i;
    c.material = {K.row(i), B.row(i), 0.0};
    c.normal = normal.row(i);
    c.delta_x = delta_x.row(i);
    c.depth = c.delta_x.dot(c.normal);
    c.v_surface = v_surface.row(i);
    if (p_TS) c.p_TS = p_TS->row(i);
  }
  const force::ForceTerms terms = force::step(contacts, {v_WT, w_WT}, stiffness_scale, damping_scale);
  return std::make_tuple(terms.F, terms.F_spring, terms.F_damping, terms.torque);
}

/// Observer output r (k, n) of a whole recording q, v, tau (k, n), sampled at rate [Hz].
Eigen::MatrixXd observe(force::MomentumObserver& self, const Eigen::MatrixXd& q, const Eigen::MatrixXd& v,
                        const Eigen::MatrixXd& tau, double rate) {
  const Eigen::Index n = self.model().n();
  if (q.cols() != n || v.rows() != q.rows() || v.cols() != n || tau.rows() != q.rows() || tau.cols() != n) {
    throw std::invalid_argument("q, v and tau must all have shape (k, " + std::to_string(n) + "), a row per period");
  }
  if (!(rate > 0.0)) throw std::invalid_argument("rate must be above 0 Hz; got " + std::to_string(rate));
  Eigen::MatrixXd r(q.rows(), n);
  for (Eigen::Index k = 0; k < q.rows(); ++k) {
    r.row(k) = self.step(q.row(k).transpose(), v.row(k).transpose(), tau.row(k).transpose(), 1.0 / rate).transpose();
  }
  return r;
}

void bind_estimate(nb::module_& m) {
  using force::Estimate;
  using force::EstimateOptions;
  using force::MomentumObserver;
  nb::class_<MomentumObserver>(
      m, "MomentumObserver",
      "Estimates external joint torques r from the drive torques (core/palpate/force/estimate.hpp).")
      .def(
          "__init__",
          [](MomentumObserver* self, const arm::Arm& model, const Eigen::MatrixXd& drive_inertia, double bandwidth) {
            new (self) MomentumObserver(model, joint_matrix(drive_inertia, "drive_inertia"), bandwidth);
          },
          "model"_a, "drive_inertia"_a, "bandwidth"_a,
          "drive_inertia: inertia (n,n) of the drives at the joints [kg m^2, kg]; bandwidth of r [Hz].")
      .def("reset", &MomentumObserver::reset, "Resets the observer: the next sample starts at r = 0.")
      .def("run", &observe, "q"_a, "v"_a, "tau"_a, "rate"_a,
           "External joint torques r (k, n) [N m, N] for k samples at rate [Hz]; tau (k, n): drive torques without "
           "friction.");

  nb::class_<EstimateOptions> options(m, "EstimateOptions",
                                      "Options of the force estimate from the follower's drive torques.");
  options.def(nb::init<>())
      .def_rw("bandwidth", &EstimateOptions::bandwidth, "Bandwidth of the momentum observer [Hz]."_doc)
      .def_rw("dead_band", &EstimateOptions::dead_band,
              "Dead band of the estimated force: smaller forces are reported as zero [N]."_doc)
      .def_rw("slip_speed", &EstimateOptions::slip_speed,
              "Fraction of the drives' speed limits above which dry friction has its full value [-]."_doc);
  joint_field(options, "rotor_inertia", &EstimateOptions::rotor_inertia,
              "Rotor inertias at the joints (n,) [kg m^2, kg].");
  joint_field(options, "coulomb", &EstimateOptions::coulomb, "Dry friction of the drives (n,) [N m, N].");
  joint_field(options, "viscous", &EstimateOptions::viscous, "Viscous friction of the drives (n,) [N m s/rad, N s/m].");
  joint_field(options, "offset", &EstimateOptions::offset, "Constant torques of the drives (n,) [N m, N].");
  joint_field(options, "spring", &EstimateOptions::spring, "Spring constants at the joints (n,) [N m/rad, N/m].");
  options.def_rw("links", &EstimateOptions::links,
                 "Identified inertial parameters (10n,); empty: those of the model."_doc);

  nb::class_<Estimate>(m, "Estimate", "Estimates the force of the environment on the tool tip from the drive torques.")
      .def(nb::init<const arm::Arm&, EstimateOptions>(), "model"_a, "options"_a)
      .def("reset", &Estimate::reset, "Resets the momentum observer.")
      .def(
          "step",
          [](Estimate& self, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& v,
             const Eigen::VectorXd& tau) -> Vec3 {
            return self.step({t, joint_vector(q, "q"), 0.0, true, joint_vector(v, "v"), joint_vector(tau, "tau")});
          },
          "t"_a, "q"_a, "v"_a, "tau"_a, "Estimated force F_T_B (3,) [N] for the follower's state at t [s].");
}

}  // namespace

void bind_force(nb::module_& m) {
  bind_estimate(m);
  m.def("force", &force_step, "K"_a, "B"_a, "normal"_a, "delta_x"_a, "v_WT"_a, "v_surface"_a, "stiffness_scale"_a = 1.0,
        "damping_scale"_a = 1.0, "w_WT"_a = Vec3(Vec3::Zero()), "p_TS"_a = nb::none(),
        "Stage `force` for n contacts, given as (n, 3) arrays in W: (F, F_spring, F_damping, torque), each (3,) in W; "
        "forces [N], torque about T [N m].");
}

}  // namespace palpate::bindings
