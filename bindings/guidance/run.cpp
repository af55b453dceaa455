#include <nanobind/ndarray.h>
#include <nanobind/stl/vector.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "convert.hpp"
#include "guidance/bindings.hpp"
#include "palpate/guidance/guidance_run.hpp"
#include "types.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using guidance::Guidance;
using Twists = Input<double, -1, 6>;

/// Runs the stage tick by tick along a motion (guidance::GuidanceRun). height: height of the elastic plane at each
/// tick; empty: no plane.
nb::typed<nb::dict, nb::str, Array> run(Guidance& self, const std::vector<double>& t, const Poses& X_WT_goal,
                                        const Twists& V_WT, const Matrix4& X_WT, const Vec3& normal,
                                        const std::vector<double>& height, double stiffness, double F_hand,
                                        double pedal, bool renders_damping) {
  const std::size_t n = t.size();
  if (X_WT_goal.shape(0) != n || V_WT.shape(0) != n)
    throw std::invalid_argument("X_WT_goal and V_WT must have one row for each time in t; got " +
                                std::to_string(X_WT_goal.shape(0)) + " and " + std::to_string(V_WT.shape(0)) +
                                " rows for " + std::to_string(n) + " times");
  if (!height.empty() && height.size() != n)
    throw std::invalid_argument("height must have one entry for each time in t, or none; got " +
                                std::to_string(height.size()) + " entries for " + std::to_string(n) + " times");
  Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor> F(n, 6);
  Eigen::Matrix<double, Eigen::Dynamic, 16, Eigen::RowMajor> goals(n, 16);
  Eigen::Matrix<double, Eigen::Dynamic, 9, Eigen::RowMajor> B(n, 9);
  Eigen::VectorXd gap(n);
  guidance::GuidanceRun motion(self, {{normal, stiffness}, F_hand, pedal, renders_damping}, to_pose(X_WT, "X_WT"));
  for (std::size_t k = 0; k < n; ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const Pose goal = to_pose(Matrix4(Eigen::Map<const RowMat4>(X_WT_goal.data() + 16 * k)), "X_WT_goal");
    const Twist V = {Vec3(V_WT.data() + 6 * k), Vec3(V_WT.data() + 6 * k + 3)};
    const guidance::Output& out = height.empty() ? motion.step(t[k], goal, V) : motion.step(t[k], goal, V, height[k]);
    F.row(row) = to_vector(out.on_tool.F);
    Eigen::Map<RowMat4>(&goals(row, 0)) = to_matrix(out.X_WT_goal);
    Eigen::Map<Mat3>(&B(row, 0)) = out.on_tool.B;  // symmetric
    gap[row] = out.gap;
  }
  nb::typed<nb::dict, nb::str, Array> d;
  d["F_T_W"] = F;
  d["X_WT_goal"] = goals;
  d["B_W"] = B;
  d["gap"] = gap;
  return d;
}

}  // namespace

void bind_run(nb::module_& m) {
  m.def(
      "run_guidance", &run, "stage"_a, "t"_a, "X_WT_goal"_a, "V_WT"_a, "X_WT"_a, "normal"_a = Vec3(Vec3::UnitZ()),
      "height"_a = std::vector<double>{}, "stiffness"_a = 0.0, "F_hand"_a = -1.0, "pedal"_a = 1.0,
      "takes_damping"_a = false,
      "Runs a Guidance along a motion: times t (n,) [s], goals X_WT_goal (n, 4, 4), twists V_WT (n, 6). The measured "
      "tool pose is the previous goal, at first X_WT (4, 4). Below the plane normal . p = height (n,) the tool touches "
      "a spring of the given stiffness [N/m]. Returns F_T_W (n, 6), X_WT_goal (n, 16), B_W (n, 9) and gap (n,).");
}

}  // namespace palpate::bindings
