#include "palpate/mapping/mapping.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/tuple.h>

#include <limits>
#include <optional>

#include "bindings.hpp"
#include "convert.hpp"
#include "doc.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {

namespace {

using mapping::Law;
using mapping::Mapping;
using mapping::Options;
using mapping::RecentringOptions;

void bind_mapping_options(nb::module_& m) {
  nb::enum_<Law>(m, "MappingLaw", "Motion of the tool in addition to that of the hand.")
      .value("position", Law::position, "None: the hand moves the tool.")
      .value("rate", Law::rate, "Near the rim of the workspace the tool continues outwards by itself.")
      .value("drift", Law::drift, "While the hand moves, the tool drifts outwards.");
  nb::class_<RecentringOptions>(m, "RecentringOptions", "Motion of the tool in addition to that of the hand.")
      .def(nb::init<>())
      .def_rw("law", &RecentringOptions::law, "The law."_doc)
      .def_rw("workspace", &RecentringOptions::workspace, "Lengths (3,) of the workspace along the axes of L [m]."_doc)
      .def_rw("centre", &RecentringOptions::centre, nb::arg().none(),
              "Centre (3,) of the workspace in L [m]; None: the first position of the handle."_doc)
      .def_rw("rim", &RecentringOptions::rim,
              "rate: distance from the centre at which it begins, 1 at the edge of the workspace [-]."_doc)
      .def_rw("rim_speed", &RecentringOptions::rim_speed, "rate: speed of the tool at the edge, the largest [m/s]."_doc)
      .def_rw("drift", &RecentringOptions::drift,
              "drift: its speed at the edge over the speed of the tool by the hand [-]."_doc);
  nb::class_<Options>(m, "MappingOptions", "Options of the stage `mapping` between hand and tool.")
      .def(nb::init<>())
      .def_rw("scale", &Options::scale,
              "Tool motion per hand motion [-]; the hand feels the stiffness force_scale * scale * K."_doc)
      .def_rw("force_scale", &Options::force_scale, "Force on the hand per force on the tool [-]."_doc)
      .def_rw("align_rate", &Options::align_rate,
              "Rate at which an orientation offset decays [rad/s]; 0: the offset stays."_doc)
      .def_rw("gripper_min", &Options::gripper_min, "Gripper angle that closes the jaw [rad]."_doc)
      .def_rw("gripper_max", &Options::gripper_max, "Gripper angle that opens the jaw [rad]."_doc)
      .def_rw("jaw_min", &Options::jaw_min, "Angle of the closed jaw [rad]."_doc)
      .def_rw("jaw_max", &Options::jaw_max, "Angle of the open jaw [rad]."_doc)
      .def_rw("jaw_start", &Options::jaw_start, "Jaw angle of a simulated follower at the start [rad]."_doc)
      .def_rw("jaw_rate", &Options::jaw_rate, "Rate at which the jaw approaches the gripper angle [rad/s]."_doc)
      .def_rw("ratchet", &Options::ratchet,
              "True: on engaging, the jaw does not open before the pinch has closed to its angle."_doc)
      .def_rw("align_tolerance", &Options::align_tolerance,
              "Orientation error up to which the handle counts as aligned; 0: any [rad]."_doc)
      .def_rw("recentring", &Options::recentring, "Motion of the tool in addition to that of the hand."_doc);
}

void bind_mapping_stage(nb::module_& m) {
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
             bool following, bool clutch, bool reached, double t, const Vec3& p_LH, const Vec3& F_T_W,
             const Vec3& correction_W, bool lock_rotation, bool lock_translation, const Vec3& t_T_W) {
            const ToolGoal out = self.step({to_pose(X_WH, "X_WH"),
                                            {v_LH, Vec3::Zero()},
                                            gripper,
                                            to_pose(X_WT, "X_WT"),
                                            jaw,
                                            following,
                                            clutch,
                                            reached,
                                            t,
                                            p_LH,
                                            F_T_W,
                                            correction_W,
                                            lock_rotation,
                                            lock_translation,
                                            false,
                                            t_T_W});
            return std::make_tuple(to_matrix(out.X_WT_goal), out.jaw, out.V_WT.v, out.engaged);
          },
          "X_WH"_a, "v_LH"_a, "gripper"_a, "X_WT"_a, "jaw"_a = 0.0, "following"_a = true, "clutch"_a = false,
          "reached"_a = true, "t"_a = std::numeric_limits<double>::quiet_NaN(), "p_LH"_a = Vec3(Vec3::Zero()),
          "F_T_W"_a = Vec3(Vec3::Zero()), "correction_W"_a = Vec3(Vec3::Zero()), "lock_rotation"_a = false,
          "lock_translation"_a = false, "t_T_W"_a = Vec3(Vec3::Zero()),
          "One tick: (X_WT_goal (4, 4), jaw [rad], v_WT (3,) [m/s], engaged). reached: the follower could take the "
          "last goal. t: time, NaN: one period later [s]. p_LH (3,): handle in L [m]; F_T_W (3,): force on the tool "
          "[N]; t_T_W (3,): moment on it [N m]; correction_W (3,): of the last goal by hard fixtures [m]. Locks: the "
          "tool keeps its orientation, its "
          "position.")
      .def("force_on_hand", &Mapping::force_on_hand, "F_T_W"_a,
           "Force F_H_L (3,) on the hand that renders the tool force F_T_W (3,) [N].")
      .def("hand_position", &Mapping::hand_position, "p_WT"_a,
           "Hand position p_WH (3,) that maps to the tool position p_WT (3,) [m].")
      .def_prop_ro("released", &Mapping::released, "Energy that the recentring released in the last step [J].")
      .def_prop_ro("anchorings", &Mapping::anchor_count,
                   "Number of times that the map was re-anchored at the hand and the tool.");
}

}  // namespace

void bind_mapping(nb::module_& m) {
  bind_mapping_options(m);
  bind_mapping_stage(m);
}

}  // namespace palpate::bindings
