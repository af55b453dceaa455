#include <nanobind/eigen/dense.h>
#include <nanobind/ndarray.h>

#include <chrono>
#include <memory>
#include <stdexcept>

#include "convert.hpp"
#include "palpate/guidance/guidance.hpp"
#include "types.hpp"
#include "verify/bindings.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using TwistsOfRuns = Input<double, -1, -1, 6>;

Pose pose(const Poses& X, std::size_t i) {
  const Eigen::Map<const RowMat4> m(X.data() + 16 * i);
  return {m.topLeftCorner<3, 3>(), m.topRightCorner<3, 1>()};
}

/// Durations of n calls by the steady clock (n,) [us].
template <class Call>
Eigen::VectorXd timed(std::size_t n, const Call& call) {
  using Clock = std::chrono::steady_clock;
  Eigen::VectorXd us(static_cast<Eigen::Index>(n));
  const nb::gil_scoped_release release;
  for (std::size_t i = 0; i < n; ++i) {
    const auto begin = Clock::now();
    call(i);
    us[static_cast<Eigen::Index>(i)] = std::chrono::duration<double, std::micro>(Clock::now() - begin).count();
  }
  return us;
}

Eigen::VectorXd time_query(const guidance::Geometry& geometry, const Poses& X_WT) {
  double sum = 0.0;
  return timed(X_WT.shape(0), [&](std::size_t i) {
    sum += geometry.query(pose(X_WT, i), 0.0).distance;
    asm volatile("" : : "g"(&sum) : "memory");  // keeps the compiler from removing the query
  });
}

/// Durations of the stage's ticks while the commanded tool pose follows X_WT, one pose per tick.
Eigen::VectorXd time_stage(const guidance::Fixtures& fixtures, const Poses& X_WT, double dt) {
  const auto stage = std::make_unique<guidance::Guidance>(guidance::Options{}, dt);
  stage->take(fixtures);
  guidance::Input in;
  in.goal.engaged = true;
  Vec3 before = pose(X_WT, 0).p;
  return timed(X_WT.shape(0), [&](std::size_t i) {
    in.t = dt * static_cast<double>(i);
    in.goal.X_WT_goal = pose(X_WT, i);
    in.goal.V_WT.v = (in.goal.X_WT_goal.p - before) / dt;
    before = in.goal.X_WT_goal.p;
    in.tool.X_WT = stage->step(in).X_WT_goal;
  });
}

/// Durations of n quadratic programs of m rows each.
Eigen::VectorXd time_qp(const TwistsOfRuns& A, const Input<double, -1, -1>& b, const Input<double, -1, -1>& y0) {
  const std::size_t m = A.shape(1);
  if (b.shape(0) != A.shape(0) || b.shape(1) != m || y0.shape(0) != A.shape(0) || y0.shape(1) != 6)
    throw std::invalid_argument("A, b and y0 must have shapes (n, m, 6), (n, m) and (n, 6)");
  const auto qp = std::make_unique<guidance::Qp>();
  return timed(A.shape(0), [&](std::size_t i) {
    qp->clear();
    for (std::size_t k = 0; k < m; ++k) qp->add(Vec6(A.data() + 6 * (i * m + k)), b.data()[i * m + k]);
    (void)qp->solve(Vec6(y0.data() + 6 * i));
  });
}

}  // namespace

void bind_guidance_bench(nb::module_& m) {
  m.def("time_query", &time_query, "geometry"_a, "X_WT"_a,
        "Durations of n queries at the poses X_WT (n, 4, 4): (n,) [us].");
  m.def("time_guidance", &time_stage, "fixtures"_a, "X_WT"_a, "dt"_a = 1e-3,
        "Durations of n ticks of guidance while the commanded tool pose follows X_WT (n, 4, 4): (n,) [us].");
  m.def("time_qp", &time_qp, "A"_a, "b"_a, "y0"_a,
        "Durations of n quadratic programs of m rows, filling included: (n,) [us]. A (n, m, 6), b (n, m), y0 (n, 6).");
}

}  // namespace palpate::bindings
