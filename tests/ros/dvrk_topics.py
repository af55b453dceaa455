"""Topics and services of a dVRK 2.4 on ROS 2, from its published interface: name, type, direction, latched.

Directions from the side of the robot: `out` published, `in` subscribed, `srv` service.
"""

from __future__ import annotations

from typing import NamedTuple


class Row(NamedTuple):
    """One topic or service of a component."""

    name: str
    type: str
    direction: str
    latched: bool = False


CP, CV, CF = "geometry_msgs/PoseStamped", "geometry_msgs/TwistStamped", "geometry_msgs/WrenchStamped"
JS, JOY, COMMAND = "sensor_msgs/JointState", "sensor_msgs/Joy", "crtk_msgs/StringStamped"
BOOL, EMPTY, STRING, FLOAT = "std_msgs/Bool", "std_msgs/Empty", "std_msgs/String", "std_msgs/Float64"
MATRIX = "std_msgs/Float64MultiArray"


def out(kind: str, *names: str, latched: bool = False) -> list[Row]:
    """Rows of published topics."""
    return [Row(name, kind, "out", latched) for name in names]


def into(kind: str, *names: str) -> list[Row]:
    """Rows of subscribed topics."""
    return [Row(name, kind, "in") for name in names]


WORDS = out(STRING, "status", "warning", "error")
ARM = [
    *out(JS, "measured_js", "setpoint_js", "gravity_compensation/setpoint_js"),
    *out(CP, "measured_cp", "setpoint_cp", "local/measured_cp", "local/setpoint_cp"),
    *out(CV, "measured_cv", "local/measured_cv"),
    *out(CF, "body/measured_cf", "spatial/measured_cf"),
    *out(MATRIX, "body/jacobian", "spatial/jacobian"),
    *out("crtk_msgs/OperatingState", "operating_state", latched=True),
    *out(STRING, "desired_state", latched=True),
    *out(FLOAT, "trajectory_j/ratio", "trajectory_j/ratio_v", "trajectory_j/ratio_a", latched=True),
    *out(BOOL, "goal_reached"),
    *WORDS,
    *into(COMMAND, "state_command"),
    *into(JS, "servo_jp", "servo_jr", "servo_jf", "move_jp", "move_jr"),
    *into(CP, "servo_cp", "servo_cr", "move_cp", "set_base_frame"),
    *into("crtk_msgs/CartesianState", "servo_cs"),
    *into("crtk_msgs/CartesianImpedance", "servo_ci"),
    *into(CF, "body/servo_cf", "spatial/servo_cf"),
    *into(EMPTY, "free", "hold"),
    *into(BOOL, "use_gravity_compensation", "body/set_cf_orientation_absolute"),
    *into(FLOAT, "trajectory_j/set_ratio", "trajectory_j/set_ratio_v", "trajectory_j/set_ratio_a"),
    Row("forward_kinematics", "crtk_msgs/QueryForwardKinematics", "srv"),
    Row("inverse_kinematics", "crtk_msgs/QueryInverseKinematics", "srv"),
    Row("actuator_to_joint_position", "cisst_msgs/ConvertFloat64Array", "srv"),
]
MTM = [
    *ARM,
    *out(JS, "gripper/measured_js"),
    *out(BOOL, "gripper/closed", "orientation_locked", latched=True),
    *out(EMPTY, "gripper/pinch"),
    *into("geometry_msgs/Quaternion", "lock_orientation"),
    *into(EMPTY, "unlock_orientation"),
]
PSM = [
    *ARM,
    *out(JS, "jaw/measured_js", "jaw/setpoint_js"),
    *into(JS, "jaw/servo_jp", "jaw/move_jp", "jaw/servo_jf"),
    *out(STRING, "tool_type", latched=True),
    *out(EMPTY, "tool_type_request"),
    *out(JOY, "arm_clutch"),
    *into(STRING, "set_tool_type"),
    *into(BOOL, "emulate_adapter_present", "emulate_tool_present"),
]
SYSTEM = [
    *WORDS,
    *into(EMPTY, "power_on", "power_off", "home"),
    *into(FLOAT, "set_volume"),
    *into(MATRIX, "beep"),
    *into(STRING, "string_to_speech"),
    *out(FLOAT, "volume", latched=True),
]
CONSOLE = [
    *WORDS,
    *into(BOOL, "teleop/enable"),
    *out(BOOL, "teleop/enabled", latched=True),
    *into(STRING, "teleop/select", "teleop/unselect"),
    *out(STRING, "teleop/selected", "teleop/unselected", latched=True),
    *into(FLOAT, "teleop/set_scale"),
    *out(FLOAT, "teleop/scale", latched=True),
    *out(JOY, "operator_present", "clutch", "camera", latched=True),
    *into(JOY, "emulate_operator_present", "emulate_clutch", "emulate_camera"),
]
FOOTPEDALS = out(JOY, "clutch", "camera", "coag", "bicoag", "cam_plus", "cam_minus", latched=True)
TELEOP = [
    *WORDS,
    *into(COMMAND, "state_command"),
    *out(STRING, "current_state", "desired_state", latched=True),
    *out(BOOL, "following", latched=True),
    *out(FLOAT, "scale", latched=True),
    *into(FLOAT, "set_scale"),
    *into(BOOL, "lock_rotation", "lock_translation", "set_align_MTM"),
    *out(JOY, "rotation_locked", "translation_locked", latched=True),
    *out(BOOL, "align_mtm", latched=True),
    *out("geometry_msgs/QuaternionStamped", "alignment_offset"),
    *into(CF, "following/mtm/body/servo_cf"),
]
ECM = [
    *ARM,
    *out(STRING, "endoscope_type", latched=True),
    *out(JOY, "arm_clutch"),
    *into(STRING, "set_endoscope_type"),
]
CAMERA_TELEOP = [
    *WORDS,
    *into(COMMAND, "state_command"),
    *into(FLOAT, "set_scale"),
    *out(STRING, "current_state", "desired_state", latched=True),
    *out(BOOL, "following", latched=True),
    *out(FLOAT, "scale", latched=True),
]
SETUP = [
    *WORDS,
    *out(JS, "measured_js"),
    *out(CP, "measured_cp", "local/measured_cp"),
    *out("crtk_msgs/OperatingState", "operating_state", latched=True),
    *into(COMMAND, "state_command"),
    *into(JS, "servo_jp", "move_jp"),
]
FOCUS = [
    *out(BOOL, "locked", "focusing_in", "focusing_out", latched=True),
    *into(BOOL, "lock", "focus_in", "focus_out"),
]
STATISTICS = "cisst_msgs/IntervalStatistics"
SIMULATED = [  # only on the simulated robot: a hand on the handle
    *into(CP, "hand/servo_cp"),
    *into(CF, "hand/servo_cf"),
    *into(FLOAT, "hand/gripper"),
    *into(EMPTY, "hand/free"),
    *out(CF, "hand/measured_cf"),
]
COMPONENTS = {
    "MTMR": MTM + SIMULATED,
    "PSM1": PSM,
    "MTMR_PSM1": TELEOP,
    "console": CONSOLE,
    "footpedals": FOOTPEDALS,
    "system": SYSTEM,
}
WHOLE = {  # components of a robot with both MTMs and an endoscope
    **COMPONENTS,
    "ECM": ECM,
    "MTML_MTMR_ECM": CAMERA_TELEOP,
    "SUJ": into(STRING, "set_reference_arm"),
    "SUJ/PSM1": SETUP,
    "SUJ/ECM": SETUP,
    "endoscope_focus": FOCUS,
    "stats": [
        Row(f"{name}/period_statistics", STATISTICS, "out")
        for name in ("subscribers", "events", "mtmr_arm", "psm1_arm", "publishers_ecm_arm", "mtmr_psm1_setting")
    ],
    "publishers": [Row("period_statistics", STATISTICS, "out")],
}
"""The same for a system with setup joints, a camera's teleoperation and the endoscope's focus motor."""
ROWS = [(f"/{component}/{row.name}", row) for component, rows in COMPONENTS.items() for row in rows]
WHOLE_ROWS = [(f"/{component}/{row.name}", row) for component, rows in WHOLE.items() for row in rows]
