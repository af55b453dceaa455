#include "palpate/mapping/mapping.hpp"

#include <nanobind/stl/tuple.h>

#include "bindings.hpp"
#include "convert.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {

void bind_mapping(nb::module_& m) {
  using mapping::Mapping;
  using mapping::Options;
  nb::class_<Options>(m, "MappingOptions", "Options of the stage `mapping` between hand and tool.")
      .def(nb::init<>())
      .def_rw("scale", &Options::scale,
              "Tool motion per hand motion [-]; the hand feels the stiffness force_scale * scale * K.")
      .def_rw("force_scale", &Options::force_scale, "Force on the hand per force on the tool [-].")
      .def_rw("align_rate", &Options::align_rate,
              "Rate at which an orientation offset decays [rad/s]; 0: the offset stays.")
      .def_rw("gripper_min", &Options::gripper_min, "Gripper angle that closes the jaw [rad].")
      .def_rw("gripper_max", &Options::gripper_max, "Gripper angle that opens the jaw [rad].")
      .def_rw("jaw_min", &Options::jaw_min, "Angle of the closed jaw [rad].")
      .def_rw("jaw_max", &Options::jaw_max, "Angle of the open jaw [rad].")
      .def_rw("jaw_rate", &Options::jaw_rate, "Rate at which the jaw approaches the gripper angle [rad/s].");

  nb::class_<Mapping>(m, "Mapping", "Stage `mapping`: relative scaled position, absolute orientation, clutch, jaw.")
      .def(
          "__init__",
          [](Mapping* self, const Options& options, const Mat3& R_WL, double dt) {
            new (self) Mapping(options, R_WL, dt);
          },
          "options"_a, "R_WL"_a, "dt"_a, "R_WL (3, 3): rotation of the leader base in W; dt: period of the cycle [s].")
      .def(
          "step",
          [](Mapping& self, const Matrix4& X_WH, const Vec3& v_LH, double gripper, const Matrix4& X_WT, double jaw,
             bool following, bool clutch, bool reached) {
            const ToolGoal out = self.step({to_pose(X_WH, "X_WH"),
                                            {v_LH, Vec3::Zero()},
                                            gripper,
                                            to_pose(X_WT, "X_WT"),
                                            jaw,
                                            following,
                                            clutch,
                                            reached});
            return std::make_tuple(to_matrix(out.X_WT_goal), out.jaw, out.V_WT.v, out.engaged);
          },
          "X_WH"_a, "v_LH"_a, "gripper"_a, "X_WT"_a, "jaw"_a = 0.0, "following"_a = true, "clutch"_a = false,
          "reached"_a = true,
          "One tick: (X_WT_goal (4, 4), jaw [rad], v_WT (3,) [m/s], engaged). reached: the follower could take the "
          "last goal.")
      .def("force_on_hand", &Mapping::force_on_hand, "F_T_W"_a,
           "Force F_H_L (3,) on the hand that renders the tool force F_T_W (3,) [N].")
      .def("hand_position", &Mapping::hand_position, "p_WT"_a,
           "Hand position p_WH (3,) that maps to the tool position p_WT (3,) [m].")
      .def_prop_ro("anchorings", &Mapping::anchor_count,
                   "Number of times that the map was re-anchored at the hand and the tool.");
}

}  // namespace palpate::bindings
