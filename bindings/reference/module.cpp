#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include <memory>
#include <stdexcept>

#include "convert.hpp"
#include "palpate/loop/realtime.hpp"
#include "palpate/reference/all_terms.hpp"
#include "timing.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using reference::AllTerms;

/// Baseline for the compute time of a cycle: Pinocchio's computeAllTerms of both arms and nothing else.
class BareDynamics {
 public:
  BareDynamics(AllTerms& leader, AllTerms& follower) : leader_(leader), follower_(follower) {}

  void run(const Eigen::MatrixXd& q_leader, const Eigen::MatrixXd& v_leader, const Eigen::MatrixXd& q_follower) {
    if (q_leader.rows() != leader_.n() || v_leader.rows() != leader_.n() || q_follower.rows() != follower_.n() ||
        v_leader.cols() != q_leader.cols() || q_follower.cols() != q_leader.cols()) {
      throw std::invalid_argument(
          "q_leader, v_leader and q_follower must have one row per joint and one column per tick");
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
  AllTerms& leader_;
  AllTerms& follower_;
  std::unique_ptr<loop::Histogram> time_ = std::make_unique<loop::Histogram>();
};

void bind_all_terms(nb::module_& m) {
  nb::class_<AllTerms>(m, "AllTerms", "Pinocchio's dynamics of a URDF; tests and benchmarks compare Arm with it.")
      .def(nb::init<const std::string&, const std::string&, const std::string&>(), "xml"_a, "base_frame"_a,
           "tip_frame"_a)
      .def(
          "compute",
          [](AllTerms& self, const VectorArg& q,
             const VectorArg& v) -> Tuple<Eigen::MatrixXd, Eigen::VectorXd, Eigen::VectorXd, Eigen::MatrixXd> {
            self.compute(joint_vector(q, "q", self.n()), joint_vector(v, "v", self.n()));
            return nb::make_tuple(self.M(), self.bias(), self.G(), self.J());
          },
          "q"_a, "v"_a, "computeAllTerms: (M (n,n), C v + G (n,), G (n,), J (6,n) at the tip in base axes).");
}

void bind_bare_dynamics(nb::module_& m) {
  nb::class_<BareDynamics>(
      m, "BareDynamics",
      "Times Pinocchio's computeAllTerms of both arms, as a baseline for the compute time of a cycle.")
      .def(nb::init<AllTerms&, AllTerms&>(), "leader"_a, "follower"_a, nb::keep_alive<1, 2>(), nb::keep_alive<1, 3>())
      .def("run", &BareDynamics::run, "q_leader"_a, "v_leader"_a, "q_follower"_a,
           "Times k ticks: q_leader (n, k), v_leader (n, k) and q_follower (m, k) [rad, m; rad/s, m/s].")
      .def(
          "timing", [](const BareDynamics& self) { return percentiles(self.time()); },
          "Compute times p50, p99, p999 and max [us].");
}

}  // namespace
}  // namespace palpate::bindings

NB_MODULE(_reference, m) {
  nb::set_leak_warnings(false);  // objects that live until the interpreter ends are not leaks
  m.doc() = "Pinocchio's dynamics of an arm, with which tests and benchmarks compare ours.";
  nb::module_::import_("palpate._core");
  palpate::bindings::bind_all_terms(m);
  palpate::bindings::bind_bare_dynamics(m);
}
